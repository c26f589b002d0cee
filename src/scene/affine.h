/* Affine maps in double: node transforms, the turn from z up to y up, keyframes. */
#pragma once

#include "base/vec.h"

/* p' = m[:, 0..2] p + m[:, 3], rows first. */
typedef struct sl_affine {
    double m[3][4];
} sl_affine;

static inline sl_affine sl_affine_identity(void) {
    return (sl_affine){{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
}

static inline bool sl_affine_is_identity(const sl_affine *a) {
    const sl_affine same = sl_affine_identity();
    bool is = true;
    for (int i = 0; i < 12; i++) is &= a->m[i / 4][i % 4] == same.m[i / 4][i % 4];
    return is;
}

/* World z up to world y up: (x, y, z) becomes (x, z, -y). */
static inline sl_affine sl_affine_z_up(void) {
    return (sl_affine){{{1, 0, 0, 0}, {0, 0, 1, 0}, {0, -1, 0, 0}}};
}

/* First b, then a. */
static inline sl_affine sl_affine_after(const sl_affine *a, const sl_affine *b) {
    sl_affine product;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 4; j++) {
            product.m[i][j] = a->m[i][0] * b->m[0][j] + a->m[i][1] * b->m[1][j] + a->m[i][2] * b->m[2][j] +
                              (j == 3 ? a->m[i][3] : 0.0);
        }
    }
    return product;
}

static inline sl_vec3d sl_affine_vector(const sl_affine *a, sl_vec3d v) {
    return sl_v3d(a->m[0][0] * v.x + a->m[0][1] * v.y + a->m[0][2] * v.z,
                  a->m[1][0] * v.x + a->m[1][1] * v.y + a->m[1][2] * v.z,
                  a->m[2][0] * v.x + a->m[2][1] * v.y + a->m[2][2] * v.z);
}

static inline sl_vec3d sl_affine_point(const sl_affine *a, sl_vec3d p) {
    sl_vec3d v = sl_affine_vector(a, p);
    return sl_v3d(v.x + a->m[0][3], v.y + a->m[1][3], v.z + a->m[2][3]);
}

static inline double sl_affine_determinant(const sl_affine *a) {
    const double(*m)[4] = a->m;
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
           m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

/* Returns what maps normals: the inverse transpose but for a positive factor, made of cofactors so that it
 * needs no division. */
static inline sl_affine sl_affine_normal_map(const sl_affine *a) {
    double sign = sl_affine_determinant(a) < 0.0 ? -1.0 : 1.0;
    sl_affine map = {{{0}}};
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
            map.m[i][j] = sign * (a->m[i1][j1] * a->m[i2][j2] - a->m[i1][j2] * a->m[i2][j1]);
        }
    }
    return map;
}

/* Of a map whose determinant is not 0: the normal map, transposed, but for the determinant's size. */
static inline sl_affine sl_affine_inverse(const sl_affine *a) {
    const sl_affine cofactors = sl_affine_normal_map(a);
    const double size = fabs(sl_affine_determinant(a));
    sl_affine b = {{{0}}};
    for (int i = 0; i < 9; i++) b.m[i / 3][i % 3] = cofactors.m[i % 3][i / 3] / size;
    const sl_vec3d back = sl_affine_vector(&b, sl_v3d(a->m[0][3], a->m[1][3], a->m[2][3]));
    b.m[0][3] = -back.x, b.m[1][3] = -back.y, b.m[2][3] = -back.z;
    return b;
}

/* A direction scaled to length 1 in double before it is rounded; zero where it has none. */
static inline sl_vec3 sl_affine_unit(const sl_affine *a, sl_vec3 v) {
    sl_vec3d d = sl_affine_vector(a, sl_to_double(v));
    double length = sl_lengthd(d);
    return length > 0.0 && isfinite(length) ? sl_to_float(sl_scaled(d, 1.0 / length)) : sl_v3(0, 0, 0);
}

/* The unit vector along one, or `fallback` where it has no direction; one that has unit length but for
 * rounding stays as it is: normalising it again could change its last bits. */
static inline sl_vec3 sl_unit_or(sl_vec3 a, sl_vec3 fallback) {
    const sl_vec3d d = sl_to_double(a);
    return fabs(sl_dotd(d, d) - 1.0) < 0x1p-22 ? a : sl_normalize_or(a, fallback);
}
