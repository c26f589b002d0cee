/* The simulated raster hardware beside OSMesa (Mesa's llvmpipe).
 *
 *     build/bench/bench_raster [--threads N] [--only TEXT] [--ours] [--brief]
 *
 * Every workload runs on ours and on OSMesa in turn: same triangles, matrices, resolution and number of
 * threads. OSMesa gets indexed triangles with shared vertices in static buffers, in one draw call a view. Its
 * time includes reading the picture into memory (glReadPixels), which ours is drawn into; the time of drawing
 * alone stands beside it. On one thread the clock is processor time, on two it is wall time (raster_measure.c
 * says how). Shaders are compiled and memory is touched before.
 *
 * Work that does not show is not done by ours, where OSMesa is free to leave it out too: attributes are
 * computed once a visible pixel, after the ID map. "differing" is the share of pixels in which the two
 * pictures differ: of ID maps in any bit, of others by more than rounding. Gathers differ mostly because
 * their near plane is so close to the eye that OSMesa's window depth, z/w in float, cannot tell far surfaces
 * apart; ours keeps 1/w there.
 *
 * --only keeps the rows whose names hold the text, --brief the smallest scene, --ours leaves OSMesa out (for a
 * profiler). Without --threads it runs for one thread, then for two in a process of its own,
 * because OSMesa learns their number once. */
#define _POSIX_C_SOURCE 200809L
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "raster_workloads.h"

typedef struct options {
    measurer measurer;
    bool both, brief, ours;
} options;

static void seen_rows(measurer *m, bench_scene *s) {
    bench_id_map(m, s, 1000, 1000);
    bench_id_map(m, s, 640, 480);
    bench_depth_cube(m, s);
    bench_gbuffer(m, s);
}

static void gather_rows(measurer *m, bench_scene *s) {
    if (!s->gathers) return;
    for (int size = 64; size <= 256; size *= 2) bench_hemisphere(m, s, size);
    for (int size = 64; size <= 256; size *= 2) bench_hemicube(m, s, size);
}

static void all_rows(measurer *m, bench_scene *scene, int scenes) {
    for (int k = 0; k < scenes; k++) {
        if (access(scene[k].path, R_OK)) continue;
        seen_rows(m, &scene[k]);
        gather_rows(m, &scene[k]);
    }
    if (access(scene[0].path, R_OK) == 0) bench_splats(m, &scene[0]);
    bench_fill(m);
    bench_small_triangles(m);
    bench_reduction(m);
}

static void all_tables(const options *o) {
    bench_scene scene[3] = {{.name = "room 7K", .path = "scenes/generated/room.json", .gathers = true},
                            {.name = "atrium 67K", .path = "scenes/generated/atrium.json", .gathers = true},
                            {.name = "figure 878K", .path = "scenes/generated/figure.json"}};
    measurer m = o->measurer;
    char title[512];
    const char *missing = o->ours ? "not asked for" : peer_start(m.threads);
    snprintf(title, sizeof title, "%u thread%s, %s; OSMesa: %s", m.threads, m.threads > 1 ? "s" : "",
             m.threads > 1 ? "wall time" : "processor time", missing ? missing : peer_name());
    measure_head(&m, title);
    all_rows(&m, scene, o->brief ? 1 : 3);
    printf("%d of %d rows miss what is wanted\n", m.missed, m.rows);
    for (int k = 0; k < 3; k++) bench_scene_close(&scene[k]);
}

static void usage(void) {
    fprintf(stderr, "usage: bench_raster [--threads N] [--only TEXT] [--ours] [--brief]\n");
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
        } else if (!strcmp(argv[i], "--ours")) {
            o.ours = true;
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
    all_tables(&o);
    return o.both ? run_on_two_threads(argc, argv) : 0;
}
