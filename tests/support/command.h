/* A subcommand of the program in a process of its own, as a person starts it. */
#pragma once

#include <sys/types.h>

typedef int command(int argc, char **argv);

/* Starts it with a line of words; those that begin with %/ name files in the folder. What it says goes to the
 * files out and err (NULL: nowhere, and where the test's own goes). */
pid_t command_start(command *run, const char *line, const char *folder, const char *out, const char *err);
