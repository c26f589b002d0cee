/* From radiance to the 8-bit sRGB of a PNG. */
#pragma once

#include "softlux.h"

/* Finds the planes LAYER.R, LAYER.G, LAYER.B of a layer, NULL where they are missing; R, G, B of the picture
 * itself where `layer` is NULL. False: one is missing. */
bool sl_layer_planes(const sl_image *image, const char *layer, const float *planes[3]);
/* The planes R, G, B, or, where one of them is missing, Y three times; false where there is no Y either. */
bool sl_picture_planes(const sl_image *image, const float *planes[3]);
/* log2 of the factor that tone's exposure means for an image, finite: its stops, and where it is automatic
 * log2 of 0.18 / (log-average luminance) more. The average is over the pixels with finite positive luminance;
 * without any it is taken as 0.18. */
double sl_tone_stops(const sl_image *image, sl_tone tone);
/* The tone of 8-bit pictures, as metadata: the curve's name, or "unknown" where the file does not tell; the
 * exposure in stops; "true" where that was automatic. */
#define SL_TONE_KEY "softlux.tone"
#define SL_TONE_EXPOSURE_KEY "softlux.exposure"
#define SL_TONE_AUTOMATIC_KEY "softlux.exposure_automatic"
/* "clip", "reinhard"; NULL past the end. */
const char *sl_tone_curve_name(size_t index);
