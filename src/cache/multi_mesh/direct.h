/* Direct radiance at points of unit reflectance, from the irradiance meshes: U_dd = sum over lights of E_d /
 * pi (equation 4 without k_d), U_ds = (n + 2) / (2 pi) sum cos^n alpha E_d (equation 6 without k_s). */
#ifndef SL_MULTI_MESH_DIRECT_H
#define SL_MULTI_MESH_DIRECT_H

#include "cache/light/light_sample.h"

/* From the shares of one point's lights (sl_irradiance_at()). */
sl_rgb sl_direct_diffuse(const sl_sampled_lights *lights, const float *share);

/* Towards the eye, from the lights' directions at a point. Equation (6) shrinks an area light to a point
 * inside the lobe, which outshines the lamp itself where the lobe is narrower than it, and is black where the
 * mirror direction meets the lamp beside its middle. So cos^n alpha is its mean over the light, by the
 * irradiance that each part of it gives where nothing hides it: as dense a grid of points as the lobe is
 * narrow, 16 to an edge at most. */
sl_rgb sl_direct_specular(const sl_sampled_lights *lights, const float *share, const sl_lit_point *point,
                          float exponent, sl_vec3 eye);

#endif
