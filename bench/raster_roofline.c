/* The roofline: what the machine would need at the least. A render must read the clusters' bounds, the
 * triangles of the clusters that it did not reject, write its planes, and transform those triangles'
 * vertices; memory and a plain vectorized loop give the two times. Counters tell how much of it there was. */
#include <stdio.h>
#include <string.h>

#include "base/memory.h"
#include "raster_bench_kernels.h"
#include "raster_workloads.h"
#include "timing.h"

enum { ROWS = 64, BOUNDS_BYTES = 28, PLANE_BYTES = 8 };

typedef struct row {
    char name[128];
    double ms, triangles, held, vertices, bytes; /* of one render; held: the scene's triangles */
} row;

static row rows[ROWS];
static int row_count;

const bench_kernels *bench_kernels_best(void) {
    extern const bench_kernels bench_kernel_table_baseline;
#ifndef SL_BASELINE_ONLY
    extern const bench_kernels bench_kernel_table_avx2, bench_kernel_table_avx512;
    if (sl_isa_best() == SL_ISA_AVX512) return &bench_kernel_table_avx512;
    if (sl_isa_best() == SL_ISA_AVX2) return &bench_kernel_table_avx2;
#endif
    return &bench_kernel_table_baseline;
}

void roofline_note(const bench_scene *s, const char *name, const figures *f, double renders, double pixels) {
    if (row_count == ROWS) return;
    row *r = &rows[row_count++];
    double held = (double)s->scene->triangle_count;
    double triangles = (double)f->counters.value[SL_COUNT_TRIANGLES_SUBMITTED] / renders;
    snprintf(r->name, sizeof r->name, "%s", name);
    r->ms = f->ours;
    r->held = held;
    r->triangles = triangles;
    r->vertices = triangles * (double)s->mesh.vertex_count / held;
    r->bytes = triangles * (double)sl_raster_memory_bytes(s->raster) / held + PLANE_BYTES * pixels +
               BOUNDS_BYTES * (double)f->counters.value[SL_COUNT_CLUSTERS_TESTED] / renders;
}

/* Bytes a millisecond; three arrays of `count` floats. */
static double measure_triad(size_t count) {
    enum { TIMES = 9 };
    float *a = bench_allocate(3 * count, sizeof *a);
    size_t repeat = ((size_t)1 << 25) / count + 1;
    double ms[TIMES];
    for (size_t i = 0; i < 3 * count; i++) a[i] = (float)i;
    for (int t = 0; t < TIMES; t++) {
        double start = now_ms();
        for (size_t r = 0; r < repeat; r++)
            bench_kernels_best()->triad(a, a + count, a + 2 * count, 0.5f, count);
        ms[t] = (now_ms() - start) / (double)repeat;
    }
    sl_free(a);
    return 3.0 * (double)count * sizeof(float) / median(ms, TIMES);
}

/* Vertices a millisecond, from and to the caches. */
static double measure_transform(void) {
    enum { COUNT = 1 << 13, REPEAT = 200, TIMES = 9 };
    const float matrix[4][4] = {{1.1f, 0.1f, 0.2f, 0.3f},
                                {0.1f, 1.2f, 0.3f, 0.1f},
                                {0.2f, 0.1f, 1.3f, 0.2f},
                                {0.1f, 0.2f, 0.9f, 1.5f}};
    float *v = bench_allocate(6 * COUNT, sizeof *v);
    double ms[TIMES];
    for (int i = 0; i < 3 * COUNT; i++) v[i] = (float)(i % 1000) * 1e-3f;
    for (int t = 0; t < TIMES; t++) {
        double start = now_ms();
        for (int r = 0; r < REPEAT; r++)
            bench_kernels_best()->transform(v, v + COUNT, v + 2 * COUNT, matrix, v + 3 * COUNT, COUNT);
        ms[t] = (now_ms() - start) / REPEAT;
    }
    sl_free(v);
    return COUNT / median(ms, TIMES);
}

static void print_row(const row *r, double memory, double transform) {
    double memory_ms = r->bytes / memory, transform_ms = r->vertices / transform;
    double least = memory_ms > transform_ms ? memory_ms : transform_ms;
    printf("%-42s %9.0f %8.0f %8.0f %8.1f %9.4f %9.4f %9.4g %6.1f\n", r->name, r->triangles,
           1e-3 * r->triangles / r->ms, 1e-3 * r->held / r->ms, 1e-6 * r->bytes, memory_ms, transform_ms,
           r->ms, r->ms / least);
}

void roofline_print(const measurer *m) {
    if (m->csv || m->threads > 1 || row_count == 0) return;
    double memory = measure_triad((size_t)22 << 20), cache = measure_triad((size_t)1 << 15),
           transform = measure_transform();
    printf("\nroofline of one thread: memory %.1f GB/s (256 MB), second cache %.1f GB/s (384 KB), plain "
           "transform %.0f million vertices/s\n",
           1e-6 * memory, 1e-6 * cache, 1e-3 * transform);
    printf("%-42s %9s %8s %8s %8s %9s %9s %9s %6s\n", "of one render", "triangles", "M/s", "held M/s", "MB",
           "memory ms", "vertex ms", "ours ms", "times");
    for (int i = 0; i < row_count; i++) print_row(&rows[i], memory, transform);
}
