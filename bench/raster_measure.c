#include "raster_measure.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "timing.h"

/* On one thread the medians of processor time are told, with half the distance of the quartiles. On two it is
 * the wall that counts, and there whatever else runs can only add: so it is the shortest sample, and how far
 * the median lies above it; and what is wanted is that two threads are 1.7 times as fast as one.
 *
 * A sample is so many runs in a row that the clock's grain does not matter; samples of ours and of OSMesa
 * take turns, so that whatever else the machine does hits both. */
enum { ROUNDS_MIN = 7, ROUNDS_MAX = 41, DRAWING_MIN = 3 };
static const double sample_ms = 4.0, row_ms = 1500.0, wanted_speed_up = 1.7;

enum { OURS, OURS_ALONE, PEER, PEER_DRAWING, KINDS };

static void run(const workload *w, int kind, unsigned threads, sl_counters *counters) {
    switch (kind) {
    case OURS: w->ours(w->context, threads, counters); break;
    case OURS_ALONE: w->ours(w->context, 1, counters); break;
    case PEER: peer_run(w->peer, true); break;
    default: peer_run(w->peer, false); break;
    }
}

/* On one thread, processor time: ours of this thread; OSMesa's of the process, should it have threads that it
 * was not asked for. */
static double now(int kind, unsigned threads) {
    if (threads > 1) return wall_ms();
    return kind == OURS || kind == OURS_ALONE ? now_ms() : process_ms();
}

static double sample(const workload *w, int kind, unsigned threads, int runs) {
    sl_counters counters = {{0}};
    double start = now(kind, threads);
    for (int i = 0; i < runs; i++) run(w, kind, threads, &counters);
    return (now(kind, threads) - start) / runs;
}

/* Also warms up: shaders are compiled, memory is touched. */
static int runs_in_a_sample(const workload *w, int kind, unsigned threads) {
    sample(w, kind, threads, 1);
    double ms = sample(w, kind, threads, 1);
    return ms > sample_ms ? 1 : (int)(sample_ms / (ms > 1e-4 ? ms : 1e-4)) + 1;
}

static bool kind_wanted(const workload *w, unsigned threads, int kind) {
    return kind == OURS || (kind == OURS_ALONE && threads > 1) || (kind >= PEER && w->peer);
}

static double typical(double *ms, int count, unsigned threads, double *apart) {
    double middle = median(ms, count); /* sorts */
    *apart = threads > 1 ? middle / ms[0] - 1.0 : spread(ms, count);
    return threads > 1 ? ms[0] : middle;
}

static figures measure(const workload *w, unsigned threads) {
    double ms[KINDS][ROUNDS_MAX];
    int runs[KINDS] = {0}, rounds = 0;
    figures f = {.differing = -1.0};
    run(w, OURS, threads, &f.counters);
    if (w->peer && w->differing) f.differing = w->differing(w->context, w->peer);
    for (int k = 0; k < KINDS; k++) {
        if (kind_wanted(w, threads, k)) runs[k] = runs_in_a_sample(w, k, threads);
    }
    double start = wall_ms();
    while (rounds < ROUNDS_MIN || (rounds < ROUNDS_MAX && wall_ms() - start < row_ms)) {
        for (int k = 0; k < KINDS; k++) {
            if (runs[k] && (k != PEER_DRAWING || rounds < DRAWING_MIN))
                ms[k][rounds] = sample(w, k, threads, runs[k]) / w->renders;
        }
        rounds++;
    }
    double unused;
    f.ours = typical(ms[OURS], rounds, threads, &f.ours_spread);
    if (runs[OURS_ALONE]) f.ours_one_thread = typical(ms[OURS_ALONE], rounds, threads, &unused);
    if (!w->peer) return f;
    f.peer = typical(ms[PEER], rounds, threads, &f.peer_spread);
    f.peer_drawing = typical(ms[PEER_DRAWING], DRAWING_MIN, threads, &unused);
    return f;
}

/* ---- the table ------------------------------------------------------------------------------- */

bool measure_wants(const measurer *m, const char *name) { return !m->only || strstr(name, m->only); }

void measure_head(const measurer *m, const char *title) {
    printf("\n%s\n%-42s %10s %5s", title, "ms a render", "ours", "+-%");
    if (m->threads > 1) printf(" %10s %8s", "one thread", "speed-up");
    printf(" %10s %5s %10s %7s %7s  %-6s %9s\n", "OSMesa", "+-%", "drawing", "ratio", "wanted", "",
           "differing");
}

static double wanted_of(const measurer *m, const workload *w) {
    return m->threads == 1 ? w->wanted : w->alone ? 0.0 : wanted_speed_up;
}

static void print_row(const measurer *m, const workload *w, const figures *f, bool missed) {
    printf("%-42s %10.4g %5.1f", w->name, f->ours, 100.0 * f->ours_spread);
    if (m->threads > 1) printf(" %10.4g %8.2f", f->ours_one_thread, f->ours_one_thread / f->ours);
    if (w->peer) {
        printf(" %10.4g %5.1f %10.4g %7.2f", f->peer, 100.0 * f->peer_spread, f->peer_drawing,
               f->peer / f->ours);
    } else {
        printf(" %10s %5s %10s %7s", "not here", "", "", "");
    }
    double wanted = wanted_of(m, w);
    if (wanted > 0.0) printf(" %7.1f  %-6s", wanted, missed ? "missed" : "");
    else printf(" %7s  %-6s", "", "");
    if (f->differing >= 0.0) printf(" %9.1e", f->differing);
    else printf(" %9s", "");
    if (w->units > 0.0)
        printf("  %.4g M%s/s, OSMesa %.4g", 1e-3 * w->units / f->ours, w->unit,
               w->peer ? 1e-3 * w->units / f->peer : 0.0);
    printf("\n");
}

figures measure_row(measurer *m, workload *w) {
    figures f = measure(w, m->threads);
    double reached = m->threads > 1 ? f.ours_one_thread / f.ours : w->peer ? f.peer / f.ours : INFINITY;
    bool missed = reached < wanted_of(m, w);
    m->rows++;
    m->missed += missed;
    print_row(m, w, &f, missed);
    fflush(stdout);
    peer_destroy(w->peer);
    w->peer = NULL;
    return f;
}
