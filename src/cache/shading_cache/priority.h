/* How much a patch wants samples: the interpolation error that shows, in grey levels, or its age; and what of the pixels' priorities is
 * normal (section on the priority map). */
#ifndef SL_SHADING_CACHE_PRIORITY_H
#define SL_SHADING_CACHE_PRIORITY_H

#include "cache/shading_cache/patches.h"

/* Radiance to display levels, 0 to 255: Y = (5R + 9G + 2B) / 16, S(R) = (R^gamma + 1/k) / (R^gamma + k), R = Y / Y_ref. */
typedef struct sl_display_curve {
    float reference;           /* Y_ref */
} sl_display_curve;
float sl_curve_level(const sl_display_curve *curve, sl_rgb radiance);

/* Largest minus smallest level of the exitant radiance at a patch's corners: of diffuse ones E mean(kd) / pi. Corners never evaluated: -1. */
float sl_patch_error(const sl_patches *patches, const sl_display_curve *curve, uint32_t patch);
/* Age in grey levels: c (now - evaluated) of its oldest corner, if that was evaluated before the last relevant change; else 0. */
float sl_patch_age(const sl_patches *patches, uint32_t patch, uint32_t now, uint32_t changed, float c);
/* c of a material: 1 + 8 c_g d with Pellacini's contrast gloss c_g = cbrt(ks + kd/2) - cbrt(kd/2) and d = 1 - 1/sqrt(2 n + 1). */
float sl_age_constant(const sl_material *material);

/* Over the pixels of the id map: what each visible leaf counts for. */
typedef struct sl_leaf_priority {
    uint32_t patch, pixels;
    float priority;            /* p_err + min(p_age, 255); < 0: never evaluated, which comes first and does not count for the mean */
    float normal;              /* out: p_norm, in [0,1] */
} sl_leaf_priority;
/* p_norm = clamp((p - lo) / (hi - lo)), hi = min(max, mean + 4 sigma), lo = max(min, mean - 4 sigma), weighted by pixels, recomputed with p clipped
 * to hi until it settles (at most 8 times), so that one outlier does not hide the rest. plain: (p - mean + 4 sigma) / (8 sigma), as printed. */
void sl_priorities_normalise(size_t count, sl_leaf_priority *leaves, bool plain);

#endif
