/* From chosen pixels to work: what is asked for, what is split, how large patches are in the picture. */
#include <math.h>

#include "base/math.h"
#include "cache/shading_cache/work.h"
#include "scene/model.h"
#include "shading_cache_support.h"

enum { WIDTH = 120, HEIGHT = 80, PLACES_MAX = 4096 };

static const sl_display_curve curve = {.reference = 1.0f};
static sl_object_change object[1];
static sl_changes changes = {.object_count = 1, .object = object};
static sl_view view;

/* Looks down on the square of side 2 in z = 0 from the height at which a unit is so many pixels. */
static sl_camera camera_above(float pixels_a_unit) {
    float fov = 1.0f, height = 0.5f * HEIGHT / (pixels_a_unit * (float)sl_tan(0.5));
    return (sl_camera){sl_v3(0, 0, height), sl_v3(1, 0, 0), sl_v3(0, 1, 0), sl_v3(0, 0, 1), fov};
}

static sl_work_settings usual(void) {
    object[0] = (sl_object_change){.changing = false};
    changes.eye_moved = 0;
    return (sl_work_settings){.view = &view,
                              .curve = &curve,
                              .split_above = 1.2f,
                              .changes = &changes};
}

typedef struct outcome {
    uint32_t vertex[4 * PLACES_MAX + 64];
    size_t count;
    uint64_t splits;
} outcome;
static outcome out;

static void work(hierarchy *h, const sl_work_settings *settings, const sl_camera *camera, size_t count,
                 const sl_chosen_place *places) {
    sl_counters counters = {0};
    view = sl_view_of_camera(h->scene, camera, WIDTH, HEIGHT);
    assert_int_equal(
        sl_work_out(h->patches, settings, count, places, out.vertex, &out.count, &counters, NULL), SL_OK);
    out.splits = counters.value[SL_COUNT_SPLITS];
    assert_sound(h->patches);
    for (size_t i = 0; i < out.count; i++) {
        assert_true(h->patches->vertex[out.vertex[i]].references > 0);
        for (size_t j = 0; j < i; j++) assert_int_not_equal(out.vertex[i], out.vertex[j]);
    }
}

/* n by n places, spread evenly over a patch that is a whole square root. */
static size_t grid_of_places(uint32_t patch, int n, sl_chosen_place *places) {
    size_t count = 0;
    for (int j = 0; j < n; j++) {
        for (int i = 0; i < n; i++)
            places[count++] =
                (sl_chosen_place){patch, ((float)i + 0.5f) / (float)n, ((float)j + 0.5f) / (float)n};
    }
    return count;
}

/* ---- evaluate, or split ---- */

static void a_patch_never_evaluated_gets_its_corners_and_stays_whole(void **state) {
    sl_chosen_place places[64];
    sl_camera camera = camera_above(30);
    sl_work_settings settings = usual();
    for (int kind = 0; kind < 2; kind++) {
        hierarchy h = hierarchy_of(kind ? triangle_scene() : square_scene(), 0);
        uint32_t patch = want_root(&h, 0);
        size_t count = grid_of_places(patch, 8, places);
        work(&h, &settings, &camera, count, places);
        assert_int_equal(out.splits, 0);
        assert_int_equal(out.count, kind ? 3 : 4);
        for (int c = 0; c < (kind ? 3 : 4); c++)
            assert_int_equal(out.vertex[c], sl_patch_corner(h.patches, patch, c));
        evaluate_all(&h, 1.0f, 1);
        evaluate(&h, sl_patch_corner(h.patches, patch, 1), 0.0f, SL_VERTEX_NEVER);
        work(&h, &settings, &camera, count, places);
        assert_int_equal(out.splits, 0);
        assert_int_equal(out.count, 1);
        assert_int_equal(out.vertex[0], sl_patch_corner(h.patches, patch, 1));
        hierarchy_discard(&h);
    }
}

static void corners_from_before_an_edit_hold_up_no_split(void **state) {
    sl_camera camera = camera_above(30);
    sl_work_settings settings = usual();
    hierarchy h = hierarchy_of(square_scene(), 0);
    uint32_t patch = want_root(&h, 0);
    sl_chosen_place place = {patch, 0.1f, 0.1f};
    evaluate_all(&h, 1.0f, 5);
    object[0].stale_before = 6;
    changes.eye_moved = 9; /* which is nothing to diffuse surfaces */
    evaluate(&h, sl_patch_corner(h.patches, patch, 2), 1.0f, 6);
    for (int c = 0; c < 4; c++)
        assert_int_equal(sl_vertex_is_stale(h.patches, &settings, sl_patch_corner(h.patches, patch, c)),
                         c != 2);
    work(&h, &settings, &camera, 1, &place);
    assert_int_equal(out.splits, 1);
    assert_int_equal(out.count, 3); /* of the child that has the place: its corners are all the new ones */
    object[0].stale_before = 0;
    hierarchy_discard(&h);
}

static void sixteen_places_give_two_levels_in_one_update_and_no_number_more_than_three(void **state) {
    static const int side[] = {1, 2, 4, 8, 16}, depth[] = {1, 1, 2, 3, 3};
    static sl_chosen_place places[256];
    sl_camera camera = camera_above(35);
    sl_work_settings settings = usual();
    for (int k = 0; k < 5; k++) {
        hierarchy h = hierarchy_of(square_scene(), 0);
        uint32_t patch = want_root(&h, 0);
        evaluate_all(&h, 1.0f, 1);
        size_t count = grid_of_places(patch, side[k], places);
        work(&h, &settings, &camera, count, places);
        assert_int_equal(deepest(h.patches), depth[k]);
        /* all corners of the finest grid but the square's own; of its middle alone the first child's */
        size_t n = (size_t)1 << depth[k];
        assert_int_equal(out.count, k == 0 ? 3 : (n + 1) * (n + 1) - 4);
        assert_int_equal(h.patches->leaves_alive, n * n);
        hierarchy_discard(&h);
    }
}

static void patches_are_handled_in_their_order_and_vertices_are_asked_for_once(void **state) {
    sl_camera camera = camera_above(30);
    sl_work_settings settings = usual();
    hierarchy h = hierarchy_of(square_scene(), 0);
    uint32_t root = want_root(&h, 0);
    split_levels(&h, root, 1);
    uint32_t first = h.patches->patch[root].child;
    const sl_chosen_place places[] = {
        {first + 2, 0.9f, 0.9f}, {first, 0.1f, 0.1f}, {first + 2, 0.8f, 0.8f}, {first + 1, 0.9f, 0.1f}};
    work(&h, &settings, &camera, 4, places);
    assert_int_equal(out.count, 8); /* 4 of the first, 2 more, 2 more */
    for (int c = 0; c < 4; c++) assert_int_equal(out.vertex[c], sl_patch_corner(h.patches, first, c));
    assert_int_equal(out.vertex[4], sl_patch_corner(h.patches, first + 1, 1));
    hierarchy_discard(&h);
}

/* ---- where splits end ---- */

static void nothing_is_split_at_the_stop_size_and_patches_become_as_many_as_pixels(void **state) {
    static sl_chosen_place places[PLACES_MAX];
    for (int kind = 0; kind < 2; kind++) {
        hierarchy h = hierarchy_of(kind ? triangle_scene() : square_scene(), 0);
        sl_camera camera = camera_above(16); /* 32 x 32 pixels, or half of them */
        sl_work_settings settings = usual();
        want_root(&h, 0);
        double pixels = kind ? 512.0 : 1024.0;
        bool done = false;
        for (int update = 0; update < 40 && !done; update++) {
            size_t count = 0;
            for (int i = 0; i < 64 * 64; i++) {
                float u = ((float)(i % 64) + 0.5f) / 64.0f, v = ((float)(i / 64) + 0.5f) / 64.0f;
                if (!kind || u + v < 1.0f)
                    places[count++] =
                        (sl_chosen_place){sl_patch_locate(h.patches, 0, (double)u, (double)v).patch, u, v};
            }
            work(&h, &settings, &camera, count, places);
            for (size_t i = 0; i < out.count; i++) evaluate(&h, out.vertex[i], 1.0f, 1);
            done = out.count == 0 && out.splits == 0;
        }
        assert_true(done);
        for (uint32_t i = 0; i < h.patches->patch_count; i++) {
            if (!sl_patch_is_alive(h.patches, i)) continue;
            sl_patch_place place = sl_patch_place_of(h.patches, i);
            float area = sl_patch_projected(h.patches, &place, &view).area;
            assert_true(sl_patch_is_leaf(h.patches, i) ? area <= 1.2f : area > 1.2f);
            assert_int_equal(sl_patch_is_finished(h.patches, &settings, i),
                             area <= 1.2f);
        }
        assert_true((double)h.patches->leaves_alive >= pixels / 1.2 &&
                    (double)h.patches->leaves_alive < 4.0 * pixels / 1.2);
        hierarchy_discard(&h);
    }
}

static void patches_of_one_pixel_ask_for_nothing_unless_noise_is_to_go_down(void **state) {
    static sl_chosen_place places[64];
    for (int sets = 0; sets < 2; sets++) {
        hierarchy h = hierarchy_of(square_scene(), sets ? KEEP_SETS : 0);
        sl_camera camera = camera_above(0.5f); /* the whole root is one pixel */
        sl_work_settings settings = usual();
        uint32_t patch = want_root(&h, 0);
        evaluate_all(&h, 1.0f, 1);
        size_t count = grid_of_places(patch, 8, places);
        work(&h, &settings, &camera, count, places);
        assert_int_equal(out.count, sets ? 4 : 0);
        assert_int_equal(out.splits, 0);
        assert_true(sl_patch_is_finished(h.patches, &settings, patch));
        hierarchy_discard(&h);
    }
}

/* A corner that meets a lamp in a mirror would colour all of its pixel. */
static void of_what_is_polished_leaves_with_contrast_are_split_to_a_sixteenth_of_a_pixel(void **state) {
    static const struct {
        float specular, exponent, mirror, bright, pixels_a_unit;
        bool split, wanted;
    } cases[] = {{0.5f, 200, 0, 4, 0.5f, true, true},   {0, 0, 0.5f, 4, 0.5f, true, true},
                 {0.5f, 20, 0, 4, 0.5f, false, true},   {0.5f, 200, 0, 1e-3f, 0.5f, false, true},
                 {0.5f, 200, 0, 4, 0.12f, false, true}, {0.5f, 200, 0, 4, 0.16f, true, true},
                 {0.5f, 200, 0, 4, 0.5f, false, false}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        trace_mesh mesh = trace_mesh_begin();
        trace_mesh_material(&mesh, cases[i].mirror > 0.0f ? 0.0f : 0.3f, cases[i].specular, cases[i].exponent,
                            cases[i].mirror, 0);
        trace_mesh_quad(&mesh, sl_v3(-1, -1, 0), sl_v3(2, 0, 0), sl_v3(0, 2, 0), 0);
        hierarchy h = hierarchy_of(trace_mesh_build(&mesh), KEEP_LOBES);
        uint32_t patch = want_root(&h, 0);
        evaluate_all(&h, 0.0f, 1);
        float *lobe = sl_vertex_lobe(h.patches, sl_patch_corner(h.patches, patch, 2));
        lobe[0] = lobe[1] = lobe[2] = cases[i].bright;
        sl_work_settings settings = usual();
        settings.sharp = cases[i].wanted;
        sl_camera camera = camera_above(cases[i].pixels_a_unit);
        sl_chosen_place place = {patch, 0.4f, 0.4f};
        view = sl_view_of_camera(h.scene, &camera, WIDTH, HEIGHT);
        assert_int_equal(sl_patch_is_finished(h.patches, &settings, patch),
                         !cases[i].split);
        work(&h, &settings, &camera, 1, &place);
        assert_int_equal(out.splits, cases[i].split);
        hierarchy_discard(&h);
    }
}

static void noise_is_answered_by_more_samples_and_contrast_by_splits(void **state) {
    hierarchy h = hierarchy_of(square_scene(), KEEP_SETS);
    sl_camera camera = camera_above(30);
    sl_work_settings settings = usual();
    uint32_t patch = want_root(&h, 0);
    sl_chosen_place place = {patch, 0.3f, 0.3f};
    evaluate_all(&h, 4.0f, 1);
    evaluate(&h, sl_patch_corner(h.patches, patch, 0), 4.5f, 1);
    /* sigma 1/2, of the difference 0.71 */
    for (int c = 0; c < 4; c++) h.patches->sets[sl_patch_corner(h.patches, patch, c)].variance = 0.25f;
    work(&h, &settings, &camera, 1, &place);
    assert_int_equal(out.count, 4);
    assert_int_equal(out.splits, 0);
    for (int c = 0; c < 4; c++)
        assert_false(sl_vertex_is_stale(h.patches, &settings, sl_patch_corner(h.patches, patch, c)));
    /* The bound is at a difference of twice its standard error: 2 sqrt(2) sigma. */
    for (int above = 0; above < 2; above++) {
        float sigma = 0.5f / (2.0f * sqrtf(2.0f)) * (above ? 0.97f : 1.03f);
        for (int c = 0; c < 4; c++)
            h.patches->sets[sl_patch_corner(h.patches, patch, c)].variance = sigma * sigma;
        work(&h, &settings, &camera, 1, &place);
        assert_int_equal(out.splits, above);
    }
    hierarchy_discard(&h);
}

static void what_changes_is_not_split_below_what_there_is_time_for(void **state) {
    for (int kind = 0; kind < 2; kind++) {
        hierarchy h = hierarchy_of(kind ? triangle_scene() : square_scene(), 0);
        sl_camera camera = camera_above(10);
        sl_work_settings settings = usual();
        sl_chosen_place place = {want_root(&h, 0), 0.3f, 0.3f};
        evaluate_all(&h, 1.0f, 1);
        settings.coarsest = 101.0f; /* children of 100 pixels; of the triangle, 50 */
        object[0].changing = true;
        work(&h, &settings, &camera, 1, &place);
        assert_int_equal(out.splits, 0);
        settings.coarsest = 99.0f;
        work(&h, &settings, &camera, 1, &place);
        assert_int_equal(out.splits, 1);
        hierarchy_discard(&h);
        h = hierarchy_of(square_scene(), 0);
        place.patch = want_root(&h, 0);
        evaluate_all(&h, 1.0f, 1);
        settings.coarsest = 101.0f;
        object[0].changing = false;
        work(&h, &settings, &camera, 1, &place);
        assert_int_equal(out.splits, 1);
        hierarchy_discard(&h);
    }
}

/* ---- size in the picture ---- */

static sl_screen_size size_of(hierarchy *h, uint32_t patch, const sl_camera *camera) {
    sl_patch_place place = sl_patch_place_of(h->patches, patch);
    view = sl_view_of_camera(h->scene, camera, WIDTH, HEIGHT);
    return sl_patch_projected(h->patches, &place, &view);
}

static void a_floor_that_runs_on_behind_the_eye_is_as_large_as_what_is_seen_of_it(void **state) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_diffuse(&mesh, 0.5f);
    trace_mesh_quad(&mesh, sl_v3(-1e4f, -1e4f, 0), sl_v3(2e4f, 0, 0), sl_v3(0, 2e4f, 0), 0);
    hierarchy h = hierarchy_of(trace_mesh_build(&mesh), 0);
    uint32_t patch = want_root(&h, 0);
    /* looks along y, one above it: half the picture */
    sl_camera along = {sl_v3(0, 0, 1), sl_v3(1, 0, 0), sl_v3(0, 0, 1), sl_v3(0, -1, 0), 1.0f};
    assert_true(fabs((double)size_of(&h, patch, &along).area / (0.5 * WIDTH * HEIGHT) - 1.0) < 0.01);
    along.eye.z = 0.0f; /* in the floor */
    assert_true(size_of(&h, patch, &along).area < 1.0f);
    along.eye.z = 1e-4f; /* so close that the near plane hides it */
    along.back = sl_v3(0, 0, 1);
    along.up = sl_v3(0, 1, 0);
    assert_true(size_of(&h, patch, &along).area == 0.0f);
    hierarchy_discard(&h);
}

/* A sheet rolled to a pipe of radius 1 or so: its corners span nothing. */
static sl_scene *pipe_scene(void) {
    static const float x[4] = {0.0f, 4.0f, -4.0f, 0.0f}, z[4] = {0.0f, 4.0f, 4.0f, 0.0f};
    sl_model model = {.stays_dark = true};
    sl_bicubic b = {.steps = 8};
    for (int j = 0; j < 4; j++) {
        for (int i = 0; i < 4; i++) b.point[j][i] = sl_v3(x[i], (float)j - 1.5f, z[i]);
    }
    sl_scene *scene;
    assert_int_equal(sl_model_add_bicubic(&model, &b, 0, 0, NULL), SL_OK);
    assert_int_equal(sl_model_build(&model, &scene, NULL), SL_OK);
    sl_model_clear(&model);
    return scene;
}

static void a_curved_patch_is_as_large_as_what_bulges_out_of_its_corners(void **state) {
    hierarchy h = hierarchy_of(pipe_scene(), 0);
    uint32_t patch = want_root(&h, 0);
    sl_camera camera = camera_above(0.1f); /* from far away: so many pixels a unit */
    float whole = size_of(&h, patch, &camera).area, parts = 0.0f;
    split_levels(&h, patch, 1);
    for (uint32_t k = 0; k < 4; k++) parts += size_of(&h, h.patches->patch[patch].child + k, &camera).area;
    /* It is 2.31 wide and 3 long, and seen twice, in front of itself. */
    assert_true(whole > 0.9f * 2.0f * 2.31f * 3.0f * 0.01f && whole < 1.1f * 2.0f * 2.31f * 3.0f * 0.01f);
    assert_true(fabsf(parts / whole - 1.0f) < 0.15f);
    hierarchy_discard(&h);
}

static void patches_at_the_eye_are_split_down_to_the_depth_limit_and_no_further(void **state) {
    hierarchy h = hierarchy_of(square_scene(), 0);
    want_root(&h, 0);
    sl_camera camera = {sl_v3(0.3f, 0.3f, 1e-4f), sl_v3(1, 0, 0), sl_v3(0, 1, 0), sl_v3(0, 0, 1), 1.0f};
    sl_work_settings settings = usual();
    for (int i = 0; i < 40; i++) {
        sl_chosen_place place = {sl_patch_locate(h.patches, 0, 0.65, 0.65).patch, 0.65f, 0.65f};
        work(&h, &settings, &camera, 1, &place);
        for (size_t k = 0; k < out.count; k++) evaluate(&h, out.vertex[k], 1.0f, 1);
    }
    assert_int_equal(out.count + out.splits, 0);
    assert_int_equal(deepest(h.patches), SL_PATCH_DEPTH_MAX);
    assert_true(sl_patch_is_finished(h.patches, &settings,
                                     sl_patch_locate(h.patches, 0, 0.65, 0.65).patch));
    hierarchy_discard(&h);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_patch_never_evaluated_gets_its_corners_and_stays_whole),
        cmocka_unit_test(corners_from_before_an_edit_hold_up_no_split),
        cmocka_unit_test(sixteen_places_give_two_levels_in_one_update_and_no_number_more_than_three),
        cmocka_unit_test(
            patches_are_handled_in_their_order_and_vertices_are_asked_for_once),
        cmocka_unit_test(nothing_is_split_at_the_stop_size_and_patches_become_as_many_as_pixels),
        cmocka_unit_test(patches_of_one_pixel_ask_for_nothing_unless_noise_is_to_go_down),
        cmocka_unit_test(of_what_is_polished_leaves_with_contrast_are_split_to_a_sixteenth_of_a_pixel),
        cmocka_unit_test(noise_is_answered_by_more_samples_and_contrast_by_splits),
        cmocka_unit_test(what_changes_is_not_split_below_what_there_is_time_for),
        cmocka_unit_test(a_floor_that_runs_on_behind_the_eye_is_as_large_as_what_is_seen_of_it),
        cmocka_unit_test(a_curved_patch_is_as_large_as_what_bulges_out_of_its_corners),
        cmocka_unit_test(patches_at_the_eye_are_split_down_to_the_depth_limit_and_no_further),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
