#define _GNU_SOURCE /* uselocale() */
#include "base/error.h"

#include <errno.h>
#include <locale.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/print.h"

/* ---- text with a decimal point --------------------------------------------------------------- */

/* The C locale is there from the start: asking for it makes nothing that would have to be freed, and cannot
 * fail. */
void *sl_c_locale_begin(void) { return uselocale(newlocale(LC_ALL_MASK, "C", (locale_t)0)); }

void sl_c_locale_end(void *before) { uselocale((locale_t)before); }

int sl_print_list(char *text, size_t size, const char *format, va_list arguments) {
    void *before = sl_c_locale_begin();
    const int length = vsnprintf(text, size, format, arguments);
    sl_c_locale_end(before);
    return length;
}

int sl_print(char *text, size_t size, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    const int length = sl_print_list(text, size, format, arguments);
    va_end(arguments);
    return length;
}

/* ---- errors ---------------------------------------------------------------------------------- */

sl_status sl_fail(sl_error *error, sl_status status, const char *format, ...) {
    if (!error) return status;
    error->status = status;
    va_list arguments;
    va_start(arguments, format);
    sl_print_list(error->message, sizeof error->message, format, arguments);
    va_end(arguments);
    for (char *c = error->message; *c; c++) {
        if (*c == '\n' || *c == '\r') *c = ' ';
    }
    return status;
}

sl_status sl_fail_null(sl_error *error, const char *expected) {
    return sl_fail(error, SL_ERROR_USAGE, "expected %s, got NULL", expected);
}

sl_status sl_fail_memory(sl_error *error, const char *what) {
    return sl_fail(error, SL_ERROR_RESOURCES, "not enough memory for %s", what);
}

const char *sl_outside_text(double value, double low, double high, char text[32]) {
    void *before = sl_c_locale_begin();
    for (int digits = 6; digits <= 17; digits++) {
        sl_print(text, 32, "%.*g", digits, value);
        double read = strtod(text, NULL);
        if (!(read >= low && read <= high)) break;
    }
    sl_c_locale_end(before);
    return text;
}

sl_status sl_status_of_errno(int reason, sl_status otherwise) {
    return reason == ENOMEM || reason == EMFILE || reason == ENFILE ? SL_ERROR_RESOURCES : otherwise;
}
