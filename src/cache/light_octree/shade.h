/* The light that surface points send to the eye, from the octree and its lights: L_o = sum f_r c_j
 * (n . d_j)+ in each of the eight voxels around, then their trilinear mean. Points that share their eight
 * voxels are shaded together: the octree is descended once for all of them, and the loop over their lights is
 * arithmetic alone. */
#pragma once

#include "cache/light_octree/voxel_texture.h"

typedef struct sl_octree_shading {
    const sl_voxel_texture *texture;
    sl_voxel_filter filter;
    bool keep_void_dark;  /* empty voxels count as black: the paper's holes */
    bool facing;          /* voxels weigh by the cosine between their normal and the point's, against leaks */
} sl_octree_shading;

/* A surface point; normal unit, shading, turned to the viewer (not finite, or 0: such a point gets 0).
 * Diffuse pi: the irradiance comes out. Specular 0: the view is not looked at. */
typedef struct sl_octree_point {
    sl_vec3 position, normal;
    sl_vec3 view;                /* unit, towards the viewer */
    sl_rgb diffuse, specular;
    float exponent;              /* modified Phong */
} sl_octree_point;

/* Points by number, and where their light goes; both are called by any worker, `put` once for each point. */
typedef struct sl_octree_points {
    size_t count;
    bool (*find)(const void *context, size_t index, sl_octree_point *point); /* false: none is there */
    void (*put)(void *context, size_t index, const float rgb[3]);
    void *context;
} sl_octree_points;

enum { SL_OCTREE_BLOCK = 4096 }; /* points that are put in order of their voxels at a time */

/* Radiance (or irradiance) of points. Each point's is a function of that point alone. Fails for want of
 * memory alone. */
sl_status sl_octree_shade(const sl_octree_shading *shading, const sl_octree_points *points, unsigned threads,
                          sl_counters *counters, sl_error *error);

/* ---- the loop over points that share their eight voxels (shade_kernels.c) ---- */

enum { SL_SHADE_BLOCK = 64, SL_SHADE_LANES = 8 };

typedef struct sl_shade_corner {
    int sets;              /* 0: void */
    sl_shade_set set[SL_VOXEL_SETS_MAX];
} sl_shade_corner;

/* Eight voxels, x lowest; with the nearest filter the first alone. */
typedef struct sl_shade_cells {
    sl_shade_corner corner[8];
    int corners;           /* 8, or 1 */
    sl_voxel_lobes lobes;
    bool keep_void_dark, facing;
} sl_shade_cells;

/* Points as arrays, filled up to whole groups of SL_SHADE_LANES with anything finite. */
typedef struct sl_shade_block {
    _Alignas(64) float tx[SL_SHADE_BLOCK];
    /* place between the voxels' centres */
    float ty[SL_SHADE_BLOCK], tz[SL_SHADE_BLOCK];
    float nx[SL_SHADE_BLOCK], ny[SL_SHADE_BLOCK], nz[SL_SHADE_BLOCK];
    float mx[SL_SHADE_BLOCK], my[SL_SHADE_BLOCK], mz[SL_SHADE_BLOCK];     /* mirror direction of the view */
    float exponent[SL_SHADE_BLOCK];
    float irradiance[3][SL_SHADE_BLOCK];                                  /* out: sum c (n . d)+ */
    /* out: sum (e+2)/(2 pi) (m . d)+^e c (n . d)+ */
    float lobe[3][SL_SHADE_BLOCK];
} sl_shade_block;

SL_KERNELS(void, sl_shade_block,
           (const sl_shade_cells *cells, size_t count, bool glossy, sl_shade_block *block));

/* ---- one point as the shader has it, before the loop over lights: for those who tell what made it ---- */

typedef struct sl_octree_seen {
    sl_shade_block block;      /* the point, SL_SHADE_LANES times */
    sl_shade_cells cells;      /* its eight voxels, or the nearest alone */
    int32_t cell[3];           /* the first of them */
    bool glossy;
} sl_octree_seen;

/* False where the point gets no light. */
bool sl_octree_see(const sl_octree_shading *shading, const sl_octree_point *point, sl_octree_seen *seen);
