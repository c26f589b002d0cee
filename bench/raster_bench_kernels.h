/* The roofline's loops, compiled once for each instruction set like the library's (base/isa.h). */
#ifndef SL_BENCH_RASTER_KERNELS_H
#define SL_BENCH_RASTER_KERNELS_H

#include <stddef.h>
#include <stdint.h>

#include "base/isa.h"

typedef struct bench_kernels {
    /* out = a + s b */
    void (*triad)(float *out, const float *a, const float *b, float s, size_t count);
    /* Vertices to window coordinates and 1/w: 4x4 matrix, division, viewport. out: x, y, 1/w one after
     * another. */
    void (*transform)(const float *x, const float *y, const float *z, const float matrix[4][4], float *out,
                      size_t count);
} bench_kernels;

const bench_kernels *bench_kernels_best(void);

#endif
