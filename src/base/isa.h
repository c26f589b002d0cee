/* Hot loops live in files called *_kernels.c, which are compiled once for each instruction set, with the
 * suffix SL_ISA_SUFFIX on every symbol, and are called through a table chosen at run time. All variants give
 * the same bits: no contraction, element-wise loops, reductions in fixed lanes. The environment variable
 * SOFTLUX_ISA=baseline|avx2|avx512 lowers the choice (tests use it to compare); a build with SL_BASELINE_ONLY
 * has the baseline variant alone. */
#ifndef SL_BASE_ISA_H
#define SL_BASE_ISA_H

typedef enum sl_isa { SL_ISA_BASELINE, SL_ISA_AVX2, SL_ISA_AVX512, SL_ISAS } sl_isa;

/* The best that the CPU has, this build holds and SOFTLUX_ISA allows. */
sl_isa sl_isa_best(void);
const char *sl_isa_name(sl_isa isa);

/* SL_KERNEL(name) is name_baseline, name_avx2 or name_avx512, as SL_ISA_SUFFIX says (the Makefile sets it).
 */
#define SL_KERNEL_PASTE2(name, suffix) name##_##suffix
#define SL_KERNEL_PASTE(name, suffix) SL_KERNEL_PASTE2(name, suffix)
#define SL_KERNEL(name) SL_KERNEL_PASTE(name, SL_ISA_SUFFIX)

/* Choosing among the variants. SL_KERNEL_VARIANTS(type, name) declares them, `type` being a table's type or a
 * function's (a typedef of it); SL_KERNEL_OF(isa, name) is the function of that instruction set.
 * SL_KERNEL_TABLE(type, name) defines const type *name_best(void), the best table of this machine. */
#ifdef SL_BASELINE_ONLY
#define SL_KERNEL_VARIANTS(type, name) extern type name##_baseline
#define SL_KERNEL_OF(isa, name) ((void)(isa), name##_baseline)
#define SL_KERNEL_CHOICE(isa, name) ((void)(isa), &name##_baseline)
#else
#define SL_KERNEL_VARIANTS(type, name) extern type name##_baseline, name##_avx2, name##_avx512
#define SL_KERNEL_OF(isa, name) \
    ((isa) == SL_ISA_AVX512 ? name##_avx512 : (isa) == SL_ISA_AVX2 ? name##_avx2 : name##_baseline)
#define SL_KERNEL_CHOICE(isa, name) SL_KERNEL_OF(isa, &name)
#endif
#define SL_KERNEL_TABLE(type, name) \
    SL_KERNEL_VARIANTS(const type, name); \
    const type *name##_best(void) { return SL_KERNEL_CHOICE(sl_isa_best(), name); }

#endif
