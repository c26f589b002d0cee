/* The simulated raster hardware beside OSMesa (Mesa's llvmpipe), and beside rays.
 *
 *     build/bench/bench_raster [--threads N] [--only TEXT] [--csv] [--brief]
 *
 * Every workload runs on ours and on OSMesa in turn: same triangles, matrices, resolution and number of threads. OSMesa gets indexed
 * triangles with shared vertices in static buffers, in one draw call a view. Its time includes reading the picture into memory
 * (glReadPixels), which ours is drawn into; the time of drawing alone stands beside it. On one thread the clock is processor time,
 * on two it is wall time (raster_measure.c says how). Shaders are compiled and memory is touched before.
 *
 * Work that does not show is not done by ours, where OSMesa is free to leave it out too: attributes are computed once a visible
 * pixel, after the ID map. "differing" is the share of pixels in which the two pictures differ: of ID maps in any bit, of others by more
 * than rounding.
 *
 * Without --threads it runs for one thread, then for two in a process of its own, because OSMesa learns their number once. */
#define _POSIX_C_SOURCE 200809L
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "raster_workloads.h"

typedef struct options {
    measurer measurer;
    bool both, brief;
} options;

static const int room_sizes[3] = {2, 7, 27}; /* n: 6,048, 65,448 and 963,048 triangles */

static void seen_rows(measurer *m, const bench_scene *s) {
    bench_id_map(m, s, 1000, 1000);
    bench_id_map(m, s, 640, 480);
    bench_depth_cube(m, s);
}

/* OSMesa takes a second for some of these at a million triangles. */
static void gather_rows(measurer *m, const bench_scene *s) {
    if (s->scene->triangle_count > 300000) return;
    for (int size = 64; size <= 256; size *= 2) bench_hemisphere(m, s, size);
    for (int size = 64; size <= 256; size *= 2) bench_hemicube(m, s, size);
}

static void run_all(const options *o) {
    static const char *const files[] = {"scenes/generated/room.json", "scenes/generated/atrium.json", "scenes/generated/figure.json"};
    measurer m = o->measurer;
    char title[160];
    const char *missing = peer_start(m.threads);
    if (missing && !m.csv) printf("OSMesa is not here: %s\n", missing);
    snprintf(title, sizeof title, "%u thread%s, %s; OSMesa: %s", m.threads, m.threads > 1 ? "s" : "",
             m.threads > 1 ? "wall time" : "processor time", peer_name());
    measure_head(&m, title);
    bench_scene *room[3];
    for (int k = 0; k < 3; k++) {
        room[k] = bench_room(room_sizes[k]);
        seen_rows(&m, room[k]);
        bench_gbuffer(&m, room[k]);
        gather_rows(&m, room[k]);
    }
    bench_splats(&m, room[1]);
    bench_fill(&m);
    bench_small_triangles(&m);
    bench_reduction(&m);
    bench_scene *file[3] = {0};
    for (int k = 0; k < 3 && !o->brief; k++) {
        if (access(files[k], R_OK)) continue;
        file[k] = bench_load(files[k]);
        seen_rows(&m, file[k]);
        gather_rows(&m, file[k]);
    }
    if (!m.csv) printf("%d of %d rows miss what is wanted\n", m.missed, m.rows);
    roofline_print(&m);
    for (int k = 0; k < 3; k++) bench_rays(&m, room[k]);
    for (int k = 0; k < 3; k++) {
        if (file[k]) bench_rays(&m, file[k]);
        bench_scene_destroy(file[k]);
        bench_scene_destroy(room[k]);
    }
}

static void usage(void) {
    fprintf(stderr, "usage: bench_raster [--threads N] [--only TEXT] [--csv] [--brief]\n");
    exit(2);
}

static options parse(int argc, char **argv) {
    options o = {.measurer = {.threads = 1}, .both = true};
    for (int i = 1; i < argc; i++) {
        if (!strcmp(argv[i], "--threads") && i + 1 < argc) {
            o.measurer.threads = (unsigned)strtoul(argv[++i], NULL, 10);
            o.both = false;
        } else if (!strcmp(argv[i], "--only") && i + 1 < argc) {
            o.measurer.only = argv[++i];
        } else if (!strcmp(argv[i], "--csv")) {
            o.measurer.csv = true;
        } else if (!strcmp(argv[i], "--brief")) {
            o.brief = true;
        } else {
            usage();
        }
    }
    if (o.measurer.threads < 1 || o.measurer.threads > 2) usage();
    return o;
}

/* This program again with the same options and two threads. */
static int run_on_two_threads(int argc, char **argv) {
    char **again = calloc((size_t)argc + 3, sizeof *again);
    int status = 1;
    if (!again) return 1;
    memcpy(again, argv, (size_t)argc * sizeof *again);
    again[argc] = (char[]){"--threads"};
    again[argc + 1] = (char[]){"2"};
    pid_t child = fork();
    if (child == 0) {
        execv("/proc/self/exe", again);
        _exit(1);
    }
    if (child < 0 || waitpid(child, &status, 0) != child) status = 1;
    free(again);
    return status != 0;
}

int main(int argc, char **argv) {
    options o = parse(argc, argv);
    run_all(&o);
    return o.both ? run_on_two_threads(argc, argv) : 0;
}
