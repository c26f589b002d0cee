#include "cache/hemisphere/hit_light_kernels.h"

#include "base/math.h"

enum { LANES = SL_SOURCE_LANES };

/* A hit: the same for all sources of a block. */
typedef struct receiver {
    float x, y, z, normal_x, normal_y, normal_z;
} receiver;

/* ---- how much each source of a block can matter at a hit ---- */

/* Enough for a choice: error below 2e-5. */
static inline float rough_angle(float y, float x) { /* of (x, y), y >= 0, in [0, pi] */
    float ax = fabsf(x), larger = ax > y ? ax : y, smaller = ax > y ? y : ax;
    float t = smaller / (larger > 0.0f ? larger : 1.0f), q = t * t;
    float a = t * (0.999866f + q * (-0.3302995f + q * (0.180141f + q * (-0.085133f + q * 0.0208351f))));
    a = y > ax ? 1.57079633f - a : a;
    return x < 0.0f ? 3.14159265f - a : a;
}

/* Nearer than this share of the squared distance within which points are chosen by solid angle. */
static const float by_angle = 0.25f;

/* Within an emitter's size of it: radiance times solid angle times about its mean cosine. */
static void weigh_near_emitters(const sl_light_sources *s, size_t first, receiver p, float *restrict weight) {
    const float *restrict sx = s->x + first, *restrict sy = s->y + first, *restrict sz = s->z + first;
    const float *restrict near = s->near + first, *restrict radiance = s->radiance + first;
    const float *restrict ax = s->corner[0][0] + first, *restrict ay = s->corner[0][1] + first,
                          *restrict az = s->corner[0][2] + first;
    const float *restrict bx = s->corner[1][0] + first, *restrict by = s->corner[1][1] + first,
                          *restrict bz = s->corner[1][2] + first;
    const float *restrict cx = s->corner[2][0] + first, *restrict cy = s->corner[2][1] + first,
                          *restrict cz = s->corner[2][2] + first;
    float unit = s->unit;
#pragma omp simd
    for (int l = 0; l < LANES; l++) {
        float dx = (sx[l] - p.x) * unit, dy = (sy[l] - p.y) * unit, dz = (sz[l] - p.z) * unit;
        float squared = dx * dx + dy * dy + dz * dz;
        float ux = (ax[l] - p.x) * unit, uy = (ay[l] - p.y) * unit, uz = (az[l] - p.z) * unit;
        float vx = (bx[l] - p.x) * unit, vy = (by[l] - p.y) * unit, vz = (bz[l] - p.z) * unit;
        float wx = (cx[l] - p.x) * unit, wy = (cy[l] - p.y) * unit, wz = (cz[l] - p.z) * unit;
        float over_u = 1.0f / sqrtf(ux * ux + uy * uy + uz * uz + 1e-30f),
              over_v = 1.0f / sqrtf(vx * vx + vy * vy + vz * vz + 1e-30f);
        float over_w = 1.0f / sqrtf(wx * wx + wy * wy + wz * wz + 1e-30f);
        ux *= over_u, uy *= over_u, uz *= over_u, vx *= over_v, vy *= over_v, vz *= over_v, wx *= over_w,
            wy *= over_w, wz *= over_w;
        float volume = fabsf(ux * (vy * wz - vz * wy) + uy * (vz * wx - vx * wz) + uz * (vx * wy - vy * wx));
        float around = 1.0f + (ux * vx + uy * vy + uz * vz) + (vx * wx + vy * wy + vz * wz) +
                       (wx * ux + wy * uy + wz * uz);
        float angle = 2.0f * rough_angle(volume, around);
        float middle = (dx * p.normal_x + dy * p.normal_y + dz * p.normal_z) / sqrtf(squared + 1e-30f);
        float cu = ux * p.normal_x + uy * p.normal_y + uz * p.normal_z,
              cv = vx * p.normal_x + vy * p.normal_y + vz * p.normal_z;
        float cw = wx * p.normal_x + wy * p.normal_y + wz * p.normal_z;
        float mean = 0.02f + 0.5f * (middle > 0.0f ? middle : 0.0f);
        mean += (1.0f / 6.0f) * ((cu > 0.0f ? cu : 0.0f) + (cv > 0.0f ? cv : 0.0f) + (cw > 0.0f ? cw : 0.0f));
        bool risen = (middle > 0.0f) | (cu > 0.0f) | (cv > 0.0f) | (cw > 0.0f);
        float w = risen ? radiance[l] * angle * mean : 0.0f;
        weight[l] = ((squared < by_angle * near[l]) & (weight[l] > 0.0f)) ? w : weight[l];
    }
}

/* strength cos cos' / d^2 by the centroids; the cosine at the hit falls smoothly to 0 where all of an emitter
 * has set. */
static inline void weigh_emitters(const sl_light_sources *s, size_t first, receiver p,
                                  float *restrict weight) {
    const float *restrict sx = s->x + first, *restrict sy = s->y + first, *restrict sz = s->z + first;
    const float *restrict ex = s->normal_x + first, *restrict ey = s->normal_y + first,
                          *restrict ez = s->normal_z + first;
    const float *restrict extents = s->extent + first, *restrict strength = s->strength + first;
    const float *restrict near = s->near + first, *restrict two_sided = s->two_sided + first;
    float unit = s->unit;
    int any_near = 0;
#pragma omp simd reduction(| : any_near)
    for (int l = 0; l < LANES; l++) {
        float dx = (sx[l] - p.x) * unit, dy = (sy[l] - p.y) * unit, dz = (sz[l] - p.z) * unit,
              extent = extents[l];
        float squared = dx * dx + dy * dy + dz * dz, least = 0.25f * extent * extent;
        float above = p.normal_x * dx + p.normal_y * dy + p.normal_z * dz;
        float part = above + extent;
        part = part > 0.0f ? part : 0.0f;
        above = above > extent ? above : part * part * (0.25f / extent);
        float front = -(ex[l] * dx + ey[l] * dy + ez[l] * dz), size = fabsf(front);
        front = two_sided[l] > 0.0f ? size : front;
        float over = 1.0f / (squared > least ? squared : least);
        float w = strength[l] * (above * over) * (front * over);
        weight[l] = front > 0.0f ? w : 0.0f;
        any_near |= squared < by_angle * near[l];
    }
    if (any_near) weigh_near_emitters(s, first, p, weight);
}

/* The squares of a unit normal's components sum to 1, they weigh the six irradiances. */
static inline void weigh_sky(const sl_light_sources *s, receiver p, float *restrict weight) {
    const float *sky = s->sky_irradiance;
    float x = p.normal_x, y = p.normal_y, z = p.normal_z;
    float sum = x * x * (x < 0.0f ? sky[1] : sky[0]) + y * y * (y < 0.0f ? sky[3] : sky[2]) +
                z * z * (z < 0.0f ? sky[5] : sky[4]);
    for (int l = 0; l < LANES; l++) weight[l] = l == 0 ? sum : 0.0f;
}

static inline void weigh_block(const sl_light_sources *s, size_t block, receiver p, float *restrict weight) {
    if (block * LANES < s->sky) weigh_emitters(s, block * LANES, p, weight);
    else weigh_sky(s, p, weight);
}

static inline float sum_of(const float *w) { /* in a fixed shape */
    float a[8], b[4];
#pragma omp simd
    for (int l = 0; l < 8; l++) a[l] = w[l] + w[l + 8];
#pragma omp simd
    for (int l = 0; l < 4; l++) b[l] = a[l] + a[l + 4];
    return (b[0] + b[2]) + (b[1] + b[3]);
}

static inline receiver receiver_of(const sl_expected_light *c, size_t k) {
    const sl_light_points *at = &c->at;
    return (receiver){at->x[k], at->y[k], at->z[k], at->normal_x[k], at->normal_y[k], at->normal_z[k]};
}

void SL_KERNEL(sl_hit_light_block)(const sl_light_sources *sources, const sl_expected_light *light,
                                   size_t slot, size_t block, sl_block_weights *weights) {
    weigh_block(sources, block, receiver_of(light, slot), weights->of);
}

void SL_KERNEL(sl_hit_light_expect)(const sl_light_sources *s, const sl_expected_light *c) {
    for (size_t k = 0; k < c->at.count; k++) {
        float *of_block = c->of_block + k * SL_SOURCE_BLOCKS_MAX, sum = 0.0f;
        c->sum[k] = 0.0f;
        if (!(c->reflects[k] > 0.0f)) continue;
        receiver p = receiver_of(c, k);
        for (size_t b = 0; b < s->blocks; b++) {
            sl_block_weights w;
            weigh_block(s, b, p, w.of);
            sum += of_block[b] = sum_of(w.of);
        }
        c->sum[k] = sum > 0.0f && sum < 1e30f ? sum : 0.0f;
    }
}

/* ---- points of emitters ---- */

/* Uniform on the triangle: (1 - sqrt u1, sqrt u1 (1 - u2), sqrt u1 u2). What arrives of the radiance: area
 * cos cos' / d^2, cut where it would stand for more than the solid angle of a hemisphere (only emitters with
 * alpha masks are sampled so near). */
void SL_KERNEL(sl_hit_light_points)(const sl_light_sources *s, const sl_point_samples *c) {
    const uint32_t *restrict slot = c->slot, *restrict source = c->source;
    const float *restrict u1 = c->u1, *restrict u2 = c->u2, *restrict share = c->share;
    const float *restrict px = c->at.x, *restrict py = c->at.y, *restrict pz = c->at.z;
    const float *restrict nx = c->at.normal_x, *restrict ny = c->at.normal_y, *restrict nz = c->at.normal_z;
    const float *restrict gx = c->at.geometric_x, *restrict gy = c->at.geometric_y,
                          *restrict gz = c->at.geometric_z;
    const float *restrict ax = s->corner[0][0], *restrict ay = s->corner[0][1],
                          *restrict az = s->corner[0][2];
    const float *restrict bx = s->corner[1][0], *restrict by = s->corner[1][1],
                          *restrict bz = s->corner[1][2];
    const float *restrict cx = s->corner[2][0], *restrict cy = s->corner[2][1],
                          *restrict cz = s->corner[2][2];
    const float *restrict sx = s->x, *restrict sy = s->y, *restrict sz = s->z;
    const float *restrict ex = s->normal_x, *restrict ey = s->normal_y, *restrict ez = s->normal_z;
    const float *restrict area = s->area, *restrict two_sided = s->two_sided, *restrict limit = s->near;
    float *restrict ox = c->origin_x, *restrict oy = c->origin_y, *restrict oz = c->origin_z;
    float *restrict dx = c->direction_x, *restrict dy = c->direction_y, *restrict dz = c->direction_z;
    float *restrict arriving = c->arriving, *restrict near = c->near;
    float offset = c->offset, rounding = c->rounding, unit = s->unit;
    const float hemisphere = (float)(2.0 * SL_PI);
#pragma omp simd
    for (size_t m = 0; m < c->count; m++) {
        size_t k = slot[m], i = source[m];
        float root = sqrtf(u1[m]), w1 = root * (1.0f - u2[m]), w2 = root * u2[m];
        float x = (ax[i] - px[k]) + (w1 * (bx[i] - ax[i]) + w2 * (cx[i] - ax[i]));
        float y = (ay[i] - py[k]) + (w1 * (by[i] - ay[i]) + w2 * (cy[i] - ay[i]));
        float z = (az[i] - pz[k]) + (w1 * (bz[i] - az[i]) + w2 * (cz[i] - az[i]));
        float mx = (sx[i] - px[k]) * unit, my = (sy[i] - py[k]) * unit, mz = (sz[i] - pz[k]) * unit;
        near[m] = mx * mx + my * my + mz * mz < limit[i] ? 1.0f : 0.0f;
        float tx = x * unit, ty = y * unit, tz = z * unit, squared = tx * tx + ty * ty + tz * tz;
        float above = nx[k] * tx + ny[k] * ty + nz[k] * tz,
              above_plane = gx[k] * tx + gy[k] * ty + gz[k] * tz;
        float front = -(ex[i] * tx + ey[i] * ty + ez[i] * tz), size = fabsf(front);
        front = two_sided[i] > 0.0f ? size : front;
        bool lit = (above > 0.0f) & (above_plane > 0.0f) & (front > 0.0f) & (squared > 1e-30f);
        float over = 1.0f / (lit ? squared : 1.0f), per_length = sqrtf(over);
        float solid = area[i] * (front * per_length) * over;
        solid = solid < hemisphere ? solid : hemisphere;
        arriving[m] = lit ? solid * (above * per_length) * share[m] : 0.0f;
        float across = fabsf(px[k]), up = fabsf(py[k]), along = fabsf(pz[k]);
        float furthest = across > up ? across : up;
        furthest = rounding * (furthest > along ? furthest : along);
        float off = furthest > offset ? furthest : offset;
        float shift_x = off * gx[k], shift_y = off * gy[k], shift_z = off * gz[k];
        ox[m] = px[k] + shift_x, oy[m] = py[k] + shift_y, oz[m] = pz[k] + shift_z;
        dx[m] = x - shift_x, dy[m] = y - shift_y, dz[m] = z - shift_z;
    }
}
