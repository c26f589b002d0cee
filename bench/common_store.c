/* Reference radiance of chosen pixels, and a folder that keeps what was dear to compute. */
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/parallel.h"
#include "base/random.h"
#include "common.h"

/* ---- the folder ---- */

static const char folder[] = "build/references";

uint64_t bench_hash(uint64_t hash, const void *bytes, size_t size) {
    const unsigned char *p = bytes;
    for (size_t i = 0; i < size; i++) hash = sl_hash64(hash ^ p[i]);
    return hash;
}

static void file_name(char path[256], const char *word, uint64_t hash) {
    snprintf(path, 256, "%s/%s-%016llx.f32", folder, word, (unsigned long long)hash);
}

bool bench_store_load(const char *word, uint64_t hash, size_t count, float *values) {
    char path[256];
    file_name(path, word, hash);
    FILE *file = fopen(path, "rb");
    if (!file) return false;
    size_t got = fread(values, sizeof *values, count, file);
    bool whole = got == count && fgetc(file) == EOF;
    fclose(file);
    return whole;
}

/* Whole or not at all: written beside its name and renamed. */
void bench_store_save(const char *word, uint64_t hash, size_t count, const float *values) {
    char path[256], beside[300];
    mkdir("build", 0777);
    mkdir(folder, 0777);
    file_name(path, word, hash);
    snprintf(beside, sizeof beside, "%s.new", path);
    FILE *file = fopen(beside, "wb");
    bool good = file && fwrite(values, sizeof *values, count, file) == count;
    if (file && fclose(file) != 0) good = false;
    if (!good || rename(beside, path) != 0) fprintf(stderr, "warning: %s cannot be kept\n", path);
}

/* ---- pixels by the path tracer ---- */

typedef struct reference_task {
    const sl_scene *scene;
    const sl_path_tracer *path;
    const bench_pixels *pixels;
    bench_reference *reference;
} reference_task;

/* Sixteen pixels, all their samples. */
static void trace_packet(void *context, size_t packet, unsigned worker) {
    (void)worker;
    const reference_task *t = context;
    size_t first = packet * SL_PACKET, rest = t->pixels->count - first;
    unsigned count = rest < SL_PACKET ? (unsigned)rest : SL_PACKET;
    double sums[2][3 * SL_PACKET] = {{0}};
    sl_counters counters = {{0}};
    sl_ray16 rays;
    for (unsigned i = 0; i < count; i++) {
        bench_camera_ray(t->scene, t->pixels->width, t->pixels->height, t->pixels->index[first + i], &rays,
                         i);
    }
    for (uint32_t sample = 0; sample < t->reference->samples; sample++) {
        sl_rgb radiance[SL_PACKET];
        sl_path_tracer_radiance(t->path, &rays, count, packet, sample, radiance, &counters);
        for (unsigned i = 0; i < count; i++) {
            double *sum = &sums[sample % 2][3 * i];
            sum[0] += (double)radiance[i].r;
            sum[1] += (double)radiance[i].g;
            sum[2] += (double)radiance[i].b;
        }
    }
    for (int half = 0; half < 2; half++) {
        for (size_t i = 0; i < 3 * (size_t)count; i++)
            t->reference->half[half][3 * first + i] =
                (float)(sums[half][i] / (0.5 * (double)t->reference->samples));
    }
}

static uint64_t hash_transport(uint64_t hash, const sl_transport *t) {
    const uint32_t words[] = {t->emission,     t->eye_mirrors, t->direct_lobes,      t->receiver_lobes,
                              t->bounce_lobes, t->bounces,     t->direct_visibility, t->bounce_visibility};
    hash = bench_hash(hash, words, sizeof words);
    /* What was kept before skies could be left out stays of use. */
    const uint32_t skyless = 1;
    return t->sky_light ? hash : bench_hash(hash, &skyless, sizeof skyless);
}

static void allocate_reference(bench_reference *reference, size_t count, uint32_t samples) {
    *reference = (bench_reference){.count = count, .samples = samples};
    reference->half[0] = calloc(6 * count + 1, sizeof(float));
    if (!reference->half[0]) bench_fail("reference", NULL);
    reference->half[1] = reference->half[0] + 3 * count;
}

void bench_reference_get(const sl_scene *scene, const sl_tracer *tracer, const sl_transport *transport,
                         const bench_pixels *pixels, uint32_t samples, bench_reference *reference) {
    uint64_t numbers[] = {sl_scene_hash(scene), (uint64_t)pixels->width, (uint64_t)pixels->height, samples};
    uint64_t hash = hash_transport(bench_hash(2, numbers, sizeof numbers), transport);
    hash = bench_hash(hash, pixels->index, pixels->count * sizeof *pixels->index);
    allocate_reference(reference, pixels->count, samples);
    if (bench_store_load("pixels", hash, 6 * pixels->count, reference->half[0])) return;
    fprintf(stderr, "reference: %zu pixels, %u samples ...\n", pixels->count, samples);
    sl_path_settings settings = {1, 1, 1, 4711, *transport};
    sl_path_tracer *path;
    sl_error error;
    settings.transport.filter = SL_FILTER_CENTRE;
    if (sl_path_tracer_create(scene, tracer, &settings, &path, &error) != SL_OK)
        bench_fail("path tracer", &error);
    reference_task task = {scene, path, pixels, reference};
    sl_parallel_for(sl_thread_count(0), (pixels->count + SL_PACKET - 1) / SL_PACKET, trace_packet, &task);
    sl_path_tracer_destroy(path);
    bench_store_save("pixels", hash, 6 * pixels->count, reference->half[0]);
}

void bench_reference_sum(const bench_reference *a, const bench_reference *b, bench_reference *sum) {
    allocate_reference(sum, a->count, a->samples < b->samples ? a->samples : b->samples);
    for (size_t i = 0; i < 6 * a->count; i++) sum->half[0][i] = a->half[0][i] + b->half[0][i];
}

void bench_reference_free(bench_reference *reference) {
    free(reference->half[0]);
    *reference = (bench_reference){0};
}
