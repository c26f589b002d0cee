/* The loop over points that share their eight voxels, compiled for every instruction set. */
#ifndef SL_CACHE_LIGHT_OCTREE_SHADE_KERNELS_H
#define SL_CACHE_LIGHT_OCTREE_SHADE_KERNELS_H

#include "base/isa.h"
#include "cache/light_octree/voxel_texture.h"

enum { SL_SHADE_BLOCK = 64, SL_SHADE_LANES = 16 };

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

#endif
