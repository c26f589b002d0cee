#include "base/batch.h"

#include "base/memory.h"
#include "base/parallel.h"

typedef struct {
    const sl_batch *batch;
    sl_counters *counters; /* by worker */
} batch_run;

static void run_item(void *context, size_t index, unsigned worker) {
    const batch_run *run = context;
    const sl_batch *batch = run->batch;
    void *result = batch->results ? (char *)batch->results + index * batch->result_bytes : NULL;
    batch->work(batch->context, index, worker, result, &run->counters[worker]);
}

/* Counters are whole numbers: their sum does not depend on the order. */
void sl_batch_run(const sl_batch *batch, unsigned threads, sl_counters *counters) {
    unsigned workers = batch->count < threads ? (unsigned)batch->count : threads;
    sl_counters *by_worker = workers > 1 ? sl_allocate(workers, sizeof *by_worker) : NULL;
    batch_run run = {batch, by_worker ? by_worker : counters};
    sl_parallel_for(by_worker ? workers : 1, batch->count, run_item, &run);
    for (unsigned w = 0; by_worker && w < workers; w++) sl_counters_add(counters, &by_worker[w]);
    sl_free(by_worker);
}
