/* The grid (grid.h). Cells are cubes in x, then y, then z order; a cell's triangles are one run of `triangles`, ascending.
 * It is filled in two passes, count and write, by slabs of whole z layers that tasks own, so threads never meet. */
#include "raster/views/grid.h"

#include <math.h>
#include <string.h>

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"

enum { CELLS_PER_AXIS_MAX = 512, SLABS_MAX = 16, WORD = 64 };

struct sl_grid {
    const sl_scene *scene;
    double origin[3], cell; /* low corner, and a cell's side */
    int n[3];
    uint64_t *start;        /* of every cell's run, and the end */
    uint32_t *triangles;
    uint32_t *filled;       /* summed over the cells below (x, y, z): how many hold a triangle; (n + 1)^3 values */
};

static size_t cell_index(const sl_grid *g, int x, int y, int z) {
    return ((size_t)z * (size_t)g->n[1] + (size_t)y) * (size_t)g->n[0] + (size_t)x;
}

static size_t sum_index(const sl_grid *g, int x, int y, int z) {
    return ((size_t)z * (size_t)(g->n[1] + 1) + (size_t)y) * (size_t)(g->n[0] + 1) + (size_t)x;
}
static size_t sum_count(const sl_grid *g) { return sum_index(g, g->n[0], g->n[1], g->n[2]) + 1; }

/* ---- triangle against cell ---- */

typedef struct {
    sl_vec3d p[3];
    sl_vec3d normal;
    int low[3], high[3]; /* cells that its box touches */
} placed_triangle;

static int cell_of(const sl_grid *g, int axis, double at, double margin) {
    double i = floor((at - g->origin[axis]) / g->cell + margin);
    return !(i > 0.0) ? 0 : i < (double)g->n[axis] ? (int)i : g->n[axis] - 1;
}

static bool triangle_is_finite(const sl_scene *s, uint32_t t) {
    for (int k = 0; k < 3; k++) {
        if (!sl_is_finite(sl_scene_position(s, s->vertex[k][t]))) return false;
    }
    return true;
}

/* The margin of 1/10000 cell covers all rounding here and in the cone's test. */
static const double margin_in_cells = 1e-4;

static bool place(const sl_grid *g, uint32_t t, placed_triangle *out) {
    const sl_scene *s = g->scene;
    if (!triangle_is_finite(s, t)) return false;
    for (int k = 0; k < 3; k++) out->p[k] = sl_to_double(sl_scene_position(s, s->vertex[k][t]));
    const double x[3] = {out->p[0].x, out->p[1].x, out->p[2].x}, y[3] = {out->p[0].y, out->p[1].y, out->p[2].y};
    const double z[3] = {out->p[0].z, out->p[1].z, out->p[2].z}, *at[3] = {x, y, z};
    for (int axis = 0; axis < 3; axis++) {
        const double *c = at[axis];
        out->low[axis] = cell_of(g, axis, fmin(fmin(c[0], c[1]), c[2]), -margin_in_cells);
        out->high[axis] = cell_of(g, axis, fmax(fmax(c[0], c[1]), c[2]), margin_in_cells);
    }
    out->normal = sl_crossd(sl_subd(out->p[1], out->p[0]), sl_subd(out->p[2], out->p[0]));
    return true;
}

static bool separated(sl_vec3d axis, const sl_vec3d q[3], double half) {
    double a = sl_dotd(axis, q[0]), b = sl_dotd(axis, q[1]), c = sl_dotd(axis, q[2]);
    double reach = half * (fabs(axis.x) + fabs(axis.y) + fabs(axis.z));
    return fmin(fmin(a, b), c) > reach || fmax(fmax(a, b), c) < -reach;
}

/* Separating axes (Akenine-Moeller 2001, "Fast 3D triangle-box overlap testing"): the triangle's normal and the nine
 * products of its edges with the box's; the box's own three are the range of cells. */
static bool touches_cell(const sl_grid *g, const placed_triangle *t, int x, int y, int z) {
    double half = g->cell * (0.5 + margin_in_cells);
    sl_vec3d centre = sl_v3d(g->origin[0] + ((double)x + 0.5) * g->cell, g->origin[1] + ((double)y + 0.5) * g->cell,
                             g->origin[2] + ((double)z + 0.5) * g->cell);
    sl_vec3d q[3];
    for (int k = 0; k < 3; k++) q[k] = sl_subd(t->p[k], centre);
    if (separated(t->normal, q, half)) return false;
    for (int k = 0; k < 3; k++) {
        sl_vec3d e = sl_subd(q[(k + 1) % 3], q[k]);
        if (separated(sl_v3d(0, -e.z, e.y), q, half) || separated(sl_v3d(e.z, 0, -e.x), q, half) ||
            separated(sl_v3d(-e.y, e.x, 0), q, half)) {
            return false;
        }
    }
    return true;
}

/* ---- filling ---- */

typedef struct {
    sl_grid *grid;
    uint64_t *cursor; /* of every cell: its count, then where its next triangle goes */
    int slabs;
    bool writing;
} filling;

static void visit(filling *f, uint32_t triangle, size_t cell) {
    if (f->writing) f->grid->triangles[f->cursor[cell]] = triangle;
    f->cursor[cell]++;
}

static void fill_slab(void *context, size_t slab, unsigned worker) {
    filling *f = context;
    const sl_grid *g = f->grid;
    (void)worker;
    int first = (int)((size_t)g->n[2] * slab / (size_t)f->slabs), end = (int)((size_t)g->n[2] * (slab + 1) / (size_t)f->slabs);
    for (size_t i = 0; i < g->scene->triangle_count; i++) {
        placed_triangle t;
        if (!place(g, (uint32_t)i, &t) || t.high[2] < first || t.low[2] >= end) continue;
        bool alone = t.low[0] == t.high[0] && t.low[1] == t.high[1] && t.low[2] == t.high[2];
        for (int z = t.low[2] > first ? t.low[2] : first; z <= t.high[2] && z < end; z++) {
            for (int y = t.low[1]; y <= t.high[1]; y++) {
                for (int x = t.low[0]; x <= t.high[0]; x++) {
                    if (alone || touches_cell(g, &t, x, y, z)) visit(f, (uint32_t)i, cell_index(g, x, y, z));
                }
            }
        }
    }
}

/* Bounds of the finite triangles; false if there is none. */
static bool find_bounds(const sl_scene *s, double low[3], double high[3]) {
    bool any = false;
    for (uint32_t t = 0; t < s->triangle_count; t++) {
        if (!triangle_is_finite(s, t)) continue;
        for (int k = 0; k < 3; k++) {
            sl_vec3d p = sl_to_double(sl_scene_position(s, s->vertex[k][t]));
            const double c[3] = {p.x, p.y, p.z};
            for (int axis = 0; axis < 3; axis++) {
                low[axis] = any ? fmin(low[axis], c[axis]) : c[axis];
                high[axis] = any ? fmax(high[axis], c[axis]) : c[axis];
            }
            any = true;
        }
    }
    return any;
}

/* Cubes, as many as cells_per_axis^3 in all; a flat scene counts as a thousandth of its length thick. */
static void choose_cells(sl_grid *g, int cells_per_axis) {
    double low[3] = {0, 0, 0}, high[3] = {0, 0, 0}, longest = 0.0, volume = 1.0;
    find_bounds(g->scene, low, high);
    for (int axis = 0; axis < 3; axis++) longest = fmax(longest, high[axis] - low[axis]);
    if (!(longest > 0.0)) longest = 1.0;
    for (int axis = 0; axis < 3; axis++) volume *= fmax((high[axis] - low[axis]) / longest, 1e-3);
    double triangles = (double)(g->scene->triangle_count > 0 ? g->scene->triangle_count : 1);
    double wanted = cells_per_axis > 0 ? (double)cells_per_axis : sl_pow(2.0 * triangles, 1.0 / 3.0);
    double cell = longest * sl_pow(volume, 1.0 / 3.0) / wanted, least = longest / (double)CELLS_PER_AXIS_MAX;
    g->cell = cell > least ? cell : least;
    for (int axis = 0; axis < 3; axis++) {
        double n = ceil((high[axis] - low[axis]) / g->cell);
        g->n[axis] = n < 1.0 ? 1 : n > (double)CELLS_PER_AXIS_MAX ? CELLS_PER_AXIS_MAX : (int)n;
        g->origin[axis] = low[axis];
    }
}

/* Summed-volume table (Crow's summed-area table of 1984, one dimension up): the filled cells of any range from eight of its
 * values. Differences of unsigned numbers, so the order of signs does not matter. */
static uint32_t filled_in(const sl_grid *g, const int low[3], const int high[3]) {
    uint32_t sum = 0;
    for (int corner = 0; corner < 8; corner++) {
        int x = corner & 1 ? high[0] : low[0], y = corner & 2 ? high[1] : low[1], z = corner & 4 ? high[2] : low[2];
        int lows = !(corner & 1) + !(corner & 2) + !(corner & 4);
        uint32_t value = g->filled[sum_index(g, x, y, z)];
        sum += lows & 1 ? 0u - value : value;
    }
    return sum;
}

/* Every value from the seven others of its cell's corners. */
static void sum_filled(sl_grid *g) {
    for (int z = 0; z < g->n[2]; z++) {
        for (int y = 0; y < g->n[1]; y++) {
            for (int x = 0; x < g->n[0]; x++) {
                size_t cell = cell_index(g, x, y, z);
                const int low[3] = {x, y, z}, high[3] = {x + 1, y + 1, z + 1};
                uint32_t others = filled_in(g, low, high); /* its own value is still 0 */
                g->filled[sum_index(g, x + 1, y + 1, z + 1)] = (g->start[cell + 1] > g->start[cell]) - others;
            }
        }
    }
}

static sl_status fill(sl_grid *g, unsigned threads, sl_error *error) {
    size_t cells = sl_grid_cell_count(g);
    filling f = {.grid = g, .slabs = g->n[2] < SLABS_MAX ? g->n[2] : SLABS_MAX};
    g->start = sl_allocate(cells + 1, sizeof *g->start);
    g->filled = sl_allocate(sum_count(g), sizeof *g->filled);
    f.cursor = sl_allocate(cells, sizeof *f.cursor);
    if (!g->start || !g->filled || !f.cursor) {
        sl_free(f.cursor);
        return sl_fail_memory(error, "a grid of triangles");
    }
    sl_parallel_for(threads, (size_t)f.slabs, fill_slab, &f);
    for (size_t c = 0; c < cells; c++) {
        g->start[c + 1] = g->start[c] + f.cursor[c];
        f.cursor[c] = g->start[c];
    }
    g->triangles = sl_allocate(g->start[cells], sizeof *g->triangles);
    sum_filled(g);
    f.writing = true;
    if (g->triangles) sl_parallel_for(threads, (size_t)f.slabs, fill_slab, &f);
    sl_free(f.cursor);
    return g->triangles ? SL_OK : sl_fail_memory(error, "a grid of triangles");
}

sl_status sl_grid_create(const sl_scene *scene, int cells_per_axis, unsigned threads, sl_grid **grid, sl_error *error) {
    *grid = NULL;
    sl_grid *g = sl_allocate(1, sizeof *g);
    if (!g) return sl_fail_memory(error, "a grid of triangles");
    g->scene = scene;
    choose_cells(g, cells_per_axis);
    sl_status status = fill(g, sl_thread_count(threads), error);
    if (status != SL_OK) sl_grid_destroy(g);
    else *grid = g;
    return status;
}

void sl_grid_destroy(sl_grid *g) {
    if (!g) return;
    sl_free(g->start);
    sl_free(g->filled);
    sl_free(g->triangles);
    sl_free(g);
}

size_t sl_grid_cell_count(const sl_grid *g) { return (size_t)g->n[0] * (size_t)g->n[1] * (size_t)g->n[2]; }
double sl_grid_cell_size(const sl_grid *g) { return g->cell; }
size_t sl_grid_memory_bytes(const sl_grid *g) {
    size_t cells = sl_grid_cell_count(g);
    return sizeof *g + (cells + 1) * sizeof *g->start + sum_count(g) * sizeof *g->filled +
           (size_t)g->start[cells] * sizeof *g->triangles;
}

/* ---- query ---- */

struct sl_grid_scratch {
    size_t words;
    uint64_t *marked; /* a bit a triangle; all 0 between queries */
    uint32_t *list;
};

sl_status sl_grid_scratch_create(const sl_grid *g, sl_grid_scratch **scratch, sl_error *error) {
    *scratch = NULL;
    sl_grid_scratch *s = sl_allocate(1, sizeof *s);
    if (s) {
        s->words = (g->scene->triangle_count + WORD - 1) / WORD;
        s->marked = sl_allocate(s->words, sizeof *s->marked);
        s->list = sl_allocate(g->scene->triangle_count, sizeof *s->list);
    }
    if (!s || !s->marked || !s->list) {
        sl_grid_scratch_destroy(s);
        return sl_fail_memory(error, "a grid query's scratch");
    }
    *scratch = s;
    return SL_OK;
}

void sl_grid_scratch_destroy(sl_grid_scratch *s) {
    if (!s) return;
    sl_free(s->marked);
    sl_free(s->list);
    sl_free(s);
}

typedef struct {
    const sl_grid *grid;
    sl_cone_test cone;
    uint64_t *marked;
    sl_grid_hits *hits;
} query;

/* Cells low[k] .. high[k]-1. */
typedef struct {
    int low[3], high[3];
} cell_range;

static bool meets_range(query *q, const cell_range *r) {
    const sl_grid *g = q->grid;
    double centre[3], half[3];
    for (int k = 0; k < 3; k++) {
        centre[k] = g->origin[k] + 0.5 * (double)(r->low[k] + r->high[k]) * g->cell;
        half[k] = 0.5 * (double)(r->high[k] - r->low[k]) * g->cell;
    }
    q->hits->boxes_tested++;
    return sl_cone_meets_box(&q->cone, sl_v3d(centre[0], centre[1], centre[2]), sl_v3d(half[0], half[1], half[2]));
}

static void mark_cell(query *q, size_t cell) {
    const sl_grid *g = q->grid;
    q->hits->cells_met++;
    for (uint64_t i = g->start[cell]; i < g->start[cell + 1]; i++) {
        uint32_t t = g->triangles[i];
        q->marked[t / WORD] |= (uint64_t)1 << (t % WORD);
    }
}

/* Ranges that are empty or outside the cone are left whole; others are halved across their longest side, down to cells. At most one range
 * of each halving waits on the way down, so the depth is the sum of the axes' bits. */
static void visit_range(query *q, cell_range r) {
    const sl_grid *g = q->grid;
    int longest = 0;
    for (int k = 1; k < 3; k++) {
        if (r.high[k] - r.low[k] > r.high[longest] - r.low[longest]) longest = k;
    }
    if (filled_in(g, r.low, r.high) == 0 || !meets_range(q, &r)) return;
    if (r.high[longest] - r.low[longest] == 1) {
        mark_cell(q, cell_index(g, r.low[0], r.low[1], r.low[2]));
        return;
    }
    cell_range half = r;
    half.high[longest] = r.low[longest] + (r.high[longest] - r.low[longest]) / 2;
    visit_range(q, half);
    half.low[longest] = half.high[longest];
    half.high[longest] = r.high[longest];
    visit_range(q, half);
}

sl_grid_hits sl_grid_cone(const sl_grid *g, const sl_cone *cone, sl_grid_scratch *s) {
    sl_grid_hits hits = {.triangle = s->list};
    query q = {g, sl_cone_test_make(cone), s->marked, &hits};
    visit_range(&q, (cell_range){{0, 0, 0}, {g->n[0], g->n[1], g->n[2]}});
    for (size_t w = 0; w < s->words; w++) {
        for (uint64_t bits = s->marked[w]; bits; bits &= bits - 1) {
            s->list[hits.count++] = (uint32_t)(w * WORD + (size_t)__builtin_ctzll(bits));
        }
        s->marked[w] = 0;
    }
    return hits;
}
