/* The benchmarks' clocks in milliseconds, and medians. Processor time is what others on the machine
 * disturb least; wall time is what more threads are for. */
#pragma once

#include "app/bench/results.h"
#include "app/clock.h"

static inline double now_ms(void) { return 1e3 * sl_thread_seconds(); } /* of this thread alone */
static inline double process_ms(void) { return 1e3 * sl_process_seconds(); } /* of all threads together */
static inline double wall_ms(void) { return 1e3 * sl_seconds_now(); }

/* Sorts the values. */
static inline double median(double *values, int count) { return sl_bench_spread_of(values, count).median; }

/* Half the distance of the quartiles, as a share of the median. Sorts the values. */
static inline double spread(double *values, int count) {
    double middle = median(values, count);
    return middle > 0.0 ? 0.5 * (values[count - 1 - count / 4] - values[count / 4]) / middle : 0.0;
}
