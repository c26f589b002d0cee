/* Which faces go together: from the largest face that is left a chart grows over its neighbours as long as
 * they turn no farther from its plane than the limit, first from the face's own plane, then once more from
 * the mean of what that found. Projected onto it, two faces of a chart may still overlap, as on a winding
 * ramp: the later ones leave, and grow charts of their own. */
#include "cache/light_octree/atlas/parts.h"

#include <string.h>

#include "base/code_sort.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"

/* Of so many turns within a quarter the one with the smallest box is taken. */
enum { TURNS = 16 };

typedef struct growing {
    const sl_atlas_faces *faces;
    sl_atlas_charts *charts;
    double cos_bend;
    size_t listed;          /* of charts->face */
    sl_coded *order;        /* faces, the largest first */
} growing;

/* ---- growing ---- */

/* Slivers, which have no normal, go with everything. */
static bool agrees(const growing *g, sl_vec3d axis, uint32_t face) {
    sl_vec3d n = g->faces->normal[face];
    return sl_dotd(n, n) == 0.0 || sl_dotd(axis, axis) == 0.0 || sl_dotd(n, axis) >= g->cos_bend;
}

static void claim(growing *g, uint32_t id, uint32_t face) {
    g->charts->of_face[face] = id;
    g->charts->face[g->listed++] = face;
}

/* Claims what is connected to the seed, nearest first. Returns the mean normal, by area, or 0. */
static sl_vec3d spread(growing *g, uint32_t id, uint32_t seed, sl_vec3d axis) {
    const uint32_t *face = g->charts->face;
    sl_vec3d sum = {0.0, 0.0, 0.0};
    size_t next = g->listed;
    claim(g, id, seed);
    for (; next < g->listed; next++) {
        sum = sl_addd(sum, sl_scaled(g->faces->normal[face[next]], g->faces->area[face[next]]));
        for (uint32_t h = 3 * face[next]; h < 3 * face[next] + 3; h++) {
            uint32_t opposite = g->faces->opposite[h];
            if (opposite == SL_NO_INDEX || g->charts->of_face[opposite / 3] != SL_NO_INDEX) continue;
            if (agrees(g, axis, opposite / 3)) claim(g, id, opposite / 3);
        }
    }
    double length = sl_lengthd(sum);
    return length > 0.0 ? sl_scaled(sum, 1.0 / length) : sl_v3d(0.0, 0.0, 0.0);
}

static void unclaim(growing *g, size_t first) {
    for (size_t i = first; i < g->listed; i++) g->charts->of_face[g->charts->face[i]] = SL_NO_INDEX;
    g->listed = first;
}

/* Returns the normal of the chart's plane. */
static sl_vec3d grow(growing *g, uint32_t id, uint32_t seed) {
    size_t first = g->listed;
    sl_vec3d axis = g->faces->normal[seed], mean = spread(g, id, seed, axis);
    if (sl_dotd(mean, mean) > 0.0 && agrees(g, mean, seed)) {
        unclaim(g, first);
        spread(g, id, seed, mean);
        axis = mean;
    }
    return sl_dotd(axis, axis) > 0.0 ? axis : sl_v3d(0.0, 0.0, 1.0);
}

/* ---- the plane ---- */

typedef struct extent {
    double low[2], high[2];
} extent;

static extent extent_of(const growing *g, const sl_atlas_plane *p) {
    extent e = {{HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL}};
    for (size_t c = 3 * p->first; c < 3 * (p->first + p->count); c++) {
        sl_vec3d at =
            sl_subd(sl_atlas_corner(g->faces, 3 * (size_t)g->charts->face[c / 3] + c % 3), p->origin);
        const double xy[2] = {sl_dotd(at, p->right), sl_dotd(at, p->up)};
        for (int k = 0; k < 2; k++) {
            e.low[k] = fmin(e.low[k], xy[k]);
            e.high[k] = fmax(e.high[k], xy[k]);
        }
    }
    return e;
}

/* Along the longest edge of the chart's border; boxes and rooms are laid straight by it. */
static sl_vec3d longest_border(const growing *g, const sl_atlas_plane *p, sl_vec3d axis) {
    sl_vec3d best = {0.0, 0.0, 0.0};
    for (size_t c = 3 * p->first; c < 3 * (p->first + p->count); c++) {
        uint32_t h = 3 * g->charts->face[c / 3] + (uint32_t)(c % 3), opposite = g->faces->opposite[h];
        if (opposite != SL_NO_INDEX && g->charts->of_face[opposite / 3] == g->charts->of_face[h / 3])
            continue;
        sl_vec3d e = sl_subd(sl_atlas_corner(g->faces, sl_atlas_next(h)), sl_atlas_corner(g->faces, h));
        e = sl_subd(e, sl_scaled(axis, sl_dotd(e, axis)));
        if (sl_dotd(e, e) > sl_dotd(best, best)) best = e;
    }
    double length = sl_lengthd(best);
    if (length > 0.0) return sl_scaled(best, 1.0 / length);
    return sl_to_double(sl_frame_from_normal(sl_to_float(axis)).x);
}

/* Turns the plane's axes so that the chart's box is small, its longer side along `right`. */
static void lay_out(const growing *g, sl_atlas_plane *p, sl_vec3d axis) {
    p->origin = sl_atlas_corner(g->faces, 3 * (size_t)g->charts->face[p->first]);
    sl_vec3d x = longest_border(g, p, axis), y = sl_crossd(axis, x);
    double least = HUGE_VAL;
    sl_atlas_plane best = *p;
    extent box = {{0.0, 0.0}, {0.0, 0.0}};
    for (int turn = 0; turn < 2 * TURNS; turn++) {
        double angle = 0.5 * SL_PI * turn / TURNS, c = sl_cos(angle), s = sl_sin(angle);
        p->right = sl_addd(sl_scaled(x, c), sl_scaled(y, s));
        p->up = sl_subd(sl_scaled(y, c), sl_scaled(x, s));
        extent e = extent_of(g, p);
        double width = e.high[0] - e.low[0], height = e.high[1] - e.low[1];
        if (height > width || !(width * height < least)) continue;
        least = width * height;
        best = *p;
        box = e;
    }
    *p = best;
    p->width = box.high[0] - box.low[0];
    p->height = box.high[1] - box.low[1];
    p->origin = sl_addd(p->origin, sl_addd(sl_scaled(p->right, box.low[0]), sl_scaled(p->up, box.low[1])));
}

/* ---- overlaps ---- */

/* A grid over a chart's plane: its cells are taken by the face that covers their middles. */
typedef struct cell_grid {
    int columns, rows;
    double cell;
    uint8_t *taken;
} cell_grid;

enum { CELLS_A_FACE = 64, SIDE_MOST = 1024 };

/* Tells whether a point lies inside a triangle, and not on its border. */
static bool covers(const double corner[3][2], double x, double y) {
    bool inside = true;
    for (int k = 0; k < 3; k++) {
        const double *a = corner[k], *b = corner[(k + 1) % 3];
        inside = inside && (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]) > 1e-6;
    }
    return inside;
}

/* Takes the cells that a face covers, or tells that one of them is taken; free: takes none. */
static bool take_cells(const growing *g, const sl_atlas_plane *p, cell_grid *grid, uint32_t face, bool take) {
    double corner[3][2], low[2] = {HUGE_VAL, HUGE_VAL}, high[2] = {-HUGE_VAL, -HUGE_VAL};
    for (size_t k = 0; k < 3; k++) {
        sl_vec3d at = sl_subd(sl_atlas_corner(g->faces, 3 * (size_t)face + k), p->origin);
        corner[k][0] = sl_dotd(at, p->right) / grid->cell;
        corner[k][1] = sl_dotd(at, p->up) / grid->cell;
        for (int d = 0; d < 2; d++) {
            low[d] = fmin(low[d], corner[k][d]);
            high[d] = fmax(high[d], corner[k][d]);
        }
    }
    for (int y = (int)fmax(low[1], 0.0); y < grid->rows && y < high[1]; y++) {
        for (int x = (int)fmax(low[0], 0.0); x < grid->columns && x < high[0]; x++) {
            uint8_t *cell = &grid->taken[(size_t)y * (size_t)grid->columns + (size_t)x];
            if (!covers(corner, x + 0.5, y + 0.5)) continue;
            if (*cell && !take) return false;
            *cell |= take;
        }
    }
    return true;
}

/* Removes faces that overlap earlier ones, never the first, as far as some cells for each face can tell.
 * Slivers cover nothing. False: no memory. */
static bool drop_overlaps(growing *g, sl_atlas_plane *p) {
    uint32_t *face = g->charts->face + p->first;
    size_t kept = 0;
    if (p->count == 1 || !(p->height > 0.0)) return true;
    cell_grid grid = {.cell = fmax(sqrt(p->width * p->height / (CELLS_A_FACE * (double)p->count)),
                                   p->width / SIDE_MOST)};
    grid.columns = (int)(p->width / grid.cell) + 1;
    grid.rows = (int)(p->height / grid.cell) + 1;
    grid.taken = sl_allocate((size_t)grid.columns * (size_t)grid.rows, sizeof *grid.taken);
    if (!grid.taken) return false;
    for (size_t i = 0; i < p->count; i++) {
        bool sliver = sl_dotd(g->faces->normal[face[i]], g->faces->normal[face[i]]) == 0.0;
        if (sliver || take_cells(g, p, &grid, face[i], false)) {
            if (!sliver) take_cells(g, p, &grid, face[i], true);
            face[kept++] = face[i];
        } else {
            g->charts->of_face[face[i]] = SL_NO_INDEX;
        }
    }
    p->count = kept;
    g->listed = p->first + kept;
    sl_free(grid.taken);
    return true;
}

/* ---- all charts ---- */

/* A round over all faces; those that leave their charts are the next one's. */
static bool grow_round(growing *g, bool *left) {
    *left = false;
    for (size_t i = 0; i < g->faces->count; i++) {
        uint32_t seed = g->order[i].item;
        if (g->charts->of_face[seed] != SL_NO_INDEX) continue;
        uint32_t id = (uint32_t)g->charts->count++;
        sl_atlas_plane *p = &g->charts->plane[id];
        *p = (sl_atlas_plane){.first = g->listed};
        sl_vec3d axis = grow(g, id, seed);
        size_t grown = p->count = g->listed - p->first;
        lay_out(g, p, axis);
        if (!drop_overlaps(g, p)) return false;
        *left = *left || p->count < grown;
        if (p->count < grown) lay_out(g, p, axis);
    }
    return true;
}

sl_status sl_atlas_charts_create(const sl_atlas_faces *faces, double bend, sl_atlas_charts *charts,
                                 sl_error *error) {
    size_t count = faces->count;
    *charts = (sl_atlas_charts){.plane = sl_allocate(count, sizeof *charts->plane),
                                .face = sl_allocate(count, sizeof *charts->face),
                                .of_face = sl_allocate(count, sizeof *charts->of_face)};
    growing g = {.faces = faces,
                 .charts = charts,
                 .cos_bend = sl_cos(bend),
                 .order = sl_allocate(count, sizeof *g.order)};
    bool good = charts->plane && charts->face && charts->of_face && g.order, left = true;
    for (uint32_t f = 0; good && f < count; f++) {
        g.order[f] = (sl_coded){~sl_double_bits(faces->area[f]), f};
        charts->of_face[f] = SL_NO_INDEX;
    }
    if (good) sl_sort_coded(g.order, count);
    while (good && left) good = grow_round(&g, &left);
    sl_free(g.order);
    if (good) return SL_OK;
    sl_atlas_charts_release(charts);
    return sl_fail_memory(error, "an atlas's charts");
}

void sl_atlas_charts_release(sl_atlas_charts *c) {
    SL_FREE_ALL(c->plane, c->face, c->of_face);
    *c = (sl_atlas_charts){0};
}
