/* Small vectors and colours, in float (what the simulated hardware computes in) and in double (what sums and
 * geometric predicates need). Plain values; every operation is one rounding per component, in the order
 * written. */
#pragma once

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stddef.h>

typedef struct sl_vec3 {
    float x, y, z;
} sl_vec3;

typedef struct sl_vec3d {
    double x, y, z;
} sl_vec3d;

typedef struct sl_rgb {
    float r, g, b;
} sl_rgb;

/* Moves numbers into [0,1]; NaN: 0. Without branches, for loops over lanes. */
static inline double sl_clamp_unit(double t) { return t > 0.0 ? (t < 1.0 ? t : 1.0) : 0.0; }
static inline float sl_clamp_unitf(float t) { return t > 0.0f ? (t < 1.0f ? t : 1.0f) : 0.0f; }

static inline sl_vec3 sl_v3(float x, float y, float z) { return (sl_vec3){x, y, z}; }
static inline sl_vec3 sl_v3_of(const float v[3]) { return sl_v3(v[0], v[1], v[2]); }
static inline sl_vec3 sl_add(sl_vec3 a, sl_vec3 b) { return sl_v3(a.x + b.x, a.y + b.y, a.z + b.z); }
static inline sl_vec3 sl_sub(sl_vec3 a, sl_vec3 b) { return sl_v3(a.x - b.x, a.y - b.y, a.z - b.z); }
static inline sl_vec3 sl_scale(sl_vec3 a, float s) { return sl_v3(a.x * s, a.y * s, a.z * s); }
static inline sl_vec3 sl_neg(sl_vec3 a) { return sl_v3(-a.x, -a.y, -a.z); }
static inline float sl_dot(sl_vec3 a, sl_vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline sl_vec3 sl_cross(sl_vec3 a, sl_vec3 b) {
    return sl_v3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
/* a + s b */
static inline sl_vec3 sl_mad(sl_vec3 a, float s, sl_vec3 b) {
    return sl_v3(a.x + s * b.x, a.y + s * b.y, a.z + s * b.z);
}
static inline float sl_length(sl_vec3 a) { return sqrtf(sl_dot(a, a)); }
static inline bool sl_is_finite(sl_vec3 a) { return isfinite(a.x) && isfinite(a.y) && isfinite(a.z); }

/* Components in planes of their own. */
static inline void sl_put(float *x, float *y, float *z, size_t i, sl_vec3 a) {
    x[i] = a.x;
    y[i] = a.y;
    z[i] = a.z;
}

static inline sl_vec3d sl_v3d(double x, double y, double z) { return (sl_vec3d){x, y, z}; }
static inline sl_vec3d sl_to_double(sl_vec3 a) { return sl_v3d((double)a.x, (double)a.y, (double)a.z); }
static inline sl_vec3 sl_to_float(sl_vec3d a) { return sl_v3((float)a.x, (float)a.y, (float)a.z); }
static inline sl_vec3d sl_addd(sl_vec3d a, sl_vec3d b) { return sl_v3d(a.x + b.x, a.y + b.y, a.z + b.z); }
static inline sl_vec3d sl_subd(sl_vec3d a, sl_vec3d b) { return sl_v3d(a.x - b.x, a.y - b.y, a.z - b.z); }
static inline sl_vec3d sl_scaled(sl_vec3d a, double s) { return sl_v3d(a.x * s, a.y * s, a.z * s); }
static inline double sl_dotd(sl_vec3d a, sl_vec3d b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline sl_vec3d sl_crossd(sl_vec3d a, sl_vec3d b) {
    return sl_v3d(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
static inline double sl_lengthd(sl_vec3d a) { return sqrt(sl_dotd(a, a)); }

/* A box along the axes; one that holds nothing has its low above its high. */
typedef struct sl_box {
    sl_vec3 low, high;
} sl_box;

static inline sl_box sl_box_empty(void) {
    return (sl_box){{FLT_MAX, FLT_MAX, FLT_MAX}, {-FLT_MAX, -FLT_MAX, -FLT_MAX}};
}
static inline void sl_box_add(sl_box *b, sl_vec3 p) {
    b->low = sl_v3(fminf(b->low.x, p.x), fminf(b->low.y, p.y), fminf(b->low.z, p.z));
    b->high = sl_v3(fmaxf(b->high.x, p.x), fmaxf(b->high.y, p.y), fmaxf(b->high.z, p.z));
}
static inline float sl_outside(float low, float high, float p) {
    const float before = low - p, behind = p - high, outside = before > behind ? before : behind;
    return outside > 0.0f ? outside : 0.0f; /* without branches, which would be guessed wrong */
}
/* Returns by how much a point lies outside a box, axis by axis. */
static inline sl_vec3 sl_outside_box(sl_box b, sl_vec3 p) {
    return sl_v3(sl_outside(b.low.x, b.high.x, p.x), sl_outside(b.low.y, b.high.y, p.y),
                 sl_outside(b.low.z, b.high.z, p.z));
}

/* The unit vector along a, computed in double so that tiny and huge vectors keep their direction; `fallback`
 * where a has no direction (zero, NaN, infinite). Without branches, for loops over lanes. */
static inline sl_vec3 sl_normalize_or(sl_vec3 a, sl_vec3 fallback) {
    sl_vec3d d = sl_to_double(a);
    double length_squared = sl_dotd(d, d);
    bool good = (length_squared > 0.0) & (length_squared <= DBL_MAX);
    sl_vec3 unit = sl_to_float(sl_scaled(d, 1.0 / sqrt(good ? length_squared : 1.0)));
    return sl_v3(good ? unit.x : fallback.x, good ? unit.y : fallback.y, good ? unit.z : fallback.z);
}

/* Orthonormal frame with z along a unit normal: branch-free, continuous but for n.z = 0 (Duff et al. 2017).
 */
typedef struct sl_frame {
    sl_vec3 x, y, z;
} sl_frame;

static inline sl_frame sl_frame_from_normal(sl_vec3 n) {
    float sign = copysignf(1.0f, n.z);
    float a = -1.0f / (sign + n.z);
    float b = n.x * n.y * a;
    return (sl_frame){sl_v3(1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x),
                      sl_v3(b, sign + n.y * n.y * a, -n.y), n};
}
static inline sl_vec3 sl_frame_to_world(const sl_frame *f, sl_vec3 a) {
    return sl_v3(f->x.x * a.x + f->y.x * a.y + f->z.x * a.z, f->x.y * a.x + f->y.y * a.y + f->z.y * a.z,
                 f->x.z * a.x + f->y.z * a.y + f->z.z * a.z);
}
static inline sl_vec3 sl_frame_to_local(const sl_frame *f, sl_vec3 a) {
    return sl_v3(sl_dot(f->x, a), sl_dot(f->y, a), sl_dot(f->z, a));
}

static inline sl_rgb sl_grey(float v) { return (sl_rgb){v, v, v}; }
static inline sl_rgb sl_rgb_add(sl_rgb a, sl_rgb b) { return (sl_rgb){a.r + b.r, a.g + b.g, a.b + b.b}; }
static inline sl_rgb sl_rgb_sub(sl_rgb a, sl_rgb b) { return (sl_rgb){a.r - b.r, a.g - b.g, a.b - b.b}; }
static inline sl_rgb sl_rgb_mul(sl_rgb a, sl_rgb b) { return (sl_rgb){a.r * b.r, a.g * b.g, a.b * b.b}; }
static inline sl_rgb sl_rgb_scale(sl_rgb a, float s) { return (sl_rgb){a.r * s, a.g * s, a.b * s}; }
/* Sums of colours that are to be weighed and divided. */
static inline void sl_sum_colour(double sum[3], double weight, sl_rgb a) {
    sum[0] += weight * (double)a.r;
    sum[1] += weight * (double)a.g;
    sum[2] += weight * (double)a.b;
}
static inline sl_rgb sl_sum_over(const double sum[3], double weight) {
    return (sl_rgb){(float)(sum[0] / weight), (float)(sum[1] / weight), (float)(sum[2] / weight)};
}
static inline void sl_rgb_put(float *r, float *g, float *b, size_t i, sl_rgb a) {
    r[i] = a.r;
    g[i] = a.g;
    b[i] = a.b;
}
static inline void sl_rgb_add_at(float *r, float *g, float *b, size_t i, sl_rgb a) {
    r[i] += a.r;
    g[i] += a.g;
    b[i] += a.b;
}
static inline float sl_rgb_mean(sl_rgb a) { return (a.r + a.g + a.b) * (1.0f / 3.0f); }
static inline float sl_rgb_max(sl_rgb a) {
    float m = a.r > a.g ? a.r : a.g;
    return m > a.b ? m : a.b;
}
static inline bool sl_rgb_is_black(sl_rgb a) { return !(sl_rgb_max(a) > 0.0f); }
static inline bool sl_rgb_is_finite(sl_rgb a) { return isfinite(a.r) && isfinite(a.g) && isfinite(a.b); }
/* Rec. 709 luminance. */
static inline float sl_luminance(sl_rgb a) { return 0.2126f * a.r + 0.7152f * a.g + 0.0722f * a.b; }
