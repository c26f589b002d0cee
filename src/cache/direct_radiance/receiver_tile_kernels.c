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

/* The same on the way from the G-buffer. */
static inline void fetch_normals(const float *restrict in_gx, const float *restrict in_gy, const float *restrict in_gz,
                                 const float *restrict in_nx, const float *restrict in_ny, const float *restrict in_nz, size_t to,
                                 sl_receiver_tile *restrict t) {
#pragma omp simd
    for (size_t i = 0; i < SL_TILE_WIDTH; i++) {
        float gx = in_gx[i], gy = in_gy[i], gz = in_gz[i], nx = in_nx[i], ny = in_ny[i], nz = in_nz[i];
        bool sound = (gx * gx + gy * gy + gz * gz <= 2.0f) & (nx * nx + ny * ny + nz * nz <= 2.0f);
        t->geometric_x[to + i] = sound ? gx : 0.0f;
        t->geometric_y[to + i] = sound ? gy : 0.0f;
        t->geometric_z[to + i] = sound ? gz : 0.0f;
        t->normal_x[to + i] = sound ? nx : 0.0f;
        t->normal_y[to + i] = sound ? ny : 0.0f;
        t->normal_z[to + i] = sound ? nz : 0.0f;
    }
}

static inline void fetch_rest(const float *restrict x, const float *restrict y, const float *restrict z, const float *restrict r,
                              const float *restrict g, const float *restrict b, size_t to, sl_receiver_tile *restrict t) {
#pragma omp simd
    for (size_t i = 0; i < SL_TILE_WIDTH; i++) {
        t->x[to + i] = x[i];
        t->y[to + i] = y[i];
        t->z[to + i] = z[i];
        t->diffuse[0][to + i] = r[i] * (float)(1.0 / SL_PI);
        t->diffuse[1][to + i] = g[i] * (float)(1.0 / SL_PI);
        t->diffuse[2][to + i] = b[i] * (float)(1.0 / SL_PI);
    }
}

void SL_KERNEL(sl_receivers_fetch_rows)(const float *const plane[SL_TILE_PLANES], size_t width, sl_receiver_tile *t) {
    for (size_t row = 0; row < SL_TILE_HEIGHT; row++) {
        const float *from[SL_TILE_PLANES];
        for (size_t k = 0; k < SL_TILE_PLANES; k++) from[k] = plane[k] + t->pixel[0] + row * width;
        fetch_rest(from[0], from[1], from[2], from[9], from[10], from[11], row * SL_TILE_WIDTH, t);
        fetch_normals(from[3], from[4], from[5], from[6], from[7], from[8], row * SL_TILE_WIDTH, t);
    }
}

bool SL_KERNEL(sl_receivers_survey)(const uint32_t *material, uint32_t first, uint32_t width, uint32_t *restrict pixel) {
    const uint32_t all = material[first];
    uint32_t differences = 0;
    for (uint32_t row = 0; row < SL_TILE_HEIGHT; row++) {
        const uint32_t begin = first + row * width, *restrict of_row = material + begin;
        uint32_t *restrict out = pixel + row * SL_TILE_WIDTH;
#pragma omp simd reduction(| : differences)
        for (uint32_t x = 0; x < SL_TILE_WIDTH; x++) {
            differences |= of_row[x] ^ all;
            out[x] = begin + x;
        }
    }
    return differences == 0;
}

/* ---- light that arrives ---- */

bool SL_KERNEL(sl_receivers_reached)(size_t count, const float *restrict weight, float largest, float *restrict lit) {
    uint32_t any = 0;
#pragma omp simd reduction(| : any)
    for (size_t i = 0; i < count; i++) {
        bool reached = (weight[i] > 0.0f) & (weight[i] <= largest);
        lit[i] = reached ? 1.0f : 0.0f;
        any |= reached ? 1u : 0u;
    }
    return any != 0;
}

void SL_KERNEL(sl_receivers_where)(size_t count, const float *restrict b, float *restrict a) {
#pragma omp simd
    for (size_t i = 0; i < count; i++) a[i] = b[i] > 0.0f ? a[i] : 0.0f;
}

/* ---- light that leaves ---- */

static inline void reflect(const sl_receiver_tile *t, const sl_tile_light *light, bool glossy, int channel, float *restrict out) {
    const float *restrict kd = t->diffuse[channel], *restrict ks = t->specular[channel];
    const float *restrict e = light->irradiance[channel], *restrict l = light->lobe[channel];
    const size_t count = t->padded;
#pragma omp simd
    for (size_t i = 0; i < count; i++) out[i] = kd[i] * e[i];
    if (!glossy) return;
#pragma omp simd
    for (size_t i = 0; i < count; i++) out[i] += ks[i] * l[i];
}

void SL_KERNEL(sl_receivers_reflect_to)(const sl_receiver_tile *t, const sl_tile_light *light, bool glossy, int width,
                                        float *const planes[3]) {
    float radiance[SL_TILE_PIXELS];
    for (int c = 0; c < 3; c++) {
        reflect(t, light, glossy, c, radiance);
        for (size_t row = 0; row < SL_TILE_HEIGHT && t->whole; row++) {
            float *restrict out = planes[c] + (size_t)t->pixel[0] + row * (size_t)width;
            const float *restrict in = radiance + row * SL_TILE_WIDTH;
#pragma omp simd
            for (size_t x = 0; x < SL_TILE_WIDTH; x++) out[x] += in[x];
        }
        for (size_t i = 0; i < t->count && !t->whole; i++) planes[c][t->pixel[i]] += radiance[i];
    }
}

void SL_KERNEL(sl_receivers_spread)(const sl_receiver_tile *t, const sl_tile_light *light, bool glossy, float *plane) {
    float radiance[3][SL_TILE_PIXELS], spread[SL_TILE_PIXELS];
    for (int c = 0; c < 3; c++) reflect(t, light, glossy, c, radiance[c]);
    const size_t padded = t->padded;
#pragma omp simd
    for (size_t i = 0; i < padded; i++) spread[i] = fabsf(sl_luminance((sl_rgb){radiance[0][i], radiance[1][i], radiance[2][i]}));
    for (size_t i = 0; i < t->count; i++) plane[t->pixel[i]] = spread[i];
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
