/* Feeds bench/ranks.py: SOFTLUX_BATCHES=FILE has a rank of one thread write a line for each batch that ranks
 * share out to FILE and its number, what it has spent outside of exchanges. The linker puts this before the
 * library's sl_batch_run() (packaging/mpi.mk). */
#define _GNU_SOURCE /* clocks */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "base/batch.h"
#include "base/ranks.h"

void __real_sl_batch_run(const sl_batch *batch, unsigned threads, sl_counters *counters);
void __wrap_sl_batch_run(const sl_batch *batch, unsigned threads, sl_counters *counters);

static struct {
    FILE *file;
    double until; /* so far all is written */
    bool asked;   /* whether there is one */
    bool inside;  /* a batch that is timed */
} batches;

/* Of this thread: others' work beside it does not count. */
static double seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

typedef struct timed {
    const sl_batch *batch;
    double *item;
} timed;

static void time_item(void *context, size_t index, unsigned worker, void *result, sl_counters *counters) {
    const timed *t = context;
    const double begin = seconds();
    t->batch->work(t->batch->context, index, worker, result, counters);
    t->item[index] = seconds() - begin;
}

/* The rank with most work of so many. */
static double most_of(const timed *t, unsigned ranks) {
    double most = 0.0;
    for (sl_ranks at = {0, ranks}; at.rank < ranks; at.rank++) {
        double sum = 0.0;
        const size_t items = sl_ranks_items(at, t->batch->count);
        for (size_t turn = 0; turn < items; turn++) sum += t->item[sl_ranks_item(at, turn)];
        most = sum > most ? sum : most;
    }
    return most;
}

/* Writes serial seconds before; items, bytes of one; seconds of all items that are computed here, and of
 * those of the slowest of 2, 4 .. 64 ranks. */
static void write_line(double serial, const timed *t) {
    size_t bytes = t->batch->result_bytes;
    for (unsigned k = 0; k < t->batch->plane_count; k++) bytes += t->batch->planes[k].bytes;
    fprintf(batches.file, "%.9f %zu %zu", serial, t->batch->count, bytes);
    for (unsigned ranks = 1; ranks <= 64; ranks *= 2) fprintf(batches.file, " %.9f", most_of(t, ranks));
    fputc('\n', batches.file);
}

static void close_log(void) {
    write_line(seconds() - batches.until, &(timed){&(sl_batch){0}, NULL});
    fclose(batches.file);
}

static void open_log(void) {
    char name[1024];
    const char *begin = getenv("SOFTLUX_BATCHES");
    batches.asked = true;
    if (!begin) return;
    snprintf(name, sizeof name, "%s.%u", begin, sl_ranks_here().rank);
    batches.file = fopen(name, "w");
    if (batches.file) atexit(close_log);
}

bool __real_sl_ranks_share(void);
bool __wrap_sl_ranks_share(void);

/* As many ranks would. */
bool __wrap_sl_ranks_share(void) { return batches.file || __real_sl_ranks_share(); }

void __wrap_sl_batch_run(const sl_batch *batch, unsigned threads, sl_counters *counters) {
    if (!batches.asked) open_log();
    const bool wanted = batches.file && batch->shared && !batches.inside;
    timed t = {batch, wanted ? calloc(batch->count + 1, sizeof *t.item) : NULL};
    if (!t.item) {
        __real_sl_batch_run(batch, threads, counters);
        return;
    }
    sl_batch log = *batch;
    log.work = time_item;
    log.context = &t;
    const double serial = seconds() - batches.until;
    batches.inside = true;
    __real_sl_batch_run(&log, 1, counters);
    batches.inside = false;
    write_line(serial, &t);
    free(t.item);
    batches.until = seconds();
}
