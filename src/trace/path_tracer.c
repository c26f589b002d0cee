/* The reference path tracers' film: pixels in tiles of 4 x 4, one packet each. Even and odd samples draw from
 * sequences that are scrambled apart, so the two halves are independent pictures. */
#include "base/batch.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/random.h"
#include "trace/bidirectional/bidirectional.h"

enum { TILE = 4, TILES_A_TASK = 16 };

struct sl_path_tracer {
    const sl_scene *scene;
    sl_path_settings settings;
    uint64_t stream_seed;
    sl_light_sampler *lights;
    sl_sequence sequence;
    sl_path_walk walk;
    sl_path_pairs *pairs; /* where walks from the lights are joined; or NULL */
    sl_halves halves;
};

static sl_status make_film(sl_path_tracer *path, const sl_tracer *tracer, sl_error *error) {
    const sl_path_settings *s = &path->settings;
    sl_status status = sl_light_sampler_create_for(path->scene, &s->transport, &path->lights, error);
    if (status == SL_OK)
        status = sl_halves_create(&path->halves, (size_t)s->width * (size_t)s->height, error);
    if (status != SL_OK) return status;
    sl_sequence_make(&path->sequence);
    path->walk = (sl_path_walk){path->scene, tracer, path->lights, &path->sequence, s->transport,
                                sl_pixel_shape_of(s->transport.filter, s->transport.filter_radius)};
    if (!s->bidirectional) return SL_OK;
    sl_path_lens lens = sl_path_lens_of(path->scene, s->width, s->height);
    return sl_path_pairs_create(&path->walk, &lens, s->threads, &path->pairs, error);
}

sl_status sl_path_tracer_create(const sl_scene *scene, const sl_tracer *tracer,
                                const sl_path_settings *settings, sl_path_tracer **out, sl_error *error) {
    *out = NULL;
    sl_pixel_filter filter = settings->transport.filter;
    if (settings->width <= 0 || settings->height <= 0) {
        return sl_fail(error, SL_ERROR_USAGE, "a film has at least one pixel, not %d x %d", settings->width,
                       settings->height);
    }
    if (filter == SL_FILTER_METHOD)
        return sl_fail(error, SL_ERROR_USAGE, "a path tracer's filter is box, centre or blackman-harris");
    sl_path_tracer *path = sl_allocate(1, sizeof *path);
    if (!path) return sl_fail_memory(error, "the path tracer");
    path->scene = scene;
    path->settings = *settings;
    path->settings.threads = sl_thread_count(settings->threads);
    /* the two tracers' numbers of one seed are not the same */
    path->stream_seed = settings->bidirectional ? sl_hash64(settings->seed) ^ 0x42696469u : settings->seed;
    sl_status status = make_film(path, tracer, error);
    if (status != SL_OK) {
        sl_path_tracer_destroy(path);
        return status;
    }
    *out = path;
    return SL_OK;
}

void sl_path_tracer_destroy(sl_path_tracer *path) {
    if (!path) return;
    sl_path_pairs_destroy(path->pairs);
    sl_halves_release(&path->halves);
    sl_light_sampler_destroy(path->lights);
    sl_free(path);
}

/* ---- one sample of every pixel --------------------------------------------------------------- */

typedef struct sample_pass {
    sl_path_tracer *path;
    unsigned half;
    uint32_t index;    /* of the half's points */
    size_t first_task; /* of those at once */
    sl_path_lens lens;
} sample_pass;

static uint64_t stream_key(const sl_path_tracer *path, unsigned half, uint64_t stream) {
    return sl_random_key(path->stream_seed, 2 * stream + half);
}

static void find_radiance(const sample_pass *pass, size_t task, unsigned worker, unsigned count,
                          const sl_path_place *place, const uint64_t *key, sl_rgb *radiance,
                          sl_counters *counters) {
    sl_path_tracer *path = pass->path;
    if (path->pairs) {
        sl_path_pairs_radiance(path->pairs, worker, task, count, place, key, pass->index, radiance, counters);
        return;
    }
    sl_ray16 rays;
    for (unsigned i = 0; i < count; i++) sl_path_lens_ray(path->scene, &pass->lens, place[i], &rays, i);
    sl_path_walk_radiance(&path->walk, &rays, count, true, key, pass->index, radiance, counters);
}

static void sample_tile(const sample_pass *pass, size_t task, unsigned worker, size_t tile,
                        sl_counters *counters) {
    sl_path_tracer *path = pass->path;
    int width = path->settings.width, height = path->settings.height;
    int across = (width + TILE - 1) / TILE, left = (int)(tile % (size_t)across) * TILE,
        top = (int)(tile / (size_t)across) * TILE;
    uint64_t keys[SL_PACKET];
    size_t pixels[SL_PACKET];
    sl_path_place places[SL_PACKET];
    unsigned count = 0;
    for (int i = 0; i < SL_PACKET; i++) {
        int x = left + i % TILE, y = top + i / TILE;
        if (x >= width || y >= height) continue;
        pixels[count] = (size_t)y * (size_t)width + (size_t)x;
        keys[count] = stream_key(path, pass->half, pixels[count]);
        places[count] = sl_path_place_in(&path->walk, x, y, keys[count], pass->index);
        count++;
    }
    sl_rgb radiance[SL_PACKET];
    find_radiance(pass, task, worker, count, places, keys, radiance, counters);
    sl_count(counters, SL_COUNT_SAMPLES, count);
    for (unsigned i = 0; i < count; i++) {
        sl_halves_add(&path->halves, pass->half, pixels[i], sl_path_finite_or_black(radiance[i], counters));
    }
}

static size_t tile_count(const sl_path_tracer *path) {
    size_t across = ((size_t)path->settings.width + TILE - 1) / TILE,
           down = ((size_t)path->settings.height + TILE - 1) / TILE;
    return across * down;
}

static void sample_tiles(void *context, size_t task, unsigned worker, void *result, sl_counters *counters) {
    (void)result;
    const sample_pass *pass = context;
    size_t first = (pass->first_task + task) * TILES_A_TASK, end = first + TILES_A_TASK,
           tiles = tile_count(pass->path);
    for (size_t tile = first; tile < end && tile < tiles; tile++)
        sample_tile(pass, task, worker, tile, counters);
}

sl_status sl_path_tracer_sample(sl_path_tracer *path, uint64_t sample, sl_counters *counters,
                                sl_error *error) {
    if (sample / SL_HALVES > UINT32_MAX) return sl_fail(error, SL_ERROR_USAGE, "too many samples a pixel");
    sample_pass pass = {path, (unsigned)(sample % SL_HALVES), (uint32_t)(sample / SL_HALVES), 0,
                        sl_path_lens_of(path->scene, path->settings.width, path->settings.height)};
    const size_t tasks = (tile_count(path) + TILES_A_TASK - 1) / TILES_A_TASK,
                 at_once = path->pairs ? SL_PAIR_LISTS : tasks;
    for (; pass.first_task < tasks; pass.first_task += at_once) {
        size_t left = tasks - pass.first_task;
        sl_batch_run(&(sl_batch){.count = left < at_once ? left : at_once,
                                 .work = sample_tiles,
                                 .context = &pass},
                     path->settings.threads, counters);
        if (path->pairs && !sl_path_pairs_commit(path->pairs, &path->halves, pass.half))
            return sl_fail_memory(error, "what light subpaths leave on the film");
    }
    path->halves.samples[pass.half]++;
    return SL_OK;
}

/* ---- results --------------------------------------------------------------------------------- */

void sl_path_tracer_mean(const sl_path_tracer *path, int half, float *r, float *g, float *b) {
    sl_halves_mean(&path->halves, half, r, g, b);
}

size_t sl_path_tracer_memory_bytes(const sl_path_tracer *path) {
    return sizeof *path + sl_halves_memory_bytes(&path->halves) +
           (path->pairs ? sl_path_pairs_memory_bytes(path->pairs) : 0);
}
