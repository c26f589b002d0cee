/* Pass 8's loop over a row of pixels, compiled for every instruction set. */
#ifndef SL_CACHE_DIRECT_RADIANCE_COMPOSE_KERNELS_H
#define SL_CACHE_DIRECT_RADIANCE_COMPOSE_KERNELS_H

#include <stddef.h>

#include "base/isa.h"

/* A row of one channel. */
typedef struct sl_compose_row {
    size_t width;
    const float *throughput;                   /* of planar mirrors; NULL: 1 */
    const float *emission, *direct, *indirect;
    float *out[4];                             /* the picture; emission, direct and indirect light with the throughput, or NULL */
} sl_compose_row;

typedef void sl_compose_kernel(const sl_compose_row *row);
sl_compose_kernel sl_compose_row_baseline, sl_compose_row_avx2, sl_compose_row_avx512;

static inline sl_compose_kernel *sl_compose_kernel_for(sl_isa isa) {
#ifndef SL_BASELINE_ONLY
    if (isa == SL_ISA_AVX512) return sl_compose_row_avx512;
    if (isa == SL_ISA_AVX2) return sl_compose_row_avx2;
#endif
    (void)isa;
    return sl_compose_row_baseline;
}

#endif
