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
SL_KERNEL_VARIANTS(sl_compose_kernel, sl_compose_row);

static inline sl_compose_kernel *sl_compose_kernel_for(sl_isa isa) { return SL_KERNEL_OF(isa, sl_compose_row); }

#endif
