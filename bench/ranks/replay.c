/* Feeds bench/ranks.py --network: mpirun -n 2 ranks-replay LOG exchanges what the batches of a log
 * (batch_log.c) would, without any work, and prints the network's latency in seconds, its bytes a second
 * each way, and the seconds that all exchanges took. */
#include <mpi.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/ranks.h"
#include "mpi/end.h"

/* Seconds that a message of so many bytes takes, both ways at once. */
static double swap_seconds(char *bytes, int count, int times) {
    const int other = 1 - (int)sl_ranks_here().rank;
    MPI_Barrier(MPI_COMM_WORLD);
    const double begin = MPI_Wtime();
    for (int i = 0; i < times; i++)
        MPI_Sendrecv(bytes, count, MPI_BYTE, other, 0, bytes + count, count, MPI_BYTE, other, 0,
                     MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    return (MPI_Wtime() - begin) / times;
}

/* Exchanges the batches of a log; returns the seconds. */
static double replay(FILE *log) {
    char line[1024];
    size_t count, bytes;
    double seconds = 0.0;
    while (fgets(line, sizeof line, log)) {
        if (sscanf(line, "%*f %zu %zu", &count, &bytes) != 2) continue;
        sl_counters counted = {{0}};
        char *items = calloc(count + 1, bytes + 1);
        if (!items) sl_ranks_end(sl_ranks_here().rank, "is out of memory");
        MPI_Barrier(MPI_COMM_WORLD);
        const double begin = MPI_Wtime();
        sl_ranks_exchange(&(sl_batch_plane){items, bytes}, 1, count, &counted);
        seconds += MPI_Wtime() - begin;
        free(items);
    }
    return seconds;
}

int main(int argc, char **argv) {
    enum { LARGE = 1 << 24 };
    MPI_Init(&argc, &argv);
    sl_ranks_start();
    FILE *log = argc == 2 ? fopen(argv[1], "r") : NULL;
    char *bytes = calloc(2, LARGE);
    if (!log || !bytes || sl_ranks_here().count != 2)
        sl_ranks_end(0, "expected: mpirun -n 2 ranks-replay LOG");
    swap_seconds(bytes, 1, 100);
    const double latency = swap_seconds(bytes, 1, 2000), large = swap_seconds(bytes, LARGE, 4);
    const double seconds = replay(log);
    if (sl_ranks_here().rank == 0) printf("%.9f %.0f %.6f\n", latency, LARGE / (large - latency), seconds);
    free(bytes);
    fclose(log);
    MPI_Finalize();
    return 0;
}
