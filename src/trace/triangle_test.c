#include "trace/triangle_test.h"

void sl_ray_state_set(sl_ray_state *state, unsigned i, sl_vec3 origin, sl_vec3 direction) {
    const float d[3] = {direction.x, direction.y, direction.z}, o[3] = {origin.x, origin.y, origin.z};
    float ax = fabsf(d[0]), ay = fabsf(d[1]), az = fabsf(d[2]);
    /* The dominant component is what the others are divided by, so that the shear's entries are at most 1. */
    unsigned k = az >= ax ? (az >= ay ? 2u : 1u) : (ax >= ay ? 0u : 1u);
    unsigned k1 = k == 2 ? 0u : k + 1u, k2 = k == 0 ? 2u : k - 1u;
    state->origin_1[i] = o[k1];
    state->origin_2[i] = o[k2];
    state->origin_3[i] = o[k];
    state->shear_1[i] = -(d[k1] / d[k]);
    state->shear_2[i] = -(d[k2] / d[k]);
    state->per_distance[i] = 1.0 / (double)d[k];
    state->with_axis[k] |= 1u << i;
}
