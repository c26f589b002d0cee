/* softlux-mpi: `softlux render` and `softlux bench` on as many ranks as mpirun starts, of which the first
 * writes and tells. One option more, --journal FILE, keeps what batches of a picture bring until the call is
 * done. */
#include <mpi.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/random.h"
#include "base/ranks.h"
#include "mpi/end.h"
#include "mpi/journal.h"
#include "softlux.h"

/* main() of ../app/main.c */
int sl_program_main(int argc, char **argv);

/* What the clock decides is not the same on all ranks. */
static const char *refused(int argc, char **argv) {
    const bool bench = argc > 1 && strcmp(argv[1], "bench") == 0;
    if (bench && sl_ranks_journal_is_kept()) return "--journal: bench keeps one in its folder";
    if (bench) return NULL;
    if (argc < 2 || strcmp(argv[1], "render") != 0)
        return "usage: mpirun -n RANKS softlux-mpi render SCENE ... | bench SCENE ...";
    for (int i = 2; i < argc; i++)
        if (strncmp(argv[i], "--time", 6) == 0) return "--time: not on several ranks, whose clocks differ";
    return NULL;
}

/* Takes --journal FILE out of the arguments; returns how many are left, -1: there is no FILE. */
static int take_journal(int argc, char **argv) {
    int left = 0;
    for (int i = 0; i < argc; i++) {
        const bool is_it = strcmp(argv[i], "--journal") == 0;
        if (is_it && i + 1 == argc) return -1;
        if (is_it) sl_ranks_journal_name(argv[++i]);
        else argv[left++] = argv[i];
    }
    argv[left] = NULL;
    return left;
}

/* Returns a hash of what results depend on besides the scene. How many threads there are is no such thing. */
static uint64_t hash_of_call(int argc, char **argv) {
    uint64_t hash = 0;
    for (const char *c = sl_version(); *c; c++) hash = sl_hash64(hash ^ (uint64_t)*c);
    for (int i = 1; i < argc; i++) {
        const bool threads = strcmp(argv[i], "-t") == 0 || strcmp(argv[i], "--threads") == 0;
        if (threads) i++;
        if (threads || strncmp(argv[i], "--threads=", 10) == 0 || strcmp(argv[i], "--quiet") == 0) continue;
        for (const char *c = argv[i];; c++) {
            hash = sl_hash64(hash ^ (uint64_t)*c);
            if (!*c) break;
        }
    }
    return hash;
}

/* Ranks behind the first are silent, but for the line that says why one has failed. */
static FILE *hold_tongue(void) {
    FILE *told = tmpfile();
    sl_ranks_voice = dup(STDERR_FILENO);
    if (!freopen("/dev/null", "w", stdout) || !told || sl_ranks_voice < 0) return NULL;
    return dup2(fileno(told), STDERR_FILENO) < 0 ? NULL : told;
}

static void tell_last_line(FILE *told, unsigned rank) {
    char line[2048], last[2048] = "";
    fflush(stderr);
    rewind(told);
    while (fgets(line, sizeof line, told))
        if (line[0] && line[0] != '\n') memcpy(last, line, sizeof last);
    dprintf(sl_ranks_voice, "softlux-mpi: rank %u: %s", rank, last);
}

static int run(int argc, char **argv) {
    const sl_ranks here = sl_ranks_here();
    FILE *told = here.rank ? hold_tongue() : NULL;
    if (here.rank && !told) return SL_ERROR_RESOURCES;
    sl_heartbeat_start();
    const int status = sl_program_main(argc, argv);
    if (told && status) tell_last_line(told, here.rank);
    if (status) return status;
    sl_heartbeat_stop();
    sl_ranks_journal_remove();
    return status;
}

int main(int argc, char **argv) {
    int level;
    MPI_Init_thread(&argc, &argv, MPI_THREAD_MULTIPLE, &level);
    sl_ranks_start();
    argc = take_journal(argc, argv);
    const char *why = argc < 0 ? "--journal: expected the name of a file" : refused(argc, argv);
    sl_ranks_call = hash_of_call(argc, argv);
    if (why && sl_ranks_here().rank == 0) fprintf(stderr, "softlux-mpi: %s\n", why);
    const int status = why ? SL_ERROR_USAGE : run(argc, argv);
    /* Others may wait for a rank that has failed by itself. */
    if (status && !why) MPI_Abort(MPI_COMM_WORLD, status);
    MPI_Finalize();
    return status;
}
