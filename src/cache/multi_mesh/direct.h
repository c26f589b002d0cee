/* Direct radiance at points of unit reflectance, from the irradiance meshes: U_dd = sum over lights of E_d / pi (equation 4 without k_d),
 * U_ds = (n + 2) / (2 pi) sum cos^n alpha E_d (equation 6 without k_s). */
#ifndef SL_MULTI_MESH_DIRECT_H
#define SL_MULTI_MESH_DIRECT_H

#include "cache/multi_mesh/irradiance.h"

/* From the shares of one point's lights (sl_irradiance_at()). */
sl_rgb sl_direct_diffuse(const sl_sampled_lights *lights, const float *share);

/* Towards the eye, from the lights' directions at a point. An area light shrunk to a point inside the lobe outshines itself where the
 * lobe is narrower than the light; its term U is held below the lamp's own radiance L by L (1 - exp(-U / L)), which on the axis of a disc
 * is within 5.5 % of the exact value (n >= 10, radius up to 60 degrees). plain: as printed. */
sl_rgb sl_direct_specular(const sl_sampled_lights *lights, const float *share, const sl_mesh_point *point, float exponent, sl_vec3 eye,
                          bool plain);

#endif
