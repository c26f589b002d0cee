/* Corners of children in quadtrees. */
#include "cache/patches/dyadic.h"

/* Each corner of a child is the middle of two corners of its parent, or one of them (then both are the same).
 */
static const uint8_t triangle_child[4][3][2] = {
    {{0, 0}, {0, 1}, {2, 0}}, {{0, 1}, {1, 1}, {1, 2}}, {{2, 0}, {1, 2}, {2, 2}}, {{1, 2}, {2, 0}, {0, 1}}};
static const uint8_t quad_child[4][4][2] = {{{0, 0}, {0, 1}, {0, 2}, {3, 0}},
                                            {{0, 1}, {1, 1}, {1, 2}, {0, 2}},
                                            {{0, 2}, {1, 2}, {2, 2}, {2, 3}},
                                            {{3, 0}, {0, 2}, {2, 3}, {3, 3}}};

void sl_dyadic_child(int corners, const uint16_t *u, const uint16_t *v, int child, uint16_t *child_u,
                     uint16_t *child_v) {
    for (int c = 0; c < corners; c++) {
        const uint8_t *of = corners == 3 ? triangle_child[child][c] : quad_child[child][c];
        child_u[c] = sl_dyadic_middle(u[of[0]], u[of[1]]);
        child_v[c] = sl_dyadic_middle(v[of[0]], v[of[1]]);
    }
}
