#include "cache/splatting/record.h"

extern const sl_splat_kernels sl_splat_kernel_table_baseline, sl_splat_kernel_table_avx2, sl_splat_kernel_table_avx512;

const sl_splat_kernels *sl_splat_kernels_for(sl_isa isa) {
#ifndef SL_BASELINE_ONLY
    if (isa == SL_ISA_AVX512) return &sl_splat_kernel_table_avx512;
    if (isa == SL_ISA_AVX2) return &sl_splat_kernel_table_avx2;
#endif
    (void)isa;
    return &sl_splat_kernel_table_baseline;
}
