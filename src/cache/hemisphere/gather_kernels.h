/* The loops over a gather's cells that are compiled for every instruction set. */
#pragma once

#include "base/isa.h"
#include "cache/hemisphere/gather_tables.h"

/* By cell. `width` + 1 zeros lie before the first cell, so that its walls to cells outside the picture can be
 * read. */
typedef struct sl_gather_planes {
    /* radiance; 1 / depth of the nearest thing seen, with which the cell's walls move (0: nothing) */
    float *r, *g, *b, *nearness;
    float *first, *distance;     /* 1 / depth and distance of what the first ray saw */
    float *mean;                            /* of r, g, b */
} sl_gather_planes;

typedef struct sl_gather_sums {
    double irradiance[3];
    double rotational[3][2];    /* local x, y */
    double translational[3][2];
    double inverse_distance;    /* sum of W / r */
    sl_curvature curvature;     /* of the channels' mean */
} sl_gather_sums;

typedef struct sl_ray_cells {
    size_t count;
    const float *slot_a, *slot_b;
    float cell;       /* side of a cell in [-1,1]^2 */
    bool jitter;
    uint64_t key;
    const uint32_t *bits; /* two jitters of 16 bits each, or NULL: drawn by the key */
    sl_frame frame;
    float *x, *y, *z; /* unit directions in the world */
} sl_ray_cells;

/* Things seen in the cells, by slot: slot k is cell order[k], those beyond are further rays of some cells
 * (more_rays.c). */
typedef struct sl_gather_hits {
    uint32_t *triangle;                             /* SL_NO_INDEX: nothing */
    float *depth, *w1, *w2;                         /* position = eye + depth * direction */
    float *direction_x, *direction_y, *direction_z; /* world, in units of depth */
    float *position_x, *position_y, *position_z;
    float *normal_x, *normal_y, *normal_z;          /* shading, towards the gather */
    float *geometric_x, *geometric_y, *geometric_z; /* towards the gather */
    /* of the geometric normal with the way back, times the direction's length */
    float *cosine;
    float *diffuse_r, *diffuse_g, *diffuse_b;
    float *irradiance_r, *irradiance_g, *irradiance_b;
    float *glossy_r, *glossy_g, *glossy_b; /* radiance by way of glossy lobes */
    float *back;                                    /* 1: seen from the clockwise side */
} sl_gather_hits;

SL_KERNELS(void, sl_gather_directions, (const sl_ray_cells *cells));
/* The standard deviation of a cell's eight neighbours (mirrored at the picture's edges), without the cell
 * itself. At least 2 x 2 cells. */
SL_KERNELS(void, sl_gather_spread, (int width, int height, const float *value, float *spread));
/* Makes positions of slots first to first + count, their normals (interpolated, and by winding) unit and on
 * the gather's side, cosine and back. */
SL_KERNELS(void, sl_gather_surfaces, (const sl_gather_hits *hits, size_t first, size_t count, sl_vec3 eye));
/* Writes the planes' mean, too. */
SL_KERNELS(void, sl_gather_sums,
           (const sl_gather_tables *tables, const sl_gather_planes *planes, sl_gather_sums *sums));
