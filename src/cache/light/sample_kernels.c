#include <float.h>

#include "base/random.h"
#include "cache/light/sample_kernels.h"

/* ---- pictures ---- */

/* The fragment program of the light's picture: what a pixel adds to the irradiance.
 *
 * A direction (x, y, 1), x and y being tangents, has the cosine n . (x, y, 1) / |(x, y, 1)|, and a pixel of
 * the tangents' plane the solid angle dx dy / |(x, y, 1)|^3. Together
 *
 *     w = (n . (x, y, 1))+ dx dy / (1 + x^2 + y^2)^2,
 *
 * of which the middle of the pixel stands for all. */
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

/* ---- shadow rays to an area light, a packet at a time: where they are aimed, what each is worth ---- */

/* One hash a ray: sixteen bits of it move the ray within its stratum's width, sixteen within its height. */
void SL_KERNEL(sl_ray_jitter)(uint64_t key, int n, const int32_t *restrict column,
                              const int32_t *restrict row, float *restrict u, float *restrict v) {
    const float over = 1.0f / (float)n;
#pragma omp simd
    for (int i = 0; i < SL_AIMED; i++) {
        uint32_t bits = sl_random_bits(key, (uint64_t)(uint32_t)(row[i] * n + column[i]));
        u[i] = ((float)column[i] + (float)(int32_t)(bits >> 16) * 0x1p-16f) * over;
        v[i] = ((float)row[i] + (float)(int32_t)(bits & 0xffff) * 0x1p-16f) * over;
    }
}

/* (n . d)+ (-m . d)+ / |d|^4, each cosine over |d|^2 so that tiny distances do not overflow early. */
void SL_KERNEL(sl_ray_weights)(const sl_ray_receiver *receiver, sl_aimed_rays *restrict r) {
    const sl_vec3 n = receiver->normal, g = receiver->geometric;
    const float scale = receiver->scale, flatness = receiver->flatness;
    const bool two_sided = receiver->two_sided;
#pragma omp simd
    for (int i = 0; i < SL_AIMED; i++) {
        float x = r->x[i], y = r->y[i], z = r->z[i], squared = (x * x + y * y) + z * z,
              over = 1.0f / (squared > 0.0f ? squared : 1.0f);
        float high = (n.x * x + n.y * y) + n.z * z, above = (g.x * x + g.y * y) + g.z * z;
        float front = -((r->normal_x[i] * x + r->normal_y[i] * y) + r->normal_z[i] * z);
        front = two_sided ? fabsf(front) : front;
        float w = (high * over) * (front * over) * scale, room = flatness / (front > 0.0f ? front : 1.0f);
        w = high > 0.0f ? w : 0.0f;
        w = above > 0.0f ? w : 0.0f;
        w = front > 0.0f ? w : 0.0f;
        w = squared > 0.0f ? w : 0.0f;
        r->weight[i] = w < FLT_MAX ? w : 0.0f;
        room = room < 0.5f ? room : 0.5f;
        r->far[i] = 1.0f - (room > receiver->margin ? room : receiver->margin);
    }
}
