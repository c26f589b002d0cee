/* The clock, and Ctrl-C. */
#ifndef SL_APP_CLOCK_H
#define SL_APP_CLOCK_H

#include <stdbool.h>

double sl_seconds_now(void);      /* since some time in the past, whatever the calendar does */
double sl_thread_seconds(void);   /* that this thread has had a processor */
double sl_process_seconds(void);  /* that all threads have, together */
void sl_sleep_until(double now);  /* or until Ctrl-C */

/* Ctrl-C (and SIGTERM) ends nothing any more, but leaves word; the second time it ends the program. */
void sl_watch_for_interrupt(void);
bool sl_interrupted(void);

#endif
