/* (10): sums over photons. Photons pass one after another over the lanes of a tile, each of which has two accumulators a channel, for
 * even and for odd photons: the order of every pixel's sums is the photons' own. */
#include "cache/direct_radiance/receiver_kernels.h"

static inline sl_vec3 receiver(const sl_receiver_tile *t, size_t i) { return sl_v3(t->x[i], t->y[i], t->z[i]); }
static inline sl_vec3 geometric(const sl_receiver_tile *t, size_t i) {
    return sl_v3(t->geometric_x[i], t->geometric_y[i], t->geometric_z[i]);
}
static inline sl_vec3 shading(const sl_receiver_tile *t, size_t i) { return sl_v3(t->normal_x[i], t->normal_y[i], t->normal_z[i]); }

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

void SL_KERNEL(sl_photons_sum)(const sl_receiver_tile *tile, const sl_photon_registers *photons, size_t count, bool cosine,
                               sl_tile_light half[2]) {
    if (cosine) {
        for (size_t j = 0; j < count; j++) add_photon(tile, &photons[j], true, half[j % 2].irradiance);
    } else {
        for (size_t j = 0; j < count; j++) add_photon(tile, &photons[j], false, half[j % 2].irradiance);
    }
}

/* ---- one photon, for those who have more to do with its weight ---- */

void SL_KERNEL(sl_photon_weigh)(const sl_receiver_tile *t, const sl_photon_registers *photon, bool cosine, float *restrict weight) {
    const sl_photon_registers p = *photon;
    const size_t count = t->padded;
    if (cosine) {
#pragma omp simd
        for (size_t i = 0; i < count; i++) weight[i] = sl_cosine_weight(&p, receiver(t, i), geometric(t, i), shading(t, i));
    } else {
#pragma omp simd
        for (size_t i = 0; i < count; i++) weight[i] = sl_disc_weight(&p, receiver(t, i), geometric(t, i), shading(t, i));
    }
}

void SL_KERNEL(sl_photon_polygon)(const sl_receiver_tile *t, const sl_photon_registers *photon, const sl_photon_polygon *polygon,
                                  const float *restrict pi, float *restrict weight) {
    const sl_photon_registers p = *photon;
    const sl_photon_polygon q = *polygon;
    const size_t count = t->padded;
#pragma omp simd
    for (size_t i = 0; i < count; i++) weight[i] = sl_polygon_weight(&p, &q, receiver(t, i), geometric(t, i), pi[i]);
}

void SL_KERNEL(sl_receivers_multiply)(size_t count, const float *restrict b, float *restrict a) {
#pragma omp simd
    for (size_t i = 0; i < count; i++) a[i] *= b[i];
}
