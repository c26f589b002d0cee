#include "cache/splatting/splatting.h"

#include <math.h>

static bool is_empty(sl_splat_rect r) { return r.x0 >= r.x1 || r.y0 >= r.y1; }
static int lesser(int a, int b) { return a < b ? a : b; }
static int greater(int a, int b) { return a > b ? a : b; }

static sl_splat_rect rect_union(sl_splat_rect a, sl_splat_rect b) {
    if (is_empty(a)) return b;
    if (is_empty(b)) return a;
    return (sl_splat_rect){lesser(a.x0, b.x0), lesser(a.y0, b.y0), greater(a.x1, b.x1), greater(a.y1, b.y1)};
}

sl_mirror_pixels sl_mirror_pixels_find(const sl_gbuffer *g, const sl_reflections *reflections) {
    sl_mirror_pixels m = {.low = {INFINITY, INFINITY, INFINITY}, .high = {-INFINITY, -INFINITY, -INFINITY}};
    for (size_t k = 0; reflections && k < reflections->count; k++) {
        const size_t i = reflections->pixel[k];
        const int x = (int)(i % (size_t)g->width), y = (int)(i / (size_t)g->width);
        const sl_vec3 p = sl_v3(g->position_x[i], g->position_y[i], g->position_z[i]);
        if (g->material[i] == SL_NO_INDEX) continue;
        m.rect = rect_union(m.rect, (sl_splat_rect){x, y, x + 1, y + 1});
        m.low = sl_v3(fminf(m.low.x, p.x), fminf(m.low.y, p.y), fminf(m.low.z, p.z));
        m.high = sl_v3(fmaxf(m.high.x, p.x), fmaxf(m.high.y, p.y), fmaxf(m.high.z, p.z));
    }
    return m;
}

static float outside(float low, float high, float x) {
    return x < low ? low - x : x > high ? x - high : 0.0f;
}

sl_splat_rect sl_mirror_bounds(const sl_mirror_pixels *m, sl_vec3 centre, float reach, sl_splat_rect seen) {
    const float x = outside(m->low.x, m->high.x, centre.x), y = outside(m->low.y, m->high.y, centre.y),
                z = outside(m->low.z, m->high.z, centre.z);
    return x * x + y * y + z * z <= reach * reach ? rect_union(seen, m->rect) : seen;
}
