/* The variant of each loop that the CPU can run. */
#include "cache/multi_mesh/draw_kernels.h"
#include "cache/multi_mesh/path_kernels.h"

SL_KERNEL_VARIANTS(sl_path_kernel, sl_paths);
SL_KERNEL_VARIANTS(sl_draw_kernel, sl_draw_simple);
SL_KERNEL_VARIANTS(sl_draw_full_kernel, sl_draw_full);

sl_path_kernel *sl_path_kernel_for(sl_isa isa) { return SL_KERNEL_OF(isa, sl_paths); }

sl_draw_kernels sl_draw_kernels_for(sl_isa isa) {
    return (sl_draw_kernels){SL_KERNEL_OF(isa, sl_draw_simple), SL_KERNEL_OF(isa, sl_draw_full)};
}
