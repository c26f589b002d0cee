/* Parallel loops. A task's result may depend on its index and never on the worker, which only chooses scratch
 * memory; so results are the same at any number of threads. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

typedef void sl_task(void *context, size_t index, unsigned worker);

/* Runs task(context, i, worker) for every i < count on up to `threads` workers (>= 1), worker < threads.
 * Tasks are handed out one by one in index order. Returns when all are done. Calls from inside a task run on
 * that worker alone (worker 0). */
void sl_parallel_for(unsigned threads, size_t count, sl_task *task, void *context);
/* Returns how many threads beside the caller's, of `wanted`, the system would start now: it has been made to,
 * and they have ended again. */
unsigned sl_threads_to_be_had(unsigned wanted);
/* threads, or the number of processors where threads is 0; at least 1, at most 256. */
unsigned sl_thread_count(unsigned threads);
