/* The whole loop, looked at from the inside: what is asked for and what is left alone, what grows old and
 * what an edit costs, and that in the end all is as if nothing had ever moved. Samples are of direct light,
 * so that a value is a function of its place. */
#include "shading_cache_support.h"

#include <math.h>
#include <stdio.h>

#include "cache/frame/method.h"
#include "cache/shading_cache/state.h"
#include "matched.h"
#include "rendering.h"

/* patches are kept as if of a picture of 64 x 64 at least */
enum { SIZE = 32, PIXELS = SIZE * SIZE, ROOM_FOR = 64 * 64 };

static sl_settings loop_settings(void) {
    sl_settings s = small_settings("shading-cache", SIZE, SIZE);
    s.shading_cache.indirect = SL_INDIRECT_NONE;
    s.shading_cache.frames_per_update = 1;
    s.shading_cache.updates = 1000000000;
    return s;
}

static sl_shading_state *inside_of(sl_method *method) { return method->state; }

static uint64_t to_the_end(sl_method *method) {
    uint64_t updates = 1;
    while (!update(method)) assert_true(++updates < 4000);
    return updates;
}

static void edit(sl_method *method, unsigned changes) {
    assert_int_equal(sl_method_edit(method, changes, NULL), SL_OK);
}

static void look(sl_scene *scene, sl_vec3 eye, sl_vec3 target) {
    assert_true(sl_camera_look_at(&scene->camera, eye, target, sl_v3(0, 1, 0), 0.9f));
}

static sl_scene *before_the_eye(trace_mesh *mesh) {
    sl_scene *scene = trace_mesh_build(mesh);
    look(scene, sl_v3(0, 0, 3), sl_v3(0, 0, 0));
    return scene;
}

/* A room of six quadrilaterals with a floor of tiles, a light or a lamp in it, and the eye in its front. */
static sl_scene *room_with(bool lamp) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t wall = trace_mesh_diffuse(&mesh, 0.5f);
    trace_mesh_box(&mesh, sl_v3(-1, -1, -1), sl_v3(1, 1, 1), true, wall);
    for (int i = 0; i < 4; i++)
        trace_mesh_quad(&mesh, sl_v3(-0.8f + 0.8f * (float)(i % 2), -0.9f, -0.8f + 0.8f * (float)(i / 2)),
                        sl_v3(0, 0, 0.8f), sl_v3(0.8f, 0, 0), wall);
    if (!lamp) trace_mesh_point_light(&mesh, sl_v3(0.3f, 0.5f, -0.2f), sl_grey(1.0f));
    if (lamp)
        trace_mesh_quad(&mesh, sl_v3(0.1f, 0.8f, -0.4f), sl_v3(0.6f, 0, 0), sl_v3(0, 0, 0.6f),
                        trace_mesh_lamp(&mesh, 4));
    sl_scene *scene = trace_mesh_build(&mesh);
    look(scene, sl_v3(0, 0, 0.9f), sl_v3(0, -0.2f, -1));
    return scene;
}

static sl_scene *room(void) { return room_with(false); }

/* ---- what settings say ---- */

static void
some_pixels_are_chosen_at_random_some_by_floods_and_where_there_is_a_crowd_patches_are_split_twice_at_once(
    void **state) {
    for (int without = 0; without < 2; without++) {
        sl_scene *scene = room();
        sl_settings settings = loop_settings();
        settings.shading_cache.no_random = settings.shading_cache.no_flood = without;
        sl_method *method = created_method(scene, &settings);
        update(method);
        assert_int_equal(deepest(inside_of(method)->patches), 0);
        update(method);
        int depth = deepest(inside_of(method)->patches);
        assert_true(depth == 2 || depth == 3);
        for (int i = 0; i < 6; i++) update(method);
        assert_int_equal(count_of(method, SL_COUNT_PIXELS_RANDOM) > 0, !without);
        assert_int_equal(count_of(method, SL_COUNT_PIXELS_FLOODED) > 0, !without);
        destroy_method(method, scene);
    }
}

static void in_the_end_all_that_is_seen_is_of_the_stop_size_and_nothing_was_split_for_less(void **state) {
    for (int curved = 0; curved < 2; curved++) {
        sl_scene *scene = curved ? load_scene("scenes/vase.json") : room();
        sl_settings settings = loop_settings();
        settings.shading_cache.stop_size = 2.0;
        settings.shading_cache.area_samples = 16;
        sl_method *method = created_method(scene, &settings);
        const sl_shading_state *s = inside_of(method);
        to_the_end(method);
        for (uint32_t i = 0; i < s->patches->patch_count; i++) {
            if (!sl_patch_is_alive(s->patches, i) || s->patches->patch[i].seen != s->now) continue;
            sl_patch_place place = sl_patch_place_of(s->patches, i);
            assert_int_equal(sl_patch_projected(s->patches, &place, &s->view).area >
                                 1.2f * 2.0f,
                             !sl_patch_is_leaf(s->patches, i));
        }
        destroy_method(method, scene);
    }
}

/* ---- what is asked for ----------------------------------------------------------------------- */

static void nothing_is_shaded_twice_in_a_scene_at_rest_and_no_more_points_than_there_are_vertices(
    void **state) {
    enum { MOST = 20000 };
    static uint32_t when[MOST];
    sl_scene *scene = room();
    sl_settings settings = loop_settings();
    sl_method *method = created_method(scene, &settings);
    const sl_shading_state *s = inside_of(method);
    memset(when, 0, sizeof when);
    for (int i = 0; i < 40; i++) {
        update(method);
        assert_true(s->patches->vertex_count <= MOST);
        size_t evaluated = 0;
        for (size_t v = 0; v < s->patches->vertex_count; v++) {
            uint32_t at = s->patches->vertex[v].evaluated;
            assert_true(when[v] == SL_VERTEX_NEVER || at == when[v]);
            when[v] = at;
            evaluated += at != SL_VERTEX_NEVER;
        }
        assert_int_equal(count_of(method, SL_COUNT_POINTS_SHADED), evaluated);
        assert_true(evaluated <= s->patches->vertices_alive);
    }
    assert_true(count_of(method, SL_COUNT_POINTS_SHADED) > 1000);
    destroy_method(method, scene);
}

static void pixels_of_patches_are_the_pictures_and_the_next_id_map_names_children(void **state) {
    static uint32_t patch[PIXELS];
    sl_scene *scene = room();
    /* from outside: the front wall is seen from behind, around it is nothing */
    look(scene, sl_v3(0, 0, 3.6f), sl_v3(0, -0.2f, -1));
    sl_settings settings = loop_settings();
    sl_method *method = created_method(scene, &settings);
    const sl_shading_state *s = inside_of(method);
    size_t children = 0;
    for (int i = 0; i < 12; i++) {
        update(method);
        size_t sum = 0, covered = 0;
        for (size_t k = 0; k < s->leaf_count; k++) sum += s->leaf[k].pixels;
        for (int k = 0; k < PIXELS; k++) covered += s->ids.patch[k] != SL_NO_INDEX;
        assert_true(covered > PIXELS / 4 && covered < PIXELS);
        assert_int_equal(sum, covered);
        sl_display_ids ids = {.patch = patch};
        sl_counters counters = {0};
        assert_int_equal(sl_display_id_map(s->display, &ids, &counters, NULL), SL_OK);
        for (int k = 0; k < PIXELS; k++) {
            assert_int_equal(patch[k] == SL_NO_INDEX, s->ids.patch[k] == SL_NO_INDEX);
            if (patch[k] == SL_NO_INDEX) continue;
            assert_true(sl_patch_is_alive(s->patches, patch[k]) && sl_patch_is_leaf(s->patches, patch[k]));
            children += patch[k] != s->ids.patch[k];
        }
    }
    assert_true(children > 500);
    /* of leaves, and of all that is above them */
    uint32_t *wanted = calloc(s->patches->patch_count, sizeof *wanted);
    assert_non_null(wanted);
    for (int k = 0; k < PIXELS; k++) {
        for (uint32_t at = s->ids.patch[k]; at != SL_NO_INDEX; at = sl_patch_parent(s->patches, at))
            wanted[at]++;
    }
    for (uint32_t i = 0; i < s->patches->patch_count; i++) {
        if (wanted[i]) assert_int_equal(s->patches->patch[i].pixels, wanted[i]);
    }
    free(wanted);
    destroy_method(method, scene);
}

/* One wall hides another, and one is behind the eye. */
static void patches_that_are_not_seen_are_left_alone(void **state) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t wall = trace_mesh_diffuse(&mesh, 0.5f);
    trace_mesh_quad(&mesh, sl_v3(-2, -2, 0), sl_v3(4, 0, 0), sl_v3(0, 4, 0), wall);
    trace_mesh_quad(&mesh, sl_v3(-1, -1, -1), sl_v3(2, 0, 0), sl_v3(0, 2, 0), wall);
    trace_mesh_quad(&mesh, sl_v3(-1, -1, 5), sl_v3(0, 2, 0), sl_v3(2, 0, 0), wall);
    trace_mesh_point_light(&mesh, sl_v3(0.4f, 0.2f, 0.5f), sl_grey(1.0f));
    sl_scene *scene = before_the_eye(&mesh);
    sl_settings settings = loop_settings();
    sl_method *method = created_method(scene, &settings);
    const sl_patches *p = inside_of(method)->patches;
    for (int i = 0; i < 25; i++) update(method);
    assert_true(count_of(method, SL_COUNT_SPLITS) > 100);
    for (uint32_t root = 2; root < 6; root++) {
        uint32_t patch = sl_patches_find_root(p, root);
        if (patch == SL_NO_INDEX) continue;
        assert_true(sl_patch_is_leaf(p, patch));
        assert_int_equal(p->patch[patch].seen, 0);
        assert_int_equal(p->patch[patch].pixels, 0);
        for (int c = 0; c < 4; c++)
            assert_int_equal(p->vertex[sl_patch_corner(p, patch, c)].evaluated, SL_VERTEX_NEVER);
    }
    const sl_shading_state *s = inside_of(method);
    /* nobody else has a priority */
    for (size_t i = 0; i < s->leaf_count; i++) assert_int_equal(sl_patch_root(p, s->leaf[i].patch), 0);
    destroy_method(method, scene);
}

/* Irradiance is even, so its four corners say all; what is seen has the texture's own resolution. */
static void a_textured_wall_in_even_light_is_exact_with_four_samples(void **state) {
    static uint8_t texels[16 * 16 * 4];
    for (int i = 0; i < 16 * 16 * 4; i++) texels[i] = (uint8_t)(30 + 97 * i % 220);
    trace_mesh mesh = trace_mesh_begin();
    uint32_t wall = trace_mesh_diffuse(&mesh, 0.8f);
    mesh.textures[0] = (sl_texture){.file = (char *)"checks", .width = 16, .height = 16, .texels = texels};
    mesh.texture_count = 1;
    mesh.materials[wall].texture = 0;
    trace_mesh_quad(&mesh, sl_v3(-1, -1, 0), sl_v3(2, 0, 0), sl_v3(0, 2, 0), wall);
    for (size_t v = 0; v < mesh.vertex_count; v++) {
        mesh.texture_coordinates[2 * v] = mesh.positions[3 * v] * 0.5f + 0.5f;
        mesh.texture_coordinates[2 * v + 1] = mesh.positions[3 * v + 1] * 0.5f + 0.5f;
    }
    mesh.lights[mesh.light_count++] =
        (sl_light){.type = SL_LIGHT_DIRECTIONAL, .direction = {0, 0.6f, -0.8f}, .intensity = {1, 2, 3}};
    sl_scene *scene = trace_mesh_build(&mesh);
    look(scene, sl_v3(0.1f, 0.1f, 3), sl_v3(0, 0, 0));
    sl_settings settings = loop_settings(), path = small_settings("path", SIZE, SIZE);
    settings.shading_cache.updates = 1;
    path.transport = "matched:shading-cache";
    path.shading_cache = settings.shading_cache;
    path.spp = 1;
    sl_counters cost;
    sl_image *ours = render(scene, &settings, &cost), *truth = render(scene, &path, NULL);
    assert_int_equal(cost.value[SL_COUNT_POINTS_SHADED], 4);
    float least = HUGE_VALF, most = 0.0f;
    for (int i = 0; i < 3 * PIXELS; i++) {
        /* both round; a texel is worth 0.7 times its neighbour */
        assert_true(fabsf(ours->planes[i] - truth->planes[i]) <= 1e-4f * (1e-3f + truth->planes[i]));
        if (i < PIXELS && truth->planes[i] > 0.0f)
            least = fminf(least, truth->planes[i]), most = fmaxf(most, truth->planes[i]);
    }
    assert_true(most > 2.0f * least);
    destroy_pictures(ours, truth);
    sl_scene_destroy(scene);
}

/* ---- age ------------------------------------------------------------------------------------- */

/* Two walls beside each other, each a material; the sun comes from the eye. */
static sl_scene *two_walls(float specular, float exponent, float other_specular, float other_exponent) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t one = trace_mesh_material(&mesh, 0.4f, specular, exponent, 0, 0),
             other = trace_mesh_material(&mesh, 0.4f, other_specular, other_exponent, 0, 0);
    trace_mesh_quad(&mesh, sl_v3(-2.1f, -1, 0), sl_v3(2, 0, 0), sl_v3(0, 2, 0), one);
    trace_mesh_quad(&mesh, sl_v3(0.1f, -1, 0), sl_v3(2, 0, 0), sl_v3(0, 2, 0), other);
    mesh.lights[mesh.light_count++] =
        (sl_light){.type = SL_LIGHT_DIRECTIONAL, .direction = {0, 0, -1}, .intensity = sl_grey(2.0f)};
    sl_scene *scene = trace_mesh_build(&mesh);
    look(scene, sl_v3(0, 0, 4), sl_v3(0, 0, 0));
    return scene;
}

static void turn(sl_scene *scene, sl_method *method, int step) {
    look(scene, sl_v3(0, 0.1f * (float)(step % 5), 4), sl_v3(0, 0.02f * (float)(step % 3), 0));
    edit(method, SL_CHANGED_CAMERA);
}

static void when_the_eye_turns_only_what_is_not_diffuse_grows_old_and_is_shaded_again(void **state) {
    sl_scene *scene = two_walls(0.0f, 0.0f, 0.3f, 50.0f);
    sl_settings settings = loop_settings();
    settings.shading_cache.stop_size = 8.0;
    sl_method *method = created_method(scene, &settings);
    const sl_shading_state *s = inside_of(method);
    const sl_patches *p = s->patches;
    to_the_end(method);
    uint32_t before = s->now, renewed[2] = {0, 0};
    uint64_t changes = count_of(method, SL_COUNT_CHANGES_DETECTED);
    turn(scene, method, 1);
    for (uint32_t i = 0; i < p->patch_count; i++) {
        if (!sl_patch_is_alive(p, i) || !sl_patch_is_leaf(p, i) || p->patch[i].seen != before) continue;
        float still = sl_patch_priority(p, &s->curve, i, s->now + 5, 0, 0),
              turned = sl_patch_priority(p, &s->curve, i, s->now + 5, s->changes.eye_moved, 0);
        assert_true(sl_patch_root(p, i) < 2 ? turned == still : turned >= still + 5.0f);
    }
    to_the_end(method);
    for (size_t v = 0; v < p->vertex_count; v++) {
        if (p->vertex[v].references && p->vertex[v].evaluated > before) renewed[p->vertex[v].root / 2]++;
    }
    assert_true(renewed[1] > 20 && renewed[0] < 5); /* a few came into view */
    /* light towards another eye tells of no change */
    assert_int_equal(count_of(method, SL_COUNT_CHANGES_DETECTED), changes);
    destroy_method(method, scene);
}

/* ---- edits ----------------------------------------------------------------------------------- */

static void an_edit_that_changes_nothing_has_all_shaded_again_to_the_same_bits_and_finds_no_change(
    void **state) {
    sl_scene *scene = load_scene("scenes/cornell.json");
    sl_settings settings = loop_settings();
    settings.shading_cache.stop_size = 4.0;
    settings.shading_cache.area_samples = 16;
    settings.shading_cache.no_resolution_drop = true;
    sl_method *method = created_method(scene, &settings);
    to_the_end(method);
    uint64_t points = count_of(method, SL_COUNT_POINTS_SHADED);
    sl_image *before = resolved_picture(method);
    for (int i = 0; i < 3; i++) {
        edit(method, SL_CHANGED_LIGHTS | SL_CHANGED_OBJECTS | SL_CHANGED_CAMERA);
        to_the_end(method);
    }
    assert_true(count_of(method, SL_COUNT_POINTS_SHADED) > 3 * points);
    assert_int_equal(count_of(method, SL_COUNT_CHANGES_DETECTED), 0);
    sl_image *after = resolved_picture(method);
    assert_true(same_picture(before, after));
    destroy_pictures(before, after);
    destroy_method(method, scene);
}

static size_t visible_leaves(const sl_shading_state *s) {
    size_t leaves = 0;
    for (uint32_t i = 0; i < s->patches->patch_count; i++)
        leaves += sl_patch_is_alive(s->patches, i) && sl_patch_is_leaf(s->patches, i) &&
                  s->patches->patch[i].seen > 0;
    return leaves;
}

static void move_light(sl_scene *scene, float x) {
    scene->lights[0].position = sl_v3(x, 0.3f, 0.1f);
    scene->version++;
}

/* All is one object, and all of it changes: what is seen has no more leaves than there is time for, and is
 * the coarser the less time there is. */
static void after_a_change_there_are_no_more_leaves_than_can_be_shaded_in_time(void **state) {
    size_t left[2];
    for (int k = 0; k < 2; k++) {
        const double budget = k ? 60.0 : 240.0;
        sl_scene *scene = room();
        sl_settings settings = loop_settings();
        settings.shading_cache.stop_size = 2.0;
        settings.shading_cache.nominal_rate = 100.0;
        settings.shading_cache.clean_up_seconds = budget / 100.0;
        sl_method *method = created_method(scene, &settings);
        const sl_shading_state *s = inside_of(method);
        to_the_end(method);
        size_t before = visible_leaves(s);
        assert_true(before > 400);
        move_light(scene, -0.6f);
        edit(method, SL_CHANGED_LIGHTS);
        for (int i = 0; i < 50 && !count_of(method, SL_COUNT_CHANGES_DETECTED); i++) update(method);
        assert_true(count_of(method, SL_COUNT_CHANGES_DETECTED) > 0);
        left[k] = visible_leaves(s);
        assert_true((double)left[k] <= budget && left[k] > 10);
        to_the_end(method); /* which is not where all is fresh and coarse */
        assert_false(s->changes.object[0].changing);
        assert_true(visible_leaves(s) > before - before / 10);
        destroy_method(method, scene);
    }
    assert_true(left[1] < left[0]);
}

static bool is_full_size(const sl_shading_state *s, uint32_t patch, float share) {
    sl_patch_place place = sl_patch_place_of(s->patches, patch);
    float area = share * sl_patch_projected(s->patches, &place, &s->view).area;
    return area > 0.0f && area <= s->work.split_above;
}

/* Their corners were shaded anew before the split where they were not; that is no change, nor is the same
 * again after an edit that changes nothing. */
static void leaves_of_one_pixel_have_dense_points_on_the_lamp_at_all_corners_and_others_need_not(
    void **state) {
    sl_scene *scene = room_with(true);
    sl_settings settings = loop_settings();
    settings.shading_cache.area_samples = 16;
    sl_method *method = created_method(scene, &settings);
    const sl_shading_state *s = inside_of(method);
    for (int pass = 0; pass < 2; pass++) {
        size_t dense = 0, few = 0, full_size = 0;
        to_the_end(method);
        for (uint32_t i = 0; i < s->patches->patch_count; i++) {
            if (!sl_patch_is_alive(s->patches, i)) continue;
            sl_patch_place place = sl_patch_place_of(s->patches, i);
            uint32_t parent = sl_patch_parent(s->patches, i);
            bool full = sl_patch_is_leaf(s->patches, i) && is_full_size(s, i, 1.0f) &&
                        parent != SL_NO_INDEX && is_full_size(s, parent, 0.25f);
            for (int c = 0; c < place.corners; c++) {
                const sl_patch_vertex *v = &s->patches->vertex[sl_patch_corner(s->patches, i, c)];
                bool here = v->evaluated != SL_VERTEX_NEVER && !v->extrapolated;
                assert_true(!here || v->dense == v->is_dense);
                few += here && !v->dense;
                full_size += full && here;
                dense += full && here && v->is_dense;
            }
        }
        print_message("%zu corners of full-size leaves, %zu with dense points; %zu with few\n", full_size,
                      dense, few);
        assert_true(full_size > 1000 && dense == full_size && few > 0);
        assert_int_equal(count_of(method, SL_COUNT_CHANGES_DETECTED), 0);
        edit(method, SL_CHANGED_LIGHTS);
    }
    destroy_method(method, scene);
}

/* Both are refined until nothing is left to refine. */
static void after_a_change_all_becomes_what_it_is_from_a_cold_start(void **state) {
    sl_scene *scene = room();
    sl_settings settings = loop_settings(), path = small_settings("path", SIZE, SIZE);
    path.transport = "matched:shading-cache";
    path.shading_cache = settings.shading_cache;
    path.spp = 1;
    sl_method *warm = created_method(scene, &settings);
    to_the_end(warm);
    sl_image *image[3];
    image[0] = resolved_picture(warm);
    move_light(scene, -0.6f);
    edit(warm, SL_CHANGED_LIGHTS);
    to_the_end(warm);
    assert_true(count_of(warm, SL_COUNT_CHANGES_DETECTED) > 0);
    sl_method *cold = created_method(scene, &settings);
    to_the_end(cold);
    image[1] = resolved_picture(warm);
    image[2] = resolved_picture(cold);
    sl_image *truth = render(scene, &path, NULL);
    sl_comparison c[3];
    for (int i = 0; i < 3; i++) c[i] = comparison_of(image[i], truth);
    print_message("relRMSE: before %.3f %%, after the change %.3f %%, from a cold start %.3f %%\n",
                  100.0 * c[0].rel_rmse, 100.0 * c[1].rel_rmse, 100.0 * c[2].rel_rmse);
    assert_true(c[0].rel_rmse > 10.0 * c[2].rel_rmse &&
                fabs(c[1].rel_rmse - c[2].rel_rmse) < 0.02 * c[2].rel_rmse);
    for (int i = 0; i < 3; i++) sl_image_destroy(image[i]);
    sl_image_destroy(truth);
    sl_method_destroy(warm);
    destroy_method(cold, scene);
}

/* ---- memory ---------------------------------------------------------------------------------- */

static void patches_keep_to_their_limit_and_who_turns_back_within_the_window_finds_all_as_it_was(
    void **state) {
    for (int late = 0; late < 2; late++) {
        sl_scene *scene = room();
        sl_settings settings = loop_settings();
        settings.shading_cache.cache_limit = late ? 0.475 : 8.0;
        settings.shading_cache.stop_size = 2.0;
        settings.shading_cache.ageing_window = late ? 5 : 2000;
        sl_method *method = created_method(scene, &settings);
        const sl_shading_state *s = inside_of(method);
        const double limit =
            settings.shading_cache.cache_limit * ROOM_FOR + 2.0 * (double)s->primitives->count;
        to_the_end(method);
        sl_image *before = resolved_picture(method);
        look(scene, sl_v3(0, 0, 0), sl_v3(1, 0.3f, 0.9f));
        edit(method, SL_CHANGED_CAMERA);
        for (int i = 0; i < 60; i++) update(method);
        print_message("%zu patches, at most %.0f\n", s->patches->patches_alive, limit);
        if (late) assert_true((double)s->patches->patches_alive <= limit);
        assert_int_equal(count_of(method, SL_COUNT_PATCHES_EVICTED) > 0, late);
        uint64_t points = count_of(method, SL_COUNT_POINTS_SHADED);
        look(scene, sl_v3(0, 0, 0.9f), sl_v3(0, -0.2f, -1));
        edit(method, SL_CHANGED_CAMERA);
        assert_int_equal(to_the_end(method) == 1, !late);
        sl_image *after = resolved_picture(method);
        assert_int_equal(count_of(method, SL_COUNT_POINTS_SHADED) > points, late);
        if (!late) assert_true(same_picture(before, after));
        destroy_pictures(before, after);
        destroy_method(method, scene);
    }
}

/* One lamp of two changes, and only one of two walls shows it; the other has to be shaded again before that
 * is known. */
static sl_scene *two_walls_with_a_lamp_each(trace_mesh *mesh) {
    uint32_t wall = trace_mesh_diffuse(mesh, 0.5f);
    for (int i = 0; i < 2; i++) {
        float x = i ? 0.5f : -0.5f;
        trace_mesh_quad(mesh, sl_v3(x - 0.5f, -1, 0), sl_v3(1, 0, 0), sl_v3(0, 2, 0), wall);
        trace_mesh_point_light(mesh, sl_v3(x, 0.2f, 0.3f), sl_grey(1.0f));
    }
    trace_mesh_quad(mesh, sl_v3(0, -1, 0), sl_v3(0, 0, 0.9f), sl_v3(0, 2, 0), wall); /* between them */
    return before_the_eye(mesh);
}

static sl_method *with_one_lamp_changed(sl_scene *scene, int points) {
    sl_settings settings = loop_settings();
    settings.shading_cache.stop_size = 4.0;
    settings.shading_cache.change_window = 1;
    settings.shading_cache.no_resolution_drop = settings.shading_cache.no_flood = true;
    settings.shading_cache.points = points;
    sl_method *method = created_method(scene, &settings);
    to_the_end(method);
    scene->lights[0].intensity = sl_grey(3.0f);
    edit(method, SL_CHANGED_LIGHTS);
    return method;
}

/* Corners of visible leaves that were evaluated last before the change, and those that never were. */
static void count_corners(const sl_shading_state *s, size_t *before, size_t *never) {
    const sl_patches *p = s->patches;
    *before = *never = 0;
    for (size_t i = 0; i < s->leaf_count; i++) {
        uint32_t leaf = s->leaf[i].patch;
        if (!sl_patch_is_alive(p, leaf) || !sl_patch_is_leaf(p, leaf)) continue;
        for (int c = 0; c < sl_patch_corners(p, leaf); c++) {
            uint32_t evaluated = p->vertex[sl_patch_corner(p, leaf, c)].evaluated;
            *never += evaluated == SL_VERTEX_NEVER;
            *before += evaluated != SL_VERTEX_NEVER && evaluated < s->changes.object[0].stale_before;
        }
    }
}

/* Leaves that are new always have such corners. While a change lasts patches stay coarse: it would for good
 * where there is much to refine. */
static void a_change_ends_while_there_are_corners_that_were_never_evaluated(void **state) {
    trace_mesh mesh = trace_mesh_begin();
    sl_scene *scene = two_walls_with_a_lamp_each(&mesh);
    sl_method *method = with_one_lamp_changed(scene, 64);
    sl_shading_state *s = inside_of(method);
    s->settings.shading_cache.stop_size = 0.1; /* from here on there is */
    size_t before = 0, never = 0;
    for (bool changing = false, ended = false; !ended;) {
        assert_false(update(method));
        ended = changing && !s->changes.object[0].changing;
        changing = s->changes.object[0].changing;
        count_corners(s, &before, &never);
    }
    assert_true(before == 0 && never > 0);
    destroy_method(method, scene);
}

/* At the edges of shadows leaves of a pixel differ at their corners for good. As long as they were chosen all
 * the same the rest waited for a random pixel: 577 updates where the points fill 22. */
static void refinement_to_the_end_takes_few_more_updates_than_its_points_fill(void **state) {
    static const sl_pixel_selection how[] = {SL_PIXELS_HIT_AND_TEST, SL_PIXELS_SORTED};
    for (int lamp = 0; lamp < 2; lamp++) {
        for (int h = 0; h < 2; h++) {
            sl_scene *scene = room_with(lamp);
            sl_settings settings = loop_settings();
            settings.shading_cache.area_samples = 16;
            settings.shading_cache.selection = how[h];
            sl_method *method = created_method(scene, &settings);
            for (int pass = 0; pass < 2; pass++) {
                uint64_t before = count_of(method, SL_COUNT_POINTS_SHADED), updates = to_the_end(method),
                         points = count_of(method, SL_COUNT_POINTS_SHADED) - before;
                print_message("%d, %d, %d: %d updates, %d points\n", lamp, h, pass, (int)updates,
                              (int)points);
                assert_true(points > 1000 && updates <= 2 * points / 64 + 8);
                edit(method, SL_CHANGED_LIGHTS); /* nothing has moved: all is shaded again */
            }
            /* of what is seen of it nothing is left to do, but it is seen */
            sl_changes_begin(&inside_of(method)->changes, 0, 1000);
            assert_true(fabsf(sl_shading_coarsest(inside_of(method)) * 10000.0f - PIXELS) < 0.01f);
            destroy_method(method, scene);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(
            nothing_is_shaded_twice_in_a_scene_at_rest_and_no_more_points_than_there_are_vertices),
        cmocka_unit_test(pixels_of_patches_are_the_pictures_and_the_next_id_map_names_children),
        cmocka_unit_test(patches_that_are_not_seen_are_left_alone),
        cmocka_unit_test(a_textured_wall_in_even_light_is_exact_with_four_samples),
        cmocka_unit_test(when_the_eye_turns_only_what_is_not_diffuse_grows_old_and_is_shaded_again),
        cmocka_unit_test(
            an_edit_that_changes_nothing_has_all_shaded_again_to_the_same_bits_and_finds_no_change),
        cmocka_unit_test(after_a_change_there_are_no_more_leaves_than_can_be_shaded_in_time),
        cmocka_unit_test(
            leaves_of_one_pixel_have_dense_points_on_the_lamp_at_all_corners_and_others_need_not),
        cmocka_unit_test(after_a_change_all_becomes_what_it_is_from_a_cold_start),
        cmocka_unit_test(
            patches_keep_to_their_limit_and_who_turns_back_within_the_window_finds_all_as_it_was),
        cmocka_unit_test(
            some_pixels_are_chosen_at_random_some_by_floods_and_where_there_is_a_crowd_patches_are_split_twice_at_once),
        cmocka_unit_test(in_the_end_all_that_is_seen_is_of_the_stop_size_and_nothing_was_split_for_less),
        cmocka_unit_test(a_change_ends_while_there_are_corners_that_were_never_evaluated),
        cmocka_unit_test(refinement_to_the_end_takes_few_more_updates_than_its_points_fill),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
