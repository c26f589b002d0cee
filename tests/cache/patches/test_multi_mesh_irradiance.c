/* Irradiance meshes: each light has its own, refined where radiance asks for it and its own shadows are, and
 * nowhere else. */
#include "light_sample_support.h"

#include "cache/patches/irradiance.h"

enum { DEPTH = 6, LEFT = 0, RIGHT = 1 };

typedef struct lit_floor {
    light_world world;
    sl_primitives *primitives;
    sl_irradiance_meshes *meshes;
    sl_counters counters;
} lit_floor;

/* A floor of two triangles, a lamp over its left half and one over its right; and, if asked for, a plate
 * below the left one that the other's light passes. */
static void make_with(lit_floor *f, bool plate, bool few_rays, float ambient) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t grey = trace_mesh_diffuse(&mesh, 0.5f);
    trace_mesh_quad(&mesh, sl_v3(-8, 0, -8), sl_v3(0, 0, 16), sl_v3(16, 0, 0), grey);
    add_ceiling_light(&mesh, -5, -0.5f, 1, 1, 3);
    add_ceiling_light(&mesh, 4, -0.5f, 1, 1, 3.25f);
    if (plate) trace_mesh_quad(&mesh, sl_v3(-5, 1.5f, -0.5f), sl_v3(0, 0, 1), sl_v3(1, 0, 0), grey);
    *f = (lit_floor){.counters = {{0}}};
    f->world = light_world_make(&mesh);
    assert_int_equal(f->world.lights->count, 2);
    assert_int_equal(sl_primitives_of_triangles(f->world.scene, &f->primitives, NULL), SL_OK);
    sl_irradiance_settings s = {.scene = f->world.scene,
                                .primitives = f->primitives,
                                .tracer = f->world.tracer,
                                .lights = f->world.lights,
                                .sampling = f->world.sampling,
                                .perception = {.exposure = 30.0f, .threshold_scale = 4.0f},
                                .ambient = sl_grey(ambient),
                                .few_rays = few_rays,
                                .max_depth = 12,
                                .threads = 1};
    assert_int_equal(sl_irradiance_meshes_create(&s, &f->meshes, NULL), SL_OK);
}

static void make(lit_floor *f, bool plate) { make_with(f, plate, false, 0.01f); }

static void discard(lit_floor *f) {
    sl_irradiance_meshes_destroy(f->meshes);
    sl_primitives_destroy(f->primitives);
    light_world_free(&f->world);
}

/* Asks for all of the floor at a grid of 2^depth a side, as if leaves three levels deep were small enough. */
static void ask(lit_floor *f, int depth) {
    uint32_t step = SL_PATCH_DYADIC >> depth;
    for (uint32_t face = 0; face <= 2; face += 2) {
        for (uint32_t q = 0; q <= SL_PATCH_DYADIC; q += step) {
            for (uint32_t p = 0; p + q <= SL_PATCH_DYADIC; p += step) {
                sl_face_point x = {.at = {face, (uint16_t)p, (uint16_t)q},
                                   .wanted_depth = depth < 3 ? depth : 3};
                float share[2];
                bool valid;
                assert_int_equal(sl_irradiance_at(f->meshes, 1, &x, share, &valid, &f->counters, NULL),
                                 SL_OK);
                assert_true(valid && share[0] >= 0.0f && share[0] <= 1.0f && share[1] >= 0.0f &&
                            share[1] <= 1.0f);
            }
        }
    }
}

static int deepest_below(const sl_patches *mesh, const sl_patch_place *place) {
    int deepest = place->depth;
    if (sl_patch_is_leaf(mesh, place->patch)) return deepest;
    for (int c = 0; c < 4; c++) {
        sl_patch_place child = sl_patch_child_place(mesh, place, c);
        int below = deepest_below(mesh, &child);
        deepest = below > deepest ? below : deepest;
    }
    return deepest;
}

static int deepest_of(const lit_floor *f, size_t light) {
    const sl_patches *mesh = sl_irradiance_mesh(f->meshes, light);
    int deepest = 0;
    for (uint32_t face = 0; face <= 2; face += 2) {
        sl_patch_place root = sl_patch_root_place(mesh, face);
        int below = deepest_below(mesh, &root);
        deepest = below > deepest ? below : deepest;
    }
    return deepest;
}

static void an_occluder_of_one_light_leaves_the_other_lights_mesh_as_it_was(void **state) {
    size_t leaves[2][2], vertices[2][2];
    for (int plate = 0; plate < 2; plate++) {
        lit_floor f;
        make(&f, plate == 1);
        ask(&f, DEPTH);
        for (size_t l = 0; l < 2; l++) {
            leaves[plate][l] = sl_irradiance_mesh(f.meshes, l)->leaves_alive;
            vertices[plate][l] = sl_irradiance_mesh(f.meshes, l)->vertex_count;
        }
        print_message("%s a plate: left lamp %zu leaves, right lamp %zu\n", plate ? "with" : "without",
                      leaves[plate][LEFT], leaves[plate][RIGHT]);
        discard(&f);
    }
    assert_true(leaves[1][LEFT] > leaves[0][LEFT]);
    assert_int_equal(leaves[1][RIGHT], leaves[0][RIGHT]);
    assert_int_equal(vertices[1][RIGHT], vertices[0][RIGHT]);
}

static void no_leaf_is_deeper_than_what_was_asked_for(void **state) {
    for (int depth = 0; depth <= DEPTH; depth += 2) {
        lit_floor f;
        make(&f, true);
        ask(&f, depth);
        for (size_t l = 0; l < 2; l++) assert_true(deepest_of(&f, l) <= depth);
        discard(&f);
    }
}

/* Values found once are not sampled again, and lie between their leaf's corners where they were not. */
static void a_light_without_shadows_stays_coarse_and_is_sampled_once(void **state) {
    lit_floor f;
    make(&f, false);
    ask(&f, DEPTH);
    uint64_t samples = f.counters.value[SL_COUNT_LIGHT_SAMPLES];
    /* lights x faces x points */
    uint64_t grid = 2 * 2 * (uint64_t)((1 << DEPTH) + 1) * ((1 << DEPTH) + 2) / 2;
    print_message("%llu samples for %llu points and lights\n", (unsigned long long)samples,
                  (unsigned long long)grid);
    assert_true(4 * samples < grid);
    ask(&f, DEPTH);
    assert_int_equal(f.counters.value[SL_COUNT_LIGHT_SAMPLES], samples);
    discard(&f);
}

/* At a point of an edge of the floor's front: F of both lamps, and how many shadow rays that took. */
static uint64_t ask_one(bool few_rays, float ambient, uint16_t q, float share[2]) {
    lit_floor f;
    bool valid;
    make_with(&f, true, few_rays, ambient);
    sl_face_point x = {.at = {0, 0, q}};
    for (int round = 0; round < 2; round++)
        assert_int_equal(sl_irradiance_at(f.meshes, 1, &x, share, &valid, &f.counters, NULL), SL_OK);
    assert_true(valid);
    discard(&f);
    return f.counters.value[SL_COUNT_SHADOW_RAYS];
}

/* In two of the floor's corners, where ambient light is most of all; between them; and without ambient light
 * in the first again, where the left lamp gives nearly all. */
static void a_lamp_that_gives_little_beside_others_is_sampled_by_few_rays(void **state) {
    static const uint16_t place[4] = {0, SL_PATCH_DYADIC, SL_PATCH_DYADIC / 2, 0};
    static const uint64_t expected[4] = {2 * 4 * 4, 2 * 4 * 4, 2 * 8 * 8, 8 * 8};
    for (int k = 0; k < 4; k++) {
        float by_pictures[2], by_rays[2];
        float ambient = k < 3 ? 0.01f : 0.0f;
        assert_int_equal(ask_one(false, ambient, place[k], by_pictures), 0);
        uint64_t rays = ask_one(true, ambient, place[k], by_rays);
        float sum = by_pictures[LEFT] + by_pictures[RIGHT];
        for (int l = 0; l < 2; l++) assert_true(fabsf(by_rays[l] - by_pictures[l]) < 0.02f * sum);
        print_message("F %.5f and %.5f, by rays %.5f and %.5f: %llu rays\n", (double)by_pictures[LEFT],
                      (double)by_pictures[RIGHT], (double)by_rays[LEFT], (double)by_rays[RIGHT],
                      (unsigned long long)rays);
        assert_int_equal(rays, expected[k]);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_occluder_of_one_light_leaves_the_other_lights_mesh_as_it_was),
        cmocka_unit_test(no_leaf_is_deeper_than_what_was_asked_for),
        cmocka_unit_test(a_light_without_shadows_stays_coarse_and_is_sampled_once),
        cmocka_unit_test(a_lamp_that_gives_little_beside_others_is_sampled_by_few_rays),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
