/* The account of a show: frames, updates, where the time of an update goes. */
#ifndef SL_APP_LIVE_REPORT_H
#define SL_APP_LIVE_REPORT_H

#include "app/clock.h"

typedef struct sl_show_report {
    const char *scene, *method;
    int width, height;
    double seconds;
    uint64_t frames, missed;
    double drawing, longest;      /* seconds of the drawing thread, and by the clock */
    /* seconds from moves to frames that show what they have changed: their sum over last.changes_shown, and
     * the longest */
    double lag, longest_lag;
    sl_live_state last;
    sl_counters counters;
    const sl_pass_times *stages;
} sl_show_report;

void sl_show_report_print(const sl_show_report *report); /* to stderr: stdout may be the stream */
void sl_show_report_json(const sl_show_report *report);

#endif
