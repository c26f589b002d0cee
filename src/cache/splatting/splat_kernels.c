/* The splat's fragment program: Algorithm 1 of Gautron et al. 2005, steps 2 to 6, over a run of pixels of one row. Coverage on
 * the CPU and splats on the hardware share weight_at(), so that their sums of weights have the same bits. */
#include "cache/splatting/record.h"

#include <math.h>

static const float weight_epsilon = 1e-3f; /* w is singular at the record itself */

static inline float weight_at(const sl_record *k, const sl_weight_rules *rules, const sl_receivers *p, size_t i) {
    float dx = p->position_x[i] - k->position.x, dy = p->position_y[i] - k->position.y,
          dz = p->position_z[i] - k->position.z;
    float mx = p->normal_x[i] - k->normal.x, my = p->normal_y[i] - k->normal.y, mz = p->normal_z[i] - k->normal.z;
    float sx = p->normal_x[i] + k->normal.x, sy = p->normal_y[i] + k->normal.y, sz = p->normal_z[i] + k->normal.z;
    float distance = sqrtf(dx * dx + dy * dy + dz * dz);
    float turn = sqrtf(mx * mx + my * my + mz * mz);
    /* (2): D = |p - p_k| / R + sqrt(1 - n.n_k), the root written as |n - n_k| / sqrt 2, which rounding cannot make
     * negative and which keeps its digits for small angles. */
    float d = distance / k->radius + turn * 0.70710678f;
    float reach = rules->accuracy * k->radius;
    /* A record in front of p sees what p does not; one far behind p belongs to another step of the stairs. s vanishes on
     * spheres, convex and concave, so curvature is not punished. */
    float s = 0.5f * (dx * sx + dy * sy + dz * sz);
    float front = -(0.01f * reach + rules->front_tolerance);
    /* & and not &&: no branches, so that the loop vectorises. */
    int accepted = (p->receives[i] != 0) & (d <= rules->accuracy) & (distance <= reach) & (s >= front) &
                   (s <= 0.5f * reach + rules->front_tolerance);
    float w = 1.0f / (d > weight_epsilon ? d : weight_epsilon) - rules->offset;
    return accepted ? (w > 0.0f ? w : 0.0f) : 0.0f;
}

/* (8), with absolute gradients: E' = E + (n_k x n) . grad_r E + (p - p_k) . grad_t E, kept within what the record can vouch
 * for: not negative, not above E (1 + a) + |grad_r E| |n_k x n|. */
static inline float extrapolate(float e, sl_vec3 rotational, float rotational_length, sl_vec3 translational, sl_vec3 turn,
                                float turn_length, sl_vec3 delta, float accuracy) {
    float value = e + sl_dot(turn, rotational) + sl_dot(delta, translational);
    float most = e * (1.0f + accuracy) + rotational_length * turn_length;
    value = value < most ? value : most;
    return value > 0.0f ? value : 0.0f;
}

static uint64_t SL_KERNEL(splat)(const sl_record *k, const sl_weight_rules *rules, const sl_receivers *p,
                                 const sl_splat_buffer *buffer, size_t first, size_t end) {
    float *restrict r = buffer->r, *restrict g = buffer->g, *restrict b = buffer->b;
    float *restrict weight = buffer->weight, *restrict count = buffer->count;
    uint64_t blended = 0;
    const sl_record record = *k;
    const sl_receivers pixels = *p;
    const sl_weight_rules rule = *rules;
#pragma omp simd reduction(+ : blended)
    for (size_t i = first; i < end; i++) {
        float w = weight_at(&record, &rule, &pixels, i);
        sl_vec3 n = sl_v3(pixels.normal_x[i], pixels.normal_y[i], pixels.normal_z[i]);
        sl_vec3 delta = sl_v3(pixels.position_x[i] - record.position.x, pixels.position_y[i] - record.position.y,
                              pixels.position_z[i] - record.position.z);
        sl_vec3 turn = sl_cross(record.normal, n);
        float turn_length = sl_length(turn);
        float er = extrapolate(record.irradiance.r, record.rotational[0], record.rotational_length[0],
                               record.translational[0], turn, turn_length, delta, rule.accuracy);
        float eg = extrapolate(record.irradiance.g, record.rotational[1], record.rotational_length[1],
                               record.translational[1], turn, turn_length, delta, rule.accuracy);
        float eb = extrapolate(record.irradiance.b, record.rotational[2], record.rotational_length[2],
                               record.translational[2], turn, turn_length, delta, rule.accuracy);
        int contributes = w > 0.0f;
        r[i] += contributes ? w * er : 0.0f;
        g[i] += contributes ? w * eg : 0.0f;
        b[i] += contributes ? w * eb : 0.0f;
        weight[i] += w;
        count[i] += contributes ? 1.0f : 0.0f;
        blended += (uint64_t)contributes;
    }
    return blended;
}

static uint64_t SL_KERNEL(cover)(const sl_record *k, const sl_weight_rules *rules, const sl_receivers *p,
                                 float *restrict coverage, size_t first, size_t end) {
    uint64_t blended = 0;
    const sl_record record = *k;
    const sl_receivers pixels = *p;
    const sl_weight_rules rule = *rules;
#pragma omp simd reduction(+ : blended)
    for (size_t i = first; i < end; i++) {
        float w = weight_at(&record, &rule, &pixels, i);
        coverage[i] += w;
        blended += w > 0.0f;
    }
    return blended;
}

static float SL_KERNEL(weight)(const sl_record *k, const sl_weight_rules *rules, const sl_receivers *p, size_t pixel) {
    return weight_at(k, rules, p, pixel);
}

extern const sl_splat_kernels SL_KERNEL(sl_splat_kernel_table);
const sl_splat_kernels SL_KERNEL(sl_splat_kernel_table) = {SL_KERNEL(splat), SL_KERNEL(cover), SL_KERNEL(weight)};
