#include "app/clock.h"

#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

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

/* ---- progress ---- */

static bool is_seen(bool quiet) { return !quiet && isatty(STDERR_FILENO); }

void sl_progress_show(bool quiet, double fraction, const char *format, ...) {
    enum { CELLS = 30 };
    char bar[CELLS + 1], text[400];
    va_list values;
    if (!is_seen(quiet)) return;
    for (int i = 0; i < CELLS; i++) bar[i] = i < (int)(fraction * CELLS) ? '#' : '.';
    bar[CELLS] = '\0';
    va_start(values, format);
    vsnprintf(text, sizeof text, format, values);
    va_end(values);
    if (fraction < 0.0) fprintf(stderr, "\r\033[K%s", text);
    else fprintf(stderr, "\r\033[K[%s] %s", bar, text);
    fflush(stderr);
}

void sl_progress_clear(bool quiet) {
    if (is_seen(quiet)) fputs("\r\033[K", stderr);
}

void sl_progress_keep(bool quiet) {
    if (is_seen(quiet)) fputc('\n', stderr);
}
