/* More than one bounce: closed forms first, then the reference path tracer. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "unit_test.h"
#include "base/math.h"
#include "base/random.h"
#include "cache/bounces/second_level.h"
#include "gather_world.h"
#include "matched.h"
#include "rendering.h"

static sl_gather_settings ray_gather(int size) {
    sl_gather_settings s = sl_gather_defaults();
    s.kind = SL_GATHER_RAYS;
    s.size = size;
    return s;
}

typedef struct {
    sl_second_cache *cache;
    gatherer gatherer;
    sl_second_report report;
} bouncer;

static void look_from(world *w, sl_vec3 eye, sl_vec3 target) {
    assert_true(sl_camera_look_at(&w->scene->camera, eye, target, sl_v3(0, 1, 0), 1.2f));
}

/* A visible gather of 40 x 40 rays that knows of `bounces`. */
static bouncer bouncer_new(world *w, uint32_t bounces, unsigned threads) {
    bouncer b = {0};
    sl_error error;
    sl_gather_settings visible = ray_gather(40);
    sl_second_settings settings = sl_second_settings_for(&visible, 0.3, bounces);
    settings.threads = threads;
    if (sl_second_cache_create(w->scene, w->tracer, &settings, &b.cache, &w->counters, &error) != SL_OK)
        fail_msg("%s", error.message);
    b.report = sl_second_cache_report(b.cache);
    visible.second = sl_second_cache_light(b.cache);
    b.gatherer = gatherer_new(w, &visible);
    return b;
}

static void bouncer_free(bouncer *b) {
    gatherer_free(&b->gatherer);
    sl_second_cache_destroy(b->cache);
}

static sl_irradiance irradiance_at(bouncer *b, const sl_gather_point *point) {
    sl_irradiance e;
    sl_gather_irradiance(b->gatherer.gather, point, b->gatherer.scratch, &e, b->gatherer.counters);
    return e;
}

/* ---- where records lie ---- */

static sl_second_cache *cache_of(world *w, double accuracy, uint32_t bounces) {
    const sl_gather_settings visible = ray_gather(40);
    sl_second_settings settings = sl_second_settings_for(&visible, accuracy, bounces);
    sl_second_cache *cache;
    settings.gather.size = 4;
    settings.threads = 2;
    assert_int_equal(sl_second_cache_create(w->scene, w->tracer, &settings, &cache, &w->counters, NULL),
                     SL_OK);
    return cache;
}

static world *room_of_posts(int posts) {
    world *w = world_new();
    const uint32_t wall = world_material(w, sl_grey(0.8f), sl_grey(0.0f));
    const uint32_t all[6] = {wall, wall, wall, wall, wall, wall};
    world_box(w, sl_v3(-1, -1, -1), sl_v3(1, 1, 1), true, all);
    for (int i = 0; i < posts * posts; i++) {
        const float x = -0.9f + 1.8f * (float)(i % posts) / (float)posts,
                    z = -0.9f + 1.8f * (float)(i / posts) / (float)posts;
        world_box(w, sl_v3(x, -1.0f, z), sl_v3(x + 0.04f, -0.2f, z + 0.04f), false, all);
    }
    world_build(w);
    look_from(w, sl_v3(0.0f, 0.6f, 0.95f), sl_v3(0.0f, -0.6f, 0.0f));
    return w;
}

static void where_light_bounces_often_between_small_things_records_of_fine_pictures_are_finer(void **state) {
    static const struct {
        int posts;
        double accuracy;
        uint32_t bounces;
        bool finer;
    } of[] = {{16, 0.15, 12, true}, {16, 0.15, 10, false}, {16, 0.3, 12, false}, {1, 0.15, 12, false}};
    for (size_t i = 0; i < sizeof of / sizeof *of; i++) {
        world *w = room_of_posts(of[i].posts);
        sl_second_cache *cache = cache_of(w, of[i].accuracy, of[i].bounces);
        const double reach = (double)sl_second_cache_reach(cache), as_a_rule =
            0.014 * sl_scene_central_diagonal(w->scene);
        const size_t records = sl_second_cache_report(cache).records;
        const float missed = sl_second_cache_report(cache).missed;
        print_message("%zu records, at least %.4f apart; %.4f missed\n", records, reach, (double)missed);
        assert_true(of[i].finer ? reach < 0.5 * as_a_rule : reach > 0.99 * as_a_rule);
        assert_true(of[i].finer ? records > 8000 : records < 6000);
        assert_true(!of[i].finer || missed < 0.002f);
        assert_true(of[i].posts > 1 || missed < 0.001f); /* records are few enough to be everywhere */
        sl_second_cache_destroy(cache);
        world_free(w);
    }
}

/* ---- the way in ---- */

static void shine_evenly(const void *context, const sl_second_points *points, float *r, float *g, float *b,
                         bool *missed, sl_counters *counters) {
    const float *e = context;
    for (size_t i = 0; i < points->count; i++) {
        if (missed) missed[i] = i % 2;
        r[i] += e[0];
        g[i] += e[1];
        b[i] += e[2];
    }
}

/* In a closed room whose walls of albedo rho all receive E, every point receives rho E; rho^2 E if rays that
 * go on from what is near, or has no light of its own, ask for it. */
static void what_the_hits_receive_is_reflected(void **state) {
    const float e[3] = {1.0f, 2.0f, 4.0f};
    const sl_second_light light = {e, shine_evenly};
    world *w = world_new();
    uint32_t wall = world_material(w, (sl_rgb){0.5f, 0.25f, 0.125f}, sl_grey(0.0f));
    world_box(w, sl_v3(-1, -1, -1), sl_v3(1, 1, 1), true, (uint32_t[6]){wall, wall, wall, wall, wall, wall});
    world_build(w);
    const sl_gather_kind kinds[] = {SL_GATHER_RAYS, SL_GATHER_HEMICUBE, SL_GATHER_PLANE};
    const float reach[] = {0.0f, 1e-6f, 10.0f}, albedo[] = {0.5f, 0.25f, 0.125f};
    const double by_rays[] = {0.0, 0.5, 1.0};
    for (int k = 0; k < 9; k++) {
        sl_gather_settings settings = ray_gather(32);
        settings.kind = kinds[k / 3];
        settings.second = &light;
        settings.onward_reach = reach[k % 3];
        sl_irradiance got = gather_once(w, &settings, sl_v3(0.1f, -1.0f, 0.2f), sl_v3(0, 1, 0));
        const float found[3] = {got.value.r, got.value.g, got.value.b};
        for (int c = 0; c < 3; c++) {
            const double expected = 0.5 * (1.0 - by_rays[k % 3] * (1.0 - (double)albedo[c]));
            assert_true(fabs((double)found[c] - expected) < (k % 3 ? 0.03 * expected : 1e-4));
        }
    }
    world_free(w);
}

/* ---- closed forms ---- */

static world *furnace(float albedo, float radiance) {
    world *w = world_new();
    uint32_t wall = world_material(w, sl_grey(albedo), sl_grey(radiance));
    world_box(w, sl_v3(-1, -1, -1), sl_v3(1, 1, 1), true, (uint32_t[6]){wall, wall, wall, wall, wall, wall});
    world_build(w);
    look_from(w, sl_v3(0.8f, 0.5f, 0.9f), sl_v3(-0.2f, -0.1f, 0.0f));
    return w;
}

static world *integrating_sphere(float albedo) {
    world *w = world_new();
    uint32_t wall = world_material(w, sl_grey(albedo), sl_grey(0.0f));
    world_sphere(w, 1.0f, 48, &wall, 1);
    world_point_light(w, sl_v3(0.3f, 0.2f, -0.4f), 1.0f); /* <E_direct> = 1 */
    world_build(w);
    look_from(w, sl_v3(0.0f, 0.1f, 0.5f), sl_v3(0, 0, -1));
    return w;
}

static void light_is_known_at_the_very_place_of_a_record(void **state) {
    world *w = integrating_sphere(0.5f);
    bouncer b = bouncer_new(w, 3, 1);
    const sl_second_light *light = sl_second_cache_light(b.cache);
    for (size_t i = 0; i < b.cache->list.count; i++) {
        const sl_gather_point *p = &b.cache->list.points[i];
        const sl_second_points at = {1, &p->triangle, &p->position.x, &p->position.y, &p->position.z,
                                     &p->normal.x, &p->normal.y, &p->normal.z};
        float e[3] = {0.0f, 0.0f, 0.0f};
        light->irradiance(light->context, &at, &e[0], &e[1], &e[2], NULL, &w->counters);
        assert_true(e[0] > 0.5f && e[0] < 1.0f);
    }
    bouncer_free(&b);
    world_free(w);
}

/* Everything emits L_e and reflects rho: b bounces add pi L_e (rho + ... + rho^b) to what arrives straight.
 */
static void the_furnace_sums_the_series(void **state) {
    const double albedo = 0.6;
    const uint32_t bounces[] = {2, 3, 5};
    world *w = furnace((float)albedo, 1.0f);
    for (int i = 0; i < 3; i++) {
        bouncer b = bouncer_new(w, bounces[i], 2);
        double wanted = 0.0, power = 1.0, sum = 0.0, worst = 0.0;
        for (uint32_t n = 0; n < bounces[i]; n++) wanted += SL_PI * (power *= albedo);
        assert_int_equal(b.report.bounces, bounces[i] - 1);
        for (uint64_t n = 0; n < 40; n++) {
            sl_gather_point point = world_surface_point(w, n);
            double e = (double)irradiance_at(&b, &point).value.g / wanted - 1.0;
            sum += e / 40;
            worst = fabs(e) > worst ? fabs(e) : worst;
        }
        print_message("furnace, %u bounces: %+.4f on average, %.4f at most\n", bounces[i], sum, worst);
        assert_true(fabs(sum) < 0.01);
        assert_true(worst < 0.04);
        bouncer_free(&b);
    }
    world_free(w);
}

/* Inside a sphere of albedo rho every bounce is even: E_b = rho^b <E_direct>, whatever the light's place. */
static void the_integrating_sphere_dims_by_its_albedo(void **state) {
    const double albedo = 0.7;
    world *w = integrating_sphere((float)albedo);
    const uint32_t bounces[] = {2, 4};
    for (int i = 0; i < 2; i++) {
        bouncer b = bouncer_new(w, bounces[i], 2);
        double wanted = 0.0, power = 1.0, sum = 0.0, worst = 0.0;
        for (uint32_t n = 0; n < bounces[i]; n++) wanted += power *= albedo;
        for (uint64_t n = 0; n < 40; n++) {
            sl_gather_point point = world_surface_point(w, n);
            double e = (double)irradiance_at(&b, &point).value.g / wanted - 1.0;
            sum += e / 40;
            worst = fabs(e) > worst ? fabs(e) : worst;
        }
        print_message("sphere, %u bounces: %+.4f on average, %.4f at most, %zu records\n", bounces[i], sum,
                      worst, b.report.records);
        assert_true(fabs(sum) < 0.004);
        assert_true(worst < 0.02);
        bouncer_free(&b);
    }
    world_free(w);
}

/* More bounces than matter: the iteration ends by itself, with all the light: E = <E_direct> rho / (1 - rho).
 */
static void bounces_that_change_nothing_are_left_out(void **state) {
    const double albedo = 0.4, wanted = albedo / (1.0 - albedo);
    world *w = integrating_sphere((float)albedo);
    bouncer b = bouncer_new(w, 64, 2);
    assert_true(b.report.converged);
    assert_in_range(b.report.bounces, 8, 14); /* 0.4^10 = 1e-4 */
    double sum = 0.0;
    for (uint64_t n = 0; n < 10; n++) {
        sl_gather_point point = world_surface_point(w, n);
        sum += 0.1 * (double)irradiance_at(&b, &point).value.g / wanted;
    }
    assert_true(fabs(sum - 1.0) < 0.005);
    bouncer_free(&b);
    world_free(w);
}

/* What records send to each other by the links that their second gather found is what they find when they
 * gather the bounce before anew. */
static void a_bounce_by_links_is_what_gathering_anew_finds(void **state) {
    world *w = world_new();
    const uint32_t red = world_material(w, (sl_rgb){0.7f, 0.1f, 0.1f}, sl_grey(0.0f)),
                   grey = world_material(w, sl_grey(0.7f), sl_grey(0.0f));
    world_box(w, sl_v3(-1, -1, -1), sl_v3(1, 1, 1), true, (uint32_t[6]){red, grey, grey, grey, grey, grey});
    world_box(w, sl_v3(-0.4f, -1, -0.4f), sl_v3(0.2f, 0, 0.2f), false,
              (uint32_t[6]){grey, grey, grey, grey, grey, grey});
    world_point_light(w, sl_v3(0.3f, 0.8f, 0.5f), 1.0f);
    world_build(w);
    look_from(w, sl_v3(0.8f, 0.5f, 0.9f), sl_v3(-0.2f, -0.1f, 0.0f));
    bouncer before = bouncer_new(w, 4, 2), after = bouncer_new(w, 5, 2);
    sl_gather_settings again = before.cache->settings.gather;
    again.second = sl_second_cache_light(before.cache);
    gatherer anew = gatherer_new(w, &again);
    const sl_second_list *list = &after.cache->list;
    double error = 0.0, sum = 0.0, bias[3] = {0.0, 0.0, 0.0};
    for (size_t i = 0; i < list->count; i++) {
        sl_irradiance e;
        sl_gather_irradiance(anew.gather, &list->points[i], anew.scratch, &e, anew.counters);
        const sl_rgb is = list->records[i].irradiance;
        const double d[3] = {(double)(is.r - e.value.r), (double)(is.g - e.value.g),
                             (double)(is.b - e.value.b)};
        for (int c = 0; c < 3; c++) bias[c] += d[c];
        error += d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
        sum += (double)(e.value.r + e.value.g + e.value.b);
    }
    error = sqrt(error * 3.0 * (double)list->count) / sum;
    print_message("%zu records: %.4f of the mean, bias %+.4f %+.4f %+.4f\n", list->count, error,
                  3.0 * bias[0] / sum, 3.0 * bias[1] / sum, 3.0 * bias[2] / sum);
    assert_true(list->count > 100);
    assert_true(error < 0.02);
    for (int c = 0; c < 3; c++) assert_true(fabs(3.0 * bias[c] / sum) < 0.003);
    gatherer_free(&anew);
    bouncer_free(&before);
    bouncer_free(&after);
    world_free(w);
}

/* ---- the path tracer ---- */

static void the_cornell_box_with_four_bounces_is_what_the_path_tracer_says(void **state) {
    sl_scene *scene = load_scene("scenes/cornell.json");
    sl_settings settings = small_settings("splatting", 64, 64);
    settings.quality = SL_QUALITY_NORMAL;
    settings.bounces = 4;
    sl_counters counters;
    const sl_comparison c = against_path_tracer(scene, &settings, 400, &counters);
    assert_true(c.rel_mse - c.rel_mse_noise < 0.03 * 0.03);
    assert_true(fabs(c.bias) < 0.005);
    assert_true(counters.value[SL_COUNT_SECOND_LEVEL_RECORDS] > 0);
    sl_scene_destroy(scene);
}

/* A camera that moves keeps the second-level records; a light that moves does not. */
/* A surface that sees the sky receives its light once: from the gathers that it escapes, or from samples
 * where a gather hits. */
static void the_light_of_a_sky_bounces_as_the_path_tracer_says(void **state) {
    static const char text[] = "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\"}], \"environment\": "
                               "{\"radiance\": [1, 1, 1]}, \"materials\": {\"m\": {\"diffuse\": 0.7}}, "
                               "\"camera\": {\"eye\": [0, 1, 4], \"target\": [0, 1, 0], \"fov_deg\": 40}}";
    /* a room of 2 x 2 x 2 without its front */
    static const char obj[] =
        "v -1 0 1\nv 1 0 1\nv 1 0 -1\nv -1 0 -1\nv -1 2 1\nv 1 2 1\nv 1 2 -1\nv -1 2 -1\n"
        "usemtl m\nf 1 2 3 4\nf 8 7 6 5\nf 4 3 7 8\nf 1 4 8 5\nf 2 6 7 3\n";
    sl_scene *scene = scene_from_text(text, obj);
    for (uint32_t bounces = 1; bounces <= 4; bounces += 3) {
        sl_settings settings = small_settings("splatting", 24, 24), path = small_settings("path", 24, 24);
        settings.bounces = path.bounces = bounces;
        path.transport = "matched:splatting";
        path.filter = SL_FILTER_CENTRE;
        path.spp = 128;
        sl_image *image = render(scene, &settings, NULL), *reference = render(scene, &path, NULL);
        sl_comparison c = comparison_of(image, reference);
        print_message("%u bounces: bias %.4f\n", bounces, c.bias);
        assert_true(fabs(c.bias) < 0.01);
        destroy_pictures(image, reference);
    }
    sl_scene_destroy(scene);
}

static void second_level_records_stay_as_long_as_the_light_does(void **state) {
    const float eye[3] = {320, 300, -300}, target[3] = {60, 100, 300}, up[3] = {0, 1, 0};
    sl_scene *scene = load_scene("scenes/cornell.json");
    sl_settings settings = small_settings("splatting", 24, 24);
    settings.bounces = 2;
    sl_error error;
    sl_progress progress = {0};
    uint64_t made[3];
    sl_method *method = created_method(scene, &settings);
    for (int i = 0; i < 3; i++) {
        if (i == 1) assert_int_equal(sl_scene_set_camera(scene, eye, target, up, 0.7f, &error), SL_OK);
        if (i > 0)
            assert_int_equal(sl_method_edit(method, i == 1 ? SL_CHANGED_CAMERA : SL_CHANGED_LIGHTS, &error),
                             SL_OK);
        do assert_int_equal(sl_method_update(method, &progress, &error), SL_OK);
        while (!progress.done);
        made[i] = sl_method_counters(method)->value[SL_COUNT_SECOND_LEVEL_RECORDS];
    }
    assert_true(made[0] > 0);
    assert_int_equal(made[1], made[0]);
    assert_true(made[2] > made[1]);
    destroy_method(method, scene);
}

/* Rooms of that many metres at x = 0 and 5, without a door between them, each with its light. */
static world *two_rooms(float one, float other, float other_light) {
    world *w = world_new();
    uint32_t wall = world_material(w, sl_grey(0.6f), sl_grey(0.0f));
    const uint32_t walls[6] = {wall, wall, wall, wall, wall, wall};
    world_box(w, sl_v3(0, 0, 0), sl_v3(one, one, one), true, walls);
    world_box(w, sl_v3(5, 0, 0), sl_v3(5 + other, other, other), true, walls);
    world_point_light(w, sl_v3(0.5f * one, 0.75f * one, 0.5f * one), 3.0f);
    world_point_light(w, sl_v3(5 + 0.5f * other, 0.75f * other, 0.5f * other), other_light);
    world_build(w);
    return w;
}

/* Seen from one, the other has no second-level records. */
static void a_camera_that_goes_elsewhere_brings_second_level_records_there(void **state) {
    world *w = two_rooms(2.0f, 2.0f, 3.0f);
    const sl_vec3 there = sl_v3(5, 0, 0);
    const sl_gather_point here = {sl_v3(0.7f, 0, 0.8f), sl_v3(0, 1, 0), sl_v3(0, 1, 0), SL_NO_INDEX, 3};
    sl_gather_point far_off = here;
    far_off.position = sl_add(here.position, there);
    sl_error error;
    look_from(w, sl_v3(1.9f, 1.2f, 1.9f), sl_v3(1, 1, 1));
    bouncer b = bouncer_new(w, 3, 2);
    sl_irradiance first = irradiance_at(&b, &here);
    assert_true(irradiance_at(&b, &far_off).value.g < 0.8f * first.value.g); /* one bounce alone */
    look_from(w, sl_v3(1.0f, 1.1f, 1.8f), sl_v3(0.5f, 1, 1)); /* the same room: nothing changes */
    assert_int_equal(sl_second_cache_follow(b.cache, &w->counters, &error), SL_OK);
    assert_int_equal(sl_second_cache_report(b.cache).records, b.report.records);
    look_from(w, sl_v3(6.9f, 1.2f, 1.9f), sl_v3(6, 1, 1));
    assert_int_equal(sl_second_cache_follow(b.cache, &w->counters, &error), SL_OK);
    assert_true(sl_second_cache_report(b.cache).records > b.report.records + b.report.records / 2);
    sl_irradiance again = irradiance_at(&b, &here);
    assert_memory_equal(&again.value, &first.value, sizeof again.value); /* the rooms do not see each other */
    assert_true(fabs((double)(irradiance_at(&b, &far_off).value.g / first.value.g) - 1.0) < 0.03);
    bouncer_free(&b);
    world_free(w);
}

/* A large room, and a closet without a door: few records, whose light is that of each other. */
static void a_camera_that_sees_a_little_more_has_that_gathered_and_no_more(void **state) {
    world *w = two_rooms(4.0f, 0.35f, 0.05f);
    const sl_gather_point inside = {sl_v3(5.1225f, 0, 0.14f), sl_v3(0, 1, 0), sl_v3(0, 1, 0), SL_NO_INDEX, 3};
    sl_error error;
    look_from(w, sl_v3(3.9f, 2.4f, 3.9f), sl_v3(2, 2, 2));
    bouncer b = bouncer_new(w, 8, 2);
    const uint64_t before = w->counters.value[SL_COUNT_GATHERS];
    look_from(w, sl_v3(5.33f, 0.21f, 0.33f), sl_v3(5.175f, 0.175f, 0.175f));
    assert_int_equal(sl_second_cache_follow(b.cache, &w->counters, &error), SL_OK);
    const size_t more = sl_second_cache_report(b.cache).records - b.report.records;
    assert_true(more > 0 && 8 * more <= b.report.records);
    assert_true(w->counters.value[SL_COUNT_GATHERS] - before < b.report.records);
    const float followed = irradiance_at(&b, &inside).value.g;
    bouncer_free(&b);
    bouncer anew = bouncer_new(w, 8, 2);
    const float whole = irradiance_at(&anew, &inside).value.g;
    assert_true(fabsf(followed / whole - 1.0f) < 0.1f);
    bouncer_free(&anew);
    world_free(w);
}

/* ---- what must not happen ---- */

/* A room open at the front; its walls are of different quads, so that the two rooms' floors are one plane. */
static void open_room(world *w, float x0, float x1, uint32_t wall) {
    const sl_vec3 a = sl_v3(x0, 0, 0), b = sl_v3(x1, 0, 0), c = sl_v3(x1, 0, 2), d = sl_v3(x0, 0, 2),
                  up = sl_v3(0, 2, 0);
    world_quad(w, a, d, c, b, wall);
    world_quad(w, sl_add(a, up), sl_add(b, up), sl_add(c, up), sl_add(d, up), wall);
    world_quad(w, a, b, sl_add(b, up), sl_add(a, up), wall);
    world_quad(w, a, sl_add(a, up), sl_add(d, up), d, wall);
    world_quad(w, b, c, sl_add(c, up), sl_add(b, up), wall);
}

/* Two rooms share the planes of their floors, ceilings and backs, and a wall that is a thousandth thick; the
 * light is in one. */
static void no_bounce_leaks_through_a_thin_wall(void **state) {
    world *w = world_new();
    uint32_t wall = world_material(w, sl_grey(0.8f), sl_grey(0.0f));
    open_room(w, 0.0f, 2.0f, wall);
    open_room(w, 2.001f, 4.0f, wall);
    world_point_light(w, sl_v3(3.0f, 1.0f, 1.2f), 10.0f);
    world_build(w);
    look_from(w, sl_v3(2.0f, 1.0f, 5.5f), sl_v3(2, 1, 0));
    bouncer b = bouncer_new(w, 6, 2);
    double lit = 0.0;
    int dark = 0;
    assert_true(b.report.records > 100);
    for (uint64_t n = 0; n < 400; n++) {
        sl_gather_point point = world_surface_point(w, n);
        double e = (double)irradiance_at(&b, &point).value.g;
        if (point.position.x < 2.0005f) {
            assert_true(e == 0.0);
            dark++;
        } else {
            lit += e;
        }
    }
    assert_true(lit > 0.0 && dark > 100);
    bouncer_free(&b);
    world_free(w);
}

static void a_scene_without_anything_to_see_has_no_second_level_records(void **state) {
    world *w = world_new();
    uint32_t wall = world_material(w, sl_grey(0.5f), sl_grey(0.0f));
    world_quad(w, sl_v3(-1, 0, 1), sl_v3(1, 0, 1), sl_v3(1, 0, -1), sl_v3(-1, 0, -1), wall);
    world_point_light(w, sl_v3(0, 1, 0), 1.0f);
    world_build(w);
    look_from(w, sl_v3(0, 1, 2), sl_v3(0, 0, 0));
    bouncer b = bouncer_new(w, 4, 2);
    assert_int_equal(b.report.records, 0);
    sl_gather_point point = world_surface_point(w, 0);
    assert_true(irradiance_at(&b, &point).value.g == 0.0f);
    bouncer_free(&b);
    world_free(w);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(where_light_bounces_often_between_small_things_records_of_fine_pictures_are_finer),
        cmocka_unit_test(what_the_hits_receive_is_reflected),
        cmocka_unit_test(light_is_known_at_the_very_place_of_a_record),
        cmocka_unit_test(the_furnace_sums_the_series),
        cmocka_unit_test(the_integrating_sphere_dims_by_its_albedo),
        cmocka_unit_test(bounces_that_change_nothing_are_left_out),
        cmocka_unit_test(a_bounce_by_links_is_what_gathering_anew_finds),
        cmocka_unit_test(the_cornell_box_with_four_bounces_is_what_the_path_tracer_says),
        cmocka_unit_test(the_light_of_a_sky_bounces_as_the_path_tracer_says),
        cmocka_unit_test(second_level_records_stay_as_long_as_the_light_does),
        cmocka_unit_test(a_camera_that_goes_elsewhere_brings_second_level_records_there),
        cmocka_unit_test(a_camera_that_sees_a_little_more_has_that_gathered_and_no_more),
        cmocka_unit_test(no_bounce_leaks_through_a_thin_wall),
        cmocka_unit_test(a_scene_without_anything_to_see_has_no_second_level_records),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
