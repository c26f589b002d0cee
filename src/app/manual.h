/* Manual pages, in the language of man(7), from the same tables as --help, so that the two cannot disagree.
 */
#ifndef SL_APP_MANUAL_H
#define SL_APP_MANUAL_H

#include "app/options.h"

#include <stddef.h>

/* The page of one command, on stdout. */
void sl_print_command_manual(const sl_command_line *line);
/* The page of the program: `count` commands, their names and what each does. */
void sl_print_program_manual(const char *const *names, const char *const *summaries, size_t count);

#endif
