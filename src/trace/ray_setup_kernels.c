#include "trace/ray_setup.h"

#include <math.h>

unsigned SL_KERNEL(sl_rays_usual)(const sl_ray_setup *restrict setup, const sl_ray16 *restrict rays,
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
    unsigned usual = 0;
    for (unsigned i = 0; i < SL_PACKET; i++) usual += valid[i] != 0;
    return usual;
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
        double begin = (double)near - s->start[i], end = (double)far - s->start[i];
        float tnear = (float)(begin * (1.0 - SL_FAR_SLACK) * unit),
              tfar = (float)((end + SL_FAR_SLACK * fabs(end) + 0x1p-22 * fabs((double)far)) * unit);
        out->tnear[i] = begin > 0.0 ? tnear : 0.0f;
        out->tfar[i] = far < INFINITY ? tfar : INFINITY;
    }
}

void SL_KERNEL(sl_rays_ready)(const sl_ray_setup *setup, const sl_ray16 *restrict rays,
                              sl_ray_state *restrict s, struct RTCRay16 *restrict out) {
    const float unit = (float)setup->unit;
    set_ends(setup, rays, s, out);
#pragma omp simd
    for (unsigned i = 0; i < SL_PACKET; i++) {
        out->org_x[i] = rays->origin_x[i] * unit;
        out->org_y[i] = rays->origin_y[i] * unit;
        out->org_z[i] = rays->origin_z[i] * unit;
        out->dir_x[i] = rays->direction_x[i];
        out->dir_y[i] = rays->direction_y[i];
        out->dir_z[i] = rays->direction_z[i];
        out->time[i] = 0.0f;
        out->mask[i] = UINT32_MAX;
        out->id[i] = i;
        out->flags[i] = 0;
        s->best_triangle[i] = SL_NO_INDEX;
        s->skip[i] = rays->skip[i];
    }
}
