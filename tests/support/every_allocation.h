/* A test program that includes this has the allocators of the whole process in its hands. While a window is
 * open allocations are counted, and one that was chosen fails (or all of ours from there on: what libraries
 * ask for they get). A first run of some piece of work tells which of our call paths allocate, and each path's
 * first allocation is then made to fail, in children, which may crash. */
#pragma once

#ifndef _GNU_SOURCE
#error "tests/support/every_allocation.h needs _GNU_SOURCE"
#endif
#include <dlfcn.h>
#include <errno.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>
#include <unwind.h>

/* ---- the window ------------------------------------------------------------------------------ */

enum { FAULT_FRAMES = 20, FAULT_SLOTS = 1 << 16, FAULT_PATHS = FAULT_SLOTS / 2 };

/* A call path of ours that allocates, and which allocation was its first. */
typedef struct fault_path {
    uint64_t hash;
    long first;
} fault_path;

/* Shared by parent and children. */
typedef struct fault_board {
    long allocations, path_count;
    fault_path path[FAULT_PATHS];
    uint64_t path_slot[FAULT_SLOTS]; /* a set of hashes */
    uint64_t expected; /* what comes out where nothing fails */
    atomic_long at;    /* the path under trial */
    long trials, absorbed, faults;
} fault_board;

static fault_board *board;
static atomic_bool window_open, recording;
static atomic_long allocation_number;
static long failing_number = -1;
static bool all_from_there_on;
/* or only what the window's own thread allocates: that comes in the same order each time */
static bool all_threads;
static _Thread_local bool opened_window;
static _Thread_local int inside; /* of the machinery below, or of an allocator that calls another */

static void open_window(long failing) {
    failing_number = failing;
    opened_window = true;
    atomic_store(&allocation_number, 0);
    atomic_store(&window_open, true);
}

static long close_window(void) {
    atomic_store(&window_open, false);
    return atomic_load(&allocation_number);
}

/* ---- who asks -------------------------------------------------------------------------------- */

/* The frames from the allocator's caller on. */
typedef struct fault_stack {
    uintptr_t at[FAULT_FRAMES], caller;
    int count;
} fault_stack;

static _Unwind_Reason_Code note_frame(struct _Unwind_Context *context, void *argument) {
    fault_stack *s = argument;
    uintptr_t at = _Unwind_GetIP(context);
    if (s->count > 0 || at == s->caller) s->at[s->count++] = at;
    return s->count < FAULT_FRAMES ? _URC_NO_REASON : _URC_END_OF_STACK;
}

static uint64_t hash_of(const uintptr_t *at, int count) {
    uint64_t hash = 0xcbf29ce484222325u;
    for (int i = 0; i < count; i++) hash = (hash ^ at[i]) * 0x100000001b3u;
    return hash ? hash : 1;
}

static const char *module_of(uintptr_t at) {
    Dl_info info;
    if (!dladdr((void *)at, &info) || !info.dli_fname) return "";
    const char *slash = strrchr(info.dli_fname, '/');
    return slash ? slash + 1 : info.dli_fname;
}

/* Tells whether the first frame that is not of the languages' own libraries, which allocate for others, is
 * ours. Some are nobody's, as where sanitizers start threads. */
static bool is_ours(const fault_stack *s) {
    for (int i = 0; i < s->count; i++) {
        const char *module = module_of(s->at[i]);
        if (module[0] && strncmp(module, "libc.", 5) && strncmp(module, "libstdc++", 9) &&
            strncmp(module, "libasan", 7))
            return strncmp(module, "lib", 3) != 0;
    }
    return false;
}

/* False where the hash is in the set already. */
static bool is_new(uint64_t *slot, uint64_t hash) {
    size_t i = hash % FAULT_SLOTS;
    while (slot[i] && slot[i] != hash) i = (i + 1) % FAULT_SLOTS;
    if (slot[i]) return false;
    slot[i] = hash;
    return true;
}

static fault_stack stack_of(void *caller) {
    fault_stack s = {.caller = (uintptr_t)caller};
    _Unwind_Backtrace(note_frame, &s);
    if (s.count == 0) s.at[s.count++] = s.caller;
    return s;
}

static void note_path(long number, void *caller) {
    static atomic_flag lock = ATOMIC_FLAG_INIT;
    fault_stack s = stack_of(caller);
    uint64_t hash = hash_of(s.at, s.count);
    while (atomic_flag_test_and_set(&lock)) {}
    if (board->path_count < FAULT_PATHS && is_new(board->path_slot, hash) && is_ours(&s))
        board->path[board->path_count++] = (fault_path){.hash = hash, .first = number};
    atomic_flag_clear(&lock);
}

/* Tells whether this allocation is to fail. */
static __attribute__((no_sanitize("address", "undefined"))) bool is_refused(void *caller) {
    if (inside || !atomic_load(&window_open) || !(all_threads || opened_window)) return false;
    long number = atomic_fetch_add(&allocation_number, 1);
    inside++;
    if (atomic_load(&recording)) note_path(number, caller);
    bool refused =
        failing_number >= 0 && (number == failing_number || (all_from_there_on && number > failing_number));
    if (refused) {
        const fault_stack s = stack_of(caller);
        refused = is_ours(&s);
    }
    inside--;
    return refused;
}

/* ---- the allocators -------------------------------------------------------------------------- */

#define NEXT_ONE(type, name)                                  \
    static type *real;                                        \
    if (!real) *(void **)&real = dlsym(RTLD_NEXT, name)

typedef void *one_size(size_t size);
typedef void *two_sizes(size_t a, size_t b);
typedef void *block_and_size(void *block, size_t size);
typedef int into(void **block, size_t alignment, size_t size);
typedef char *copier(const char *text);

/* By libraries, too; called before the sanitizers are there. */
#define SEEN __attribute__((visibility("default"), no_sanitize("address", "undefined")))
#define REFUSE(result)      \
    if (is_refused(__builtin_return_address(0))) {     \
        errno = ENOMEM;     \
        return (result);    \
    }
#define PASS_ON(type, call)     \
    inside++;                   \
    type passed = (call);       \
    inside--;                   \
    return passed

SEEN void *malloc(size_t size) {
    NEXT_ONE(one_size, "malloc");
    REFUSE(NULL)
    PASS_ON(void *, real(size));
}

SEEN void *calloc(size_t count, size_t size) {
    NEXT_ONE(two_sizes, "calloc");
    REFUSE(NULL)
    PASS_ON(void *, real(count, size));
}

SEEN void *realloc(void *block, size_t size) {
    NEXT_ONE(block_and_size, "realloc");
    REFUSE(NULL)
    PASS_ON(void *, real(block, size));
}

SEEN void *aligned_alloc(size_t alignment, size_t size) {
    NEXT_ONE(two_sizes, "aligned_alloc");
    REFUSE(NULL)
    PASS_ON(void *, real(alignment, size));
}

void *memalign(size_t alignment, size_t size);
SEEN void *memalign(size_t alignment, size_t size) {
    NEXT_ONE(two_sizes, "memalign");
    REFUSE(NULL)
    PASS_ON(void *, real(alignment, size));
}

SEEN int posix_memalign(void **block, size_t alignment, size_t size) {
    NEXT_ONE(into, "posix_memalign");
    if (is_refused(__builtin_return_address(0))) return ENOMEM;
    PASS_ON(int, real(block, alignment, size));
}

SEEN char *strdup(const char *text) { /* that of the address sanitizer does not go by malloc() */
    NEXT_ONE(copier, "strdup");
    REFUSE(NULL)
    PASS_ON(char *, real(text));
}

/* Has the allocators found while no library is at work: dlerror() allocates, and to be looking for an allocator
 * in its midst would free what it is writing. */
__attribute__((constructor)) static void find_allocators(void) {
    void *volatile block = realloc(malloc(1), 2);
    free(block);
    block = calloc(1, 1);
    free(block);
    block = strdup("");
    free(block);
    block = aligned_alloc(16, 16);
    free(block);
    block = memalign(16, 16);
    free(block);
    void *aligned = NULL;
    if (posix_memalign(&aligned, 16, 16) == 0) free(aligned);
}

/* C++: throws where there is none. */
void *operator_new(size_t size) __asm__("_Znwm");
void *operator_new_array(size_t size) __asm__("_Znam");

static inline __attribute__((always_inline, no_sanitize("address", "undefined"))) void *new_or_throw(
    one_size *real, size_t size) {
    static void (*throw_bad_alloc)(void);
    if (!throw_bad_alloc) *(void **)&throw_bad_alloc = dlsym(RTLD_DEFAULT, "_ZSt17__throw_bad_allocv");
    if (is_refused(__builtin_return_address(0))) throw_bad_alloc();
    PASS_ON(void *, real(size));
}

SEEN void *operator_new(size_t size) {
    NEXT_ONE(one_size, "_Znwm");
    return new_or_throw(real, size);
}

SEEN void *operator_new_array(size_t size) {
    NEXT_ONE(one_size, "_Znam");
    return new_or_throw(real, size);
}
