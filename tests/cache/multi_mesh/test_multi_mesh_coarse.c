/* The coarse mesh of multi-mesh caching: what it samples and how often, what lies between, and what bounces
 * off it. */
#include "scene/ambient.h"
#include "multi_mesh_gather_support.h"

static bool near(double a, double b, double tolerance) { return fabs(a - b) <= tolerance; }

typedef struct meshed {
    sl_scene *scene;
    sl_primitives *primitives;
    sl_coarse *coarse;
} meshed;

static meshed mesh_of(sl_scene *scene, float edge, int depth) {
    meshed m = {.scene = scene};
    assert_int_equal(sl_primitives_of_triangles(scene, &m.primitives, NULL), SL_OK);
    assert_int_equal(sl_coarse_create(scene, m.primitives, edge, depth, &m.coarse, NULL), SL_OK);
    return m;
}

static void meshed_destroy(meshed *m) {
    sl_coarse_destroy(m->coarse);
    sl_primitives_destroy(m->primitives);
    sl_scene_destroy(m->scene);
}

static sl_scene *quad_scene(float diffuse) {
    trace_mesh m = trace_mesh_begin();
    trace_mesh_quad(&m, sl_v3(0, 0, 0), sl_v3(1, 0, 0), sl_v3(0, 1, 0), trace_mesh_diffuse(&m, diffuse));
    return trace_mesh_build(&m);
}

static sl_vec3 face_normal(const sl_scene *scene, uint32_t face) {
    sl_vec3 n = sl_scene_geometric_normal(scene, face / 2);
    return face & 1u ? sl_neg(n) : n;
}

static sl_vec3 position_of(const meshed *m, size_t v) {
    sl_root_place at = m->coarse->vertex[v];
    return face_point(m->scene, at.root, (float)at.u / SL_PATCH_DYADIC, (float)at.v / SL_PATCH_DYADIC)
        .lit.position;
}

/* ---- what is sampled ------------------------------------------------------------------------- */

/* A square of two triangles, each side: (n + 1)^2 vertices, those on the diagonal shared. */
static void edges_are_split_until_they_are_short_or_deep_enough(void **state) {
    const float edge[6] = {10.0f, 1.42f, 1.41f, 0.5f, 0.1f, 0.001f};
    const int depth[6] = {5, 5, 5, 5, 3, 4}, level[6] = {0, 0, 1, 2, 3, 4};
    for (int k = 0; k < 6; k++) {
        meshed m = mesh_of(quad_scene(0.5f), edge[k], depth[k]);
        size_t n = (size_t)1 << level[k];
        assert_int_equal(m.coarse->vertex_count, 2 * (n + 1) * (n + 1));
        for (size_t v = 0; v < 2 * (n + 1) * (n + 1); v++)
            assert_int_equal(m.coarse->level[m.coarse->vertex[v].root], level[k]);
        meshed_destroy(&m);
    }
}

/* A square of eight coarse triangles, each side: 6 at its middle, 3 amid its sides, 1 or 2 at its corners. */
static void a_vertex_stands_for_a_third_of_the_coarse_triangles_around_it(void **state) {
    meshed m = mesh_of(quad_scene(0.5f), 1.0f, 5);
    float area[18];
    int thirds[7] = {0};
    assert_int_equal(m.coarse->vertex_count, 18);
    sl_coarse_areas(m.coarse, area);
    for (int v = 0; v < 18; v++) {
        double triangles = 24.0 * (double)area[v];
        assert_true(near(triangles, round(triangles), 1e-4) && triangles < 6.5);
        thirds[(int)round(triangles)]++;
    }
    assert_true(thirds[1] == 4 && thirds[2] == 4 && thirds[3] == 8 && thirds[6] == 2);
    meshed_destroy(&m);
}

/* Two quads side by side, one of large triangles, one of small ones: where they meet the finer ones' vertices
 * are those of the coarser one. */
static sl_scene *uneven_scene(void) {
    trace_mesh m = trace_mesh_begin();
    uint32_t grey = trace_mesh_diffuse(&m, 0.5f);
    uint32_t a = trace_mesh_vertex(&m, 0, 0, 0), b = trace_mesh_vertex(&m, 0, 1, 0),
             c = trace_mesh_vertex(&m, 3, 0.5f, 0), d = trace_mesh_vertex(&m, -0.5f, 0.5f, 0);
    trace_mesh_triangle(&m, a, c, b, grey);
    trace_mesh_triangle(&m, b, d, a, grey);
    trace_mesh_triangle(&m, trace_mesh_vertex(&m, 0, 0, 0), trace_mesh_vertex(&m, 0, 0, 1),
                        trace_mesh_vertex(&m, 0, 1, 0), grey);
    return trace_mesh_build(&m);
}

static void no_point_of_a_flat_surface_is_sampled_twice(void **state) {
    for (int scene = 0; scene < 2; scene++) {
        trace_mesh ball = trace_mesh_begin();
        if (scene)
            trace_mesh_sphere(&ball, sl_v3(0, 0, 0), 1.0f, 6, 0.0f, true, trace_mesh_diffuse(&ball, 0.4f));
        meshed m = mesh_of(scene ? trace_mesh_build(&ball) : uneven_scene(), 0.3f, 4);
        if (!scene) trace_mesh_discard(&ball);
        size_t count = m.coarse->vertex_count, creases = 0;
        for (size_t i = 0; i < count; i++) {
            for (size_t j = 0; j < i; j++) {
                sl_root_place a = m.coarse->vertex[i], b = m.coarse->vertex[j];
                if (sl_length(sl_sub(position_of(&m, i), position_of(&m, j))) > 1e-5f) continue;
                float turned =
                    sl_length(sl_sub(face_normal(m.scene, a.root), face_normal(m.scene, b.root)));
                assert_true(turned > 5e-5f); /* another side, or beyond a crease */
                creases += turned < 1.9f;
            }
        }
        assert_true(creases > 0);
        meshed_destroy(&m);
    }
}

static void faces_that_reflect_nothing_are_not_sampled(void **state) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t grey = trace_mesh_diffuse(&mesh, 0.5f), black = trace_mesh_diffuse(&mesh, 0);
    uint32_t mirror = trace_mesh_material(&mesh, 0, 0, 0, 0.9f, 0),
             glossy = trace_mesh_material(&mesh, 0, 0.5f, 20, 0, 0);
    const uint32_t all[4] = {black, mirror, glossy, grey};
    for (int k = 0; k < 4; k++)
        trace_mesh_quad(&mesh, sl_v3(2.0f * (float)k, 0, 0), sl_v3(1, 0, 0), sl_v3(0, 1, 0), all[k]);
    meshed m = mesh_of(trace_mesh_build(&mesh), 10.0f, 0);
    assert_int_equal(m.coarse->vertex_count, 8);
    for (size_t v = 0; v < 8; v++) assert_true(m.coarse->vertex[v].root >= 12);
    meshed_destroy(&m);
}

static void the_inner_side_of_a_solid_is_not_sampled(void **state) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_box(&mesh, sl_v3(0, 0, 0), sl_v3(1, 1, 1), false, trace_mesh_diffuse(&mesh, 0.5f));
    trace_mesh_quad(&mesh, sl_v3(-5, -1, -5), sl_v3(0, 0, 10), sl_v3(10, 0, 0), trace_mesh_lamp(&mesh, 1));
    meshed m = mesh_of(trace_mesh_build(&mesh), 10.0f, 0);
    assert_int_equal(m.coarse->vertex_count, 24); /* four corners of six sides */
    for (size_t v = 0; v < 24; v++) assert_int_equal(m.coarse->vertex[v].root % 2, 0);
    meshed_destroy(&m);
}

/* ---- what lies between ----------------------------------------------------------------------- */

static void assert_linear_field_is_kept(float edge, int depth) {
    meshed m = mesh_of(uneven_scene(), edge, depth);
    for (size_t v = 0; v < m.coarse->vertex_count; v++) {
        sl_vec3 p = position_of(&m, v);
        sl_coarse_set(m.coarse, v, (sl_rgb){2.0f + p.x, 3.0f - p.y, 1.0f + p.z});
    }
    sl_coarse_finish(m.coarse, 1);
    for (uint32_t face = 0; face < 6; face++) {
        for (int k = 0; k < 200; k++) {
            float w1 = (float)(k % 14) / 14.0f, w2 = (1.0f - w1) * (float)(k / 14) / 14.0f;
            sl_vec3 p = face_point(m.scene, face, w1, w2).lit.position;
            sl_rgb v = sl_rgb_scale(coarse_colour(m.coarse, face, w1, w2), 2.0f); /* of 1/2 reflected */
            assert_true(near((double)v.r, 2.0 + (double)p.x, 1e-5));
            assert_true(near((double)v.g, 3.0 - (double)p.y, 1e-5));
            assert_true(near((double)v.b, 1.0 + (double)p.z, 1e-5));
        }
    }
    meshed_destroy(&m);
}

static void a_linear_field_is_kept_between_vertices_across_levels(void **state) {
    const float edge[4] = {0.3f, 1.01f, 1.2f, 0.6f};
    const int depth[4] = {5, 5, 3, 1};
    for (int k = 0; k < 4; k++) assert_linear_field_is_kept(edge[k], depth[k]);
}

/* A unit square of 4 x 4: what lies on the rim of a triangle is moved a sixth of a coarse triangle's weight
 * into it, what lies within stays. */
static void light_is_asked_for_a_little_within_rims(void **state) {
    meshed m = mesh_of(quad_scene(0.5f), 0.36f, 8);
    size_t within = 0, rim = 0;
    for (size_t v = 0; v < m.coarse->vertex_count; v++) {
        sl_root_place at = m.coarse->vertex[v];
        const sl_root_place to = sl_coarse_lit_place(m.coarse, v);
        const int own[3] = {SL_PATCH_DYADIC - at.u - at.v, at.u, at.v},
                  lit[3] = {SL_PATCH_DYADIC - to.u - to.v, to.u, to.v};
        bool on_rim = !own[0] || !own[1] || !own[2];
        for (int k = 0; k < 3; k++)
            assert_int_equal(on_rim && !own[k] ? SL_PATCH_DYADIC / 24 : on_rim ? lit[k] : own[k], lit[k]);
        assert_true(near((double)to.u, (double)at.u, SL_PATCH_DYADIC / 12.0 + 1.0));
        rim += on_rim;
        within += !on_rim;
    }
    assert_true(rim > 20 && within > 10);
    meshed_destroy(&m);
}

static void a_value_that_is_no_number_is_made_up_for_by_its_neighbours(void **state) {
    meshed m = mesh_of(quad_scene(0.5f), 10.0f, 0);
    const float bad[3] = {NAN, INFINITY, -INFINITY};
    for (int k = 0; k < 3; k++) {
        for (size_t v = 0; v < 8; v++) sl_coarse_set(m.coarse, v, sl_grey(2.0f));
        sl_coarse_set(m.coarse, 1, (sl_rgb){1.0f, bad[k], 1.0f});
        sl_coarse_finish(m.coarse, 1);
        for (uint32_t face = 0; face < 4; face++)
            assert_true(coarse_colour(m.coarse, face, 0.3f, 0.6f).g == 1.0f);
        assert_true(sl_coarse_brightest(m.coarse).r == 1.0f);
    }
    for (size_t v = 0; v < 8; v++) sl_coarse_set(m.coarse, v, sl_grey(NAN));
    sl_coarse_finish(m.coarse, 1);
    assert_true(sl_coarse_brightest(m.coarse).g == 0.0f);
    meshed_destroy(&m);
}

/* ---- what bounces off ------------------------------------------------------------------------ */

/* Left half red, right half green, in stripes of one texel. */
static sl_scene *striped_quad(bool masked) {
    enum { SIZE = 64 };
    uint8_t *texels = malloc(SIZE * SIZE * 4);
    assert_non_null(texels);
    for (int i = 0; i < SIZE * SIZE; i++) {
        bool red = i % SIZE < SIZE / 2, on = i % 2 == 0;
        const uint8_t rgba[4] = {red && on ? 255 : 0, !red && on ? 255 : 0, 0, masked && !on ? 0 : 255};
        memcpy(texels + 4 * i, rgba, 4);
    }
    trace_mesh m = trace_mesh_begin();
    uint32_t material = trace_mesh_diffuse(&m, 0.8f);
    m.materials[material].texture = 0;
    if (masked) m.materials[material].alpha_texture = 0;
    char name[] = "stripes";
    m.textures[0] =
        (sl_texture){.file = name, .width = SIZE, .height = SIZE, .has_alpha = masked, .texels = texels};
    m.texture_count = 1;
    trace_mesh_quad(&m, sl_v3(0, 0, 0), sl_v3(1, 0, 0), sl_v3(0, 1, 0), material);
    sl_scene *scene = trace_mesh_build(&m);
    free(texels);
    return scene;
}

static void colours_are_values_times_the_mean_of_the_texture(void **state) {
    for (int masked = 0; masked < 2; masked++) {
        meshed m = mesh_of(striped_quad(masked == 1), 0.4f, 3);
        for (size_t v = 0; v < m.coarse->vertex_count; v++)
            sl_coarse_set(m.coarse, v, sl_grey(3.0f));
        sl_coarse_finish(m.coarse, 1);
        /* Every second column is black, or not there at all. */
        double mean = 3.0 * 0.8 * (masked ? 1.0 : 0.5);
        sl_rgb brightest = sl_coarse_brightest(m.coarse);
        assert_true(near((double)brightest.r, mean, 0.12 * mean));
        assert_true(near((double)brightest.g, mean, 0.12 * mean));
        assert_true(brightest.b == 0.0f);
        meshed_destroy(&m);
    }
}

/* ---- before there is one --------------------------------------------------------------------- */

static void every_kind_of_light_counts_with_its_power(void **state) {
    sl_light spot = {.type = SL_LIGHT_SPOT,
                     .direction = {0, 0, -1},
                     .intensity = {1, 1, 1},
                     .cos_inner = 0.5f,
                     .cos_outer = 0.5f};
    sl_light sun = {.type = SL_LIGHT_DIRECTIONAL, .direction = {0, 0, -1}, .intensity = {1, 1, 1}};
    sl_environment sky = {.present = true, .constant = {1, 1, 1}};
    /* A square of area 1, reflectance 0.5: half of the power, over pi of the sky as it is. */
    const double power[4] = {SL_PI * 2.0 /* two-sided emitter */, SL_PI, 1.0, 0.0};
    for (int k = 0; k < 4; k++) {
        trace_mesh m = trace_mesh_begin();
        uint32_t material = trace_mesh_material(&m, 0.5f, 0, 0, 0, k == 0 ? 1.0f : 0.0f);
        m.materials[material].emission_two_sided = true;
        trace_mesh_quad(&m, sl_v3(0, 0, 0), sl_v3(1, 0, 0), sl_v3(0, 1, 0), material);
        if (k == 1) m.lights[m.light_count++] = spot;
        if (k == 2) m.lights[m.light_count++] = sun;
        if (k == 3) m.environment = &sky;
        sl_scene *scene = trace_mesh_build(&m);
        double truth = 0.5 * power[k] + (k == 3 ? SL_PI : 0.0);
        assert_true(near((double)sl_ambient_irradiance(scene).g, truth, 1e-5 * truth));
        sl_scene_destroy(scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(edges_are_split_until_they_are_short_or_deep_enough),
        cmocka_unit_test(a_vertex_stands_for_a_third_of_the_coarse_triangles_around_it),
        cmocka_unit_test(no_point_of_a_flat_surface_is_sampled_twice),
        cmocka_unit_test(faces_that_reflect_nothing_are_not_sampled),
        cmocka_unit_test(the_inner_side_of_a_solid_is_not_sampled),
        cmocka_unit_test(a_linear_field_is_kept_between_vertices_across_levels),
        cmocka_unit_test(light_is_asked_for_a_little_within_rims),
        cmocka_unit_test(a_value_that_is_no_number_is_made_up_for_by_its_neighbours),
        cmocka_unit_test(colours_are_values_times_the_mean_of_the_texture),
        cmocka_unit_test(every_kind_of_light_counts_with_its_power),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
