#include "cache/hemisphere/gather_tables.h"

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "cache/hemisphere/hemisphere_tables.h"

enum { TILE = 4, PLANES = 23 };

/* ---- memory ---------------------------------------------------------------------------------- */

static sl_status allocate_tables(sl_gather_tables *t, sl_error *error) {
    float **const planes[PLANES] = {&t->weight,   &t->weight_by_depth, &t->vector_x,    &t->vector_y,
                              &t->column_x, &t->column_y,        &t->row_x,       &t->row_y,
                              &t->direction_x, &t->direction_y,  &t->direction_z, &t->length,
                              &t->slot_a,   &t->slot_b,
                              &t->column_xx, &t->column_xy, &t->column_yy, &t->row_xx, &t->row_xy, &t->row_yy,
                              &t->vertex_xx, &t->vertex_xy, &t->vertex_yy};
    t->block = sl_allocate_planes(t->padded, PLANES, planes);
    t->order = sl_allocate(t->cells, sizeof(uint32_t));
    return t->block && t->order ? SL_OK : sl_fail_memory(error, "the gather's tables");
}

void sl_gather_tables_destroy(sl_gather_tables *t) {
    if (!t) return;
    sl_free(t->block);
    sl_free(t->order);
    sl_free(t);
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

/* ---- plane and hemicube: cells between great circles ----------------------------------------- */

/* The direction of the grid's corner (x, y), in units of depth. */
typedef sl_vec3d corner_of(const sl_gather_tables *tables, double half_tangent, int x, int y);

static sl_vec3d plane_corner(const sl_gather_tables *t, double half_tangent, int x, int y) {
    return sl_v3d(half_tangent * (2.0 * x / t->size - 1.0), half_tangent * (2.0 * y / t->size - 1.0), 1.0);
}

/* The picture in units where the top is [-1,1]^2 and the sides, folded out, reach to 2: a side's height is
 * what is missing to 2. Where faces meet they agree. */
static sl_vec3d hemicube_corner(const sl_gather_tables *t, double half_tangent, int x, int y) {
    double a = x * (2.0 / t->size) - 2.0, b = y * (2.0 / t->size) - 2.0;
    (void)half_tangent;
    if (fabs(a) > 1.0) return sl_v3d(a > 0.0 ? 1.0 : -1.0, b, 2.0 - fabs(a));
    if (fabs(b) > 1.0) return sl_v3d(a, b > 0.0 ? 1.0 : -1.0, 2.0 - fabs(b));
    return sl_v3d(a, b, 1.0);
}

static bool is_blank(const sl_gather_tables *t, int x, int y) {
    int n = t->size;
    bool middle_x = x >= n / 2 && x < n / 2 + n, middle_y = y >= n / 2 && y < n / 2 + n;
    return t->kind == SL_GATHER_HEMICUBE && !middle_x && !middle_y;
}

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

static void set_wall(float *x, float *y, sl_vec3d a, sl_vec3d b) {
    sl_vec3d wall = sl_wall_vector(a, b);
    *x = (float)wall.x;
    *y = (float)wall.y;
}

/* Walls where the hemicube's side faces meet, at azimuths of 45 degrees, are left out. */
static void fill_flat(sl_gather_tables *t, corner_of *corner, double half_tangent, bool extended) {
    for (int y = 0; y < t->height; y++) {
        for (int x = 0; x < t->width; x++) {
            if (is_blank(t, x, y)) continue;
            size_t i = (size_t)y * (size_t)t->width + (size_t)x;
            const sl_vec3d c[4] = {corner(t, half_tangent, x, y), corner(t, half_tangent, x + 1, y),
                                   corner(t, half_tangent, x + 1, y + 1), corner(t, half_tangent, x, y + 1)};
            sl_vec3d vector = sl_cell_vector(c, 4), sum = sl_addd(sl_addd(c[0], c[1]), sl_addd(c[2], c[3]));
            if (extended) vector = sl_addd(vector, border_of(t, c, x, y));
            set_cell(t, i, vector, sl_scaled(sum, 0.25));
            if (x > 0 && !is_blank(t, x - 1, y)) set_wall(&t->column_x[i], &t->column_y[i], c[0], c[3]);
            if (y > 0 && !is_blank(t, x, y - 1)) set_wall(&t->row_x[i], &t->row_y[i], c[1], c[0]);
        }
    }
}

/* [LC04]: everything over the share F of the cosine-weighted hemisphere that the plane covers. */
static void divide_by_coverage(sl_gather_tables *t) {
    double scale = SL_PI / t->weight_sum;
    float *planes[] = {t->weight,    t->weight_by_depth, t->vector_x,  t->vector_y,  t->column_x, t->column_y,
                       t->row_x,     t->row_y,           t->column_xx, t->column_xy, t->column_yy, t->row_xx,
                       t->row_xy,    t->row_yy,          t->vertex_xx, t->vertex_xy, t->vertex_yy};
    for (size_t p = 0; p < sizeof planes / sizeof *planes; p++) {
        for (size_t i = 0; i < t->cells; i++) planes[p][i] = (float)(scale * (double)planes[p][i]);
    }
    t->weight_sum = SL_PI;
}

/* ---- rays: the concentric map ---------------------------------------------------------------- */

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

/* Any strata on Nusselt's disc, where equal areas are equal cosine weights. A point q of it moves by (s q -
 * delta) / r, s = q . delta, when the receiver moves by delta; so the cell on the right of the wall from a to
 * b gains the area g . delta / r from the one on its left: g = N - (q . N) q, q the wall's middle, N its
 * length turned to the right. */
static void disc_wall(double ax, double ay, double bx, double by, float *out_x, float *out_y) {
    double normal_x = by - ay, normal_y = ax - bx, x = 0.5 * (ax + bx), y = 0.5 * (ay + by);
    double inward = x * normal_x + y * normal_y;
    *out_x = (float)(normal_x - inward * x);
    *out_y = (float)(normal_y - inward * y);
}

/* A cell is a piece of the annulus between its ring's radii; its vector has the annulus' mean sine, finite at
 * the horizon where a ray's tangent is not. */
static sl_vec3d disc_cell_vector(int n, double a, double b) {
    double middle = fmax(fabs(a), fabs(b)), outer = fmin(1.0, middle + 1.0 / n),
           inner = fmax(0.0, middle - 1.0 / n), x, y;
    double area = SL_PI / ((double)n * n);
    double azimuth_range = 2.0 * area / (outer * outer - inner * inner);
    double sines = 0.5 * (sl_asin(outer) - outer * sqrt(fmax(0.0, 1.0 - outer * outer))) -
                   0.5 * (sl_asin(inner) - inner * sqrt(fmax(0.0, 1.0 - inner * inner)));
    sl_concentric_disc(a, b, &x, &y);
    double radius = sqrt(x * x + y * y);
    if (!(radius > 0.0)) return sl_v3d(0.0, 0.0, area); /* the one middle cell of an odd grid */
    double length = 2.0 * sl_sin(0.5 * azimuth_range) * sines / radius;
    return sl_v3d(length * x, length * y, area);
}

static void fill_rays(sl_gather_tables *t) {
    int n = t->size;
    double step = 2.0 / n;
    for (int y = 0; y < n; y++) {
        for (int x = 0; x < n; x++) {
            size_t i = (size_t)y * (size_t)n + (size_t)x;
            double a = x * step - 1.0, b = y * step - 1.0, px, py, corner[4][2];
            sl_concentric_disc(a, b, &corner[0][0], &corner[0][1]);
            sl_concentric_disc(a + step, b, &corner[1][0], &corner[1][1]);
            sl_concentric_disc(a, b + step, &corner[3][0], &corner[3][1]);
            sl_concentric_disc(a + 0.5 * step, b + 0.5 * step, &px, &py);
            double pz = sqrt(fmax(0.0, 1.0 - px * px - py * py));
            set_cell(t, i, disc_cell_vector(n, a + 0.5 * step, b + 0.5 * step), sl_v3d(px, py, pz));
            if (x)
                disc_wall(corner[0][0], corner[0][1], corner[3][0], corner[3][1], &t->column_x[i],
                          &t->column_y[i]);
            if (y)
                disc_wall(corner[1][0], corner[1][1], corner[0][0], corner[0][1], &t->row_x[i], &t->row_y[i]);
        }
    }
}

static sl_vec3d disc_corner(const sl_gather_tables *t, double half_tangent, int x, int y) {
    double px, py;
    (void)half_tangent;
    sl_concentric_disc(x * (2.0 / t->size) - 1.0, y * (2.0 / t->size) - 1.0, &px, &py);
    return sl_v3d(px, py, sqrt(fmax(0.0, 1.0 - px * px - py * py)));
}

/* ---- second derivatives ---- */

static void set_curvature(float *xx, float *xy, float *yy, sl_curvature k) {
    *xx = (float)k.xx;
    *xy = (float)k.xy;
    *yy = (float)k.yy;
}

static bool is_cell(const sl_gather_tables *t, int x, int y) {
    return x >= 0 && y >= 0 && t->length[(size_t)y * (size_t)t->width + (size_t)x] > 0.0f;
}

/* Finds how the walls between cells, and the corners where four of them meet, move with the receiver beyond
 * the first order (Schwarzhaupt, Jensen, Jarosz 2012 have the idea that occlusion belongs into the Hessian).
 * corner: the direction of the grid's corner (x, y), in units of depth. */
static void fill_curvatures(sl_gather_tables *t, corner_of *corner, double half_tangent) {
    for (int y = 0; y < t->height; y++) {
        for (int x = 0; x < t->width; x++) {
            size_t i = (size_t)y * (size_t)t->width + (size_t)x;
            if (!is_cell(t, x, y)) continue;
            bool has_left = is_cell(t, x - 1, y), has_below = is_cell(t, x, y - 1);
            sl_vec3d here = corner(t, half_tangent, x, y), right = corner(t, half_tangent, x + 1, y),
                     up = corner(t, half_tangent, x, y + 1);
            /* Seen along the wall, the cell lies on its right. */
            if (has_left)
                set_curvature(&t->column_xx[i], &t->column_xy[i], &t->column_yy[i],
                              sl_wall_curvature(here, up));
            if (has_below)
                set_curvature(&t->row_xx[i], &t->row_xy[i], &t->row_yy[i], sl_wall_curvature(right, here));
            if (!has_left || !has_below || !is_cell(t, x - 1, y - 1)) continue;
            sl_curvature k = sl_vertex_curvature(here, right, corner(t, half_tangent, x - 1, y), up,
                                                 corner(t, half_tangent, x, y - 1));
            set_curvature(&t->vertex_xx[i], &t->vertex_xy[i], &t->vertex_yy[i], k);
        }
    }
}

/* ---- creation -------------------------------------------------------------------------------- */

sl_status sl_gather_tables_create(sl_gather_kind kind, int size, double half_tangent, sl_border border,
                                  sl_gather_tables **tables, sl_error *error) {
    *tables = NULL;
    sl_gather_tables *t = sl_allocate(1, sizeof *t);
    if (!t) return sl_fail_memory(error, "the gather's tables");
    t->kind = kind;
    t->size = kind == SL_GATHER_HEMICUBE ? size + size % 2 : size;
    t->width = t->height = kind == SL_GATHER_HEMICUBE ? 2 * t->size : t->size;
    t->cells = (size_t)t->width * (size_t)t->height;
    t->padded = (t->cells + SL_GATHER_LANES - 1) / SL_GATHER_LANES * SL_GATHER_LANES;
    sl_status status = allocate_tables(t, error);
    if (status != SL_OK) {
        sl_gather_tables_destroy(t);
        return status;
    }
    if (kind == SL_GATHER_HEMICUBE) {
        fill_flat(t, hemicube_corner, half_tangent, false);
        fill_curvatures(t, hemicube_corner, half_tangent);
    } else if (kind == SL_GATHER_PLANE) {
        fill_flat(t, plane_corner, half_tangent, border == SL_BORDER_RADIAL);
        fill_curvatures(t, plane_corner, half_tangent);
        if (border == SL_BORDER_LC04) divide_by_coverage(t);
    } else {
        fill_rays(t);
        fill_curvatures(t, disc_corner, half_tangent);
    }
    order_cells(t);
    *tables = t;
    return SL_OK;
}
