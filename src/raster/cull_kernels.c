/* Culling: which clusters a view may see, and where on the screen.
 *
 * A cluster is rejected whole when its bounds lie outside a plane of the view, or between pixel centres. What
 * is rejected here would have been culled triangle by triangle: every test leaves room for the rounding of
 * itself and of the transform. */
#include <math.h>
#include <string.h>

#include "raster/pipeline.h"

/* Sixteen clusters' bounds relative to the eye. */
typedef struct {
    float x[SL_LANES], y[SL_LANES], z[SL_LANES], half_x[SL_LANES], half_y[SL_LANES], half_z[SL_LANES];
} bounds;

static void load_bounds(const sl_raster *r, const sl_pass_view *view, size_t first, bounds *restrict b) {
    const float *restrict cx = r->centre_x + first, *restrict cy = r->centre_y + first,
                          *restrict cz = r->centre_z + first;
    const float *restrict hx = r->half_x + first, *restrict hy = r->half_y + first,
                          *restrict hz = r->half_z + first;
#pragma omp simd
    for (int l = 0; l < SL_LANES; l++) {
        b->x[l] = cx[l] - view->origin[0];
        b->y[l] = cy[l] - view->origin[1];
        b->z[l] = cz[l] - view->origin[2];
        b->half_x[l] = hx[l];
        b->half_y[l] = hy[l];
        b->half_z[l] = hz[l];
    }
}

/* A cluster is outside a plane when its centre lies further behind it than box and sphere both reach. */
static int32_t cull_by_planes(const bounds *restrict b, const float *restrict radius,
                              const sl_pass_view *view, int32_t *restrict inside) {
    for (int l = 0; l < SL_LANES; l++) inside[l] = 1;
    for (int k = 0; k < view->planes; k++) {
        const float nx = view->plane[k][0], ny = view->plane[k][1], nz = view->plane[k][2],
                    d = view->plane[k][3];
        const float length = view->plane_length[k];
#pragma omp simd
        for (int l = 0; l < SL_LANES; l++) {
            float x = nx * b->x[l], y = ny * b->y[l], z = nz * b->z[l];
            float box = fabsf(nx) * b->half_x[l] + fabsf(ny) * b->half_y[l] + fabsf(nz) * b->half_z[l];
            float sphere = length * radius[l];
            float reach = box < sphere ? box : sphere;
            /* where all are denormal */
            float slack = 1e-5f * (fabsf(x) + fabsf(y) + fabsf(z) + fabsf(d) + reach) + 1e-37f;
            inside[l] &= !(x + y + z + d < -(reach + slack));
        }
    }
    int32_t any = 0;
    for (int l = 0; l < SL_LANES; l++) any |= inside[l];
    return any;
}

/* A coordinate of the clip space over a box: at the centre, its change along each half axis, and the
 * rounding's room. */
typedef struct {
    float centre[SL_LANES], along_x[SL_LANES], along_y[SL_LANES], along_z[SL_LANES], slack[SL_LANES];
} clip_range;

static void clip_range_of(const bounds *restrict b, const float row[4], clip_range *restrict out) {
    const float m0 = row[0], m1 = row[1], m2 = row[2], m3 = row[3];
#pragma omp simd
    for (int l = 0; l < SL_LANES; l++) {
        float x = m0 * b->x[l], y = m1 * b->y[l], z = m2 * b->z[l];
        float ax = m0 * b->half_x[l], ay = m1 * b->half_y[l], az = m2 * b->half_z[l];
        out->centre[l] = x + y + z + m3;
        out->along_x[l] = ax;
        out->along_y[l] = ay;
        out->along_z[l] = az;
        out->slack[l] =
            4e-6f * (fabsf(x) + fabsf(y) + fabsf(z) + fabsf(m3) + fabsf(ax) + fabsf(ay) + fabsf(az));
    }
}

/* The box's corners projected: ranges of x/w, y/w and z/w, and the least w. A quotient of linear functions is
 * largest and smallest in corners where w > 0. */
typedef struct {
    float x_low[SL_LANES], x_high[SL_LANES], y_low[SL_LANES], y_high[SL_LANES], z_low[SL_LANES],
        w_low[SL_LANES];
} projection;

static inline float corner_value(const clip_range *r, const float sign[3], int l) {
    return r->centre[l] + ((sign[0] * r->along_x[l] + sign[1] * r->along_y[l]) + sign[2] * r->along_z[l]);
}

static inline float least(float a, float b) { return a < b ? a : b; }
static inline float most(float a, float b) { return a > b ? a : b; }

static void project(const clip_range *restrict x, const clip_range *restrict y, const clip_range *restrict z,
                    const clip_range *restrict w, projection *restrict p) {
#pragma omp simd
    for (int l = 0; l < SL_LANES; l++) {
        p->x_low[l] = p->y_low[l] = p->z_low[l] = p->w_low[l] = INFINITY;
        p->x_high[l] = p->y_high[l] = -INFINITY;
    }
    for (int corner = 0; corner < 8; corner++) {
        const float sign[3] = {corner & 1 ? 1.0f : -1.0f, corner & 2 ? 1.0f : -1.0f,
                               corner & 4 ? 1.0f : -1.0f};
#pragma omp simd
        for (int l = 0; l < SL_LANES; l++) {
            float cw = corner_value(w, sign, l), over = 1.0f / cw;
            float cx = corner_value(x, sign, l) * over, cy = corner_value(y, sign, l) * over;
            p->w_low[l] = least(p->w_low[l], cw);
            p->x_low[l] = least(p->x_low[l], cx);
            p->x_high[l] = most(p->x_high[l], cx);
            p->y_low[l] = least(p->y_low[l], cy);
            p->y_high[l] = most(p->y_high[l], cy);
            p->z_low[l] = least(p->z_low[l], corner_value(z, sign, l) * over);
        }
    }
}

/* Facts about a group: the pixels whose centres lie in the projection, a bound on depth, a distance to sort
 * by. */
typedef struct {
    int32_t x0[SL_LANES], y0[SL_LANES], x1[SL_LANES], y1[SL_LANES];
    float nearest[SL_LANES], distance[SL_LANES];
} footprint;

static inline float pixel_of(float ndc, float half, float offset) { return ndc * half + (offset - 0.5f); }
static inline float within(float value, float low, float high) { return most(low, least(value, high)); }

/* Where the box reaches to the eye's plane or anything is not finite, the whole viewport and no bound on
 * depth. */
static void place(const projection *restrict p, const clip_range *restrict x, const clip_range *restrict y,
                  const clip_range *restrict z, const clip_range *restrict w, const sl_pass_view *view,
                  footprint *restrict f) {
    const float hx = view->half_width, hy = view->half_height, ox = view->offset_x, oy = view->offset_y,
                snapping = 0.01f;
    const float left = (float)view->x0, right = (float)(view->x1 - 1), low = (float)view->y0,
                high = (float)(view->y1 - 1);
    float z_bound[SL_LANES], w_bound[SL_LANES];
    int32_t known[SL_LANES];
#pragma omp simd
    for (int l = 0; l < SL_LANES; l++) {
        float w_low = p->w_low[l] - w->slack[l];
        float over = 1.0f / (w_low > 0.0f ? w_low : 1.0f);
        float around = w->slack[l] * over; /* relative error of 1/w at its worst */
        float margin_x =
            snapping + hx * (x->slack[l] * over + around * most(fabsf(p->x_low[l]), fabsf(p->x_high[l])));
        float margin_y =
            snapping + hy * (y->slack[l] * over + around * most(fabsf(p->y_low[l]), fabsf(p->y_high[l])));
        float i0 = ceilf(pixel_of(p->x_low[l], hx, ox) - margin_x),
              i1 = floorf(pixel_of(p->x_high[l], hx, ox) + margin_x);
        float j0 = ceilf(pixel_of(p->y_low[l], hy, oy) - margin_y),
              j1 = floorf(pixel_of(p->y_high[l], hy, oy) + margin_y);
        float z_low = p->z_low[l] - (z->slack[l] * over + around * fabsf(p->z_low[l]));
        z_bound[l] = z_low * 0.5f + (0.5f - 1e-6f);
        w_bound[l] = over * 1.000001f;
        /* Sums of finite numbers: a NaN or an infinity anywhere shows here. */
        float all = (fabsf(i0) + fabsf(i1)) + (fabsf(j0) + fabsf(j1)) + fabsf(z_low) + fabsf(over);
        int32_t here = w_low > 0.0f ? 1 : 0;
        here = all < 1e30f ? here : 0;
        known[l] = here;
        f->x0[l] = (int32_t)(here ? within(i0, left, right + 1.0f) : left);
        f->x1[l] = (int32_t)(here ? within(i1, left - 1.0f, right) : right);
        f->y0[l] = (int32_t)(here ? within(j0, low, high + 1.0f) : low);
        f->y1[l] = (int32_t)(here ? within(j1, low - 1.0f, high) : high);
        f->distance[l] = here ? w_low : 0.0f;
    }
    const float *restrict bound = view->inverse_w ? w_bound : z_bound;
    const float no_bound = view->inverse_w ? INFINITY : -1.0f;
    for (int l = 0; l < SL_LANES; l++)
        f->nearest[l] = known[l] && view->rule != SL_OPENGL_PLANE ? bound[l] : no_bound;
}

static void append_group(const footprint *restrict f, const int32_t *restrict inside, size_t first,
                         size_t here, sl_visible *visible) {
    uint32_t count = visible->count;
    for (size_t l = 0; l < here; l++) {
        visible->cluster[count] = (uint32_t)(first + l);
        visible->x0[count] = f->x0[l];
        visible->y0[count] = f->y0[l];
        visible->x1[count] = f->x1[l];
        visible->y1[count] = f->y1[l];
        visible->nearest[count] = f->nearest[l];
        visible->distance[count] = f->distance[l];
        count += (uint32_t)((inside[l] != 0) & (f->x0[l] <= f->x1[l]) & (f->y0[l] <= f->y1[l]));
    }
    visible->count = count;
}

void SL_KERNEL(sl_raster_cull)(const sl_raster *r, const sl_pass_view *view, sl_visible *visible) {
    visible->count = 0;
    for (size_t first = 0; first < r->cluster_count; first += SL_LANES) {
        int32_t inside[SL_LANES];
        bounds b;
        clip_range x, y, z, w;
        projection p;
        footprint f;
        load_bounds(r, view, first, &b);
        if (!cull_by_planes(&b, r->radius + first, view, inside)) continue;
        clip_range_of(&b, view->clip[0], &x);
        clip_range_of(&b, view->clip[1], &y);
        clip_range_of(&b, view->clip[2], &z);
        clip_range_of(&b, view->clip[3], &w);
        project(&x, &y, &z, &w, &p);
        place(&p, &x, &y, &z, &w, view, &f);
        size_t here = r->cluster_count - first < SL_LANES ? r->cluster_count - first : SL_LANES;
        append_group(&f, inside, first, here, visible);
    }
}
