#define _GNU_SOURCE /* syscall() */
#include "base/parallel.h"

#include <pthread.h>
#include <stdatomic.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#ifndef SL_THREADS_WITHOUT_OPENMP
#include <omp.h>
#endif

#include "base/batch.h"
#include "base/memory.h"
#include "base/ranks.h"
#include "base/thread.h"

enum { THREADS_MAX = 256 };

unsigned sl_thread_count(unsigned threads) {
    if (threads == 0) {
        long processors = sysconf(_SC_NPROCESSORS_ONLN);
        threads = processors > 0 ? (unsigned)processors : 1;
    }
    return threads > THREADS_MAX ? THREADS_MAX : threads;
}

typedef struct trial {
    pthread_t handle;
    pthread_mutex_t *all_are_there;
    pid_t number; /* the system's */
} trial;

static void *wait_for_the_others(void *argument) {
    trial *t = argument;
    t->number = (pid_t)syscall(SYS_gettid);
    pthread_mutex_lock(t->all_are_there);
    pthread_mutex_unlock(t->all_are_there);
    return NULL;
}

/* A thread that has been joined counts among the user's for a moment still. */
static void wait_until_gone(pid_t thread) {
    enum { PATIENCE = 1000 };
    for (int i = 0; i < PATIENCE && syscall(SYS_tgkill, getpid(), thread, 0) == 0; i++)
        nanosleep(&(struct timespec){0, 20000}, NULL);
}

unsigned sl_threads_to_be_had(unsigned wanted) {
    trial trials[THREADS_MAX];
    pthread_mutex_t all_are_there;
    unsigned started = 0;
    if (pthread_mutex_init(&all_are_there, NULL) != 0) return 0;
    pthread_mutex_lock(&all_are_there);
    for (; started < wanted && started < THREADS_MAX; started++) {
        trials[started].all_are_there = &all_are_there;
        if (pthread_create(&trials[started].handle, NULL, wait_for_the_others, &trials[started]) != 0) break;
    }
    pthread_mutex_unlock(&all_are_there);
    for (unsigned i = 0; i < started; i++) pthread_join(trials[i].handle, NULL);
    for (unsigned i = 0; i < started; i++) wait_until_gone(trials[i].number);
    pthread_mutex_destroy(&all_are_there);
    return started;
}

static void run_alone(size_t count, sl_task *task, void *context) {
    for (size_t i = 0; i < count; i++) task(context, i, 0);
}

/* ---- children of fork() ---------------------------------------------------------------------- */

static atomic_bool forked;

static void note_fork(void) { atomic_store_explicit(&forked, true, memory_order_relaxed); }

/* When the library is loaded, and not at its first loop: the process may have had a team of its own before
 * that. */
__attribute__((constructor)) static void watch_forks(void) { pthread_atfork(NULL, NULL, note_fork); }

/* ---- threads that last for one loop ---------------------------------------------------------- */

typedef struct {
    sl_task *task;
    void *context;
    size_t count;
    atomic_size_t *next;
    unsigned worker;
} loop_worker;

static _Thread_local bool inside_loop;

static void *work(void *argument) {
    loop_worker *w = argument;
    inside_loop = true;
    /* Relaxed: a stronger order would tell the thread sanitizer that a task happens after those handed out
     * before it. */
    for (size_t i; (i = atomic_fetch_add_explicit(w->next, 1, memory_order_relaxed)) < w->count;)
        w->task(w->context, i, w->worker);
    inside_loop = false;
    return NULL;
}

static void run_on_own_threads(unsigned threads, size_t count, sl_task *task, void *context) {
    atomic_size_t next = 0;
    loop_worker workers[THREADS_MAX];
    pthread_t handles[THREADS_MAX];
    unsigned started = 1;
    for (unsigned i = 0; i < threads; i++) workers[i] = (loop_worker){task, context, count, &next, i};
    while (started < threads && pthread_create(&handles[started], NULL, work, &workers[started]) == 0)
        started++;
    work(&workers[0]);
    for (unsigned i = 1; i < started; i++) pthread_join(handles[i], NULL);
}

/* ---- the loop -------------------------------------------------------------------------------- */

#ifndef SL_THREADS_WITHOUT_OPENMP

static bool was_forked(void) { return atomic_load_explicit(&forked, memory_order_relaxed); }

/* Once a thread was refused, now or in another loop. */
static atomic_bool threads_are_scarce;

/* The runtime ends the process where it cannot start a thread, so a team that is larger than the last one,
 * whose threads alone the runtime still has, is tried first. It has a team for each thread that begins one.
 */
static bool can_have_team(unsigned threads) {
    static _Thread_local unsigned team = 1;
    if (threads > team && sl_threads_to_be_had(threads - team) < threads - team)
        atomic_store(&threads_are_scarce, true);
    if (atomic_load(&threads_are_scarce)) return false;
    team = threads;
    return true;
}

static bool inside_another(void) { return inside_loop || omp_in_parallel(); }

static void run_on_threads(unsigned threads, size_t count, sl_task *task, void *context) {
    /* In a child of fork() the runtime would wait for threads that only the parent has. */
    if (was_forked() || !can_have_team(threads)) {
        run_on_own_threads(threads, count, task, context);
        return;
    }
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads)
    for (size_t i = 0; i < count; i++) task(context, i, (unsigned)omp_get_thread_num());
}

#else

/* The thread sanitizer does not understand the OpenMP runtime's barriers, but it does understand POSIX
 * threads. */
static bool inside_another(void) { return inside_loop; }

static void run_on_threads(unsigned threads, size_t count, sl_task *task, void *context) {
    run_on_own_threads(threads, count, task, context);
}

#endif

void sl_parallel_for(unsigned threads, size_t count, sl_task *task, void *context) {
    if (threads > count) threads = (unsigned)count;
    if (threads <= 1 || inside_another()) run_alone(count, task, context);
    else run_on_threads(threads, count, task, context);
}

/* ---- batches --------------------------------------------------------------------------------- */

typedef struct {
    const sl_batch *batch;
    sl_counters *counters; /* by worker */
    sl_ranks at;           /* whose items they are */
} batch_run;

static void run_item(void *context, size_t turn, unsigned worker) {
    const batch_run *run = context;
    const sl_batch *batch = run->batch;
    const size_t index = sl_ranks_item(run->at, turn);
    void *result = batch->results ? (char *)batch->results + index * batch->result_bytes : NULL;
    batch->work(batch->context, index, worker, result, &run->counters[worker]);
}

/* Counters are whole numbers: their sum does not depend on the order. */
static void run_share(const sl_batch *batch, sl_ranks here, unsigned threads, sl_counters *counters) {
    const size_t count = sl_ranks_items(here, batch->count);
    unsigned workers = count < threads ? (unsigned)count : threads;
    sl_counters *by_worker = workers > 1 ? sl_allocate(workers, sizeof *by_worker) : NULL;
    batch_run run = {batch, by_worker ? by_worker : counters, here};
    sl_parallel_for(by_worker ? workers : 1, count, run_item, &run);
    for (unsigned w = 0; by_worker && w < workers; w++) sl_counters_add(counters, &by_worker[w]);
    sl_free(by_worker);
}

/* An item of a batch that is shared out is one rank's, with all that it takes. */
static _Thread_local bool inside_shared;

bool sl_batch_is_own_work(void) { return inside_shared; }

/* Loops within loops are not in the same order on all ranks. */
static bool is_shared(const sl_batch *batch) {
    return sl_ranks_share() && batch->shared && !inside_shared && !inside_another();
}

void sl_batch_run(const sl_batch *batch, unsigned threads, sl_counters *counters) {
    if (!is_shared(batch)) {
        run_share(batch, (sl_ranks){0, 1}, threads, counters);
        return;
    }
    sl_counters counted = {{0}};
    sl_batch_plane planes[1 + SL_BATCH_PLANES] = {{batch->results, batch->result_bytes}};
    for (unsigned k = 0; k < batch->plane_count; k++) planes[1 + k] = batch->planes[k];
    if (!sl_ranks_recall(planes, 1 + batch->plane_count, batch->count, &counted)) {
        inside_shared = true;
        run_share(batch, sl_ranks_here(), threads, &counted);
        inside_shared = false;
        sl_ranks_exchange(planes, 1 + batch->plane_count, batch->count, &counted);
    }
    sl_counters_add(counters, &counted);
}

/* ---- a thread beside the caller's ------------------------------------------------------------ */

bool sl_monitor_open(sl_monitor *m) {
    if (pthread_mutex_init(&m->lock, NULL) != 0) return false;
    if (pthread_cond_init(&m->changed, NULL) == 0) return true;
    pthread_mutex_destroy(&m->lock);
    return false;
}

/* By the calendar's clock, which may jump: who waits looks again whether it is time. */
void sl_monitor_wait_for(sl_monitor *m, double seconds) {
    struct timespec until;
    clock_gettime(CLOCK_REALTIME, &until);
    const long more = until.tv_nsec + (long)(1e9 * (seconds < 1.0 ? seconds : 1.0));
    until.tv_sec += more / 1000000000;
    until.tv_nsec = more % 1000000000;
    pthread_cond_timedwait(&m->changed, &m->lock, &until);
}

void sl_monitor_close(sl_monitor *m) {
    pthread_cond_destroy(&m->changed);
    pthread_mutex_destroy(&m->lock);
}

static void *run(void *argument) {
    const sl_thread *thread = argument;
    thread->run(thread->context);
    return NULL;
}

bool sl_thread_start(sl_thread *thread, void (*run_this)(void *context), void *context) {
    thread->run = run_this;
    thread->context = context;
    return pthread_create(&thread->handle, NULL, run, thread) == 0;
}

void sl_thread_join(sl_thread *thread) { pthread_join(thread->handle, NULL); }
