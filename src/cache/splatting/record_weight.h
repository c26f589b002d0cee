/* Weight and value of a record at a point: (2), (3) and (8) of Gautron et al. 2005, as they are inlined into
 * the loops over a splat's pixels and over the records around a point. */
#pragma once

#include "cache/splatting/record.h"

#include <math.h>

/* w is singular at the record itself: D counts as no less than this. A tenth of a where that is less, since
 * weights of 1 / D - 1 / a would all be 0. */
static inline float sl_record_least_distance(float accuracy) {
    return 0.1f * accuracy < 1e-3f ? 0.1f * accuracy : 1e-3f;
}

/* Common to all points that a record is asked about. */
typedef struct sl_record_terms {
    sl_vec3 position, normal;
    float inverse_radius, accuracy, least, offset;
    float reach_squared;    /* (a R)^2 */
    float front, behind;    /* bounds of 2 s, see sl_record_weight_at() */
    /* E, and E (1 + a sigma): as much as rule 1 (record.h) lets the extrapolation grow */
    float e[3], most[3];
    sl_record_wall walls[SL_RECORD_WALLS];
    int has_walls;
    sl_vec3 rotational[3];  /* grad_r E x n_k */
    sl_vec3 translational[3];
    float rotational_length[3];
} sl_record_terms;

static inline sl_record_terms sl_record_terms_of(const sl_record *k, const sl_weight_rules *rules) {
    float reach = rules->accuracy * k->radius;
    sl_record_terms s = {.position = k->position, .normal = k->normal, .inverse_radius = 1.0f / k->radius,
                         .accuracy = rules->accuracy, .least = sl_record_least_distance(rules->accuracy),
                         .offset = rules->offset, .reach_squared = reach * reach,
                         .front = -2.0f * (0.01f * reach + rules->front_tolerance),
                         .behind = reach + 2.0f * rules->front_tolerance};
    for (int i = 0; i < SL_RECORD_WALLS; i++) {
        s.walls[i] = k->walls[i];
        s.has_walls |= k->walls[i].offset < 0.0f;
    }
    const float e[3] = {k->irradiance.r, k->irradiance.g, k->irradiance.b};
    for (int c = 0; c < 3; c++) {
        s.e[c] = e[c];
        s.most[c] = e[c] * (1.0f + rules->accuracy * k->stretch);
        s.rotational[c] = sl_cross(k->rotational[c], k->normal);
        s.translational[c] = k->translational[c];
        s.rotational_length[c] = k->rotational_length[c];
    }
    return s;
}

/* Between a point and a record. */
typedef struct sl_record_offsets {
    float x, y, z;    /* p - p_k */
    float mx, my, mz; /* n - n_k */
} sl_record_offsets;

static inline float sl_record_squared_distance(const sl_record_terms *s, float px, float py, float pz) {
    float x = px - s->position.x, y = py - s->position.y, z = pz - s->position.z;
    return x * x + y * y + z * z;
}

static inline sl_record_offsets sl_record_offsets_at(const sl_record_terms *s, float px, float py, float pz,
                                                     float nx, float ny, float nz) {
    return (sl_record_offsets){px - s->position.x, py - s->position.y, pz - s->position.z,
                               nx - s->normal.x,   ny - s->normal.y,   nz - s->normal.z};
}

/* |n - n_k| */
static inline float sl_record_turn(const sl_record_offsets *o) {
    return sqrtf(o->mx * o->mx + o->my * o->my + o->mz * o->mz);
}

/* The caller compares the squared distance with (a R)^2. */
static inline float sl_record_weight_at(const sl_record_terms *k, float distance_squared, float px, float py,
                                        float pz, float nx, float ny, float nz) {
    const sl_record_offsets o = sl_record_offsets_at(k, px, py, pz, nx, ny, nz);
    /* (2): D = |p - p_k| / R + sqrt(1 - n.n_k), the root written as |n - n_k| / sqrt 2, which rounding cannot
     * make negative and which keeps its digits for small angles. */
    float d = sqrtf(distance_squared) * k->inverse_radius + sl_record_turn(&o) * 0.70710678f;
    /* s = (p - p_k) . (n + n_k) / 2. A record in front of p sees what p does not (s < -a R / 100); one far
     * behind p belongs to another step of the stairs (s > a R / 2). s vanishes on spheres, convex and
     * concave, so curvature is not punished. */
    float s2 = o.x * (nx + k->normal.x) + o.y * (ny + k->normal.y) + o.z * (nz + k->normal.z);
    int accepted = (d <= k->accuracy) & (s2 >= k->front) & (s2 <= k->behind);
    float w = 1.0f / (d > k->least ? d : k->least) - k->offset;
    return accepted ? (w > 0.0f ? w : 0.0f) : 0.0f;
}

/* In place of rule 2 (record.h): does a point at this offset lie in front of the walls that stand near the
 * record? For records that have walls. */
static inline int sl_record_before_walls(const sl_record_terms *k, float x, float y, float z) {
    int before = 1;
    for (int i = 0; i < SL_RECORD_WALLS; i++) {
        const sl_record_wall *wall = &k->walls[i];
        before &= x * wall->normal.x + y * wall->normal.y + z * wall->normal.z >= wall->offset;
    }
    return before;
}

/* (8), with absolute gradients: E' = E + (n_k x n) . grad_r E + (p - p_k) . grad_t E, kept within what the
 * record can vouch for: not negative, not above E (1 + a) + |grad_r E| |n - n_k|. The triple product is n .
 * (grad_r E x n_k), the same with n - n_k for n, which keeps its digits for small angles and is there
 * already. */
static inline float sl_record_extrapolate(const sl_record_terms *k, int c, const sl_record_offsets *o,
                                          float turn) {
    const sl_vec3 q = k->rotational[c], t = k->translational[c];
    float value =
        k->e[c] + (o->mx * q.x + o->my * q.y + o->mz * q.z) + (o->x * t.x + o->y * t.y + o->z * t.z);
    float most = k->most[c] + k->rotational_length[c] * turn;
    value = value < most ? value : most;
    return value > 0.0f ? value : 0.0f;
}
