#include "cache/splatting/record.h"

SL_KERNEL_VARIANTS(const sl_splat_kernels, sl_splat_kernel_table);

const sl_splat_kernels *sl_splat_kernels_for(sl_isa isa) {
    return SL_KERNEL_CHOICE(isa, sl_splat_kernel_table);
}
