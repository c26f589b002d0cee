/* How long each pass of a method takes, by an observer that looks at a clock: that of the updating thread, so
 * that time in which others had its processor does not count, or that of all threads together. */
#ifndef SL_APP_PASS_TIMES_H
#define SL_APP_PASS_TIMES_H

#include "softlux.h"

enum { SL_PASS_TIMES = 256 };

typedef struct sl_pass_time {
    char name[64];
    uint64_t times;
    double seconds;
} sl_pass_time;

typedef struct sl_pass_times {
    sl_observer observer; /* to be given to the method */
    sl_pass_time pass[SL_PASS_TIMES];
    int count;
    double (*clock)(void);
    double last;
} sl_pass_times;

void sl_pass_times_begin(sl_pass_times *times, double (*clock)(void)); /* which must stay where it is */
void sl_pass_times_add(sl_pass_times *times, const char *name, double seconds);
double sl_pass_times_sum(const sl_pass_times *times);

#endif
