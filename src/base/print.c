#define _GNU_SOURCE
#include "base/print.h"

#include <locale.h>
#include <stdio.h>

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
