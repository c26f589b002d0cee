/* Chooses the kernels' instruction set, once for each sl_raster. */
#include "raster/internal.h"

extern const sl_raster_kernels sl_raster_kernels_baseline;
#ifndef SL_BASELINE_ONLY
extern const sl_raster_kernels sl_raster_kernels_avx2, sl_raster_kernels_avx512;
#endif

const sl_raster_kernels *sl_raster_kernels_best(void) {
#ifndef SL_BASELINE_ONLY
    switch (sl_isa_best()) {
    case SL_ISA_AVX512: return &sl_raster_kernels_avx512;
    case SL_ISA_AVX2: return &sl_raster_kernels_avx2;
    default: break;
    }
#endif
    return &sl_raster_kernels_baseline;
}
