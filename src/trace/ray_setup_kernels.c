#include "trace/ray_setup.h"

#include <math.h>

/* Finds which rays are usual: -1, else 0. */
static inline void find_usual(const sl_ray_setup *restrict setup, const sl_ray16 *restrict rays,
                              unsigned count, int *restrict valid) {
    _Alignas(64) double squared[SL_PACKET];
#pragma omp simd
    for (unsigned i = 0; i < SL_PACKET; i++) {
        double x = setup->centre.x - (double)rays->origin_x[i],
               y = setup->centre.y - (double)rays->origin_y[i];
        double z = setup->centre.z - (double)rays->origin_z[i];
        squared[i] = x * x + y * y + z * z;
    }
    _Alignas(64) int near[SL_PACKET];
#pragma omp simd
    for (unsigned i = 0; i < SL_PACKET; i++) near[i] = squared[i] <= setup->far_squared ? -1 : 0;
#pragma omp simd
    for (unsigned i = 0; i < SL_PACKET; i++) {
        float ax = fabsf(rays->direction_x[i]), ay = fabsf(rays->direction_y[i]),
              az = fabsf(rays->direction_z[i]);
        float far = rays->far[i];
        int bounded = (ax < SL_LONGEST) & (ay < SL_LONGEST) & (az < SL_LONGEST);
        int has_direction = (ax > SL_SHORTEST) | (ay > SL_SHORTEST) | (az > SL_SHORTEST);
        int has_length = (far > rays->near[i]) & (far > 0.0f);
        valid[i] = near[i] & -((i < count) & bounded & has_direction & has_length);
    }
}

static inline void set_ends(const sl_ray_setup *restrict setup, const sl_ray16 *restrict rays,
                            sl_ray_state *restrict s, struct RTCRay16 *restrict out) {
    const double unit = setup->unit;
#pragma omp simd
    for (unsigned i = 0; i < SL_PACKET; i++) {
        float near = rays->near[i], far = rays->far[i];
        near = near > 0.0f ? near : 0.0f;
        s->near[i] = near;
        s->best_t[i] = far;
        double begin = (double)near, end = (double)far;
        float tnear = (float)(begin * (1.0 - SL_FAR_SLACK) * unit),
              tfar = (float)((end + SL_FAR_SLACK * fabs(end) + 0x1p-22 * fabs(end)) * unit);
        out->tnear[i] = near > 0.0f ? tnear : 0.0f;
        out->tfar[i] = far < INFINITY ? tfar : INFINITY;
    }
}

unsigned SL_KERNEL(sl_ray_setup_usual)(const sl_ray_setup *setup, const sl_ray16 *rays, unsigned count,
                                       const sl_ready_rays *ready) {
    struct RTCRay16 *restrict out = ready->rays;
    sl_ray_state *restrict s = ready->state;
    float(*restrict o)[SL_PACKET] = ready->origin,
                    (*restrict d)[SL_PACKET] = ready->direction, *restrict scale = ready->scale;
    const float unit = (float)setup->unit;
    find_usual(setup, rays, count, ready->valid);
    set_ends(setup, rays, s, out);
#pragma omp simd
    for (unsigned i = 0; i < SL_PACKET; i++) {
        float ox = rays->origin_x[i], oy = rays->origin_y[i], oz = rays->origin_z[i];
        float dx = rays->direction_x[i], dy = rays->direction_y[i], dz = rays->direction_z[i];
        o[0][i] = ox, o[1][i] = oy, o[2][i] = oz;
        d[0][i] = dx, d[1][i] = dy, d[2][i] = dz;
        out->org_x[i] = ox * unit, out->org_y[i] = oy * unit, out->org_z[i] = oz * unit;
        out->dir_x[i] = dx, out->dir_y[i] = dy, out->dir_z[i] = dz;
        scale[i] = 1.0f;
        out->time[i] = 0.0f;
        out->mask[i] = UINT32_MAX;
        out->id[i] = i;
        out->flags[i] = 0;
        s->best_triangle[i] = SL_NO_INDEX;
        s->skip[i] = rays->skip[i];
    }
#pragma omp simd
    for (unsigned i = 0; i < SL_PACKET; i++) s->start[i] = 0.0;
    unsigned usual = 0;
    for (unsigned i = 0; i < SL_PACKET; i++) usual += ready->valid[i] != 0;
    return usual;
}
