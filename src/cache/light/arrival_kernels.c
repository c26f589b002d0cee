/* Light that arrives from a source at many points, shadows aside, and sums of it. */
#include "cache/light/light_kernels.h"

static inline float above(float value) { return value > 0.0f ? value : 0.0f; } /* 0 for NaN */

static void arrive_from_afar(const sl_light_points *points, const sl_light_source *source, sl_arrivals *out) {
    const float *restrict nx = points->normal_x, *restrict ny = points->normal_y,
                          *restrict nz = points->normal_z;
    const float *restrict gx = points->geometric_x, *restrict gy = points->geometric_y,
                          *restrict gz = points->geometric_z;
    float *restrict x = out->x, *restrict y = out->y, *restrict z = out->z, *restrict weight = out->weight;
    float dx = -source->direction.x, dy = -source->direction.y, dz = -source->direction.z;
    const size_t count = points->count;
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        x[i] = dx;
        y[i] = dy;
        z[i] = dz;
        float cosine = above(nx[i] * dx + ny[i] * dy + nz[i] * dz),
              facing = gx[i] * dx + gy[i] * dy + gz[i] * dz;
        weight[i] = facing > 0.0f ? cosine : 0.0f;
    }
}

void SL_KERNEL(sl_light_arrive)(const sl_light_points *points, const sl_light_source *source,
                                sl_arrivals *out) {
    if (source->kind == SL_SOURCE_DIRECTIONAL) {
        arrive_from_afar(points, source, out);
        return;
    }
    const float *restrict px = points->x, *restrict py = points->y, *restrict pz = points->z;
    const float *restrict nx = points->normal_x, *restrict ny = points->normal_y,
                          *restrict nz = points->normal_z;
    const float *restrict gx = points->geometric_x, *restrict gy = points->geometric_y,
                          *restrict gz = points->geometric_z;
    float *restrict x = out->x, *restrict y = out->y, *restrict z = out->z, *restrict weight = out->weight;
    const sl_vec3 l = source->position, d = source->direction;
    const bool area = source->kind == SL_SOURCE_AREA;
    /* A cone that holds everything, where there is none. */
    const bool cone = source->kind == SL_SOURCE_SPOT;
    const float extent = area ? source->extent : 0.0f, inner = cone ? source->cos_inner : -2.0f,
                outer = cone ? source->cos_outer : -3.0f;
    const size_t count = points->count;
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        float tx = l.x - px[i], ty = l.y - py[i], tz = l.z - pz[i];
        float squared = tx * tx + ty * ty + tz * tz;
        float over = 1.0f / sqrtf(squared > 0.0f ? squared : 1.0f);
        tx = tx * over;
        ty = ty * over;
        tz = tz * over;
        float cosine = above(nx[i] * tx + ny[i] * ty + nz[i] * tz),
              facing = gx[i] * tx + gy[i] * ty + gz[i] * tz;
        float emitted = -(d.x * tx + d.y * ty + d.z * tz);
        float shape = area ? above(emitted) : sl_spot_falloff(emitted, inner, outer);
        float value = cosine * shape / (squared + extent);
        x[i] = tx;
        y[i] = ty;
        z[i] = tz;
        weight[i] = facing > 0.0f && squared > 0.0f && squared < INFINITY ? value : 0.0f;
    }
}

void SL_KERNEL(sl_light_accumulate)(size_t count, sl_rgb colour, const float *restrict a,
                                    const float *restrict b, float *restrict r, float *restrict g,
                                    float *restrict bl) {
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        float term = a[i] * b[i];
        r[i] += colour.r * term;
        g[i] += colour.g * term;
        bl[i] += colour.b * term;
    }
}
