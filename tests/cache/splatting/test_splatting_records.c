/* The records of whole pictures, looked at one by one: the picture is their sum over all pixels, none lights
 * another step of the stairs, none made inside of something reaches out of it, and none is made twice. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "unit_test.h"
#include "cache/splatting/record_weight.h"
#include "cache/splatting/state.h"
#include "rendering.h"
#include "scene/scene.h"
#include "trace_scenes.h"

/* ---- the method, with its state in sight ---- */

typedef struct {
    sl_splat_state *state;
    sl_image *image;
} drawn;

static drawn draw(const sl_scene *scene, sl_settings settings) {
    sl_transport transport;
    drawn d = {.image = NULL};
    void *state;
    settings.threads = 2;
    settings.filter = SL_FILTER_CENTRE;
    sl_splatting_method.complete(&settings);
    sl_splatting_method.transport(&settings, &transport);
    assert_int_equal(sl_splatting_method.create(scene, &settings, &transport, &state, NULL), SL_OK);
    for (sl_progress progress = {0}; !progress.done;)
        assert_int_equal(sl_splatting_method.update(state, &progress, NULL), SL_OK);
    assert_int_equal(sl_splatting_method.resolve(state, &d.image, NULL), SL_OK);
    d.state = state;
    return d;
}

static void drawn_free(drawn *d) {
    sl_image_destroy(d->image);
    sl_splatting_method.destroy(d->state);
}

/* ---- the picture is the sum of the records ---- */

/* Algorithm 1 for one pixel and all records in order: no rectangles, no tiles. */
static void add_up(const sl_record_cache *cache, size_t pixel, float sum[4]) {
    const sl_splat_receivers *p = &cache->pass.receivers;
    memset(sum, 0, 4 * sizeof *sum);
    for (size_t k = 0; k < cache->list.count; k++) {
        const sl_record *record = &cache->list.records[k];
        float w = sl_record_weight(&cache->pass, record, pixel);
        if (!(w > 0.0f)) continue;
        const sl_record_terms terms = sl_record_terms_of(record, &cache->pass.weights);
        const sl_record_offsets o =
            sl_record_offsets_at(&terms, p->position_x[pixel], p->position_y[pixel], p->position_z[pixel],
                                 p->normal_x[pixel], p->normal_y[pixel], p->normal_z[pixel]);
        for (int c = 0; c < 3; c++) sum[c] += w * sl_record_extrapolate(&terms, c, &o, sl_record_turn(&o));
        sum[3] += w;
    }
}

static void assert_sum_of_records(const drawn *d, const char *what) {
    const sl_splat_state *s = d->state;
    const float *const planes[4] = {s->splats.r, s->splats.g, s->splats.b, s->splats.weight};
    size_t receivers = 0;
    for (int class = 0; class < SL_RECEIVER_CLASSES; class++) {
        const sl_record_cache *cache = &s->cache[class];
        for (size_t i = 0; cache->receivers && i < sl_splat_pixels(s); i++) {
            float sum[4];
            if (!cache->receives[i]) continue;
            add_up(cache, i, sum);
            receivers++;
            for (int c = 0; c < 4; c++) {
                if (sum[c] != planes[c][i])
                    fail_msg("%s: pixel %zu, plane %d: %.9g, the records give %.9g", what, i, c,
                             (double)planes[c][i], (double)sum[c]);
            }
            assert_true(s->owned[i] || sum[3] >= cache->pass.covered_weight);
        }
    }
    assert_true(receivers > sl_splat_pixels(s) / 4);
}

static void every_pixel_is_the_sum_of_all_records_bit_for_bit(void **state) {
    static const char *const scenes[] = {"scenes/cornell-glossy.json", "scenes/two-rooms.json"};
    for (int i = 0; i < 4; i++) {
        sl_scene *scene = load_scene(scenes[i / 2]);
        sl_settings settings = small_settings("splatting", 65, 47); /* no whole tiles */
        settings.gather_size = 12;
        settings.metric = i % 2 ? SL_METRIC_HARMONIC : SL_METRIC_HESSIAN;
        settings.accuracy = 0.4;
        drawn d = draw(scene, settings);
        assert_sum_of_records(&d, scenes[i / 2]);
        drawn_free(&d);
        sl_scene_destroy(scene);
    }
}

/* ---- stairs ---- */

enum { STEPS = 5 };

static sl_scene *stairs(void) {
    char obj[4096];
    int n = snprintf(obj, sizeof obj, "v -1 0 -3\nv 1 0 -3\nv 1 3 -3\nv -1 3 -3\nf 1 2 3 4\n");
    /* tread i at height 0.2 i, from z = 1 - 0.4 i backwards, and the riser behind it */
    for (int i = 0; i < STEPS; i++) {
        double y = 0.2 * i, front = 1.0 - 0.4 * i, back = i + 1 < STEPS ? front - 0.4 : -3.0;
        n += snprintf(obj + n, sizeof obj - (size_t)n,
                      "v -1 %g %g\nv 1 %g %g\nv 1 %g %g\nv -1 %g %g\nf -4 -3 -2 -1\n", y, front, y, front, y,
                      back, y, back);
        if (i + 1 < STEPS)
            n += snprintf(obj + n, sizeof obj - (size_t)n,
                          "v -1 %g %g\nv 1 %g %g\nv 1 %g %g\nv -1 %g %g\nf -4 -3 -2 -1\n", y, back, y, back,
                          y + 0.2, back, y + 0.2, back);
    }
    return scene_from_text(
        "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\"}],\n"
        " \"lights\": [{\"type\": \"point\", \"position\": [0.3, 2.5, -1], \"intensity\": 10}],\n"
        " \"camera\": {\"eye\": [0.2, 2.6, 2.6], \"target\": [0, 0.3, -0.3], \"fov_deg\": 45}}",
        obj);
}

/* Of records and pixels on treads of different height, how many are near enough; and that no such record
 * counts. */
static size_t assert_steps_apart(const sl_splat_state *s, int metric) {
    const sl_record_cache *cache = &s->cache[SL_RECEIVES_IRRADIANCE];
    const sl_splat_receivers *p = &cache->pass.receivers;
    const float a = cache->pass.weights.accuracy;
    size_t near = 0;
    for (size_t k = 0; k < cache->list.count; k++) {
        const sl_record *r = &cache->list.records[k];
        for (size_t i = 0; r->normal.y > 0.9f && i < sl_splat_pixels(s); i++) {
            if (!p->receives[i] || !(p->normal_y[i] > 0.9f) || fabsf(p->position_y[i] - r->position.y) < 0.1f)
                continue;
            sl_vec3 delta = sl_sub(sl_v3(p->position_x[i], p->position_y[i], p->position_z[i]), r->position);
            near += sl_length(delta) < a * r->radius;
            if (sl_record_weight(&cache->pass, r, i) > 0.0f)
                fail_msg("metric %d: a record at %g %g %g counts at %g %g %g", metric, (double)r->position.x,
                         (double)r->position.y, (double)r->position.z, (double)p->position_x[i],
                         (double)p->position_y[i], (double)p->position_z[i]);
        }
    }
    return near;
}

static void no_record_of_a_tread_counts_on_another(void **state) {
    const sl_radius_metric metrics[] = {SL_METRIC_HARMONIC, SL_METRIC_HESSIAN};
    sl_scene *scene = stairs();
    size_t near = 0;
    for (int i = 0; i < 4; i++) {
        sl_settings settings = small_settings("splatting", 64, 64);
        settings.gather_size = 16;
        settings.metric = metrics[i / 2];
        settings.accuracy = i % 2 ? 0.8 : 0.3;
        drawn d = draw(scene, settings);
        near += assert_steps_apart(d.state, (int)metrics[i / 2]);
        drawn_free(&d);
    }
    print_message("%zu times a record is near enough to another tread\n", near);
    assert_true(near > 2000);
    sl_scene_destroy(scene);
}

/* ---- inside of things ---- */

/* A lit room, and a closed box of half the size given about a point of its floor. */
static sl_scene *room_with_box(double half) {
    char obj[2048];
    const double x = 0.3, y = -1.0, z = 0.2;
    int n = snprintf(obj, sizeof obj,
                     "v -1 -1 -1\nv 1 -1 -1\nv 1 -1 1\nv -1 -1 1\nv -1 1 -1\nv 1 1 -1\nv 1 1 1\nv -1 1 1\n"
                     "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 4 1 5 8\nf 2 3 7 6\n");
    for (int i = 0; half > 0.0 && i < 8; i++)
        n += snprintf(obj + n, sizeof obj - (size_t)n, "v %.9g %.9g %.9g\n", x + (i % 2 ? half : -half),
                      y + (i / 2 % 2 ? half : -half), z + (i / 4 ? half : -half));
    if (half > 0.0)
        snprintf(obj + n, sizeof obj - (size_t)n,
                 "f 9 11 12 10\nf 13 14 16 15\nf 9 10 14 13\nf 11 15 16 12\nf 9 13 15 11\nf 10 12 16 14\n");
    return scene_from_text(
        "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\"}],\n"
        " \"lights\": [{\"type\": \"point\", \"position\": [0, 0.5, 0], \"intensity\": 1}],\n"
        " \"camera\": {\"eye\": [0, 0, 0.9], \"target\": [0, -1, 0], \"fov_deg\": 60}}",
        obj);
}

/* The floor's triangle that holds the point. */
static uint32_t floor_triangle(const sl_scene *scene, sl_vec3 p) {
    sl_tracer *tracer = tracer_of(scene);
    sl_counters counters = {{0}};
    sl_hit16 hit;
    sl_ray16 ray;
    sl_ray16_set(&ray, 0, sl_v3(p.x, 0.5f * p.y, p.z), sl_v3(0, -1, 0), 0.0f, INFINITY, SL_NO_INDEX);
    sl_trace(tracer, &ray, 1, false, &hit, &counters);
    while (hit.t[0] < -0.5f * p.y * 0.9999999f) { /* past the box */
        ray.skip[0] = hit.triangle[0], ray.near[0] = hit.t[0];
        sl_trace(tracer, &ray, 1, false, &hit, &counters);
    }
    sl_tracer_destroy(tracer);
    return hit.triangle[0];
}

/* The records of a picture of one pixel, which shows that point: the first, and how many they are after so
 * many visits. */
static sl_record records_on_floor(double half, float footprint, int visits, size_t *count) {
    const sl_vec3 p = {0.3f, -1.0f, 0.2f}, up = {0, 1, 0};
    sl_scene *scene = room_with_box(half);
    sl_tracer *tracer = tracer_of(scene);
    sl_gathers gathers;
    sl_gbuffer *g;
    sl_counters counters = {{0}};
    sl_gather_settings settings = sl_gather_defaults();
    settings.kind = SL_GATHER_RAYS;
    settings.size = 32;
    assert_int_equal(sl_gathers_create(scene, NULL, tracer, &settings, 1, &gathers, NULL), SL_OK);
    assert_int_equal(sl_gbuffer_create(1, 1, &g, NULL), SL_OK);
    g->position_x[0] = p.x, g->position_y[0] = p.y, g->position_z[0] = p.z;
    g->normal_x[0] = g->geometric_x[0] = up.x, g->normal_y[0] = g->geometric_y[0] = up.y,
    g->normal_z[0] = g->geometric_z[0] = up.z;
    g->id[0] = floor_triangle(scene, p);
    uint32_t receives = 1;
    uint8_t owned = 0;
    float coverage = 0.0f;
    sl_record_pass pass = {.scene = scene,
                           .tracer = tracer,
                           .gathers = &gathers,
                           .gbuffer = g,
                           .receivers = {1, 1, g->position_x, g->position_y, g->position_z, g->normal_x,
                                         g->normal_y, g->normal_z, &receives},
                           .weights = {0.3f, 1.0f / 0.3f, 1e-5f * scene->diagonal},
                           .covered_weight = 1.0f / (9.0f * 0.3f),
                           .radii = {.accuracy = 0.3,
                                     .minimum_pixels = 1.5,
                                     .maximum_radius = 0.1 * (double)scene->diagonal,
                                     .guard = true,
                                     .gather = SL_GATHER_RAYS,
                                     .plane_tangent = 2.7},
                           .isa = sl_isa_best(),
                           .camera = &scene->camera,
                           .near_distance = 1e-5f * scene->diagonal,
                           .footprint_per_depth = footprint,
                           .coverage = &coverage,
                           .owned = &owned,
                           .threads = 1};
    sl_record_list list = {0};
    for (int i = 0; i < visits; i++) {
        sl_traversal traversal;
        sl_traversal_start(&traversal, SL_ORDER_LINEAR, 1, 1);
        while (traversal.stride) {
            size_t pixels[SL_BATCH_MAX], found = sl_traversal_next(&traversal, &pass, pixels);
            if (!found) continue;
            assert_int_equal(sl_traversal_gather(&traversal, &pass, pixels, found, &list, &counters, NULL),
                             SL_OK);
        }
    }
    assert_true(list.count > 0);
    *count = list.count;
    sl_record record = list.records[0];
    sl_record_list_free(&list);
    sl_gbuffer_destroy(g);
    sl_gathers_destroy(&gathers);
    sl_tracer_destroy(tracer);
    sl_scene_destroy(scene);
    return record;
}

/* The eye stands 1e-5 of the diagonal off the surface, 3.5e-5 here; inside of a small box it tries again ten
 * times as far out. Inside of a larger one nothing is known of what is around: the record reaches as little
 * as it may, and only what it sees. */
static void a_record_inside_of_something_looks_out_of_it_or_keeps_to_itself(void **state) {
    const float footprint = 0.001f;
    size_t count;
    sl_record free_one = records_on_floor(0.0, footprint, 1, &count),
              small = records_on_floor(2e-4, footprint, 1, &count);
    sl_record larger = records_on_floor(1e-3, footprint, 1, &count);
    assert_true(free_one.irradiance.g > 0.01f && free_one.radius > 2.0f * free_one.minimum_radius);
    print_message("E %.4f; in a small box %.4f, in a larger one %.4f\n", (double)free_one.irradiance.g,
                  (double)small.irradiance.g, (double)larger.irradiance.g);
    assert_true(fabsf(small.irradiance.g / free_one.irradiance.g - 1.0f) < 0.02f);
    assert_true(small.radius > 0.9f * free_one.radius);
    assert_true(larger.irradiance.g < 0.01f * free_one.irradiance.g);
    assert_true(larger.radius == larger.minimum_radius);
}

/* A record may be refused by its own pixel: of one without any reach D is no number. The pixel counts as
 * covered all the same, or every visit would make it another record. */
static void a_pixel_gets_one_record_even_where_that_does_not_cover_it(void **state) {
    size_t count;
    sl_record record = records_on_floor(1e-3, 0.0f, 3, &count);
    assert_true(record.radius == 0.0f);
    assert_int_equal(count, 1);
}

/* A frame's budget cuts batches to any size. */
static void a_batch_grows_to_the_room_that_there_is_and_not_beyond(void **state) {
    for (size_t size = 1; size <= SL_BATCH_MAX; size++) {
        for (size_t wasted = 0; wasted <= size; wasted++)
            assert_in_range(sl_record_batch_size(size, size, size - wasted), 1, SL_BATCH_MAX);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_batch_grows_to_the_room_that_there_is_and_not_beyond),
        cmocka_unit_test(every_pixel_is_the_sum_of_all_records_bit_for_bit),
        cmocka_unit_test(no_record_of_a_tread_counts_on_another),
        cmocka_unit_test(a_record_inside_of_something_looks_out_of_it_or_keeps_to_itself),
        cmocka_unit_test(a_pixel_gets_one_record_even_where_that_does_not_cover_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
