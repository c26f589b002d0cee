/* The bidirectional path tracer's film. Pixels go in tiles of 4 x 4, one packet each, with as many light
 * subpaths. What falls on other pixels (t = 1) is kept in lists, a list a task, and added in the order of the
 * tasks: the bits depend on no thread. */
#include <math.h>
#include <string.h>

#include "base/batch.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/random.h"
#include "trace/bidirectional/bidirectional.h"
#include "trace/bidirectional/subpath.h"
#include "trace/halves.h"
#include "trace/path_walk.h"

enum { TILE = 4, TILES_A_TASK = 16, TASKS_AT_ONCE = 64 };

typedef struct splat {
    size_t pixel;
    sl_rgb light;
} splat;

/* Of one task: grows as it needs, and is used again. */
typedef struct splat_list {
    splat *splats;
    size_t count, capacity;
    bool out_of_memory;
} splat_list;

/* Of one worker. */
typedef struct workplace {
    sl_subpath eye[SL_PACKET], light[SL_PACKET];
} workplace;

struct sl_bidirectional {
    const sl_scene *scene;
    sl_bidirectional_settings settings;
    sl_light_sampler *lights;
    sl_sequence sequence;
    sl_path_maker maker;
    sl_halves halves;
    uint64_t stream_seed;
    workplace *workplaces;
    splat_list lists[TASKS_AT_ONCE];
};

/* ---- making ---------------------------------------------------------------------------------- */

void sl_path_maker_init(sl_path_maker *m, const sl_scene *scene, const sl_tracer *tracer,
                        const sl_light_sampler *lights, const sl_sequence *sequence,
                        const sl_transport *transport) {
    enum { ROULETTE_AFTER = 2 };
    *m = (sl_path_maker){
        .scene = scene, .tracer = tracer, .lights = lights, .sequence = sequence, .transport = *transport};
    m->roulette_after = transport->bounces == SL_BOUNCES_UNLIMITED ? ROULETTE_AFTER : UINT32_MAX;
    m->radius = 0.5 * (double)scene->diagonal;
    m->eye_vertices = 1;
}

static sl_status make_film(sl_bidirectional *film, const sl_tracer *tracer, sl_error *error) {
    const sl_bidirectional_settings *s = &film->settings;
    sl_status status = sl_light_sampler_create_for(film->scene, &s->transport, &film->lights, error);
    if (status == SL_OK)
        status = sl_halves_create(&film->halves, (size_t)s->width * (size_t)s->height, error);
    if (status != SL_OK) return status;
    film->workplaces = sl_allocate(s->threads, sizeof *film->workplaces);
    if (!film->workplaces) return sl_fail_memory(error, "the bidirectional path tracer");
    sl_sequence_make(&film->sequence);
    sl_path_maker_init(&film->maker, film->scene, tracer, film->lights, &film->sequence, &s->transport);
    double tangent = sl_tan(0.5 * (double)film->scene->camera.vertical_fov);
    film->maker.tan_x = (float)(tangent * (double)s->width / (double)s->height);
    film->maker.tan_y = (float)tangent;
    film->maker.balance = s->balance;
    film->maker.light_image = s->transport.filter == SL_FILTER_BOX && !s->without_light_image;
    film->maker.direct_image = s->direct_image;
    return SL_OK;
}

sl_status sl_bidirectional_create(const sl_scene *scene, const sl_tracer *tracer,
                                  const sl_bidirectional_settings *settings, sl_bidirectional **out,
                                  sl_error *error) {
    *out = NULL;
    sl_pixel_filter filter = settings->transport.filter;
    if (settings->width <= 0 || settings->height <= 0) {
        return sl_fail(error, SL_ERROR_USAGE, "a film has at least one pixel, not %d x %d", settings->width,
                       settings->height);
    }
    if (filter != SL_FILTER_BOX && filter != SL_FILTER_CENTRE) {
        return sl_fail(error, SL_ERROR_USAGE, "the bidirectional path tracer's filter is box or centre");
    }
    sl_bidirectional *film = sl_allocate(1, sizeof *film);
    if (!film) return sl_fail_memory(error, "the bidirectional path tracer");
    film->scene = scene;
    film->settings = *settings;
    film->settings.threads = sl_thread_count(settings->threads);
    /* not the path tracer's numbers of the same seed */
    film->stream_seed = sl_hash64(settings->seed) ^ 0x42696469u;
    sl_status status = make_film(film, tracer, error);
    if (status != SL_OK) {
        sl_bidirectional_destroy(film);
        return status;
    }
    *out = film;
    return SL_OK;
}

void sl_bidirectional_destroy(sl_bidirectional *film) {
    if (!film) return;
    sl_halves_release(&film->halves);
    for (int i = 0; i < TASKS_AT_ONCE; i++) sl_free(film->lists[i].splats);
    sl_free(film->workplaces);
    sl_light_sampler_destroy(film->lights);
    sl_free(film);
}

/* ---- splats ---------------------------------------------------------------------------------- */

static void keep_splat(splat_list *list, size_t pixel, sl_rgb light) {
    if (list->count == list->capacity) {
        size_t capacity = 2 * list->capacity + 256;
        splat *longer = sl_allocate(capacity, sizeof *longer);
        if (!longer) {
            list->out_of_memory = true;
            return;
        }
        if (list->count > 0) memcpy(longer, list->splats, list->count * sizeof *longer);
        sl_free(list->splats);
        list->splats = longer;
        list->capacity = capacity;
    }
    list->splats[list->count++] = (splat){pixel, light};
}

/* ---- one packet ------------------------------------------------------------------------------ */

typedef struct sample_pass {
    sl_bidirectional *film;
    unsigned half;
    uint32_t index;    /* of the half's points */
    size_t first_task; /* of those at once */
} sample_pass;

typedef struct packet {
    const sl_bidirectional *film;
    sl_rgb radiance[SL_PACKET];
    splat_list *list;
    sl_counters *counters;
} packet;

static void receive(void *context, unsigned lane, unsigned s, unsigned t, double x, double y, sl_rgb radiance,
                    double weight) {
    packet *p = context;
    (void)s;
    sl_rgb light = sl_rgb_scale(radiance, (float)weight);
    if (!sl_rgb_is_finite(light)) {
        sl_count(p->counters, SL_COUNT_NONFINITE, 1);
    } else if (t > 1) {
        p->radiance[lane] = sl_rgb_add(p->radiance[lane], light);
    } else {
        int width = p->film->settings.width, height = p->film->settings.height;
        size_t column = (size_t)(x * (double)width), row = (size_t)(y * (double)height);
        if (column < (size_t)width && row < (size_t)height)
            keep_splat(p->list, row * (size_t)width + column, light);
    }
}

static sl_vec3 camera_ray(const sample_pass *pass, int x, int y, uint64_t key, double *pdf) {
    const sl_path_maker *m = &pass->film->maker;
    const sl_camera *c = &m->scene->camera;
    float point[3] = {0.5f, 0.5f, 0.0f};
    if (m->transport.filter == SL_FILTER_BOX)
        sl_sequence_point(m->sequence, key, SL_SET_PIXEL, pass->index, point);
    float u = (2.0f * ((float)x + point[0]) / (float)pass->film->settings.width - 1.0f) * m->tan_x;
    float v = (1.0f - 2.0f * ((float)y + point[1]) / (float)pass->film->settings.height) * m->tan_y;
    *pdf = sl_camera_pdf(m, 1.0 / sqrt(1.0 + (double)u * (double)u + (double)v * (double)v));
    return sl_normalize_or(sl_sub(sl_mad(sl_scale(c->right, u), v, c->up), c->back), sl_neg(c->back));
}

static void sample_tile(const sample_pass *pass, size_t tile, workplace *place, splat_list *list,
                        sl_counters *counters) {
    const sl_bidirectional *film = pass->film;
    int width = film->settings.width, height = film->settings.height;
    int across = (width + TILE - 1) / TILE, left = (int)(tile % (size_t)across) * TILE,
        top = (int)(tile / (size_t)across) * TILE;
    sl_vec3 direction[SL_PACKET];
    double pdf[SL_PACKET];
    uint64_t keys[SL_PACKET];
    uint32_t indices[SL_PACKET];
    size_t pixels[SL_PACKET];
    sl_subpath *eye[SL_PACKET], *light[SL_PACKET];
    const sl_path_vertex *light_vertices[SL_PACKET];
    unsigned light_count[SL_PACKET], count = 0;
    for (int i = 0; i < SL_PACKET; i++) {
        int x = left + i % TILE, y = top + i / TILE;
        if (x >= width || y >= height) continue;
        pixels[count] = (size_t)y * (size_t)width + (size_t)x;
        keys[count] = sl_random_key(film->stream_seed, 2 * (uint64_t)pixels[count] + pass->half);
        indices[count] = pass->index;
        direction[count] = camera_ray(pass, x, y, keys[count], &pdf[count]);
        eye[count] = &place->eye[count];
        light[count] = &place->light[count];
        count++;
    }
    packet p = {.film = film, .list = list, .counters = counters};
    sl_walk_from_lights(&film->maker, count, keys, indices, light, counters);
    sl_walk_from_eye(&film->maker, count, film->scene->camera.eye, direction, pdf, keys, indices, eye,
                     counters);
    for (unsigned i = 0; i < count; i++) {
        light_vertices[i] = light[i]->vertex;
        light_count[i] = light[i]->count;
    }
    const sl_path_receiver receiver = {&p, receive};
    sl_connect_all(&film->maker, count, eye, light_vertices, light_count, keys, indices, &receiver, counters);
    sl_count(counters, SL_COUNT_SAMPLES, count);
    for (unsigned i = 0; i < count; i++) sl_halves_add(&film->halves, pass->half, pixels[i], p.radiance[i]);
}

/* ---- one sample of every pixel --------------------------------------------------------------- */

static size_t tile_count(const sl_bidirectional *film) {
    size_t across = ((size_t)film->settings.width + TILE - 1) / TILE,
           down = ((size_t)film->settings.height + TILE - 1) / TILE;
    return across * down;
}

static void sample_tiles(void *context, size_t task, unsigned worker, void *result, sl_counters *counters) {
    (void)result;
    const sample_pass *pass = context;
    splat_list *list = &pass->film->lists[task];
    size_t first = (pass->first_task + task) * TILES_A_TASK, end = first + TILES_A_TASK,
           tiles = tile_count(pass->film);
    list->count = 0;
    for (size_t tile = first; tile < end && tile < tiles; tile++) {
        sample_tile(pass, tile, &pass->film->workplaces[worker], list, counters);
    }
}

/* Each of a pass's light subpaths stands for one sample of the whole film: a pixel, which is one part in W H
 * of it, collects from W H subpaths, and the two numbers cancel. */
static bool add_splats(const sample_pass *pass, size_t tasks) {
    bool complete = true;
    for (size_t i = 0; i < tasks; i++) {
        splat_list *list = &pass->film->lists[i];
        for (size_t k = 0; k < list->count; k++) {
            sl_halves_add(&pass->film->halves, pass->half, list->splats[k].pixel, list->splats[k].light);
        }
        complete &= !list->out_of_memory;
        list->out_of_memory = false;
    }
    return complete;
}

sl_status sl_bidirectional_sample(sl_bidirectional *film, uint64_t sample, sl_counters *counters,
                                  sl_error *error) {
    if (sample / SL_HALVES > UINT32_MAX) return sl_fail(error, SL_ERROR_USAGE, "too many samples a pixel");
    sample_pass pass = {film, (unsigned)(sample % SL_HALVES), (uint32_t)(sample / SL_HALVES), 0};
    size_t tasks = (tile_count(film) + TILES_A_TASK - 1) / TILES_A_TASK;
    bool complete = true;
    for (; pass.first_task < tasks && complete; pass.first_task += TASKS_AT_ONCE) {
        size_t now = tasks - pass.first_task < TASKS_AT_ONCE ? tasks - pass.first_task : TASKS_AT_ONCE;
        sl_batch_run(&(sl_batch){.count = now, .work = sample_tiles, .context = &pass},
                     film->settings.threads, counters);
        complete = add_splats(&pass, now);
    }
    if (!complete) return sl_fail_memory(error, "what light subpaths leave on the film");
    film->halves.samples[pass.half]++;
    return SL_OK;
}

/* ---- results --------------------------------------------------------------------------------- */

void sl_bidirectional_mean(const sl_bidirectional *film, int half, float *r, float *g, float *b) {
    sl_halves_mean(&film->halves, half, r, g, b);
}

size_t sl_bidirectional_memory_bytes(const sl_bidirectional *film) {
    size_t bytes = sizeof *film + film->settings.threads * sizeof *film->workplaces +
                   sl_halves_memory_bytes(&film->halves);
    for (int i = 0; i < TASKS_AT_ONCE; i++) bytes += film->lists[i].capacity * sizeof(splat);
    return bytes;
}
