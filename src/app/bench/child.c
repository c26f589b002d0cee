#include "app/bench/child.h"

#include "app/clock.h"

#include "base/error.h"
#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

enum { EXIT_FAILED = 100 }; /* of a child that has told why */

/* ---- in the child ---- */

bool sl_write_all(int out, const char *text, size_t left) {
    while (left > 0) {
        ssize_t n = write(out, text, left);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return false;
        text += n;
        left -= (size_t)n;
    }
    return true;
}

static _Noreturn void be_child(sl_child_work *work, void *context, const sl_child_limits *limits,
                               pid_t parent, int out) {
    prctl(PR_SET_PDEATHSIG, SIGKILL); /* nobody would read what it finds out */
    if (getppid() != parent) _exit(EXIT_FAILED);
    signal(SIGINT, SIG_IGN); /* the parent, who got it too, decides */
    signal(SIGHUP, SIG_IGN);
    signal(SIGTERM, SIG_DFL);
    signal(SIGPIPE, SIG_DFL);
    const struct rlimit none = {0, 0};
    setrlimit(RLIMIT_CORE, &none);
    if (limits->memory_bytes) {
        const struct rlimit most = {(rlim_t)limits->memory_bytes, (rlim_t)limits->memory_bytes};
        setrlimit(RLIMIT_AS, &most);
    }
    char *report = NULL;
    bool well = work(context, &report);
    if (!report || !sl_write_all(out, report, strlen(report))) well = false;
    _exit(well ? 0 : EXIT_FAILED); /* none of the parent's buffers is to be written twice */
}

/* ---- in the parent ---- */

/* Reads until the child closes its end. SL_CHILD_DONE: so it did. */
static sl_child_outcome listen_to(int in, const sl_child_limits *limits, FILE *report) {
    double until = sl_seconds_now() + limits->seconds;
    for (;;) {
        char bytes[8192];
        struct pollfd wait = {in, POLLIN, 0};
        int ready = poll(&wait, 1, 50);
        if (limits->interrupted && limits->interrupted()) return SL_CHILD_LEFT_OUT;
        if (limits->seconds > 0.0 && sl_seconds_now() > until) return SL_CHILD_STOPPED;
        ssize_t n = ready > 0 ? read(in, bytes, sizeof bytes) : 1;
        if (n == 0 || (n < 0 && errno != EINTR)) return SL_CHILD_DONE;
        if (ready > 0 && n > 0) fwrite(bytes, 1, (size_t)n, report);
    }
}

static void explain(int how, const sl_child_limits *limits, sl_child_end *end) {
    if (end->outcome == SL_CHILD_STOPPED) {
        snprintf(end->why, sizeof end->why, "stopped after %g seconds", limits->seconds);
    } else if (end->outcome == SL_CHILD_LEFT_OUT) {
        snprintf(end->why, sizeof end->why, "interrupted");
    } else if (WIFSIGNALED(how)) {
        end->outcome = SL_CHILD_CRASHED;
        snprintf(end->why, sizeof end->why, "%s", strsignal(WTERMSIG(how)));
        if (WTERMSIG(how) == SIGKILL)
            snprintf(end->why, sizeof end->why, "killed, most likely for want of memory");
    } else if (WEXITSTATUS(how) == EXIT_FAILED) {
        end->outcome = SL_CHILD_FAILED;
        snprintf(end->why, sizeof end->why, "%.*s", (int)strcspn(end->text, "\n"), end->text);
        if (!*end->text) snprintf(end->why, sizeof end->why, "failed without a word of why");
    } else if (WEXITSTATUS(how) != 0) {
        end->outcome = SL_CHILD_CRASHED;
        snprintf(end->why, sizeof end->why, "ended with status %d", WEXITSTATUS(how));
    }
}

/* Closes the report, too, where it is open. */
static sl_status fail_to_start(FILE *report, sl_child_end *end, sl_error *error) {
    sl_status status =
        sl_fail(error, SL_ERROR_RESOURCES, "cannot start a process: %s", strerror(errno));
    if (report) fclose(report);
    free(end->text);
    end->text = NULL;
    return status;
}

sl_status sl_child_run(sl_child_work *work, void *context, const sl_child_limits *limits, sl_child_end *end,
                       sl_error *error) {
    int ends[2], how = 0;
    size_t length;
    *end = (sl_child_end){SL_CHILD_DONE, NULL, ""};
    FILE *report = open_memstream(&end->text, &length);
    if (!report || pipe(ends) != 0) return fail_to_start(report, end, error);
    fflush(NULL);
    pid_t parent = getpid(), child = fork();
    if (child < 0) {
        close(ends[0]);
        close(ends[1]);
        return fail_to_start(report, end, error);
    }
    if (child == 0) {
        close(ends[0]);
        be_child(work, context, limits, parent, ends[1]);
    }
    close(ends[1]);
    end->outcome = listen_to(ends[0], limits, report);
    if (end->outcome != SL_CHILD_DONE) kill(child, SIGKILL);
    close(ends[0]);
    while (waitpid(child, &how, 0) < 0 && errno == EINTR) {}
    if (fclose(report) != 0) return fail_to_start(NULL, end, error);
    explain(how, limits, end);
    if (end->outcome != SL_CHILD_DONE) end->text[0] = '\0';
    return SL_OK;
}
