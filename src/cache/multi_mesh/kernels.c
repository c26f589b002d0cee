/* The variant of each loop that the CPU can run. */
#include "cache/multi_mesh/path_kernels.h"

void sl_paths_baseline(size_t count, const float *w1, const float *w2, uint32_t *path);
#ifndef SL_BASELINE_ONLY
void sl_paths_avx2(size_t count, const float *w1, const float *w2, uint32_t *path);
void sl_paths_avx512(size_t count, const float *w1, const float *w2, uint32_t *path);
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
