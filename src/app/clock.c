#include "app/clock.h"

#include <signal.h>
#include <string.h>
#include <time.h>

static double seconds_of(clockid_t clock) {
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

double sl_seconds_now(void) { return seconds_of(CLOCK_MONOTONIC); }
double sl_thread_seconds(void) { return seconds_of(CLOCK_THREAD_CPUTIME_ID); }
double sl_process_seconds(void) { return seconds_of(CLOCK_PROCESS_CPUTIME_ID); }

/* The one thing that a signal handler can do: leave word. */
static volatile sig_atomic_t interrupted;

static void on_interrupt(int signal_number) {
    interrupted = signal_number;
}

void sl_watch_for_interrupt(void) {
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_handler = on_interrupt;
    action.sa_flags = (int)SA_RESETHAND; /* a second Ctrl-C ends the program at once */
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    struct sigaction before;
    if (sigaction(SIGHUP, NULL, &before) == 0 && before.sa_handler != SIG_IGN)
        sigaction(SIGHUP, &action, NULL);
}

bool sl_interrupted(void) { return interrupted != 0; }
int sl_interrupted_status(void) { return 128 + (int)interrupted; }

/* In small steps: the signal may have gone to another thread. */
void sl_sleep_until(double now) {
    for (double left; (left = now - sl_seconds_now()) > 0.0 && !interrupted;) {
        double step = left < 0.05 ? left : 0.05;
        nanosleep(&(struct timespec){0, (long)(1e9 * step)}, NULL);
    }
}
