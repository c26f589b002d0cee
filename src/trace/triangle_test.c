#include "trace/triangle_test.h"

void sl_ray_state_shear(sl_ray_state *state, unsigned i, float x, float y, float z) {
    float ax = fabsf(x), ay = fabsf(y), az = fabsf(z);
    /* The dominant axis is where the ray's direction is divided by, so that the shear's entries are at most 1. The other two
     * keep their cyclic order, so that the winding seen along the ray does not depend on the choice. */
    float row_x[3] = {0.0f, 0.0f, 0.0f}, row_y[3] = {0.0f, 0.0f, 0.0f}, along[3] = {0.0f, 0.0f, 0.0f};
    const float direction[3] = {x, y, z};
    int k = az >= ax ? (az >= ay ? 2 : 1) : (ax >= ay ? 0 : 1);
    int i1 = (k + 1) % 3, i2 = (k + 2) % 3;
    row_x[i1] = 1.0f;
    row_x[k] = -(direction[i1] / direction[k]);
    row_y[i2] = 1.0f;
    row_y[k] = -(direction[i2] / direction[k]);
    along[k] = 1.0f;
    state->row_xx[i] = row_x[0];
    state->row_xy[i] = row_x[1];
    state->row_xz[i] = row_x[2];
    state->row_yx[i] = row_y[0];
    state->row_yy[i] = row_y[1];
    state->row_yz[i] = row_y[2];
    state->along_x[i] = along[0];
    state->along_y[i] = along[1];
    state->along_z[i] = along[2];
    state->per_distance[i] = 1.0 / (double)direction[k];
}
