/* The resolution's loops over lanes; resolve.h has their order. */
#include <string.h>

#include "base/lanes.h"
#include "raster/resolve/barycentrics.h"
#include "raster/resolve/resolve.h"
#include "scene/surface_rules.h"

/* Pixels of a run done together, floats and doubles. A run's last ones go beyond its end, so no wider than
 * the vectors. */
enum { LANES = SL_WIDTH, DOUBLE_LANES = SL_WIDTH / 2 };

/* Loops over runs or pixels do whole lanes: what lies beyond the count was valid once, or 0. */
static inline uint32_t whole_lanes(uint32_t count) { return (count + SL_LANES - 1) / SL_LANES * SL_LANES; }

/* Bytes that are 0 or 1, eight at once, and the first of them that is 1 (x86 is little-endian). */
static inline uint64_t eight_bytes(const uint8_t *bytes) {
    uint64_t word;
    memcpy(&word, bytes, sizeof word);
    return word;
}
static inline uint32_t lowest_byte(uint64_t set) { return (uint32_t)__builtin_ctzll(set) / 8; }

/* ---- runs ---- */

/* Where the index changes, as bytes, 64 pixels at a time; then only at the changes. */
void SL_KERNEL(sl_resolve_runs)(sl_resolve_block *block, size_t count) {
    const uint32_t most = count < SL_RESOLVE_PIXELS ? (uint32_t)count : SL_RESOLVE_PIXELS;
    uint32_t runs = 1;
    block->start[0] = 0;
    for (uint32_t first = 0; first < most; first += 64) {
        const uint32_t *restrict id = block->id + first, lanes = most - first < 64 ? most - first : 64;
        uint8_t changes[64] = {0};
        changes[0] = first > 0 && id[0] != id[-1];
#pragma omp simd
        for (uint32_t l = 1; l < lanes; l++) changes[l] = id[l] != id[l - 1];
        for (uint32_t group = 0; group < 64; group += 8) {
            for (uint64_t set = eight_bytes(changes + group); set; set &= set - 1) {
                block->start[runs] = first + group + lowest_byte(set);
                if (runs++ < SL_RESOLVE_RUNS) continue;
                block->runs = SL_RESOLVE_RUNS;
                block->count = block->start[SL_RESOLVE_RUNS];
                return;
            }
        }
    }
    block->start[runs] = most;
    block->runs = runs;
    block->count = most;
}

/* ---- weights ---- */

/* Columns and rows of the block's pixels. */
static void locate_pixels(sl_resolve_block *block, const sl_pass_view *view) {
    double *restrict column = block->column, *restrict row = block->row;
    const double width = (double)view->width, inverse = 1.0 / width;
    const int32_t first = (int32_t)block->first, count = (int32_t)block->count,
                  lanes = (int32_t)whole_lanes(block->count);
    const uint32_t *restrict pixel = block->pixel;
    if (pixel) {
#pragma omp simd
        for (int32_t n = 0; n < count; n++) column[n] = (double)(int32_t)pixel[n];
    } else {
#pragma omp simd
        for (int32_t n = 0; n < lanes; n++) column[n] = (double)(first + n);
    }
#pragma omp simd
    for (int32_t n = 0; n < lanes; n++) {
        double y = (double)(int32_t)((column[n] + 0.5) * inverse); /* the half outweighs what is rounded */
        row[n] = y;
        column[n] -= y * width;
    }
}

static void make_lines(sl_resolve_block *block, const sl_pass_view *view) {
    const float eye_x = view->origin[0], eye_y = view->origin[1], eye_z = view->origin[2];
    const float(*restrict x)[SL_RESOLVE_RUNS] = block->corner.x,
                          (*restrict y)[SL_RESOLVE_RUNS] = block->corner.y,
                          (*restrict z)[SL_RESOLVE_RUNS] = block->corner.z;
    double *restrict a0 = block->a0, *restrict b0 = block->b0, *restrict c0 = block->c0,
                     *restrict a1 = block->a1;
    double *restrict b1 = block->b1, *restrict c1 = block->c1, *restrict a2 = block->a2,
                     *restrict b2 = block->b2;
    double *restrict c2 = block->c2, *restrict origin_x = block->origin_x,
                     *restrict origin_y = block->origin_y;
    const uint32_t runs = whole_lanes(block->runs);
#pragma omp simd
    for (uint32_t r = 0; r < runs; r++) {
        sl_edge_lines l = sl_edge_lines_make(view, sl_v3(x[0][r] - eye_x, y[0][r] - eye_y, z[0][r] - eye_z),
                                             sl_v3(x[1][r] - eye_x, y[1][r] - eye_y, z[1][r] - eye_z),
                                             sl_v3(x[2][r] - eye_x, y[2][r] - eye_y, z[2][r] - eye_z));
        a0[r] = l.a0, b0[r] = l.b0, c0[r] = l.c0;
        a1[r] = l.a1, b1[r] = l.b1, c1[r] = l.c1;
        a2[r] = l.a2, b2[r] = l.b2, c2[r] = l.c2;
        origin_x[r] = l.x;
        origin_y[r] = l.y;
    }
}

/* Lines whose weights are 0 everywhere. */
static void make_background(sl_resolve_block *block) {
    for (uint32_t r = 0; r < block->runs; r++) {
        if (sl_run_triangle(block, r) != SL_NO_INDEX) continue;
        block->a0[r] = block->b0[r] = block->a1[r] = block->b1[r] = 0.0;
        block->c1[r] = block->a2[r] = block->b2[r] = block->c2[r] = 0.0;
        block->c0[r] = 1.0;
    }
}

static void evaluate_lines(sl_resolve_block *block) {
    for (uint32_t r = 0; r < block->runs; r++) {
        const double la0 = block->a0[r], lb0 = block->b0[r], lc0 = block->c0[r], la1 = block->a1[r],
                     lb1 = block->b1[r];
        const double lc1 = block->c1[r], la2 = block->a2[r], lb2 = block->b2[r], lc2 = block->c2[r];
        const double x = block->origin_x[r], y = block->origin_y[r];
        for (uint32_t n = block->start[r]; n < block->start[r + 1]; n += DOUBLE_LANES) {
            const double *restrict column = block->column + n, *restrict row = block->row + n;
            double *restrict e0 = block->e0 + n, *restrict e1 = block->e1 + n, *restrict e2 = block->e2 + n;
#pragma omp simd
            for (int l = 0; l < DOUBLE_LANES; l++) {
                double dx = column[l] - x, dy = row[l] - y;
                e0[l] = sl_edge_at(la0, lb0, lc0, dx, dy);
                e1[l] = sl_edge_at(la1, lb1, lc1, dx, dy);
                e2[l] = sl_edge_at(la2, lb2, lc2, dx, dy);
            }
        }
    }
}

static void divide_by_sums(sl_resolve_block *block) {
    const double *restrict e0 = block->e0, *restrict e1 = block->e1, *restrict e2 = block->e2;
    float *restrict w1 = block->w1, *restrict w2 = block->w2;
    uint8_t *restrict outside = block->outside;
    const uint32_t count = whole_lanes(block->count);
#pragma omp simd
    for (uint32_t n = 0; n < count; n++) {
        double b1, b2;
        outside[n] = sl_weights_inside(e0[n], e1[n], e2[n], &b1, &b2) ? 0 : 1;
        w1[n] = (float)b1;
        w2[n] = (float)b2;
    }
}

/* One by one, for the few pixels outside their triangle. */
static void move_inside(sl_resolve_block *block) {
    uint32_t r = 0;
    for (uint32_t group = 0; group < block->count; group += 8) {
        for (uint64_t set = eight_bytes(block->outside + group); set; set &= set - 1) {
            uint32_t n = group + lowest_byte(set);
            if (n >= block->count) return;
            while (n >= block->start[r + 1]) r++;
            const sl_edge_lines l = {block->a0[r], block->b0[r],       block->c0[r],      block->a1[r],
                                     block->b1[r], block->c1[r],       block->a2[r],      block->b2[r],
                                     block->c2[r], block->origin_x[r], block->origin_y[r]};
            sl_weights_at(&l, block->column[n], block->row[n], &block->w1[n], &block->w2[n]);
        }
    }
}

void SL_KERNEL(sl_resolve_weights)(sl_resolve_block *block, const sl_pass_view *view) {
    locate_pixels(block, view);
    make_lines(block, view);
    make_background(block);
    evaluate_lines(block);
    divide_by_sums(block);
    move_inside(block);
}

/* ---- attributes ---- */

void SL_KERNEL(sl_resolve_interpolate)(const sl_resolve_block *block, const sl_run_corners value,
                                       float *plane) {
    for (uint32_t r = 0; r < block->runs; r++) {
        const float first = value[0][r], to_1 = value[1][r] - first, to_2 = value[2][r] - first;
        for (uint32_t n = block->start[r]; n < block->start[r + 1]; n += LANES) {
            const float *restrict w1 = block->w1 + n, *restrict w2 = block->w2 + n;
            float *restrict out = plane + n;
#pragma omp simd
            for (int l = 0; l < LANES; l++) out[l] = sl_interpolate(first, to_1, to_2, w1[l], w2[l]);
        }
    }
}

/* Three at once: the loops over runs cost as much as what is in them. */
static void interpolate_vectors(const sl_resolve_block *block, const sl_run_vectors *value,
                                sl_vector_planes *plane) {
    for (uint32_t r = 0; r < block->runs; r++) {
        const float x0 = value->x[0][r], x1 = value->x[1][r] - x0, x2 = value->x[2][r] - x0;
        const float y0 = value->y[0][r], y1 = value->y[1][r] - y0, y2 = value->y[2][r] - y0;
        const float z0 = value->z[0][r], z1 = value->z[1][r] - z0, z2 = value->z[2][r] - z0;
        for (uint32_t n = block->start[r]; n < block->start[r + 1]; n += LANES) {
            const float *restrict w1 = block->w1 + n, *restrict w2 = block->w2 + n;
            float *restrict x = plane->x + n, *restrict y = plane->y + n, *restrict z = plane->z + n;
#pragma omp simd
            for (int l = 0; l < LANES; l++) {
                x[l] = sl_interpolate(x0, x1, x2, w1[l], w2[l]);
                y[l] = sl_interpolate(y0, y1, y2, w1[l], w2[l]);
                z[l] = sl_interpolate(z0, z1, z2, w1[l], w2[l]);
            }
        }
    }
}

/* The same at all of a run's pixels. */
static void spread(const sl_resolve_block *block, const float *x, const float *y, const float *z,
                                  sl_vector_planes *plane) {
    for (uint32_t r = 0; r < block->runs; r++) {
        const float vx = x[r], vy = y[r], vz = z[r];
        for (uint32_t n = block->start[r]; n < block->start[r + 1]; n += LANES) {
            float *restrict px = plane->x + n, *restrict py = plane->y + n, *restrict pz = plane->z + n;
#pragma omp simd
            for (int l = 0; l < LANES; l++) {
                px[l] = vx;
                py[l] = vy;
                pz[l] = vz;
            }
        }
    }
}

void SL_KERNEL(sl_resolve_spread_index)(const sl_resolve_block *block, const uint32_t *value,
                                        uint32_t *plane) {
    for (uint32_t r = 0; r < block->runs; r++) {
        const uint32_t v = value[r];
        for (uint32_t n = block->start[r]; n < block->start[r + 1]; n += LANES) {
            uint32_t *restrict out = plane + n;
#pragma omp simd
            for (int l = 0; l < LANES; l++) out[l] = v;
        }
    }
}

/* ---- surfaces ---- */

/* The normals of facets, once for each run. What interpolation makes of equal values is value + 0, which
 * turns -0 into 0. */
static void normals_of_facets(sl_surface_block *s, uint32_t runs) {
    float *restrict nx = s->corner_normal.x[0], *restrict ny = s->corner_normal.y[0],
                    *restrict nz = s->corner_normal.z[0];
    const float *restrict gx = s->face_x, *restrict gy = s->face_y, *restrict gz = s->face_z;
#pragma omp simd
    for (uint32_t r = 0; r < runs; r++) {
        sl_vec3 n =
            sl_shading_normal(sl_v3(nx[r] + 0.0f, ny[r] + 0.0f, nz[r] + 0.0f), sl_v3(gx[r], gy[r], gz[r]));
        nx[r] = n.x;
        ny[r] = n.y;
        nz[r] = n.z;
    }
}

/* Turns both normals of facets to the viewer's side. */
static void turn_facets(sl_surface_block *s, uint32_t count, sl_vec3 eye) {
    const float *restrict x = s->position.x, *restrict y = s->position.y, *restrict z = s->position.z;
    float *restrict nx = s->normal.x, *restrict ny = s->normal.y, *restrict nz = s->normal.z;
    float *restrict gx = s->geometric.x, *restrict gy = s->geometric.y, *restrict gz = s->geometric.z;
#pragma omp simd
    for (uint32_t n = 0; n < count; n++) {
        float side = sl_side_seen(sl_v3(gx[n], gy[n], gz[n]), sl_sub(eye, sl_v3(x[n], y[n], z[n])));
        nx[n] = side * nx[n];
        ny[n] = side * ny[n];
        nz[n] = side * nz[n];
        gx[n] = side * gx[n];
        gy[n] = side * gy[n];
        gz[n] = side * gz[n];
    }
}

static void turn_normals(sl_surface_block *s, uint32_t count, sl_vec3 eye) {
    const float *restrict x = s->position.x, *restrict y = s->position.y, *restrict z = s->position.z;
    float *restrict nx = s->normal.x, *restrict ny = s->normal.y, *restrict nz = s->normal.z;
    float *restrict gx = s->geometric.x, *restrict gy = s->geometric.y, *restrict gz = s->geometric.z;
#pragma omp simd
    for (uint32_t n = 0; n < count; n++) {
        sl_vec3 g = sl_v3(gx[n], gy[n], gz[n]);
        g = sl_scale(g, sl_side_seen(g, sl_sub(eye, sl_v3(x[n], y[n], z[n]))));
        sl_vec3 normal = sl_shading_normal(sl_v3(nx[n], ny[n], nz[n]), g);
        nx[n] = normal.x;
        ny[n] = normal.y;
        nz[n] = normal.z;
        gx[n] = g.x;
        gy[n] = g.y;
        gz[n] = g.z;
    }
}

void SL_KERNEL(sl_resolve_surfaces)(const sl_resolve_block *block, const sl_pass_view *view,
                                    sl_surface_block *s) {
    const uint32_t count = whole_lanes(block->count);
    const sl_vec3 eye = sl_v3(view->origin[0], view->origin[1], view->origin[2]);
    interpolate_vectors(block, &block->corner, &s->position);
    spread(block, s->face_x, s->face_y, s->face_z, &s->geometric);
    if (s->facets) {
        const sl_run_vectors *n = &s->corner_normal;
        normals_of_facets(s, whole_lanes(block->runs));
        spread(block, n->x[0], n->y[0], n->z[0], &s->normal);
        turn_facets(s, count, eye);
    } else {
        interpolate_vectors(block, &s->corner_normal, &s->normal);
        turn_normals(s, count, eye);
    }
}
