#include "app/clock.h"

#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
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
static atomic_int interrupted;

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

/* ---- time of a method's passes ---- */

void sl_pass_times_add(sl_pass_times *t, const char *name, double seconds) {
    int i = 0;
    while (i < t->count && strcmp(t->pass[i].name, name) != 0) i++;
    if (i == SL_PASS_TIMES) i--;
    if (i == t->count) snprintf(t->pass[t->count++].name, sizeof t->pass[i].name, "%.63s", name);
    t->pass[i].times++;
    t->pass[i].seconds += seconds;
}

/* Charges a pass, which announces itself when it is done, with what passed since the last one did. */
static void end_of_pass(void *context, const sl_pass *pass) {
    sl_pass_times *t = context;
    double now = t->clock(), since = t->last <= now ? t->last : 0.0; /* a thread's own clock begins at 0 */
    sl_pass_times_add(t, pass->name, now - since);
    t->last = now;
}

void sl_pass_times_begin(sl_pass_times *t, double (*clock)(void)) {
    memset(t, 0, sizeof *t);
    t->observer = (sl_observer){.context = t, .pass = end_of_pass};
    t->clock = clock;
    t->last = clock();
}
