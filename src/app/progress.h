/* What goes on, for who waits: a line on a terminal that each next one replaces. */
#ifndef SL_APP_PROGRESS_H
#define SL_APP_PROGRESS_H

#include <stdbool.h>

/* Shows a bar that is filled to the fraction (none if negative), and text. Nothing where quiet is asked for,
 * or standard error is no terminal. */
__attribute__((format(printf, 3, 4))) void sl_progress_show(bool quiet, double fraction, const char *format,
                                                           ...);
/* Takes the line away; or ends it, so that it stays. */
void sl_progress_clear(bool quiet);
void sl_progress_keep(bool quiet);

#endif
