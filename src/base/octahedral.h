#pragma once

#include "base/vec.h"

/* The sphere on the octahedron |x| + |y| + |z| = 1, whose lower half is folded over the upper one's square
 * (Meyer et al. 2010): (u, v) in [-1,1]^2 of a direction of any length but 0, and the octahedron's point
 * there.
 */
static inline void sl_octahedral_place(sl_vec3 d, float *u, float *v) {
    float size = fabsf(d.x) + fabsf(d.y) + fabsf(d.z), x = d.x / size, y = d.y / size;
    *u = d.z < 0.0f ? copysignf(1.0f - fabsf(y), x) : x;
    *v = d.z < 0.0f ? copysignf(1.0f - fabsf(x), y) : y;
}
static inline sl_vec3 sl_octahedral_point(float u, float v) {
    float z = 1.0f - fabsf(u) - fabsf(v);
    if (z < 0.0f) return sl_v3(copysignf(1.0f - fabsf(v), u), copysignf(1.0f - fabsf(u), v), z);
    return sl_v3(u, v, z);
}
