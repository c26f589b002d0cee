/* What tilting is for: radiance reflected by a Phong lobe at a place whose normal is not the record's, in smooth surroundings.
 * Beside the tables D stand two rivals that move the lobe instead of the
 * coefficients: aligned by its mirror direction, and exactly but for what the pixel's horizon cuts off (moved_lobe.c). */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/random.h"
#include "cache/hemisphere/quadrature.h"
#include "harmonics_support.h"

enum { POLAR = 48, AZIMUTHS = 96, NODES = POLAR * AZIMUTHS, LIGHTS = 8, WORLDS = 16, VIEWS = 32, ORDER_TOP = 10 };

typedef struct node {
    sl_vec3d direction;
    double weight;
} node;

/* Crowded at the horizon, where functions of odd m behave like the root of the cosine. */
static void make_nodes(node *nodes) {
    double c[POLAR], w[POLAR];
    sl_gauss_upper_end(POLAR, c, w);
    for (int i = 0; i < POLAR; i++)
        for (int k = 0; k < AZIMUTHS; k++) {
            double cosine = 1.0 - c[i], sine = sqrt(1.0 - cosine * cosine), phi = 2.0 * SL_PI * (k + 0.5) / AZIMUTHS;
            nodes[i * AZIMUTHS + k] = (node){sl_v3d(sine * cos(phi), sine * sin(phi), cosine), w[i] * 2.0 * SL_PI / AZIMUTHS};
        }
}

static sl_vec3d random_direction(uint64_t key, uint64_t index, double least_z) {
    double z = least_z + (1.0 - least_z) * (double)sl_random_unit(key, 2 * index);
    double phi = 2.0 * SL_PI * (double)sl_random_unit(key, 2 * index + 1);
    double sine = sqrt(1.0 - z * z);
    return sl_v3d(sine * cos(phi), sine * sin(phi), z);
}

/* Radiance from all sides: broad lights in random directions. */
static double surroundings(uint64_t world, double sharpness, sl_vec3d d) {
    uint64_t key = sl_random_key(11, world);
    double sum = 0.0;
    for (uint64_t k = 0; k < LIGHTS; k++)
        sum += (double)sl_random_unit(key, 1000 + k) * exp(sharpness * (sl_dotd(random_direction(key, k, -1.0), d) - 1.0));
    return sum;
}

typedef struct experiment {
    int order;
    double exponent, sharpness;
    node nodes[NODES];
    sl_vec3d views[VIEWS];
    double lobes[VIEWS][NODES];                 /* (s+2)/(2 pi) max(0, r . w)^s cos theta, times weights */
    double lambda[WORLDS][SL_HSH_STRIDE_MAX];   /* in the record's frame */
    double seen[WORLDS][NODES];                 /* radiance in the pixel's frame */
    sl_phong_table *table;
    sl_moved_lobe *moved;
    sl_hsh_rotation *mirror, *zero;
} experiment;

static experiment *experiment_new(int order, double exponent, double sharpness) {
    experiment *e = calloc(1, sizeof *e);
    e->order = order;
    e->exponent = exponent;
    e->sharpness = sharpness;
    make_nodes(e->nodes);
    assert_int_equal(sl_phong_table_create(order, exponent, &e->table, NULL), SL_OK);
    assert_int_equal(sl_moved_lobe_create(order, exponent, &e->moved, NULL), SL_OK);
    e->mirror = rotation_new(order, 30, SL_HSH_MIRROR);
    e->zero = rotation_new(order, 30, SL_HSH_ZERO);
    for (uint64_t v = 0; v < VIEWS; v++) {
        sl_vec3d o = e->views[v] = random_direction(sl_random_key(5, 0), v, cos(70 * degree));
        for (int i = 0; i < NODES; i++) {
            sl_vec3d d = e->nodes[i].direction;
            double c = -o.x * d.x - o.y * d.y + o.z * d.z;
            e->lobes[v][i] = e->nodes[i].weight * d.z * (exponent + 2.0) / (2.0 * SL_PI) * pow(c > 0.0 ? c : 0.0, exponent);
        }
    }
    for (int i = 0; i < NODES; i++) {
        double h[SL_HSH_STRIDE_MAX];
        sl_hsh_evaluate(order, e->nodes[i].direction, h);
        for (uint64_t w = 0; w < WORLDS; w++) {
            double radiance = e->nodes[i].weight * surroundings(w, sharpness, e->nodes[i].direction);
            for (size_t j = 0; j < sl_hsh_stride(order); j++) e->lambda[w][j] += radiance * h[j];
        }
    }
    return e;
}

static void experiment_free(experiment *e) {
    sl_phong_table_destroy(e->table);
    sl_moved_lobe_destroy(e->moved);
    sl_hsh_rotation_destroy(e->mirror);
    sl_hsh_rotation_destroy(e->zero);
    free(e);
}

/* The lobe's coefficients for an outgoing direction of any azimuth. */
static void lobe_coefficients(const experiment *e, sl_vec3d out, double *v) {
    float even[SL_HSH_STRIDE_MAX];
    double phi = atan2(out.y, out.x);
    sl_phong_table_look_up(e->table, (float)out.z, even);
    memset(v, 0, sl_hsh_stride(e->order) * sizeof *v);
    for (int l = 0; l < e->order; l++)
        for (int m = 0; m <= l; m++) {
            v[sl_hsh_even(l, m)] = cos(m * phi) * (double)even[sl_hsh_even(l, m)];
            if (m > 0) v[sl_hsh_odd(e->order, l, -m)] = sin(m * phi) * (double)even[sl_hsh_even(l, m)];
        }
}

static double albedo(const experiment *e, double cosine) {
    float even[SL_HSH_STRIDE_MAX];
    sl_phong_table_look_up(e->table, (float)cosine, even);
    return sqrt(2.0 * SL_PI) * (double)even[0];
}

typedef enum way { NONE, ZERO, MIRROR, LOBE_ALIGNED, MOVED, WAYS } way;

/* Coefficients in the record's frame that reflect towards the pixel frame's direction `out`. */
static void record_coefficients(const experiment *e, way how, double beta, sl_vec3d out, double *u) {
    double v[SL_HSH_STRIDE_MAX];
    if (how == LOBE_ALIGNED) {
        /* The lobe keeps its mirror direction r: look it up for the direction that the record's plane would reflect to r. */
        sl_vec3d r = tilted(sl_v3d(-out.x, -out.y, out.z), beta), o = sl_v3d(-r.x, -r.y, r.z);
        lobe_coefficients(e, o, u);
        for (size_t i = 0; i < sl_hsh_stride(e->order); i++) u[i] *= albedo(e, out.z) / albedo(e, o.z);
        return;
    }
    if (how == MOVED) {
        float moved[SL_HSH_STRIDE_MAX];
        sl_vec3d r = tilted(sl_v3d(-out.x, -out.y, out.z), beta), n = tilted(sl_v3d(0.0, 0.0, 1.0), beta);
        sl_moved_lobe_look_up(e->moved, sl_to_float(r), sl_to_float(n), (float)out.z, moved);
        for (size_t i = 0; i < sl_hsh_stride(e->order); i++) u[i] = (double)moved[i];
        return;
    }
    lobe_coefficients(e, out, v);
    if (how == NONE) memcpy(u, v, sl_hsh_stride(e->order) * sizeof *u);
    else tilt_back(how == MIRROR ? e->mirror : e->zero, e->order, beta, v, u);
}

static double dot(const double *a, const double *b, size_t count) {
    double sum = 0.0;
    for (size_t i = 0; i < count; i++) sum += a[i] * b[i];
    return sum;
}

/* RMS error of L_o, per cent of its RMS value, of every way. */
static void run(experiment *e, double beta, double *errors) {
    double square[WAYS] = {0}, total = 0.0;
    for (uint64_t w = 0; w < WORLDS; w++)
        for (int i = 0; i < NODES; i++) e->seen[w][i] = surroundings(w, e->sharpness, tilted(e->nodes[i].direction, beta));
    for (int v = 0; v < VIEWS; v++) {
        double u[WAYS][SL_HSH_STRIDE_MAX];
        for (int how = 0; how < WAYS; how++) record_coefficients(e, (way)how, beta, e->views[v], u[how]);
        for (int w = 0; w < WORLDS; w++) {
            double truth = dot(e->lobes[v], e->seen[w], NODES);
            total += truth * truth;
            for (int how = 0; how < WAYS; how++) {
                double error = dot(u[how], e->lambda[w], sl_hsh_stride(e->order)) - truth;
                square[how] += error * error;
            }
        }
    }
    for (int how = 0; how < WAYS; how++) errors[how] = 100.0 * sqrt(square[how] / total);
}

static void tilting_keeps_glossy_reflections_in_smooth_surroundings(void **state) {
    (void)state;
    /* Per cent at 0, 5, 10, 20, 30 degrees: without tilt at least; zero fill, mirror fill, lobe alignment, moved lobe at most.
     * Measured: none 5, 10, 19, 28 with s = 20; mirror .02 .02 .03 .13 .68, .82 .81 .85 1.0 1.6, .06 .08 .14 .42 1.2,
     * .01 .04 .10 .40 1.3; moved .02 .02 .03 .12 .68, .82 .88 .91 .92 1.4, .06 .12 .20 .44 1.1, .01 .55 1.1 2.1 3.2. */
    const struct {
        int order;
        double exponent, none[5], zero[5], mirror[5], aligned[5], moved[5];
    } tables[] = {
        {10, 20, {0, 4, 8, 16, 24}, {.02, .03, .13, 1.0, 3.8}, {.02, .03, .04, .21, 1.0}, {.02, .7, 1.3, 2.5, 4.4}, {.02, .03, .04, .21, 1.0}},
        {5, 15, {0, 4, 8, 16, 24}, {.91, 1.0, 1.25, 1.6, 4.5}, {.91, .91, .95, 1.2, 2.0}, {.91, 1.3, 1.8, 3.1, 5.0}, {.91, .91, .95, 1.2, 2.0}},
        {5, 5, {0, 4, 8, 15, 22}, {.1, .2, .4, 1.6, 4.5}, {.1, .1, .2, .5, 1.3}, {.1, 1.4, 2.5, 5.0, 7.5}, {.1, .15, .25, .5, 1.3}},
        {6, 1, {0, 3, 6, 12, 18}, {.1, .2, .5, 2.0, 5.0}, {.1, .1, .2, .5, 1.5}, {.1, 2.2, 4.2, 8.0, 12.0}, {.1, .6, 1.2, 2.4, 3.6}},
    };
    const double betas[5] = {0, 5, 10, 20, 30};
    for (size_t k = 0; k < sizeof tables / sizeof tables[0]; k++) {
        experiment *e = experiment_new(tables[k].order, tables[k].exponent, 4.0);
        for (int b = 0; b < 5; b++) {
            double errors[WAYS];
            run(e, betas[b] * degree, errors);
            assert_true(errors[NONE] >= tables[k].none[b]);
            assert_true(errors[ZERO] <= tables[k].zero[b]);
            assert_true(errors[MIRROR] <= tables[k].mirror[b]);
            assert_true(errors[LOBE_ALIGNED] <= tables[k].aligned[b]);
            assert_true(errors[MOVED] <= tables[k].moved[b]);
            if (b >= 2) assert_true(errors[MIRROR] < errors[ZERO] && errors[MIRROR] < errors[LOBE_ALIGNED]);
            if (b >= 2) assert_true(errors[MOVED] < 0.5 * errors[LOBE_ALIGNED] + 0.2);
        }
        experiment_free(e);
    }
}

static void two_tilts_are_nearly_one(void **state) {
    (void)state;
    experiment *e = experiment_new(10, 20, 4.0);
    double square = 0.0, total = 0.0;
    for (int v = 0; v < VIEWS; v++) {
        double lobe[SL_HSH_STRIDE_MAX], once[SL_HSH_STRIDE_MAX], half[SL_HSH_STRIDE_MAX], twice[SL_HSH_STRIDE_MAX];
        lobe_coefficients(e, e->views[v], lobe);
        tilt_back(e->mirror, e->order, 10 * degree, lobe, once);
        tilt_back(e->mirror, e->order, 5 * degree, lobe, half);
        tilt_back(e->mirror, e->order, 5 * degree, half, twice);
        for (int w = 0; w < WORLDS; w++) {
            double a = dot(once, e->lambda[w], sl_hsh_stride(e->order)), b = dot(twice, e->lambda[w], sl_hsh_stride(e->order));
            square += (a - b) * (a - b);
            total += a * a;
        }
    }
    assert_true(sqrt(square / total) < 1e-3);
    experiment_free(e);
}

/* Z(angle) of a vector: the functions' pairs of equal l and |m| turn by m times the angle. */
static void turn(int order, double angle, double *v) {
    for (int l = 1; l < order; l++)
        for (int m = 1; m <= l; m++) {
            double *even = &v[sl_hsh_even(l, m)], *odd = &v[sl_hsh_odd(order, l, -m)], c = cos(m * angle), s = sin(m * angle);
            double turned = c * *even - s * *odd;
            *odd = s * *even + c * *odd;
            *even = turned;
        }
}

/* The whole way between two frames as they are made from normals: the pixel's direction a is the record's R_z(alpha) R_y(beta)
 * R_z(-gamma) a, so a lobe's coefficients turn by -gamma, tilt by the transpose, and turn by alpha. */
static void coefficients_travel_between_frames_of_normals(void **state) {
    (void)state;
    experiment *e = experiment_new(10, 20, 4.0);
    uint64_t key = sl_random_key(21, 0);
    double square = 0.0, moved_square = 0.0, total = 0.0;
    for (uint64_t k = 0; k < 24; k++) {
        sl_vec3 n_k = sl_to_float(random_direction(key, 2 * k, -1.0));
        sl_vec3 n = sl_normalize_or(sl_mad(n_k, 0.25f, sl_to_float(random_direction(key, 2 * k + 1, -1.0))), n_k);
        sl_frame record = sl_frame_from_normal(n_k), pixel = sl_frame_from_normal(n);
        sl_vec3 there = sl_frame_to_local(&record, n), back = sl_frame_to_local(&pixel, n_k);
        double beta = atan2(hypot((double)there.x, (double)there.y), (double)there.z);
        double alpha = atan2((double)there.y, (double)there.x), gamma = atan2(-(double)back.y, -(double)back.x);
        double u[SL_HSH_STRIDE_MAX], v[SL_HSH_STRIDE_MAX], lambda[SL_HSH_STRIDE_MAX] = {0}, truth = 0.0;
        int view = (int)k;
        lobe_coefficients(e, e->views[view], v);
        turn(e->order, -gamma, v);
        tilt_back(e->mirror, e->order, beta, v, u);
        turn(e->order, alpha, u);
        for (int i = 0; i < NODES; i++) {
            double h[SL_HSH_STRIDE_MAX];
            sl_vec3 d = sl_to_float(e->nodes[i].direction);
            sl_hsh_evaluate(e->order, e->nodes[i].direction, h);
            double radiance = e->nodes[i].weight * surroundings(3, e->sharpness, sl_to_double(sl_frame_to_world(&record, d)));
            for (size_t j = 0; j < sl_hsh_stride(e->order); j++) lambda[j] += radiance * h[j];
            truth += e->lobes[view][i] * surroundings(3, e->sharpness, sl_to_double(sl_frame_to_world(&pixel, d)));
        }
        double error = dot(u, lambda, sl_hsh_stride(e->order)) - truth;
        square += error * error;
        total += truth * truth;
        /* The other way: the mirror direction and the normal, seen from the record. */
        float moved[SL_HSH_STRIDE_MAX];
        sl_vec3d o = e->views[view];
        sl_vec3 r = sl_frame_to_local(&record, sl_frame_to_world(&pixel, sl_v3((float)-o.x, (float)-o.y, (float)o.z)));
        sl_moved_lobe_look_up(e->moved, r, there, (float)o.z, moved);
        for (size_t i = 0; i < sl_hsh_stride(e->order); i++) u[i] = (double)moved[i];
        error = dot(u, lambda, sl_hsh_stride(e->order)) - truth;
        moved_square += error * error;
    }
    assert_true(sqrt(square / total) < 2e-3);
    assert_true(sqrt(moved_square / total) < 2e-3);
    experiment_free(e);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tilting_keeps_glossy_reflections_in_smooth_surroundings),
        cmocka_unit_test(two_tilts_are_nearly_one),
        cmocka_unit_test(coefficients_travel_between_frames_of_normals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
