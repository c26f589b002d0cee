/* More rays where radiance varies. One ray a cell errs by the spread of the radiance inside its cell; hot
 * spots beside lamps, patches of sun and lit edges fill few cells and make most of a gather's error. So a
 * share of rays more goes where the neighbours of a cell differ most, by what is known before any light
 * sample is drawn: albedo times expected light, and light that came without samples.
 *
 * A cell's own ray has no say in how many more it gets, only those around it: then the number does not depend
 * on the value, and the mean of all rays of the cell stays unbiased (rays chosen by their own values would
 * not: Kirk and Arvo 1991, "Unbiased sampling techniques for image synthesis"). Numbers are in proportion to
 * the spread, as is best for strata of equal weight (Neyman 1934). */
#include "base/math.h"
#include "base/random.h"
#include "cache/hemisphere/hit_light.h"

#include <math.h>

enum { MORE_MAX = 15 }; /* a cell */

/* ---- what is known of a cell ---- */

static void estimate_radiance(const sl_gather_view *view, float *radiance) {
    const sl_gather_scratch *s = view->scratch;
    const sl_gather_hits *h = &s->hits;
    const sl_gather *g = view->gather;
    bool sampled = g->sources > 0,
         emission = g->settings.emission || g->settings.background || g->mirrors;
    float scale = sampled ? g->unit : 0.0f;
    const float *told = s->onward.told;
    for (size_t k = 0; k < g->tables->used; k++) {
        float light = sampled ? s->light->expected[k] * scale : 0.0f;
        float sum = h->diffuse_r[k] * (h->irradiance_r[k] + light) +
                    h->diffuse_g[k] * (h->irradiance_g[k] + light) +
                    h->diffuse_b[k] * (h->irradiance_b[k] + light);
        if (told) sum += told[k];
        float seen = emission ? sl_rgb_mean(sl_gather_emission(view, k)) : 0.0f;
        float l = sum * (float)(1.0 / (3.0 * SL_PI)) + seen;
        radiance[s->slot_cell[k]] = l > 0.0f && isfinite(l) ? l : 0.0f;
    }
}

/* Only ratios count, and squares of radiance may leave what floats hold: a power of two, which changes no
 * digit, brings the greatest into [0.5, 1). */
static void bring_near_one(const sl_gather_view *view, float *radiance) {
    const sl_gather_scratch *s = view->scratch;
    const sl_gather_tables *t = view->gather->tables;
    float greatest = 0.0f;
    int exponent = 0;
    for (size_t k = 0; k < t->used; k++)
        greatest = radiance[s->slot_cell[k]] > greatest ? radiance[s->slot_cell[k]] : greatest;
    if (!(greatest > 0.0f)) return;
    (void)frexpf(greatest, &exponent);
    for (size_t k = 0; k < t->used; k++)
        radiance[s->slot_cell[k]] = ldexpf(radiance[s->slot_cell[k]], -exponent);
}

/* ---- how many where ---- */

/* Sets how far the best numbers of rays, in proportion to the spread, are above one; all at most `budget`.
 * By slot. */
static double share_rays(const sl_gather_tables *t, const float *spread, double budget, float *more) {
    double sum = 0.0, wanted = 0.0;
    for (size_t k = 0; k < t->used; k++) sum += (double)spread[t->order[k]];
    if (!(sum > 0.0)) return 0.0;
    double scale = (budget + (double)t->used) / sum;
    for (size_t k = 0; k < t->used; k++) {
        double n = scale * (double)spread[t->order[k]] - 1.0;
        n = n > 0.0 ? n < MORE_MAX ? n : MORE_MAX : 0.0;
        more[k] = (float)n;
        wanted += n;
    }
    return wanted > 0.0 ? (wanted > budget ? budget / wanted : 1.0) : 0.0;
}

/* New slots, in the order of the cells; systematic sampling rounds the numbers. */
static void add_slots(const sl_gather_view *view, const float *more, double scale) {
    const sl_gather_tables *t = view->gather->tables;
    sl_gather_scratch *s = view->scratch;
    uint64_t key = sl_random_key(view->point->key, 2);
    double sum = (double)sl_random_unit(key, 0);
    uint32_t before = 0;
    for (size_t k = 0; k < t->used; k++) {
        sum += scale * (double)more[k];
        uint32_t now = (uint32_t)sum, count = now - before;
        before = now;
        if (count > s->slots_max - s->slots) count = (uint32_t)(s->slots_max - s->slots);
        if (count == 0) continue;
        float share = 1.0f / (float)(1 + count);
        uint32_t bits = sl_random_bits(key, 1 + k);
        s->slot_share[k] = share;
        for (uint32_t i = 0; i < count; i++, s->slots++) {
            /* Steps of the R2 sequence, in 2^-16: 1/g and 1/g^2, g^3 = g + 1. */
            uint32_t a = (bits >> 16) + i * 49471u, b = bits + i * 37345u;
            s->slot_cell[s->slots] = t->order[k];
            s->slot_share[s->slots] = share;
            s->more_a[s->slots - t->used] = t->slot_a[k];
            s->more_b[s->slots - t->used] = t->slot_b[k];
            s->more_bits[s->slots - t->used] = (a & 0xffffu) << 16 | (b & 0xffffu);
        }
    }
}

void sl_gather_add_rays(const sl_gather_view *view, sl_counters *counters) {
    const sl_gather *g = view->gather;
    const sl_gather_tables *t = g->tables;
    sl_gather_scratch *s = view->scratch;
    if (t->kind != SL_GATHER_RAYS || s->slots_max == t->used || t->size < 4 || !g->settings.jitter) return;
    /* these are written later */
    float *radiance = s->planes.mean, *spread = s->planes.distance, *more = s->planes.r;
    estimate_radiance(view, radiance);
    bring_near_one(view, radiance);
    SL_KERNEL_OF(g->isa, sl_gather_spread)(t->width, t->height, radiance, spread);
    double scale = share_rays(t, spread, (double)(s->slots_max - t->used), more);
    if (scale > 0.0) add_slots(view, more, scale);
    if (s->slots > t->used) sl_gather_see_more_rays(view, counters);
}
