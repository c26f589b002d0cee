#include "cache/hemisphere/gather_tables.h"

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"

enum { TILE = 4, PLANES = 20, WEIGHTS = 14 /* of these, the first ones */ };

/* ---- any cell bounded by great circles ------------------------------------------------------- */

/* The integral of omega over a spherical polygon is a sum over its edges: half the angle along the normal of
 * the edge's plane. */
sl_vec3d sl_cell_vector(const sl_vec3d *corners, int count) {
    sl_vec3d sum = {0.0, 0.0, 0.0};
    for (int i = 0; i < count; i++) {
        sl_vec3d a = corners[i], b = corners[(i + 1) % count], normal = sl_crossd(a, b);
        double length = sl_lengthd(normal);
        if (!(length > 0.0)) continue; /* no edge, or one through the eye: its plane is undefined */
        sum = sl_addd(sum, sl_scaled(normal, 0.5 * sl_atan2(length, sl_dotd(a, b)) / length));
    }
    return sum;
}

/* ---- edges: what moves when the receiver moves ----------------------------------------------- */

/* An edge from a to b seen from the origin: its line's foot h, its unit direction, and the integrals of s^k /
 * (h^2 + s^2)^2 along it (k = 1: j1, k = 0: j2). False where there is no edge, or the origin lies on its
 * line. */
typedef struct edge {
    sl_vec3d foot, along;
    double j1, j2;
} edge;

static bool make_edge(sl_vec3d a, sl_vec3d b, edge *e) {
    sl_vec3d difference = sl_subd(b, a);
    double length = sl_lengthd(difference);
    if (!(length > 0.0)) return false;
    e->along = sl_scaled(difference, 1.0 / length);
    double s0 = sl_dotd(a, e->along), s1 = s0 + length;
    e->foot = sl_subd(a, sl_scaled(e->along, s0));
    double h = sl_lengthd(e->foot);
    if (!(h >= 1e-9 * length)) return false;
    double r0 = h * h + s0 * s0, r1 = h * h + s1 * s1;
    e->j1 = 0.5 * (1.0 / r0 - 1.0 / r1);
    e->j2 = (s1 / r1 - s0 / r0) / (2.0 * h * h) + sl_atan2(length * h, h * h + s0 * s1) / (2.0 * h * h * h);
    return true;
}

/* A point d of the wall, |d| = l, is seen to move by -delta_perp / l (depth 1), and sweeps (e x d) . delta /
 * l^3 of solid angle an element; times the cosine n . d / l. e x d is the same all along the edge, n . d is
 * linear on it. */
sl_vec3d sl_wall_vector(sl_vec3d a, sl_vec3d b) {
    edge e;
    if (!make_edge(a, b, &e)) return sl_v3d(0.0, 0.0, 0.0);
    return sl_scaled(sl_crossd(e.along, e.foot), e.foot.z * e.j2 + e.along.z * e.j1);
}

/* ---- second derivatives ---------------------------------------------------------------------- */

/* Nusselt's disc, q = the tangential part of the direction, has equal areas where cosine weights are equal,
 * so that second derivatives are those of areas and need none of a kernel. A point at distance l is seen at
 *     q(delta) = q + (s q - delta) / l + (q (3 s^2 - delta^2) / 2 - s delta) / l^2 + ...,   s = q . delta. */
typedef struct disc_point {
    double x, y, distance;
} disc_point;

static disc_point on_disc(sl_vec3d direction) {
    double length = sl_lengthd(direction);
    return (disc_point){direction.x / length, direction.y / length, length};
}

/* A segment from q0 to q1 sweeps half the cross product of the diagonals (q1' - q0) x (q0' - q1) to its left:
 * with D = q1 - q0, first order d and second order e of each end, that is half of D x (d0 + d1) + D x (e0 +
 * e1) + d1 x d0. The last two, for one displacement. */
static double swept(disc_point a, disc_point b, double x, double y) {
    double sum[2] = {0.0, 0.0}, d[2][2];
    const disc_point ends[2] = {a, b};
    for (int i = 0; i < 2; i++) {
        const disc_point q = ends[i];
        double near = 1.0 / q.distance, s = q.x * x + q.y * y, along = 0.5 * (3.0 * s * s - x * x - y * y);
        d[i][0] = (s * q.x - x) * near;
        d[i][1] = (s * q.y - y) * near;
        sum[0] += (along * q.x - s * x) * near * near;
        sum[1] += (along * q.y - s * y) * near * near;
    }
    double crossed = (b.x - a.x) * sum[1] - (b.y - a.y) * sum[0];
    return 0.5 * (crossed + d[1][0] * d[0][1] - d[1][1] * d[0][0]);
}

/* A wall is straight in space and an arc on the disc: short pieces of it are straight enough. */
sl_curvature sl_wall_curvature(sl_vec3d a, sl_vec3d b) {
    enum { PIECES = 8 };
    sl_curvature sum = {0.0, 0.0, 0.0};
    disc_point from = on_disc(a);
    for (int i = 1; i <= PIECES; i++) {
        double share = (double)i / PIECES;
        disc_point to = on_disc(sl_addd(sl_scaled(a, 1.0 - share), sl_scaled(b, share)));
        double xx = swept(from, to, 1.0, 0.0), yy = swept(from, to, 0.0, 1.0),
               both = swept(from, to, 1.0, 1.0);
        sum.xx += 2.0 * xx;
        sum.yy += 2.0 * yy;
        sum.xy += both - xx - yy;
        from = to;
    }
    return sum;
}

/* ---- memory ---------------------------------------------------------------------------------- */

static sl_status allocate_tables(sl_gather_tables *t, sl_error *error) {
    float **const planes[PLANES] = {
        &t->weight,      &t->weight_by_depth, &t->vector_x,  &t->vector_y,  &t->column.x,
        &t->column.y,    &t->column.xx,       &t->column.xy, &t->column.yy, &t->row.x,
        &t->row.y,       &t->row.xx,          &t->row.xy,    &t->row.yy, /* WEIGHTS */
        &t->direction_x, &t->direction_y,     &t->direction_z, &t->length,  &t->slot_a, &t->slot_b};
    t->block = sl_allocate_planes(t->padded, PLANES, planes);
    t->order = sl_allocate(t->cells, sizeof(uint32_t));
    return t->block && t->order ? SL_OK : sl_fail_memory(error, "the gather's tables");
}

void sl_gather_tables_destroy(sl_gather_tables *t) {
    if (!t) return;
    SL_FREE_ALL(t->block, t->order, t);
}

size_t sl_gather_tables_bytes(const sl_gather_tables *t) {
    return sizeof *t + t->padded * PLANES * sizeof(float) + t->cells * sizeof(uint32_t);
}

/* ---- common to all --------------------------------------------------------------------------- */

static void set_cell(sl_gather_tables *t, size_t i, sl_vec3d vector, sl_vec3d direction) {
    double length = sl_lengthd(direction);
    t->weight[i] = (float)vector.z;
    t->weight_by_depth[i] = (float)(vector.z / length);
    t->vector_x[i] = (float)vector.x;
    t->vector_y[i] = (float)vector.y;
    t->direction_x[i] = (float)direction.x;
    t->direction_y[i] = (float)direction.y;
    t->direction_z[i] = (float)direction.z;
    t->length[i] = (float)length;
    t->weight_sum += vector.z;
}

/* Tiles of 4 x 4 in rows: packets of 16 rays stay together, neighbours in memory are neighbours in the
 * picture. */
static void order_cells(sl_gather_tables *t) {
    for (int ty = 0; ty < t->height; ty += TILE) {
        for (int tx = 0; tx < t->width; tx += TILE) {
            for (int y = ty; y < ty + TILE && y < t->height; y++) {
                for (int x = tx; x < tx + TILE && x < t->width; x++) {
                    size_t i = (size_t)y * (size_t)t->width + (size_t)x;
                    if (!(t->length[i] > 0.0f)) continue; /* blank */
                    t->slot_a[t->used] = (float)(2.0 * x / t->width - 1.0);
                    t->slot_b[t->used] = (float)(2.0 * y / t->height - 1.0);
                    t->order[t->used++] = (uint32_t)i;
                }
            }
        }
    }
}

/* ---- directions ------------------------------------------------------------------------------ */

void sl_concentric_disc(double a, double b, double *x, double *y) {
    double radius = 0.0, azimuth = 0.0;
    if (fabs(a) > fabs(b)) {
        radius = a;
        azimuth = 0.25 * SL_PI * b / a;
    } else if (b != 0.0) {
        radius = b;
        azimuth = 0.5 * SL_PI - 0.25 * SL_PI * a / b;
    }
    *x = radius * sl_cos(azimuth);
    *y = radius * sl_sin(azimuth);
}

static sl_vec3d on_map(double a, double b) {
    double x, y;
    sl_concentric_disc(a, b, &x, &y);
    return sl_v3d(x, y, sqrt(fmax(0.0, 1.0 - x * x - y * y)));
}

/* The hemicube in units where its top is [-1,1]^2 and the sides, folded out, reach to 2: a side's height is
 * what is missing to 2. Where faces meet they agree. */
static sl_vec3d on_hemicube(double a, double b) {
    if (fabs(a) > 1.0) return sl_v3d(a > 0.0 ? 1.0 : -1.0, b, 2.0 - fabs(a));
    if (fabs(b) > 1.0) return sl_v3d(a, b > 0.0 ? 1.0 : -1.0, 2.0 - fabs(b));
    return sl_v3d(a, b, 1.0);
}

sl_vec3d sl_gather_direction(const sl_gather_tables *t, double x, double y) {
    double step = 2.0 / t->size, half = 1.0 * t->width / t->size;
    double a = x * step - half, b = y * step - half;
    if (t->kind == SL_GATHER_PLANE) return sl_v3d(t->half_tangent * a, t->half_tangent * b, 1.0);
    return t->kind == SL_GATHER_HEMICUBE ? on_hemicube(a, b) : on_map(a, b);
}

static bool is_blank(const sl_gather_tables *t, int x, int y) {
    int n = t->size;
    bool middle_x = x >= n / 2 && x < n / 2 + n, middle_y = y >= n / 2 && y < n / 2 + n;
    return t->kind == SL_GATHER_HEMICUBE && !middle_x && !middle_y;
}

/* ---- cells ----------------------------------------------------------------------------------- */

/* Integral of omega from an edge of the plane's border along the meridians down to the horizon. */
static sl_vec3d extension(sl_vec3d from, sl_vec3d to) {
    const sl_vec3d corners[4] = {from, sl_v3d(from.x, from.y, 0.0), sl_v3d(to.x, to.y, 0.0), to};
    return sl_cell_vector(corners, 4);
}

/* A corner pixel owns two edges. corners: counter-clockwise from the lower left. */
static sl_vec3d border_of(const sl_gather_tables *t, const sl_vec3d corners[4], int x, int y) {
    const bool outer[4] = {y == 0, x == t->width - 1, y == t->height - 1, x == 0};
    sl_vec3d sum = {0.0, 0.0, 0.0};
    for (int k = 0; k < 4; k++) {
        if (outer[k]) sum = sl_addd(sum, extension(corners[k], corners[(k + 1) % 4]));
    }
    return sum;
}

/* Cells lie between great circles; those of rays nearly, but their cosine weights are just equal. */
static void fill_cell(sl_gather_tables *t, size_t i, int x, int y) {
    const sl_vec3d c[4] = {sl_gather_direction(t, x, y), sl_gather_direction(t, x + 1, y),
                           sl_gather_direction(t, x + 1, y + 1), sl_gather_direction(t, x, y + 1)};
    sl_vec3d vector = sl_cell_vector(c, 4);
    if (sl_gather_is_extended(t)) vector = sl_addd(vector, border_of(t, c, x, y));
    if (t->kind == SL_GATHER_RAYS) vector.z = SL_PI / ((double)t->size * t->size);
    set_cell(t, i, vector, sl_gather_direction(t, x + 0.5, y + 0.5));
}

/* ---- walls ----------------------------------------------------------------------------------- */

static void set_wall(const sl_wall_planes *walls, size_t i, sl_vec3d a, sl_vec3d b) {
    const sl_vec3d wall = sl_wall_vector(a, b);
    const sl_curvature k = sl_wall_curvature(a, b);
    walls->x[i] = (float)wall.x;
    walls->y[i] = (float)wall.y;
    walls->xx[i] = (float)k.xx;
    walls->xy[i] = (float)k.xy;
    walls->yy[i] = (float)k.yy;
}

/* Derives how the walls between a cell and those to its left and below it move with the receiver, to the
 * second order (Schwarzhaupt, Jensen, Jarosz 2012 have the idea that occlusion belongs into the Hessian).
 * Seen along the wall, the cell lies on its right. Walls where the hemicube's side faces meet, at azimuths of
 * 45 degrees, are left out. */
static void fill_walls(sl_gather_tables *t, size_t i, int x, int y) {
    sl_vec3d here = sl_gather_direction(t, x, y), right = sl_gather_direction(t, x + 1, y),
             up = sl_gather_direction(t, x, y + 1);
    if (x > 0 && !is_blank(t, x - 1, y)) set_wall(&t->column, i, here, up);
    if (y > 0 && !is_blank(t, x, y - 1)) set_wall(&t->row, i, right, here);
}

static void fill(sl_gather_tables *t, bool walls) {
    for (int y = 0; y < t->height; y++) {
        for (int x = 0; x < t->width; x++) {
            size_t i = (size_t)y * (size_t)t->width + (size_t)x;
            if (is_blank(t, x, y)) continue;
            fill_cell(t, i, x, y);
            if (walls) fill_walls(t, i, x, y);
        }
    }
}

/* [LC04]: everything over the share F of the cosine-weighted hemisphere that the plane covers. */
static void divide_by_coverage(sl_gather_tables *t) {
    float *weights = t->weight;
    t->scale = SL_PI / t->weight_sum;
    for (size_t i = 0; i < WEIGHTS * t->padded; i++) weights[i] = (float)(t->scale * (double)weights[i]);
    t->weight_sum = SL_PI;
}

/* ---- creation -------------------------------------------------------------------------------- */

sl_status sl_gather_tables_create(sl_gather_kind kind, int size, double half_tangent, sl_border border,
                                  bool walls, sl_gather_tables **tables, sl_error *error) {
    *tables = NULL;
    sl_gather_tables *t = sl_allocate(1, sizeof *t);
    if (!t) return sl_fail_memory(error, "the gather's tables");
    t->kind = kind;
    t->border = border;
    t->half_tangent = half_tangent;
    t->scale = 1.0;
    t->size = kind == SL_GATHER_HEMICUBE ? size + size % 2 : size;
    t->width = t->height = kind == SL_GATHER_HEMICUBE ? 2 * t->size : t->size;
    t->cells = (size_t)t->width * (size_t)t->height;
    t->padded = (t->cells + SL_GATHER_LANES - 1) / SL_GATHER_LANES * SL_GATHER_LANES;
    sl_status status = allocate_tables(t, error);
    if (status != SL_OK) {
        sl_gather_tables_destroy(t);
        return status;
    }
    fill(t, walls);
    if (kind == SL_GATHER_PLANE && border == SL_BORDER_LC04) divide_by_coverage(t);
    order_cells(t);
    *tables = t;
    return SL_OK;
}
