/* Loops over a tile's lanes: receivers fetched, photons summed by (10), lobes, and light that leaves. */
#include "cache/direct_radiance/receivers.h"

void SL_KERNEL(sl_receivers_prepare)(sl_receiver_tile *t) {
    float *restrict gx = t->geometric_x, *restrict gy = t->geometric_y, *restrict gz = t->geometric_z;
    float *restrict nx = t->normal_x, *restrict ny = t->normal_y, *restrict nz = t->normal_z;
    float *restrict r = t->diffuse[0], *restrict g = t->diffuse[1], *restrict b = t->diffuse[2];
    const size_t count = t->padded;
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        float of_geometric = gx[i] * gx[i] + gy[i] * gy[i] + gz[i] * gz[i];
        float of_shading = nx[i] * nx[i] + ny[i] * ny[i] + nz[i] * nz[i];
        bool sound = (of_geometric <= 2.0f) & (of_shading <= 2.0f);
        gx[i] = sound ? gx[i] : 0.0f;
        gy[i] = sound ? gy[i] : 0.0f;
        gz[i] = sound ? gz[i] : 0.0f;
        nx[i] = sound ? nx[i] : 0.0f;
        ny[i] = sound ? ny[i] : 0.0f;
        nz[i] = sound ? nz[i] : 0.0f;
        r[i] *= (float)(1.0 / SL_PI);
        g[i] *= (float)(1.0 / SL_PI);
        b[i] *= (float)(1.0 / SL_PI);
    }
}

/* ---- light that arrives ---- */

bool SL_KERNEL(sl_receivers_reached)(size_t count, float *restrict weight, float largest,
                                     float *restrict lit) {
    uint32_t any = 0;
#pragma omp simd reduction(| : any)
    for (size_t i = 0; i < count; i++) {
        bool reached = (weight[i] > 0.0f) & (weight[i] <= largest);
        lit[i] = reached ? 1.0f : 0.0f;
        weight[i] = reached ? weight[i] : 0.0f;
        any |= reached ? 1u : 0u;
    }
    return any != 0;
}

/* ---- light that leaves ---- */

static inline void reflect(const sl_receiver_tile *t, const sl_tile_light *light, bool glossy, int channel,
                           float *restrict out) {
    const float *restrict kd = t->diffuse[channel], *restrict ks = t->specular[channel];
    const float *restrict e = light->irradiance[channel], *restrict l = light->lobe[channel];
    const size_t count = t->padded;
#pragma omp simd
    for (size_t i = 0; i < count; i++) out[i] = kd[i] * e[i];
    if (!glossy) return;
#pragma omp simd
    for (size_t i = 0; i < count; i++) out[i] += ks[i] * l[i];
}

void SL_KERNEL(sl_receivers_reflect_to)(const sl_receiver_tile *t, const sl_tile_light *light, bool glossy,
                                        float *const planes[3]) {
    float radiance[SL_TILE_PIXELS];
    for (int c = 0; c < 3; c++) {
        reflect(t, light, glossy, c, radiance);
        for (size_t i = 0; i < t->count; i++) planes[c][t->pixel[i]] += radiance[i];
    }
}

/* (10): sums over photons. Photons pass one after another over the lanes of a tile: the order of every
 * pixel's sums is the photons' own. */

static inline sl_vec3 receiver(const sl_receiver_tile *t, size_t i) {
    return sl_v3(t->x[i], t->y[i], t->z[i]);
}
static inline sl_vec3 geometric(const sl_receiver_tile *t, size_t i) {
    return sl_v3(t->geometric_x[i], t->geometric_y[i], t->geometric_z[i]);
}
static inline sl_vec3 shading(const sl_receiver_tile *t, size_t i) {
    return sl_v3(t->normal_x[i], t->normal_y[i], t->normal_z[i]);
}

/* One photon on all lanes; cosine is a constant where this is inlined. */
static inline void add_photon(const sl_receiver_tile *t, const sl_photon_registers *photon, bool cosine,
                              float (*irradiance)[SL_TILE_PIXELS]) {
    const size_t count = t->padded;
    const sl_photon_registers p = *photon;
    float *restrict r = irradiance[0], *restrict g = irradiance[1], *restrict b = irradiance[2];
#pragma omp simd aligned(r, g, b : 64)
    for (size_t i = 0; i < count; i++) {
        float w = cosine ? sl_cosine_weight(&p, receiver(t, i), geometric(t, i), shading(t, i))
                         : sl_disc_weight(&p, receiver(t, i), geometric(t, i), shading(t, i));
        r[i] += p.red * w;
        g[i] += p.green * w;
        b[i] += p.blue * w;
    }
}

void SL_KERNEL(sl_photons_sum)(const sl_receiver_tile *tile, const sl_photon_registers *photons, size_t count,
                               bool cosine, sl_tile_light *sum) {
    if (cosine) {
        for (size_t j = 0; j < count; j++) add_photon(tile, &photons[j], true, sum->irradiance);
    } else {
        for (size_t j = 0; j < count; j++) add_photon(tile, &photons[j], false, sum->irradiance);
    }
}

/* ---- one photon, for those who have more to do with its weight ---- */

void SL_KERNEL(sl_photon_weigh)(const sl_receiver_tile *t, const sl_photon_registers *photon, bool cosine,
                                float *restrict weight) {
    const sl_photon_registers p = *photon;
    const size_t count = t->padded;
    if (cosine) {
#pragma omp simd
        for (size_t i = 0; i < count; i++)
            weight[i] = sl_cosine_weight(&p, receiver(t, i), geometric(t, i), shading(t, i));
    } else {
#pragma omp simd
        for (size_t i = 0; i < count; i++)
            weight[i] = sl_disc_weight(&p, receiver(t, i), geometric(t, i), shading(t, i));
    }
}

void SL_KERNEL(sl_photon_polygon)(const sl_receiver_tile *t, const sl_photon_registers *photon,
                                  const sl_photon_polygon *polygon, const float *restrict pi,
                                  float *restrict weight) {
    const sl_photon_registers p = *photon;
    const sl_photon_polygon q = *polygon;
    const size_t count = t->padded;
#pragma omp simd
    for (size_t i = 0; i < count; i++)
        weight[i] = sl_polygon_weight(&p, &q, receiver(t, i), geometric(t, i), pi[i]);
}

/* Modified Phong lobes, on either side: (cos alpha)^n between a lobe's axis and the line between receiver and
 * light. */

/* A photon's lobe stands along the mirrored direction of its light. */
void SL_KERNEL(sl_photon_lobe_power)(const sl_receiver_tile *t, const sl_photon_registers *photon,
                                     const sl_lobe_registers *lobe, float *restrict power) {
    const sl_lobe_registers l = *lobe;
    const float px = photon->x, py = photon->y, pz = photon->z;
    const size_t count = t->padded;
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        float dx = t->x[i] - px, dy = t->y[i] - py, dz = t->z[i] - pz;
        power[i] = sl_lobe_power(l.x * dx + l.y * dy + l.z * dz, dx * dx + dy * dy + dz * dz, l.exponent);
    }
}

/* A receiver's stands along the mirrored direction of the eye. Photons and the points of area lights stand
 * for discs of area A: a sharp lobe would show each of them as a spot. With a^2 = A cos theta' / (pi r^2),
 * the disc's angular radius, the lobe's mean over it is
 *
 *     a wider lobe where n a^2 is small: near its axis cos^n is a Gaussian of variance 1 / n, the disc adds
 * a^2 / 4, so n' = n / (1 + n a^2 / 4),    scaled by (n' + 2) / (n + 2) to keep its integral the disc itself
 * with a rim where n a^2 is large: 2 / ((n + 2) a^2) where the axis meets it, and at a distance rho from its
 * middle falling to 0 while rho^2 pi / A goes from 1 - w to 1 + w, w^2 = 12 / (n a^2): the same integral and
 * variance, without a tail
 *
 * and a blend of both where n a^2 is from 6 to 24. */
static inline float squared_radius(float extent, float there, float squared) {
    float r = squared > 0.0f ? squared : 1.0f, cube = r * sqrtf(r);
    float radius = 4.0f * extent * there / (cube > 0x1p-126f ? cube : 0x1p-126f);
    return radius < 2.0f ? radius : 2.0f;
}

/* rho^2 pi / A where the axis meets the disc's plane; far off where it does not, ahead. */
static inline float offset_on_disc(sl_vec3 d, sl_vec3 axis, sl_vec3 normal, float extent) {
    float towards = normal.x * axis.x + normal.y * axis.y + normal.z * axis.z;
    float t = (normal.x * d.x + normal.y * d.y + normal.z * d.z) / (fabsf(towards) > 1e-9f ? towards : 1e-9f);
    float x = t * axis.x - d.x, y = t * axis.y - d.y, z = t * axis.z - d.z;
    float offset = (x * x + y * y + z * z) / (4.0f * (extent > 1e-30f ? extent : 1e-30f));
    return ((t > 0.0f) & (offset < 1e6f)) ? offset : 1e6f;
}

static inline float rimmed_disc(float n, float a, float offset) {
    float sharpness = n * a > 6.0f ? n * a : 6.0f, rim = sqrtf(12.0f / sharpness),
          inside = (1.0f + rim - offset) / (2.0f * rim);
    return 2.0f * n / ((n + 2.0f) * sharpness) * (inside > 0.0f ? (inside < 1.0f ? inside : 1.0f) : 0.0f);
}

void SL_KERNEL(sl_receiver_lobe_power)(const sl_receiver_tile *t, const sl_lobe_target *target,
                                       float *restrict power) {
    const sl_vec3 p = target->towards, m = target->normal;
    const float keep = target->direction ? 0.0f : 1.0f, extent = target->extent,
                behind = target->two_sided ? 1.0f : 0.0f;
    const size_t count = t->padded;
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        sl_vec3 d = {p.x - keep * t->x[i], p.y - keep * t->y[i], p.z - keep * t->z[i]};
        sl_vec3 axis = {t->mirrored_x[i], t->mirrored_y[i], t->mirrored_z[i]};
        float squared = d.x * d.x + d.y * d.y + d.z * d.z, along = axis.x * d.x + axis.y * d.y + axis.z * d.z;
        float n = t->exponent[i], there = -(m.x * d.x + m.y * d.y + m.z * d.z);
        float a = squared_radius(extent, there > 0.0f ? there : -behind * there, squared),
              wide = n / (1.0f + 0.25f * n * a);
        float share = (n * a - 6.0f) * (1.0f / 18.0f),
              disc = share > 0.0f ? (share < 1.0f ? share : 1.0f) : 0.0f;
        float lobe = (wide + 2.0f) / (n + 2.0f) * sl_lobe_power(along, squared, wide);
        power[i] = along > 0.0f ? lobe + disc * (rimmed_disc(n, a, offset_on_disc(d, axis, m, extent)) - lobe)
                                : 0.0f;
    }
}

void SL_KERNEL(sl_receiver_mirror_eye)(sl_receiver_tile *t) {
    float *restrict mx = t->mirrored_x, *restrict my = t->mirrored_y, *restrict mz = t->mirrored_z;
    const size_t count = t->padded;
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        sl_vec3 x = sl_v3(t->x[i], t->y[i], t->z[i]),
                n = sl_v3(t->normal_x[i], t->normal_y[i], t->normal_z[i]);
        sl_vec3 to_eye = sl_normalize_or(sl_sub(sl_v3(mx[i], my[i], mz[i]), x), n);
        /* In double before it is rounded, so that high exponents see a unit vector. */
        sl_vec3 mirrored = sl_normalize_or(sl_sub(sl_scale(n, 2.0f * sl_dot(n, to_eye)), to_eye), n);
        mx[i] = mirrored.x;
        my[i] = mirrored.y;
        mz[i] = mirrored.z;
    }
}
