/* The program's subcommands: each takes the arguments after its own name and returns the exit status:
 * 0, 1 (comparison failed), 2 (usage), 3 (input), 4 (output), 5 (resources), above 128 (cut short by a
 * signal, 128 + its number). */
#pragma once

enum { SL_EXIT_COMPARISON_FAILED = 1, SL_EXIT_SIGNAL = 128 };

typedef struct sl_command {
    const char *name;
    int (*run)(int argc, char **argv);
    const char *summary; /* what it does */
} sl_command;

int sl_command_render(int argc, char **argv);
int sl_command_compare(int argc, char **argv);
int sl_command_info(int argc, char **argv);
int sl_command_bench(int argc, char **argv);
int sl_command_steps(int argc, char **argv);
int sl_command_check_numerics(int argc, char **argv);
int sl_command_live(int argc, char **argv);
int sl_command_serve(int argc, char **argv);
