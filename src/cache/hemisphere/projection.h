/* From the picture of a gather to coefficients of incoming radiance over the hemispherical harmonics, with
 * translational gradients (Krivanek et al. 2005, but with gradients by walls instead of by derivatives of H
 * and of solid angles):
 *
 *   lambda_i      = sum over cells of L times the integral of H_i over the cell (and its extension to the
 *                   horizon)
 *   grad lambda_i = sum over walls between cells of (L_b - L_a) / (the nearer one's distance) times the
 *                   integral of H_i along the wall, as it moves with the receiver (gather_kernels.c: the
 *                   principle of walls)
 *
 * On the plane with its radial extension, walls between border cells go on down to the horizon.
 *
 * Two matrix products: n^2 coefficients by cells by 3 channels, and by walls by 6. Mirror images make them
 * four times as small. The instruments are symmetric about the axes x and y, and so is every H, but for its
 * sign: it changes by cos(m phi), m even: never;  m odd: with x;      by sin(m phi), m odd: with y;  m even:
 * with x and with y. So the four mirror images of a cell (or of a wall) are first summed with the signs of
 * each of these four classes, and the products run over one quadrant. In the tables the functions stand class
 * after class, in groups of sixteen columns.
 *
 * projection.c makes the tables, projection_kernels.c the products. */
#pragma once

#include "base/isa.h"
#include "cache/hemisphere/gather_tables.h"
#include "cache/hemisphere/harmonics.h"

enum {
    SL_PROJECTION_BLOCK = 64,  /* cells or walls: summed in float, then added in double */
    SL_PROJECTION_GROUP = 16,  /* columns */
    SL_PROJECTION_GROUPS_MAX = 12,
    SL_PROJECTION_CLASSES = 4, /* bit 0: changes sign with x; bit 1: with y */
    SL_PROJECTION_VECTORS = 9  /* lambda, d lambda / dx, d lambda / dy; R, G, B each */
};

/* Blocks of cells or walls of the quadrant; what the last block lacks is 0. */
typedef struct sl_projection_list {
    size_t count, blocks;
    /* of mirror image 0 .. 3 (bit 0: x, bit 1: y). Cells: [0]; walls: taken from [0], given to [1] */
    uint32_t *cell[2][4];
    float *x, *y;         /* walls: how they move */
    float *table;         /* [block][group][SL_PROJECTION_BLOCK][SL_PROJECTION_GROUP] */
} sl_projection_list;

typedef struct sl_projection {
    int order, groups;
    int class_of[SL_PROJECTION_GROUPS_MAX];
    /* Of a column in harmonics.h's order; SL_NO_INDEX: padding. */
    uint32_t place[SL_PROJECTION_GROUPS_MAX * SL_PROJECTION_GROUP];
    sl_projection_list cells, walls;
} sl_projection;

/* [group][vector][column] */
typedef struct sl_projection_sums {
    double sum[SL_PROJECTION_GROUPS_MAX][SL_PROJECTION_VECTORS][SL_PROJECTION_GROUP];
} sl_projection_sums;

/* order: 1 to SL_HSH_ORDER_MAX. */
sl_status sl_projection_create(const sl_gather_tables *tables, int order, unsigned threads,
                               sl_projection **projection, sl_error *error);
void sl_projection_destroy(sl_projection *projection);
size_t sl_projection_bytes(const sl_projection *projection);

/* picture: radiance R, G, B and nearness, by cell. coefficients: SL_PROJECTION_VECTORS times
 * sl_hsh_stride(order) floats. */
void sl_project(const sl_projection *projection, sl_isa isa, const float *const picture[4],
                float *coefficients);

/* ---- the kernels (projection_kernels.c) ---- */

SL_KERNELS(void, sl_projection_sums,
           (const sl_projection *projection, const float *const picture[4], sl_projection_sums *sums));
