/* Manual pages, in the language of man(7), from the same tables as --help, so that the two cannot disagree.
 */
#pragma once

#include "app/commands.h"
#include "app/options.h"


/* The page of one command, on stdout. */
void sl_print_command_manual(const sl_command_line *line);
/* The page of the program and its commands. */
void sl_print_program_manual(const sl_command *commands, size_t count);

/* ---- options of methods ---- */

/* The last part of a setting's name: what the command line calls it. */
const char *sl_setting_flag(const sl_setting *setting);
/* Its line of help, with the default in brackets. */
void sl_setting_help(const sl_setting *setting, char *text, size_t room);
/* Prints all of them, method by method. */
void sl_print_settings(void);
