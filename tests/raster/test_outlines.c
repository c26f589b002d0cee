/* Outlines: where a pixel may show more than one surface. */
#include "gather_world.h"
#include "raster/views/outlines.h"
#include "raster_support.h"

#include "base/math.h"

enum { SIDE = 64, PIXELS = SIDE * SIDE };

typedef struct outlined {
    uint8_t touched[PIXELS];
    uint32_t id[PIXELS];
} outlined;

/* From the origin along -z, 90 degrees wide. */
static void outline(world *w, outlined *o) {
    static float depth[PIXELS];
    sl_outlines *outlines;
    world_build(w);
    assert_true(sl_camera_look_at(&w->scene->camera, sl_v3(0, 0, 0), sl_v3(0, 0, -1), sl_v3(0, 1, 0),
                                  (float)(0.5 * SL_PI)));
    const sl_view view = sl_view_scene(w->scene, SIDE, SIDE);
    const sl_target target = {SIDE, SIDE, o->id, depth};
    memset(o->touched, 0, sizeof o->touched);
    assert_int_equal(sl_outlines_create(w->scene, &outlines, NULL), SL_OK);
    assert_int_equal(sl_raster_id(w->raster, &view, 1, &target, &w->counters, NULL), SL_OK);
    assert_int_equal(sl_outlines_draw(outlines, &view, depth, o->touched, NULL), SL_OK);
    sl_outlines_destroy(outlines);
}

static size_t touched_within(const outlined *o, int x0, int y0, int x1, int y1) {
    size_t count = 0;
    for (int y = y0; y < y1; y++)
        for (int x = x0; x < x1; x++) count += o->touched[y * SIDE + x];
    return count;
}

static void borders_are_outlines_and_diagonals_are_not(void **state) {
    static outlined o;
    world *w = world_new();
    world_wall(w, SIDE, 16.5f, 16.5f, 48.5f, 48.5f, 4, world_material(w, sl_grey(0.5f), sl_grey(0)));
    outline(w, &o);
    assert_int_equal(touched_within(&o, 18, 18, 47, 47), 0);
    assert_int_equal(touched_within(&o, 0, 0, SIDE, SIDE), touched_within(&o, 15, 15, 50, 50));
    for (int k = 16; k <= 48; k++) {
        assert_true(o.touched[16 * SIDE + k] && o.touched[48 * SIDE + k]);
        assert_true(o.touched[k * SIDE + 16] && o.touched[k * SIDE + 48]);
    }
    world_free(w);
}

static void what_is_hidden_has_no_outline(void **state) {
    static outlined o;
    world *w = world_new();
    const uint32_t grey = world_material(w, sl_grey(0.5f), sl_grey(0));
    world_wall(w, SIDE, -8, -8, 72, 72, 2, grey);
    world_wall(w, SIDE, 20, 20, 40, 40, 3, grey);
    outline(w, &o);
    assert_int_equal(touched_within(&o, 0, 0, SIDE, SIDE), 0);
    world_free(w);
}

static void where_the_material_changes_is_an_outline(void **state) {
    static outlined o;
    world *w = world_new();
    world_wall(w, SIDE, -8, -8, 32, 72, 2, world_material(w, sl_grey(0.5f), sl_grey(0)));
    world_wall(w, SIDE, 32, -8, 72, 72, 2, world_material(w, sl_grey(0.2f), sl_grey(0)));
    outline(w, &o);
    for (int y = 0; y < SIDE; y++) assert_true(o.touched[y * SIDE + 31] && o.touched[y * SIDE + 32]);
    assert_int_equal(touched_within(&o, 0, 0, 29, SIDE) + touched_within(&o, 35, 0, SIDE, SIDE), 0);
    world_free(w);
}

static void a_hair_that_no_sample_meets_is_an_outline_along_all_its_length(void **state) {
    static outlined o;
    world *w = world_new();
    const uint32_t grey = world_material(w, sl_grey(0.5f), sl_grey(0));
    world_wall(w, SIDE, -8, -8, 72, 72, 4, grey);
    world_wall(w, SIDE, 20.2f, -8, 20.201f, 72, 2, grey);
    outline(w, &o);
    for (int y = 0; y < SIDE; y++) {
        assert_true(o.touched[y * SIDE + 20]);
        assert_true(o.id[y * SIDE + 20] < 2);
    }
    world_free(w);
}

static void a_smooth_sphere_has_its_silhouette_alone(void **state) {
    static outlined o;
    world *w = world_new();
    uint32_t grey = world_material(w, sl_grey(0.5f), sl_grey(0));
    world_sphere(w, 1.0f, 48, &grey, 1);
    for (size_t i = 0; i < w->vertices; i++) w->positions[3 * i + 2] -= 3.0f;
    outline(w, &o);
    for (int y = 0; y < SIDE; y++) {
        for (int x = 0; x < SIDE; x++) {
            /* the sphere's outline is a circle of tangent 1 / sqrt(8) */
            const double dx = x + 0.5 - SIDE / 2, dy = y + 0.5 - SIDE / 2,
                         off = sqrt(dx * dx + dy * dy) - SIDE / 2 / sqrt(8.0);
            if (fabs(off) > 4.0) assert_false(o.touched[y * SIDE + x]);
            if (fabs(off) < 0.3) assert_true(o.touched[y * SIDE + x]);
        }
    }
    world_free(w);
}

/* Each in a slab of its own, so that they do not meet: before each other, or above each other like floors, of
 * which many lie across the eye. */
static void add_random_triangle(world *w, uint64_t key, float slab, bool floors, uint32_t material) {
    const float spread = random_between(key, 0, 0.01f, 6.0f);
    sl_vec3 p[3];
    for (uint64_t k = 0; k < 3; k++) {
        const float a = random_between(key, 1, -6, 6) + spread * random_between(key, 10 + k, -1, 1),
                    b = random_between(key, 2, -9, 3) + spread * random_between(key, 20 + k, -1, 1),
                    within = slab + random_between(key, 30 + k, -0.04f, 0.04f);
        p[k] = floors ? sl_v3(a, within, b) : sl_v3(a, b + 3, within);
    }
    world_quad(w, p[0], p[1], p[2], p[2], material);
}

static void two_surfaces_in_a_pixel_are_never_missed(void **state) {
    enum { SCENES = 16, TRIANGLES = 120, LOOKS = 8 };
    static outlined o;
    static uint32_t seen[LOOKS][PIXELS];
    size_t edges = 0;
    for (uint64_t n = 0; n < SCENES; n++) {
        world *w = world_new();
        const uint32_t grey = world_material(w, sl_grey(0.5f), sl_grey(0));
        for (uint64_t i = 0; i < TRIANGLES; i++)
            add_random_triangle(w, sl_random_key(n, i), -6.0f + 0.1f * (float)i + 0.05f, n % 2, grey);
        outline(w, &o);
        for (uint64_t k = 0; k < LOOKS; k++) {
            const uint64_t key = sl_random_key(n, TRIANGLES + k);
            w->scene->sub_frame = (sl_sub_frame){.right = random_between(key, 0, -0.5f, 0.5f),
                                                 .up = random_between(key, 1, -0.5f, 0.5f)};
            const sl_view view = sl_view_scene(w->scene, SIDE, SIDE);
            const sl_target target = {SIDE, SIDE, seen[k], NULL};
            assert_int_equal(sl_raster_id(w->raster, &view, 1, &target, &w->counters, NULL), SL_OK);
        }
        for (size_t i = 0; i < PIXELS; i++) {
            bool one = true;
            for (int k = 1; k < LOOKS; k++) one = one && seen[k][i] == seen[0][i];
            edges += !one;
            if (!one) assert_true(o.touched[i]);
        }
        world_free(w);
    }
    assert_true(edges > 2000);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(borders_are_outlines_and_diagonals_are_not),
        cmocka_unit_test(what_is_hidden_has_no_outline),
        cmocka_unit_test(where_the_material_changes_is_an_outline),
        cmocka_unit_test(a_hair_that_no_sample_meets_is_an_outline_along_all_its_length),
        cmocka_unit_test(a_smooth_sphere_has_its_silhouette_alone),
        cmocka_unit_test(two_surfaces_in_a_pixel_are_never_missed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
