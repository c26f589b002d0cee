#define _XOPEN_SOURCE 700 /* sigaltstack() */
#include "app/load.h"

#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/sanitized.h"

enum { CRASHES = 5, STACK_BYTES = 1 << 16, LINE_BYTES = 1 << 13 };
static const int crashes[CRASHES] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};

static char last_line[LINE_BYTES]; /* made beforehand, since handlers get no context and must not format: the heap may be what is damaged */

static void make_last_line(const char *path) {
    snprintf(last_line, sizeof last_line, "softlux: %.4096s: cannot be read: the importer of mesh files crashed on it or on a file that it names, as it does on some "
             "damaged ones; expected sound files", path ? path : "");
    for (char *c = last_line; *c; c++) {
        if (*c == '\n' || *c == '\r') *c = ' ';
    }
    strcat(last_line, "\n");
}

/* A crash in here ends the process by its signal, which is reset and, meanwhile, blocked. One write, so that lines of two threads that crash do not mix. */
static void on_crash(int signal_number) {
    (void)signal_number;
    ssize_t written = write(STDERR_FILENO, last_line, strlen(last_line));
    (void)written; /* whom else to tell? */
    _exit(SL_ERROR_INPUT);
}

sl_status sl_load_scene(const char *path, const sl_load_options *options, sl_scene **scene, sl_error *error) {
    static char stack[STACK_BYTES]; /* what was read may have been nested so deep that the thread's own is full; nothing reads in other threads */
    const stack_t apart = {.ss_sp = stack, .ss_size = sizeof stack};
    stack_t stack_before;
    struct sigaction before[CRASHES], action = {.sa_handler = on_crash, .sa_flags = (int)(SA_ONSTACK | SA_RESETHAND)};
    sigemptyset(&action.sa_mask);
    make_last_line(path);
    bool watched = !SL_SANITIZED && sigaltstack(&apart, &stack_before) == 0;
    for (int i = 0; watched && i < CRASHES; i++) sigaction(crashes[i], &action, &before[i]);
    sl_status status = sl_scene_load_with(path, options, scene, error);
    for (int i = 0; watched && i < CRASHES; i++) sigaction(crashes[i], &before[i], NULL);
    if (watched) sigaltstack(&stack_before, NULL);
    return status;
}
