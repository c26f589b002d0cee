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

typedef struct report {
    char *text;
    size_t length, room;
} report;

/* More of the report; false at its end. */
static bool read_more(int in, report *r) {
    if (r->room - r->length < 4096) {
        size_t room = 2 * r->room + 8192;
        char *more = realloc(r->text, room);
        if (!more) return false;
        r->text = more;
        r->room = room;
    }
    ssize_t n = read(in, r->text + r->length, r->room - r->length - 1);
    if (n < 0) return errno == EINTR;
    r->length += (size_t)n;
    return n > 0;
}

/* Reads until the child closes its end. SL_CHILD_DONE: so it did. */
static sl_child_outcome listen_to(int in, const sl_child_limits *limits, report *r) {
    double until = sl_seconds_now() + limits->seconds;
    for (;;) {
        struct pollfd wait = {in, POLLIN, 0};
        int ready = poll(&wait, 1, 50);
        if (limits->interrupted && limits->interrupted()) return SL_CHILD_LEFT_OUT;
        if (limits->seconds > 0.0 && sl_seconds_now() > until) return SL_CHILD_STOPPED;
        if (ready > 0 && !read_more(in, r)) return SL_CHILD_DONE;
    }
}

static void explain(int how, const sl_child_limits *limits, const report *r, sl_child_end *end) {
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
        snprintf(end->why, sizeof end->why, "%.*s", r->length ? (int)strcspn(r->text, "\n") : 27,
                 r->length ? r->text : "failed without a word of why");
    } else if (WEXITSTATUS(how) != 0) {
        end->outcome = SL_CHILD_CRASHED;
        snprintf(end->why, sizeof end->why, "ended with status %d", WEXITSTATUS(how));
    }
}

static sl_status fail_to_start(sl_error *error) {
    return sl_fail(error, SL_ERROR_RESOURCES, "cannot start a process: %s", strerror(errno));
}

sl_status sl_child_run(sl_child_work *work, void *context, const sl_child_limits *limits, sl_child_end *end,
                       sl_error *error) {
    int ends[2], how = 0;
    *end = (sl_child_end){SL_CHILD_DONE, NULL, ""};
    if (pipe(ends) != 0) return fail_to_start(error);
    fflush(NULL);
    pid_t parent = getpid(), child = fork();
    if (child < 0) {
        close(ends[0]);
        close(ends[1]);
        return fail_to_start(error);
    }
    if (child == 0) {
        close(ends[0]);
        be_child(work, context, limits, parent, ends[1]);
    }
    close(ends[1]);
    report r = {calloc(1, 1), 0, 1};
    end->outcome = listen_to(ends[0], limits, &r);
    if (end->outcome != SL_CHILD_DONE) kill(child, SIGKILL);
    close(ends[0]);
    while (waitpid(child, &how, 0) < 0 && errno == EINTR) {}
    if (r.text) r.text[r.length] = '\0';
    explain(how, limits, &r, end);
    if (end->outcome != SL_CHILD_DONE && r.text) r.text[0] = '\0';
    end->text = r.text;
    return r.text ? SL_OK : fail_to_start(error);
}
