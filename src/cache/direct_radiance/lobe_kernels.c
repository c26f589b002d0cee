/* Modified Phong lobes, on either side: (cos alpha)^n between a lobe's axis and the line between receiver and light. */
#include "cache/direct_radiance/receiver_kernels.h"

/* A photon's lobe stands along the mirrored direction of its light (section 2.5). */
void SL_KERNEL(sl_photon_lobe_power)(const sl_receiver_tile *t, const sl_photon_registers *photon, const sl_lobe_registers *lobe,
                                     float *restrict power) {
    const sl_lobe_registers l = *lobe;
    const float px = photon->x, py = photon->y, pz = photon->z;
    const size_t count = t->padded;
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        float dx = t->x[i] - px, dy = t->y[i] - py, dz = t->z[i] - pz;
        power[i] = sl_lobe_power(l.x * dx + l.y * dy + l.z * dz, dx * dx + dy * dy + dz * dz, l.exponent);
    }
}

/* A receiver's along the mirrored direction of the eye. */
void SL_KERNEL(sl_receiver_lobe_power)(const sl_receiver_tile *t, sl_vec3 towards, bool direction, float *restrict power) {
    const float keep = direction ? 0.0f : 1.0f;
    const size_t count = t->padded;
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        float dx = towards.x - keep * t->x[i], dy = towards.y - keep * t->y[i], dz = towards.z - keep * t->z[i];
        float along = t->mirrored_x[i] * dx + t->mirrored_y[i] * dy + t->mirrored_z[i] * dz;
        power[i] = sl_lobe_power(along, dx * dx + dy * dy + dz * dz, t->exponent[i]);
    }
}

void SL_KERNEL(sl_receiver_mirror_eye)(sl_receiver_tile *t) {
    float *restrict mx = t->mirrored_x, *restrict my = t->mirrored_y, *restrict mz = t->mirrored_z;
    const size_t count = t->padded;
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        sl_vec3 x = sl_v3(t->x[i], t->y[i], t->z[i]), n = sl_v3(t->normal_x[i], t->normal_y[i], t->normal_z[i]);
        sl_vec3 to_eye = sl_normalize_or(sl_sub(sl_v3(mx[i], my[i], mz[i]), x), n);
        /* In double before it is rounded, so that high exponents see a unit vector. */
        sl_vec3 mirrored = sl_normalize_or(sl_sub(sl_scale(n, 2.0f * sl_dot(n, to_eye)), to_eye), n);
        mx[i] = mirrored.x;
        my[i] = mirrored.y;
        mz[i] = mirrored.z;
    }
}
