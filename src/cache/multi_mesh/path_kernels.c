/* A point's way down a quadtree of triangles, from its barycentric weights. A child that keeps corner i holds
 * the points whose weight of it is above one half, and all their weights double there, i's less one. Child 3,
 * turned by half a turn, holds the rest: weights w become 1 - 2 w. In whole numbers nothing is rounded on the
 * way. */
#include "cache/multi_mesh/path_kernels.h"
#include "cache/multi_mesh/pixels.h"

enum { ONE = 1 << 24, BLOCK = 256 };

/* In [0, 1], 0 for NaN. */
static inline int32_t whole(float weight) {
    float clamped = weight > 0.0f ? weight : 0.0f;
    return (int32_t)((clamped < 1.0f ? clamped : 1.0f) * (float)ONE);
}

/* One level down; (x ^ in_3) - in_3 is x, or -x in child 3. */
static void step(size_t count, int32_t *restrict wa, int32_t *restrict wb, int32_t *restrict wc,
                 uint32_t *restrict path) {
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        int32_t a = 2 * wa[i], b = 2 * wb[i], c = 2 * wc[i];
        int32_t in_1 = -(b > ONE), in_2 = -(c > ONE) & ~in_1, in_0 = -(a > ONE) & ~(in_1 | in_2),
                in_3 = ~(in_0 | in_1 | in_2);
        int32_t one_in_3 = ONE & in_3;
        wa[i] = ((a ^ in_3) - in_3) + one_in_3 - (ONE & in_0);
        wb[i] = ((b ^ in_3) - in_3) + one_in_3 - (ONE & in_1);
        wc[i] = ((c ^ in_3) - in_3) + one_in_3 - (ONE & in_2);
        path[i] = path[i] << 2 | ((uint32_t)in_1 & 1u) | ((uint32_t)in_2 & 2u) | ((uint32_t)in_3 & 3u);
    }
}

void SL_KERNEL(sl_paths)(size_t count, const float *restrict w1, const float *restrict w2,
                         uint32_t *restrict path) {
    int32_t a[BLOCK], b[BLOCK], c[BLOCK];
    for (size_t at = 0; at < count; at += BLOCK) {
        size_t n = count - at < BLOCK ? count - at : BLOCK;
#pragma omp simd
        for (size_t i = 0; i < n; i++) {
            b[i] = whole(w1[at + i]);
            c[i] = whole(w2[at + i]);
            int32_t rest = ONE - b[i] - c[i];
            a[i] = rest > 0 ? rest : 0;
            path[at + i] = 0;
        }
        for (int level = 0; level < SL_PATH_LEVELS; level++) step(n, a, b, c, path + at);
    }
}
