/* Killed at any moment: before whichever call that changes files a command ends, or half way through a write,
 * each of its files is there whole, or is as it was, or is not there, and the next run gives what one gives
 * that was never killed. The same where the system refuses the call (a disk that is full or breaks), which
 * the command then says in one line. The short form tries some of these moments; with SOFTLUX_EVERY_MOMENT=1
 * every one (tests/hard/killed.sh). */
#define _GNU_SOURCE

#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "unit_test.h"
#include "app/commands.h"
#include "base/values.h"
#include "command.h"
#include "scene_files.h"

/* ---- moments --------------------------------------------------------------------------------- */

typedef enum end { RUNS_TO_ITS_END, KILLED, KILLED_HALF_WAY, REFUSED, ENDS } end;

/* Parent and child share it. */
enum { MOMENTS = 4096 };
static struct {
    atomic_long moments;
    bool tears[MOMENTS]; /* writes */
    atomic_bool came; /* the moment that was to be the last */
    char call[16];    /* what was to be called then */
} *board;

static struct {
    pid_t program; /* whose calls count: not those of what it starts */
    end how;
    long last;     /* moment */
} plan;

/* Tells whether this call is the last; it does not return then, unless it is to be torn or refused. */
static bool is_last(const char *call, bool tears) {
    if (getpid() != plan.program) return false;
    long moment = atomic_fetch_add(&board->moments, 1);
    if (plan.how == RUNS_TO_ITS_END && moment < MOMENTS) board->tears[moment] = tears;
    if (plan.how == RUNS_TO_ITS_END || moment != plan.last) return false;
    snprintf(board->call, sizeof board->call, "%s", call);
    atomic_store(&board->came, true);
    if (plan.how == REFUSED || (plan.how == KILLED_HALF_WAY && tears)) return true;
    kill(getpid(), SIGKILL);
    return false;
}

#define REAL(type, name)                                     \
    static type *real;                                       \
    if (!real) *(void **)&real = dlsym(RTLD_NEXT, name)

typedef int opener(const char *path, int flags, ...);
typedef ssize_t writer(int descriptor, const void *data, size_t bytes);
typedef ssize_t writer_at(int descriptor, const void *data, size_t bytes, off_t offset);
typedef int of_descriptor(int descriptor);
typedef int renamer(const char *from, const char *to);
typedef int folder_maker(const char *path, mode_t mode);

static bool is_file(int descriptor) {
    struct stat s;
    return descriptor > 2 && fstat(descriptor, &s) == 0 && S_ISREG(s.st_mode);
}

int open(const char *path, int flags, ...) {
    REAL(opener, "open");
    mode_t mode = 0;
    if (flags & O_CREAT) {
        va_list rest;
        va_start(rest, flags);
        mode = va_arg(rest, mode_t);
        va_end(rest);
    }
    if ((flags & O_ACCMODE) != O_RDONLY && is_last("open", false)) return errno = EIO, -1;
    return real(path, flags, mode);
}

ssize_t write(int descriptor, const void *data, size_t bytes) {
    REAL(writer, "write");
    if (!is_file(descriptor) || !is_last("write", true)) return real(descriptor, data, bytes);
    if (plan.how == REFUSED) return errno = ENOSPC, -1;
    if (real(descriptor, data, bytes / 2) >= 0) kill(getpid(), SIGKILL);
    return -1;
}

ssize_t pwrite(int descriptor, const void *data, size_t bytes, off_t offset) {
    REAL(writer_at, "pwrite");
    if (!is_last("pwrite", true)) return real(descriptor, data, bytes, offset);
    if (plan.how == REFUSED) return errno = ENOSPC, -1;
    if (real(descriptor, data, bytes / 2, offset) >= 0) kill(getpid(), SIGKILL);
    return -1;
}

int fsync(int descriptor) {
    REAL(of_descriptor, "fsync");
    return is_last("fsync", false) ? errno = EIO, -1 : real(descriptor);
}

/* Tells whether anything can be lost: not of a file that was made to see whether one can be made. */
static bool holds_bytes(int descriptor) {
    struct stat s;
    return is_file(descriptor) && fstat(descriptor, &s) == 0 && s.st_size > 0;
}

/* A refused file has been closed: nobody may try again. */
int close(int descriptor) {
    REAL(of_descriptor, "close");
    bool refused = holds_bytes(descriptor) && (fcntl(descriptor, F_GETFL) & O_ACCMODE) != O_RDONLY &&
                   is_last("close", false);
    int result = real(descriptor);
    return refused ? errno = EDQUOT, -1 : result;
}

int rename(const char *from, const char *to) {
    REAL(renamer, "rename");
    return is_last("rename", false) ? errno = EIO, -1 : real(from, to);
}

int mkdir(const char *path, mode_t mode) {
    REAL(folder_maker, "mkdir");
    return is_last("mkdir", false) ? errno = EIO, -1 : real(path, mode);
}

/* ---- commands -------------------------------------------------------------------------------- */

typedef struct work {
    const char *name;
    command *command;
    const char *line; /* a %/ stands for the folder */
} work;

static const work works[] = {
    {"render, EXR", sl_command_render,
     "scenes/cornell.json -m path --spp 1 -s 8x8 -t 1 --quiet -o %/a.exr"},
    {"render, frames", sl_command_render,
     "scenes/moving-light.json -m path --spp 1 -s 8x8 -t 1 --frames 2 --fps 1 --quiet -o %/a%d.pfm"},
    {"render, a cache", sl_command_render,
     "scenes/cornell.json -q draft -s 8x8 -t 1 --save-cache %/a.cache --quiet -o %/a.pfm"},
    {"steps", sl_command_steps,
     "scenes/cornell.json -m direct-radiance -q draft -s 8x8 -t 1 --reference-spp 1 --quiet -o %/page"},
};
enum { WORKS = sizeof works / sizeof works[0] };

static char said[64];

static const work *current;

static int be_the_program(int argc, char **argv) {
    plan.program = getpid();
    return current->command(argc, argv);
}

/* Runs a command in a process of its own; returns how that ended. */
static int run(const work *w, const char *folder, end how, long last) {
    int ended = 0;
    atomic_store(&board->moments, 0);
    atomic_store(&board->came, false);
    plan.how = how;
    plan.last = last;
    current = w;
    pid_t child = command_start(be_the_program, w->line, folder, NULL, how == REFUSED ? said : NULL);
    assert_true(child > 0 && waitpid(child, &ended, 0) == child);
    return ended;
}

/* ---- files ----------------------------------------------------------------------------------- */

enum { FILES = 32, NAME = 200 };
typedef struct listing {
    char name[FILES][NAME]; /* below the folder */
    size_t count;
} listing;

static void list_below(const char *folder, const char *below, listing *l) {
    char path[512];
    snprintf(path, sizeof path, "%s/%s", folder, below);
    DIR *d = opendir(path);
    if (!d) return;
    for (struct dirent *e; (e = readdir(d));) {
        char name[NAME];
        struct stat s;
        if (e->d_name[0] == '.') continue;
        assert_true((size_t)snprintf(name, sizeof name, "%s%s%s", below, *below ? "/" : "", e->d_name) <
                    sizeof name);
        snprintf(path, sizeof path, "%s/%s", folder, name);
        assert_int_equal(stat(path, &s), 0);
        if (S_ISDIR(s.st_mode)) {
            list_below(folder, name, l);
        } else {
            assert_true(l->count < FILES);
            strcpy(l->name[l->count++], name);
        }
    }
    closedir(d);
}

static listing files_of(const char *folder) {
    listing l = {.count = 0};
    list_below(folder, "", &l);
    return l;
}

static bool is_listed(const listing *l, const char *name) {
    for (size_t i = 0; i < l->count; i++) {
        if (strcmp(l->name[i], name) == 0) return true;
    }
    return false;
}

static void remove_folder(const char *folder) {
    char line[300];
    snprintf(line, sizeof line, "rm -rf '%s'", folder);
    assert_int_equal(system(line), 0);
}

typedef struct bytes {
    char *at; /* a zero behind them; NULL: no file */
    size_t size;
} bytes;

static bytes read_all(const char *folder, const char *name) {
    char path[512];
    bytes b = {0};
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *in = fopen(path, "rb");
    if (!in) return b;
    const size_t room = 1 << 20;
    b.at = malloc(room + 1);
    assert_non_null(b.at);
    b.size = fread(b.at, 1, room, in);
    assert_true(b.size < room);
    b.at[b.size] = '\0';
    fclose(in);
    return b;
}

/* ---- whether they are whole ------------------------------------------------------------------ */

static const char old_text[] = "what was there before";

static bool is_whole(const char *folder, const char *model, const char *name) {
    bytes b = read_all(folder, name), whole = read_all(model, name);
    bool same = b.at && whole.at && b.size == whole.size && memcmp(b.at, whole.at, b.size) == 0;
    free(b.at);
    free(whole.at);
    return same;
}

static bool is_old(const char *folder, const char *name) {
    bytes b = read_all(folder, name);
    bool old = b.at && strcmp(b.at, old_text) == 0;
    free(b.at);
    return old;
}

static void put_old_files(const char *folder, const listing *whole) {
    for (size_t i = 0; i < whole->count; i++) {
        char path[512];
        const char *name = whole->name[i], *slash = strchr(name, '/');
        if (slash)
            snprintf(path, sizeof path, "%s/%.*s", folder, (int)(slash - name), name), mkdir(path, 0777);
        snprintf(path, sizeof path, "%s/%s", folder, name);
        FILE *out = fopen(path, "w");
        assert_non_null(out);
        assert_true(fputs(old_text, out) >= 0 && fclose(out) == 0);
    }
}

/* ---- a trial --------------------------------------------------------------------------------- */

typedef struct trial {
    const work *w;
    const char *model; /* the folder of a run that was never killed */
    listing whole;     /* its files */
    end how;
    long last;
    bool over_old;
} trial;

static void explain(const trial *t, const char *what, const char *name) {
    fail_msg("%s, ended before its file call %ld (%s)%s%s%s: %s%s", t->w->name, t->last, board->call,
             t->how == KILLED_HALF_WAY ? ", half way" : "",
             t->how == REFUSED ? ", which was refused" : "",
             t->over_old ? ", over old files" : "", name, what);
}

/* Parts alone may be left, and only by a command that was killed. */
static void look_after_the_end(const trial *t, const char *folder) {
    listing found = files_of(folder);
    for (size_t i = 0; i < found.count; i++) {
        const char *name = found.name[i];
        if (sl_ends_with(name, ".part")) {
            if (t->how == REFUSED) explain(t, " is left", name);
        } else if (!is_listed(&t->whole, name)) {
            explain(t, " is no file of this command", name);
        } else if (!is_whole(folder, t->model, name) && !(t->over_old && is_old(folder, name))) {
            explain(t, " is neither whole nor as it was", name);
        }
    }
    for (size_t i = 0; t->over_old && i < t->whole.count; i++) {
        if (!is_listed(&found, t->whole.name[i]))
            explain(t, " was there before and is not now", t->whole.name[i]);
    }
}

static void look_after_the_next_run(const trial *t, const char *folder) {
    listing found = files_of(folder);
    for (size_t i = 0; i < t->whole.count; i++) {
        if (!is_whole(folder, t->model, t->whole.name[i]))
            explain(t, " is not what it should be after the next run", t->whole.name[i]);
    }
    for (size_t i = 0; i < found.count; i++) {
        if (!sl_ends_with(found.name[i], ".part") && !is_listed(&t->whole, found.name[i]))
            explain(t, " is no file of this command, after the next run", found.name[i]);
    }
}

/* A call that was refused fails the command, in one line. */
static void look_at_what_was_said(const trial *t, int ended) {
    bytes b = read_all(scene_file_path(""), "said");
    assert_non_null(b.at);
    if (!WIFEXITED(ended)) explain(t, "it crashed", "");
    if (WEXITSTATUS(ended) == 0) explain(t, "nobody minds", "");
    if (strncmp(b.at, "softlux: ", 9) != 0 || strchr(b.at, '\n') != b.at + b.size - 1)
        explain(t, b.at, "what it says is not one line: ");
    free(b.at);
}

static void try_it(const trial *t) {
    char folder[64];
    snprintf(folder, sizeof folder, "%s", scene_file_path("trial"));
    assert_int_equal(mkdir(folder, 0777), 0);
    if (t->over_old) put_old_files(folder, &t->whole);
    int ended = run(t->w, folder, t->how, t->last);
    if (atomic_load(&board->came) && t->how == REFUSED) {
        look_at_what_was_said(t, ended);
    } else if (atomic_load(&board->came)) {
        if (!WIFSIGNALED(ended) || WTERMSIG(ended) != SIGKILL) explain(t, "it did not end there", "");
    } else {
        explain(t, "it never came there", "");
    }
    look_after_the_end(t, folder);
    ended = run(t->w, folder, RUNS_TO_ITS_END, -1);
    if (ended != 0) explain(t, "the next run fails", "");
    look_after_the_next_run(t, folder);
    remove_folder(folder);
}

static long most; /* moments tried of a command; 0: all */

enum { WAYS = ENDS - KILLED };

/* All ways to end at all moments; or some moments, each in one way. */
static long try_moments(trial *t, long moments, const bool *writes) {
    long tried = 0, step = most && moments > most ? (moments + most - 1) / most : 1;
    for (long k = 0; k < moments * (most ? 1 : 2 * WAYS); k++) {
        unsigned variant = most ? (unsigned)(k / step + (long)(t->w - works)) : (unsigned)(k / moments);
        if (most && k % step) continue;
        t->last = k % moments;
        t->how = (end)(KILLED + variant % WAYS);
        if (!most && t->how == KILLED_HALF_WAY && !writes[t->last]) continue;
        t->over_old = variant / WAYS % 2 == 0;
        try_it(t);
        tried++;
    }
    return tried;
}

static void try_work(const work *w) {
    char model[64];
    trial t = {.w = w, .model = model};
    snprintf(model, sizeof model, "%s", scene_file_path("model"));
    assert_int_equal(mkdir(model, 0777), 0);
    assert_int_equal(run(w, model, RUNS_TO_ITS_END, -1), 0);
    long moments = atomic_load(&board->moments);
    bool writes[MOMENTS];
    t.whole = files_of(model);
    assert_true(moments >= 4 && moments <= MOMENTS && t.whole.count >= 1);
    memcpy(writes, board->tears, sizeof writes); /* every run notes its own */
    long tried = try_moments(&t, moments, writes);
    if (!most)
        printf("result %-16s %4ld file calls, %4ld ends tried\n", w->name, moments, tried), fflush(stdout);
    remove_folder(model);
}

static void killed_programs_leave_whole_files_or_none_and_run_again(void **state) {
    for (int i = 0; i < WORKS; i++) try_work(&works[i]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(killed_programs_leave_whole_files_or_none_and_run_again),
    };
    most = getenv("SOFTLUX_EVERY_MOMENT") ? 0 : 5;
    board = mmap(NULL, sizeof *board, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (board == MAP_FAILED) return 1;
    snprintf(said, sizeof said, "%s", scene_file_path("said"));
    return cmocka_run_group_tests(tests, NULL, scene_files_teardown);
}
