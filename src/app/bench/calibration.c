#include "app/bench/calibration.h"

#include <stdint.h>
#include <time.h>

static double seconds(clockid_t clock) {
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Some 25 milliseconds, longer than a turn among processes; what it computes is stored where the compiler must believe that somebody looks. */
sl_calibration sl_calibrate(void) {
    static volatile double sink;
    double wall = seconds(CLOCK_MONOTONIC), cpu = seconds(CLOCK_THREAD_CPUTIME_ID), sum = 0.0;
    uint64_t state = 88172645463325252u;
    for (int i = 0; i < 16000000; i++) {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        sum += (double)(state >> 40) * 0x1p-24;
    }
    sink = sum;
    (void)sink;
    return (sl_calibration){seconds(CLOCK_MONOTONIC) - wall, seconds(CLOCK_THREAD_CPUTIME_ID) - cpu};
}
