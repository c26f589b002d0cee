/* Modified Phong lobes, on either side: (cos alpha)^n between a lobe's axis and the line between receiver and light. */
#include "cache/direct_radiance/receiver_kernels.h"

/* A photon's lobe stands along the mirrored direction of its light. */
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

/* A receiver's stands along the mirrored direction of the eye. Photons and the points of area lights stand for discs:
 * a sharp lobe would show each of them as a spot. The lobe's mean over the disc is a wider lobe: near its axis cos^n is
 * a Gaussian of variance 1 / n, the disc of angular radius a adds a^2 / 4, so
 *
 *     n' = n / (1 + n a^2 / 4),    a^2 = A cos theta' / (pi r^2),    scaled by (n' + 2) / (n + 2) to keep its integral. */
static inline float wider_exponent(float n, float extent, float there, float squared) {
    float r = squared > 0.0f ? squared : 1.0f, cube = r * sqrtf(r);
    float blur = extent * (there > 0.0f ? there : 0.0f) / (cube > 0x1p-126f ? cube : 0x1p-126f);
    return n / (1.0f + n * (blur < 1e30f ? blur : 1e30f));
}

void SL_KERNEL(sl_receiver_lobe_power)(const sl_receiver_tile *t, const sl_lobe_target *target, float *restrict power) {
    const sl_vec3 p = target->towards, m = target->normal;
    const float keep = target->direction ? 0.0f : 1.0f, extent = target->extent, behind = target->two_sided ? 1.0f : 0.0f;
    const size_t count = t->padded;
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        float dx = p.x - keep * t->x[i], dy = p.y - keep * t->y[i], dz = p.z - keep * t->z[i];
        float squared = dx * dx + dy * dy + dz * dz, along = t->mirrored_x[i] * dx + t->mirrored_y[i] * dy + t->mirrored_z[i] * dz;
        float n = t->exponent[i], there = -(m.x * dx + m.y * dy + m.z * dz);
        float wide = wider_exponent(n, extent, there < 0.0f ? -behind * there : there, squared);
        power[i] = (wide + 2.0f) / (n + 2.0f) * sl_lobe_power(along, squared, wide);
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
