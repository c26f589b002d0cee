/* A point's way down a quadtree of triangles, from its barycentric weights. A child that keeps corner i holds the points whose weight of it
 * is above one half, and all their weights double there, i's less one. Child 3, turned by half a turn, holds the rest: weights w become
 * 1 - 2 w. In whole numbers nothing is rounded on the way. */
#include "cache/multi_mesh/path_kernels.h"
#include "cache/multi_mesh/pixels.h"

enum { ONE = 1 << 24 };

/* In [0, 1], 0 for NaN. */
static inline int32_t whole(float weight) {
    float clamped = weight > 0.0f ? weight : 0.0f;
    return (int32_t)((clamped < 1.0f ? clamped : 1.0f) * (float)ONE);
}

void SL_KERNEL(sl_paths)(size_t count, const float *restrict w1, const float *restrict w2, uint32_t *restrict path) {
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        int32_t b = whole(w1[i]), c = whole(w2[i]), rest = ONE - b - c, a = rest > 0 ? rest : 0;
        uint32_t way = 0;
        for (int level = 0; level < SL_PATH_LEVELS; level++) {
            int32_t a2 = 2 * a, b2 = 2 * b, c2 = 2 * c;
            int32_t in_1 = -(b2 > ONE), in_2 = -(c2 > ONE) & ~in_1, in_0 = -(a2 > ONE) & ~(in_1 | in_2), in_3 = ~(in_0 | in_1 | in_2);
            /* (x ^ in_3) - in_3 is x, or -x in child 3. */
            a = ((a2 ^ in_3) - in_3) + (ONE & in_3) - (ONE & in_0);
            b = ((b2 ^ in_3) - in_3) + (ONE & in_3) - (ONE & in_1);
            c = ((c2 ^ in_3) - in_3) + (ONE & in_3) - (ONE & in_2);
            way = way << 2 | ((uint32_t)in_1 & 1u) | ((uint32_t)in_2 & 2u) | ((uint32_t)in_3 & 3u);
        }
        path[i] = way;
    }
}
