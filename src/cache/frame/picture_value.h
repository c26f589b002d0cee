/* Limits a picture's values: the largest float where radiance is beyond floats (a light of 1e37 W/sr a
 * millimetre away); and nothing where an infinite light met a zero, which is no number. */
#pragma once

#include <float.h>
#include <math.h>

/* Without a branch, for loops in lanes. */
static inline float sl_picture_value(float v) {
    float large = v > 0.0f ? FLT_MAX : 0.0f;
    return fabsf(v) <= FLT_MAX ? v : large;
}
