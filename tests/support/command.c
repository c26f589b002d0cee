#include "command.h"

#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static void redirect(const char *name, int stream) {
    int file = open(name, O_WRONLY | O_CREAT | O_TRUNC, 0666);
    if (file >= 0) dup2(file, stream);
}

static _Noreturn void be_the_program(command *run, const char *line, const char *folder) {
    enum { WORDS = 64, WORD = 300 };
    static char words[WORDS][WORD];
    char *argv[WORDS + 1], text[4096], *rest = NULL;
    int argc = 0;
    snprintf(text, sizeof text, "%s", line);
    for (char *word = strtok_r(text, " ", &rest); word && argc < WORDS; word = strtok_r(NULL, " ", &rest)) {
        int below = word[0] == '%' && word[1] == '/';
        snprintf(words[argc], WORD, "%s%s", below ? folder : "", word + below);
        argv[argc] = words[argc], argc++;
    }
    argv[argc] = NULL;
    int status = run(argc, argv);
    fflush(NULL);
    _exit(status);
}

pid_t command_start(command *run, const char *line, const char *folder, const char *out, const char *err) {
    fflush(NULL);
    pid_t child = fork();
    if (child) return child;
    redirect(out ? out : "/dev/null", STDOUT_FILENO);
    if (err) redirect(err, STDERR_FILENO);
    be_the_program(run, line, folder);
}
