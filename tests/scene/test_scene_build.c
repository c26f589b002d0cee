/* Building a scene from arrays: what is repaired, with which warning, and what is refused. */
#include <math.h>
#include <string.h>

#include "unit_test.h"
#include "scene/features.h"
#include "scene/scene.h"
#include "rendering.h"
#include "scene_parts.h"

static const float square[12] = {0, 0, 0, 2, 0, 0, 2, 2, 0, 0, 2, 0};
static const uint32_t two[6] = {0, 1, 2, 0, 2, 3};
static const sl_material grey = {
    .diffuse = {0.5f, 0.5f, 0.5f}, .texture = SL_NO_INDEX, .alpha_texture = SL_NO_INDEX};

static sl_scene_parts square_parts(void) {
    return (sl_scene_parts){.vertex_count = 4, .positions = square, .triangle_count = 2, .indices = two};
}

static void refuse(const sl_scene_parts *parts, const char *because) {
    sl_scene *scene = (sl_scene *)&refuse;
    sl_error error = {0};
    assert_int_equal(sl_scene_build(parts, &scene, &error), SL_ERROR_INPUT);
    assert_null(scene);
    if (!strstr(error.message, because)) fail_msg("expected '%s' in '%s'", because, error.message);
}

static void facets_without_normals_stay_facets(void **state) {
    /* a corner: three facets at right angles */
    static const float roof[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    static const uint32_t faces[9] = {0, 1, 2, 0, 2, 3, 0, 3, 1};
    sl_scene_parts parts = {.vertex_count = 4, .positions = roof, .triangle_count = 3, .indices = faces};
    sl_scene *s = scene_built(&parts);
    assert_int_equal(s->vertex_count, 9);
    for (uint32_t t = 0; t < 3; t++) {
        for (int c = 0; c < 3; c++) {
            sl_vec3 n = sl_scene_normal(s, s->vertex[c][t]), g = sl_scene_geometric_normal(s, t);
            assert_memory_equal(&n, &g, sizeof n);
        }
    }
    sl_scene_destroy(s);
}

static void given_normals_are_made_unit_and_bad_ones_replaced(void **state) {
    const float normals[12] = {0, 0, 5, 0, 0, 0, NAN, 0, 1, 1e30f, 0, 1e30f};
    sl_scene_parts parts = square_parts();
    parts.normals = normals;
    sl_scene *s = scene_built(&parts);
    for (size_t v = 0; v < s->vertex_count; v++) {
        sl_vec3 n = sl_scene_normal(s, (uint32_t)v);
        assert_true(fabs((double)sl_dot(n, n) - 1.0) < 1e-6);
    }
    assert_true(s->normal_z[s->vertex[0][0]] == 1.0f);
    assert_true(s->normal_z[s->vertex[1][0]] == 1.0f);
    assert_true(fabsf(s->normal_x[s->vertex[2][1]] - sqrtf(0.5f)) < 1e-6f);
    sl_scene_destroy(s);
}

static void triangles_that_cannot_be_drawn_are_dropped_and_counted(void **state) {
    const float positions[21] = {0, 0, 0, 1, 0, 0, 0, 1, 0, NAN, 0, 0, INFINITY, 0, 0, 2, 0, 0, 0, 0, 0};
    const uint32_t faces[15] = {0, 1, 2, 0, 1, 3, 0, 4, 2, 0, 1, 5, 0, 0, 1};
    sl_scene_parts parts = {.vertex_count = 7, .positions = positions, .triangle_count = 5, .indices = faces};
    sl_scene *s = scene_built(&parts);
    assert_int_equal(sl_scene_triangle_count(s), 1);
    assert_int_equal(s->vertex_count, 3);
    assert_true(scene_warns_of(s, "2 triangles with NaN or infinite vertices"));
    assert_true(scene_warns_of(s, "2 triangles without area"));
    sl_scene_destroy(s);
}

static void tiny_and_huge_triangles_keep_a_normal(void **state) {
    const float sizes[4] = {1e-38f, 1e-20f, 1e20f, 1e38f};
    for (int i = 0; i < 4; i++) {
        const float positions[9] = {0, 0, 0, sizes[i], 0, 0, 0, sizes[i], 0};
        const uint32_t face[3] = {0, 1, 2};
        sl_scene_parts parts = {
            .vertex_count = 3, .positions = positions, .triangle_count = 1, .indices = face};
        sl_scene *s = scene_built(&parts);
        assert_true(s->geometric_normal_z[0] == 1.0f);
        assert_true(s->diagonal > 0.0f && isfinite(s->diagonal));
        assert_true(sl_is_finite(s->camera.eye) && isfinite(s->camera.back.z));
        sl_scene_destroy(s);
    }
}

static void reflectance_above_one_is_scaled_per_channel(void **state) {
    sl_material m = grey;
    m.name = (char *)"shiny";
    m.diffuse = (sl_rgb){0.9f, 0.5f, 0.2f};
    m.specular = (sl_rgb){0.9f, 0.5f, 0.3f};
    sl_scene_parts parts = square_parts();
    parts.material_count = 1;
    parts.materials = &m;
    sl_scene *s = scene_built(&parts);
    const sl_material *got = &s->materials[0];
    assert_true(got->diffuse.r + got->specular.r <= 1.0f && got->diffuse.r > 0.499f);
    assert_true(got->diffuse.g == 0.5f && got->specular.g == 0.5f && got->diffuse.b == 0.2f &&
                got->specular.b == 0.3f);
    assert_true(scene_warns_of(s, "'shiny'") && scene_warns_of(s, "exceed 1"));
    sl_scene_destroy(s);
}

static void unphysical_materials_and_lights_are_refused(void **state) {
    sl_scene_parts parts = square_parts();
    sl_material m = grey;
    m.name = (char *)"wall";
    parts.material_count = 1;
    parts.materials = &m;
    m.diffuse.g = -0.1f;
    refuse(&parts, "material 'wall': expected 'diffuse' from 0");
    m = grey;
    m.emission.r = INFINITY;
    refuse(&parts, "emission");
    m = grey;
    m.exponent = NAN;
    refuse(&parts, "exponent");
    m = grey;
    sl_light light = {.type = SL_LIGHT_POINT, .intensity = {1, -1, 1}};
    parts.light_count = 1;
    parts.lights = &light;
    refuse(&parts, "intensity");
    light = (sl_light){.type = SL_LIGHT_DIRECTIONAL, .intensity = {1, 1, 1}};
    refuse(&parts, "direction");
    light = (sl_light){.type = SL_LIGHT_SPOT,
                       .intensity = {1, 1, 1},
                       .direction = {0, 0, 1},
                       .cos_inner = 0.1f,
                       .cos_outer = 0.5f};
    refuse(&parts, "inner cone");
}

static void a_mirror_has_no_other_lobe(void **state) {
    sl_material m = grey;
    m.mirror = (sl_rgb){2.0f, 0.5f, 0.5f};
    sl_scene_parts parts = square_parts();
    parts.material_count = 1;
    parts.materials = &m;
    sl_scene *s = scene_built(&parts);
    assert_true(sl_rgb_max(s->materials[0].diffuse) == 0.0f && s->materials[0].mirror.r == 1.0f);
    assert_true(scene_warns_of(s, "mirror"));
    assert_int_equal(sl_scene_features(s).mirror_triangles, 2);
    assert_int_equal(sl_scene_features(s).diffuse_triangles, 0);
    sl_scene_destroy(s);
}

static void emissive_triangles_become_emitters_in_order(void **state) {
    sl_material both[2] = {grey, grey};
    both[1].emission = (sl_rgb){3, 2, 1};
    const uint32_t index[2] = {0, 1};
    sl_scene_parts parts = square_parts();
    parts.material_count = 2;
    parts.materials = both;
    parts.material_index = index;
    sl_scene *s = scene_built(&parts);
    assert_int_equal(s->emitter_count, 1);
    assert_int_equal(s->emitters[0].triangle, 1);
    assert_true(s->emitters[0].area == 2.0f && s->emitters[0].radiance.r == 3.0f);
    assert_int_equal(s->emitter_of_triangle[0], SL_NO_INDEX);
    assert_int_equal(s->emitter_of_triangle[1], 0);
    assert_int_equal(sl_scene_features(s).emissive_triangles, 1);
    sl_scene_destroy(s);
}

static void emitters_whose_area_vanishes_give_no_light_and_say_so(void **state) {
    sl_material m = grey;
    m.emission = (sl_rgb){1, 1, 1};
    const float positions[9] = {0, 0, 0, 1e-38f, 0, 0, 0, 1e-38f, 0};
    const uint32_t face[3] = {0, 1, 2};
    sl_scene_parts parts = {.vertex_count = 3,
                            .positions = positions,
                            .triangle_count = 1,
                            .indices = face,
                            .material_count = 1,
                            .materials = &m};
    sl_scene *s = scene_built(&parts);
    assert_int_equal(s->emitter_count, 0);
    assert_int_equal(s->emitter_of_triangle[0], SL_NO_INDEX);
    assert_true(scene_warns_of(s, "give no light"));
    sl_scene_destroy(s);
}

static void a_dark_scene_gets_the_stated_light_only_if_asked(void **state) {
    sl_scene_parts parts = square_parts();
    sl_scene *s = scene_built(&parts);
    assert_false(s->environment.present);
    assert_true(scene_warns_of(s, "no light"));
    sl_scene_destroy(s);
    parts.default_light = true;
    s = scene_built(&parts);
    assert_true(s->environment.present && s->environment.constant.g == 0.2f);
    assert_true(s->light_count == 1 && s->lights[0].type == SL_LIGHT_DIRECTIONAL &&
                s->lights[0].intensity.g == 3.0f);
    assert_true(scene_warns_of(s, "no light: a sun"));
    sl_scene_destroy(s);
    const sl_light light = {.type = SL_LIGHT_POINT, .position = {0, 0, 1}, .intensity = {1, 1, 1}};
    parts.light_count = 1;
    parts.lights = &light;
    s = scene_built(&parts);
    assert_false(s->environment.present);
    assert_false(scene_warns_of(s, "no light"));
    sl_scene_destroy(s);
}

static void a_missing_camera_frames_the_whole_box(void **state) {
    const int films[3][2] = {{512, 512}, {100, 400}, {400, 100}};
    for (int f = 0; f < 3; f++) {
        sl_scene_parts parts = square_parts();
        parts.film_width = films[f][0];
        parts.film_height = films[f][1];
        sl_scene *s = scene_built(&parts);
        assert_true(scene_warns_of(s, "no camera"));
        assert_true(s->camera.eye.z > s->box_max.z && s->camera.back.x > 0.3f && s->camera.back.y > 0.3f &&
                    s->camera.back.z > 0.8f);
        double up = tan(0.5 * (double)s->camera.vertical_fov), across = up * films[f][0] / films[f][1];
        for (uint32_t v = 0; v < s->vertex_count; v++) {
            sl_vec3 d = sl_sub(sl_scene_position(s, v), s->camera.eye);
            double depth = -(double)sl_dot(d, s->camera.back);
            assert_true(depth > 0.0);
            assert_true(fabs((double)sl_dot(d, s->camera.right)) <= across * depth);
            assert_true(fabs((double)sl_dot(d, s->camera.up)) <= up * depth);
        }
        sl_scene_destroy(s);
    }
}

static void moving_the_camera_raises_the_version_and_changes_the_hash(void **state) {
    sl_scene_parts parts = square_parts();
    sl_scene *s = scene_built(&parts), *same = scene_built(&parts);
    assert_true(sl_scene_hash(s) == sl_scene_hash(same));
    const float eye[3] = {0, 0, 5}, target[3] = {0, 0, 0}, up[3] = {0, 1, 0};
    uint64_t version = s->version, hash = sl_scene_hash(s);
    assert_int_equal(sl_scene_set_camera(s, eye, target, up, 1.0f, NULL), SL_OK);
    assert_true(s->version > version && sl_scene_hash(s) != hash);
    sl_error error;
    assert_int_equal(sl_scene_set_camera(s, eye, eye, up, 1.0f, &error), SL_ERROR_USAGE);
    sl_scene_destroy(s);
    sl_scene_destroy(same);
}

static void the_hash_sees_whatever_reaches_a_pixel(void **state) {
    sl_scene_parts parts = square_parts();
    sl_material m = grey;
    parts.material_count = 1;
    parts.materials = &m;
    sl_scene *s = scene_built(&parts);
    uint64_t hash = sl_scene_hash(s);
    float *floats[] = {&s->position_x[1],          &s->normal_y[2],           &s->texture_u[0],
                       &s->materials[0].diffuse.g, &s->materials[0].exponent, &s->materials[0].emission.b,
                       &s->environment.constant.r, &s->camera.vertical_fov};
    for (size_t i = 0; i < sizeof floats / sizeof floats[0]; i++) {
        float before = *floats[i];
        *floats[i] = before + 0.25f;
        assert_true(sl_scene_hash(s) != hash);
        *floats[i] = before;
        assert_true(sl_scene_hash(s) == hash);
    }
    s->film_width++;
    assert_true(sl_scene_hash(s) != hash);
    sl_scene_destroy(s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(facets_without_normals_stay_facets),
        cmocka_unit_test(given_normals_are_made_unit_and_bad_ones_replaced),
        cmocka_unit_test(triangles_that_cannot_be_drawn_are_dropped_and_counted),
        cmocka_unit_test(tiny_and_huge_triangles_keep_a_normal),
        cmocka_unit_test(reflectance_above_one_is_scaled_per_channel),
        cmocka_unit_test(unphysical_materials_and_lights_are_refused),
        cmocka_unit_test(a_mirror_has_no_other_lobe),
        cmocka_unit_test(emissive_triangles_become_emitters_in_order),
        cmocka_unit_test(emitters_whose_area_vanishes_give_no_light_and_say_so),
        cmocka_unit_test(a_dark_scene_gets_the_stated_light_only_if_asked),
        cmocka_unit_test(a_missing_camera_frames_the_whole_box),
        cmocka_unit_test(moving_the_camera_raises_the_version_and_changes_the_hash),
        cmocka_unit_test(the_hash_sees_whatever_reaches_a_pixel),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
