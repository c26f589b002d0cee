/* Priorities in grey levels: what an eye would see of the interpolation error, and how old a patch is. */
#include "cache/shading_cache/priority.h"

#include <math.h>

#include "base/math.h"

/* ---- display levels -------------------------------------------------------------------------- */

float sl_curve_luminance(sl_rgb radiance) {
    float y = (5.0f * radiance.r + 9.0f * radiance.g + 2.0f * radiance.b) / 16.0f;
    return y > 0.0f ? fminf(y, FLT_MAX) : 0.0f;
}

float sl_curve_level_of(const sl_display_curve *curve, float luminance) {
    return sl_display_level(curve->reference > 0.0f ? 1.0f / (10.0f * curve->reference) : INFINITY,
                            luminance);
}

float sl_levels_apart(const sl_display_curve *curve, sl_rgb a, sl_rgb b) {
    return fabsf(sl_curve_level_of(curve, sl_curve_luminance(a)) -
                 sl_curve_level_of(curve, sl_curve_luminance(b)));
}

/* ---- what leaves a patch --------------------------------------------------------------------- */

/* Its luminance is linear in the irradiance: E mean(kd) / pi, and the surface's own light. */
typedef struct exitance {
    sl_rgb emission, reflected;
} exitance;

static exitance exitance_of(const sl_primitives *primitives, uint32_t root) {
    const sl_material *material = sl_root_material(primitives, root);
    return (exitance){sl_root_emission(material, root),
                      sl_rgb_scale(sl_root_mean_diffuse(primitives, root), (float)(1.0 / SL_PI))};
}

static sl_rgb radiance_at(const sl_patches *p, const exitance *e, uint32_t vertex) {
    const float *value = sl_vertex_value(p, vertex);
    sl_rgb sum = sl_rgb_add(e->emission, sl_rgb_mul(e->reflected, (sl_rgb){value[0], value[1], value[2]}));
    const float *lobe = sl_vertex_lobe(p, vertex);
    return lobe ? sl_rgb_add(sum, (sl_rgb){lobe[0], lobe[1], lobe[2]}) : sum;
}

float sl_vertex_luminance(const sl_patches *p, uint32_t vertex) {
    exitance e = exitance_of(p->primitives, p->vertex[vertex].root);
    return sl_curve_luminance(radiance_at(p, &e, vertex));
}

float sl_vertex_level(const sl_patches *p, const sl_display_curve *curve, uint32_t vertex) {
    return sl_curve_level_of(curve, sl_vertex_luminance(p, vertex));
}

/* ---- error and age of a patch ---------------------------------------------------------------- */

/* Levels grow with luminance: only those of the darkest and of the brightest corner are needed. */
float sl_patch_error(const sl_patches *p, const sl_display_curve *curve, uint32_t patch) {
    exitance e = exitance_of(p->primitives, sl_patch_root(p, patch));
    float low = FLT_MAX, high = 0.0f;
    for (int c = 0; c < sl_patch_corners(p, patch); c++) {
        uint32_t vertex = sl_patch_corner(p, patch, c);
        if (p->vertex[vertex].evaluated == SL_VERTEX_NEVER) return -1.0f;
        float luminance = sl_curve_luminance(radiance_at(p, &e, vertex));
        if (p->vertex[vertex].extrapolated) low = 0.0f; /* extrapolated: it may be black there */
        low = luminance < low ? luminance : low;
        high = luminance > high ? luminance : high;
    }
    return high > low ? fmaxf(sl_curve_level_of(curve, high) - sl_curve_level_of(curve, low), 0.0f) : 0.0f;
}

float sl_patch_age(const sl_patches *p, uint32_t patch, uint32_t now, uint32_t changed, float c) {
    uint32_t oldest = changed ? sl_leaf_oldest(p, patch) : now;
    return oldest != SL_VERTEX_NEVER && oldest < changed ? c * (float)(now - oldest) : 0.0f;
}

static double cube_root(double x) { return x > 0.0 ? sl_pow(x, 1.0 / 3.0) : 0.0; }

float sl_age_constant(const sl_material *material) {
    double half = 0.5 * (double)sl_curve_luminance(material->diffuse), n = (double)material->exponent;
    double ks = (double)sl_curve_luminance(sl_rgb_add(material->specular, material->mirror)),
           contrast = cube_root(ks + half) - cube_root(half);
    double distinctness = sl_material_is_mirror(material) ? 1.0
                          : n > 0.0                       ? 1.0 - 1.0 / sqrt(2.0 * n + 1.0)
                                                          : 0.0;
    return (float)(1.0 + 8.0 * contrast * distinctness);
}

/* With one c for both, the larger age is that since the later of the two. */
float sl_patch_priority(const sl_patches *p, const sl_display_curve *curve, uint32_t patch, uint32_t now,
                        uint32_t eye_moved, uint32_t changed) {
    float error = sl_patch_error(p, curve, patch);
    if (error < 0.0f || (!eye_moved && !changed)) return error;
    const sl_material *material = sl_root_material(p->primitives, sl_patch_root(p, patch));
    if (sl_material_has_lobe(material) && eye_moved > changed) changed = eye_moved;
    float updates = sl_patch_age(p, patch, now, changed, 1.0f);
    return updates > 0.0f ? error + fminf(sl_age_constant(material) * updates, 255.0f) : error;
}

/* ---- normalisation --------------------------------------------------------------------------- */

/* Over the pixels of leaves that have been evaluated. */
static double mean_priority(size_t count, const sl_leaf_priority *leaves) {
    double sum = 0.0, pixels = 0.0;
    for (size_t i = 0; i < count; i++) {
        bool evaluated = leaves[i].priority >= 0.0f;
        sum += evaluated ? (double)leaves[i].pixels * (double)leaves[i].priority : 0.0;
        pixels += evaluated ? leaves[i].pixels : 0;
    }
    return pixels > 0.0 ? sum / pixels : 0.0;
}

void sl_priorities_raise(size_t count, sl_leaf_priority *leaves, size_t picture_pixels) {
    double mean = fmax(mean_priority(count, leaves), 1.0);
    for (size_t i = 0; i < count; i++) {
        float least = (float)(mean * sqrt(128.0 * (double)leaves[i].pixels / (double)picture_pixels));
        if (leaves[i].priority >= 0.0f && leaves[i].priority < least) leaves[i].priority = least;
    }
}

/* Of the priorities of evaluated leaves, by pixels. Moments are taken about the smallest, so that equal ones
 * have no variance at all. */
typedef struct distribution {
    double min, max, mean, sigma;
} distribution;

static bool is_evaluated(const sl_leaf_priority *leaf) { return leaf->priority >= 0.0f && leaf->pixels > 0; }

static double finite_priority(const sl_leaf_priority *leaf) {
    return fmin((double)leaf->priority, (double)FLT_MAX);
}

static bool find_range(size_t count, const sl_leaf_priority *leaves, distribution *d) {
    *d = (distribution){.min = HUGE_VAL, .max = -HUGE_VAL};
    for (size_t i = 0; i < count; i++) {
        if (!is_evaluated(&leaves[i])) continue;
        d->min = fmin(d->min, finite_priority(&leaves[i]));
        d->max = fmax(d->max, finite_priority(&leaves[i]));
    }
    return d->max >= d->min;
}

static void find_moments(size_t count, const sl_leaf_priority *leaves, double clip, distribution *d) {
    double weight = 0.0, sum = 0.0, squares = 0.0;
    for (size_t i = 0; i < count; i++) {
        if (!is_evaluated(&leaves[i])) continue;
        double pixels = (double)leaves[i].pixels, above = fmin(finite_priority(&leaves[i]), clip) - d->min;
        weight += pixels;
        sum += pixels * above;
        squares += pixels * above * above;
    }
    double mean = sum / weight;
    d->mean = d->min + mean;
    d->sigma = sqrt(fmax(squares / weight - mean * mean, 0.0));
}

static bool are_outliers(size_t count, const sl_leaf_priority *leaves, double high) {
    const double few = 0.001;
    double above = 0.0, all = 0.0;
    for (size_t i = 0; i < count; i++) {
        if (!is_evaluated(&leaves[i])) continue;
        all += (double)leaves[i].pixels;
        if (finite_priority(&leaves[i]) > high) above += (double)leaves[i].pixels;
    }
    return above <= few * all;
}

/* One value of 10^6 among 10^4 between 0 and 1 puts mean + 4 sigma at 40,000, and all others at nothing;
 * clipped to that its next place is 1,600, then 65, 3.3, 1.7. What one pixel in a hundred has is no outlier,
 * but what there is to refine: clipped again and again it would come down to what all the others have. */
static double find_high(size_t count, const sl_leaf_priority *leaves, distribution *d) {
    enum { PASSES = 8 };
    double high = d->max;
    for (int pass = 0; pass < PASSES; pass++) {
        find_moments(count, leaves, high, d);
        double next = fmin(high, d->mean + 4.0 * d->sigma);
        if (!(next < high)) break;
        high = next;
        if (!are_outliers(count, leaves, high)) break;
    }
    return high;
}

void sl_priorities_normalise(size_t count, sl_leaf_priority *leaves, bool plain) {
    distribution d;
    double low = 0.0, high = 0.0;
    if (find_range(count, leaves, &d)) {
        if (plain) find_moments(count, leaves, d.max, &d);
        high = plain ? d.mean + 4.0 * d.sigma : find_high(count, leaves, &d);
        low = plain ? d.mean - 4.0 * d.sigma : fmax(d.min, d.mean - 4.0 * d.sigma);
    }
    for (size_t i = 0; i < count; i++) {
        double p = finite_priority(&leaves[i]);
        if (!(leaves[i].priority >= 0.0f)) leaves[i].normal = 1.0f; /* NaN, too: new samples mend it */
        else if (high > low) leaves[i].normal = (float)fmin(fmax((p - low) / (high - low), 0.0), 1.0);
        else leaves[i].normal = p > 0.0 ? 1.0f : 0.0f;
    }
}
