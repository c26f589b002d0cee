/* Hot loops live in files called *_kernels.c, which are compiled once for each instruction set, with the
 * suffix SL_ISA_SUFFIX on every symbol, and are chosen at run time. All variants give
 * the same bits: no contraction, element-wise loops, reductions in fixed lanes. The environment variable
 * SOFTLUX_ISA=baseline|avx2|avx512 lowers the choice (tests use it to compare); a build with SL_BASELINE_ONLY
 * has the baseline variant alone, as have processors other than x86-64. */
#pragma once

typedef enum sl_isa { SL_ISA_BASELINE, SL_ISA_AVX2, SL_ISA_AVX512, SL_ISAS } sl_isa;

/* The best that the CPU has, this build holds and SOFTLUX_ISA allows. */
sl_isa sl_isa_best(void);
const char *sl_isa_name(sl_isa isa);

/* SL_KERNEL(name) is name_baseline, name_avx2 or name_avx512, as SL_ISA_SUFFIX says (the Makefile sets it).
 */
#define SL_KERNEL_PASTE2(name, suffix) name##_##suffix
#define SL_KERNEL_PASTE(name, suffix) SL_KERNEL_PASTE2(name, suffix)
#define SL_KERNEL(name) SL_KERNEL_PASTE(name, SL_ISA_SUFFIX)

/* SL_KERNELS(result, name, (arguments)) declares the variants of a kernel; SL_KERNEL_OF(isa, name) is the one
 * of an instruction set, which a caller finds once (sl_isa_best()) and keeps. */
#ifdef SL_BASELINE_ONLY
#define SL_KERNELS(result, name, arguments) result name##_baseline arguments
#define SL_KERNEL_OF(isa, name) ((void)(isa), name##_baseline)
#else
#define SL_KERNELS(result, name, arguments) \
    result name##_baseline arguments, name##_avx2 arguments, name##_avx512 arguments
#define SL_KERNEL_OF(isa, name) \
    ((isa) == SL_ISA_AVX512 ? name##_avx512 : (isa) == SL_ISA_AVX2 ? name##_avx2 : name##_baseline)
#endif
