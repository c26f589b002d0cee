#include "cache/hemisphere/projection.h"

#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"

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

/* COLUMN: between cells (x-1, y) and (x, y); ROW: between (x, y-1) and (x, y); BORDER: what the outermost
 * column or row wall of the plane becomes in the radial extension. */
typedef enum wall_type { COLUMN, ROW, BORDER_COLUMN, BORDER_ROW } wall_type;

/* One of its cells or walls. */
typedef struct entry {
    wall_type type;
    int x, y;
} entry;

typedef struct quadrant {
    const sl_gather_tables *tables;
    sl_hsh_recurrence recurrence;
    sl_projection *projection;
    entry *cells, *walls;
} quadrant;

static bool is_cell(const sl_gather_tables *t, int x, int y) {
    return t->length[(size_t)y * (size_t)t->width + (size_t)x] > 0.0f; /* else blank */
}

static void append(entry *list, size_t *count, wall_type type, int x, int y) {
    list[(*count)++] = (entry){type, x, y};
}

/* Lists the cells and walls whose middles have x >= 0 and y >= 0. */
static void list_quadrant(quadrant *q) {
    const sl_gather_tables *t = q->tables;
    size_t *cells = &q->projection->cells.count, *walls = &q->projection->walls.count;
    int width = t->width, first = width / 2;
    bool extended = sl_gather_is_extended(t);
    for (int y = first; y < width; y++) {
        for (int x = first; x < width; x++) {
            if (!is_cell(t, x, y)) continue;
            append(q->cells, cells, COLUMN, x, y);
            bool column = 2 * x >= width && is_cell(t, x - 1, y),
                 row = 2 * y >= width && is_cell(t, x, y - 1);
            if (column) append(q->walls, walls, COLUMN, x, y);
            if (row) append(q->walls, walls, ROW, x, y);
            if (column && extended && y == width - 1) append(q->walls, walls, BORDER_COLUMN, x, y);
            if (row && extended && x == width - 1) append(q->walls, walls, BORDER_ROW, x, y);
        }
    }
}

static uint32_t mirrored_cell(const sl_gather_tables *t, int x, int y, int image) {
    if (image & 1) x = t->width - 1 - x;
    if (image & 2) y = t->height - 1 - y;
    return (uint32_t)(y * t->width + x);
}

static void set_images(const quadrant *q, sl_projection_list *list, int end, entry e, size_t i) {
    for (int image = 0; image < 4; image++)
        list->cell[end][image][i] = mirrored_cell(q->tables, e.x, e.y, image);
}

static void set_wall_images(const quadrant *q, size_t i) {
    entry e = q->walls[i], from = e;
    if (e.type == COLUMN || e.type == BORDER_COLUMN) from.x--;
    else from.y--;
    set_images(q, &q->projection->walls, 0, from, i);
    set_images(q, &q->projection->walls, 1, e, i);
}

/* ---- integrals of the functions -------------------------------------------------------------- */

/* H_lm are spherical harmonics of the directions with 2 cos theta - 1 in place of cos theta, which keeps
 * ratios of solid angles: hemisphere and sphere. There cells are halved until no side is longer than this
 * angle, and walls, which count by the functions in the middle of each part, until none is longer than half
 * of it. */
static const double longest_side = 0.08;

/* Of a cell or wall that an axis cuts, only what lies in the quadrant. */
static double in_quadrant(const sl_gather_tables *t, int x) {
    double middle = 0.5 * t->width;
    return x > middle ? x : middle;
}

/* Returns the direction of a point of a cell (s to the right, r upwards), or of its border extension: s along
 * the edge (clockwise), r from there down to the horizon. All in [0,1]; in units of depth. */
static sl_vec3d place_in(const sl_gather_tables *t, entry cell, double s, double r) {
    double x = in_quadrant(t, cell.x), y = in_quadrant(t, cell.y);
    double along_y = cell.type == BORDER_ROW ? 1.0 - s : r;
    double right = x + s * (cell.x + 1 - x), up = y + along_y * (cell.y + 1 - y);
    if (cell.type != BORDER_ROW && cell.type != BORDER_COLUMN) return sl_gather_direction(t, right, up);
    sl_vec3d edge = cell.type == BORDER_ROW ? sl_gather_direction(t, t->width, up)
                                            : sl_gather_direction(t, right, t->width);
    return sl_v3d(edge.x, edge.y, (1.0 - r) * edge.z);
}

static sl_vec3d unit_of(sl_vec3d d) { return sl_scaled(d, 1.0 / sl_lengthd(d)); }
static double length_between(sl_vec3d a, sl_vec3d b) { return sl_lengthd(sl_subd(a, b)); }

/* The unit direction with the azimuth of d, and that cosine to the axis. */
static sl_vec3d at_height(sl_vec3d d, double cosine) {
    double tangential = sqrt(d.x * d.x + d.y * d.y), sine = sqrt(fmax(0.0, (1.0 - cosine) * (1.0 + cosine)));
    double scale = tangential > 0.0 ? sine / tangential : 0.0;
    return sl_v3d(scale * d.x, scale * d.y, cosine);
}

static sl_vec3d to_sphere(sl_vec3d d) { return at_height(d, 2.0 * d.z / sl_lengthd(d) - 1.0); }
static sl_vec3d from_sphere(sl_vec3d d) { return at_height(d, 0.5 + 0.5 * d.z / sl_lengthd(d)); }

static void add_functions(const quadrant *q, sl_vec3d direction, double weight, double *sums) {
    double values[SL_HSH_STRIDE_MAX];
    size_t stride = sl_hsh_stride(q->projection->order);
    sl_hsh_evaluate_by(&q->recurrence, direction, values);
    for (size_t i = 0; i < stride; i++) sums[i] += weight * values[i];
}

typedef struct range {
    double from, to;
} range;

static double middle_of(range whole) { return 0.5 * (whole.from + whole.to); }
static range half_of(range whole, int half) {
    return half ? (range){middle_of(whole), whole.to} : (range){whole.from, middle_of(whole)};
}

/* A patch on the sphere through 3 x 3 points, quadratic in both parameters, so that patches of different
 * sizes leave no gap at a curved line. */
typedef sl_vec3d patch[3][3];

static sl_vec3d on_patch(const patch points, const double across[3], const double along[3]) {
    sl_vec3d sum = {0.0, 0.0, 0.0};
    for (int j = 0; j < 3; j++)
        for (int i = 0; i < 3; i++) sum = sl_addd(sum, sl_scaled(points[j][i], across[j] * along[i]));
    return sum;
}

/* Adds the integral of every function over a patch, in solid angle: Gauss's rule of 2 x 2 points, which are
 * at (3 -+ sqrt 3) / 6. There parabolas through values at 0, 1/2 and 1 have these weights, and slopes. */
static void add_patch(const quadrant *q, const patch points, double *sums) {
    static const double value[2][3] = {{0.45534180126147955, 2.0 / 3.0, -0.12200846792814621},
                                       {-0.12200846792814621, 2.0 / 3.0, 0.45534180126147955}};
    static const double slope[2][3] = {{-2.1547005383792515, 2.3094010767585031, -0.15470053837925153},
                                       {0.15470053837925153, -2.3094010767585031, 2.1547005383792515}};
    for (int k = 0; k < 4; k++) {
        const double *u = value[k & 1], *v = value[k >> 1];
        sl_vec3d p = on_patch(points, v, u), turn = sl_crossd(on_patch(points, v, slope[k & 1]),
                                                               on_patch(points, slope[k >> 1], u));
        double length = sl_lengthd(p), angle = sl_dotd(p, turn) / (4.0 * length * length * length);
        add_functions(q, from_sphere(p), 0.5 * q->tables->scale * angle, sums);
    }
}

/* Adds the integral of every function over a part of a cell. Directions are halved each by its own sides'
 * length, so that the disc's diagonals, where its grid has kinks, only pass through corners of parts. */
static void add_part(const quadrant *q, entry cell, range s, range r, double *sums) {
    const double columns[3] = {s.from, middle_of(s), s.to}, rows[3] = {r.from, middle_of(r), r.to};
    patch p;
    for (int j = 0; j < 3; j++)
        for (int i = 0; i < 3; i++) p[j][i] = to_sphere(place_in(q->tables, cell, columns[i], rows[j]));
    bool wide = fmax(length_between(p[0][0], p[0][2]), length_between(p[2][0], p[2][2])) > longest_side,
         high = fmax(length_between(p[0][0], p[2][0]), length_between(p[0][2], p[2][2])) > longest_side;
    if (!wide && !high) {
        add_patch(q, p, sums);
        return;
    }
    for (int i = 0; i <= wide; i++)
        for (int j = 0; j <= high; j++)
            add_part(q, cell, wide ? half_of(s, i) : s, high ? half_of(r, j) : r, sums);
}

static void integrate_cell(const quadrant *q, entry cell, double *sums) {
    const range all = {0.0, 1.0};
    const int last = q->tables->width - 1;
    memset(sums, 0, sl_hsh_stride(q->projection->order) * sizeof *sums);
    add_part(q, cell, all, all, sums);
    if (!sl_gather_is_extended(q->tables)) return;
    if (cell.x == last) add_part(q, (entry){BORDER_ROW, cell.x, cell.y}, all, all, sums);
    if (cell.y == last) add_part(q, (entry){BORDER_COLUMN, cell.x, cell.y}, all, all, sums);
}

/* Returns the point of a wall at the share s of its way: seen along it, the cell that gains lies on its
 * right. In the border what stands there is taken to be upright, at the distance that it has at depth 1. */
static sl_vec3d wall_point(const sl_gather_tables *t, entry wall, double s) {
    switch (wall.type) {
    case COLUMN:
    case BORDER_COLUMN: return place_in(t, wall, 0.0, s);
    case ROW: return place_in(t, wall, 1.0 - s, 0.0);
    default: return place_in(t, wall, 1.0, 1.0 - s);
    }
}

typedef struct wall_sums {
    double x, y, size, *functions;
} wall_sums;

/* A wall is made by surfaces at depth 1. Displacing the receiver by delta in the surface gives the solid
 * angle (x, y) . delta to the cell beyond it, taken from the one before it: a piece e of it at the direction
 * d gives (e x d) . delta / |d|^3. Functions are weighted by that motion. */
static void add_wall_part(const quadrant *q, entry wall, double from, double to, wall_sums *sums) {
    sl_vec3d a = wall_point(q->tables, wall, from), b = wall_point(q->tables, wall, to);
    if (length_between(to_sphere(a), to_sphere(b)) > 0.5 * longest_side) {
        double half = 0.5 * (from + to);
        add_wall_part(q, wall, from, half, sums);
        add_wall_part(q, wall, half, to, sums);
        return;
    }
    sl_vec3d d = sl_scaled(sl_addd(a, b), 0.5), m = sl_crossd(sl_subd(b, a), d);
    double squared = sl_dotd(d, d), per_angle = 1.0 / (squared * sqrt(squared)),
           size = sqrt(m.x * m.x + m.y * m.y) * per_angle;
    sums->x += per_angle * m.x;
    sums->y += per_angle * m.y;
    sums->size += size;
    add_functions(q, unit_of(d), size, sums->functions);
}

/* Gives how it moves, and the mean of every function along it. */
static void integrate_wall(const quadrant *q, entry wall, wall_sums *sums) {
    size_t stride = sl_hsh_stride(q->projection->order);
    int line = wall.type == COLUMN || wall.type == BORDER_COLUMN ? wall.x : wall.y;
    /* on the axis it is its own mirror image */
    double scale = q->tables->scale * (2 * line == q->tables->width ? 0.5 : 1.0);
    memset(sums->functions, 0, stride * sizeof *sums->functions);
    add_wall_part(q, wall, 0.0, 1.0, sums);
    sums->x *= scale;
    sums->y *= scale;
    for (size_t i = 0; i < stride && sums->size > 0.0; i++) sums->functions[i] /= sums->size;
}

/* ---- tables ---------------------------------------------------------------------------------- */

static void set_row(const sl_projection *p, sl_projection_list *list, size_t i, const double *values) {
    float *block = list->table + i / BLOCK * (size_t)p->groups * BLOCK * GROUP + i % BLOCK * GROUP;
    for (int g = 0; g < p->groups; g++) {
        for (int c = 0; c < GROUP; c++) {
            uint32_t place = p->place[g * GROUP + c];
            block[g * BLOCK * GROUP + c] = place == SL_NO_INDEX ? 0.0f : (float)values[place];
        }
    }
}

static void fill_cells(void *context, size_t block, unsigned worker) {
    const quadrant *q = context;
    double sums[SL_HSH_STRIDE_MAX];
    (void)worker;
    for (size_t i = block * BLOCK; i < q->projection->cells.count && i < (block + 1) * BLOCK; i++) {
        integrate_cell(q, q->cells[i], sums);
        set_row(q->projection, &q->projection->cells, i, sums);
        set_images(q, &q->projection->cells, 0, q->cells[i], i);
    }
}

static void fill_walls(void *context, size_t block, unsigned worker) {
    const quadrant *q = context;
    sl_projection_list *list = &q->projection->walls;
    double mean[SL_HSH_STRIDE_MAX];
    (void)worker;
    for (size_t i = block * BLOCK; i < list->count && i < (block + 1) * BLOCK; i++) {
        wall_sums sums = {.functions = mean};
        integrate_wall(q, q->walls[i], &sums);
        list->x[i] = (float)sums.x;
        list->y[i] = (float)sums.y;
        set_row(q->projection, list, i, mean);
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
    SL_FREE_ALL(list->table, list->cell[0][0], list->x);
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
    size_t side = (size_t)q->tables->width / 2 + 1;
    q->cells = sl_allocate(side * side, sizeof *q->cells);
    q->walls = sl_allocate(4 * side * side, sizeof *q->walls);
    bool room = q->cells && q->walls;
    if (room) list_quadrant(q);
    sl_status status = room ? allocate_list(&p->cells, p->groups, 1, error)
                            : sl_fail_memory(error, "tables of hemispherical harmonics");
    if (status == SL_OK) status = allocate_list(&p->walls, p->groups, 2, error);
    if (status == SL_OK) {
        sl_parallel_for(threads, p->cells.blocks, fill_cells, q);
        sl_parallel_for(threads, p->walls.blocks, fill_walls, q);
    }
    sl_free(q->cells);
    sl_free(q->walls);
    return status;
}

sl_status sl_projection_create(const sl_gather_tables *tables, int order, unsigned threads,
                               sl_projection **out, sl_error *error) {
    *out = NULL;
    sl_projection *p = sl_allocate(1, sizeof *p);
    if (!p) return sl_fail_memory(error, "tables of hemispherical harmonics");
    p->order = order;
    order_columns(p);
    quadrant q = {.tables = tables, .projection = p};
    sl_hsh_recurrence_of(order, &q.recurrence);
    sl_status status = fill(&q, threads, error);
    if (status == SL_OK) *out = p;
    else sl_projection_destroy(p);
    return status;
}

/* ---- one projection -------------------------------------------------------------------------- */

void sl_project(const sl_projection *p, sl_isa isa, const float *const picture[4], float *coefficients) {
    sl_projection_sums sums;
    size_t stride = sl_hsh_stride(p->order);
    SL_KERNEL_OF(isa, sl_projection_sums)(p, picture, &sums);
    memset(coefficients, 0, SL_PROJECTION_VECTORS * stride * sizeof *coefficients);
    for (int g = 0; g < p->groups; g++) {
        for (int c = 0; c < GROUP; c++) {
            uint32_t place = p->place[g * GROUP + c];
            for (size_t v = 0; place != SL_NO_INDEX && v < SL_PROJECTION_VECTORS; v++)
                coefficients[v * stride + place] = (float)sums.sum[g][v][c];
        }
    }
}
