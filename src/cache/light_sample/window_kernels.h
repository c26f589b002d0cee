/* The loops over the pixels of a light's picture, compiled for every instruction set. */
#ifndef SL_CACHE_LIGHT_SAMPLE_KERNELS_H
#define SL_CACHE_LIGHT_SAMPLE_KERNELS_H

#include "base/isa.h"
#include "base/vec.h"

#include <stdint.h>

/* A picture in tangents at distance 1 along the view's axis: the pixel in column i, row j looks along (x, y, 1), x = column_x[i] + row_x[j] and
 * y = column_y[i] + row_y[j]; in a picture square to its frame y is row_y[j] alone, and x is column_x[i]. */
typedef struct sl_light_pixels {
    int size;
    const float *column_x, *column_y, *row_x, *row_y;
    float step_x, step_y;        /* between neighbours, of pictures square to their frame */
    sl_vec3 normal, geometric;   /* of the receiver, in the view's frame */
    float scale;                 /* weights are multiplied by this (of a window: a pixel's area, too) */
    float *seen, *all;           /* size x size each */
} sl_light_pixels;

/* The light is a window: pixels whose bit of `inside` is set; seen where id is SL_NO_INDEX. */
typedef void sl_window_weigh(const sl_light_pixels *pixels, const uint32_t *inside, const uint32_t *id);
/* The light is what its own picture shows (light_id: a triangle with facing != 0); seen where the scene is no nearer, depths being 1/w. */
typedef void sl_look_at_weigh(const sl_light_pixels *pixels, const uint32_t *light_id, const uint8_t *facing, const float *light_depth,
                              const float *depth);

typedef struct sl_light_pixel_kernels {
    sl_window_weigh *window;
    sl_look_at_weigh *look_at;
} sl_light_pixel_kernels;

#define SL_DECLARE_LIGHT_PIXEL_KERNELS(isa)  \
    sl_window_weigh sl_window_weigh_##isa;   \
    sl_look_at_weigh sl_look_at_weigh_##isa

SL_DECLARE_LIGHT_PIXEL_KERNELS(baseline);
SL_DECLARE_LIGHT_PIXEL_KERNELS(avx2);
SL_DECLARE_LIGHT_PIXEL_KERNELS(avx512);

static inline sl_light_pixel_kernels sl_light_pixel_kernels_for(sl_isa isa) {
#ifndef SL_BASELINE_ONLY
    if (isa == SL_ISA_AVX512) return (sl_light_pixel_kernels){sl_window_weigh_avx512, sl_look_at_weigh_avx512};
    if (isa == SL_ISA_AVX2) return (sl_light_pixel_kernels){sl_window_weigh_avx2, sl_look_at_weigh_avx2};
#endif
    (void)isa;
    return (sl_light_pixel_kernels){sl_window_weigh_baseline, sl_look_at_weigh_baseline};
}

#endif
