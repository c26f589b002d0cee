/* The clock, Ctrl-C, and what goes on, for who waits. */
#pragma once

#include "softlux.h"


double sl_seconds_now(void);      /* since some time in the past, whatever the calendar does */
double sl_thread_seconds(void);   /* that this thread has had a processor */
double sl_process_seconds(void);  /* that all threads have, together */
void sl_sleep_until(double now);  /* or until Ctrl-C */

/* Ctrl-C, SIGTERM and SIGHUP (unless that is ignored, as nohup has it) end nothing any more, but leave word;
 * the second time they end the program. */
void sl_watch_for_interrupt(void);
bool sl_interrupted(void);
/* Of work that was cut short: 128 + the signal's number. main() ends the program by that signal, so that a
 * shell's loop ends, too. */
int sl_interrupted_status(void);

/* Shows, on a line of a terminal that each next one replaces, a bar that is filled to the fraction (none if
 * negative), and text; nothing where quiet is asked for, or standard error is no terminal. */
__attribute__((format(printf, 3, 4))) void sl_progress_show(bool quiet, double fraction, const char *format,
                                                           ...);
/* Takes the line away; or ends it, so that it stays. */
void sl_progress_clear(bool quiet);
void sl_progress_keep(bool quiet);

/* ---- time of a method's passes ---- */

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
