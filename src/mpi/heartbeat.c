#include <mpi.h>
#include <stdatomic.h>
#include <time.h>

#include "base/ranks.h"
#include "base/thread.h"
#include "mpi/end.h"

/* Time is counted in ticks of the thread itself: who has been stopped does not think that others were. */
enum { TICK_MS = 20, BEAT_TICKS = 1000 / TICK_MS, PATIENCE_TICKS = 8000 / TICK_MS };

static struct {
    MPI_Comm ring;
    sl_thread thread;
    bool runs;
    atomic_bool over;
} heart;

/* The last beat is a 1. */
static void beat(void *context) {
    (void)context;
    const sl_ranks here = sl_ranks_here();
    const unsigned before = (here.rank + here.count - 1) % here.count, after = (here.rank + 1) % here.count;
    int told = 0, heard = 0, silent = 0;
    MPI_Request out = MPI_REQUEST_NULL, in;
    MPI_Irecv(&heard, 1, MPI_INT, (int)before, 0, heart.ring, &in);
    for (unsigned tick = 0; !told || !heard; tick++) {
        int sent, came = 0;
        MPI_Test(&out, &sent, MPI_STATUS_IGNORE);
        if (sent && !told && (tick % BEAT_TICKS == 0 || heart.over)) {
            told = heart.over;
            MPI_Isend(&told, 1, MPI_INT, (int)after, 0, heart.ring, &out);
        }
        if (!heard) MPI_Test(&in, &came, MPI_STATUS_IGNORE);
        if (came && !heard) MPI_Irecv(&heard, 1, MPI_INT, (int)before, 0, heart.ring, &in);
        silent = came ? 0 : silent + 1;
        if (!heard && silent > PATIENCE_TICKS) sl_ranks_end(before, "has not been heard of for 8 s");
        nanosleep(&(struct timespec){0, TICK_MS * 1000000}, NULL);
    }
    MPI_Wait(&out, MPI_STATUS_IGNORE);
}

/* Where MPI cannot be called by two threads nobody is watched. */
void sl_heartbeat_start(void) {
    int level;
    MPI_Query_thread(&level);
    int can = level >= MPI_THREAD_MULTIPLE, all;
    MPI_Allreduce(&can, &all, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
    if (!all || sl_ranks_here().count == 1) return;
    MPI_Comm_dup(MPI_COMM_WORLD, &heart.ring);
    heart.runs = sl_thread_start(&heart.thread, beat, NULL);
    if (!heart.runs) sl_ranks_end(sl_ranks_here().rank, "has no thread to tell that it lives");
}

void sl_heartbeat_stop(void) {
    if (!heart.runs) return;
    MPI_Barrier(MPI_COMM_WORLD);
    heart.over = true;
    sl_thread_join(&heart.thread);
    MPI_Comm_free(&heart.ring);
}
