/* A value depends on the pixel and the number of its samples alone, never on what else was traced, before or
 * beside it. */
#include "cache/audit/trace_probes.h"

#include "base/batch.h"
#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/random.h"

#include <string.h>

enum { PILOT = SL_HALVES, PILOT_PLACE, STREAMS, PILOTS_MAX = 1 << 17 };

sl_status sl_probe_tracer_create(sl_probe_tracer *t, const sl_scene *scene, const sl_transport *transport,
                                 int width, int height, unsigned threads, uint64_t seed, sl_error *error) {
    *t = (sl_probe_tracer){.scene = scene,
                           .threads = sl_thread_count(threads),
                           .seed = seed,
                           .pixels = (size_t)width * (size_t)height,
                           .lens = sl_path_lens_of(scene, width, height)};
    do {
        t->block++;
        t->across = (width + t->block - 1) / t->block;
        t->blocks = (size_t)t->across * (size_t)((height + t->block - 1) / t->block);
    } while (t->blocks > PILOTS_MAX);
    t->slot = sl_allocate_unset(t->pixels, sizeof *t->slot);
    if (!t->slot) return sl_fail_memory(error, "error probes");
    memset(t->slot, 0xff, t->pixels * sizeof *t->slot);
    sl_status status = sl_tracer_create(scene, t->threads, NULL, &t->tracer, error);
    if (status == SL_OK) status = sl_light_sampler_create_for(scene, transport, &t->lights, error);
    sl_sequence_make(&t->sequence);
    t->walk = (sl_path_walk){scene, t->tracer, t->lights, &t->sequence, *transport,
                             sl_pixel_shape_of(transport->filter, transport->filter_radius)};
    t->lamps = sl_path_lamps_of(&t->walk);
    if (status == SL_OK) status = sl_audit_surfaces(&t->walk, &t->lens, t->threads, &t->surfaces, error);
    return status;
}

void sl_probe_tracer_release(sl_probe_tracer *t) {
    sl_light_sampler_destroy(t->lights);
    sl_tracer_destroy(t->tracer);
    sl_image_destroy(t->surfaces);
    SL_FREE_ALL(t->pilot, t->slot, t->probe);
    *t = (sl_probe_tracer){0};
}

/* Pixels that show lamps: their view of them is taken apart, so that it does not drown the rest in noise. */
static bool shows_lamps(const sl_probe_tracer *t, uint32_t pixel) {
    return t->surfaces && !(t->surfaces->planes[pixel] > 0.5f) &&
           t->walk.transport.filter != SL_FILTER_CENTRE;
}

/* Traces sample `index` of those of up to sixteen pixels that show lamps, or of the others. */
static void trace_those(const sl_probe_tracer *t, const uint32_t *pixels, unsigned count, bool lamps,
                        unsigned stream, uint32_t index, sl_rgb radiance[SL_PACKET], sl_counters *counters) {
    sl_ray16 rays;
    uint64_t keys[SL_PACKET] = {0};
    unsigned which[SL_PACKET], found = 0;
    sl_rgb light[SL_PACKET];
    rays.skip[0] = SL_NO_INDEX;
    for (unsigned i = 0; i < count; i++) {
        if (shows_lamps(t, pixels[i]) != lamps) continue;
        int x = (int)(pixels[i] % (uint32_t)t->lens.width), y = (int)(pixels[i] / (uint32_t)t->lens.width);
        keys[found] = sl_random_key(t->seed, (uint64_t)STREAMS * pixels[i] + stream);
        sl_path_place place = sl_path_place_in(&t->walk, x, y, keys[found], index);
        sl_path_lens_ray(t->scene, &t->lens, place, &rays, found);
        radiance[i] = lamps ? sl_path_see_lamps(&t->lamps.lamps, &t->lens, x, y, 1.0f, keys[found], index,
                                                counters).mean
                            : sl_grey(0.0f);
        which[found++] = i;
    }
    if (!found) return;
    sl_path_walk_radiance(lamps ? &t->lamps.rest : &t->walk, &rays, found, false, keys, index, light,
                          counters);
    for (unsigned k = 0; k < found; k++) {
        sl_rgb *r = &radiance[which[k]];
        *r = sl_rgb_add(*r, sl_path_finite_or_black(light[k], counters));
    }
}

/* Sample `index` of up to sixteen pixels. */
static void trace_packet(const sl_probe_tracer *t, const uint32_t *pixels, unsigned count, unsigned stream,
                         uint32_t index, sl_rgb radiance[SL_PACKET], sl_counters *counters) {
    trace_those(t, pixels, count, false, stream, index, radiance, counters);
    trace_those(t, pixels, count, true, stream, index, radiance, counters);
    sl_count(counters, SL_COUNT_SAMPLES, count);
}

/* A packet is a task. */
static void for_packets(sl_probe_tracer *t, size_t count, sl_batch_work *work, void *context) {
    const sl_batch batch = {.count = (count + SL_PACKET - 1) / SL_PACKET, .work = work, .context = context};
    sl_batch_run(&batch, t->threads, &t->counters);
}

static unsigned packet_size(size_t first, size_t end) {
    return end - first < SL_PACKET ? (unsigned)(end - first) : SL_PACKET;
}

/* ---- the pilot ---- */

/* Somewhere in the block, as far as it lies in the picture. */
static uint32_t pilot_pixel(const sl_probe_tracer *t, size_t block) {
    int left = (int)(block % (size_t)t->across) * t->block, top = (int)(block / (size_t)t->across) * t->block;
    int wide = t->lens.width - left < t->block ? t->lens.width - left : t->block;
    int high = t->lens.height - top < t->block ? t->lens.height - top : t->block;
    uint32_t place = sl_random_bits(sl_random_key(t->seed, PILOT_PLACE), block) % (uint32_t)(wide * high);
    return (uint32_t)((top + (int)place / wide) * t->lens.width + left + (int)place % wide);
}

static void pilot_task(void *context, size_t task, unsigned worker, void *result, sl_counters *counters) {
    (void)worker, (void)result;
    sl_probe_tracer *t = context;
    const size_t first = task * SL_PACKET;
    const unsigned count = packet_size(first, t->blocks);
    uint32_t pixels[SL_PACKET] = {0};
    sl_rgb radiance[SL_PACKET];
    for (unsigned i = 0; i < count; i++) pixels[i] = pilot_pixel(t, first + i);
    trace_packet(t, pixels, count, PILOT, 0, radiance, counters);
    for (unsigned i = 0; i < count; i++) {
        t->pilot[first + i] = radiance[i].r;
        t->pilot[t->blocks + first + i] = radiance[i].g;
        t->pilot[2 * t->blocks + first + i] = radiance[i].b;
    }
}

sl_status sl_probe_tracer_pilot(sl_probe_tracer *t, sl_error *error) {
    if (t->pilot) return SL_OK;
    t->pilot = sl_allocate_unset(3 * t->blocks, sizeof *t->pilot);
    if (!t->pilot) return sl_fail_memory(error, "error probes");
    for_packets(t, t->blocks, pilot_task, t);
    return SL_OK;
}

/* ---- probes ---- */

typedef struct stretch { /* samples [first, end) of each half, for some slots */
    sl_probe_tracer *t;
    const uint32_t *slots;
    size_t count;
    uint32_t first, end;
} stretch;

static void stretch_task(void *context, size_t task, unsigned worker, void *result, sl_counters *counters) {
    (void)worker, (void)result;
    const stretch *s = context;
    const uint32_t *slots = s->slots + task * SL_PACKET;
    const unsigned count = packet_size(task * SL_PACKET, s->count);
    uint32_t pixels[SL_PACKET] = {0};
    sl_rgb radiance[SL_PACKET];
    for (unsigned i = 0; i < count; i++) pixels[i] = s->t->probe[slots[i]].pixel;
    for (unsigned half = 0; half < SL_HALVES; half++) {
        for (uint32_t index = s->first; index < s->end; index++) {
            trace_packet(s->t, pixels, count, half, index, radiance, counters);
            for (unsigned i = 0; i < count; i++)
                sl_sum_colour(s->t->probe[slots[i]].sum[half], 1.0, radiance[i]);
        }
    }
}

/* Those that have the fewest samples first, up to where the next have, and so on: all of a packet trace the
 * same ones. */
static void catch_up(sl_probe_tracer *t, const uint32_t *pixels, size_t count, uint32_t samples,
                     uint32_t *list) {
    for (;;) {
        stretch s = {t, list, 0, samples, samples};
        for (size_t i = 0; i < count; i++) {
            uint32_t has = t->probe[t->slot[pixels[i]]].samples;
            if (has < s.first) s.first = has;
        }
        if (s.first >= samples) return;
        for (size_t i = 0; i < count; i++) {
            uint32_t slot = t->slot[pixels[i]], has = t->probe[slot].samples;
            if (has == s.first) list[s.count++] = slot;
            else if (has < s.end) s.end = has;
        }
        for_packets(t, s.count, stretch_task, &s);
        for (size_t i = 0; i < s.count; i++) t->probe[list[i]].samples = s.end;
    }
}

sl_status sl_probe_tracer_trace(sl_probe_tracer *t, const uint32_t *pixels, size_t count, uint32_t samples,
                                sl_error *error) {
    size_t fresh = 0;
    for (size_t i = 0; i < count; i++) fresh += t->slot[pixels[i]] == SL_NO_INDEX;
    if (t->slots + fresh > t->capacity) {
        if (!sl_regrow(&t->probe, t->slots, t->slots + fresh, sizeof *t->probe))
            return sl_fail_memory(error, "error probes");
        t->capacity = t->slots + fresh;
    }
    uint32_t *list = sl_allocate(count, sizeof *list);
    if (!list) return sl_fail_memory(error, "error probes");
    for (size_t i = 0; i < count; i++) {
        if (t->slot[pixels[i]] != SL_NO_INDEX) continue;
        t->slot[pixels[i]] = (uint32_t)t->slots;
        t->probe[t->slots++].pixel = pixels[i];
    }
    catch_up(t, pixels, count, samples, list);
    sl_free(list);
    return SL_OK;
}

double sl_probe_tracer_missing(const sl_probe_tracer *t, const uint32_t *pixels, size_t count,
                               uint32_t samples) {
    double missing = 0.0;
    for (size_t i = 0; i < count; i++) {
        uint32_t slot = t->slot[pixels[i]], has = slot == SL_NO_INDEX ? 0 : t->probe[slot].samples;
        if (has < samples) missing += SL_HALVES * (double)(samples - has);
    }
    return missing;
}

void sl_probe_tracer_means(const sl_probe_tracer *t, uint32_t pixel, double p[3], double q[3]) {
    const sl_probe *probe = &t->probe[t->slot[pixel]];
    const double scale = probe->samples ? 1.0 / (double)probe->samples : 0.0;
    for (int c = 0; c < 3; c++) {
        p[c] = scale * probe->sum[0][c];
        q[c] = scale * probe->sum[1][c];
    }
}
