/* A direction in one float beside its light's colour: polar angle and azimuth in equal steps, a = columns *
 * q_theta + q_phi. The number of steps of theta is even, so that the six axes have codes of their own; an
 * integer below 2^24 is exact in 32 bits. */
#include "base/math.h"
#include "cache/light_octree/lights.h"

enum { COLUMNS = 256, STEPS = 254 /* of theta, from pole to pole */ };

/* sin and cos of step / steps of a full turn; steps is a multiple of four or twice an odd number, quarter
 * turns are exact. */
static void turn(uint32_t step, uint32_t steps, double *sine, double *cosine) {
    uint32_t quarters = 4 * step / steps;
    /* in the quarter */
    double angle = 2.0 * SL_PI * ((double)(4 * step - quarters * steps) / (4.0 * (double)steps));
    double s = 4 * step == quarters * steps ? 0.0 : sl_sin(angle),
           c = 4 * step == quarters * steps ? 1.0 : sl_cos(angle);
    switch (quarters & 3) {
    case 0: *sine = s, *cosine = c; break;
    case 1: *sine = c, *cosine = -s; break;
    case 2: *sine = -s, *cosine = -c; break;
    default: *sine = -c, *cosine = s; break;
    }
}

float sl_direction_pack(sl_vec3d d) {
    const double columns = COLUMNS, steps = STEPS;
    double length = sl_lengthd(d);
    if (!(length > 0.0 && length <= DBL_MAX)) return 0.0f; /* the pole */
    double theta = sl_acos(d.z / length), phi = sl_atan2(d.y, d.x);
    if (phi < 0.0) phi += 2.0 * SL_PI;
    double q_theta = floor(steps * theta / SL_PI + 0.5), q_phi = floor(columns * phi / (2.0 * SL_PI) + 0.5);
    return (float)(columns * q_theta + (q_phi < columns ? q_phi : 0.0));
}

static sl_vec3 compose(double sin_theta, double cos_theta, double sin_phi, double cos_phi) {
    return sl_v3((float)(sin_theta * cos_phi), (float)(sin_theta * sin_phi), (float)cos_theta);
}

/* Returns the nearest code of what is none. */
static uint32_t code_of(float packed) {
    static const uint32_t last = COLUMNS * STEPS + COLUMNS - 1;
    if (!(packed > 0.0f)) return 0;
    return packed < (float)last ? (uint32_t)packed : last;
}

sl_vec3 sl_direction_unpack(float packed) {
    uint32_t code = code_of(packed);
    double sin_theta, cos_theta, sin_phi, cos_phi;
    turn(code / COLUMNS, 2 * STEPS, &sin_theta, &cos_theta);
    turn(code % COLUMNS, COLUMNS, &sin_phi, &cos_phi);
    return compose(sin_theta, cos_theta, sin_phi, cos_phi);
}
