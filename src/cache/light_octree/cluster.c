/* K-means on the sphere. Distance is the chord |a - b|; for fixed members the best unit centre is the
 * normalised weighted mean, since |omega - d|^2 = 2 - 2 omega . d, and so J = sum w |omega - d|^2 = 2 sum
 * over clusters of (W - |S|), with W = sum w and S = sum w omega, never rises. Its worst case is
 * superpolynomial (Arthur and Vassilvitskii 2006): iterations have a cap. */
#include <string.h>

#include "base/math.h"
#include "cache/light_octree/lights.h"

/* Nearer to each other than that (squared chord), directions are one: floats are no finer. */
static const double SAME = 1e-12;

static sl_cluster_kernels kernels(void) { return sl_cluster_kernels_for(sl_isa_best()); }

static sl_vec3d direction_of(const sl_directions *d, size_t i) {
    return sl_v3d((double)d->x[i], (double)d->y[i], (double)d->z[i]);
}

static sl_vec3d unit_of(const sl_directions *d, size_t i) {
    sl_vec3d v = direction_of(d, i);
    double length = sl_lengthd(v);
    return length > 0.0 ? sl_scaled(v, 1.0 / length) : sl_v3d(0.0, 0.0, 1.0);
}

/* ---- where to start ---- */

static size_t largest_dot(const sl_directions *d, sl_vec3d mean) {
    size_t best = 0;
    double value = -INFINITY;
    for (size_t i = 0; i < d->count; i++) {
        double dot = sl_dotd(direction_of(d, i), mean);
        if (d->weight[i] > 0.0 && dot > value) {
            value = dot;
            best = i;
        }
    }
    return best;
}

/* First the point nearest to the mean, then each time the one with the largest w * chord^2 to its nearest
 * centre. */
void sl_cluster_start(const sl_directions *d, int wanted, double *nearest, sl_clusters *clusters) {
    *clusters = (sl_clusters){0};
    if (d->count == 0 || wanted < 1) return;
    if (wanted > SL_VOXEL_LIGHTS_MAX) wanted = SL_VOXEL_LIGHTS_MAX;
    sl_cluster_kernels kernel = kernels();
    sl_vec3d mean = {0};
    double largest = 0.0;
    for (size_t i = 0; i < d->count; i++) {
        mean = sl_addd(mean, sl_scaled(direction_of(d, i), d->weight[i]));
        largest = d->weight[i] > largest ? d->weight[i] : largest;
        nearest[i] = INFINITY;
    }
    if (!(largest > 0.0)) return;
    size_t chosen = largest_dot(d, mean);
    double value = INFINITY;
    while (clusters->count < wanted && value > 0.0) {
        clusters->centre[clusters->count++] = unit_of(d, chosen);
        chosen = kernel.farthest(d, direction_of(d, chosen), nearest, &value);
        if (!(nearest[chosen] > SAME)) value = 0.0;
    }
}

/* ---- one iteration ---- */

/* The last cluster takes an empty one's number. */
static void drop(int empty, size_t count, uint8_t *of, sl_clusters *clusters, sl_cluster_sums *sums) {
    int last = --clusters->count;
    clusters->centre[empty] = clusters->centre[last];
    sums->x[empty] = sums->x[last];
    sums->y[empty] = sums->y[last];
    sums->z[empty] = sums->z[last];
    sums->weight[empty] = sums->weight[last];
    sums->members[empty] = sums->members[last];
    for (size_t i = 0; i < count; i++) of[i] = of[i] == last ? (uint8_t)empty : of[i];
}

/* A vanishing mean has no direction: the heaviest member's is taken. */
static sl_vec3d heaviest(const sl_directions *d, const uint8_t *of, int cluster) {
    size_t best = 0;
    double weight = -1.0;
    for (size_t i = 0; i < d->count; i++) {
        if (of[i] == cluster && d->weight[i] > weight) {
            weight = d->weight[i];
            best = i;
        }
    }
    return unit_of(d, best);
}

static void place_centres(const sl_directions *d, const uint8_t *of, const sl_cluster_sums *sums,
                          sl_clusters *clusters) {
    double cost = 0.0;
    for (int c = 0; c < clusters->count; c++) {
        sl_vec3d sum = sl_v3d(sums->x[c], sums->y[c], sums->z[c]);
        double length = sl_lengthd(sum);
        bool vanishes = !(length > 1e-6 * sums->weight[c]);
        clusters->centre[c] = vanishes ? heaviest(d, of, c) : sl_scaled(sum, 1.0 / length);
        cost += 2.0 * (sums->weight[c] - sl_dotd(sum, clusters->centre[c]));
    }
    clusters->cost = cost > 0.0 ? cost : 0.0;
}

static size_t step(const sl_cluster_kernels *kernel, const sl_directions *d, uint8_t *of,
                   sl_clusters *clusters) {
    sl_cluster_sums sums;
    size_t changed = kernel->assign(d, clusters->count, clusters->centre, of, &sums);
    for (int c = 0; c < clusters->count; c++) {
        if (sums.members[c] == 0) drop(c--, d->count, of, clusters, &sums);
    }
    place_centres(d, of, &sums, clusters);
    clusters->iterations++;
    return changed;
}

size_t sl_cluster_step(const sl_directions *d, uint8_t *of, sl_clusters *clusters) {
    sl_cluster_kernels kernel = kernels();
    return step(&kernel, d, of, clusters);
}

/* ---- the whole ---- */

void sl_cluster_directions(const sl_directions *d, int wanted, uint8_t *of, double *scratch,
                           sl_clusters *clusters) {
    sl_cluster_kernels kernel = kernels();
    sl_cluster_start(d, wanted, scratch, clusters);
    if (clusters->count == 0) {
        memset(of, 0, d->count);
        return;
    }
    memset(of, 0xff, d->count);
    while (clusters->iterations < SL_CLUSTER_ITERATIONS && step(&kernel, d, of, clusters) > 0) {}
}
