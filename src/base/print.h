/* Numbers are printed and read with a decimal point, whatever the locale of the program that the library is a
 * part of: many have a comma. */
#pragma once

#include <stdarg.h>
#include <stddef.h>

/* As snprintf and vsnprintf; for all that may have a fraction. */
__attribute__((format(printf, 3, 4))) int sl_print(char *text, size_t size, const char *format, ...);
__attribute__((format(printf, 3, 0))) int sl_print_list(char *text, size_t size, const char *format,
                                                        va_list arguments);

/* For what reads numbers, libraries too: between the two the calling thread has the C locale. The second
 * takes what the first returned. */
void *sl_c_locale_begin(void);
void sl_c_locale_end(void *before);
