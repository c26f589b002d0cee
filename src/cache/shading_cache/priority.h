/* Priorities of patches: the interpolation error that shows, in grey levels, and age; and their normalisation
 * over the pixels (section on the priority map). */
#pragma once

#include "cache/patches/perception.h"
#include "cache/patches/patches.h"

/* Radiance to display levels, 0 to 255: Y = (5R + 9G + 2B) / 16, R = Y / Y_ref, S(R) = (R + 1/k) / (R + k)
 * with k = 10, and D = 255 ((S - S(0)) / (1 - S(0)))^(1/2.2), which is the level at an exposure of 1 / (k
 * Y_ref). */
typedef struct sl_display_curve {
    float reference;           /* Y_ref */
} sl_display_curve;
/* Y; negative, NaN: 0; infinite: the largest float. */
float sl_curve_luminance(sl_rgb radiance);
float sl_curve_level_of(const sl_display_curve *curve, float luminance);
/* The number of levels by which two radiances differ. */
float sl_levels_apart(const sl_display_curve *curve, sl_rgb a, sl_rgb b);

/* Y of what leaves a vertex towards the eye, evaluated or not: E mean(kd) / pi, the lobe's radiance, and the
 * surface's own; and its level. */
float sl_vertex_luminance(const sl_patches *patches, uint32_t vertex);
float sl_vertex_level(const sl_patches *patches, const sl_display_curve *curve, uint32_t vertex);

/* Largest minus smallest level of the exitant radiance at a patch's corners. Corners never evaluated: -1.
 * Corners without light of their own may be black, so that what holds them is split as long as it can be
 * seen. */
float sl_patch_error(const sl_patches *patches, const sl_display_curve *curve, uint32_t patch);
/* Age in grey levels: c (now - evaluated) of its oldest corner, or what hangs on its edges, if that was
 * evaluated before the last relevant change; else 0. */
float sl_patch_age(const sl_patches *patches, uint32_t patch, uint32_t now, uint32_t changed, float c);
/* c of a material: 1 + 8 c_g d with Pellacini's contrast gloss c_g = cbrt(ks + kd/2) - cbrt(kd/2) and d = 1 -
 * 1/sqrt(2 n + 1), of mirrors 1. */
float sl_age_constant(const sl_material *material);
/* Both together: p_err + min(p_age, 255), p_age the larger one of two: since the eye moved, of what is not
 * only diffuse, and since its object's shading changed (updates; 0: never). Negative: never evaluated. */
float sl_patch_priority(const sl_patches *patches, const sl_display_curve *curve, uint32_t patch,
                        uint32_t now, uint32_t eye_moved, uint32_t changed);

/* A visible leaf of the id map. */
typedef struct sl_leaf_priority {
    uint32_t patch, pixels;
    /* p_err + min(p_age, 255); < 0 or NaN: never evaluated, which comes first and does not count for the
     * mean */
    float priority;
    float normal;              /* out: p_norm, in [0,1] */
} sl_leaf_priority;
/* Corners of one colour do not say that nothing lies between them: the larger a leaf the more may, and the
 * more the less is known of the rest. So that such a leaf does not wait for a random pixel, one of 1/128 of
 * the picture counts as if it were wrong by as much as the pixels' mean, others by the root of their area;
 * those that were never evaluated stay as they are. Neither the picture's size nor its contrast has a say in
 * that; where nothing differs at all one level stands for the mean. */
void sl_priorities_raise(size_t count, sl_leaf_priority *leaves, size_t picture_pixels);
/* p_norm = clamp((p - lo) / (hi - lo)), hi = min(max, mean + 4 sigma), lo = max(min, mean - 4 sigma),
 * weighted by pixels, recomputed with p clipped to hi (at most 8 times) as long as no more than one pixel in
 * a thousand lies above it, so that one outlier does not hide the rest. Where hi = lo, 0 for p = 0, else 1.
 * plain: (p - mean + 4 sigma) / (8 sigma), as printed. */
void sl_priorities_normalise(size_t count, sl_leaf_priority *leaves, bool plain);
