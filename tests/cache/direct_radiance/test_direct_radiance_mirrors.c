/* Curved mirrors of Direct Radiance Mapping: environment cubes, what they show, and what is not made where
 * nobody looks. */
#include "base/math.h"
#include "cache/direct_radiance/direct_radiance.h"
#include "raster_support.h"
#include "receiver_support.h"
#include "scene/ambient.h"

enum { W = 80, H = 60, PIXELS = W * H, MAX = 30000, RINGS = 24 };

/* ---- scenes ---- */

enum { WHITE, MIRROR, DIM_MIRROR, LAMP, BROWN, MATERIALS };

typedef struct {
    float xyz[9 * MAX], normal[9 * MAX];
    uint32_t material[MAX], object[MAX];
    size_t count;
} mesh;

static void add_triangle(mesh *m, uint32_t material, uint32_t object, const sl_vec3 p[3],
                         const sl_vec3 n[3]) {
    assert_true(m->count < MAX);
    memcpy(m->xyz + 9 * m->count, p, 9 * sizeof(float));
    if (n) memcpy(m->normal + 9 * m->count, n, 9 * sizeof(float));
    else memset(m->normal + 9 * m->count, 0, 9 * sizeof(float));
    m->material[m->count] = material;
    m->object[m->count++] = object;
}

/* Its front is on the side of a x b. */
static void add_quad(mesh *m, uint32_t material, uint32_t object, sl_vec3 centre, sl_vec3 a, sl_vec3 b) {
    sl_vec3 p[4] = {sl_sub(sl_sub(centre, a), b), sl_sub(sl_add(centre, a), b), sl_add(sl_add(centre, a), b),
                    sl_add(sl_sub(centre, a), b)};
    add_triangle(m, material, object, (sl_vec3[3]){p[0], p[1], p[2]}, NULL);
    add_triangle(m, material, object, (sl_vec3[3]){p[0], p[2], p[3]}, NULL);
}

/* A box seen from inside. */
static void add_room(mesh *m, uint32_t material, uint32_t object, float half) {
    const sl_vec3 axis[3] = {sl_v3(half, 0, 0), sl_v3(0, half, 0), sl_v3(0, 0, half)};
    for (int k = 0; k < 3; k++) {
        add_quad(m, material, object, axis[k], axis[(k + 2) % 3], axis[(k + 1) % 3]);
        add_quad(m, material, object, sl_neg(axis[k]), axis[(k + 1) % 3], axis[(k + 2) % 3]);
    }
}

static sl_vec3 on_sphere(int ring, int sector) {
    double theta = SL_PI * ring / RINGS, phi = SL_PI * sector / RINGS;
    return sl_v3((float)(sl_sin(theta) * sl_cos(phi)), (float)sl_cos(theta),
                 (float)(sl_sin(theta) * sl_sin(phi)));
}

/* Smooth, with the sphere's normals. */
static void add_ball(mesh *m, uint32_t material, uint32_t object, sl_vec3 centre, float radius) {
    for (int i = 0; i < RINGS; i++) {
        for (int j = 0; j < 2 * RINGS; j++) {
            sl_vec3 n[4] = {on_sphere(i, j), on_sphere(i, j + 1), on_sphere(i + 1, j + 1),
                            on_sphere(i + 1, j)},
                    p[4];
            for (int k = 0; k < 4; k++) p[k] = sl_mad(centre, radius, n[k]);
            if (i > 0)
                add_triangle(m, material, object, (sl_vec3[3]){p[0], p[1], p[2]},
                             (sl_vec3[3]){n[0], n[1], n[2]});
            if (i < RINGS - 1)
                add_triangle(m, material, object, (sl_vec3[3]){p[0], p[2], p[3]},
                             (sl_vec3[3]){n[0], n[2], n[3]});
        }
    }
}

static const sl_rgb mirror_ks = {1.0f, 1.0f, 1.0f}, dim_ks = {0.5f, 0.75f, 0.25f},
                    lamp_radiance = {8.0f, 4.0f, 2.0f};

static sl_scene *scene_of(const mesh *m, const sl_environment *environment, const sl_light *light) {
    uint32_t *indices = malloc(3 * MAX * sizeof *indices);
    assert_non_null(indices);
    for (uint32_t i = 0; i < 3 * m->count; i++) indices[i] = i;
    const uint32_t none = SL_NO_INDEX;
    sl_material materials[MATERIALS] = {
        [WHITE] = {.diffuse = {0.8f, 0.8f, 0.8f}, .texture = none, .alpha_texture = none},
        [MIRROR] = {.mirror = mirror_ks, .texture = none, .alpha_texture = none},
        [DIM_MIRROR] = {.mirror = dim_ks, .texture = none, .alpha_texture = none},
        [LAMP] = {.emission = lamp_radiance, .texture = none, .alpha_texture = none},
        [BROWN] = {.diffuse = {0.4f, 0.2f, 0.0f}, .texture = none, .alpha_texture = none},
    };
    sl_scene_parts parts = {.vertex_count = 3 * m->count,
                            .positions = m->xyz,
                            .normals = m->normal,
                            .triangle_count = m->count,
                            .indices = indices,
                            .material_index = m->material,
                            .object_index = m->object,
                            .material_count = MATERIALS,
                            .materials = materials,
                            .environment = environment,
                            .light_count = light ? 1 : 0,
                            .lights = light};
    sl_scene *scene = NULL;
    sl_error error;
    if (sl_scene_build(&parts, &scene, &error) != SL_OK) fail_msg("%s", error.message);
    free(indices);
    return scene;
}

/* ---- a picture ---- */

typedef struct {
    sl_scene *scene;
    sl_raster *raster;
    sl_mirrors *planar;
    sl_map_lights *lights;
    sl_view view;
} fixture;

static fixture fixture_of(sl_scene *scene, sl_vec3 eye, sl_vec3 target) {
    fixture f = {.scene = scene, .raster = raster_of(scene)};
    sl_camera camera;
    assert_true(sl_camera_look_at(&camera, eye, target, sl_v3(0, 1, 0), 0.9f));
    f.view = sl_view_camera(&camera, W, H, 1e-3f, 4000.0f);
    assert_int_equal(sl_mirrors_find(scene, 8, &f.planar, NULL), SL_OK);
    assert_int_equal(sl_map_lights_find(scene, 1, &f.lights, NULL), SL_OK);
    return f;
}

static void destroy(fixture *f) {
    sl_map_lights_destroy(f->lights);
    sl_mirrors_destroy(f->planar);
    sl_raster_destroy(f->raster);
    sl_scene_destroy(f->scene);
}

typedef struct {
    int cube_size, reflections;
    bool indirect, trick;
    unsigned threads;
    const sl_map_photons *photons;
} way;

enum { EMISSION, DIRECT, INDIRECT, PARTS };
typedef struct {
    sl_receivers *receivers;
    size_t cube_bytes;
    float plane[PARTS][3][PIXELS];
    sl_counters cubes, shading; /* what the cubes cost, and the rest */
} picture;

static void render_picture(const fixture *f, const way *how, picture *out) {
    memset(out, 0, sizeof *out);
    const unsigned threads = how->threads ? how->threads : 1;
    assert_int_equal(sl_receivers_render(f->scene, f->raster, &f->view, f->planar, how->reflections, threads,
                                         &out->receivers, &out->shading, NULL),
                     SL_OK);
    sl_light_pass light = {.scene = f->scene,
                           .lights = f->lights,
                           .photons = how->photons,
                           .weight = SL_WEIGHT_FLUX,
                           .threads = threads};
    sl_mirror_pass pass = {.scene = f->scene,
                           .raster = f->raster,
                           .planar = f->planar,
                           .light = &light,
                           .cube_size = how->cube_size,
                           .reflections = how->reflections,
                           .indirect = how->indirect};
    sl_curved_mirrors *mirrors = NULL;
    assert_int_equal(sl_curved_mirrors_render(&pass, out->receivers, &mirrors, &out->cubes, NULL), SL_OK);
    out->cube_bytes = sl_curved_mirrors_bytes(mirrors);
    if (how->trick) light.trick_albedo = sl_mean_albedo(f->scene);
    sl_lit_picture lit;
    float *part[PARTS][3];
    for (int p = 0; p < PARTS; p++) {
        for (int k = 0; k < 3; k++) part[p][k] = out->plane[p][k];
    }
    memcpy(lit.direct, part[DIRECT], sizeof lit.direct);
    memcpy(lit.indirect, part[INDIRECT], sizeof lit.indirect);
    add_emission(f->scene, out->receivers, part[EMISSION]);
    light_directly(&light, out->receivers, &lit, &out->shading);
    light_indirectly(&light, out->receivers, &lit, &out->shading);
    sl_curved_mirrors_reflect(mirrors, out->receivers, part[EMISSION], part[DIRECT], part[INDIRECT],
                              &out->shading);
    sl_curved_mirrors_destroy(mirrors);
    for (int p = 0; p < PARTS; p++) {
        for (int k = 0; k < 3; k++) {
            for (int i = 0; i < PIXELS; i++)
                assert_true(isfinite(out->plane[p][k][i]) && out->plane[p][k][i] >= 0.0f);
        }
    }
}

static void release(picture *p) { sl_receivers_destroy(p->receivers); }

static uint32_t material_at(const picture *p, int i) { return p->receivers->gbuffer->material[i]; }

static sl_vec3 reflected_at(const picture *p, int i) {
    const sl_gbuffer *g = p->receivers->gbuffer;
    sl_vec3 n = sl_v3(g->normal_x[i], g->normal_y[i], g->normal_z[i]);
    sl_vec3 d = sl_sub(sl_v3(g->position_x[i], g->position_y[i], g->position_z[i]),
                       sl_receiver_eye(p->receivers, (size_t)i));
    return sl_normalize_or(sl_mad(d, -2.0f * sl_dot(d, n), n), n);
}

/* ---- what is not made ---- */

static picture a, b;

static void only_curved_mirrors_in_sight_get_cubes(void **state) {
    (void)state;
    static mesh m;
    size_t bytes[3] = {0};
    for (int n = 0; n < 3; n++) {
        m.count = 0;
        add_room(&m, WHITE, 0, 5);
        add_ball(&m, MIRROR, 1, sl_v3(0, 0, 4), 0.5f);
        if (n > 0) add_ball(&m, MIRROR, 2, sl_v3(-1, 0, -3), 0.75f);
        if (n > 1) add_ball(&m, DIM_MIRROR, 3, sl_v3(1, 0, -3), 0.75f);
        sl_light light = {.type = SL_LIGHT_POINT, .intensity = {10, 10, 10}};
        fixture f = fixture_of(scene_of(&m, NULL, &light), sl_v3(0, 0, 0.5f), sl_v3(0, 0, -4));
        render_picture(&f, &(way){.cube_size = 32, .reflections = 1}, &a);
        assert_int_equal(a.cubes.value[SL_COUNT_RASTER_PASSES], 6 * n);
        bytes[n] = a.cube_bytes;
        release(&a);
        destroy(&f);
    }
    assert_true(bytes[0] == 0 && bytes[1] > 6 * 32 * 32 * 16 && bytes[2] > 3 * bytes[1] / 2 &&
                bytes[2] <= 2 * bytes[1]);
}

/* ---- what is shown ---- */

static void a_far_environment_is_reflected_as_by_rays(void **state) {
    (void)state;
    enum { EW = 512, EH = 256 };
    static mesh m;
    static float texels[3 * EW * EH];
    for (int y = 0; y < EH; y++) {
        for (int x = 0; x < EW; x++) {
            double phi = 2.0 * SL_PI * ((x + 0.5) / EW - 0.5), theta = SL_PI * (y + 0.5) / EH;
            float *t = texels + 3 * (y * EW + x);
            t[0] = (float)(2.0 + sl_sin(theta) * sl_sin(phi));
            t[1] = (float)(2.0 + sl_cos(theta));
            t[2] = (float)(2.0 - sl_sin(theta) * sl_cos(phi));
        }
    }
    sl_environment environment = {.present = true, .width = EW, .height = EH, .texels = texels};
    m.count = 0;
    add_ball(&m, DIM_MIRROR, 0, sl_v3(0.5f, 0.25f, 0), 1);
    fixture f = fixture_of(scene_of(&m, &environment, NULL), sl_v3(0, 1, 3), sl_v3(0.5f, 0.25f, 0));
    render_picture(&f, &(way){.cube_size = 128, .reflections = 1}, &a);
    size_t seen = 0;
    for (int i = 0; i < PIXELS; i++) {
        if (material_at(&a, i) != DIM_MIRROR) continue;
        sl_rgb sky = sl_rgb_mul(sl_environment_radiance(&f.scene->environment, reflected_at(&a, i)), dim_ks);
        const float expected[3] = {sky.r, sky.g, sky.b};
        for (int k = 0; k < 3; k++)
            assert_true(fabsf(a.plane[EMISSION][k][i] - expected[k]) <= 0.02f * expected[k]);
        seen++;
    }
    assert_true(seen > 500);
    release(&a);
    destroy(&f);
}

/* A lamp that only the flat mirror can show to the ball: it shines away from it. */
static void a_planar_mirror_is_seen_in_the_ball(void **state) {
    (void)state;
    static mesh m;
    m.count = 0;
    add_ball(&m, MIRROR, 0, sl_v3(0, 0, 0), 1);
    add_quad(&m, DIM_MIRROR, 1, sl_v3(5, 0, 0), sl_v3(0, 0, 4), sl_v3(0, 4, 0));
    add_quad(&m, LAMP, 2, sl_v3(3, 2, 0), sl_v3(0, 0.8f, 0), sl_v3(0, 0, 2.5f)); /* front towards +x */
    for (int reflections = 0; reflections <= 1; reflections++) {
        fixture f = fixture_of(scene_of(&m, NULL, NULL), sl_v3(2, -0.8f, 2), sl_v3(0.3f, 0.3f, 0));
        assert_int_equal(f.planar->count, 1);
        render_picture(&f, &(way){.cube_size = 128, .reflections = reflections}, &a);
        size_t by_mirror = 0, other = 0;
        const float expected[3] = {dim_ks.r * lamp_radiance.r, dim_ks.g * lamp_radiance.g,
                                   dim_ks.b * lamp_radiance.b};
        for (int i = 0; i < PIXELS; i++) {
            if (material_at(&a, i) != MIRROR) continue;
            bool equal = true;
            for (int k = 0; k < 3; k++)
                equal &= fabsf(a.plane[EMISSION][k][i] - expected[k]) < 1e-5f * expected[k];
            by_mirror += equal;
            other += a.plane[EMISSION][0][i] > 1.001f * expected[0];
        }
        assert_true(reflections ? by_mirror > 3 : by_mirror == 0);
        assert_int_equal(other, 0); /* its front is not seen otherwise */
        release(&a);
        destroy(&f);
    }
}

/* A lamp that fills the middle half of a face, each way: 0.0641 of the sphere, where it is 1/24 of the
 * texels. The ball beside shows k_s times that share. */
static void a_mirror_in_a_mirror_shows_the_mean_over_solid_angle(void **state) {
    (void)state;
    static mesh m;
    m.count = 0;
    add_ball(&m, MIRROR, 0, sl_v3(0, 0, 0), 0.5f);
    add_ball(&m, DIM_MIRROR, 1, sl_v3(2, 0, 2), 0.6f);
    add_quad(&m, LAMP, 2, sl_v3(-3, 0, 0), sl_v3(0, 1.5f, 0), sl_v3(0, 0, 1.5f)); /* front towards +x */
    fixture f = fixture_of(scene_of(&m, NULL, NULL), sl_v3(0, 0, 1.6f), sl_v3(0, 0, 0));
    render_picture(&f, &(way){.cube_size = 64}, &a);
    const double lamp = 4.0 * sl_atan2(0.25, sqrt(1.5)) / (4.0 * SL_PI),
                 hidden = 0.5 * (1.0 - sqrt(1.0 - 0.36 / 8.0));
    const double expected = lamp / (1.0 - hidden) * (double)lamp_radiance.r * (double)dim_ks.r;
    size_t shown = 0;
    for (int i = 0; i < PIXELS; i++) {
        if (material_at(&a, i) == MIRROR)
            shown += fabs((double)a.plane[EMISSION][0][i] - expected) < 0.01 * expected;
    }
    assert_true(shown > 5);
    release(&a);
    destroy(&f);
}

/* ---- indirect light in mirrors ---- */

/* A room of one colour with two photons on its floor and left wall. */
static fixture lit_room(mesh *m, sl_map_photons *photons) {
    static sl_map_photon photon[2] = {{.position = {0, -4, 0},
                                       .footprint = 1,
                                       .flux = {3, 2, 1},
                                       .cos_alpha = 1,
                                       .normal = {0, 1, 0},
                                       .printed_area = 1,
                                       .radiance = {3, 2, 1}},
                                      {.position = {-4, 1, 1},
                                       .footprint = 1,
                                       .flux = {1, 2, 3},
                                       .cos_alpha = 1,
                                       .normal = {1, 0, 0},
                                       .printed_area = 1,
                                       .radiance = {1, 2, 3}}};
    *photons = (sl_map_photons){
        .count = 2, .photon = photon, .first_of_light = {0, 2}, .nearest = 1e-5f, .box_diagonal = 14.0f};
    m->count = 0;
    add_room(m, BROWN, 0, 4);
    add_ball(m, DIM_MIRROR, 1, sl_v3(-0.5f, 0, 0), 1);
    add_quad(m, MIRROR, 2, sl_v3(2.5f, 0, -3), sl_v3(1, 0, 0), sl_v3(0, 1, 0));
    sl_light light = {.type = SL_LIGHT_POINT, .position = {0, 3, 0}, .intensity = {10, 10, 10}};
    return fixture_of(scene_of(m, NULL, &light), sl_v3(1.0f, 0.5f, 3.5f), sl_v3(0, 0, 0));
}

static void full_cubes_differ_from_direct_ones_at_curved_mirrors_alone(void **state) {
    (void)state;
    static mesh m;
    sl_map_photons photons;
    fixture f = lit_room(&m, &photons);
    render_picture(&f, &(way){.cube_size = 32, .reflections = 1, .photons = &photons}, &a);
    render_picture(&f, &(way){.cube_size = 32, .reflections = 1, .photons = &photons, .indirect = true}, &b);
    assert_memory_equal(a.plane[EMISSION], b.plane[EMISSION], sizeof a.plane[EMISSION]);
    assert_memory_equal(a.plane[DIRECT], b.plane[DIRECT], sizeof a.plane[DIRECT]);
    size_t brighter = 0, in_flat_mirror = 0;
    for (int i = 0; i < PIXELS; i++) {
        if (material_at(&a, i) == DIM_MIRROR) {
            assert_true(a.plane[INDIRECT][0][i] == 0.0f);
            brighter += b.plane[INDIRECT][0][i] > 0.0f;
        } else {
            for (int k = 0; k < 3; k++) assert_true(a.plane[INDIRECT][k][i] == b.plane[INDIRECT][k][i]);
            in_flat_mirror += a.receivers->path[i] && a.plane[INDIRECT][0][i] > 0.0f;
        }
    }
    assert_true(brighter > 200 && in_flat_mirror > 50);
    assert_int_equal(a.cubes.value[SL_COUNT_RASTER_PASSES], b.cubes.value[SL_COUNT_RASTER_PASSES]);
    assert_int_equal(a.cubes.value[SL_COUNT_PHOTON_LOOK_UPS], 0);
    const uint64_t look_ups = b.cubes.value[SL_COUNT_PHOTON_LOOK_UPS];
    assert_true(look_ups > 0 && look_ups <= 6 * 32 * 32 * 2); /* the cube's pixels, times photons */
    release(&a);
    release(&b);
    destroy(&f);
}

static void the_trick_is_direct_cubes_and_one_term_more(void **state) {
    (void)state;
    static mesh m;
    sl_map_photons photons;
    fixture f = lit_room(&m, &photons);
    render_picture(&f, &(way){.cube_size = 32, .reflections = 1, .photons = &photons}, &a);
    render_picture(&f, &(way){.cube_size = 32, .reflections = 1, .photons = &photons, .trick = true}, &b);
    assert_memory_equal(&a.cubes, &b.cubes, sizeof a.cubes); /* the same passes */
    assert_int_equal(a.shading.value[SL_COUNT_RASTER_PASSES], b.shading.value[SL_COUNT_RASTER_PASSES]);
    assert_memory_equal(a.plane[DIRECT], b.plane[DIRECT], sizeof a.plane[DIRECT]);
    const sl_rgb albedo = sl_mean_albedo(f.scene);
    assert_true(fabsf(albedo.r - 0.4f) < 1e-6f && fabsf(albedo.g - 0.2f) < 1e-6f && albedo.b == 0.0f);
    size_t lit = 0;
    for (int i = 0; i < PIXELS; i++) {
        if (material_at(&a, i) != DIM_MIRROR) {
            assert_true(a.plane[INDIRECT][0][i] == b.plane[INDIRECT][0][i]);
            continue;
        }
        const sl_gbuffer *g = b.receivers->gbuffer;
        sl_rgb e = sl_grey(0.0f);
        for (size_t j = 0; j < photons.count; j++) {
            e = sl_rgb_add(
                e, sl_photon_irradiance(&photons, j, SL_WEIGHT_FLUX,
                                        sl_v3(g->position_x[i], g->position_y[i], g->position_z[i]),
                                        sl_v3(g->geometric_x[i], g->geometric_y[i], g->geometric_z[i]),
                                        sl_v3(g->normal_x[i], g->normal_y[i], g->normal_z[i])));
        }
        const float red = dim_ks.r * 0.4f * (float)(1.0 / SL_PI) * e.r,
                    green = dim_ks.g * 0.2f * (float)(1.0 / SL_PI) * e.g;
        assert_true(fabsf(b.plane[INDIRECT][0][i] - red) <= 1e-5f * red + 1e-9f);
        assert_true(fabsf(b.plane[INDIRECT][1][i] - green) <= 1e-5f * green + 1e-9f);
        lit += red > 0.0f;
    }
    assert_true(lit > 200);
    release(&a);
    release(&b);
    size_t flat = 0; /* a flat mirror that is not followed has no part in it */
    render_picture(&f, &(way){.cube_size = 32, .reflections = 0, .photons = &photons, .trick = true}, &a);
    for (int i = 0; i < PIXELS; i++) {
        if (material_at(&a, i) != MIRROR) continue;
        assert_true(a.plane[INDIRECT][0][i] == 0.0f);
        flat++;
    }
    assert_true(flat > 50);
    release(&a);
    destroy(&f);
}

static void the_tricks_albedo_is_a_mean_by_area_of_what_is_no_mirror(void **state) {
    (void)state;
    static mesh m;
    m.count = 0;
    add_quad(&m, WHITE, 0, sl_v3(0, 0, 0), sl_v3(1, 0, 0), sl_v3(0, 1, 0));
    add_quad(&m, BROWN, 0, sl_v3(0, 0, 1), sl_v3(3, 0, 0), sl_v3(0, 1, 0));
    add_quad(&m, MIRROR, 0, sl_v3(0, 0, 2), sl_v3(9, 0, 0), sl_v3(0, 9, 0));
    sl_scene *scene = scene_of(&m, NULL, NULL);
    const sl_rgb albedo = sl_mean_albedo(scene);
    assert_true(fabsf(albedo.r - 0.5f) < 1e-6f && fabsf(albedo.g - 0.35f) < 1e-6f &&
                fabsf(albedo.b - 0.2f) < 1e-6f);
    sl_scene_destroy(scene);
    m.count = 0;
    add_ball(&m, MIRROR, 0, sl_v3(0, 0, 0), 1);
    scene = scene_of(&m, NULL, NULL);
    assert_true(sl_mean_albedo(scene).r == 0.0f); /* no 0 / 0 */
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(only_curved_mirrors_in_sight_get_cubes),
        cmocka_unit_test(a_far_environment_is_reflected_as_by_rays),
        cmocka_unit_test(a_planar_mirror_is_seen_in_the_ball),
        cmocka_unit_test(a_mirror_in_a_mirror_shows_the_mean_over_solid_angle),
        cmocka_unit_test(full_cubes_differ_from_direct_ones_at_curved_mirrors_alone),
        cmocka_unit_test(the_trick_is_direct_cubes_and_one_term_more),
        cmocka_unit_test(the_tricks_albedo_is_a_mean_by_area_of_what_is_no_mirror),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
