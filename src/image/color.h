/* The sRGB curve (IEC 61966-2-1) between linear light and what is stored in 8-bit pictures. */
#pragma once

/* Nothing is clamped: below 0 the curve's straight part goes on, above 1 its power part does. NaN gives NaN,
 * infinity itself. */
float sl_srgb_encode(float linear);
float sl_srgb_decode(float encoded);
/* Linear values of the bytes of an 8-bit picture. */
extern const float sl_srgb_to_linear[256];
