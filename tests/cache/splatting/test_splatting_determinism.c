/* The same records and the same bits, whatever the threads, the batches and the way there. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "unit_test.h"
#include "rendering.h"
#include "cache/splatting/splatting.h"

static void the_picture_has_the_same_bits_at_any_number_of_threads(void **state) {
    sl_scene *scene = load_scene("scenes/cornell-glossy.json");
    for (int kind = SL_GATHER_PLANE; kind <= SL_GATHER_RAYS; kind++) {
        sl_settings settings = small_settings("splatting", 40, 40);
        settings.gather = (sl_gather_kind)kind;
        settings.gather_size = 16;
        settings.metric = kind == SL_GATHER_RAYS ? SL_METRIC_HARMONIC : SL_METRIC_HESSIAN;
        assert_same_bits_with_any_threads(scene, &settings);
    }
    sl_scene_destroy(scene);
}

/* ---- the traversal, driven by hand ---- */

enum { SIDE = 48 };

typedef struct {
    sl_scene *scene;
    sl_raster *raster;
    sl_tracer *tracer;
    sl_gathers gathers;
    sl_gbuffer *gbuffer;
    uint32_t receives[SIDE * SIDE];
    uint8_t owned[SIDE * SIDE];
    float coverage[SIDE * SIDE];
    sl_record_pass pass;
} stage;

static void stage_open(stage *s) {
    memset(s, 0, sizeof *s);
    s->scene = load_scene("scenes/cornell.json");
    sl_counters counters = {{0}};
    assert_int_equal(sl_raster_create(s->scene, 1, &s->raster, NULL), SL_OK);
    assert_int_equal(sl_tracer_create(s->scene, 1, NULL, &s->tracer, NULL), SL_OK);
    sl_gather_settings gather = sl_gather_defaults();
    gather.kind = SL_GATHER_RAYS;
    gather.size = 8;
    assert_int_equal(sl_gathers_create(s->scene, s->raster, s->tracer, &gather, 1, &s->gathers, NULL), SL_OK);
    assert_int_equal(sl_gbuffer_create(SIDE, SIDE, &s->gbuffer, NULL), SL_OK);
    const sl_camera *c = &s->scene->camera;
    sl_frame frame = {c->right, c->up, sl_neg(c->back)};
    float t = 0.357f; /* tan of half the field of view */
    sl_view view = sl_view_pyramid(&frame, c->eye, -t, t, -t, t, SIDE, SIDE, 1e-5f * s->scene->diagonal);
    assert_int_equal(sl_raster_gbuffer(s->raster, &view, 1, s->gbuffer, &counters, NULL), SL_OK);
    const sl_gbuffer *g = s->gbuffer;
    for (int i = 0; i < SIDE * SIDE; i++)
        s->receives[i] = g->material[i] != SL_NO_INDEX && g->diffuse_r[i] > 0.0f;
    s->pass = (sl_record_pass){
        .scene = s->scene,
        .tracer = s->tracer,
        .gathers = &s->gathers,
        .gbuffer = g,
        .receivers = {SIDE, SIDE, g->position_x, g->position_y, g->position_z, g->normal_x, g->normal_y,
                      g->normal_z, s->receives},
        .weights = {0.3f, 1.0f / 0.3f, 1e-5f * s->scene->diagonal},
        .covered_weight = 1.0f / (9.0f * 0.3f),
        .radii = {.accuracy = 0.3,
                  .minimum_pixels = 1.5,
                  .maximum_radius = 0.1 * (double)s->scene->diagonal,
                  .guard = true,
                  .gather = SL_GATHER_RAYS,
                  .plane_tangent = 2.7},
        .isa = sl_isa_best(),
        .camera = c,
        .near_distance = 1e-5f * s->scene->diagonal,
        .footprint_per_depth = 2.0f * t / SIDE,
        .coverage = s->coverage,
        .owned = s->owned,
        .threads = 1,
    };
}

static void stage_close(stage *s) {
    sl_gbuffer_destroy(s->gbuffer);
    sl_gathers_destroy(&s->gathers);
    sl_tracer_destroy(s->tracer);
    sl_raster_destroy(s->raster);
    sl_scene_destroy(s->scene);
}

static sl_record_list traverse(stage *s, sl_traversal_order order, size_t batch, sl_counters *counters) {
    sl_record_list list = {0};
    sl_traversal traversal;
    memset(s->owned, 0, sizeof s->owned);
    memset(s->coverage, 0, sizeof s->coverage);
    sl_traversal_start(&traversal, order, SIDE, SIDE);
    while (traversal.stride) {
        size_t pixels[SL_BATCH_MAX];
        traversal.batch = batch;
        const size_t found = sl_traversal_next(&traversal, &s->pass, pixels);
        if (!found) continue;
        assert_int_equal(sl_traversal_gather(&traversal, &s->pass, pixels, found, &list, counters, NULL),
                         SL_OK);
    }
    assert_int_equal(traversal.visited, SIDE * SIDE);
    return list;
}

static void speculative_batches_give_the_records_of_one_by_one(void **state) {
    static stage s;
    stage_open(&s);
    for (int order = SL_ORDER_COARSE_TO_FINE; order <= SL_ORDER_LINEAR; order++) {
        sl_counters counters = {{0}};
        sl_record_list one_by_one = traverse(&s, (sl_traversal_order)order, 1, &counters);
        assert_int_equal(counters.value[SL_COUNT_RECORDS_DISCARDED], 0);
        assert_true(one_by_one.count > 20);
        for (size_t batch = 2; batch <= SL_BATCH_MAX; batch *= 4) {
            sl_record_list list = traverse(&s, (sl_traversal_order)order, batch, &counters);
            assert_int_equal(list.count, one_by_one.count);
            assert_memory_equal(list.records, one_by_one.records, list.count * sizeof *list.records);
            sl_record_list_free(&list);
        }
        assert_true(counters.value[SL_COUNT_RECORDS_DISCARDED] > 0);
        sl_record_list_free(&one_by_one);
    }
    stage_close(&s);
}

static void in_the_end_every_receiver_is_covered_by_far_fewer_records(void **state) {
    static stage s;
    stage_open(&s);
    sl_counters counters = {{0}};
    sl_record_list list = traverse(&s, SL_ORDER_COARSE_TO_FINE, 16, &counters);
    size_t receivers = 0;
    for (int i = 0; i < SIDE * SIDE; i++) {
        receivers += s.receives[i];
        if (s.receives[i]) assert_true(s.owned[i] || s.coverage[i] >= s.pass.covered_weight);
        else assert_true(s.coverage[i] == 0.0f && !s.owned[i]);
    }
    assert_true(list.count < receivers / 4); /* it is a cache: far fewer records than pixels */
    sl_record_list_free(&list);
    stage_close(&s);
}

/* The pixel that a record was made for. */
static size_t pixel_of(const stage *s, const sl_record *record) {
    const sl_gbuffer *g = s->gbuffer;
    size_t i = 0;
    while (i < SIDE * SIDE &&
           (g->position_x[i] != record->position.x || g->position_y[i] != record->position.y ||
            g->position_z[i] != record->position.z))
        i++;
    assert_true(i < SIDE * SIDE);
    return i;
}

/* The records one by one, in order: none of them was made for a pixel that those before it cover. */
static void no_record_is_made_on_a_pixel_that_earlier_ones_cover(void **state) {
    static stage s;
    stage_open(&s);
    for (int order = SL_ORDER_COARSE_TO_FINE; order <= SL_ORDER_LINEAR; order++) {
        sl_counters counters = {{0}};
        sl_record_list list = traverse(&s, (sl_traversal_order)order, 32, &counters);
        assert_true(list.count > 20);
        for (size_t k = 0; k < list.count; k++) {
            size_t pixel = pixel_of(&s, &list.records[k]);
            float sum = 0.0f;
            assert_true(s.receives[pixel]);
            for (size_t j = 0; j < k; j++) {
                sum += sl_record_weight(&s.pass, &list.records[j], pixel);
                assert_true(pixel_of(&s, &list.records[j]) != pixel);
            }
            assert_true(sum < s.pass.covered_weight);
        }
        sl_record_list_free(&list);
    }
    stage_close(&s);
}

/* ---- ways to the same picture ---- */

static uint64_t finish(sl_method *method) {
    sl_progress progress = {.done = true}; /* left over from before an edit: the method knows better */
    assert_int_equal(sl_method_update(method, &progress, NULL), SL_OK);
    while (!progress.done) assert_int_equal(sl_method_update(method, &progress, NULL), SL_OK);
    return sl_method_counters(method)->value[SL_COUNT_RECORDS];
}

static void a_moved_camera_keeps_the_records_and_looking_back_needs_none(void **state) {
    sl_scene *scene = load_scene("scenes/cornell.json");
    sl_camera home = scene->camera;
    sl_settings settings = small_settings("splatting", 40, 40);
    settings.gather_size = 16;
    sl_method *method = created_method(scene, &settings);
    uint64_t first = finish(method);
    const float eye[3] = {300, 290, -760}, target[3] = {270, 260, 0}, up[3] = {0, 1, 0};
    assert_int_equal(sl_scene_set_camera(scene, eye, target, up, home.vertical_fov, NULL), SL_OK);
    assert_int_equal(sl_method_edit(method, SL_CHANGED_CAMERA, NULL), SL_OK);
    /* resolving before the new view has its G-buffer shows nothing and spoils nothing */
    sl_image *too_early = resolved_picture(method);
    for (int i = 0; i < 40 * 40; i++) assert_true(too_early->planes[i] == 0.0f);
    sl_image_destroy(too_early);
    uint64_t second = finish(method) - first;
    sl_image *moved = resolved_picture(method);
    const float *weight = sl_image_channel(moved, "weight.Y"),
                *indirect = sl_image_channel(moved, "indirect.R");
    for (int i = 0; i < 40 * 40; i++) assert_true(weight[i] > 0.0f || indirect[i] == 0.0f);
    sl_image_destroy(moved);
    assert_true(second < first / 2);
    scene->camera = home;
    assert_int_equal(sl_method_edit(method, SL_CHANGED_CAMERA, NULL), SL_OK);
    uint64_t third = finish(method) - first - second;
    /* radii that shrank for the second view's records may open a few gaps */
    assert_true(third <= first / 20);
    assert_int_equal(sl_method_edit(method, SL_CHANGED_LIGHTS, NULL), SL_OK);
    assert_int_equal(finish(method) - first - second - third, first); /* new light: all anew */
    destroy_method(method, scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_picture_has_the_same_bits_at_any_number_of_threads),
        cmocka_unit_test(speculative_batches_give_the_records_of_one_by_one),
        cmocka_unit_test(in_the_end_every_receiver_is_covered_by_far_fewer_records),
        cmocka_unit_test(no_record_is_made_on_a_pixel_that_earlier_ones_cover),
        cmocka_unit_test(a_moved_camera_keeps_the_records_and_looking_back_needs_none),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
