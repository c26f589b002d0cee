#pragma once

#include "softlux.h"

static inline void sl_count(sl_counters *counters, sl_counter counter, uint64_t amount) {
    counters->value[counter] += amount;
}
void sl_counters_add(sl_counters *sum, const sl_counters *other);
void sl_counters_subtract(sl_counters *from, const sl_counters *other);
