/* Keeps what outlives an edit: direct light at a vertex from which no light has changed, nor is seen through
 * a place where something was, or is now; and all light where nothing but its power has changed. */
#include <math.h>

#include "cache/shading_cache/state.h"

enum { FEW = 32 };

/* ---- power: light adds up, and scales with what it comes from ---- */

/* Of what is black in a channel any ratio is right: `ratio` keeps what it has. */
static bool find_ratio(sl_rgb before, sl_rgb now, double ratio[3]) {
    const float from[3] = {before.r, before.g, before.b}, to[3] = {now.r, now.g, now.b};
    for (int c = 0; c < 3; c++) {
        if (!(from[c] > 0.0f) && to[c] > 0.0f) return false;
        if (from[c] > 0.0f) ratio[c] = (double)to[c] / (double)from[c];
    }
    return true;
}

/* An unknown ratio (NaN) is about any. */
static bool is_about(double a, double b) { return !(fabs(a - b) > 1e-6 * b); }

/* The ratio of each channel, if it is that of all lights. */
static bool find_common_ratio(const sl_sampled_lights *before, const sl_sampled_lights *now,
                              double ratio[3]) {
    for (size_t l = 0; l < now->count; l++) {
        double of_this[3] = {NAN, NAN, NAN};
        if (!find_ratio(before->light[l].colour, now->light[l].colour, of_this)) return false;
        for (int c = 0; c < 3; c++) {
            if (isnan(ratio[c])) ratio[c] = of_this[c];
            if (!is_about(of_this[c], ratio[c])) return false;
        }
    }
    return now->count > 0;
}

static void scale(float *value, int channels, const double ratio[3]) {
    for (int c = 0; c < channels; c++)
        if (value[c] != 0.0f) value[c] = (float)((double)value[c] * ratio[c % 3]);
}

/* Within the rounding of a float. Returns what is left to be done: where colours change paths are chosen
 * otherwise, and indirect light is renewed as if surfaces had another colour. */
static unsigned scale_light(sl_shading_state *s, const sl_light_moves *moves,
                            const sl_sampled_lights *before) {
    double ratio[3] = {NAN, NAN, NAN};
    sl_patches *p = s->patches;
    if (p->sets || s->scene->environment.present || !find_common_ratio(before, moves->lights, ratio))
        return SL_CHANGED_POWER;
    for (uint32_t v = 0; v < p->vertex_count; v++) {
        if (!p->vertex[v].references || p->vertex[v].evaluated == SL_VERTEX_NEVER) continue;
        scale(sl_vertex_value(p, v), p->settings.channels, ratio);
        if (v < s->layers.capacity) scale(sl_cheap_layer(&s->layers, p, v), 2 * p->settings.channels, ratio);
    }
    s->drawn = false;
    bool grey = is_about(ratio[0], ratio[1]) && is_about(ratio[1], ratio[2]) && is_about(ratio[2], ratio[0]);
    return grey ? 0 : SL_CHANGED_MATERIALS;
}

/* ---- places ---- */

/* Only light that comes straight from lamps tells by its way whether something came between. */
static bool is_told_by_lamps(const sl_shading_state *s) {
    bool sky = s->scene->environment.present && s->settings.shading_cache.indirect == SL_INDIRECT_NONE;
    return s->plan.direct && !s->plan.caustics && !sky && (s->layers.kept || !s->plan.indirect);
}

static bool is_untouched(const sl_shading_state *s, const sl_light_moves *moves, uint32_t v,
                         bool recoloured) {
    const sl_patch_vertex *vertex = &s->patches->vertex[v];
    sl_lit_point at;
    if (!vertex->references || vertex->evaluated == SL_VERTEX_NEVER || vertex->extrapolated ||
        moves->object_moved[sl_root_object(s->primitives, vertex->root)] ||
        (recoloured && sl_material_has_lobe(sl_root_material(s->primitives, vertex->root))) ||
        sl_vertex_is_stale(s->patches, &s->work, v))
        return false;
    sl_vertex_sample_point(s->patches, v, &at);
    for (size_t l = 0; l < moves->lights->count; l++)
        if (sl_light_may_differ(moves, l, at.position, 1e-4 * (double)sl_scene_central_diagonal(s->scene)))
            return false;
    return true;
}

unsigned sl_shading_keep(sl_shading_state *s, unsigned what, const sl_light_moves *moves,
                         const sl_sampled_lights *before) {
    const unsigned kept = SL_CHANGED_OBJECTS | SL_CHANGED_MATERIALS, power = SL_CHANGED_POWER;
    if (what & power) what = (what & ~power) | scale_light(s, moves, before);
    if (what == 0 || what == SL_CHANGED_CAMERA) return what;
    if (what & ~kept || !is_told_by_lamps(s) || moves->lights->count > FEW || moves->box_count > 2 * FEW)
        return what | SL_CHANGED_LIGHTS;
    for (uint32_t v = 0; v < s->patches->vertex_count; v++)
        if (is_untouched(s, moves, v, what & SL_CHANGED_MATERIALS))
            sl_vertex_mark(&s->patches->vertex[v], s->now + 1);
    return what;
}
