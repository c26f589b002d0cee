/* Some work, again and again, with another allocation failing each time: whatever fails, the work comes to an
 * end, says in one line that memory ended (or did without, and gives the same result), loses no memory, and
 * can be done afterwards as if nothing had been. Trials run in children, since what they look for may crash. */
#pragma once

#include "every_allocation.h"

#include <signal.h>
#include <time.h>

#include "softlux.h"

typedef struct fault_outcome {
    sl_status status;
    sl_error error;
    uint64_t hash; /* of all that came out; 0: not told, since it depends on the clock */
} fault_outcome;

typedef struct fault_case {
    const char *name;
    void (*prepare)(const struct fault_case *c); /* once a child, with all memory there is; may be NULL */
    void (*work)(const struct fault_case *c, fault_outcome *o);
    const void *what;
    bool all_threads; /* what they allocate counts, too, though in another order each time */
} fault_case;

enum { TRIALS_A_CHILD = 48, MOST_CRASHES = 12 };

static uint64_t hash_bytes(uint64_t hash, const void *data, size_t bytes) {
    const unsigned char *at = data;
    if (!hash) hash = 0xcbf29ce484222325u;
    for (size_t i = 0; i < bytes; i++) hash = (hash ^ at[i]) * 0x100000001b3u;
    return hash;
}

static uint64_t hash_image(uint64_t hash, const sl_image *image) {
    return hash_bytes(hash, image->planes,
                      (size_t)image->channels * (size_t)image->width * (size_t)image->height * sizeof(float));
}

/* The leak checker of the address sanitizer, where there is one. */
int __lsan_do_recoverable_leak_check(void) __attribute__((weak));
SEEN const char *__lsan_default_suppressions(void), *__lsan_default_options(void);
/* a table of the dynamic loader */
SEEN const char *__lsan_default_suppressions(void) { return "leak:add_to_global_resize\n"; }
SEEN const char *__lsan_default_options(void) { return "print_suppressions=0"; }

/* cmocka catches what kills a program, and goes on; children are to die of it. Called before cmocka is. */
static struct sigaction deaths[5];
static const int deadly[5] = {SIGSEGV, SIGABRT, SIGFPE, SIGILL, SIGBUS};

static void keep_deaths(void) {
    for (int i = 0; i < 5; i++) sigaction(deadly[i], NULL, &deaths[i]);
}

/* ---- in a child ------------------------------------------------------------------------------ */

static void run_once(const fault_case *c, long failing, fault_outcome *o) {
    *o = (fault_outcome){.status = SL_OK};
    open_window(failing);
    c->work(c, o);
    close_window();
}

static void complain(const fault_case *c, long index, const char *what, const char *detail) {
    const fault_path *p = &board->path[index];
    fprintf(stderr, "%s: allocation %ld (path %ld)%s: %s%s%s\n", c->name, p->first, index,
            all_from_there_on ? " and all after it" : "", what, detail && *detail ? ": " : "",
            detail ? detail : "");
    board->faults++;
}

static void try_path(const fault_case *c, long index) {
    fault_outcome o;
    run_once(c, board->path[index].first, &o);
    board->trials++;
    if (o.status == SL_OK) {
        board->absorbed++;
        if (o.hash != board->expected) complain(c, index, "went on with another result", NULL);
        return;
    }
    size_t length = strlen(o.error.message);
    if (o.error.status != o.status) complain(c, index, "the error's status is another", o.error.message);
    if (o.status != SL_ERROR_RESOURCES)
        complain(c, index, "blames something else than memory", o.error.message);
    if (length == 0 || strchr(o.error.message, '\n'))
        complain(c, index, "does not say in one line what is wrong", o.error.message);
}

/* Runs the case with all memory there is. */
static void run_whole(const fault_case *c, long index) {
    fault_outcome o;
    run_once(c, -1, &o);
    if (o.status != SL_OK) complain(c, index, "fails afterwards, with memory", o.error.message);
    else if (o.hash != board->expected) complain(c, index, "another result afterwards, with memory", NULL);
}

static void become_mortal(void) {
    for (int i = 0; i < 5; i++) sigaction(deadly[i], &deaths[i], NULL);
}

static _Noreturn void be_recorder(const fault_case *c) {
    fault_outcome o;
    become_mortal();
    if (c->prepare) c->prepare(c);
    run_once(c, -1, &o); /* what is made once a process, by libraries, is made now */
    atomic_store(&recording, true);
    run_once(c, -1, &o);
    board->allocations = atomic_load(&allocation_number);
    board->expected = o.hash;
    if (o.status != SL_OK)
        fprintf(stderr, "%s: fails with all memory there is: %s\n", c->name, o.error.message);
    _exit(o.status == SL_OK ? 0 : 1);
}

static _Noreturn void be_trier(const fault_case *c, long from, long step) {
    become_mortal();
    if (c->prepare) c->prepare(c);
    run_whole(c, from);
    long i = from;
    for (int done = 0; i < board->path_count && done < TRIALS_A_CHILD; i += step, done++) {
        atomic_store(&board->at, i);
        try_path(c, i);
    }
    run_whole(c, i - step);
    if (__lsan_do_recoverable_leak_check && __lsan_do_recoverable_leak_check())
        complain(c, i - step, "leaks, or one of those before it", NULL);
    atomic_store(&board->at, i);
    _exit(0);
}

/* ---- in the parent, which allocates nothing and has one thread ------------------------------- */

static int wait_for(pid_t child) {
    int how = 0;
    while (waitpid(child, &how, 0) < 0 && errno == EINTR) {}
    return how;
}

/* Processor seconds so far, of all its threads; negative: it is no more. */
static double processor_seconds(pid_t child) {
    clockid_t clock;
    struct timespec t;
    if (clock_getcpuclockid(child, &clock) != 0 || clock_gettime(clock, &t) != 0) return -1.0;
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

typedef enum trial_end { ENDED, TURNS, WAITS } trial_end;

/* However busy a machine is, a child that has something to do gets some of it: one whose processor time
 * stands still waits for what never comes. One that took a minute of it since its last path turns in a
 * circle. Either is killed. */
static trial_end watch(pid_t child, int *how) {
    static const double most_of_a_path = 60.0;
    enum { TICKS_A_SECOND = 100, MOST_STILL = 60 * TICKS_A_SECOND };
    double last = 0.0, at_path = 0.0;
    long path = -1;
    for (int still = 0;; still++) {
        if (waitpid(child, how, WNOHANG) == child) return ENDED;
        const double now = processor_seconds(child);
        if (now != last) last = now, still = 0;
        if (atomic_load(&board->at) != path) path = atomic_load(&board->at), at_path = now;
        const trial_end end = still > MOST_STILL ? WAITS : now - at_path > most_of_a_path ? TURNS : ENDED;
        if (end != ENDED) {
            kill(child, SIGKILL);
            *how = wait_for(child);
            return end;
        }
        nanosleep(&(struct timespec){0, 1000000000 / TICKS_A_SECOND}, NULL);
    }
}

static void tell_death(const fault_case *c, trial_end end, int how) {
    char what[80];
    if (end != ENDED)
        snprintf(what, sizeof what, "does not end: it %s",
                 end == WAITS ? "waits for what does not come" : "takes a minute of processor time");
    else if (WIFSIGNALED(how)) snprintf(what, sizeof what, "crashes with signal %d", WTERMSIG(how));
    else snprintf(what, sizeof what, "ends the process with status %d", WEXITSTATUS(how));
    complain(c, atomic_load(&board->at), what, NULL);
}

/* All paths, or every step-th. */
static void try_paths(const fault_case *c, long step) {
    int crashes = 0;
    for (long from = 0; from < board->path_count && crashes < MOST_CRASHES;) {
        atomic_store(&board->at, from);
        fflush(NULL);
        pid_t child = fork();
        if (child == 0) be_trier(c, from, step);
        int how = 0;
        const trial_end end = watch(child, &how);
        from = atomic_load(&board->at);
        if (end == ENDED && how == 0) continue;
        tell_death(c, end, how);
        crashes++;
        from += step;
    }
}

static bool make_board(void) {
    if (!board) board = mmap(NULL, sizeof *board, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (board == MAP_FAILED) return false;
    memset(board, 0, sizeof *board);
    return true;
}

/* SOFTLUX_EVERY_ALLOCATION=1: all paths are tried, and with all that follow failing as well. Unset: `some`. */
static long how_many_to_try(long some) { return getenv("SOFTLUX_EVERY_ALLOCATION") ? 0 : some; }

/* Returns how many faults there are. most: how many paths are tried; 0: see above. */
static long try_case(const fault_case *c, long most) {
    if (!make_board()) return 1;
    all_threads = c->all_threads;
    fflush(NULL);
    pid_t child = fork();
    if (child == 0) be_recorder(c);
    if (wait_for(child) != 0) return fprintf(stderr, "%s: does not work at all\n", c->name), 1;
    const long count = board->path_count, step = most && count > most ? (count + most - 1) / most : 1;
    for (int all = 0; all < (most ? 1 : 2); all++) {
        all_from_there_on = all;
        try_paths(c, step);
    }
    printf("result %-34s %7ld allocations, %5ld paths; %ld tried, %ld did without, %ld faults\n", c->name,
           board->allocations, count, board->trials, board->absorbed, board->faults);
    return board->faults;
}

/* ---- which cases ----------------------------------------------------------------------------- */

static const char *wanted_name; /* only those whose names hold it; NULL: all */
static bool list_only;

/* A program's arguments: nothing, a part of a name, or --list for "case NAME" a line each. */
static void choose_cases(int argc, char **argv) {
    list_only = argc > 1 && strcmp(argv[1], "--list") == 0;
    wanted_name = argc > 1 && !list_only ? argv[1] : NULL;
}

/* Returns how many faults there are. */
static long try_named(const fault_case *c, long most) {
    if (list_only) printf("case %s\n", c->name);
    return list_only || (wanted_name && !strstr(c->name, wanted_name)) ? 0 : try_case(c, most);
}
