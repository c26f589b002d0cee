/* Eight points at a time: sums are kept in eight lanes, point i in lane i mod 8, and joined in a fixed order
 * at the end, so that every instruction set gives the same bits. */
#include "cache/light_octree/lights.h"

#include "base/math.h"

#include <string.h>

enum { LANES = 8 };

/* Eight points in double; beyond the end of the list weight and one are 0. */
typedef struct points {
    double x[LANES], y[LANES], z[LANES], weight[LANES], one[LANES];
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
            p.one[l] = 1.0;
        }
        return p;
    }
    for (size_t l = 0; l < LANES; l++) {
        size_t i = first + l < d->count ? first + l : d->count - 1;
        p.x[l] = (double)d->x[i];
        p.y[l] = (double)d->y[i];
        p.z[l] = (double)d->z[i];
        p.weight[l] = first + l < d->count ? d->weight[i] : 0.0;
        p.one[l] = first + l < d->count ? 1.0 : 0.0;
    }
    return p;
}

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

/* The number of clusters is a constant wherever this is inlined, so that their sums stay in registers. */
static inline size_t assign(const sl_directions *d, const int clusters, const sl_vec3d *centre,
                            uint8_t *restrict of, sl_cluster_sums *restrict sums) {
    double sx[SL_VOXEL_LIGHTS_MAX][LANES] = {{0}}, sy[SL_VOXEL_LIGHTS_MAX][LANES] = {{0}},
           sz[SL_VOXEL_LIGHTS_MAX][LANES] = {{0}}, sw[SL_VOXEL_LIGHTS_MAX][LANES] = {{0}},
           members[SL_VOXEL_LIGHTS_MAX][LANES] = {{0}};
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
                members[c][l] += nearest[l] == (double)c ? p.one[l] : 0.0;
            }
        }
        changed += put_clusters(nearest, of + first, d->count - first);
    }
    for (int c = 0; c < clusters; c++) {
        sums->x[c] = join(sx[c]);
        sums->y[c] = join(sy[c]);
        sums->z[c] = join(sz[c]);
        sums->weight[c] = join(sw[c]);
        sums->members[c] = (size_t)join(members[c]);
    }
    return changed;
}

size_t SL_KERNEL(sl_cluster_assign)(const sl_directions *d, int clusters, const sl_vec3d *centre, uint8_t *of,
                                    sl_cluster_sums *sums) {
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

size_t SL_KERNEL(sl_cluster_farthest)(const sl_directions *d, sl_vec3d centre, double *restrict nearest,
                                      double *value) {
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
