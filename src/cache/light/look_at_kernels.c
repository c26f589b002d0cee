/* The fragment program of the light's picture: what a pixel adds to the irradiance.
 *
 * A direction (x, y, 1), x and y being tangents, has the cosine n . (x, y, 1) / |(x, y, 1)|, and a pixel of
 * the tangents' plane the solid angle dx dy / |(x, y, 1)|^3. Together
 *
 *     w = (n . (x, y, 1))+ dx dy / (1 + x^2 + y^2)^2,
 *
 * of which the middle of the pixel stands for all. */
#include "cache/light/sample_kernels.h"

void SL_KERNEL(sl_look_at_weigh)(const sl_light_pixels *pixels, const uint32_t *light_id,
                                 const uint8_t *facing, const float *light_depth, const float *depth) {
    const int size = pixels->size;
    const float scale = pixels->scale;
    const sl_vec3 n = pixels->normal, g = pixels->geometric;
    for (int j = 0; j < size; j++) {
        const float row_x = pixels->row_x[j], row_y = pixels->row_y[j];
        const int at = j * size;
        const float *restrict tx = pixels->column_x, *restrict ty = pixels->column_y,
                              *restrict far = light_depth + at, *restrict here = depth + at;
        const uint32_t *restrict ids = light_id + at;
        float *restrict all = pixels->all + at, *restrict seen = pixels->seen + at;
        for (int i = 0; i < size; i++) seen[i] = ids[i] != UINT32_MAX && facing[ids[i]] ? scale : 0.0f;
#pragma omp simd
        for (int i = 0; i < size; i++) {
            float x = tx[i] + row_x, y = ty[i] + row_y, q = (1.0f + x * x) + y * y;
            float cosine = (n.x * x + n.y * y) + n.z, above = (g.x * x + g.y * y) + g.z;
            float w = cosine * seen[i] / (q * q);
            w = cosine > 0.0f ? w : 0.0f;
            w = above > 0.0f ? w : 0.0f;
            all[i] = w;
            seen[i] = here[i] <= far[i] * 1.0001f ? w : 0.0f;
        }
    }
}
