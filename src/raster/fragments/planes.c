/* Chooses the planes' kernels. */
#include "raster/fragments/planes.h"

#include "base/isa.h"

extern const sl_plane_kernels sl_plane_kernel_table_baseline;
#ifndef SL_BASELINE_ONLY
extern const sl_plane_kernels sl_plane_kernel_table_avx2, sl_plane_kernel_table_avx512;
#endif

const sl_plane_kernels *sl_plane_kernels_best(void) {
#ifndef SL_BASELINE_ONLY
    switch (sl_isa_best()) {
    case SL_ISA_AVX512: return &sl_plane_kernel_table_avx512;
    case SL_ISA_AVX2: return &sl_plane_kernel_table_avx2;
    default: break;
    }
#endif
    return &sl_plane_kernel_table_baseline;
}
