#include "cache/hemisphere/projection.h"

#include <string.h>

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/hemisphere/hemisphere_tables.h"
#include "cache/hemisphere/projection_integrals.h"

enum { BLOCK = SL_PROJECTION_BLOCK, GROUP = SL_PROJECTION_GROUP };

/* ---- columns --------------------------------------------------------------------------------- */

/* cos(m phi) -> cos(m (pi - phi)) = (-1)^m cos(m phi), sin(m phi) -> -(-1)^m sin(m phi); phi -> -phi turns
 * the sines. */
static int class_of(int m) {
    int odd = m % 2 != 0;
    return m >= 0 ? odd : 2 + !odd;
}

static void order_columns(sl_projection *p) {
    int column = 0;
    for (int c = 0; c < SL_PROJECTION_CLASSES; c++) {
        int first = column;
        for (int l = 0; l < p->order; l++) {
            for (int m = -l; m <= l; m++) {
                if (class_of(m) != c) continue;
                p->place[column++] = (uint32_t)(m >= 0 ? sl_hsh_even(l, m) : sl_hsh_odd(p->order, l, m));
            }
        }
        if (column == first) continue; /* order 1 or 2 */
        while (column % GROUP) p->place[column++] = SL_NO_INDEX;
        while (p->groups < column / GROUP) p->class_of[p->groups++] = c;
    }
}

/* ---- the quadrant ---------------------------------------------------------------------------- */

/* One of its cells or walls. */
typedef struct entry {
    sl_wall_type type;
    int x, y;
} entry;

typedef struct quadrant {
    const sl_gather_tables *tables;
    sl_instrument instrument;
    double scale;
    sl_projection *projection;
    entry *cells, *walls;
} quadrant;

static bool is_cell(const sl_gather_tables *t, int x, int y) {
    return t->length[(size_t)y * (size_t)t->width + (size_t)x] > 0.0f; /* else blank */
}

/* Adds to a list, or only counts where there is none. */
static void append(entry *list, size_t *count, sl_wall_type type, int x, int y) {
    if (list) list[*count] = (entry){type, x, y};
    ++*count;
}

/* Cells and walls whose middles have x >= 0 and y >= 0. */
static void list_quadrant(quadrant *q) {
    const sl_gather_tables *t = q->tables;
    int width = t->width, first = width / 2;
    bool extended = t->kind == SL_GATHER_PLANE && q->instrument.border == SL_BORDER_RADIAL;
    size_t cells = 0, walls = 0;
    for (int y = first; y < width; y++) {
        for (int x = first; x < width; x++) {
            if (!is_cell(t, x, y)) continue;
            append(q->cells, &cells, SL_WALL_COLUMN, x, y);
            bool column = 2 * x >= width && is_cell(t, x - 1, y),
                 row = 2 * y >= width && is_cell(t, x, y - 1);
            if (column) append(q->walls, &walls, SL_WALL_COLUMN, x, y);
            if (row) append(q->walls, &walls, SL_WALL_ROW, x, y);
            if (column && extended && y == width - 1) append(q->walls, &walls, SL_WALL_BORDER_COLUMN, x, y);
            if (row && extended && x == width - 1) append(q->walls, &walls, SL_WALL_BORDER_ROW, x, y);
        }
    }
    q->projection->cells.count = cells;
    q->projection->walls.count = walls;
}

static uint32_t mirrored_cell(const sl_gather_tables *t, int x, int y, int image) {
    if (image & 1) x = t->width - 1 - x;
    if (image & 2) y = t->height - 1 - y;
    return (uint32_t)(y * t->width + x);
}

static void set_cell_images(const quadrant *q, size_t i) {
    sl_projection_list *list = &q->projection->cells;
    entry e = q->cells[i];
    for (int image = 0; image < 4; image++)
        list->cell[0][image][i] = mirrored_cell(q->tables, e.x, e.y, image);
}

static void set_wall_images(const quadrant *q, size_t i) {
    sl_projection_list *list = &q->projection->walls;
    entry e = q->walls[i], from = e;
    if (e.type == SL_WALL_COLUMN || e.type == SL_WALL_BORDER_COLUMN) from.x--;
    if (e.type == SL_WALL_ROW || e.type == SL_WALL_BORDER_ROW) from.y--;
    for (int image = 0; image < 4; image++) {
        list->cell[0][image][i] = mirrored_cell(q->tables, from.x, from.y, image);
        list->cell[1][image][i] = mirrored_cell(q->tables, e.x, e.y, image);
    }
}

/* ---- tables ---------------------------------------------------------------------------------- */

static void set_row(const sl_projection *p, sl_projection_list *list, size_t i, const double *values,
                    double scale) {
    float *block = list->table + i / BLOCK * (size_t)p->groups * BLOCK * GROUP + i % BLOCK * GROUP;
    for (int g = 0; g < p->groups; g++) {
        for (int c = 0; c < GROUP; c++) {
            uint32_t place = p->place[g * GROUP + c];
            block[g * BLOCK * GROUP + c] = place == SL_NO_INDEX ? 0.0f : (float)(scale * values[place]);
        }
    }
}

static void fill_cells(void *context, size_t block, unsigned worker) {
    const quadrant *q = context;
    double sums[SL_HSH_STRIDE_MAX];
    (void)worker;
    for (size_t i = block * BLOCK; i < q->projection->cells.count && i < (block + 1) * BLOCK; i++) {
        sl_cell_harmonics(&q->instrument, q->cells[i].x, q->cells[i].y, sums);
        set_row(q->projection, &q->projection->cells, i, sums, q->scale);
        set_cell_images(q, i);
    }
}

static void fill_walls(void *context, size_t block, unsigned worker) {
    const quadrant *q = context;
    sl_projection_list *list = &q->projection->walls;
    sl_wall wall;
    (void)worker;
    for (size_t i = block * BLOCK; i < list->count && i < (block + 1) * BLOCK; i++) {
        sl_wall_harmonics(&q->instrument, q->walls[i].type, q->walls[i].x, q->walls[i].y, &wall);
        list->x[i] = (float)(q->scale * wall.x);
        list->y[i] = (float)(q->scale * wall.y);
        set_row(q->projection, list, i, wall.mean, 1.0);
        set_wall_images(q, i);
    }
}

/* ---- memory ---------------------------------------------------------------------------------- */

static sl_status allocate_list(sl_projection_list *list, int groups, int sides, sl_error *error) {
    list->blocks = (list->count + BLOCK - 1) / BLOCK;
    size_t padded = list->blocks * BLOCK;
    list->table = sl_allocate(padded * (size_t)groups * GROUP, sizeof(float));
    list->cell[0][0] = sl_allocate(padded * 4 * (size_t)sides, sizeof(uint32_t));
    list->x = sl_allocate(padded * 2, sizeof(float));
    if (!list->table || !list->cell[0][0] || !list->x)
        return sl_fail_memory(error, "tables of hemispherical harmonics");
    list->y = list->x + padded;
    for (int i = 0; i < 4 * sides; i++) list->cell[i / 4][i % 4] = list->cell[0][0] + (size_t)i * padded;
    return SL_OK;
}

static void free_list(sl_projection_list *list) {
    sl_free(list->table);
    sl_free(list->cell[0][0]);
    sl_free(list->x);
}

void sl_projection_destroy(sl_projection *p) {
    if (!p) return;
    free_list(&p->cells);
    free_list(&p->walls);
    sl_free(p);
}

size_t sl_projection_bytes(const sl_projection *p) {
    size_t row = (size_t)p->groups * GROUP * sizeof(float) + 2 * sizeof(float);
    return sizeof *p + p->cells.blocks * BLOCK * (row + 4 * sizeof(uint32_t)) +
           p->walls.blocks * BLOCK * (row + 8 * sizeof(uint32_t));
}

static sl_status fill(quadrant *q, unsigned threads, sl_error *error) {
    sl_projection *p = q->projection;
    list_quadrant(q); /* counts */
    sl_status status = allocate_list(&p->cells, p->groups, 1, error);
    if (status == SL_OK) status = allocate_list(&p->walls, p->groups, 2, error);
    if (status != SL_OK) return status;
    q->cells = sl_allocate(p->cells.count, sizeof *q->cells);
    q->walls = sl_allocate(p->walls.count, sizeof *q->walls);
    if (q->cells && q->walls) {
        list_quadrant(q);
        sl_parallel_for(threads, p->cells.blocks, fill_cells, q);
        sl_parallel_for(threads, p->walls.blocks, fill_walls, q);
    } else {
        status = sl_fail_memory(error, "tables of hemispherical harmonics");
    }
    sl_free(q->cells);
    sl_free(q->walls);
    return status;
}

sl_status sl_projection_create(const sl_gather_tables *tables, double half_tangent, sl_border border,
                               int order, unsigned threads, sl_projection **out, sl_error *error) {
    *out = NULL;
    sl_projection *p = sl_allocate(1, sizeof *p);
    if (!p) return sl_fail_memory(error, "tables of hemispherical harmonics");
    p->order = order;
    order_columns(p);
    quadrant q = {.tables = tables, .scale = 1.0, .projection = p};
    q.instrument = sl_instrument_of(tables, half_tangent, border, order);
    /* by what the plane covers, as weights are */
    bool divided = tables->kind == SL_GATHER_PLANE && border == SL_BORDER_LC04;
    if (divided)
        q.scale = SL_PI / sl_plane_cosine_weight(-half_tangent, half_tangent, -half_tangent, half_tangent);
    sl_status status = fill(&q, threads, error);
    if (status != SL_OK) {
        sl_projection_destroy(p);
        return status;
    }
    *out = p;
    return SL_OK;
}

/* ---- one projection -------------------------------------------------------------------------- */

static sl_projection_kernel *kernel_for(sl_isa isa) { return SL_KERNEL_OF(isa, sl_projection_sums); }

void sl_project(const sl_projection *p, sl_isa isa, const float *const picture[4], float *coefficients) {
    sl_projection_sums sums;
    size_t stride = sl_hsh_stride(p->order);
    kernel_for(isa)(p, picture, &sums);
    memset(coefficients, 0, SL_PROJECTION_VECTORS * stride * sizeof *coefficients);
    for (int g = 0; g < p->groups; g++) {
        for (int c = 0; c < GROUP; c++) {
            uint32_t place = p->place[g * GROUP + c];
            for (size_t v = 0; place != SL_NO_INDEX && v < SL_PROJECTION_VECTORS; v++) {
                coefficients[v * stride + place] = (float)sums.sum[g][v][c];
            }
        }
    }
}
