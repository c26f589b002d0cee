/* The loops over a leaf's pixels that are compiled for every instruction set. */
#ifndef SL_MULTI_MESH_DRAW_KERNELS_H
#define SL_MULTI_MESH_DRAW_KERNELS_H

#include <stddef.h>
#include <stdint.h>

#include "base/isa.h"

/* The face's weights 1 and 2 at a leaf's corner 0, and what the leaf's own weights 1 and 2 gain by the face's
 * from there. */
typedef struct sl_leaf_weights {
    float p, q, b_of_p, b_of_q, c_of_p, c_of_q;
} sl_leaf_weights;

static inline float sl_clamp01(float x) {
    float above = x > 0.0f ? x : 0.0f;
    return above < 1.0f ? above : 1.0f;
}

/* The leaf's three weights where the face's are w1, w2. */
typedef struct sl_fan_weights {
    float a, b, c;
} sl_fan_weights;
static inline sl_fan_weights sl_fan_weights_at(const sl_leaf_weights *of, float w1, float w2) {
    float p = w1 - of->p, q = w2 - of->q;
    float b = sl_clamp01(p * of->b_of_p + q * of->b_of_q), c = sl_clamp01(p * of->c_of_p + q * of->c_of_q);
    return (sl_fan_weights){sl_clamp01(1.0f - b - c), b, c};
}

/* A leaf whose edges have one vertex between their ends, or none: six triangles around its centre. By corner
 * or edge, by channel. */
typedef struct sl_simple_fan {
    sl_leaf_weights weights;
    float corner[3][3], centre[3];
    float middle[3][3];    /* of edges; the mean of the ends where nothing is known */
} sl_simple_fan;

/* Any leaf: values along its edges at equal steps, by channel. */
enum { SL_FULL_FAN_STEPS = 64 };
typedef struct sl_full_fan {
    sl_leaf_weights weights;
    float centre[3];
    /* by channel: edge e from its first end at e * (SL_FULL_FAN_STEPS + 1) */
    float edge[3][3 * (SL_FULL_FAN_STEPS + 1)];
} sl_full_fan;

/* Pixel i, where the face's weights are w1[i], w2[i], into three planes. */
typedef void sl_draw_kernel(const sl_simple_fan *fan, size_t count, const uint32_t *pixel, const float *w1,
                            const float *w2, float *const planes[3]);
typedef void sl_draw_full_kernel(const sl_full_fan *fan, size_t count, const uint32_t *pixel, const float *w1,
                                 const float *w2, float *const planes[3]);

typedef struct sl_draw_kernels {
    sl_draw_kernel *simple;
    sl_draw_full_kernel *full;
} sl_draw_kernels;
sl_draw_kernels sl_draw_kernels_for(sl_isa isa);

#endif
