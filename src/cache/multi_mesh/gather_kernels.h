/* The loop over a gather's pixels, for every instruction set: from triangle ids to what bounces off the
 * coarse mesh there, and that times weights. */
#ifndef SL_MULTI_MESH_GATHER_KERNELS_H
#define SL_MULTI_MESH_GATHER_KERNELS_H

#include "base/isa.h"
#include "cache/multi_mesh/gather.h"

/* of a triangle: its corner 0, edges from there to corners 1 and 2; three to spare */
enum { SL_MESH_GATHER_FLOATS = 12 };

/* A picture: pixel (i, j) looks along x[i] frame.x + y[j] frame.y + frame.z. */
typedef struct sl_mesh_gather_pixels {
    int width, height;             /* width is a multiple of four */
    const uint32_t *id;            /* SL_NO_INDEX: background */
    const float *x, *y;
    sl_frame frame;
    sl_vec3 eye;
    sl_vec3 horizon;               /* geometric normal: what lies below its plane is black */
    /* by scene triangle, SL_MESH_GATHER_FLOATS each; then one more, all 0, for the background */
    const float *triangle;
    uint32_t triangle_count;
    const sl_coarse_face *face;    /* by face; then two of the background */
    const float *colour;           /* of the coarse mesh */
    const float *weight;
    float *radiance[3];            /* planes: the picture */
    float *weighted[3];            /* ... times weights */
} sl_mesh_gather_pixels;

typedef void sl_mesh_gather_kernel(const sl_mesh_gather_pixels *pixels);
SL_KERNEL_VARIANTS(sl_mesh_gather_kernel, sl_mesh_gather_shade);

static inline sl_mesh_gather_kernel *sl_mesh_gather_kernel_for(sl_isa isa) {
    return SL_KERNEL_OF(isa, sl_mesh_gather_shade);
}

#endif
