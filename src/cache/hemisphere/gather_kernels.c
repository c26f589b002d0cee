#include "cache/hemisphere/gather_kernels.h"

#include "base/random.h"

/* ---- directions of rays ---------------------------------------------------------------------- */

/* sin and cos for |x| <= pi / 4: Taylor, errors below 4e-7 and 3e-8. */
static inline float sine(float x) {
    float q = x * x;
    return x * (1.0f + q * (-1.0f / 6.0f + q * (1.0f / 120.0f - q * (1.0f / 5040.0f))));
}
static inline float cosine_of(float x) {
    float q = x * x;
    return 1.0f + q * (-0.5f + q * (1.0f / 24.0f + q * (-1.0f / 720.0f + q * (1.0f / 40320.0f))));
}

/* The concentric map (sl_concentric_disc()): the larger coordinate is the radius, the other one's share of it
 * the azimuth. */
void SL_KERNEL(sl_gather_directions)(const sl_ray_cells *c) {
    const float *restrict corner_a = c->slot_a, *restrict corner_b = c->slot_b;
    float *restrict out_x = c->x, *restrict out_y = c->y, *restrict out_z = c->z;
    sl_frame f = c->frame;
    for (size_t k = 0; k < c->count; k++) { /* one random number makes both jitters */
        uint32_t bits = c->bits ? c->bits[k] : c->jitter ? sl_random_bits(c->key, k) : 0x80008000u;
        out_x[k] = (float)(bits >> 16) * 0x1p-16f;
        out_y[k] = (float)(bits & 0xffffu) * 0x1p-16f;
    }
#pragma omp simd
    for (size_t k = 0; k < c->count; k++) {
        float a = corner_a[k] + c->cell * out_x[k], b = corner_b[k] + c->cell * out_y[k];
        bool a_larger = fabsf(a) > fabsf(b);
        float radius = a_larger ? a : b, other = a_larger ? b : a;
        float share = other / (radius != 0.0f ? radius : 1.0f);
        float angle = share * 0.785398163397f, s = radius * sine(angle), t = radius * cosine_of(angle);
        float x = a_larger ? t : s, y = a_larger ? s : t;
        float height = 1.0f - radius * radius;
        float z = sqrtf(height > 1e-8f ? height : 1e-8f);
        out_x[k] = f.x.x * x + f.y.x * y + f.z.x * z;
        out_y[k] = f.x.y * x + f.y.y * y + f.z.y * z;
        out_z[k] = f.x.z * x + f.y.z * y + f.z.z * z;
    }
}

/* ---- how radiance varies --------------------------------------------------------------------- */

static inline float square(float x) { return x * x; }

/* Of eight numbers. */
static inline float deviation(float a, float b, float c, float d, float e, float f, float g, float h) {
    float mean = 0.125f * (((a + b) + (c + d)) + ((e + f) + (g + h)));
    float low = (square(a - mean) + square(b - mean)) + (square(c - mean) + square(d - mean));
    float high = (square(e - mean) + square(f - mean)) + (square(g - mean) + square(h - mean));
    return sqrtf(0.125f * (low + high));
}

static void spread_of_row(size_t width, const float *restrict below, const float *restrict here,
                          const float *restrict above, float *restrict to) {
    for (size_t x = 1; x < width - 1; x++)
        to[x] = deviation(below[x - 1], below[x], below[x + 1], here[x - 1], here[x + 1], above[x - 1],
                          above[x], above[x + 1]);
    for (int end = 0; end < 2; end++) { /* mirrored */
        size_t x = end ? width - 1 : 0, in = end ? width - 2 : 1;
        to[x] = deviation(below[in], below[x], below[in], here[in], here[in], above[in], above[x], above[in]);
    }
}

void SL_KERNEL(sl_gather_spread)(int width, int height, const float *value, float *spread) {
    size_t w = (size_t)width, h = (size_t)height;
    for (size_t y = 0; y < h; y++)
        spread_of_row(w, value + w * (y > 0 ? y - 1 : 1), value + w * y,
                      value + w * (y + 1 < h ? y + 1 : h - 2), spread + w * y);
}

/* ---- surfaces -------------------------------------------------------------------------------- */

/* As sl_scene_surface() decides: normals turned to the gather's side, the shading normal into the geometric
 * one's hemisphere. */
void SL_KERNEL(sl_gather_surfaces)(const sl_gather_hits *h, size_t first, size_t count, sl_vec3 eye) {
    const float *restrict depth = h->depth + first;
    const float *restrict dx = h->direction_x + first, *restrict dy = h->direction_y + first,
                          *restrict dz = h->direction_z + first;
    float *restrict px = h->position_x + first, *restrict py = h->position_y + first,
                    *restrict pz = h->position_z + first;
    float *restrict nx = h->normal_x + first, *restrict ny = h->normal_y + first,
                    *restrict nz = h->normal_z + first;
    float *restrict gx = h->geometric_x + first, *restrict gy = h->geometric_y + first,
                    *restrict gz = h->geometric_z + first;
    float *restrict cosine = h->cosine + first, *restrict back = h->back + first;
#pragma omp simd
    for (size_t k = 0; k < count; k++) {
        px[k] = eye.x + depth[k] * dx[k];
        py[k] = eye.y + depth[k] * dy[k];
        pz[k] = eye.z + depth[k] * dz[k];
        float towards = -(gx[k] * dx[k] + gy[k] * dy[k] + gz[k] * dz[k]);
        float side = towards < 0.0f ? -1.0f : 1.0f;
        float x = side * gx[k], y = side * gy[k], z = side * gz[k];
        float squared = nx[k] * nx[k] + ny[k] * ny[k] + nz[k] * nz[k];
        float agreement = nx[k] * x + ny[k] * y + nz[k] * z;
        bool good = squared > 1e-20f && squared < 1e20f && agreement != 0.0f; /* else the geometric normal */
        float scale = (agreement < 0.0f ? -1.0f : 1.0f) / sqrtf(good ? squared : 1.0f);
        nx[k] = good ? nx[k] * scale : x;
        ny[k] = good ? ny[k] * scale : y;
        nz[k] = good ? nz[k] * scale : z;
        gx[k] = x;
        gy[k] = y;
        gz[k] = z;
        cosine[k] = side * towards;
        back[k] = towards < 0.0f ? 1.0f : 0.0f;
    }
}

/* ---- sums ------------------------------------------------------------------------------------ */

enum { LANES = SL_GATHER_LANES };

/* The fixed shape of every sum: eight lanes, then pairs. */
static double lanes_sum(const double *s) {
    return ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7]));
}

/* E = sum W L; grad_r E = sum L (n x V) = sum L (-V_y, V_x), V the integral of omega over the cell: E(n) =
 * integral of L n . omega, and a rotation alpha makes n + alpha x n of n. (Where n . omega = 0 the integrand
 * vanishes, so that the horizon itself adds nothing.) */
static void sum_cells(const sl_gather_tables *t, size_t cells, const float *restrict radiance,
                      double *irradiance, double rotational[2]) {
    const float *restrict w = t->weight, *restrict vx = t->vector_x, *restrict vy = t->vector_y;
    double e[LANES] = {0}, rx[LANES] = {0}, ry[LANES] = {0};
    for (size_t i = 0; i < cells; i += LANES) {
#pragma omp simd
        for (size_t lane = 0; lane < LANES; lane++) {
            double l = (double)radiance[i + lane];
            e[lane] += (double)w[i + lane] * l;
            rx[lane] -= (double)vy[i + lane] * l;
            ry[lane] += (double)vx[i + lane] * l;
        }
    }
    *irradiance = lanes_sum(e);
    rotational[0] = lanes_sum(rx);
    rotational[1] = lanes_sum(ry);
}

static double sum_products(size_t cells, const float *restrict a, const float *restrict b) {
    double sum[LANES] = {0};
    for (size_t i = 0; i < cells; i += LANES) {
#pragma omp simd
        for (size_t lane = 0; lane < LANES; lane++) sum[lane] += (double)a[i + lane] * (double)b[i + lane];
    }
    return lanes_sum(sum);
}

/* The principle of walls: L is one value in each cell, so E changes because the boundaries between cells
 * move, and such a wall moves with the nearer of its two surfaces, whose outline or texture it is (as Ward
 * and Heckbert 1992 have it for polar strata):
 *
 *     grad_t E = sum over walls of (L_j - L_i) max(1 / Z_j, 1 / Z_i) g_ij
 *
 * nearness is 1 / Z, Z the depth in whose units the table's g (sl_wall_vector()) is given; 0 where nothing is
 * seen, so that infinitely far light does not move. column_: walls between j and the cell on its left; row_:
 * between j and the cell below. */
static void sum_walls(const sl_gather_tables *t, size_t cells, const float *restrict radiance,
                      const float *restrict nearness, double translational[2]) {
    const float *restrict column_x = t->column.x, *restrict column_y = t->column.y;
    const float *restrict row_x = t->row.x, *restrict row_y = t->row.y;
    const float *restrict left = radiance - 1, *restrict below = radiance - t->width;
    const float *restrict near_left = nearness - 1, *restrict near_below = nearness - t->width;
    double x[LANES] = {0}, y[LANES] = {0};
    for (size_t i = 0; i < cells; i += LANES) {
#pragma omp simd
        for (size_t lane = 0; lane < LANES; lane++) {
            size_t j = i + lane;
            double near = (double)nearness[j], near_a = (double)near_left[j], near_b = (double)near_below[j];
            double across = ((double)radiance[j] - (double)left[j]) * (near > near_a ? near : near_a);
            double up = ((double)radiance[j] - (double)below[j]) * (near > near_b ? near : near_b);
            x[lane] += across * (double)column_x[j] + up * (double)row_x[j];
            y[lane] += across * (double)column_y[j] + up * (double)row_y[j];
        }
    }
    translational[0] = lanes_sum(x);
    translational[1] = lanes_sum(y);
}

/* ---- second derivatives ---------------------------------------------------------------------- */

static inline double nearer(float a, float b) { return (double)(a > b ? a : b); }

/* d2E = sum over walls of s / Z^2 K_wall, with the step s of L across the wall, Z of the nearer of the two
 * cells beside it, and K of sl_wall_curvature(). */
static void sum_curvature(const sl_gather_tables *t, const float *restrict light,
                          const float *restrict nearness, sl_curvature *curvature) {
    const size_t row = (size_t)t->width;
    const float *restrict left = light - 1, *restrict below = light - row;
    const float *restrict near_left = nearness - 1, *restrict near_below = nearness - row;
    double xx[LANES] = {0}, xy[LANES] = {0}, yy[LANES] = {0};
    for (size_t i = 0; i < t->padded; i += LANES) {
#pragma omp simd
        for (size_t lane = 0; lane < LANES; lane++) {
            size_t j = i + lane;
            double near_column = nearer(nearness[j], near_left[j]),
                   near_row = nearer(nearness[j], near_below[j]);
            double column = ((double)light[j] - (double)left[j]) * near_column * near_column,
                   across = ((double)light[j] - (double)below[j]) * near_row * near_row;
            xx[lane] += column * (double)t->column.xx[j] + across * (double)t->row.xx[j];
            xy[lane] += column * (double)t->column.xy[j] + across * (double)t->row.xy[j];
            yy[lane] += column * (double)t->column.yy[j] + across * (double)t->row.yy[j];
        }
    }
    curvature->xx = lanes_sum(xx);
    curvature->xy = lanes_sum(xy);
    curvature->yy = lanes_sum(yy);
}

/* ---- all ------------------------------------------------------------------------------------- */

void SL_KERNEL(sl_gather_sums)(const sl_gather_tables *t, const sl_gather_planes *p, sl_gather_sums *sums) {
    const float *channel[3] = {p->r, p->g, p->b};
    float *restrict mean = p->mean;
    for (int c = 0; c < 3; c++) {
        sum_cells(t, t->padded, channel[c], &sums->irradiance[c], sums->rotational[c]);
        sum_walls(t, t->padded, channel[c], p->nearness, sums->translational[c]);
    }
    sums->inverse_distance = sum_products(t->padded, t->weight_by_depth, p->first);
    for (size_t i = 0; i < t->padded; i++) mean[i] = (p->r[i] + p->g[i] + p->b[i]) * (1.0f / 3.0f);
    sum_curvature(t, mean, p->nearness, &sums->curvature);
}
