/* K-means on the sphere. Distance is the chord |a - b|; for fixed members the best unit centre is the
 * normalised weighted mean, since |omega - d|^2 = 2 - 2 omega . d, and so J = sum w |omega - d|^2 = 2 sum
 * over clusters of (W - |S|), with W = sum w and S = sum w omega, never rises. Its worst case is
 * superpolynomial (Arthur and Vassilvitskii 2006): iterations have a cap.
 *
 * Eight points at a time: sums are kept in eight lanes, point i in lane i mod 8, and joined in a fixed order
 * at the end, so that every instruction set gives the same bits. */
#include "cache/light_octree/voxel_lights.h"

#include <string.h>

enum { LANES = 8 };

/* Nearer to each other than that (squared chord), directions are one: floats are no finer. */
static const double SAME = 1e-12;

/* ---- points ---- */

static sl_vec3d direction_of(const sl_directions *d, size_t i) {
    return sl_v3d((double)d->x[i], (double)d->y[i], (double)d->z[i]);
}

static sl_vec3d unit_of(const sl_directions *d, size_t i) {
    sl_vec3d v = direction_of(d, i);
    double length = sl_lengthd(v);
    return length > 0.0 ? sl_scaled(v, 1.0 / length) : sl_v3d(0.0, 0.0, 1.0);
}

/* Eight points in double; beyond the end of the list weight is 0. */
typedef struct points {
    double x[LANES], y[LANES], z[LANES], weight[LANES];
} points;

static inline points load(const sl_directions *d, size_t first) {
    points p;
    if (first + LANES <= d->count) {
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            p.x[l] = (double)d->x[first + (size_t)l];
            p.y[l] = (double)d->y[first + (size_t)l];
            p.z[l] = (double)d->z[first + (size_t)l];
            p.weight[l] = d->weight[first + (size_t)l];
        }
        return p;
    }
    for (size_t l = 0; l < LANES; l++) {
        size_t i = first + l < d->count ? first + l : d->count - 1;
        p.x[l] = (double)d->x[i];
        p.y[l] = (double)d->y[i];
        p.z[l] = (double)d->z[i];
        p.weight[l] = first + l < d->count ? d->weight[i] : 0.0;
    }
    return p;
}

/* ---- where to start ---- */

/* Sets nearest[i] = min(nearest[i], |omega - centre|^2); returns the point with the largest w * nearest, ties
 * to the lower, and its value. */
static size_t farthest(const sl_directions *d, sl_vec3d centre, double *restrict nearest, double *value) {
    double best[LANES], where[LANES]; /* each lane's own largest, and its block: an exact whole number */
    for (int l = 0; l < LANES; l++) {
        best[l] = -1.0;
        where[l] = 0.0;
    }
    for (size_t first = 0; first < d->count; first += LANES) {
        points p = load(d, first);
        double chord[LANES], near[LANES];
        size_t end = d->count - first < LANES ? d->count - first : LANES;
        for (size_t l = 0; l < LANES; l++) near[l] = l < end ? nearest[first + l] : 0.0;
        const double block = (double)first;
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            double x = p.x[l] - centre.x, y = p.y[l] - centre.y, z = p.z[l] - centre.z,
                   square = x * x + y * y + z * z;
            chord[l] = square < near[l] ? square : near[l];
            double v = p.weight[l] * chord[l];
            where[l] = v > best[l] ? block : where[l];
            best[l] = v > best[l] ? v : best[l];
        }
        for (size_t l = 0; l < end; l++) nearest[first + l] = chord[l];
    }
    int lane = 0;
    for (int l = 1; l < LANES; l++) {
        if (best[l] > best[lane] || (best[l] == best[lane] && where[l] + l < where[lane] + lane)) lane = l;
    }
    *value = best[lane];
    return (size_t)where[lane] + (size_t)lane;
}

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
static void start(const sl_directions *d, int wanted, double *nearest, sl_clusters *clusters) {
    *clusters = (sl_clusters){0};
    if (d->count == 0 || wanted < 1) return;
    if (wanted > SL_VOXEL_LIGHTS_MAX) wanted = SL_VOXEL_LIGHTS_MAX;
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
        chosen = farthest(d, direction_of(d, chosen), nearest, &value);
        if (!(nearest[chosen] > SAME)) value = 0.0;
    }
}

/* ---- one iteration ---- */

static inline double join(const double v[LANES]) {
    return ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7]));
}

/* The clusters of up to eight points; returns how many are other than before. */
static inline size_t put_clusters(const double nearest[LANES], uint8_t *of, size_t count) {
    uint8_t now[LANES];
    size_t changed = 0;
#pragma omp simd
    for (int l = 0; l < LANES; l++) now[l] = (uint8_t)(int)nearest[l];
    if (count > LANES) count = LANES;
    if (count == LANES && memcmp(now, of, LANES) == 0) return 0;
    for (size_t l = 0; l < count; l++) {
        changed += now[l] != of[l];
        of[l] = now[l];
    }
    return changed;
}

/* Of each cluster's members: sum w omega and sum w. */
typedef struct cluster_sums {
    double x[SL_VOXEL_LIGHTS_MAX], y[SL_VOXEL_LIGHTS_MAX], z[SL_VOXEL_LIGHTS_MAX],
        weight[SL_VOXEL_LIGHTS_MAX];
} cluster_sums;

/* The number of clusters is a constant wherever this is inlined, so that their sums stay in registers. */
static inline size_t assign(const sl_directions *d, const int clusters, const sl_vec3d *centre,
                            uint8_t *restrict of, cluster_sums *restrict sums) {
    double sx[SL_VOXEL_LIGHTS_MAX][LANES] = {{0}}, sy[SL_VOXEL_LIGHTS_MAX][LANES] = {{0}},
           sz[SL_VOXEL_LIGHTS_MAX][LANES] = {{0}}, sw[SL_VOXEL_LIGHTS_MAX][LANES] = {{0}};
    size_t changed = 0;
    for (size_t first = 0; first < d->count; first += LANES) {
        points p = load(d, first);
        double best[LANES], nearest[LANES];
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            best[l] = p.x[l] * centre[0].x + p.y[l] * centre[0].y + p.z[l] * centre[0].z;
            nearest[l] = 0.0;
        }
        for (int c = 1; c < clusters; c++) {
#pragma omp simd
            for (int l = 0; l < LANES; l++) {
                double dot = p.x[l] * centre[c].x + p.y[l] * centre[c].y + p.z[l] * centre[c].z;
                nearest[l] = dot > best[l] ? (double)c : nearest[l];
                best[l] = dot > best[l] ? dot : best[l];
            }
        }
        for (int c = 0; c < clusters; c++) {
#pragma omp simd
            for (int l = 0; l < LANES; l++) {
                double w = nearest[l] == (double)c ? p.weight[l] : 0.0;
                sx[c][l] += w * p.x[l];
                sy[c][l] += w * p.y[l];
                sz[c][l] += w * p.z[l];
                sw[c][l] += w;
            }
        }
        changed += put_clusters(nearest, of + first, d->count - first);
    }
    for (int c = 0; c < clusters; c++) {
        sums->x[c] = join(sx[c]);
        sums->y[c] = join(sy[c]);
        sums->z[c] = join(sz[c]);
        sums->weight[c] = join(sw[c]);
    }
    return changed;
}

/* Puts every point into the cluster with the largest omega . d, ties to the lower one, and sums up; returns
 * how many changed. */
static size_t assign_all(const sl_directions *d, int clusters, const sl_vec3d *centre, uint8_t *of,
                         cluster_sums *sums) {
    memset(sums, 0, sizeof *sums);
    switch (clusters) {
    case 1: return assign(d, 1, centre, of, sums);
    case 2: return assign(d, 2, centre, of, sums);
    case 3: return assign(d, 3, centre, of, sums);
    case 4: return assign(d, 4, centre, of, sums);
    case 5: return assign(d, 5, centre, of, sums);
    case 6: return assign(d, 6, centre, of, sums);
    case 7: return assign(d, 7, centre, of, sums);
    default: return assign(d, SL_VOXEL_LIGHTS_MAX, centre, of, sums);
    }
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

/* A cluster without members keeps its centre. */
static void place_centres(const sl_directions *d, const uint8_t *of, const cluster_sums *sums,
                          sl_clusters *clusters) {
    double cost = 0.0;
    for (int c = 0; c < clusters->count; c++) {
        sl_vec3d sum = sl_v3d(sums->x[c], sums->y[c], sums->z[c]);
        double length = sl_lengthd(sum);
        if (!(sums->weight[c] > 0.0)) continue;
        bool vanishes = !(length > 1e-6 * sums->weight[c]);
        clusters->centre[c] = vanishes ? heaviest(d, of, c) : sl_scaled(sum, 1.0 / length);
        cost += 2.0 * (sums->weight[c] - sl_dotd(sum, clusters->centre[c]));
    }
    clusters->cost = cost > 0.0 ? cost : 0.0;
}

/* ---- the whole ---- */

void SL_KERNEL(sl_cluster)(const sl_directions *d, int wanted, int iterations, uint8_t *of, double *scratch,
                           sl_clusters *clusters) {
    cluster_sums sums;
    size_t changed = d->count;
    start(d, wanted, scratch, clusters);
    memset(of, clusters->count > 0 ? 0xff : 0, d->count);
    while (clusters->count > 0 && clusters->iterations < iterations && changed > 0) {
        changed = assign_all(d, clusters->count, clusters->centre, of, &sums);
        place_centres(d, of, &sums, clusters);
        clusters->iterations++;
    }
}
