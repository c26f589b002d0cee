/* What is seen in a mirror lies elsewhere than where the picture shows it, so the rectangle about a record's
 * sphere on the screen (step 1 of Algorithm 1) misses those pixels. They are found by where they lie in the
 * world instead: by boxes of 16 x 16 pixels each. */
#include "cache/splatting/splatting.h"

#include "base/error.h"
#include "base/memory.h"

#include <math.h>

enum { CELL = 16 };

static bool is_empty(sl_splat_rect r) { return r.x0 >= r.x1 || r.y0 >= r.y1; }
static int lesser(int a, int b) { return a < b ? a : b; }
static int greater(int a, int b) { return a > b ? a : b; }

static sl_splat_rect rect_union(sl_splat_rect a, sl_splat_rect b) {
    if (is_empty(a)) return b;
    if (is_empty(b)) return a;
    return (sl_splat_rect){lesser(a.x0, b.x0), lesser(a.y0, b.y0), greater(a.x1, b.x1), greater(a.y1, b.y1)};
}

static void add(sl_mirror_cell *c, sl_splat_rect pixels, sl_vec3 p) {
    const bool first = is_empty(c->rect);
    c->rect = rect_union(c->rect, pixels);
    c->low = first ? p : sl_v3(fminf(c->low.x, p.x), fminf(c->low.y, p.y), fminf(c->low.z, p.z));
    c->high = first ? p : sl_v3(fmaxf(c->high.x, p.x), fmaxf(c->high.y, p.y), fmaxf(c->high.z, p.z));
}

sl_status sl_mirror_cells_make(const sl_gbuffer *g, const sl_reflections *reflections,
                               sl_mirror_cells *cells, sl_error *error) {
    const int columns = (g->width + CELL - 1) / CELL, rows = (g->height + CELL - 1) / CELL;
    sl_mirror_cells_release(cells);
    if (!reflections) return SL_OK;
    cells->cell = sl_allocate((size_t)columns * (size_t)rows, sizeof *cells->cell);
    if (!cells->cell) return sl_fail_memory(error, "what mirrors show");
    cells->columns = columns;
    cells->rows = rows;
    for (size_t k = 0; k < reflections->count; k++) {
        const size_t i = reflections->pixel[k];
        const int x = (int)(i % (size_t)g->width), y = (int)(i / (size_t)g->width);
        const sl_vec3 p = sl_v3(g->position_x[i], g->position_y[i], g->position_z[i]);
        if (g->material[i] == SL_NO_INDEX) continue;
        add(&cells->cell[y / CELL * columns + x / CELL], (sl_splat_rect){x, y, x + 1, y + 1}, p);
        add(&cells->all, (sl_splat_rect){x, y, x + 1, y + 1}, p);
    }
    return SL_OK;
}

void sl_mirror_cells_release(sl_mirror_cells *cells) {
    sl_free(cells->cell);
    *cells = (sl_mirror_cells){0};
}

/* ---- spheres and cells ---- */

static float outside(float low, float high, float x) {
    return x < low ? low - x : x > high ? x - high : 0.0f;
}

static bool reaches(const sl_mirror_cell *c, sl_vec3 centre, float reach) {
    const float x = outside(c->low.x, c->high.x, centre.x), y = outside(c->low.y, c->high.y, centre.y),
                z = outside(c->low.z, c->high.z, centre.z);
    return !is_empty(c->rect) && x * x + y * y + z * z <= reach * reach;
}

sl_splat_rect sl_mirror_bounds(const sl_mirror_cells *cells, sl_vec3 centre, float reach,
                               sl_splat_rect seen) {
    return reaches(&cells->all, centre, reach) ? rect_union(seen, cells->all.rect) : seen;
}

sl_splat_rect sl_mirror_bounds_within(const sl_mirror_cells *cells, sl_vec3 centre, float reach,
                                      sl_splat_rect seen, sl_splat_rect tile) {
    sl_splat_rect r = {greater(seen.x0, tile.x0), greater(seen.y0, tile.y0), lesser(seen.x1, tile.x1),
                       lesser(seen.y1, tile.y1)};
    for (int y = tile.y0 / CELL; y < cells->rows && y * CELL < tile.y1; y++) {
        for (int x = tile.x0 / CELL; x < cells->columns && x * CELL < tile.x1; x++) {
            const sl_mirror_cell *c = &cells->cell[y * cells->columns + x];
            if (reaches(c, centre, reach)) r = rect_union(r, c->rect);
        }
    }
    return is_empty(r) ? (sl_splat_rect){tile.x0, tile.y0, tile.x0, tile.y0} : r;
}
