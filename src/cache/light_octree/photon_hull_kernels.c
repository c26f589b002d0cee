#include "cache/light_octree/photon_hull_kernels.h"

#include <math.h>
#include <stdbool.h>

enum { LANES = SL_HULL_LANES, WAYS = SL_HULL_WAYS };

/* Each lane's own farthest, and the block in which it stands. */
typedef struct farthest {
    float value[LANES];
    int32_t block[LANES];
} farthest;

static inline void look(farthest *f, const float value[LANES], int32_t block) {
#pragma omp simd
    for (int l = 0; l < LANES; l++) {
        f->block[l] = value[l] > f->value[l] ? block : f->block[l];
        f->value[l] = value[l] > f->value[l] ? value[l] : f->value[l];
    }
}

static inline uint32_t first_of(const farthest *f) {
    int best = 0;
    for (int l = 1; l < LANES; l++) {
        bool before = f->block[l] + l < f->block[best] + best;
        if (f->value[l] > f->value[best] || (f->value[l] == f->value[best] && before)) best = l;
    }
    return (uint32_t)(f->block[best] + best);
}

void SL_KERNEL(sl_hull_extremes)(const float *x, const float *y, size_t count, uint32_t extreme[WAYS]) {
    farthest f[WAYS];
    for (int w = 0; w < WAYS; w++) {
        for (int l = 0; l < LANES; l++) {
            f[w].value[l] = -INFINITY;
            f[w].block[l] = 0;
        }
    }
    for (size_t first = 0; first < count; first += LANES) {
        float v[WAYS][LANES], px[LANES], py[LANES];
        /* beyond the end the last point again, whose number is lower there */
        for (size_t l = 0; l < LANES; l++) {
            size_t i = first + l < count ? first + l : count - 1;
            px[l] = x[i];
            py[l] = y[i];
        }
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            float up = px[l] + py[l], down = px[l] - py[l];
            v[0][l] = px[l];
            v[1][l] = up;
            v[2][l] = py[l];
            v[3][l] = -down;
            v[4][l] = -px[l];
            v[5][l] = -up;
            v[6][l] = -py[l];
            v[7][l] = down;
        }
        for (int w = 0; w < WAYS; w++) look(&f[w], v[w], (int32_t)first);
    }
    for (int w = 0; w < WAYS; w++) {
        extreme[w] = first_of(&f[w]);
        if (extreme[w] >= count) extreme[w] = (uint32_t)count - 1;
    }
}

size_t SL_KERNEL(sl_hull_outside)(const float *x, const float *y, size_t count, const sl_hull_edges *edges,
                                  float slack, uint32_t *outside) {
    size_t kept = 0;
    for (size_t first = 0; first < count; first += LANES) {
        float px[LANES], py[LANES];
        int32_t out[LANES] = {0};
        for (size_t l = 0; l < LANES; l++) {
            size_t i = first + l < count ? first + l : count - 1;
            px[l] = x[i];
            py[l] = y[i];
        }
        for (int e = 0; e < edges->count; e++) {
            const float ax = edges->x[e], ay = edges->y[e], dx = edges->along_x[e], dy = edges->along_y[e];
#pragma omp simd
            for (int l = 0; l < LANES; l++) out[l] |= dx * (py[l] - ay) - dy * (px[l] - ax) <= slack;
        }
        for (size_t l = 0; l < LANES && first + l < count; l++) {
            outside[kept] = (uint32_t)(first + l);
            kept += (size_t)out[l];
        }
    }
    return kept;
}
