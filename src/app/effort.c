/* Weights: seconds that the methods take at draft, normal and high quality in the Cornell box, two rooms and
 * a room with a window, against the half microsecond of a ray of the path tracer. Right within a factor of
 * two. */
#include "app/effort.h"

double sl_effort_in_rays(const sl_counters *c) {
    static const struct { sl_counter counter; double rays; } weights[] = {
        {SL_COUNT_RAYS, 0.5},           {SL_COUNT_SHADOW_RAYS, 0.4},      {SL_COUNT_PHOTONS_STORED, 2.5},
        {SL_COUNT_PHOTONS_GATHERED, 0.3}, {SL_COUNT_PHOTON_LOOK_UPS, 0.02}, {SL_COUNT_FRAGMENTS_SHADED, 0.02},
    };
    double rays = 0.0;
    for (size_t i = 0; i < sizeof weights / sizeof weights[0]; i++)
        rays += weights[i].rays * (double)c->value[weights[i].counter];
    return rays;
}
