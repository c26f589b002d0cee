#include "image/color.h"

#include "base/math.h"

#include <math.h>

/* The standard's own constants. Its two pieces meet within 1e-7 only, so each direction names its threshold.
 */
static const double straight_slope = 12.92, offset = 0.055, exponent = 2.4;
static const double linear_threshold = 0.0031308, encoded_threshold = 0.04045;

float sl_srgb_encode(float linear) {
    double x = linear;
    if (!(x > linear_threshold)) return (float)(straight_slope * x); /* NaN comes this way too */
    if (isinf(x)) return linear;
    return (float)((1.0 + offset) * sl_pow(x, 1.0 / exponent) - offset);
}

float sl_srgb_decode(float encoded) {
    double x = encoded;
    if (!(x > encoded_threshold)) return (float)(x / straight_slope);
    if (isinf(x)) return encoded;
    double y = sl_pow((x + offset) / (1.0 + offset), exponent);
    return (float)y;
}

void sl_srgb_decode_table(float table[256]) {
    for (int i = 0; i < 256; i++) table[i] = sl_srgb_decode((float)i / 255.0f);
}
