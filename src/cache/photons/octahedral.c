/* Directions in 32 bits: the sphere is projected to an octahedron, whose lower half is folded over the upper
 * one's square (Meyer et al. 2010). 65,534 steps instead of 65,535 make the axes exact. */
#include "cache/photons/photons.h"

static const float octahedral_steps = 32767.0f;

static uint32_t octahedral_step(float v) {
    float step = (v + 1.0f) * octahedral_steps + 0.5f;
    return step > 0.0f ? step < 65534.0f ? (uint32_t)step : 65534u : 0u;
}

uint32_t sl_octahedral_encode(sl_vec3 unit) {
    float size = fabsf(unit.x) + fabsf(unit.y) + fabsf(unit.z);
    if (!(size > 0.0f) || !(size <= FLT_MAX)) return octahedral_step(0.0f) << 16 | octahedral_step(0.0f);
    float u = unit.x / size, v = unit.y / size;
    if (unit.z < 0.0f) {
        float folded = copysignf(1.0f - fabsf(v), u);
        v = copysignf(1.0f - fabsf(u), v);
        u = folded;
    }
    return octahedral_step(u) << 16 | octahedral_step(v);
}

sl_vec3 sl_octahedral_decode(uint32_t code) {
    float u = (float)(code >> 16) / octahedral_steps - 1.0f,
          v = (float)(code & 0xffffu) / octahedral_steps - 1.0f;
    sl_vec3 d = sl_v3(u, v, 1.0f - fabsf(u) - fabsf(v));
    if (d.z < 0.0f) {
        d.x = copysignf(1.0f - fabsf(v), u);
        d.y = copysignf(1.0f - fabsf(u), v);
    }
    return sl_normalize_or(d, sl_v3(0.0f, 0.0f, 1.0f));
}
