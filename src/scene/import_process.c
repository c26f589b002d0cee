#include "scene/import_process.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/error.h"
#include "base/memory.h"
#include "base/print.h"
#include "scene/import_reply.h"

extern char **environ;

enum { PLACEMENT_BYTES = 12 * 32 };

/* One process and the line to it. */
typedef struct helper {
    const char *path, *program;
    sl_import_limits limits;
    pid_t id;
    int line;
    sl_error *error;
} helper;

sl_import_limits sl_import_limits_of(const char *path) {
    struct stat about;
    double bytes = stat(path, &about) == 0 ? (double)about.st_size : 0.0;
    double processor = 60.0 + bytes / 1e6;
    const uint64_t addresses = ((uint64_t)8 << 30) + 64 * (uint64_t)bytes;
    return (sl_import_limits){(unsigned)(10.0 * processor), (unsigned)processor, addresses};
}

/* ---- starting ------------------------------------------------------------------------------------------ */

static const char *program_path(void) {
    const char *named = getenv("SOFTLUX_IMPORTER");
    return named && *named ? named : sl_importer_path;
}

/* No signal of the caller's is ignored or blocked there, and what its terminal sends goes to the caller
 * alone. What libraries have to say of their own end goes nowhere. */
static int describe(int end, posix_spawn_file_actions_t *files, posix_spawnattr_t *attributes) {
    sigset_t none, all;
    sigemptyset(&none);
    sigfillset(&all);
    posix_spawnattr_setsigmask(attributes, &none);
    posix_spawnattr_setsigdefault(attributes, &all);
    posix_spawnattr_setpgroup(attributes, 0);
    posix_spawnattr_setflags(attributes,
                             POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
    int failed = posix_spawn_file_actions_adddup2(files, end, STDIN_FILENO);
    if (!failed) failed = posix_spawn_file_actions_adddup2(files, STDIN_FILENO, STDOUT_FILENO);
    if (failed) return failed;
    return posix_spawn_file_actions_addopen(files, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
}

static int spawn(helper *h, int end, char *const arguments[]) {
    posix_spawn_file_actions_t files;
    posix_spawnattr_t attributes;
    int failed = posix_spawn_file_actions_init(&files);
    if (failed) return failed;
    failed = posix_spawnattr_init(&attributes);
    if (!failed) {
        failed = describe(end, &files, &attributes);
        if (!failed) failed = posix_spawn(&h->id, h->program, &files, &attributes, arguments, environ);
        posix_spawnattr_destroy(&attributes);
    }
    posix_spawn_file_actions_destroy(&files);
    return failed;
}

static void write_placement(const sl_affine *a, char text[PLACEMENT_BYTES]) {
    for (int i = 0, at = 0; i < 12; i++)
        at += sl_print(text + at, (size_t)(PLACEMENT_BYTES - at), "%a ", a->m[i / 4][i % 4]);
}

static sl_status start(helper *h, const sl_affine *placement, const char *folder) {
    int ends[2], failed;
    char numbers[4][32], place[PLACEMENT_BYTES];
    snprintf(numbers[0], sizeof numbers[0], "%u", SL_IMPORT_VERSION);
    snprintf(numbers[1], sizeof numbers[1], "%u", h->limits.seconds);
    snprintf(numbers[2], sizeof numbers[2], "%u", h->limits.processor_seconds);
    snprintf(numbers[3], sizeof numbers[3], "%llu", (unsigned long long)h->limits.address_bytes);
    write_placement(placement, place);
    const char *arguments[] = {h->program, numbers[0], numbers[1], numbers[2], numbers[3],
                               h->path,    place,      folder,     NULL};
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
        return sl_fail(h->error, SL_ERROR_RESOURCES,
                       "%s: cannot be read: no line to the importer of mesh files: %s", h->path,
                       strerror(errno));
    failed = spawn(h, ends[1], (char *const *)(void *)arguments);
    close(ends[1]);
    h->line = ends[0];
    if (!failed) return SL_OK;
    close(h->line);
    return sl_fail(h->error, SL_ERROR_RESOURCES,
                   "%s: cannot be read: the program that imports mesh files, %s, cannot be started: %s; "
                   "SOFTLUX_IMPORTER may name another",
                   h->path, h->program, strerror(failed));
}

/* ---- talking ------------------------------------------------------------------------------------------- */

/* Returns how many bytes came before the line ended. */
static size_t receive(const helper *h, void *to, size_t size) {
    size_t got = 0;
    while (got < size) {
        ssize_t more = recv(h->line, (char *)to + got, size - got, 0);
        if (more < 0 && errno == EINTR) continue;
        if (more <= 0) break;
        got += (size_t)more;
    }
    return got;
}

/* ---- the end ------------------------------------------------------------------------------------------- */

/* Tells whether it is known how the process ended: a caller may have its children waited for by others. */
static bool reap(const helper *h, int *how) {
    pid_t ended;
    close(h->line);
    while ((ended = waitpid(h->id, how, 0)) < 0 && errno == EINTR) {}
    return ended == h->id;
}

static sl_status fail_of_end(const helper *h, bool known, int how) {
    const int ended_by = known && WIFSIGNALED(how) ? WTERMSIG(how) : 0;
    char why[120] = "ended without a whole answer";
    if (ended_by == SIGALRM) snprintf(why, sizeof why, "took more than %u seconds", h->limits.seconds);
    else if (ended_by == SIGXCPU)
        snprintf(why, sizeof why, "was ended, as it is after %u seconds of work",
                 h->limits.processor_seconds);
    else if (ended_by == SIGKILL)
        snprintf(why, sizeof why, "was killed, as the system does where memory ends");
    else if (ended_by)
        snprintf(why, sizeof why,
                 "crashed on it or on a file that it names (signal %d), as it does on some damaged ones",
                 ended_by);
    return sl_fail(h->error, ended_by == SIGKILL ? SL_ERROR_RESOURCES : SL_ERROR_INPUT,
                   "%s: cannot be read: the importer of mesh files %s; expected a sound file", h->path, why);
}

/* SL_OK: a whole reply is there. *size: what it says it has. */
static sl_status hear(const helper *h, void **reply, size_t *size, bool *whole) {
    char header[SL_IMPORT_HEADER_BYTES], beyond;
    *whole = false;
    if (receive(h, header, sizeof header) < sizeof header) return SL_OK;
    uint64_t bytes = sl_import_reply_bytes(header);
    if (bytes == 0) return SL_OK;
    *size = (size_t)bytes;
    *reply = sl_allocate_unset(*size, 1);
    if (!*reply)
        return sl_fail(h->error, SL_ERROR_RESOURCES, "%s: not enough memory for the %zu bytes that are in it",
                       h->path, *size);
    memcpy(*reply, header, sizeof header);
    size_t rest = *size - sizeof header;
    *whole = receive(h, (char *)*reply + sizeof header, rest) == rest && receive(h, &beyond, 1) == 0;
    return SL_OK;
}

sl_status sl_import_run(const char *path, const sl_affine *placement, const char *folder,
                        sl_import_limits limits, void **reply, size_t *size, sl_error *error) {
    helper h = {.path = path, .program = program_path(), .limits = limits, .error = error};
    bool whole;
    int how = 0;
    *reply = NULL;
    sl_status status = start(&h, placement, folder);
    if (status != SL_OK) return status;
    shutdown(h.line, SHUT_WR);
    status = hear(&h, reply, size, &whole);
    bool known = reap(&h, &how);
    if (status == SL_OK && whole) return SL_OK;
    sl_free(*reply);
    *reply = NULL;
    return status == SL_OK ? fail_of_end(&h, known, how) : status;
}
