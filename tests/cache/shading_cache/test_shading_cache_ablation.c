/* What each part of the choice of pixels is worth: the loop from priorities to work on a wall whose shading
 * is a function known everywhere, so that the error of what is shown is known, too, after any number of
 * samples. */
#include <math.h>

#include "base/math.h"
#include "cache/shading_cache/work.h"
#include "shading_cache_support.h"

enum { SIZE = 128, PIXELS = SIZE * SIZE, ROOTS = 4, POINTS = 64, CHOICES = 2 * POINTS };

static const sl_display_curve curve = {.reference = 0.3f};

/* ---- what is to be shown ---- */

static bool in_spot(double x, double y) {
    return (x + 0.61) * (x + 0.61) + (y - 0.37) * (y - 0.37) < 0.05 * 0.05;
}

/* A gentle gradient, a slanting shadow, and one of a small thing that lies inside of one of the first
 * patches. */
static float with_shadows(double x, double y) {
    double light = 1.5 + 0.4 * x - 0.2 * y * y;
    if (0.8 * x + 0.55 * y > 0.25) light *= 0.2;
    return (float)(in_spot(x, y) ? 0.1 * light : light);
}

static float even_but_for_a_spot(double x, double y) { return in_spot(x, y) ? 0.1f : 1.5f; }

static float (*shown)(double x, double y);

/* ---- the wall ---- */

typedef struct wall {
    hierarchy h;
    sl_camera camera;
    uint32_t patch[PIXELS];
    float u[PIXELS], v[PIXELS];
    uint32_t leaf[PIXELS];
    sl_leaf_priority leaves[PIXELS];
    size_t leaf_count, samples;
    sl_choice choice[CHOICES];
} wall;

static void wall_point(int pixel, double *x, double *y) {
    *x = 2.0 * ((double)(pixel % SIZE) + 0.5) / SIZE - 1.0;
    *y = 2.0 * ((double)(pixel / SIZE) + 0.5) / SIZE - 1.0;
}

/* Fronts of squares, in rows. */
static uint32_t root_at(double x, double y) {
    return 2 * ((uint32_t)(0.5 * ROOTS * (x + 1.0)) + ROOTS * (uint32_t)(0.5 * ROOTS * (y + 1.0)));
}

static void wall_begin(wall *w) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_material(&mesh, 0.5f, 0, 0, 0, 0);
    for (int i = 0; i < ROOTS * ROOTS; i++) {
        float side = 2.0f / ROOTS;
        trace_mesh_quad(&mesh, sl_v3(-1.0f + side * (float)(i % ROOTS), -1.0f + side * (float)(i / ROOTS), 0),
                        sl_v3(side, 0, 0), sl_v3(0, side, 0), 0);
    }
    w->h = hierarchy_of(trace_mesh_build(&mesh), 0);
    assert_int_equal(w->h.primitives->count, ROOTS * ROOTS);
    for (uint32_t i = 0; i < ROOTS * ROOTS; i++) want_root(&w->h, 2 * i);
    w->camera = (sl_camera){sl_v3(0, 0, 1.0f / (float)sl_tan(0.5)), sl_v3(1, 0, 0), sl_v3(0, 1, 0),
                            sl_v3(0, 0, 1), 1.0f};
    w->samples = 0;
}

static void see(wall *w) {
    w->leaf_count = 0;
    uint32_t *leaf_of_patch = malloc(w->h.patches->patch_count * sizeof *leaf_of_patch);
    assert_non_null(leaf_of_patch);
    memset(leaf_of_patch, 0xff, w->h.patches->patch_count * sizeof *leaf_of_patch);
    for (int i = 0; i < PIXELS; i++) {
        double x, y;
        wall_point(i, &x, &y);
        w->u[i] = (float)(0.5 * ROOTS * (x + 1.0) - floor(0.5 * ROOTS * (x + 1.0)));
        w->v[i] = (float)(0.5 * ROOTS * (y + 1.0) - floor(0.5 * ROOTS * (y + 1.0)));
        w->patch[i] = sl_patch_locate(w->h.patches, root_at(x, y), (double)w->u[i], (double)w->v[i]).patch;
        uint32_t *leaf = &leaf_of_patch[w->patch[i]];
        if (*leaf == SL_NO_INDEX) {
            *leaf = (uint32_t)w->leaf_count;
            w->leaves[w->leaf_count++] = (sl_leaf_priority){
                w->patch[i], 0, sl_patch_priority(w->h.patches, &curve, w->patch[i], 1, 0, 0), 0.0f};
        }
        w->leaves[*leaf].pixels++;
        w->leaf[i] = *leaf;
    }
    free(leaf_of_patch);
}

/* One update of the loop, with samples that are exact. */
static void update(wall *w, const sl_selection_settings *selection, bool plain) {
    static uint32_t vertex[(4 + SL_HANGING_A_PATCH) * CHOICES + 64];
    sl_chosen_place place[CHOICES];
    sl_counters counters = {0};
    static sl_object_change object[ROOTS];
    const sl_changes still = {.object_count = ROOTS, .object = object};
    sl_view view = sl_view_of_camera(w->h.scene, &w->camera, SIZE, SIZE);
    sl_work_settings work = {.view = &view,
                             .curve = &curve,
                             .changes = &still,
                             .split_above = 1.2f,
                             .levels = 3,
                             .crowd = 4,
                             .now = 1};
    size_t count, vertices;
    see(w);
    sl_priorities_normalise(w->leaf_count, w->leaves, plain);
    assert_int_equal(sl_select_pixels(selection, SIZE, SIZE, w->leaf, w->leaf_count, w->leaves, w->choice,
                                      &count, &counters, NULL),
                     SL_OK);
    for (size_t i = 0; i < count; i++) {
        uint32_t pixel = w->choice[i].pixel;
        place[i] = (sl_chosen_place){w->patch[pixel], w->u[pixel], w->v[pixel]};
    }
    assert_int_equal(sl_work_out(w->h.patches, &work, count, place, vertex, &vertices, &counters, NULL),
                     SL_OK);
    for (size_t i = 0; i < vertices; i++) {
        const sl_patch_vertex *v = &w->h.patches->vertex[vertex[i]];
        sl_vec3 p = sl_root_position(w->h.primitives, v->root, v->u, v->v);
        evaluate(&w->h, vertex[i], shown((double)p.x, (double)p.y), 1);
    }
    w->samples += vertices;
}

/* RMS in grey levels. */
static double error_of(const wall *w) {
    double sum = 0.0;
    for (int i = 0; i < PIXELS; i++) {
        double x, y;
        wall_point(i, &x, &y);
        sl_patch_place leaf = sl_patch_locate(w->h.patches, root_at(x, y), (double)w->u[i], (double)w->v[i]);
        float value[3] = {0, 0, 0}, scale = 0.5f / (float)SL_PI;
        sl_patch_value(w->h.patches, &leaf, (double)w->u[i], (double)w->v[i], value);
        double d = (double)sl_curve_level_of(&curve, scale * value[0]) -
                   (double)sl_curve_level_of(&curve, scale * shown(x, y));
        sum += d * d;
    }
    return sqrt(sum / PIXELS);
}

/* ---- variants ---- */

enum { STEPS = 4, SEEDS = 3 };
static const size_t samples_at[STEPS] = {500, 1000, 2000, 4000};

typedef struct variant {
    sl_pixel_selection how;
    float flood, random;
    bool plain;
} variant;

static const variant both = {SL_PIXELS_HIT_AND_TEST, 0.5f, 0.03f, false};

/* Mean errors after so many samples, or when twenty updates in a row asked for none. */
static void measure(const variant *way, double error[STEPS]) {
    static wall w;
    for (int k = 0; k < STEPS; k++) error[k] = 0.0;
    for (uint64_t seed = 1; seed <= SEEDS; seed++) {
        sl_selection_settings s = {.how = way->how,
                                   .points = POINTS,
                                   .random_share = way->random,
                                   .flood_threshold = way->flood,
                                   .per_patch = 16,
                                   .seed = seed};
        int idle = 0;
        wall_begin(&w);
        for (int k = 0; k < STEPS; k++) {
            while (w.samples < samples_at[k] && idle < 20) {
                size_t before = w.samples;
                s.update++;
                update(&w, &s, way->plain);
                idle = w.samples == before ? idle + 1 : 0;
            }
            error[k] += error_of(&w) / SEEDS;
        }
        hierarchy_discard(&w.h);
    }
}

static void hits_and_floods_together_beat_either_alone_and_sorting(void **state) {
    (void)state;
    shown = with_shadows;
    double two[STEPS], hits[STEPS], sorted[STEPS];
    variant v = both;
    measure(&v, two);
    v.flood = 2.0f;
    measure(&v, hits);
    v.how = SL_PIXELS_SORTED;
    measure(&v, sorted);
    for (int k = 1; k < STEPS; k++) assert_true(two[k] < two[k - 1] && hits[k] < hits[k - 1]);
    for (int k = 0; k < STEPS; k++) assert_true(two[k] < hits[k]);
    /* patches of a pixel at the shadow's edge stay the first for ever */
    assert_true(two[3] < 0.95 * sorted[3]);
}

static void clamped_priorities_need_half_the_samples_of_printed_ones(void **state) {
    (void)state;
    shown = with_shadows;
    double clamped[STEPS], plain[STEPS];
    variant v = both;
    measure(&v, clamped);
    v.plain = true;
    measure(&v, plain);
    for (int k = 0; k < STEPS; k++) assert_true(clamped[k] < plain[k]);
    for (int k = 0; k + 1 < STEPS; k++) assert_true(clamped[k] < plain[k + 1]);
}

static void a_shadow_within_an_even_wall_is_found_by_chance_or_never(void **state) {
    (void)state;
    shown = even_but_for_a_spot;
    double with[STEPS], without[STEPS];
    variant v = both;
    measure(&v, with);
    v.random = 0.0f;
    measure(&v, without);
    assert_true(without[0] > 1.0 && without[3] == without[0] && with[3] < 0.5 * without[3]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hits_and_floods_together_beat_either_alone_and_sorting),
        cmocka_unit_test(clamped_priorities_need_half_the_samples_of_printed_ones),
        cmocka_unit_test(a_shadow_within_an_even_wall_is_found_by_chance_or_never),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
