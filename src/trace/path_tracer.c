/* The reference path tracers' film: pixels in tiles of 4 x 4, one packet each. Even and odd samples draw from
 * sequences that are scrambled apart, so the two halves are independent pictures. */
#include "base/batch.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/random.h"
#include "trace/bidirectional/bidirectional.h"

#include <math.h>

enum { TILE = 4, TILES_A_TASK = 4, TASKS_AT_ONCE = 4096 };

struct sl_path_tracer {
    const sl_scene *scene;
    sl_path_settings settings;
    uint64_t stream_seed;
    sl_light_sampler *lights;
    sl_sequence sequence;
    sl_path_walk walk;
    sl_path_lamps lamps;
    uint8_t *rims; /* tiles in which the edge of a lamp is seen; NULL: not known yet */
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
    path->lamps = sl_path_lamps_of(&path->walk);
    if (!s->bidirectional) return SL_OK;
    sl_path_lens lens = sl_path_lens_of(path->scene, s->width, s->height);
    return sl_path_pairs_create(&path->walk, &lens, s->threads, &path->pairs, error);
}

sl_status sl_path_tracer_create(const sl_scene *scene, const sl_tracer *tracer,
                                const sl_path_settings *settings, sl_path_tracer **out, sl_error *error) {
    *out = NULL;
    sl_pixel_filter filter = settings->transport.filter;
    if (settings->width <= 0 || settings->height <= 0)
        return sl_fail(error, SL_ERROR_USAGE, "a film has at least one pixel, not %d x %d", settings->width,
                       settings->height);
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
    if (status == SL_OK) *out = path;
    else sl_path_tracer_destroy(path);
    return status;
}

void sl_path_tracer_destroy(sl_path_tracer *path) {
    if (!path) return;
    sl_path_pairs_destroy(path->pairs);
    sl_halves_release(&path->halves);
    sl_free(path->rims);
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

/* What a task brings: the light of its tiles' pixels, row by row. */
typedef struct task_light {
    sl_rgb light[TILES_A_TASK][TILE * TILE];
} task_light;

static size_t tile_count(const sl_path_tracer *path) {
    size_t across = ((size_t)path->settings.width + TILE - 1) / TILE,
           down = ((size_t)path->settings.height + TILE - 1) / TILE;
    return across * down;
}

static int tile_left(const sl_path_tracer *path, size_t tile) {
    return (int)(tile % (((size_t)path->settings.width + TILE - 1) / TILE)) * TILE;
}

static int tile_top(const sl_path_tracer *path, size_t tile) {
    return (int)(tile / (((size_t)path->settings.width + TILE - 1) / TILE)) * TILE;
}

static uint64_t stream_key(const sl_path_tracer *path, unsigned half, uint64_t stream) {
    return sl_random_key(path->stream_seed, 2 * stream + half);
}

/* ---- lamps that the eye sees ----------------------------------------------------------------- */

typedef struct rim_search {
    const sl_path_tracer *path;
    sl_path_lens lens;
} rim_search;

/* Looks at two by two pixels at once, a pixel farther than the tile reaches. */
static void look_at_tile(void *context, size_t tile, unsigned worker, void *result, sl_counters *counters) {
    (void)worker;
    enum { SIDE = 2 };
    const rim_search *s = context;
    const int left = tile_left(s->path, tile) - 1, top = tile_top(s->path, tile) - 1;
    sl_path_lamp_view all = {sl_grey(0.0f), INFINITY, 0.0f};
    for (int y = top; y < top + TILE + 2; y += SIDE) {
        for (int x = left; x < left + TILE + 2; x += SIDE) {
            const uint64_t key = sl_random_key((uint64_t)(x - left), tile * (TILE + 2) + (uint64_t)(y - top));
            const sl_path_lamp_view view =
                sl_path_see_lamps(&s->path->lamps.lamps, &s->lens, x, y, SIDE, key, 0, counters);
            all = (sl_path_lamp_view){sl_rgb_add(all.mean, view.mean), fminf(all.low, view.low),
                              fmaxf(all.high, view.high)};
        }
    }
    all.mean = sl_rgb_scale(all.mean, 1.0f / ((TILE / SIDE + 1) * (TILE / SIDE + 1)));
    *(sl_path_lamp_view *)result = all;
}

/* Marks the tiles in which lamps differ by more than what the picture shows of them in the mean. */
static sl_status find_rims(sl_path_tracer *path, const sl_path_lens *lens, sl_counters *counters,
                           sl_error *error) {
    const size_t tiles = tile_count(path);
    const bool some = path->settings.transport.emission &&
                      path->settings.transport.filter != SL_FILTER_CENTRE && !path->pairs;
    rim_search search = {path, *lens};
    path->rims = sl_allocate(tiles, sizeof *path->rims);
    if (!path->rims) return sl_fail_memory(error, "the path tracer");
    if (!some) return SL_OK;
    sl_path_lamp_view *views = sl_allocate_unset(tiles, sizeof *views);
    if (!views) return sl_fail_memory(error, "the path tracer");
    sl_batch_run(&(sl_batch){.count = tiles, .work = look_at_tile, .context = &search, .results = views,
                             .result_bytes = sizeof *views, .shared = true},
                 path->settings.threads, counters);
    double sum = 0.0;
    for (size_t i = 0; i < tiles; i++) sum += (double)sl_luminance(views[i].mean);
    for (size_t i = 0; i < tiles; i++)
        path->rims[i] = (double)views[i].high - (double)views[i].low > sum / (double)tiles;
    sl_free(views);
    return SL_OK;
}

/* ---- tiles ----------------------------------------------------------------------------------- */

static void find_radiance(const sample_pass *pass, size_t task, unsigned worker, bool rim, unsigned count,
                          const sl_path_place *place, const uint64_t *key, sl_rgb *radiance,
                          sl_counters *counters) {
    sl_path_tracer *path = pass->path;
    if (path->pairs) {
        sl_path_pairs_radiance(path->pairs, worker, task, count, place, key, pass->index, radiance, counters);
        return;
    }
    sl_ray16 rays;
    for (unsigned i = 0; i < count; i++) sl_path_lens_ray(path->scene, &pass->lens, place[i], &rays, i);
    sl_path_walk_radiance(rim ? &path->lamps.rest : &path->walk, &rays, count, true, key, pass->index,
                          radiance, counters);
}

/* Lists the pixels of a tile that the picture has; returns how many. */
static unsigned tile_pixels(const sl_path_tracer *path, size_t tile, size_t pixels[TILE * TILE]) {
    const int width = path->settings.width, left = tile_left(path, tile), top = tile_top(path, tile);
    unsigned count = 0;
    for (int i = 0; i < TILE * TILE; i++) {
        const int x = left + i % TILE, y = top + i / TILE;
        if (x < width && y < path->settings.height)
            pixels[count++] = (size_t)y * (size_t)width + (size_t)x;
    }
    return count;
}

static void sample_tile(const sample_pass *pass, size_t task, unsigned worker, size_t tile,
                        sl_rgb sum[TILE * TILE], sl_counters *counters) {
    sl_path_tracer *path = pass->path;
    const size_t width = (size_t)path->settings.width;
    const bool rim = path->rims[tile];
    uint64_t keys[SL_PACKET];
    size_t pixels[SL_PACKET];
    sl_path_place places[SL_PACKET];
    const unsigned count = tile_pixels(path, tile, pixels);
    for (unsigned i = 0; i < count; i++) {
        keys[i] = stream_key(path, pass->half, pixels[i]);
        places[i] = sl_path_place_in(&path->walk, (int)(pixels[i] % width), (int)(pixels[i] / width), keys[i],
                                     pass->index);
    }
    sl_rgb radiance[SL_PACKET];
    find_radiance(pass, task, worker, rim, count, places, keys, radiance, counters);
    sl_count(counters, SL_COUNT_SAMPLES, count);
    for (unsigned i = 0; i < count; i++) {
        const int x = (int)(pixels[i] % width), y = (int)(pixels[i] / width);
        sl_rgb light = sl_path_finite_or_black(radiance[i], counters);
        if (rim) {
            const sl_path_lamp_view lamps = sl_path_see_lamps(&path->lamps.lamps, &pass->lens, x, y, 1.0f,
                                                              keys[i], pass->index, counters);
            light = sl_rgb_add(light, lamps.mean);
        }
        sum[i] = light;
    }
}

static void sample_tiles(void *context, size_t task, unsigned worker, void *result, sl_counters *counters) {
    const sample_pass *pass = context;
    task_light *light = result;
    size_t first = (pass->first_task + task) * TILES_A_TASK, end = first + TILES_A_TASK,
           tiles = tile_count(pass->path);
    for (size_t tile = first; tile < end && tile < tiles; tile++)
        sample_tile(pass, task, worker, tile, light->light[tile - first], counters);
}

/* Adds what tasks have brought, in their order. */
static void commit(const sample_pass *pass, const task_light *light, size_t tasks) {
    const size_t tiles = tile_count(pass->path);
    size_t pixels[SL_PACKET];
    for (size_t k = 0; k < tasks * TILES_A_TASK; k++) {
        const size_t tile = pass->first_task * TILES_A_TASK + k;
        const unsigned count = tile < tiles ? tile_pixels(pass->path, tile, pixels) : 0;
        for (unsigned i = 0; i < count; i++)
            sl_halves_add(&pass->path->halves, pass->half, pixels[i],
                          light[k / TILES_A_TASK].light[k % TILES_A_TASK][i]);
    }
}

sl_status sl_path_tracer_sample(sl_path_tracer *path, uint64_t sample, sl_counters *counters,
                                sl_error *error) {
    if (sample / SL_HALVES > UINT32_MAX) return sl_fail(error, SL_ERROR_USAGE, "too many samples a pixel");
    sample_pass pass = {path, (unsigned)(sample % SL_HALVES), (uint32_t)(sample / SL_HALVES), 0,
                        sl_path_lens_of(path->scene, path->settings.width, path->settings.height)};
    sl_status status = path->rims ? SL_OK : find_rims(path, &pass.lens, counters, error);
    if (status != SL_OK) return status;
    const size_t tasks = (tile_count(path) + TILES_A_TASK - 1) / TILES_A_TASK,
                 at_once = path->pairs ? SL_PAIR_LISTS : TASKS_AT_ONCE;
    task_light *light = sl_allocate_unset(tasks < at_once ? tasks : at_once, sizeof *light);
    if (!light) return sl_fail_memory(error, "the path tracer");
    const sl_batch_plane splats = path->pairs ? sl_path_pairs_counts(path->pairs) : (sl_batch_plane){0};
    for (; status == SL_OK && pass.first_task < tasks; pass.first_task += at_once) {
        const size_t left = tasks - pass.first_task, count = left < at_once ? left : at_once;
        sl_batch_run(&(sl_batch){.count = count, .work = sample_tiles, .context = &pass, .results = light,
                                 .result_bytes = sizeof *light, .shared = true, .planes = &splats,
                                 .plane_count = path->pairs != NULL},
                     path->settings.threads, counters);
        commit(&pass, light, count);
        if (path->pairs && !sl_path_pairs_commit(path->pairs, count, &path->halves, pass.half, counters))
            status = sl_fail_memory(error, "what light subpaths leave on the film");
    }
    sl_free(light);
    if (status != SL_OK) return status;
    path->halves.samples[pass.half]++;
    return SL_OK;
}

/* ---- results --------------------------------------------------------------------------------- */

void sl_path_tracer_mean(const sl_path_tracer *path, int half, float *r, float *g, float *b) {
    sl_halves_mean(&path->halves, half, r, g, b);
}

size_t sl_path_tracer_memory_bytes(const sl_path_tracer *path) {
    return sizeof *path + sl_halves_memory_bytes(&path->halves) + (path->rims ? tile_count(path) : 0) +
           (path->pairs ? sl_path_pairs_memory_bytes(path->pairs) : 0);
}
