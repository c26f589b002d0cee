#include "app/progress.h"

#include <stdarg.h>
#include <stdio.h>
#include <unistd.h>

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
