/* The loop over receivers that look a light up, compiled for every instruction set. */
#ifndef SL_CACHE_DIRECT_RADIANCE_SHADOW_CUBE_KERNELS_H
#define SL_CACHE_DIRECT_RADIANCE_SHADOW_CUBE_KERNELS_H

#include "base/isa.h"
#include "cache/direct_radiance/light_sides.h"

enum { SL_SHADOW_BLOCK = 128 };

/* The depth pictures around a light point. A cube's hold 1/z, z along the picture's own axis, and have a border of one texel beyond 90
 * degrees, so that a filter never leaves its picture; a directional light's one holds 1 - d, d in [0,1] linear in depth. So in both
 * larger is nearer, 0 is empty, and a plane is a linear function. A spot whose cone fits in the picture ahead has that one alone, no wider than
 * the cone. */
typedef struct sl_shadow_cube {
    float *depth;                    /* first a row of zeros, to which pictures without anything in them lead; then the pictures */
    int32_t start[SL_LIGHT_SIDES];   /* where in depth each side's picture begins; 0: it has none */
    int32_t mask[SL_LIGHT_SIDES];    /* all bits of a place in the picture, or none where there is no picture */
    int size;
    bool directional;
    float tangent;                   /* of a cube's pictures: half their width at distance 1, without the border: 1, or a spot's own */
    sl_vec3 eye;                     /* directional: the box's centre */
    sl_frame frame;                  /* of the light */
    float reach_x, reach_y, reach_z; /* directional: half extents */
    float rounding;                  /* by how much a receiver's position may be rounded */
} sl_shadow_cube;

/* Texels before the first picture. */
static inline size_t sl_shadow_zeros(int size) { return ((size_t)size + 2 + 15) / 16 * 16; }

/* Receivers, at most SL_SHADOW_BLOCK; normals unit, on the lit side; lit is multiplied. */
typedef void sl_shadow_cube_kernel(const sl_shadow_cube *cube, size_t count, const float *px, const float *py, const float *pz,
                                   const float *nx, const float *ny, const float *nz, float *lit);

SL_KERNEL_VARIANTS(sl_shadow_cube_kernel, sl_shadow_cube_lit);

static inline sl_shadow_cube_kernel *sl_shadow_cube_kernel_for(sl_isa isa) { return SL_KERNEL_OF(isa, sl_shadow_cube_lit); }

#endif
