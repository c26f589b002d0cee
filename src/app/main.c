/* softlux: the program. Each subcommand has a file of its own. */
#include "app/commands.h"
#include "app/manual.h"
#include "base/values.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static const sl_command commands[] = {
    {"render", sl_command_render, "compute a picture of a scene"},
    {"compare", sl_command_compare, "error metrics between two pictures; exit status for golden-image tests"},
    {"info", sl_command_info, "what is in a scene, and what a method would do with it"},
    {"live", sl_command_live, "play a scene that moves, as it comes"},
    {"serve", sl_command_serve,
     "serve a page to move in a scene, change it, compare methods, take them apart"},
    {"bench", sl_command_bench, "speed against error of every method on a scene"},
    {"steps", sl_command_steps, "every pass of a method as a picture, explained, in one page"},
    {"check-numerics", sl_command_check_numerics, "every method on scenes that break careless code"},
};
enum { COMMANDS = sizeof commands / sizeof commands[0] };

static void print_help(FILE *out) {
    fprintf(out,
            "usage: softlux COMMAND ...\n\n"
            "Global illumination of triangle scenes on a CPU: deterministic, without a GPU.\n\ncommands:\n");
    for (size_t i = 0; i < COMMANDS; i++) fprintf(out, "  %-15s %s\n", commands[i].name, commands[i].summary);
    fprintf(out, "\n`softlux COMMAND --help` tells more, `softlux help settings` every option of the "
                 "methods; `softlux --version`\n"
                 "prints the version.\n"
                 "Exit status: 0, 1 comparison failed, 2 usage, 3 input, 4 output, 5 resources; 128 + N "
                 "where signal N (Ctrl-C: 2)\n"
                 "cut the work short: what was done by then is written.\n\n"
                 "example: softlux render scenes/cornell.json -o cornell.png\n");
}

/* A stream that was closed leaves its number to the first file that is opened, and what is printed would go
 * there. */
static void hold_standard_streams(void) {
    for (int stream = 0; stream < 3; stream++) {
        if (fcntl(stream, F_GETFD) < 0)
            (void)!open("/dev/null", stream == STDERR_FILENO ? O_WRONLY : O_RDONLY);
    }
}

/* Checks that what was printed has arrived: a disk may be full. A command that failed has said its line, most
 * likely of that. */
static int conclude(int status) {
    bool arrived = !ferror(stdout);
    if ((fflush(stdout) == 0 && arrived) || status > SL_EXIT_COMPARISON_FAILED) return status;
    fprintf(stderr, "softlux: cannot write standard output: %s\n", strerror(errno));
    return SL_ERROR_OUTPUT;
}

static int run(int argc, char **argv) {
    if (argc < 2) {
        print_help(stderr);
        return SL_ERROR_USAGE;
    }
    if (strcmp(argv[1], "help") == 0 && argc > 2 && strcmp(argv[2], "settings") == 0) {
        sl_print_settings();
        return 0;
    }
    if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0 || strcmp(argv[1], "help") == 0) {
        print_help(stdout);
        return 0;
    }
    if (strcmp(argv[1], "--man") == 0) {
        sl_print_program_manual(commands, COMMANDS);
        return 0;
    }
    if (strcmp(argv[1], "--version") == 0) {
        printf("softlux %s\n", SL_VERSION);
        return 0;
    }
    const char *names[COMMANDS];
    for (size_t i = 0; i < COMMANDS; i++) {
        names[i] = commands[i].name;
        if (strcmp(argv[1], names[i]) == 0) return commands[i].run(argc - 2, argv + 2);
    }
    const char *near = sl_nearest_word(argv[1], names, COMMANDS);
    fprintf(stderr, "softlux: unknown command '%s'%s%s; see softlux --help\n", argv[1],
            near ? "; did you mean " : "", near ? near : "");
    return SL_ERROR_USAGE;
}

/* As if the signal had not been handled: a shell sees 128 + its number, and leaves its loop. */
static int end_by_signal(int status) {
    if (status <= SL_EXIT_SIGNAL) return status;
    signal(status - SL_EXIT_SIGNAL, SIG_DFL);
    raise(status - SL_EXIT_SIGNAL);
    return status;
}

int main(int argc, char **argv) {
    hold_standard_streams();
    signal(SIGXFSZ, SIG_IGN); /* a file that may not grow is an output error, told in a line */
    return end_by_signal(conclude(run(argc, argv)));
}
