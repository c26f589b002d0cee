/* The products of projection.h. A coefficient is a lane: it adds cells, or walls, one after the other, in
 * float within a block and in double from block to block. So the width of the registers changes nothing. */
#include "cache/hemisphere/projection.h"

#include <string.h>

#include "base/lanes.h"

enum { BLOCK = SL_PROJECTION_BLOCK, GROUP = SL_PROJECTION_GROUP, CLASSES = SL_PROJECTION_CLASSES };

enum { PIECES = SL_WIDTH < 16 ? 2 : 1 }; /* of a group that are summed at a time */

/* ---- mirror images --------------------------------------------------------------------------- */

/* Sums over four images with the signs of each class, in place. */
static inline void fold(float image[CLASSES][BLOCK]) {
    float *restrict a = image[0], *restrict b = image[1], *restrict c = image[2], *restrict d = image[3];
#pragma omp simd
    for (int k = 0; k < BLOCK; k++) {
        float sum_0 = a[k] + b[k], sum_1 = c[k] + d[k], difference_0 = a[k] - b[k],
              difference_1 = c[k] - d[k];
        a[k] = sum_0 + sum_1;
        b[k] = difference_0 + difference_1;
        c[k] = sum_0 - sum_1;
        d[k] = difference_0 - difference_1;
    }
}

static inline void fold_cells(const sl_projection_list *list, size_t first, const float *restrict radiance,
                              float folded[CLASSES][BLOCK]) {
    for (int image = 0; image < 4; image++) {
        const uint32_t *restrict cell = list->cell[0][image] + first;
        float *restrict to = folded[image];
        for (int k = 0; k < BLOCK; k++) to[k] = radiance[cell[k]];
    }
    fold(folded);
}

/* (L_b - L_a) / distance of the nearer: the boundary moves with the nearer surface. */
static inline void fold_walls(const sl_projection_list *list, size_t first, const float *restrict radiance,
                              float near[4][BLOCK], float folded[CLASSES][BLOCK]) {
    for (int image = 0; image < 4; image++) {
        const uint32_t *restrict from = list->cell[0][image] + first, *restrict to =
                                                                          list->cell[1][image] + first;
        float *restrict out = folded[image];
        const float *restrict nearer = near[image];
        for (int k = 0; k < BLOCK; k++) out[k] = (radiance[to[k]] - radiance[from[k]]) * nearer[k];
    }
    fold(folded);
}

static inline void nearer_surfaces(const sl_projection_list *list, size_t first,
                                   const float *restrict nearness, float near[4][BLOCK]) {
    for (int image = 0; image < 4; image++) {
        const uint32_t *restrict from = list->cell[0][image] + first, *restrict to =
                                                                          list->cell[1][image] + first;
        float *restrict out = near[image];
        for (int k = 0; k < BLOCK; k++) {
            float a = nearness[from[k]], b = nearness[to[k]];
            out[k] = a > b ? a : b;
        }
    }
}

/* ---- products -------------------------------------------------------------------------------- */

static inline void add_lanes(double *restrict sum, const sl_lanes_floats *restrict part) {
    for (int i = 0; i < SL_WIDTH; i++) sum[i] += (double)(*part)[i];
}

/* Some vectors of one group over one block; a constant number, so that loops over them are unrolled. */
static inline __attribute__((always_inline)) void multiply(const float *restrict table, int vectors,
                                                           float (*restrict factor)[BLOCK],
                                                           double (*restrict sum)[GROUP]) {
    for (int first = 0; first < GROUP; first += PIECES * SL_WIDTH) {
        sl_lanes_floats part[6][PIECES];
        memset(part, 0, sizeof part);
        for (int k = 0; k < BLOCK; k++) {
            for (int i = 0; i < PIECES; i++) {
                const sl_lanes_floats h = sl_lanes_load_floats(table + k * GROUP + first + i * SL_WIDTH);
                for (int v = 0; v < vectors; v++) part[v][i] += h * factor[v][k];
            }
        }
        for (int v = 0; v < vectors; v++)
            for (int i = 0; i < PIECES; i++) add_lanes(&sum[v][first + i * SL_WIDTH], &part[v][i]);
    }
}

/* ---- blocks ---------------------------------------------------------------------------------- */

static void add_cells(const sl_projection *p, size_t block, const float *const picture[4],
                      sl_projection_sums *sums) {
    float folded[3][CLASSES][BLOCK], factor[3][BLOCK];
    for (int c = 0; c < 3; c++) fold_cells(&p->cells, block * BLOCK, picture[c], folded[c]);
    for (int g = 0; g < p->groups; g++) {
        for (int c = 0; c < 3; c++) memcpy(factor[c], folded[c][p->class_of[g]], sizeof factor[c]);
        multiply(p->cells.table + (block * (size_t)p->groups + (size_t)g) * BLOCK * GROUP, 3, factor,
                 sums->sum[g]);
    }
}

/* A wall's mirror image in x moves by (-x, y): for d / dx the classes exchange their signs with x, for d / dy
 * those with y. */
static void add_walls(const sl_projection *p, size_t block, const float *const picture[4],
                      sl_projection_sums *sums) {
    float near[4][BLOCK], folded[3][CLASSES][BLOCK], moved[6][BLOCK];
    const float *wall_x = p->walls.x + block * BLOCK, *wall_y = p->walls.y + block * BLOCK;
    nearer_surfaces(&p->walls, block * BLOCK, picture[3], near);
    for (int c = 0; c < 3; c++) fold_walls(&p->walls, block * BLOCK, picture[c], near, folded[c]);
    for (int g = 0; g < p->groups; g++) {
        const float *table = p->walls.table + (block * (size_t)p->groups + (size_t)g) * BLOCK * GROUP;
        for (int c = 0; c < 3; c++) {
            float *restrict x = moved[c], *restrict y = moved[3 + c];
            const float *folded_x = folded[c][p->class_of[g] ^ 1], *folded_y = folded[c][p->class_of[g] ^ 2];
#pragma omp simd
            for (int k = 0; k < BLOCK; k++) {
                x[k] = folded_x[k] * wall_x[k];
                y[k] = folded_y[k] * wall_y[k];
            }
        }
        multiply(table, 6, moved, &sums->sum[g][3]);
    }
}

void SL_KERNEL(sl_projection_sums)(const sl_projection *p, const float *const picture[4],
                                   sl_projection_sums *sums) {
    memset(sums, 0, sizeof *sums);
    for (size_t block = 0; block < p->cells.blocks; block++) add_cells(p, block, picture, sums);
    for (size_t block = 0; block < p->walls.blocks; block++) add_walls(p, block, picture, sums);
}
