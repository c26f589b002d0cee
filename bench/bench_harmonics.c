/* How far the finite order of the hemispherical harmonics limits glossy reflection, and what they cost.
 *
 *     build/bench/bench_harmonics            all exponents
 *     build/bench/bench_harmonics 20 100     these alone
 *
 * For every exponent s and order n: the relative L2 error of the Phong lobe at outgoing angles of 0, 45, 60 and 75 degrees; and the
 * error of reflected radiance, root mean square over random places and directions (up to 75 degrees) as a share of its own, in
 * smooth surroundings (eight broad lights, exp(4 (cos - 1))) and in hard-edged ones (a disc of 10 or of 3 degrees' radius on black),
 * where also the deepest undershoot is told, as a share of the greatest radiance (the renderer clamps it to 0). Coefficients are
 * projected almost exactly: what is measured is truncation and the lobe's table, not a gather's noise. Then nanoseconds of
 * processor time. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "timing.h"

#include "base/math.h"
#include "base/random.h"
#include "cache/hemisphere/harmonics.h"
#include "cache/hemisphere/quadrature.h"

enum { POLAR = 64, AZIMUTHS = 128, NODES = POLAR * AZIMUTHS, RINGS = 16, SPOKES = 32, DISC = RINGS * SPOKES };
enum { LIGHTS = 8, WORLDS = 12, VIEWS = 24, DISCS = 400, STRIDE = SL_HSH_STRIDE_MAX };

static const double degree = SL_PI / 180.0;

typedef struct node {
    sl_vec3d direction;
    double weight;
} node;

static double unit(uint64_t stream, uint64_t index) { return (double)sl_random_unit(sl_random_key(1, stream), index); }

static sl_vec3d polar(double theta, double phi) { return sl_v3d(sin(theta) * cos(phi), sin(theta) * sin(phi), cos(theta)); }

/* Uniform in solid angle between the zenith (or the nadir, for least_z = -1) and a height. */
static sl_vec3d random_direction(uint64_t stream, uint64_t index, double least_z) {
    return polar(acos(least_z + (1.0 - least_z) * unit(stream, 2 * index)), 2.0 * SL_PI * unit(stream, 2 * index + 1));
}

static void hemisphere_nodes(node *nodes) {
    double c[POLAR], w[POLAR];
    sl_gauss_upper_end(POLAR, c, w);
    for (int i = 0; i < POLAR; i++)
        for (int k = 0; k < AZIMUTHS; k++)
            nodes[i * AZIMUTHS + k] = (node){polar(acos(1.0 - c[i]), 2.0 * SL_PI * (k + 0.5) / AZIMUTHS), w[i] * 2.0 * SL_PI / AZIMUTHS};
}

static void disc_nodes(sl_vec3d centre, double radius, node *nodes) {
    double x[RINGS], w[RINGS];
    sl_frame frame = sl_frame_from_normal(sl_to_float(centre));
    sl_gauss_legendre(RINGS, x, w);
    for (int i = 0; i < RINGS; i++)
        for (int k = 0; k < SPOKES; k++) {
            sl_vec3d d = polar(radius * x[i], 2.0 * SL_PI * (k + 0.5) / SPOKES), across = sl_to_double(frame.x), up = sl_to_double(frame.y);
            sl_vec3d there = sl_addd(sl_addd(sl_scaled(across, d.x), sl_scaled(up, d.y)), sl_scaled(centre, d.z));
            nodes[i * SPOKES + k] = (node){there, w[i] * radius * sin(radius * x[i]) * 2.0 * SL_PI / SPOKES};
        }
}

static double smooth_radiance(uint64_t world, sl_vec3d d) {
    double sum = 0.0;
    for (uint64_t k = 0; k < LIGHTS; k++)
        sum += unit(100 + world, 1000 + k) * exp(4.0 * (sl_dotd(random_direction(100 + world, k, -1.0), d) - 1.0));
    return sum;
}

static double disc_radiance(uint64_t world, sl_vec3d d) {
    (void)world;
    (void)d;
    return 1.0;
}

typedef double radiance(uint64_t world, sl_vec3d d);

/* Light in one place: its coefficients at the highest order, and what lobes reflect of it exactly. */
typedef struct place {
    int views;
    sl_vec3d view[VIEWS];
    double lambda[STRIDE], truth[VIEWS];
} place;

static void light_place(place *p, uint64_t world, radiance *from, const node *nodes, int count, double exponent) {
    double h[STRIDE];
    memset(p->lambda, 0, sizeof p->lambda);
    memset(p->truth, 0, sizeof p->truth);
    for (int i = 0; i < count; i++) {
        sl_vec3d d = nodes[i].direction;
        double light = nodes[i].weight * from(world, d);
        sl_hsh_evaluate(SL_HSH_ORDER_MAX, d, h);
        for (size_t j = 0; j < STRIDE; j++) p->lambda[j] += light * h[j];
        for (int v = 0; v < p->views; v++) {
            sl_vec3d o = p->view[v];
            double c = o.z * d.z - o.x * d.x - o.y * d.y;
            if (c > 0.0) p->truth[v] += light * d.z * (exponent + 2.0) / (2.0 * SL_PI) * pow(c, exponent);
        }
    }
}

/* L_o by bands below `order`. */
static double reflected(const place *p, int order, const sl_phong_table *table, sl_vec3d out) {
    float even[STRIDE];
    double sum = 0.0, phi = atan2(out.y, out.x);
    sl_phong_table_look_up(table, (float)out.z, even);
    for (int l = 0; l < order; l++)
        for (int m = 0; m <= l; m++) {
            double pair = cos(m * phi) * p->lambda[sl_hsh_even(l, m)];
            if (m > 0) pair += sin(m * phi) * p->lambda[sl_hsh_odd(SL_HSH_ORDER_MAX, l, -m)];
            sum += (double)even[sl_hsh_even(l, m)] * pair;
        }
    return sum;
}

typedef struct outcome {
    double rms, undershoot;
} outcome;

static outcome outcome_of(const place *places, int count, int order, const sl_phong_table *table) {
    double square = 0.0, total = 0.0, least = 0.0, greatest = 0.0;
    for (int k = 0; k < count; k++)
        for (int v = 0; v < places[k].views; v++) {
            double truth = places[k].truth[v], value = reflected(&places[k], order, table, places[k].view[v]);
            least = value < least ? value : least;
            greatest = truth > greatest ? truth : greatest;
            double error = (value > 0.0 ? value : 0.0) - truth;
            square += error * error;
            total += truth * truth;
        }
    return (outcome){sqrt(square / total), least < 0.0 ? -least / greatest : 0.0};
}

/* The disc stands wholly above the horizon; lobes look at it, past its edge, or up to 60 degrees aside. */
static void make_disc_places(place *places, double radius, double exponent) {
    static node nodes[DISC];
    for (uint64_t k = 0; k < DISCS; k++) {
        place *p = &places[k];
        sl_vec3d centre = random_direction(7, k, cos(75.0 * degree));
        sl_frame frame = sl_frame_from_normal(sl_to_float(centre));
        disc_nodes(centre, radius, nodes);
        p->views = 0;
        for (uint64_t v = 0; v < VIEWS; v++) {
            uint64_t index = 2 * (k * VIEWS + v);
            sl_vec3d aside = polar(60.0 * degree * unit(9, index), 2.0 * SL_PI * unit(9, index + 1));
            sl_vec3d r = sl_to_double(sl_frame_to_world(&frame, sl_to_float(aside)));
            if (r.z > cos(75.0 * degree)) p->view[p->views++] = sl_v3d(-r.x, -r.y, r.z);
        }
        light_place(p, k, disc_radiance, nodes, DISC, exponent);
    }
}

static void make_smooth_places(place *places, const node *nodes, double exponent) {
    for (uint64_t w = 0; w < WORLDS; w++) {
        places[w].views = VIEWS;
        for (uint64_t v = 0; v < VIEWS; v++) places[w].view[v] = random_direction(8, w * VIEWS + v, cos(75.0 * degree));
        light_place(&places[w], w, smooth_radiance, nodes, NODES, exponent);
    }
}

static void table_of_errors(double exponent) {
    static node nodes[NODES];
    static place smooth[WORLDS], large[DISCS], small[DISCS];
    const double angles[4] = {0, 45, 60, 75};
    hemisphere_nodes(nodes);
    make_smooth_places(smooth, nodes, exponent);
    make_disc_places(large, 10.0 * degree, exponent);
    make_disc_places(small, 3.0 * degree, exponent);
    for (int order = 2; order <= SL_HSH_ORDER_MAX; order++) {
        sl_phong_table *table;
        if (sl_phong_table_create(order, exponent, &table, NULL) != SL_OK) exit(5);
        outcome in_smooth = outcome_of(smooth, WORLDS, order, table);
        outcome in_large = outcome_of(large, DISCS, order, table), in_small = outcome_of(small, DISCS, order, table);
        printf("%6g %3d ", exponent, order);
        for (int a = 0; a < 4; a++) printf(" %6.2f", 100.0 * sl_phong_truncation_at(order, exponent, angles[a] * degree));
        printf("  %8.3f %8.2f %8.2f %8.2f %8.2f%s\n", 100.0 * in_smooth.rms, 100.0 * in_large.rms, 100.0 * in_large.undershoot,
               100.0 * in_small.rms, 100.0 * in_small.undershoot,
               order == sl_phong_order(exponent, 0.05) ? "  <- least within 5 % at 45 degrees, or the largest" : "");
        sl_phong_table_destroy(table);
    }
}

/* ---- costs ------------------------------------------------------------------------------------------------------- */

enum { REPETITIONS = 7, CALLS = 20000 };

/* Keeps the optimizer from leaving out what is measured. */
static volatile float sink;

typedef struct tables {
    int order;
    sl_phong_table *lobe;
    sl_hsh_rotation *tilt;
    sl_moved_lobe *moved;
    sl_hsh_recurrence recurrence;
} tables;

typedef void call(const tables *t, uint32_t i);

static void call_evaluate(const tables *t, uint32_t i) {
    double h[STRIDE];
    sl_hsh_evaluate_by(&t->recurrence, sl_v3d(0.6, 1e-6 * i, 0.8), h);
    sink = (float)h[t->order];
}
static void call_find(const tables *t, uint32_t i) { sink = *sl_phong_table_at(t->lobe, (float)i * (1.0f / CALLS)).second; }
static void call_look_up(const tables *t, uint32_t i) {
    float even[STRIDE];
    sl_phong_table_look_up(t->lobe, (float)i * (1.0f / CALLS), even);
    sink = even[t->order];
}
static void call_tilt_at(const tables *t, uint32_t i) { sink = *sl_hsh_tilt_at(t->tilt, (float)i * (0.4f / CALLS)).even[1]; }

static void add_rows(size_t rows, size_t width, const float *v, const float *const *parts, float mix, float *restrict u) {
    for (size_t i = 0; i < rows; i++) {
        float b = v[i] * mix, a = v[i] - b;
        const float *restrict first = parts[0] + i * width, *restrict second = parts[1] + i * width;
        for (size_t j = 0; j < width; j++) u[j] += a * first[j] + b * second[j];
    }
}

/* u = D^T v of a whole vector, in plain loops for the baseline instruction set. */
static void call_tilt(const tables *t, uint32_t i) {
    float v[STRIDE], u[STRIDE] = {0.0f};
    size_t odd = sl_hsh_odd_start(t->order);
    sl_hsh_tilt tilt = sl_hsh_tilt_at(t->tilt, (float)i * (0.4f / CALLS));
    for (size_t j = 0; j < STRIDE; j++) v[j] = (float)(i + j);
    add_rows(sl_hsh_even_count(t->order), odd, v, tilt.even, tilt.mix, u);
    add_rows(sl_hsh_odd_count(t->order), sl_hsh_stride(t->order) - odd, v + odd, tilt.odd, tilt.mix, u + odd);
    sink = u[t->order];
}

/* The same lobe in another frame without D, in plain loops too. */
static void call_move(const tables *t, uint32_t i) {
    float u[STRIDE], lean = (float)i * (0.4f / CALLS);
    sl_moved_lobe_look_up(t->moved, sl_v3(0.6f, lean, 0.7f), sl_v3(lean, 0.1f, 0.9f), 0.7f, u);
    sink = u[t->order];
}

static double cost_ns(const tables *t, call *f) {
    double times[REPETITIONS];
    for (int r = 0; r < REPETITIONS; r++) {
        double begin = now_ms();
        for (uint32_t i = 0; i < CALLS; i++) f(t, i);
        times[r] = (now_ms() - begin) * 1e6 / CALLS;
    }
    return median(times, REPETITIONS);
}

static void table_of_costs(void) {
    printf("\nnanoseconds: H in a direction; rows of the lobe's table; lobe looked up; tables of a tilt; coefficients tilted; lobe moved\n"
           "instead. Made by one thread: milliseconds and KB of a lobe, of a moved lobe, of tilts up to 24 degrees\n");
    printf("%3s %8s %6s %8s %8s %8s %8s  %6s %6s %6s %6s %6s %7s\n", "n", "evaluate", "rows", "look up", "tilt at", "tilt", "move", "ms", "KB",
           "ms", "KB", "ms", "KB");
    for (int order = 2; order <= SL_HSH_ORDER_MAX; order++) {
        tables t = {.order = order};
        sl_hsh_recurrence_of(order, &t.recurrence);
        double begin = now_ms();
        if (sl_phong_table_create(order, 20.0, &t.lobe, NULL) != SL_OK) exit(5);
        double lobe = now_ms() - begin;
        begin = now_ms();
        if (sl_hsh_rotation_create(order, 24.0 * degree, SL_HSH_MIRROR, 1, &t.tilt, NULL) != SL_OK) exit(5);
        double tilt = now_ms() - begin;
        begin = now_ms();
        if (sl_moved_lobe_create(order, 20.0, &t.moved, NULL) != SL_OK) exit(5);
        double moved = now_ms() - begin;
        printf("%3d %8.1f %6.1f %8.1f %8.1f %8.1f %8.1f  %6.1f %6.1f %6.1f %6.1f %6.1f %7.1f\n", order, cost_ns(&t, call_evaluate),
               cost_ns(&t, call_find), cost_ns(&t, call_look_up), cost_ns(&t, call_tilt_at), cost_ns(&t, call_tilt),
               cost_ns(&t, call_move), lobe, (double)sl_phong_table_bytes(t.lobe) / 1024.0, moved,
               (double)sl_moved_lobe_bytes(t.moved) / 1024.0, tilt, (double)sl_hsh_rotation_bytes(t.tilt) / 1024.0);
        sl_moved_lobe_destroy(t.moved);
        sl_phong_table_destroy(t.lobe);
        sl_hsh_rotation_destroy(t.tilt);
    }
}

int main(int argc, char **argv) {
    const double usual[] = {5, 10, 15, 20, 30, 50, 100, 200};
    printf("per cent\n%6s %3s  %27s  %8s %8s %8s %8s %8s\n", "s", "n", "lobe at 0, 45, 60, 75", "smooth", "10 deg", "below 0", "3 deg",
           "below 0");
    for (int k = 1; k < argc; k++) table_of_errors(atof(argv[k]));
    for (size_t k = 0; argc == 1 && k < sizeof usual / sizeof usual[0]; k++) table_of_errors(usual[k]);
    table_of_costs();
    return 0;
}
