/* Which pixels of a view ask for which records. */
#include "base/counters.h"
#include "cache/splatting/state.h"

#include <string.h>

/* The class of a pixel with geometry; SL_RECEIVER_CLASSES where it reflects nothing but mirrors. */
static sl_receiver_class class_of(const sl_splat_state *s, size_t i) {
    const sl_gbuffer *g = s->gbuffer;
    if (sl_material_is_glossy(&s->scene->materials[g->material[i]])) return SL_RECEIVES_RADIANCE;
    bool diffuse = g->diffuse_r[i] > 0.0f || g->diffuse_g[i] > 0.0f || g->diffuse_b[i] > 0.0f;
    return diffuse ? SL_RECEIVES_IRRADIANCE : SL_RECEIVER_CLASSES;
}

static bool is_sound(const sl_gbuffer *g, size_t i) {
    return sl_is_finite(sl_v3(g->normal_x[i], g->normal_y[i], g->normal_z[i])) &&
           sl_is_finite(sl_v3(g->position_x[i], g->position_y[i], g->position_z[i]));
}

/* A normal that is not finite would ask for ever. */
void sl_splat_classify(sl_splat_state *s) {
    for (int c = 0; c < SL_RECEIVER_CLASSES; c++) {
        s->cache[c].receivers = 0;
        if (s->cache[c].receives)
            memset(s->cache[c].receives, 0, sl_splat_pixels(s) * sizeof *s->cache[c].receives);
    }
    for (size_t i = 0; i < sl_splat_pixels(s); i++) {
        if (s->gbuffer->material[i] == SL_NO_INDEX) continue;
        sl_receiver_class class = class_of(s, i);
        if (!is_sound(s->gbuffer, i)) {
            sl_count(&s->counters, SL_COUNT_NONFINITE, 1);
        } else if (class < SL_RECEIVER_CLASSES && s->cache[class].receives) {
            s->cache[class].receives[i] = 1;
            s->cache[class].receivers++;
        }
    }
}
