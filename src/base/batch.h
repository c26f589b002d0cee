/* Batches: independent work of one kind. Item i reads the batch's context and its index alone, and writes one
 * result of fixed size; the caller commits results in the order of their indices, so that a picture has the
 * same bits at any number of workers, wherever they work. */
#pragma once


#include "base/counters.h"

/* Computes item `index`. worker chooses scratch memory and nothing else; counters are the worker's own. */
typedef void sl_batch_work(void *context, size_t index, unsigned worker, void *result, sl_counters *counters);

/* Places that items write to beside their results: item i's at i * bytes. */
typedef struct sl_batch_plane {
    void *items;
    size_t bytes;
} sl_batch_plane;

enum { SL_BATCH_PLANES = 24 }; /* at most, beside the results */

typedef struct sl_batch {
    size_t count;
    sl_batch_work *work;
    void *context;
    /* count of them, item i's at i * result_bytes; NULL: items write to places of the context */
    void *results;
    size_t result_bytes;
    /* Items write nothing but their results and to planes (NULL: none), which hold no pointers: ranks share
     * them out (ranks.h). Item i of every batch is the same rank's. */
    bool shared;
    const sl_batch_plane *planes;
    unsigned plane_count;
} sl_batch;

/* Computes all items on up to `threads` workers (>= 1, worker < threads) and adds what they have counted.
 * Without memory for counters of their own all items run on the caller's thread. */
void sl_batch_run(const sl_batch *batch, unsigned threads, sl_counters *counters);

/* Tells whether an item that ranks share out is at work on this thread: others do not do the same. */
bool sl_batch_is_own_work(void);
