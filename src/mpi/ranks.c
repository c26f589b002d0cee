/* Ranks by MPI, which starts, places and connects them. */
#include "base/random.h"
#include "base/ranks.h"
#include "mpi/end.h"
#include "mpi/journal.h"

#include <limits.h>
#include <mpi.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static pid_t process; /* the rank's; one that it starts is none */

void sl_ranks_start(void) { process = getpid(); }

sl_ranks sl_ranks_here(void) {
    int rank, count;
    if (getpid() != process) return (sl_ranks){0, 1};
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &count);
    return (sl_ranks){(unsigned)rank, (unsigned)count};
}

bool sl_ranks_share(void) { return sl_ranks_here().count > 1 || sl_ranks_journal_is_kept(); }

/* Tells whether all ranks have the same number here. */
static bool agree(uint64_t number) {
    uint64_t ends[2] = {number, ~number}, least[2]; /* the least of ~n is that of the largest n */
    MPI_Allreduce(ends, least, 2, MPI_UINT64_T, MPI_MIN, MPI_COMM_WORLD);
    return least[0] == ~least[1];
}

uint64_t sl_ranks_call;

const char *sl_ranks_begin(uint64_t scene) {
    if (!agree(scene)) return "ranks have read different scenes";
    return sl_ranks_journal_open(sl_hash64(scene ^ sl_ranks_call));
}

int sl_ranks_voice = STDERR_FILENO;

void sl_ranks_end(unsigned rank, const char *why) {
    dprintf(sl_ranks_voice, "softlux-mpi: rank %u %s\n", rank, why);
    MPI_Abort(MPI_COMM_WORLD, 5);
    for (;;) pause();
}

static void end_for_memory(sl_ranks here) { sl_ranks_end(here.rank, "is out of memory"); }

void sl_ranks_tell(unsigned teller, void *bytes, size_t count) {
    enum { PIECE = 1 << 28 }; /* MPI counts in int */
    for (size_t at = 0; at < count; at += PIECE) {
        const size_t some = count - at < PIECE ? count - at : PIECE;
        MPI_Bcast((char *)bytes + at, (int)some, MPI_BYTE, (int)teller, MPI_COMM_WORLD);
    }
}

/* ---- what each rank is about to give ---- */

typedef struct head {
    uint64_t count, bytes;
    sl_counters counted;
} head;

static bool are_alike(const head *a, const head *b) { return a->count == b->count && a->bytes == b->bytes; }

/* All ranks see it, the first one tells. */
static void end_at_other_work(sl_ranks here, unsigned other) {
    if (here.rank == 0)
        sl_ranks_end(other, "is at other work: do all have the same scene, files and options?");
    for (;;) pause();
}

/* Whole numbers: their sum does not depend on the order. */
static void exchange_heads(sl_ranks here, size_t count, size_t bytes, sl_counters *counted) {
    const head own = {count, bytes, *counted};
    head *all = malloc(here.count * sizeof *all);
    if (!all) end_for_memory(here);
    MPI_Allgather(&own, sizeof own, MPI_BYTE, all, sizeof own, MPI_BYTE, MPI_COMM_WORLD);
    *counted = (sl_counters){{0}};
    for (unsigned r = 0; r < here.count; r++) {
        if (!are_alike(&all[r], &all[0])) end_at_other_work(here, r);
        sl_counters_add(counted, &all[r].counted);
    }
    free(all);
}

/* ---- items ---- */

/* Items [first, end) of some planes; first is a multiple of the ranks. */
typedef struct piece {
    const sl_batch_plane *planes;
    unsigned plane_count;
    size_t first, end;
} piece;

static size_t items_of(const piece *p, sl_ranks at) {
    return sl_ranks_items(at, p->end) - p->first / at.count;
}

/* Puts a rank's items side by side, or back into their places. */
static void move_items(const piece *p, char *side, sl_ranks at, bool back) {
    const size_t begin = p->first / at.count, end = begin + items_of(p, at);
    for (unsigned k = 0; k < p->plane_count; k++) {
        char *items = p->planes[k].items;
        const size_t bytes = p->planes[k].bytes;
        for (size_t turn = begin; bytes && turn < end; turn++, side += bytes) {
            char *item = items + sl_ranks_item(at, turn) * bytes;
            memcpy(back ? item : side, back ? side : item, bytes);
        }
    }
}

static void exchange_piece(sl_ranks here, const piece *p, size_t bytes) {
    const size_t count = p->end - p->first;
    char *all = malloc(count * bytes);
    int *sizes = malloc(2 * here.count * sizeof *sizes), *places = sizes + here.count;
    if (!all || !sizes) end_for_memory(here);
    size_t place = 0;
    for (unsigned r = 0; r < here.count; r++) {
        sizes[r] = (int)(items_of(p, (sl_ranks){r, here.count}) * bytes);
        places[r] = (int)place;
        place += (size_t)sizes[r];
    }
    move_items(p, all + places[here.rank], here, false);
    MPI_Allgatherv(MPI_IN_PLACE, 0, MPI_DATATYPE_NULL, all, sizes, places, MPI_BYTE, MPI_COMM_WORLD);
    for (unsigned r = 0; r < here.count; r++)
        if (r != here.rank) move_items(p, all + places[r], (sl_ranks){r, here.count}, true);
    free(sizes);
    free(all);
}

static void exchange_items(sl_ranks here, const sl_batch_plane *planes, unsigned plane_count, size_t count,
                           size_t bytes) {
    /* MPI counts in int: whole rounds of all ranks at a time */
    const size_t rounds = (size_t)INT_MAX / 2 / bytes / here.count;
    const size_t most = (rounds ? rounds : 1) * here.count;
    for (size_t first = 0; first < count; first += most) {
        const size_t end = count - first < most ? count : first + most;
        exchange_piece(here, &(piece){planes, plane_count, first, end}, bytes);
    }
}

void sl_ranks_exchange(const sl_batch_plane *planes, unsigned plane_count, size_t count,
                       sl_counters *counted) {
    const sl_ranks here = sl_ranks_here();
    size_t bytes = 0;
    for (unsigned k = 0; k < plane_count; k++) bytes += planes[k].bytes;
    if (here.count > 1) exchange_heads(here, count, bytes, counted);
    if (here.count > 1 && bytes) exchange_items(here, planes, plane_count, count, bytes);
    sl_ranks_journal_note(planes, plane_count, count, counted);
}
