#include "cache/direct_radiance/compose_kernels.h"

#include "cache/frame/picture_value.h"

/* sl_picture_value(), without a branch. */
static inline float value(float v) {
    float large = v > 0.0f ? FLT_MAX : 0.0f;
    return fabsf(v) <= FLT_MAX ? v : large;
}

void SL_KERNEL(sl_compose_row)(const sl_compose_row *row) {
    const float *restrict emission = row->emission, *restrict direct = row->direct, *restrict indirect = row->indirect;
    const float *restrict throughput = row->throughput;
    float *restrict picture = row->out[0];
    const size_t width = row->width;
    if (!throughput && !row->out[1]) {
#pragma omp simd
        for (size_t x = 0; x < width; x++) picture[x] = value(value(emission[x]) + value(direct[x]) + value(indirect[x]));
        return;
    }
    float *restrict e = row->out[1], *restrict d = row->out[2], *restrict i = row->out[3];
    if (!throughput) {
#pragma omp simd
        for (size_t x = 0; x < width; x++) {
            e[x] = value(emission[x]);
            d[x] = value(direct[x]);
            i[x] = value(indirect[x]);
            picture[x] = value(e[x] + d[x] + i[x]);
        }
    } else if (!row->out[1]) {
#pragma omp simd
        for (size_t x = 0; x < width; x++)
            picture[x] = value(value(throughput[x] * emission[x]) + value(throughput[x] * direct[x]) + value(throughput[x] * indirect[x]));
    } else {
#pragma omp simd
        for (size_t x = 0; x < width; x++) {
            e[x] = value(throughput[x] * emission[x]);
            d[x] = value(throughput[x] * direct[x]);
            i[x] = value(throughput[x] * indirect[x]);
            picture[x] = value(e[x] + d[x] + i[x]);
        }
    }
}
