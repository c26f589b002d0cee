/* Pairs of an eye and a light subpath, one for each pixel of a packet. What falls on other pixels (t = 1) is
 * kept in lists, a list a task, and added in the order of the tasks: the bits depend on no thread. */
#include <math.h>
#include <string.h>

#include "base/batch.h"
#include "base/counters.h"
#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"
#include "trace/bidirectional/bidirectional.h"
#include "trace/bidirectional/subpath.h"

typedef struct splat {
    size_t pixel;
    sl_rgb light;
} splat;

/* Of one task: grows as it needs, and is used again. */
typedef struct splat_list {
    splat *splats;
    size_t capacity;
} splat_list;

typedef struct splat_count {
    size_t splats;
    bool out_of_memory;
} splat_count;

/* Of one worker. */
typedef struct workplace {
    sl_subpath eye[SL_PACKET], light[SL_PACKET];
} workplace;

struct sl_path_pairs {
    sl_path_lens lens;
    sl_path_maker maker;
    unsigned workers;
    workplace *workplaces;
    splat_list lists[SL_PAIR_LISTS];
    splat_count count[SL_PAIR_LISTS];
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

sl_status sl_path_pairs_create(const sl_path_walk *walk, const sl_path_lens *lens, unsigned workers,
                               sl_path_pairs **out, sl_error *error) {
    *out = NULL;
    sl_path_pairs *pairs = sl_allocate(1, sizeof *pairs);
    if (pairs) pairs->workplaces = sl_allocate(workers, sizeof *pairs->workplaces);
    if (!pairs || !pairs->workplaces) {
        sl_free(pairs);
        return sl_fail_memory(error, "the bidirectional path tracer");
    }
    pairs->lens = *lens;
    pairs->workers = workers;
    sl_path_maker_init(&pairs->maker, walk->scene, walk->tracer, walk->lights, walk->sequence,
                       &walk->transport);
    pairs->maker.tan_x = lens->tan_x;
    pairs->maker.tan_y = lens->tan_y;
    pairs->maker.light_image = walk->transport.filter == SL_FILTER_BOX;
    *out = pairs;
    return SL_OK;
}

void sl_path_pairs_destroy(sl_path_pairs *pairs) {
    if (!pairs) return;
    for (int i = 0; i < SL_PAIR_LISTS; i++) sl_free(pairs->lists[i].splats);
    SL_FREE_ALL(pairs->workplaces, pairs);
}

size_t sl_path_pairs_memory_bytes(const sl_path_pairs *pairs) {
    size_t bytes = sizeof *pairs + pairs->workers * sizeof *pairs->workplaces;
    for (int i = 0; i < SL_PAIR_LISTS; i++) bytes += pairs->lists[i].capacity * sizeof(splat);
    return bytes;
}

/* ---- one packet ------------------------------------------------------------------------------ */

typedef struct packet {
    const sl_path_lens *lens;
    sl_rgb *radiance;
    splat_list *list;
    splat_count *count;
    sl_counters *counters;
} packet;

static void keep_splat(splat_list *list, splat_count *count, size_t pixel, sl_rgb light) {
    if (sl_make_room(&list->splats, count->splats, &list->capacity, sizeof *list->splats))
        list->splats[count->splats++] = (splat){pixel, light};
    else count->out_of_memory = true;
}

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
        const size_t width = (size_t)p->lens->width, height = (size_t)p->lens->height;
        size_t column = (size_t)(x * (double)width), row = (size_t)(y * (double)height);
        if (column < width && row < height) keep_splat(p->list, p->count, row * width + column, light);
    }
}

void sl_path_pairs_radiance(sl_path_pairs *pairs, unsigned worker, size_t list, unsigned count,
                            const sl_path_place *place, const uint64_t *key, uint32_t index,
                            sl_rgb *radiance, sl_counters *counters) {
    const sl_path_maker *m = &pairs->maker;
    workplace *w = &pairs->workplaces[worker];
    sl_vec3 direction[SL_PACKET];
    double pdf[SL_PACKET];
    uint32_t indices[SL_PACKET] = {0};
    sl_subpath *eye[SL_PACKET] = {NULL}, *light[SL_PACKET] = {NULL};
    const sl_path_vertex *light_vertices[SL_PACKET];
    unsigned light_count[SL_PACKET];
    for (unsigned i = 0; i < count; i++) {
        sl_path_tangents at = sl_path_lens_tangents(&pairs->lens, place[i]);
        direction[i] = sl_path_lens_direction(m->scene, at);
        double squared = 1.0 + (double)at.x * (double)at.x + (double)at.y * (double)at.y;
        pdf[i] = sl_camera_pdf(m, 1.0 / sqrt(squared));
        indices[i] = index;
        eye[i] = &w->eye[i];
        light[i] = &w->light[i];
        radiance[i] = sl_grey(0.0f);
    }
    sl_walk_from_lights(m, count, key, indices, light, counters);
    sl_walk_from_eye(m, count, m->scene->camera.eye, direction, pdf, key, indices, eye, counters);
    for (unsigned i = 0; i < count; i++) {
        light_vertices[i] = light[i]->vertex;
        light_count[i] = light[i]->count;
    }
    packet p = {&pairs->lens, radiance, &pairs->lists[list], &pairs->count[list], counters};
    const sl_path_receiver receiver = {&p, receive};
    sl_connect_all(m, count, eye, light_vertices, light_count, key, indices, &receiver, counters);
}

/* ---- what has fallen elsewhere --------------------------------------------------------------- */

sl_batch_plane sl_path_pairs_counts(sl_path_pairs *pairs) {
    return (sl_batch_plane){pairs->count, sizeof *pairs->count};
}

static void copy_splats(void *context, size_t index, unsigned worker, void *result, sl_counters *counters) {
    (void)worker, (void)counters;
    const sl_path_pairs *pairs = context;
    const size_t count = pairs->count[index].splats;
    if (count > 0) memcpy(result, pairs->lists[index].splats, count * sizeof(splat));
}

/* Returns the splats of all lists, those of list i from i * *most on; NULL: there is no memory for some. */
static splat *splats_of(sl_path_pairs *pairs, size_t lists, size_t *most, sl_counters *counters) {
    *most = 0;
    for (size_t i = 0; i < lists; i++) {
        if (pairs->count[i].out_of_memory) return NULL;
        *most = pairs->count[i].splats > *most ? pairs->count[i].splats : *most;
    }
    splat *splats = sl_allocate_unset(lists * *most, sizeof *splats);
    const sl_batch batch = {.count = lists, .work = copy_splats, .context = pairs, .results = splats,
                            .result_bytes = *most * sizeof *splats, .shared = true};
    if (splats) sl_batch_run(&batch, 1, counters);
    return splats;
}

/* Each light subpath stands for one sample of the whole film: a pixel, which is one part in W H of it,
 * collects from W H subpaths, and the two numbers cancel. */
bool sl_path_pairs_commit(sl_path_pairs *pairs, size_t lists, const sl_halves *halves, unsigned half,
                          sl_counters *counters) {
    size_t most;
    splat *splats = splats_of(pairs, lists, &most, counters);
    for (size_t i = 0; splats && i < lists; i++)
        for (size_t k = i * most; k < i * most + pairs->count[i].splats; k++)
            sl_halves_add(halves, half, splats[k].pixel, splats[k].light);
    memset(pairs->count, 0, sizeof pairs->count);
    sl_free(splats);
    return splats != NULL;
}
