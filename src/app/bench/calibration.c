#include "app/bench/calibration.h"

#include "app/clock.h"

#include <stdint.h>

/* Takes some 25 milliseconds, longer than a turn among processes; what it computes is stored where the
 * compiler must believe that somebody looks. */
sl_calibration sl_calibrate(void) {
    static volatile double sink;
    double wall = sl_seconds_now(), cpu = sl_thread_seconds(), sum = 0.0;
    uint64_t state = 88172645463325252u;
    for (int i = 0; i < 16000000; i++) {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        sum += (double)(state >> 40) * 0x1p-24;
    }
    sink = sum;
    (void)sink;
    return (sl_calibration){sl_seconds_now() - wall, sl_thread_seconds() - cpu};
}
