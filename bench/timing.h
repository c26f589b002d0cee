/* What the benchmarks share: clocks and medians. Processor time is what others on the machine disturb least;
 * wall time is what more threads are for. */
#ifndef SL_BENCH_TIMING_H
#define SL_BENCH_TIMING_H

#include <stdlib.h>
#include <time.h>

static inline double clock_ms(clockid_t clock) {
    struct timespec t;
    clock_gettime(clock, &t);
    return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

static inline double now_ms(void) { return clock_ms(CLOCK_THREAD_CPUTIME_ID); } /* of this thread alone */
/* of all threads together */
static inline double process_ms(void) { return clock_ms(CLOCK_PROCESS_CPUTIME_ID); }
static inline double wall_ms(void) { return clock_ms(CLOCK_MONOTONIC); }

static inline int by_value(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Sorts the values. */
static inline double median(double *values, int count) {
    qsort(values, (size_t)count, sizeof *values, by_value);
    return values[count / 2];
}

/* Half the distance of the quartiles, as a share of the median. Sorts the values. */
static inline double spread(double *values, int count) {
    double middle = median(values, count);
    return middle > 0.0 ? 0.5 * (values[count - 1 - count / 4] - values[count / 4]) / middle : 0.0;
}

#endif
