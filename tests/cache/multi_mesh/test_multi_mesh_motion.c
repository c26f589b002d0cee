/* Lights and objects that move while updates go on: counters and pictures, no clocks. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "unit_test.h"
#include "base/math.h"
#include "base/sanitized.h"
#include "cache/light/moves.h"
#include "cache/multi_mesh/multi_mesh_internal.h"
#include "edited_room.h"
#include "rendering.h"
#include "scene/copy.h"

enum { SIDE = 40, PIXELS = SIDE * SIDE, MOVES = SL_SANITIZED ? 90 : 400 };

/* A box on the floor of a room slides about, and so does its lamp. */
static sl_scene *moving_room(void) {
    static const char cube[] = "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\n"
                               "v -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n"
                               "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 1 5 8 4\nf 2 3 7 6\n";
    return scene_from_text(
        "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\", \"name\": \"room\", \"material\": \"wall\"}, "
        "{\"file\": \"mesh.obj\", \"name\": \"box\", \"material\": \"box\", "
        "\"transform\": {\"scale\": 0.25}, "
        "\"keyframes\": [{\"time\": 0, \"translate\": [-0.6, -0.7, -0.5]}, {\"time\": 1, \"translate\": "
        "[0.6, -0.7, -0.4]}, {\"time\": 2, \"translate\": [0.1, 0, 0.3]}, {\"time\": 3, \"translate\": "
        "[-0.6, -0.7, -0.5]}]}], "
        "\"materials\": {\"wall\": {\"diffuse\": [0.7, 0.6, 0.5]}, \"box\": {\"diffuse\": [0.2, "
        "0.6, 0.3]}}, \"lights\": [{\"type\": \"quad\", \"corner\": [-0.2, 0.95, -0.2], \"edge1\": [0.4, 0, "
        "0], \"edge2\": [0, 0, 0.4], \"radiance\": 9}, {\"type\": \"point\", \"position\": [0.7, 0.5, 0.7], "
        "\"intensity\": 0.1, \"keyframes\": [{\"time\": 0, \"position\": [0.7, 0.5, 0.7]}, {\"time\": 3, "
        "\"position\": [0.7, 0.5, 0.7]}, {\"time\": 4, \"position\": [-0.7, 0.4, 0.6]}]}], \"camera\": "
        "{\"eye\": [0, 0, 0.98], \"target\": [0, 0, 0], \"fov_deg\": 80}}",
        cube);
}

static sl_settings mesh_settings(unsigned threads) {
    sl_settings s = small_settings("multi-mesh", SIDE, SIDE);
    s.filter = SL_FILTER_CENTRE;
    s.threads = threads;
    s.gather_size = 64;
    s.bounces = 2;
    return s;
}

/* An edit, and one update. */
static void move_to(sl_method *method, sl_scene *scene, double time) {
    go_to_time(scene, method, time);
    update(method);
}

static double difference(const sl_image *image, const sl_image *reference, const char *layer) {
    const float *a = sl_image_channel(image, layer), *b = sl_image_channel(reference, layer);
    double sum = 0.0, all = 0.0;
    for (int i = 0; i < PIXELS; i++) {
        sum += pow((double)a[i] - (double)b[i], 2.0);
        all += pow((double)b[i], 2.0);
    }
    return sqrt(sum / all);
}

/* Against pictures that begin with the scene as it is. */
static void look(sl_method *method, const sl_scene *scene, const sl_settings *settings, double most) {
    sl_image *seen = resolved_picture(method), *fresh = render(scene, settings, NULL);
    double all = difference(seen, fresh, "G"), direct = difference(seen, fresh, "direct.G");
    print_message("%.1f %% off, direct light %.1f %%\n", 100.0 * all, 100.0 * direct);
    assert_true(all < most && direct < most);
    destroy_pictures(seen, fresh);
}

/* Leaves that are seen, known to be too large or to have an edge that differs, and may be cut. */
static size_t leaves_to_be_cut(const sl_method *method) {
    const sl_multi_mesh_state *s = method->state;
    size_t count = 0;
    for (int i = 0; i < SL_COMPONENTS; i++) {
        const sl_displayed *d = s->part[i];
        for (uint32_t n = 0; d && n < d->mesh->patch_count; n++) {
            const sl_patch *node = &d->mesh->patch[n];
            if (!sl_patch_is_alive(d->mesh, n) || node->child != SL_NO_INDEX || !node->pixels) continue;
            sl_patch_place leaf = sl_patch_place_of(d->mesh, n);
            count += sl_needs_cut(node) && sl_may_split(d, &leaf);
        }
    }
    return count;
}

static void light_follows_four_hundred_moves_and_leaves_are_cut_all_the_while(void **state) {
    sl_scene *scene = moving_room();
    const sl_settings settings = mesh_settings(2);
    sl_method *method = created_method(scene, &settings);
    sl_image *still = finished_picture(method);
    const double light = channel_mean(still, "G");
    uint64_t splits = count_of(method, SL_COUNT_SPLITS), undone = count_of(method, SL_COUNT_COLLAPSES);
    for (int k = 1; k <= MOVES; k++) {
        move_to(method, scene, fmod(0.04 * k, 4.0));
        sl_image *seen = resolved_picture(method);
        assert_in_range((int)(100.0 * channel_mean(seen, "G") / light), 70, 140);
        sl_image_destroy(seen);
        if (k % 10 == 0) {
            assert_true(count_of(method, SL_COUNT_SPLITS) > splits || leaves_to_be_cut(method) == 0);
            splits = count_of(method, SL_COUNT_SPLITS);
        }
        if (k % 45 == 0) look(method, scene, &settings, 0.10);
    }
    assert_true(count_of(method, SL_COUNT_COLLAPSES) > undone);
    sl_image_destroy(still);
    destroy_method(method, scene);
}

static void pictures_in_motion_have_the_same_bits_with_any_threads(void **state) {
    sl_scene *scene[2] = {moving_room(), moving_room()};
    sl_method *method[2];
    for (int i = 0; i < 2; i++) {
        const sl_settings settings = mesh_settings(i ? 3 : 1);
        method[i] = created_method(scene[i], &settings);
    }
    for (int k = 0; k < 60; k++) {
        sl_image *seen[2];
        for (int i = 0; i < 2; i++) {
            if (k < 20) update(method[i]);
            else move_to(method[i], scene[i], 2.0 + 0.05 * (k - 20));
            seen[i] = resolved_picture(method[i]);
        }
        assert_true(same_picture(seen[0], seen[1]));
        for (int i = 0; i < 2; i++) sl_image_destroy(seen[i]);
    }
    for (int i = 0; i < 2; i++) {
        destroy_method(method[i], scene[i]);
    }
}

static void after_edits_that_undo_each_other_a_picture_is_as_good_as_a_fresh_one(void **state) {
    sl_scene *scene = moving_room();
    const sl_settings settings = mesh_settings(2);
    sl_settings truth = small_settings("path", SIDE, SIDE);
    truth.transport = "matched:multi-mesh";
    truth.bounces = settings.bounces;
    truth.filter = SL_FILTER_CENTRE;
    truth.spp = 256;
    sl_method *method = created_method(scene, &settings);
    for (int k = 0; k < 31; k++) move_to(method, scene, k % 2 ? 1.0 : 3.7);
    sl_image *seen = finished_picture(method), *fresh = render(scene, &settings, NULL),
             *reference = render(scene, &truth, NULL);
    double ours = difference(seen, reference, "G"), theirs = difference(fresh, reference, "G");
    print_message("%.2f %%, a fresh one %.2f %%\n", 100.0 * ours, 100.0 * theirs);
    assert_true(ours < 1.1 * theirs);
    destroy_pictures(seen, fresh);
    sl_image_destroy(reference);
    destroy_method(method, scene);
}

/* ---- samples that survive ---- */

static sl_multi_mesh_state *state_of(const sl_scene *scene, sl_settings settings) {
    sl_transport transport;
    void *state;
    sl_multi_mesh_complete(&settings);
    sl_multi_mesh_transport(&settings, &transport);
    assert_int_equal(sl_multi_mesh_method.create(scene, &settings, &transport, &state, NULL), SL_OK);
    return state;
}

static void update_to_the_end(sl_multi_mesh_state *s) {
    for (sl_progress p = {0}; !p.done;) assert_int_equal(sl_multi_mesh_method.update(s, &p, NULL), SL_OK);
}

static size_t known_alike(const sl_patches *ours, const sl_patches *fresh) {
    size_t alike = 0;
    for (uint32_t v = 0; v < fresh->vertex_count; v++) {
        uint32_t own = sl_vertex_find(ours, fresh->vertex[v].place);
        if (sl_mesh_state(fresh, v) != SL_VERTEX_KNOWN || !sl_mesh_is_sampled(ours, own)) continue;
        assert_int_equal(sl_mesh_state(ours, own), SL_VERTEX_KNOWN);
        assert_true(*sl_vertex_value(ours, own) == *sl_vertex_value(fresh, v));
        alike++;
    }
    return alike;
}

/* The light samples of the coarse mesh, and its colours with all bounces. */
static void assert_same_coarse(const sl_multi_mesh_state *s, const sl_multi_mesh_state *fresh) {
    const sl_patches *a = s->whole.coarse->vertices, *b = fresh->whole.coarse->vertices;
    assert_int_equal(s->kept.count, fresh->kept.count);
    for (size_t i = 0; i < s->kept.count * s->now.lights->count; i++) {
        const sl_coarse_share mine = s->kept.share[i], its = fresh->kept.share[i];
        if (its.by) assert_true(mine.by == its.by && sl_float_bits(mine.share) == sl_float_bits(its.share));
    }
    assert_int_equal(a->vertex_count, b->vertex_count);
    assert_memory_equal(a->value, b->value, 3 * a->vertex_count * sizeof *a->value);
}

static void samples_that_survive_a_move_are_those_of_a_fresh_method(void **state) {
    sl_scene *scene = moving_room();
    sl_multi_mesh_state *s = state_of(scene, mesh_settings(2));
    update_to_the_end(s);
    for (int k = 1; k <= 6; k++) {
        unsigned changes;
        assert_int_equal(sl_scene_set_time(scene, 0.3 * k, &changes, NULL), SL_OK);
        uint64_t before = s->counters.value[SL_COUNT_LIGHT_SAMPLES];
        assert_int_equal(sl_multi_mesh_method.edit(s, changes, NULL), SL_OK);
        assert_int_equal(s->counters.value[SL_COUNT_LIGHT_SAMPLES], before);
        sl_multi_mesh_state *fresh = state_of(scene, mesh_settings(2));
        update_to_the_end(fresh);
        size_t kept = 0;
        for (size_t l = 0; l < 2; l++)
            kept += known_alike(sl_irradiance_mesh(s->irradiance, l),
                                sl_irradiance_mesh(fresh->irradiance, l));
        print_message("%zu samples have survived\n", kept);
        assert_true(kept > 100);
        update_to_the_end(s);
        assert_same_coarse(s, fresh);
        sl_multi_mesh_method.destroy(fresh);
    }
    sl_multi_mesh_method.destroy(s);
    sl_scene_destroy(scene);
}

static size_t known_samples(const sl_multi_mesh_state *s) {
    size_t known = 0;
    for (size_t l = 0; l < s->now.lights->count; l++) {
        const sl_patches *mesh = sl_irradiance_mesh(s->irradiance, l);
        for (uint32_t v = 0; v < mesh->vertex_count; v++) known += sl_mesh_state(mesh, v) == SL_VERTEX_KNOWN;
    }
    return known;
}

static void change_colours(sl_scene *scene) {
    sl_scene_edit *edit;
    sl_material_data wall;
    const float strength[3] = {0.02f, 0.3f, 0.1f};
    uint32_t number = sl_scene_find_material(scene, "wall");
    assert_true(sl_scene_material(scene, number, &wall));
    wall.diffuse[0] = 0.2f;
    assert_int_equal(sl_scene_edit_begin(scene, &edit, NULL), SL_OK);
    assert_int_equal(sl_edit_material(edit, number, &wall, NULL), SL_OK);
    assert_int_equal(sl_edit_light(edit, 1, strength, NULL, NULL, NULL), SL_OK);
    assert_int_equal(sl_scene_edit_commit(edit, NULL, NULL), SL_OK);
}

static void a_lamps_power_and_a_walls_colour_change_no_sample_and_show_at_once(void **state) {
    sl_scene *scene = moving_room();
    const sl_settings settings = mesh_settings(2);
    sl_method *method = created_method(scene, &settings);
    run_to_end(method);
    const size_t known = known_samples(method->state);
    change_colours(scene);
    assert_int_equal(sl_method_edit(method, 0, NULL), SL_OK);
    assert_int_equal(known_samples(method->state), known);
    update(method);
    sl_image *seen = resolved_picture(method), *fresh = render(scene, &settings, NULL);
    print_message("direct light %.2f %% off\n", 100.0 * difference(seen, fresh, "direct.G"));
    assert_true(difference(seen, fresh, "direct.G") < 0.08);
    destroy_pictures(seen, fresh);
    destroy_method(method, scene);
}

/* The coarse mesh of a picture at rest has more vertices than all these updates ask for light at. */
static void indirect_light_does_not_wait_for_a_fine_coarse_mesh_while_things_move(void **state) {
    (void)state;
    sl_scene *scene = moving_room();
    sl_settings settings = mesh_settings(2);
    settings.multi_mesh.coarse_edge = 0.05;
    settings.multi_mesh.coarse_depth = 6;
    sl_method *method = created_method(scene, &settings);
    for (int i = 1; i <= 12; i++) move_to(method, scene, 0.04 * i);
    assert_true(sl_method_counters(method)->value[SL_COUNT_INDIRECT_SAMPLES] > 0);
    sl_image *image = finished_picture(method), *reference = render(scene, &settings, NULL);
    assert_true(difference(image, reference, "indirect.G") < 0.05);
    destroy_pictures(image, reference);
    destroy_method(method, scene);
}

static sl_scene *room_with_a_carried_lamp(void) {
    return scene_from_text(
        "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\", \"material\": \"wall\"}], \"materials\": "
        "{\"wall\": {\"diffuse\": 0.7}}, \"lights\": [{\"type\": \"point\", \"position\": [-0.8, 0.6, 0], "
        "\"intensity\": 0.1, \"keyframes\": [{\"time\": 0, \"position\": [-0.8, 0.6, 0]}, {\"time\": 1, "
        "\"position\": [0.8, 0.6, 0]}]}], \"camera\": {\"eye\": [0, 0, 0.98], \"target\": [0, 0, 0], "
        "\"fov_deg\": 80}}",
        "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n"
        "f 1 2 3 4\nf 5 8 7 6\nf 1 5 6 2\nf 3 7 8 4\nf 1 4 8 5\nf 2 6 7 3\n");
}

/* Three updates a frame: a still picture's coarse mesh could be begun in each, and done in none. */
static void indirect_light_keeps_up_with_a_lamp_that_is_carried(void **state) {
    (void)state;
    sl_scene *scene = room_with_a_carried_lamp();
    sl_settings settings = mesh_settings(2);
    settings.bounces = 9;
    sl_method *method = created_method(scene, &settings);
    run_to_end(method);
    for (int i = 1; i <= 20; i++) {
        move_to(method, scene, 0.05 * i);
        for (int k = 0; k < 2; k++) update(method);
    }
    sl_image *image = resolved_picture(method), *fresh = render(scene, &settings, NULL);
    print_message("indirect light %.2f %% off\n", 100.0 * difference(image, fresh, "indirect.G"));
    assert_true(difference(image, fresh, "indirect.G") < 0.13);
    destroy_pictures(image, fresh);
    destroy_method(method, scene);
}

/* Its vertices are more than an update lights; those of the box stand for a sixteenth of the wall's areas. */
static void of_the_coarse_mesh_what_is_large_is_lit_first(void **state) {
    sl_scene *scene = moving_room();
    sl_settings settings = mesh_settings(2);
    sl_method *method = created_method(scene, &settings);
    const sl_coarse_rounds *r = &((const sl_multi_mesh_state *)method->state)->whole;
    for (int i = 1; i <= 40 && !r->rolls; i++) move_to(method, scene, 0.04 * i);
    assert_true(r->rolls && r->updates == 1);
    float least = INFINITY, most = 0.0f;
    for (size_t v = 0; v < r->coarse->vertex_count; v++) {
        if (r->lit_in[v]) least = fminf(least, r->area[v]);
        else most = fmaxf(most, r->area[v]);
    }
    print_message("lit: areas from %g; not yet: to %g\n", (double)least, (double)most);
    assert_true(most > 0.0f && least >= most);
    destroy_method(method, scene);
}

static void while_something_moves_an_update_cuts_until_nothing_large_is_coarse(void **state) {
    sl_scene *scene = moving_room();
    sl_settings settings = mesh_settings(2);
    settings.multi_mesh.batch = 1;
    sl_method *method = created_method(scene, &settings);
    uint64_t most = 0, before = 0;
    for (int i = 1; i <= 20; i++) {
        move_to(method, scene, 0.04 * i);
        const uint64_t splits = sl_method_counters(method)->value[SL_COUNT_SPLITS];
        most = splits - before > most ? splits - before : most;
        before = splits;
    }
    assert_true(most > 8);
    destroy_method(method, scene);
}

static void carry_light(sl_method *method, sl_scene *scene, edited_room *room, bool paint) {
    sl_scene_edit *edit;
    room->place[0][0] += 0.02;
    assert_int_equal(sl_scene_edit_begin(scene, &edit, NULL), SL_OK);
    assert_int_equal(sl_edit_light(edit, 1, NULL, room->place[0], NULL, NULL), SL_OK);
    if (paint) assert_int_equal(sl_edit_material(edit, MATERIAL_WALL, &room->material[0], NULL), SL_OK);
    assert_int_equal(sl_scene_edit_commit(edit, NULL, NULL), SL_OK);
    assert_int_equal(sl_method_edit(method, 0, NULL), SL_OK);
    update(method);
}

static double sum_of_reflectances(const sl_method *method) {
    const sl_multi_mesh_state *s = method->state;
    double sum = 0.0;
    assert_true(s->whole.coarse && s->whole.rolls && s->whole.coarse->reflectance);
    for (size_t t = SL_COARSE_FIRST; t < s->whole.coarse->triangle_count; t++)
        sum += (double)sl_rgb_mean(s->whole.coarse->reflectance[t]);
    return sum;
}

static void gathers_see_a_texture_that_gets_another_colour_while_things_move(void **state) {
    (void)state;
    edited_room room = room_at_first(1);
    sl_scene *scene;
    sl_settings settings = mesh_settings(1);
    room.material[0].texture = 1;
    assert_int_equal(build_room(&room, &scene, NULL), SL_OK);
    sl_method *method = created_method(scene, &settings);
    run_to_end(method);
    for (int i = 0; i < 3; i++) carry_light(method, scene, &room, false);
    const double before = sum_of_reflectances(method);
    for (int c = 0; c < 3; c++) room.material[0].diffuse[c] *= 0.5f;
    carry_light(method, scene, &room, true);
    assert_true(sum_of_reflectances(method) < 0.95 * before);
    destroy_method(method, scene);
}

/* A wall by so many lamps that an update lights few vertices. */
static sl_scene *wall_by_lamps(int lamps) {
    char *json;
    size_t size;
    FILE *out = open_memstream(&json, &size);
    fputs("{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\"}], \"lights\": [", out);
    for (int i = 0; i < lamps; i++)
        fprintf(out, "%s{\"type\": \"point\", \"position\": [%g, 0.5, 0.4], \"intensity\": 0.01}",
                i ? ", " : "", 1.6 * i / lamps - 0.8);
    fputs("], \"camera\": {\"eye\": [0, 0, 0.98], \"target\": [0, 0, 0], \"fov_deg\": 80, \"keyframes\": "
          "[{\"time\": 0, \"eye\": [0, 0, 0.98]}, {\"time\": 1, \"eye\": [0.4, 0, 0.9]}]}}", out);
    fclose(out);
    sl_scene *scene = scene_from_text(json, "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n");
    free(json);
    return scene;
}

static void where_the_eye_walks_from_the_start_light_is_shown_before_all_roots_have_some(void **state) {
    sl_scene *scene = wall_by_lamps(4000), *copy;
    const sl_settings settings = mesh_settings(2);
    sl_method *method = created_method(scene, &settings);
    const sl_window_class *class = method->class->window;
    void *window;
    uint64_t versions;
    sl_counters counters = {{0}};
    assert_int_equal(sl_scene_copy(scene, &copy, NULL), SL_OK);
    assert_int_equal(class->create(method->state, copy, 1, &window, NULL), SL_OK);
    update(method);
    move_to(method, scene, 0.1);
    assert_int_equal(((sl_multi_mesh_state *)method->state)->phase, SL_PHASE_FIRST);
    sl_image *image = blank_image(SIDE, SIDE, 3);
    assert_int_equal(class->draw(window, image, &versions, &counters, NULL), SL_OK);
    double sum = 0.0;
    for (size_t i = 0; i < 3 * PIXELS; i++) sum += (double)image->planes[i];
    assert_true(sum > 0.0 && isfinite(sum));
    sl_image_destroy(image);
    class->destroy(window);
    sl_method_destroy(method);
    sl_scene_copy_destroy(copy);
    sl_scene_destroy(scene);
}

static sl_image *drawn_by(const sl_window_class *class, void *window) {
    sl_image *image = blank_image(SIDE, SIDE, 3);
    uint64_t versions;
    sl_counters counters = {{0}};
    assert_int_equal(class->draw(window, image, &versions, &counters, NULL), SL_OK);
    assert_true(versions > 0);
    return image;
}

static void leaves_kept_from_frame_to_frame_show_what_a_new_window_shows(void **state) {
    sl_scene *scene = moving_room(), *copy;
    const sl_settings settings = mesh_settings(2);
    sl_method *method = created_method(scene, &settings);
    const sl_window_class *class = method->class->window;
    void *window, *other;
    assert_int_equal(sl_scene_copy(scene, &copy, NULL), SL_OK);
    assert_int_equal(class->create(method->state, copy, 2, &window, NULL), SL_OK);
    while (!update(method)) {}
    for (int k = 0; k < 12; k++) {
        if (k % 3 == 2) move_to(method, scene, 3.0 + 0.08 * k); /* the lamp alone */
        assert_true(sl_camera_look_at(&copy->camera, sl_v3(0.04f * (float)k, 0.0f, 0.98f),
                                      sl_v3(0.0f, 0.0f, 0.0f), sl_v3(0.0f, 1.0f, 0.0f), 1.4f));
        assert_int_equal(class->move(window, NULL), SL_OK);
        assert_int_equal(class->create(method->state, copy, 2, &other, NULL), SL_OK);
        sl_image *seen = drawn_by(class, window), *fresh = drawn_by(class, other);
        assert_true(same_picture(seen, fresh));
        destroy_pictures(seen, fresh);
        class->destroy(other);
    }
    class->destroy(window);
    sl_method_destroy(method);
    sl_scene_copy_destroy(copy);
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(light_follows_four_hundred_moves_and_leaves_are_cut_all_the_while),
        cmocka_unit_test(pictures_in_motion_have_the_same_bits_with_any_threads),
        cmocka_unit_test(after_edits_that_undo_each_other_a_picture_is_as_good_as_a_fresh_one),
        cmocka_unit_test(samples_that_survive_a_move_are_those_of_a_fresh_method),
        cmocka_unit_test(a_lamps_power_and_a_walls_colour_change_no_sample_and_show_at_once),
        cmocka_unit_test(indirect_light_does_not_wait_for_a_fine_coarse_mesh_while_things_move),
        cmocka_unit_test(indirect_light_keeps_up_with_a_lamp_that_is_carried),
        cmocka_unit_test(of_the_coarse_mesh_what_is_large_is_lit_first),
        cmocka_unit_test(while_something_moves_an_update_cuts_until_nothing_large_is_coarse),
        cmocka_unit_test(gathers_see_a_texture_that_gets_another_colour_while_things_move),
        cmocka_unit_test(where_the_eye_walks_from_the_start_light_is_shown_before_all_roots_have_some),
        cmocka_unit_test(leaves_kept_from_frame_to_frame_show_what_a_new_window_shows),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
