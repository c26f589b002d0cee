/* Samples of pixels at edges, and the triangles that they may see. */
#pragma once

#include "base/isa.h"
#include "base/vec.h"

#include <stdint.h>

enum { SL_EDGE_SAMPLES = 4 };

/* A triangle from the eye, by the camera's axes: a direction d = (u, v, 1) is within it where d side[i] have
 * one sign for all i, and meets it at inverse distance (d, sum of side) / volume. */
typedef struct sl_edge_cone {
    sl_vec3d side[3];
    double inverse_volume;
    bool everywhere;   /* no triangle: it is infinitely far away */
    bool flat, masked; /* it shows no area; nobody knows where it is opaque but at its own centres */
} sl_edge_cone;

/* Finds what the samples of a pixel see, which are at (u, v) on a plane at unit distance before the eye: the
 * nearest of the cones; the first, the pixel's own, where they meet none. */
SL_KERNELS(void, sl_edge_see,
           (size_t count, const sl_edge_cone *const *cones, const double u[SL_EDGE_SAMPLES],
            const double v[SL_EDGE_SAMPLES], uint8_t seen[SL_EDGE_SAMPLES]));
