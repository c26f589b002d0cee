/* What is done with a tile's lanes before light is added, and after. */
#include "cache/direct_radiance/receiver_kernels.h"

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

void SL_KERNEL(sl_receivers_reflect)(const sl_receiver_tile *t, const sl_tile_light *light, bool glossy,
                                     float (*radiance)[SL_TILE_PIXELS]) {
    const size_t count = t->padded;
    for (int c = 0; c < 3; c++) {
        const float *restrict kd = t->diffuse[c], *restrict ks = t->specular[c];
        const float *restrict e = light->irradiance[c], *restrict l = light->lobe[c];
        float *restrict out = radiance[c];
#pragma omp simd
        for (size_t i = 0; i < count; i++) out[i] = kd[i] * e[i];
        if (!glossy) continue;
#pragma omp simd
        for (size_t i = 0; i < count; i++) out[i] += ks[i] * l[i];
    }
}

void SL_KERNEL(sl_receivers_combine)(size_t count, bool glossy, const sl_tile_light half[2], const float share[2], sl_tile_light *sum) {
    const float of_even = share[0], of_odd = share[1];
    for (int c = 0; c < 3; c++) {
        const float *restrict even = half[0].irradiance[c], *restrict odd = half[1].irradiance[c];
        float *restrict out = sum->irradiance[c];
#pragma omp simd
        for (size_t i = 0; i < count; i++) out[i] = of_even * even[i] + of_odd * odd[i];
        const float *restrict even_lobe = half[0].lobe[c], *restrict odd_lobe = half[1].lobe[c];
        float *restrict out_lobe = sum->lobe[c];
        if (!glossy) continue;
#pragma omp simd
        for (size_t i = 0; i < count; i++) out_lobe[i] = of_even * even_lobe[i] + of_odd * odd_lobe[i];
    }
}
