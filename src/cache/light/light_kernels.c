#include "cache/light/light_kernels.h"

#include "base/math.h"

/* ---- light that arrives from a source at many points, shadows aside, and sums of it ---- */

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

/* ---- the unhindered light of a triangle ---- */

/* Lambert's formula for many points at once: the irradiance from a triangle of radiance 1,
 *
 *     E = -1/2 sum over edges of angle (n . u),   u the unit normal of the edge's plane through the point,
 *
 * of what lies above the horizon. Instead of making a clipped polygon, every edge is cut to the part t0..t1
 * of it that lies above (its plane stays the same), and one more edge runs along the horizon from where the
 * outline leaves to where it comes back.
 *
 * Far away the sum is a small difference of large terms: where the emitter is seen within 0.005 rad, it is
 * taken as a point.
 */

/* The angle of (x, y), y >= 0, in [0, pi]; error below 5e-7. */
static inline float angle_of(float y, float x) {
    float size = fabsf(x), small = y < size ? y : size, large = y < size ? size : y;
    float q = small / (large > 0.0f ? large : 1.0f), z = q * q;
    float p = -0x1.31f904p-8f; /* atan(q) / q, least squares at Chebyshev nodes */
    p = p * z + 0x1.8bf086p-6f;
    p = p * z - 0x1.e655d6p-5f;
    p = p * z + 0x1.95c0f4p-4f;
    p = p * z - 0x1.1f0f46p-3f;
    p = p * z + 0x1.98f84ep-3f;
    p = p * z - 0x1.5551bcp-2f;
    p = p * z + 0x1.fffffcp-1f;
    float a = p * q;
    a = y < size ? a : (float)(0.5 * SL_PI) - a;
    return x < 0.0f ? (float)SL_PI - a : a;
}

/* angle (n . u) of the part t0..t1 of the edge from a along e. */
static inline float edge_term(sl_vec3 n, sl_vec3 a, sl_vec3 e, float t0, float t1) {
    sl_vec3 c = sl_cross(a, e);
    float length = sqrtf(sl_dot(c, c)),
          swing = angle_of(length * (t1 - t0), sl_dot(sl_mad(a, t0, e), sl_mad(a, t1, e)));
    return swing * (sl_dot(n, c) / (length > 0.0f ? length : 1.0f));
}

/* Returns a where is_a, else b where is_b, else c; number by number, so that loops over it vectorise. */
static inline sl_vec3 one_of(bool is_a, sl_vec3 a, bool is_b, sl_vec3 b, sl_vec3 c) {
    return sl_v3(is_a ? a.x : is_b ? b.x : c.x, is_a ? a.y : is_b ? b.y : c.y, is_a ? a.z : is_b ? b.z : c.z);
}

void SL_KERNEL(sl_polygon_light)(const sl_light_points *points, const sl_polygon_light *light,
                                 float *restrict irradiance) {
    const float *restrict px = points->x, *restrict py = points->y, *restrict pz = points->z;
    const float *restrict nx = points->normal_x, *restrict ny = points->normal_y,
                          *restrict nz = points->normal_z;
    const sl_vec3 v0 = light->corner[0], v1 = light->corner[1], v2 = light->corner[2], out = light->normal;
    const sl_vec3 e0 = sl_sub(v1, v0), e1 = sl_sub(v2, v1), e2 = sl_sub(v0, v2);
    const sl_vec3 centre = {(v0.x + v1.x + v2.x) / 3.0f, (v0.y + v1.y + v2.y) / 3.0f,
                            (v0.z + v1.z + v2.z) / 3.0f};
    const float far_away = light->extent_squared * (1.0f / (0.005f * 0.005f)),
                area = light->area;
    const size_t count = points->count;
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        sl_vec3 p = {px[i], py[i], pz[i]}, n = {nx[i], ny[i], nz[i]};
        sl_vec3 a = sl_sub(v0, p), b = sl_sub(v1, p), c = sl_sub(v2, p), m = sl_sub(centre, p);
        float ha = sl_dot(n, a), hb = sl_dot(n, b), hc = sl_dot(n, c);
        /* Where each edge crosses the horizon. */
        float ta = ha / (ha != hb ? ha - hb : 1.0f), tb = hb / (hb != hc ? hb - hc : 1.0f),
              tc = hc / (hc != ha ? hc - ha : 1.0f);
        bool ua = ha >= 0.0f, ub = hb >= 0.0f, uc = hc >= 0.0f;
        float sum = edge_term(n, a, e0, ua ? 0.0f : ub ? ta : 0.0f, ub ? 1.0f : ua ? ta : 0.0f);
        sum += edge_term(n, b, e1, ub ? 0.0f : uc ? tb : 0.0f, uc ? 1.0f : ub ? tb : 0.0f);
        sum += edge_term(n, c, e2, uc ? 0.0f : ua ? tc : 0.0f, ua ? 1.0f : uc ? tc : 0.0f);
        sl_vec3 pa = sl_mad(a, ta, e0), pb = sl_mad(b, tb, e1), pc = sl_mad(c, tc, e2);
        bool leaves_a = ua && !ub, leaves_b = ub && !uc, leaves_c = uc && !ua;
        bool comes_a = !ua && ub, comes_b = !ub && uc;
        sl_vec3 from = one_of(leaves_a, pa, leaves_b, pb, pc), to = one_of(comes_a, pa, comes_b, pb, pc);
        float horizon = edge_term(n, from, sl_sub(to, from), 0.0f, 1.0f);
        sum += leaves_a || leaves_b || leaves_c ? horizon : 0.0f;
        float near_value = -0.5f * sum;

        float squared = sl_dot(m, m), over = 1.0f / (squared > 0.0f ? squared : 1.0f), high = sl_dot(n, m),
              front = -sl_dot(out, m);
        high = high > 0.0f ? high : 0.0f;
        float far_value = area * high * front * over * over;
        float value = squared > far_away ? far_value : near_value;
        /* not from behind, nor in its plane, or on it */
        value = front > 1e-5f * sqrtf(squared + light->extent_squared) ? value : 0.0f;
        irradiance[i] = value > 0.0f ? value : 0.0f;
    }
}

/* ---- one of many sides, and a point of it ---- */

/* The first side whose cumulative sum exceeds u0 of the whole; sums fall in no gap, since u0 < 1. */
static void choose(const sl_aim_block *block, int32_t *restrict chosen) {
    const size_t count = block->points->count;
    const float *restrict u0 = block->u0, *restrict total = block->sums + (block->sides - 1) * SL_LIGHT_BLOCK;
    for (size_t i = 0; i < count; i++) chosen[i] = 0;
    for (size_t side = 0; side + 1 < block->sides; side++) {
        const float *restrict sum = block->sums + side * SL_LIGHT_BLOCK;
#pragma omp simd
        for (size_t i = 0; i < count; i++) chosen[i] += u0[i] * total[i] >= sum[i] ? 1 : 0;
    }
}

void SL_KERNEL(sl_direct_aim)(const sl_aim_block *block) {
    const size_t count = block->points->count;
    int32_t *restrict chosen = block->chosen, base[SL_LIGHT_BLOCK], place[SL_LIGHT_BLOCK];
    choose(block, chosen);
    for (size_t i = 0; i < count; i++) {
        base[i] = (int32_t)block->side[chosen[i]] * SL_SIDE_VALUES;
        place[i] = chosen[i] * SL_LIGHT_BLOCK + (int32_t)i;
    }
    const float *restrict px = block->points->x, *restrict py = block->points->y,
                          *restrict pz = block->points->z;
    const float *restrict nx = block->points->normal_x, *restrict ny = block->points->normal_y,
                          *restrict nz = block->points->normal_z;
    const float *restrict gx = block->points->geometric_x, *restrict gy = block->points->geometric_y,
                          *restrict gz = block->points->geometric_z;
    const float *restrict u1 = block->u1, *restrict u2 = block->u2, *restrict share = block->share;
    const float *restrict total = block->sums + (block->sides - 1) * SL_LIGHT_BLOCK;
    const float *t0 = block->values, *t1 = t0 + 1, *t2 = t0 + 2, *t3 = t0 + 3, *t4 = t0 + 4, *t5 = t0 + 5,
                *t6 = t0 + 6, *t7 = t0 + 7;
    const float *t8 = t0 + 8, *t9 = t0 + 9, *t10 = t0 + 10, *t11 = t0 + 11, *t12 = t0 + 12, *t13 = t0 + 13,
                *t14 = t0 + 14, *t15 = t0 + 15;
    float *restrict x = block->x, *restrict y = block->y, *restrict z = block->z,
                    *restrict weight = block->weight;
    float *restrict r = block->r, *restrict g = block->g, *restrict b = block->b,
                    *restrict wanted = block->wanted;
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        int32_t k = base[i];
        /* uniform on the triangle */
        float root = sqrtf(u1[i]), w1 = root * (1.0f - u2[i]), w2 = root * u2[i];
        float tx = t0[k] + w1 * t3[k] + w2 * t6[k] - px[i];
        float ty = t1[k] + w1 * t4[k] + w2 * t7[k] - py[i];
        float tz = t2[k] + w1 * t5[k] + w2 * t8[k] - pz[i];
        float squared = tx * tx + ty * ty + tz * tz;
        float cosine = nx[i] * tx + ny[i] * ty + nz[i] * tz,
              emitted = -(t9[k] * tx + t10[k] * ty + t11[k] * tz);
        float facing = gx[i] * tx + gy[i] * ty + gz[i] * tz, exact = share[place[i]];
        /* f / pdf = (cos cos' A / d^2) / (E_side / E_all), both cosines times d. */
        float form = t12[k] * cosine * emitted / (squared > 0.0f ? squared * squared : 1.0f);
        float relative = form / (exact > 0.0f ? exact : 1.0f);
        bool lit = cosine > 0.0f && emitted > 0.0f && exact > 0.0f && squared > 0.0f;
        x[i] = tx;
        y[i] = ty;
        z[i] = tz;
        r[i] = t13[k];
        g[i] = t14[k];
        b[i] = t15[k];
        weight[i] = lit ? relative * total[i] : 0.0f;
        wanted[i] = lit && facing > 0.0f ? 1.0f : 0.0f;
    }
}
