/* Shading from the octree's lights, against sums written as the formulas stand. */
#include "light_octree_support.h"

typedef struct world {
    sl_scene *scene;
    sl_octree *octree;
    sl_voxel_lights *lights;
    sl_voxel_texture *texture;
} world;

/* Random lights in every leaf, or the same in all. */
typedef enum light_kind { RANDOM_LIGHTS, EQUAL_LIGHTS } light_kind;

static world new_world(int depth, sl_voxel_lobes lobes, light_kind kind) {
    world w = {.scene = furnished_room(8, 6)};
    w.octree = octree_of(w.scene, depth, 2);
    sl_light_octree_settings options = plain_options(4);
    options.lobes = lobes;
    w.lights = lights_of(w.scene, w.octree, &options);
    uint64_t key = sl_random_key(3, 0);
    for (size_t i = 0; i < w.octree->leaf_count; i++) {
        int used = kind == EQUAL_LIGHTS ? 3 : (int)(sl_random_bits(key, 99 * i) % 5);
        for (int j = 0; j < used && j < w.lights->texels; j++) {
            uint64_t at = kind == EQUAL_LIGHTS ? 20 * (uint64_t)j : 99 * i + 20 * (uint64_t)j;
            set_light(w.lights, i, j, sl_to_double(random_direction(key, at)),
                      0.5f + sl_random_unit(key, at + 1), sl_random_unit(key, at + 2), 0.3f);
        }
    }
    w.texture = texture_of(w.octree, w.lights);
    return w;
}

static void end_world(world *w) { destroy_octree(w->scene, w->octree, w->lights, w->texture); }

enum { POINTS = 10000 };

typedef struct points {
    sl_octree_point at[POINTS];
    float out[POINTS][3];
} points;

/* On surfaces, with any normal and view; every third is glossy. */
static points *surface_points(const sl_scene *scene, uint64_t seed) {
    points *p = calloc(1, sizeof *p);
    assert_non_null(p);
    uint64_t key = sl_random_key(seed, 0), more = sl_random_key(seed, 1);
    for (uint64_t i = 0; i < POINTS; i++) {
        uint32_t triangle;
        sl_vec3 at = random_on(scene, key, i, &triangle), n = random_direction(more, 3 * i),
                v = random_direction(more, 3 * i + 1);
        if (sl_dot(n, v) < 0.0f) v = sl_neg(v);
        bool glossy = i % 3 == 0;
        p->at[i] = (sl_octree_point){.position = at,
                                     .normal = n,
                                     .view = v,
                                     .diffuse = {0.8f, 0.5f, 0.3f},
                                     .exponent = 1.0f + 60.0f * sl_random_unit(key, 9 * i)};
        if (glossy) p->at[i].specular = (sl_rgb){0.2f, 0.1f, 0.15f};
    }
    return p;
}

static sl_counters shade(const sl_octree_shading *shading, points *p) {
    return shade_listed(shading, p->at, POINTS, 1, p->out[0]);
}

/* ---- the formulas as they stand, in double ---- */

static void add_voxel(const world *w, size_t place, const points *p, size_t i, double weight, double sum[3]) {
    const sl_shade_set set = sl_voxel_texture_set(w->texture, place);
    const sl_octree_point *q = &p->at[i];
    const float diffuse[3] = {q->diffuse.r, q->diffuse.g, q->diffuse.b},
                specular[3] = {q->specular.r, q->specular.g, q->specular.b};
    sl_vec3d n = sl_to_double(q->normal), v = sl_to_double(q->view);
    sl_vec3d m = sl_subd(sl_scaled(n, 2.0 * sl_dotd(n, v)), v);
    /* sharper lobes are widened to what one light stands for */
    double e = fmin((double)q->exponent, 2.0 * w->texture->lights - 2.0);
    for (int j = 0; j < set.lights; j++) {
        const float *to = set.light[j].direction;
        sl_vec3d d = sl_v3d((double)to[0], (double)to[1], (double)to[2]);
        double cosine = sl_dotd(n, d), alpha = sl_dotd(m, d);
        cosine = w->texture->lobes == SL_LOBES_SURFACE ? 1.0 : cosine > 0.0 ? cosine : 0.0;
        double lobe = alpha > 0.0 ? (e + 2.0) / (2.0 * SL_PI) * pow(alpha, e) : 0.0;
        for (int c = 0; c < 3; c++) {
            double reflect = (double)diffuse[c] / SL_PI + (double)specular[c] * lobe;
            sum[c] += weight * reflect * (double)set.light[j].color[c] * cosine;
        }
    }
}

static void expected(const world *w, const sl_octree_shading *shading, const points *p, size_t i,
                     double result[3]) {
    double total = 0.0, u[3];
    const double origin[3] = {w->octree->origin.x, w->octree->origin.y, w->octree->origin.z};
    const float at_point[3] = {p->at[i].position.x, p->at[i].position.y, p->at[i].position.z};
    bool nearest = shading->filter == SL_VOXEL_NEAREST;
    for (int d = 0; d < 3; d++)
        u[d] = ((double)at_point[d] - origin[d]) / sl_octree_voxel(w->octree) - (nearest ? 0.0 : 0.5);
    result[0] = result[1] = result[2] = 0.0;
    for (int k = 0; k < (nearest ? 1 : 8); k++) {
        double weight = 1.0;
        sl_vec3d centre;
        double *at[3] = {&centre.x, &centre.y, &centre.z};
        for (int d = 0; d < 3; d++) {
            double f = u[d] - floor(u[d]);
            if (!nearest) weight *= k >> d & 1 ? f : 1.0 - f;
            *at[d] = origin[d] + (floor(u[d]) + (k >> d & 1) + 0.5) * sl_octree_voxel(w->octree);
        }
        uint64_t fetches = 0;
        size_t place = find_at(w->texture, centre, &fetches);
        if (place == SIZE_MAX) continue;
        add_voxel(w, place, p, i, weight, result);
        total += weight;
    }
    assert_true(total >= 0.125 - 1e-6); /* the point's own voxel is a leaf */
    if (!shading->keep_void_dark) {
        for (int c = 0; c < 3; c++) result[c] /= total;
    }
}

static void pixels_are_the_sums_of_the_formulas(void **state) {
    const sl_voxel_lobes lobes[] = {SL_LOBES_PERPENDICULAR, SL_LOBES_SURFACE};
    for (int k = 0; k < 8; k++) {
        world w = new_world(k & 1 ? 5 : 3, lobes[k >> 1 & 1], RANDOM_LIGHTS);
        points *p = surface_points(w.scene, (uint64_t)k);
        sl_octree_shading shading = {.texture = w.texture,
                                     .filter = k == 3 || k == 4 ? SL_VOXEL_NEAREST : SL_VOXEL_TRILINEAR,
                                     .keep_void_dark = k == 5};
        shade(&shading, p);
        for (size_t i = 0; i < POINTS; i++) {
            double truth[3];
            expected(&w, &shading, p, i, truth);
            for (int c = 0; c < 3; c++) {
                if (!(fabs((double)p->out[i][c] - truth[c]) <= 2e-5 * truth[c] + 1e-5)) {
                    fail_msg("case %d, point %zu: %.9g, not %.9g", k, i, (double)p->out[i][c], truth[c]);
                }
            }
        }
        free(p);
        end_world(&w);
    }
}

static void a_constant_field_stays_constant(void **state) {
    for (int depth = 2; depth <= 6; depth++) {
        world w = new_world(depth, SL_LOBES_NONE, EQUAL_LIGHTS);
        for (size_t i = 0; i < w.lights->set_count; i++)
            set_light(w.lights, i, 0, sl_v3d(0, 0, 1), 2.0f, 3.0f, 0.7f);
        sl_voxel_texture_destroy(w.texture);
        w.texture = texture_of(w.octree, w.lights);
        points *p = surface_points(w.scene, 8);
        for (size_t i = 0; i < POINTS; i++) {
            p->at[i].diffuse = sl_grey((float)SL_PI);
            p->at[i].specular = sl_grey(0.0f);
        }
        sl_octree_shading shading = {.texture = w.texture};
        shade(&shading, p);
        for (size_t i = 0; i < POINTS; i++) {
            assert_true(fabsf(p->out[i][0] - 2.0f) < 2e-6f && fabsf(p->out[i][1] - 3.0f) < 3e-6f &&
                        fabsf(p->out[i][2] - 0.7f) < 1e-6f);
        }
        shading.keep_void_dark = true; /* the paper's holes */
        shade(&shading, p);
        float least = 2.0f;
        for (size_t i = 0; i < POINTS; i++) least = p->out[i][0] < least ? p->out[i][0] : least;
        assert_true(least < 1.2f && least >= 0.25f - 1e-6f);
        free(p);
        end_world(&w);
    }
}

static void light_is_continuous_along_a_surface(void **state) {
    world w = new_world(5, SL_LOBES_PERPENDICULAR, RANDOM_LIGHTS);
    points *p = surface_points(w.scene, 4);
    float jump = 0.0f, most = 0.0f;
    /* a slanted line on the floor y = 0, some voxels long, in steps of a thousandth */
    for (size_t i = 0; i < POINTS; i++) {
        p->at[i].position = sl_v3(0.3f + 1.9e-4f * (float)i, 0.0f, 0.2f + 2.3e-4f * (float)i);
        p->at[i].normal = sl_v3(0.0f, 1.0f, 0.0f);
        p->at[i].specular = sl_grey(0.0f);
    }
    sl_octree_shading shading = {.texture = w.texture};
    shade(&shading, p);
    for (size_t i = 0; i < POINTS; i++) {
        most = p->out[i][0] > most ? p->out[i][0] : most;
        if (i > 0 && fabsf(p->out[i][0] - p->out[i - 1][0]) > jump)
            jump = fabsf(p->out[i][0] - p->out[i - 1][0]);
    }
    assert_true(most > 0.1f);
    if (jump > 0.02f * most) fail_msg("a jump of %g, where %g is the most", (double)jump, (double)most);
    shading.filter = SL_VOXEL_NEAREST; /* which is not */
    shade(&shading, p);
    jump = 0.0f;
    for (size_t i = 1; i < POINTS; i++) {
        if (fabsf(p->out[i][0] - p->out[i - 1][0]) > jump) jump = fabsf(p->out[i][0] - p->out[i - 1][0]);
    }
    assert_true(jump > 0.2f * most);
    free(p);
    end_world(&w);
}

/* d fetches of the descent, the set's head and n = 3 lights; filtered 8 (d + 1 + n), less where the descent
 * ends in void. */
static void fetches_are_those_of_the_hardware(void **state) {
    world w = new_world(5, SL_LOBES_PERPENDICULAR, EQUAL_LIGHTS);
    points *p = surface_points(w.scene, 4);
    sl_octree_shading shading = {.texture = w.texture, .filter = SL_VOXEL_NEAREST};
    assert_true(shade(&shading, p).value[SL_COUNT_TEXTURE_FETCHES] == POINTS * (5 + 1 + 3));
    shading.filter = SL_VOXEL_TRILINEAR;
    uint64_t fetches = shade(&shading, p).value[SL_COUNT_TEXTURE_FETCHES];
    assert_true(fetches < POINTS * 8 * (5 + 1 + 3) && fetches > POINTS * 3 * (5 + 1 + 3));
    free(p);
    end_world(&w);
}

static void what_is_no_surface_point_is_black(void **state) {
    world w = new_world(4, SL_LOBES_PERPENDICULAR, EQUAL_LIGHTS);
    points *p = surface_points(w.scene, 4);
    const float odd[] = {NAN, INFINITY, -INFINITY, 1e30f, -3.0f, 9.0f};
    for (size_t i = 0; i < 6000; i++) {
        float *const plane[6] = {&p->at[i].position.x, &p->at[i].position.y, &p->at[i].position.z,
                                 &p->at[i].normal.x,   &p->at[i].normal.y,   &p->at[i].normal.z};
        *plane[i % 6] = odd[i / 6 % 6];
    }
    sl_octree_shading shading = {.texture = w.texture};
    for (int k = 0; k < 4; k++) {
        shading.facing = k & 1;
        shading.filter = k & 2 ? SL_VOXEL_NEAREST : SL_VOXEL_TRILINEAR;
        shade(&shading, p);
        for (size_t i = 0; i < POINTS; i++) {
            for (int c = 0; c < 3; c++) assert_true(isfinite(p->out[i][c]) && p->out[i][c] >= 0.0f);
            if (i < 6000 && i % 6 < 3 && i / 6 % 6 != 4) assert_true(p->out[i][0] == 0.0f);
        }
    }
    free(p);
    end_world(&w);
}

/* Two sheets: the floor's voxels must not take light from the wall's. */
static void facing_voxels_alone_count_where_asked(void **state) {
    const float xyz[] = {0, 0, 0, 0, 0, 4, 4, 0, 4, 0, 0, 0, 4, 0, 4, 4, 0, 0,  /* floor, normal y */
                         /* wall, normal x, on below the floor */
                         0, -1, 0, 0, 4, 0, 0, 4, 4, 0, -1, 0, 0, 4, 4, 0, -1, 4};
    sl_scene *scene = scene_of_triangles(xyz, 4);
    sl_octree *octree = octree_of(scene, 4, 1);
    sl_light_octree_settings options = plain_options(1);
    options.lobes = SL_LOBES_NONE;
    sl_voxel_lights *lights = lights_of(scene, octree, &options);
    for (size_t i = 0; i < octree->leaf_count; i++) {
        bool floor_leaf = fabsf(lights->set[i].normal.y) > 0.99f,
             wall = fabsf(lights->set[i].normal.x) > 0.99f;
        set_light(lights, i, 0, sl_v3d(0, 1, 0), floor_leaf ? 1.0f : wall ? 100.0f : 1.0f, 1, 1);
    }
    sl_voxel_texture *texture = texture_of(octree, lights);
    double voxel = sl_octree_voxel(octree), most[2] = {0};
    for (int facing = 0; facing < 2; facing++) {
        sl_octree_shading shading = {.texture = texture, .facing = facing};
        for (int i = 0; i < 200; i++) {
            float out[3];
            shade_point(&shading, sl_v3((float)(voxel * (0.01 + 0.01 * i)), 0.0f, 2.1f), sl_v3(0, 1, 0), out);
            most[facing] = (double)out[0] > most[facing] ? (double)out[0] : most[facing];
        }
    }
    if (!(most[0] > 5.0 && most[1] < 1.001 && most[1] > 0.999)) fail_msg("%g, %g", most[0], most[1]);
    destroy_octree(scene, octree, lights, texture);
}

/* A box's edge: each wall takes the light of its own group, right up to the edge. */
static void split_voxels_give_each_normal_its_own_lights(void **state) {
    float xyz[9 * 12];
    size_t count = add_box(xyz, 0, sl_v3(0, 0, 0), sl_v3(3, 3, 3), 1, NULL, NULL);
    sl_scene *scene = scene_of_triangles(xyz, count);
    sl_octree *octree = octree_of(scene, 3, 1);
    sl_light_octree_settings options = plain_options(1);
    options.lobes = SL_LOBES_NONE;
    options.whole_voxels = false;
    sl_voxel_lights *lights = lights_of(scene, octree, &options);
    /* faces are x, y, z twice: 64 voxels each, edges have two sets, corners three */
    assert_true(lights->set_count == 6 * 64);
    for (size_t i = 0; i < lights->set_count; i++) {
        sl_vec3 n = lights->set[i].normal;
        set_light(lights, i, 0, sl_v3d(0, 0, 1), fabsf(n.x) > 0.9f ? 1.0f : 0.0f,
                  fabsf(n.y) > 0.9f ? 1.0f : 0.0f, fabsf(n.z) > 0.9f ? 1.0f : 0.0f);
    }
    sl_voxel_texture *texture = texture_of(octree, lights);
    uint64_t key = sl_random_key(5, 5);
    for (uint64_t i = 0; i < 3000; i++) {
        uint32_t triangle;
        sl_vec3 at = random_on(scene, key, i, &triangle), n = sl_scene_geometric_normal(scene, triangle);
        if (i & 1) n = sl_neg(n); /* from either side */
        float out[3];
        sl_octree_shading shading = {.texture = texture,
                                     .filter = i & 2 ? SL_VOXEL_NEAREST : SL_VOXEL_TRILINEAR};
        shade_point(&shading, at, n, out);
        assert_true(fabsf(out[0] - fabsf(n.x)) < 1e-5f && fabsf(out[1] - fabsf(n.y)) < 1e-5f &&
                    fabsf(out[2] - fabsf(n.z)) < 1e-5f);
    }
    destroy_octree(scene, octree, lights, texture);
}

static void batches_and_instruction_sets_give_the_same_bits(void **state) {
    const char *isas[] = {"baseline", "avx2", "avx512"};
    const sl_voxel_lobes lobes[] = {SL_LOBES_PERPENDICULAR, SL_LOBES_SURFACE, SL_LOBES_NONE};
    for (int k = 0; k < 3; k++) {
        world w = new_world(4, lobes[k], RANDOM_LIGHTS);
        points *p = surface_points(w.scene, 4);
        sl_octree_shading shading = {.texture = w.texture, .facing = k == 1};
        shade(&shading, p);
        float(*before)[3] = malloc(sizeof p->out);
        assert_non_null(before);
        memcpy(before, p->out, sizeof p->out);
        for (int isa = 0; isa < 3; isa++) {
            assert_int_equal(setenv("SOFTLUX_ISA", isas[isa], 1), 0);
            shade_listed(&shading, p->at, POINTS, 1 + (unsigned)isa, p->out[0]);
            assert_memory_equal(before, p->out, sizeof p->out);
        }
        unsetenv("SOFTLUX_ISA");
        for (size_t i = 0; i < 300; i++) { /* alone */
            float out[3];
            shade_listed(&shading, &p->at[i], 1, 1, out);
            assert_memory_equal(out, before[i], sizeof out);
        }
        free(before);
        free(p);
        end_world(&w);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pixels_are_the_sums_of_the_formulas),
        cmocka_unit_test(a_constant_field_stays_constant),
        cmocka_unit_test(light_is_continuous_along_a_surface),
        cmocka_unit_test(fetches_are_those_of_the_hardware),
        cmocka_unit_test(what_is_no_surface_point_is_black),
        cmocka_unit_test(facing_voxels_alone_count_where_asked),
        cmocka_unit_test(split_voxels_give_each_normal_its_own_lights),
        cmocka_unit_test(batches_and_instruction_sets_give_the_same_bits),
    };
    return cmocka_run_group_tests_name("light octree: shading", tests, NULL, NULL);
}
