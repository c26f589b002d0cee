/* Where a coordinate falls on a texture: the arithmetic that single lookups and vectorised ones share. Free
 * of branches and library calls, so that loops over it vectorise; every step in double is exact for textures
 * of up to 16384 texels, but for the fraction of a negative coordinate. */
#ifndef SL_RASTER_TEXEL_PLACE_H
#define SL_RASTER_TEXEL_PLACE_H

#include <float.h>

#include "base/math.h"
#include "raster/textures/textures.h"

/* The coordinate in [0,1]. NaN falls to the lower end. */
static inline double sl_clamped(float u) {
    float cut = u > 0.0f ? u : 0.0f;
    return (double)(cut < 1.0f ? cut : 1.0f);
}

/* The two texels around x in [0,1], and the weight of the second. x n - 1/2 is the position in texel centres;
 * half a texel is added instead of taken away, so that truncation rounds down. */
typedef struct sl_texel_pair {
    int32_t low, high;
    double weight;
} sl_texel_pair;

static inline sl_texel_pair sl_texels_around(double x, int32_t n) {
    double position = x * (double)n + 0.5;
    int32_t i = (int32_t)position; /* 0 ... n */
    return (sl_texel_pair){i == 0 ? 0 : i - 1, i == n ? n - 1 : i, position - (double)i};
}

static inline double sl_mix(double a, double b, double t) { return a + t * (b - a); }

/* Level of detail to level: the finer of two, the coarser, and the weight of the coarser. */
typedef struct sl_level_pair {
    int32_t fine, coarse;
    double weight;
} sl_level_pair;

static inline sl_level_pair sl_levels_around(float lod, int32_t levels) {
    float last = (float)(levels - 1);
    float above = lod > 0.0f ? lod : 0.0f; /* NaN too */
    float l = above < last ? above : last;
    int32_t fine = (int32_t)l;
    float beyond = l - (float)fine;
    return (sl_level_pair){fine, fine + (beyond > 0.0f ? 1 : 0), (double)beyond};
}

/* A direction's face and its place (s, t) there in [0,1]: OpenGL 4.5, table 8.19; ties go to x, then y. */
typedef struct sl_cube_place {
    int32_t face;
    double s, t;
} sl_cube_place;

static inline double sl_finite_component(float x) {
    float above = x > -FLT_MAX ? x : -FLT_MAX; /* NaN for the moment */
    float y = above < FLT_MAX ? above : FLT_MAX;
    return x != x ? 0.0 : (double)y;
}

static inline sl_cube_place sl_cube_place_of(float direction_x, float direction_y, float direction_z) {
    double x = sl_finite_component(direction_x), y = sl_finite_component(direction_y),
           z = sl_finite_component(direction_z);
    double ax = fabs(x), ay = fabs(y), az = fabs(z);
    /* Sums of products vectorise where nested choices do not; all terms but one are 0. */
    double below = ax > ay ? ax : ay;
    double is_z = az > below ? 1.0 : 0.0, is_y = (1.0 - is_z) * (ay > ax ? 1.0 : 0.0),
           is_x = (1.0 - is_z) - is_y;
    double major = (is_x * x + is_y * y) + is_z * z;
    double sign = major < 0.0 ? -1.0 : 1.0;
    double s = (is_y * x + is_z * (sign * x)) - is_x * (sign * z);
    double t = is_y * (sign * z) - (1.0 - is_y) * y;
    double length = fabs(major), half = 0.5 / (length > 0.0 ? length : 1.0);
    double u = s * half + 0.5, v = t * half + 0.5; /* by rounding the least beyond [0,1] */
    double u_above = u > 0.0 ? u : 0.0, v_above = v > 0.0 ? v : 0.0;
    int32_t axis = (int32_t)(is_y + is_z * 2.0) * 2;
    return (sl_cube_place){axis + (major < 0.0 ? 1 : 0), u_above < 1.0 ? u_above : 1.0,
                           v_above < 1.0 ? v_above : 1.0};
}

#endif
