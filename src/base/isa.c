#include "base/isa.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

static const char *const isa_names[SL_ISAS] = {"baseline", "avx2", "avx512"};

const char *sl_isa_name(sl_isa isa) { return isa_names[isa]; }

static sl_isa isa_of_cpu(void) {
#ifdef SL_BASELINE_ONLY
    return SL_ISA_BASELINE;
#else
    __builtin_cpu_init();
    bool v3 =
        __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2");
    bool v4 = v3 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
              __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
              __builtin_cpu_supports("avx512vl");
    return v4 ? SL_ISA_AVX512 : v3 ? SL_ISA_AVX2 : SL_ISA_BASELINE;
#endif
}

sl_isa sl_isa_best(void) {
    sl_isa best = isa_of_cpu();
    const char *wanted = getenv("SOFTLUX_ISA");
    for (int isa = 0; wanted && isa < (int)best; isa++) {
        if (strcmp(wanted, isa_names[isa]) == 0) return (sl_isa)isa;
    }
    return best;
}
