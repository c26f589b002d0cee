/* Fragment programs of the light's picture: what a pixel adds to the irradiance.
 *
 * A direction (x, y, 1), x and y being tangents, has the cosine n . (x, y, 1) / |(x, y, 1)|, and a pixel of
 * the tangents' plane the solid angle dx dy / |(x, y, 1)|^3. Together
 *
 *     w = (n . (x, y, 1))+ dx dy / (1 + x^2 + y^2)^2,
 *
 * which is, with d = h (x, y, 1) and pixels of ds = h dx, dt = h dy on a light at distance h, the same as (n
 * . d)+ h ds dt / |d|^4. */
#include "cache/light/sample_kernels.h"

void SL_KERNEL(sl_window_weigh)(const sl_light_pixels *pixels, const uint32_t *inside, const uint32_t *id) {
    static const uint32_t bit[32] = {1u << 0,  1u << 1,  1u << 2,  1u << 3,  1u << 4,  1u << 5,  1u << 6,
                                     1u << 7,  1u << 8,  1u << 9,  1u << 10, 1u << 11, 1u << 12, 1u << 13,
                                     1u << 14, 1u << 15, 1u << 16, 1u << 17, 1u << 18, 1u << 19, 1u << 20,
                                     1u << 21, 1u << 22, 1u << 23, 1u << 24, 1u << 25, 1u << 26, 1u << 27,
                                     1u << 28, 1u << 29, 1u << 30, 1u << 31};
    const int size = pixels->size, words = (size + 31) / 32;
    const sl_vec3 n = pixels->normal, g = pixels->geometric;
    const float scale = pixels->scale;
    for (int j = 0; j < size; j++) {
        const float row_x = pixels->row_x[j], row_y = pixels->row_y[j];
        for (int word = 0; word < words; word++) {
            const uint32_t on = inside[j * words + word];
            const int count = size - 32 * word < 32 ? size - 32 * word : 32;
            const int at = j * size + 32 * word;
            const float *restrict column_x = pixels->column_x + 32 * word, *restrict column_y =
                                                                               pixels->column_y + 32 * word;
            const uint32_t *restrict ids = id + at;
            float *restrict all = pixels->all + at, *restrict seen = pixels->seen + at;
#pragma omp simd
            for (int i = 0; i < count; i++) {
                float x = column_x[i] + row_x, y = column_y[i] + row_y, q = (1.0f + x * x) + y * y;
                float cosine = (n.x * x + n.y * y) + n.z, above = (g.x * x + g.y * y) + g.z;
                float w = cosine * scale / (q * q);
                w = cosine > 0.0f ? w : 0.0f;
                w = above > 0.0f ? w : 0.0f;
                w = on & bit[i] ? w : 0.0f;
                all[i] = w;
                seen[i] = ids[i] == UINT32_MAX ? w : 0.0f;
            }
        }
    }
}

/* Solid angle of a pixel over its area: the mean of (1 + x^2 + y^2)^(-3/2) by Gauss's rule of 2 x 2 points,
 * reach_x and reach_y from its middle. */
static inline float term(float u, float v) {
    float q = 1.0f + u * u + v * v;
    return 1.0f / (q * sqrtf(q));
}

static inline float gauss(float x, float y, float reach_x, float reach_y) {
    float left = x - reach_x, right = x + reach_x, low = y - reach_y, high = y + reach_y;
    return 0.25f * ((term(left, low) + term(right, low)) + (term(left, high) + term(right, high)));
}

#define GAUSS_POINT 0.2886751346f /* of a pixel's step: 1 / (2 sqrt 3) */

/* Where pixels are not small the rule's error would show: they are cut into 16 x 16. */
static float coarse_pixel(float x, float y, float step_x, float step_y) {
    float sum = 0.0f;
    for (int b = 0; b < 16; b++) {
        for (int a = 0; a < 16; a++) {
            float u = x + ((float)a - 7.5f) * 0.0625f * step_x, v = y + ((float)b - 7.5f) * 0.0625f * step_y;
            sum += gauss(u, v, 0.0625f * GAUSS_POINT * step_x, 0.0625f * GAUSS_POINT * step_y);
        }
    }
    return sum * (1.0f / 256.0f);
}

static void pixel_row(int size, const float *restrict x, float y, float step_x, float step_y,
                      float *restrict out) {
    const float reach_x = GAUSS_POINT * step_x, reach_y = GAUSS_POINT * step_y;
    if (step_x > 0.1f || step_y > 0.1f) {
        for (int i = 0; i < size; i++) out[i] = coarse_pixel(x[i], y, step_x, step_y);
        return;
    }
#pragma omp simd
    for (int i = 0; i < size; i++) out[i] = gauss(x[i], y, reach_x, reach_y);
}

void SL_KERNEL(sl_look_at_weigh)(const sl_light_pixels *pixels, const uint32_t *light_id,
                                 const uint8_t *facing, const float *light_depth, const float *depth) {
    const int size = pixels->size;
    const float scale = pixels->scale * pixels->step_x * pixels->step_y;
    const sl_vec3 n = pixels->normal, g = pixels->geometric;
    for (int j = 0; j < size; j++) {
        const float y = pixels->row_y[j];
        const int at = j * size;
        const float *restrict tx = pixels->column_x, *restrict far = light_depth + at,
                              *restrict here = depth + at;
        const uint32_t *restrict ids = light_id + at;
        float *restrict all = pixels->all + at, *restrict seen = pixels->seen + at;
        uint32_t any = 0;
        for (int i = 0; i < size; i++) { /* 1: a pixel of the light */
            uint32_t on = ids[i] != UINT32_MAX && facing[ids[i]];
            any |= on;
            seen[i] = on ? scale : 0.0f;
        }
        if (any) pixel_row(size, tx, y, pixels->step_x, pixels->step_y, all);
#pragma omp simd
        for (int i = 0; i < size; i++) {
            float x = tx[i], cosine = (n.x * x + n.y * y) + n.z, above = (g.x * x + g.y * y) + g.z;
            float w = all[i] * seen[i] * (cosine / sqrtf((1.0f + x * x) + y * y));
            w = cosine > 0.0f ? w : 0.0f;
            w = above > 0.0f ? w : 0.0f;
            w = seen[i] > 0.0f ? w : 0.0f;
            all[i] = w;
            seen[i] = here[i] <= far[i] * 1.0001f ? w : 0.0f;
        }
    }
}
