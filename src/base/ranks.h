/* Ranks: processes that compute one picture together. Each runs all of the program, in the same order, but
 * for batches (batch.h), whose items they share out and whose results they give each other. So no method
 * knows of them, and a picture has the same bits with any number of ranks.
 *
 * ranks_alone.c is a process by itself, without MPI; ../mpi/ranks.c those that mpirun starts (make MPI=1). */
#pragma once


#include "base/batch.h"

typedef struct sl_ranks {
    unsigned rank, count; /* rank < count */
} sl_ranks;

sl_ranks sl_ranks_here(void);

/* Tells whether batches are shared out: there are other ranks, or a journal is kept of what they bring. */
bool sl_ranks_share(void);

/* Work begins on the scene of that hash. Returns why it cannot, NULL: it can. */
const char *sl_ranks_begin(uint64_t scene);

/* Of each `ranks` items one behind the other every rank has one. Who begins changes evenly: no column of a
 * picture is one rank's. The turn-th item of a rank, which may be one behind the last. */
static inline size_t sl_ranks_item(sl_ranks at, size_t turn) {
    const size_t begins = (uint64_t)(uint32_t)(turn * 2654435769u) * at.count >> 32; /* the golden ratio's */
    return turn * at.count + (at.rank + begins) % at.count;
}

/* How many of `count` items are a rank's. */
static inline size_t sl_ranks_items(sl_ranks at, size_t count) {
    const size_t rounds = count / at.count;
    return rounds + (sl_ranks_item(at, rounds) < count);
}

/* Gives every rank all items of some planes, and adds up what all have counted. All ranks call it in the same
 * order; a rank whose items are others than the rest's ends the job. Without memory for a copy it ends the
 * job, too: others would wait. */
void sl_ranks_exchange(const sl_batch_plane *planes, unsigned plane_count, size_t count,
                       sl_counters *counted);

/* Fills in the items of all ranks from the journal of a call that ended before it was done, and what they
 * have counted. False: it does not have this batch. */
bool sl_ranks_recall(const sl_batch_plane *planes, unsigned plane_count, size_t count, sl_counters *counted);

/* Gives all ranks the bytes of one of them. */
void sl_ranks_tell(unsigned teller, void *bytes, size_t count);
