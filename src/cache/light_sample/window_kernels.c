/* Fragment programs of the light's picture (pass S2): what a pixel adds to the irradiance.
 *
 * A direction (x, y, 1), x and y being tangents, has the cosine n . (x, y, 1) / |(x, y, 1)|, and a pixel of the tangents' plane the solid angle
 * dx dy / |(x, y, 1)|^3. Together
 *
 *     w = (n . (x, y, 1))+ dx dy / (1 + x^2 + y^2)^2,
 *
 * which is, with d = h (x, y, 1) and pixels of ds = h dx, dt = h dy on a light at distance h, the same as (n . d)+ h ds dt / |d|^4. */
#include "cache/light_sample/window_kernels.h"

void SL_KERNEL(sl_window_weigh)(const sl_light_pixels *pixels, const uint32_t *inside, const uint32_t *id) {
    static const uint32_t bit[32] = {1u << 0,  1u << 1,  1u << 2,  1u << 3,  1u << 4,  1u << 5,  1u << 6,  1u << 7,
                                     1u << 8,  1u << 9,  1u << 10, 1u << 11, 1u << 12, 1u << 13, 1u << 14, 1u << 15,
                                     1u << 16, 1u << 17, 1u << 18, 1u << 19, 1u << 20, 1u << 21, 1u << 22, 1u << 23,
                                     1u << 24, 1u << 25, 1u << 26, 1u << 27, 1u << 28, 1u << 29, 1u << 30, 1u << 31};
    const int size = pixels->size, words = (size + 31) / 32;
    const float nx = pixels->normal.x, gx = pixels->geometric.x, scale = pixels->scale * pixels->step_x * pixels->step_y;
    for (int j = 0; j < size; j++) {
        const float y = pixels->y[j], n_row = pixels->normal.y * y + pixels->normal.z, q_row = 1.0f + y * y;
        const float g_row = pixels->geometric.y * y + pixels->geometric.z;
        for (int word = 0; word < words; word++) {
            const uint32_t on = inside[j * words + word];
            const int count = size - 32 * word < 32 ? size - 32 * word : 32;
            const int at = j * size + 32 * word;
            const float *restrict tx = pixels->x + 32 * word;
            const uint32_t *restrict ids = id + at;
            float *restrict all = pixels->all + at, *restrict seen = pixels->seen + at;
#pragma omp simd
            for (int i = 0; i < count; i++) {
                float x = tx[i], cosine = nx * x + n_row, above = gx * x + g_row, q = x * x + q_row;
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

/* Solid angle of a pixel: the integral of (1 + x^2 + y^2)^(-3/2) by Gauss's rule of 2 x 2 points. Where pixels are not small (steps of more than
 * 0.1 at the axis) its error would show; they have wide views, and are cut in four by four. */
static inline float gauss(float x, float y, float reach_x, float reach_y) {
    float sum = 0.0f;
    for (int k = 0; k < 4; k++) {
        float u = x + (k & 1 ? reach_x : -reach_x), v = y + (k & 2 ? reach_y : -reach_y), q = 1.0f + u * u + v * v;
        sum += 1.0f / (q * sqrtf(q));
    }
    return 0.25f * sum;
}

#define GAUSS_POINT 0.2886751346f /* of a pixel's step: 1 / (2 sqrt 3) */

static inline float fine_solid_angle(float x, float y, float step_x, float step_y) {
    return gauss(x, y, GAUSS_POINT * step_x, GAUSS_POINT * step_y) * step_x * step_y;
}

static float coarse_solid_angle(float x, float y, float step_x, float step_y) {
    float sum = 0.0f;
    for (int b = 0; b < 16; b++) {
        for (int a = 0; a < 16; a++) {
            float u = x + ((float)a - 7.5f) * 0.0625f * step_x, v = y + ((float)b - 7.5f) * 0.0625f * step_y;
            sum += gauss(u, v, 0.0625f * GAUSS_POINT * step_x, 0.0625f * GAUSS_POINT * step_y);
        }
    }
    return sum * (1.0f / 256.0f) * step_x * step_y;
}

void SL_KERNEL(sl_look_at_weigh)(const sl_light_pixels *pixels, const uint32_t *light_id, const uint8_t *facing,
                                 const float *light_depth, const float *depth) {
    const int size = pixels->size;
    const float step_x = pixels->step_x, step_y = pixels->step_y;
    const bool coarse = step_x > 0.1f || step_y > 0.1f;
    const float nx = pixels->normal.x, gx = pixels->geometric.x, scale = pixels->scale;
    for (int j = 0; j < size; j++) {
        const float y = pixels->y[j], n_row = pixels->normal.y * y + pixels->normal.z, q_row = 1.0f + y * y;
        const float g_row = pixels->geometric.y * y + pixels->geometric.z;
        const int at = j * size;
        const float *restrict tx = pixels->x, *restrict far = light_depth + at, *restrict here = depth + at;
        const uint32_t *restrict ids = light_id + at;
        float *restrict all = pixels->all + at, *restrict seen = pixels->seen + at;
        for (int i = 0; i < size; i++) { /* 1: a pixel of the light */
            all[i] = ids[i] != UINT32_MAX && facing[ids[i]] ? 1.0f : 0.0f;
            seen[i] = coarse && all[i] > 0.0f ? coarse_solid_angle(tx[i], y, step_x, step_y) : 0.0f;
        }
#pragma omp simd
        for (int i = 0; i < size; i++) {
            float x = tx[i], cosine = nx * x + n_row, above = gx * x + g_row, q = x * x + q_row;
            float angle = coarse ? seen[i] : fine_solid_angle(x, y, step_x, step_y);
            float w = angle * (scale * (cosine / sqrtf(q))) * all[i];
            w = cosine > 0.0f ? w : 0.0f;
            w = above > 0.0f ? w : 0.0f;
            all[i] = w;
            seen[i] = here[i] <= far[i] * 1.0001f ? w : 0.0f;
        }
    }
}
