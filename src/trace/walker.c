#include "trace/walker.h"

#include <math.h>

#include "base/random.h"

void sl_walker_draw(const sl_sequence *sequence, const sl_walker *w, uint32_t set, float point[3]) {
    sl_sequence_point(sequence, w->key, set + SL_SETS_A_VERTEX * w->vertex, w->index, point);
}

bool sl_walker_survives(const sl_sequence *sequence, sl_walker *w) {
    float weight = fmaxf(sl_rgb_max(w->weight), sl_rgb_max(w->direct_weight)) * w->roulette_scale;
    float chance = fminf(fmaxf(weight, 0.05f), 0.95f), point[3];
    sl_walker_draw(sequence, w, SL_SET_ROULETTE, point);
    if (!(point[0] < chance)) return false;
    w->weight = sl_rgb_scale(w->weight, 1.0f / chance);
    w->direct_weight = sl_rgb_scale(w->direct_weight, 1.0f / chance);
    return true;
}

void sl_walker_leave(sl_walker *w, sl_vec3 origin, sl_vec3 direction, double pdf, uint32_t triangle) {
    w->origin = origin;
    w->direction = direction;
    w->near = 0.0f;
    w->far = INFINITY;
    w->skip = triangle;
    w->pdf = pdf;
    w->parallel = false;
    w->vertex++;
}

/* ---- what rays meet -------------------------------------------------------------------------- */

static void put_ray(sl_ray16 *rays, unsigned i, const sl_walker *w) {
    sl_ray16_set(rays, i, w->origin, w->direction, w->near, w->far, w->skip);
}

/* Where nothing hides anything, every surface on the ray sends its light to the ray's start. One of the n is
 * taken, each with probability 1/n. All ways in which a path may be made have this ray in their walk from the
 * eye, so 1/n is in all their densities, and none need have it. */
static void choose_along_ray(const sl_tracer *tracer, const sl_sequence *sequence, sl_walker *w,
                             unsigned lane, sl_hit16 *hits, sl_counters *counters) {
    sl_ray16 ray;
    sl_hit16 hit;
    float point[3];
    sl_walker_draw(sequence, w, SL_SET_THROUGH - SL_SETS_A_VERTEX, point); /* of the vertex that was left */
    const uint64_t key = sl_random_key(w->key, (uint64_t)(point[0] * 0x1p24f));
    uint32_t met = 0;
    hits->triangle[lane] = SL_NO_INDEX;
    put_ray(&ray, 0, w);
    for (;; ray.near[0] = hit.t[0], ray.skip[0] = hit.triangle[0]) {
        sl_trace(tracer, &ray, 1, false, &hit, counters);
        if (hit.triangle[0] == SL_NO_INDEX) break;
        met++;
        if (!(sl_random_unit(key, met) * (float)met < 1.0f)) continue;
        hits->t[lane] = hit.t[0], hits->triangle[lane] = hit.triangle[0];
        hits->w1[lane] = hit.w1[0], hits->w2[lane] = hit.w2[0];
    }
    w->weight = sl_rgb_scale(w->weight, (float)met);
    w->through = false;
}

void sl_walkers_trace(const sl_tracer *tracer, const sl_sequence *sequence, sl_walker *const *active,
                      unsigned count, bool coherent, sl_hit16 *hits, sl_counters *counters) {
    sl_ray16 rays;
    bool through = false;
    unsigned i = 0;
    do {
        put_ray(&rays, i, active[i]);
        through |= active[i]->through;
    } while (++i < count);
    sl_trace(tracer, &rays, count, coherent, hits, counters);
    for (i = 0; i < count && through; i++)
        if (active[i]->through) choose_along_ray(tracer, sequence, active[i], i, hits, counters);
}
