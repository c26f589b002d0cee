/* Filling an sl_error. `error` may be NULL everywhere. */
#pragma once

#include "softlux.h"

/* Formats one line into *error (newlines become spaces) and returns status, so that a failing function can
 * end with `return sl_fail(error, SL_ERROR_INPUT, "%s:%d: expected ...", file, line);` */
__attribute__((format(printf, 3, 4))) sl_status sl_fail(sl_error *error, sl_status status, const char *format,
                                                        ...);
/* The one answer of a public function to a NULL that no comment in softlux.h allows: what it expected
 * instead. */
sl_status sl_fail_null(sl_error *error, const char *expected);
/* The one answer to a failed allocation of `what`. */
sl_status sl_fail_memory(sl_error *error, const char *what);
/* A number that lies outside of [low, high], with as few digits, six at least, as show that it does; returns
 * text. */
const char *sl_outside_text(double value, double low, double high, char text[32]);
/* Returns what a system call that failed with this errno failed for: resources (no memory, no more files), or
 * as its caller says. */
sl_status sl_status_of_errno(int reason, sl_status otherwise);
