#include "base/counters.h"
#include "cache/light/shadow_internal.h"

#include <string.h>

static bool any(const float *values, size_t count) {
    bool found = false;
    for (size_t i = 0; i < count; i++) found |= values[i] > 0.0f;
    return found;
}

/* False: nothing arrives anywhere in the block, shadows aside. */
static bool look_up(const sl_shadow_maps *maps, const sl_mapped_source *s, const sl_light_points *points,
                    sl_arrivals *arrivals, float *lit, sl_counters *counters) {
    maps->kernels.arrive(points, &s->source, arrivals);
    if (!any(arrivals->weight, points->count)) return false;
    for (size_t i = 0; i < points->count; i++) lit[i] = 1.0f;
    maps->kernels.lit(points, &s->cube, lit);
    sl_count(counters, SL_COUNT_SHADOW_LOOKUPS, points->count);
    return true;
}

void sl_shadow_maps_each(const sl_shadow_maps *maps, const sl_light_points *points, unsigned parts,
                         sl_shadow_map_visitor *visit, void *context, sl_counters *counters) {
    sl_arrivals arrivals;
    float lit[SL_LIGHT_BLOCK];
    for (size_t i = 0; i < maps->source_count; i++) {
        const sl_mapped_source *s = &maps->sources[i];
        if ((s->part & parts) && look_up(maps, s, points, &arrivals, lit, counters))
            visit(context, &arrivals, lit, s->source.colour);
    }
}

/* ---- emitters: the exact irradiance of the whole times the share of the samples that is visible ---- */

typedef struct {
    float seen[SL_LIGHT_BLOCK], all[SL_LIGHT_BLOCK]; /* sums of weights */
} shares;

/* Nowhere a part of the samples alone. */
static bool all_agree(const shares *s, size_t count) {
    bool agree = true;
    for (size_t i = 0; i < count; i++) agree &= s->seen[i] == 0.0f || s->seen[i] == s->all[i];
    return agree;
}

/* Where the first quarter of the samples says the same in the whole block, the others would too: of a block
 * of a picture, 128 pixels side by side, the penumbrae alone need all. */
static void share_of_samples(const sl_shadow_maps *maps, const sl_mapped_emitter *e,
                             const sl_light_points *points, unsigned parts, shares *s,
                             sl_counters *counters) {
    sl_arrivals arrivals;
    float lit[SL_LIGHT_BLOCK];
    size_t pilot = e->count / 4 > 4 ? e->count / 4 : 4;
    memset(s, 0, sizeof *s);
    for (size_t k = 0; k < e->count; k++) {
        if (k == pilot && ((parts & SL_MAPPED_FEW) || all_agree(s, points->count))) return;
        if (!look_up(maps, &maps->sources[e->first + k], points, &arrivals, lit, counters)) continue;
        for (size_t i = 0; i < points->count; i++) {
            s->all[i] += arrivals.weight[i];
            s->seen[i] += arrivals.weight[i] * lit[i];
        }
    }
}

static void add_emitter(const sl_shadow_maps *maps, const sl_mapped_emitter *e, const sl_light_points *points,
                        unsigned parts, float *r, float *g, float *b, sl_counters *counters) {
    float exact[SL_LIGHT_BLOCK];
    shares s;
    maps->kernels.polygon(points, &e->polygon, exact);
    if (!any(exact, points->count)) return;
    share_of_samples(maps, e, points, parts, &s, counters);
    for (size_t i = 0; i < points->count; i++) s.seen[i] = s.all[i] > 0.0f ? s.seen[i] / s.all[i] : 0.0f;
    maps->kernels.accumulate(points->count, e->radiance, exact, s.seen, r, g, b);
}

void sl_shadow_maps_irradiance(const sl_shadow_maps *maps, const sl_light_points *points, unsigned parts,
                               float *r, float *g, float *b, sl_counters *counters) {
    sl_arrivals arrivals;
    float lit[SL_LIGHT_BLOCK];
    for (size_t i = 0; i < maps->plain_count; i++) {
        const sl_mapped_source *s = &maps->sources[i];
        if (!(s->part & parts) || !look_up(maps, s, points, &arrivals, lit, counters)) continue;
        maps->kernels.accumulate(points->count, s->source.colour, arrivals.weight, lit, r, g, b);
    }
    for (size_t i = 0; i < maps->emitter_count && (parts & SL_MAPPED_LIGHTS); i++)
        add_emitter(maps, &maps->emitters[i], points, parts, r, g, b, counters);
}
