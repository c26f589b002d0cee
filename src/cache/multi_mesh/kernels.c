/* The variant of each loop that the CPU can run. */
#include "cache/multi_mesh/draw_kernels.h"
#include "cache/multi_mesh/path_kernels.h"

sl_path_kernel sl_paths_baseline;
sl_draw_kernel sl_draw_simple_baseline;
sl_draw_full_kernel sl_draw_full_baseline;
#ifndef SL_BASELINE_ONLY
sl_path_kernel sl_paths_avx2, sl_paths_avx512;
sl_draw_kernel sl_draw_simple_avx2, sl_draw_simple_avx512;
sl_draw_full_kernel sl_draw_full_avx2, sl_draw_full_avx512;
#endif

sl_path_kernel *sl_path_kernel_for(sl_isa isa) {
#ifndef SL_BASELINE_ONLY
    if (isa == SL_ISA_AVX512) return sl_paths_avx512;
    if (isa == SL_ISA_AVX2) return sl_paths_avx2;
#else
    (void)isa;
#endif
    return sl_paths_baseline;
}

sl_draw_kernels sl_draw_kernels_for(sl_isa isa) {
#ifndef SL_BASELINE_ONLY
    if (isa == SL_ISA_AVX512) return (sl_draw_kernels){sl_draw_simple_avx512, sl_draw_full_avx512};
    if (isa == SL_ISA_AVX2) return (sl_draw_kernels){sl_draw_simple_avx2, sl_draw_full_avx2};
#else
    (void)isa;
#endif
    return (sl_draw_kernels){sl_draw_simple_baseline, sl_draw_full_baseline};
}
