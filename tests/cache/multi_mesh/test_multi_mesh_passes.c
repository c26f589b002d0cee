/* The passes of a picture from within: what each leaves behind, which are left out, in which order meshes are
 * served, what stays when the eye moves. */
#include <math.h>
#include <stdio.h>

#include "unit_test.h"
#include "cache/multi_mesh/multi_mesh_internal.h"
#include "rendering.h"
#include "scene/ambient.h"

typedef struct run {
    sl_scene *scene;
    sl_multi_mesh_state *s;
    bool done;
} run;

/* Takes the scene. */
static run run_in_quality(sl_scene *scene, int size, sl_quality quality) {
    run r = {.scene = scene};
    sl_settings settings = small_settings("multi-mesh", size, size);
    sl_transport transport;
    void *state;
    settings.quality = quality;
    sl_multi_mesh_complete(&settings);
    sl_multi_mesh_transport(&settings, &transport);
    assert_int_equal(sl_multi_mesh_method.create(scene, &settings, &transport, &state, NULL), SL_OK);
    r.s = state;
    return r;
}

static run run_of(sl_scene *scene, int size) { return run_in_quality(scene, size, SL_QUALITY_DRAFT); }

static void step(run *r) {
    sl_progress progress = {0};
    assert_int_equal(sl_multi_mesh_method.update(r->s, &progress, NULL), SL_OK);
    r->done = progress.done;
}

static void finish(run *r) {
    do step(r);
    while (!r->done);
}

static void discard(run *r) {
    sl_multi_mesh_method.destroy(r->s);
    sl_scene_destroy(r->scene);
}

static void look_from(run *r, float x) {
    assert_int_equal(sl_scene_set_camera(r->scene, (float[]){278 + x, 273, -800}, (float[]){278, 273, 0},
                                         (float[]){0, 1, 0}, 0.686f, NULL),
                     SL_OK);
    assert_int_equal(sl_multi_mesh_method.edit(r->s, SL_CHANGED_CAMERA, NULL), SL_OK);
}

/* ---- materials and merge ---- */

static void assert_rgb(const float *const planes[3], size_t i, sl_rgb expected) {
    assert_true(planes[0][i] == expected.r && planes[1][i] == expected.g && planes[2][i] == expected.b);
}

/* Both targets hold what the material of each pixel's triangle says; lamps' fronts their radiance. */
static void materials_are_those_of_each_pixels_triangle(void **state) {
    run r = run_of(load_scene("scenes/cornell-glossy.json"), 48);
    step(&r);
    const sl_materials_seen *m = &r.s->materials;
    size_t glossy = 0, lamp = 0;
    for (size_t i = 0; i < 48 * 48; i++) {
        uint32_t t = r.s->id[i];
        sl_rgb none = {0, 0, 0};
        const sl_material *material =
            t == SL_NO_INDEX ? NULL : &r.scene->materials[r.scene->material_index[t]];
        assert_rgb((const float *const *)m->diffuse, i, material ? material->diffuse : none);
        assert_rgb((const float *const *)m->specular, i, material ? material->specular : none);
        assert_rgb((const float *const *)m->emission, i, material ? material->emission : none);
        glossy += material && sl_material_is_glossy(material);
        lamp += material && sl_material_is_emitter(material);
    }
    assert_true(glossy > 0 && lamp > 0);
    discard(&r);
}

/* ---- from the first picture on ---- */

/* rho Phi / A until the coarse mesh is whole; then meshes take turns, the one with the highest priority
 * first, so that their maxima fall together: as long as either has leaves that are worth more than a
 * hundredth of what was at first, neither is left more than four times as high as the other. */
static void meshes_are_served_so_that_their_largest_priorities_fall_together(void **state) {
    run r = run_of(load_scene("scenes/cornell.json"), 96);
    r.s->settings.multi_mesh.batch = 4; /* leaves between two looks */
    step(&r);
    step(&r);
    sl_image *first = NULL;
    assert_int_equal(sl_multi_mesh_method.resolve(r.s, &first, NULL), SL_OK);
    sl_rgb ambient = sl_ambient_irradiance(r.scene);
    for (size_t i = 0; i < 96 * 96; i++)
        if (r.s->materials.diffuse[0][i] > 0.0f) assert_true(r.s->planes[SL_INDIRECT][0][i] == ambient.r);
    sl_image_destroy(first);
    float top = 0.0f;
    int together = 0, apart = 0;
    while (!r.done) {
        step(&r);
        if (!r.s->whole.coarse || r.s->phase != SL_PHASE_REFINE) continue;
        float a = sl_displayed_priority(r.s->part[SL_DIRECT_DIFFUSE]),
              b = sl_displayed_priority(r.s->part[SL_INDIRECT]);
        float high = fmaxf(a, b), low = fminf(a, b);
        top = fmaxf(top, high);
        if (high < 0.01f * top || low <= 0.0f) continue;
        if (high <= 4.0f * low) together++;
        else apart++;
    }
    print_message("%d updates with largest priorities within a factor of four, %d without\n", together,
                  apart);
    assert_true(together > 20);
    assert_true(4 * apart < together);
    discard(&r);
}

/* ---- the eye moves ---- */

static size_t known_in(const sl_patches *mesh) {
    size_t count = 0;
    for (uint32_t v = 0; v < mesh->vertex_count; v++) count += sl_mesh_state(mesh, v) == SL_VERTEX_KNOWN;
    return count;
}

static void after_a_step_of_the_eye_specular_radiance_starts_from_its_roots_and_the_rest_stays(void **state) {
    run r = run_of(load_scene("scenes/cornell-glossy.json"), 64);
    finish(&r);
    const sl_patches *specular = r.s->part[SL_DIRECT_SPECULAR]->mesh,
                  *direct = r.s->part[SL_DIRECT_DIFFUSE]->mesh, *indirect = r.s->part[SL_INDIRECT]->mesh;
    size_t leaves = direct->leaves_alive, roots = direct->root_count, known = known_in(direct),
           gathered = known_in(indirect);
    assert_true(specular->leaves_alive > specular->root_count);
    look_from(&r, 20.0f);
    step(&r); /* the view, the roots, and a batch of leaves */
    size_t served = 3 * (size_t)r.s->settings.multi_mesh.batch;
    assert_true(specular->root_count > 0);
    assert_in_range(specular->leaves_alive, specular->root_count, specular->root_count + served);
    assert_true(direct->leaves_alive + served >= leaves + direct->root_count - roots);
    assert_true(known_in(direct) >= known);
    assert_true(known_in(indirect) >= gathered);
    finish(&r);
    discard(&r);
}

/* ---- passes that are left out ---- */

static const char square_obj[] = "usemtl floor\nv -4 0 -4\nv -4 0 4\nv 4 0 4\nv 4 0 -4\nf 1 2 3 4\n";

static run run_of_floor(const char *material, const char *lights) {
    char json[512];
    snprintf(json, sizeof json,
             "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\"}], \"materials\": {\"floor\": {%s}}, "
             "\"lights\": [%s], \"camera\": {\"eye\": [0, 3, 5], "
             "\"target\": [0, 0, 0], \"fov_deg\": 40}}",
             material, lights);
    run r = run_of(scene_from_text(json, square_obj), 24);
    finish(&r);
    return r;
}

static void what_a_scene_has_no_use_for_is_not_done(void **state) {
    static const char point[] = "{\"type\": \"point\", \"position\": [0, 2, 0], \"intensity\": 5}";
    /* nothing is diffuse */
    run r = run_of_floor("\"diffuse\": 0, \"specular\": 0.5, \"exponent\": 20", point);
    assert_null(r.s->part[SL_DIRECT_DIFFUSE]);
    assert_null(r.s->part[SL_INDIRECT]);
    assert_null(r.s->next.coarse);
    assert_null(r.s->materials.emission[0]);
    assert_true(r.s->counters.value[SL_COUNT_LIGHT_SAMPLES] > 0);
    assert_int_equal(r.s->counters.value[SL_COUNT_COARSE_SAMPLES], 0);
    assert_int_equal(r.s->counters.value[SL_COUNT_INDIRECT_SAMPLES], 0);
    discard(&r);
    r = run_of_floor("\"diffuse\": 0", point); /* nothing reflects: all is black */
    for (int k = 0; k < SL_COMPONENTS; k++) assert_null(r.s->part[k]);
    assert_int_equal(r.s->counters.value[SL_COUNT_LIGHT_SAMPLES], 0);
    discard(&r);
    r = run_of_floor("\"diffuse\": 0.5", point); /* nothing is glossy, no lamp is to be seen */
    assert_null(r.s->part[SL_DIRECT_SPECULAR]);
    assert_null(r.s->materials.specular[0]);
    assert_null(r.s->materials.emission[0]);
    assert_non_null(r.s->part[SL_INDIRECT]);
    discard(&r);
}

static run run_of_text(const char *obj, const char *materials, const char *lights, const char *target) {
    char json[768];
    snprintf(json, sizeof json,
             "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\"}], \"materials\": {%s}, \"lights\": "
             "[%s], \"camera\": {\"eye\": [0, 3, 5], "
             "\"target\": [%s], \"fov_deg\": 40}}",
             materials, lights, target);
    run r = run_of(scene_from_text(json, obj), 24);
    finish(&r);
    return r;
}

/* Light may fall on nothing because of where lamps look, or because something black stands before them; or
 * nothing diffuse is seen. */
static void where_no_light_falls_nothing_is_gathered(void **state) {
    static const char grey[] = "\"floor\": {\"diffuse\": 0.5}, \"black\": {\"diffuse\": 0}",
                      lamp[] = "{\"type\": \"quad\", \"corner\": [-1, 2, -1], "
                               "\"edge1\": [2, 0, 0], \"edge2\": [0, 0, 2], \"radiance\": 1}",
                      turned[] = "{\"type\": \"quad\", \"corner\": [-1, 2, -1], \"edge1\": [0, 0, 2], "
                                 "\"edge2\": [2, 0, 0], \"radiance\": 1}",
                      open_obj[] = "usemtl floor\nv -4 0 -4\nv -4 0 4\nv 4 0 4\nv 4 0 -4\nf 1 2 3 4\nusemtl "
                                   "black\nv -9 -1 -9\nv -9 -1 9\nv 9 -1 9\nv 9 -1 -9\nf 5 6 7 8\n",
                      covered_obj[] =
                          "usemtl floor\nv -7 0 -7\nv -7 0 7\nv 7 0 7\nv 7 0 -7\nf 1 2 3 4\nusemtl black\nv "
                          "-5 1.9 -5\nv -5 1.9 5\nv 5 1.9 5\nv 5 1.9 -5\nf 5 6 7 8\n";
    struct {
        const char *obj, *light, *target;
        bool coarse, gathers;
    } cases[] = {{open_obj, lamp, "0, 0, 0", true, true},          /* the lamp lights the floor */
                 {open_obj, turned, "0, 0, 0", true, false},       /* it shines away from it */
                 {covered_obj, lamp, "0, 2.5, 0", false, false},     /* nothing diffuse is seen */
                 /* all of its light falls on what is black */
                 {covered_obj, lamp, "0, 0, 5.8", true, false}};
    for (int k = 0; k < 4; k++) {
        run r = run_of_text(cases[k].obj, grey, cases[k].light, cases[k].target);
        const uint64_t *count = r.s->counters.value;
        print_message("%d: %llu coarse samples, %llu gathers\n", k,
                      (unsigned long long)count[SL_COUNT_COARSE_SAMPLES],
                      (unsigned long long)count[SL_COUNT_INDIRECT_SAMPLES]);
        assert_true((count[SL_COUNT_COARSE_SAMPLES] > 0) == cases[k].coarse);
        assert_true((count[SL_COUNT_INDIRECT_SAMPLES] > 0) == cases[k].gathers);
        sl_image *image = NULL;
        assert_int_equal(sl_multi_mesh_method.resolve(r.s, &image, NULL), SL_OK);
        const float *indirect = sl_image_channel(image, "indirect.G");
        for (int i = 0; i < 24 * 24 && !cases[k].gathers; i++) assert_true(indirect[i] == 0.0f);
        sl_image_destroy(image);
        discard(&r);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(materials_are_those_of_each_pixels_triangle),
        cmocka_unit_test(meshes_are_served_so_that_their_largest_priorities_fall_together),
        cmocka_unit_test(after_a_step_of_the_eye_specular_radiance_starts_from_its_roots_and_the_rest_stays),
        cmocka_unit_test(what_a_scene_has_no_use_for_is_not_done),
        cmocka_unit_test(where_no_light_falls_nothing_is_gathered),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
