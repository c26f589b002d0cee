/* Quadtrees of triangles and of quadrilaterals. Corners are at whole numbers of a power of two in their
 * root's parameters (u, v), so halves are exact, and what two patches share has the same numbers in both.
 *
 *        2          A triangle is cut at the middles of its edges. Children 0, 1, 2 keep the corner of that
 *       / \         number; child 3 is the middle one, with its corners at the middles opposite to corners
 *      / 2 \        0, 1, 2. Corners of children are in the order of their parent's, so that each child is
 *     /_____\       its parent, halved and moved (child 3: turned by half a turn). A sliver's children are
 *    / \ 3 / \      no worse than itself.
 *   / 0 \ / 1 \
 *  0 ----*---- 1    A quadrilateral is cut at the middles of its edges and the centre; child i keeps corner
 *                   i. Corners go around counter-clockwise from (0, 0) in (u, v). */
#ifndef SL_PATCHES_DYADIC_H
#define SL_PATCHES_DYADIC_H

#include <stddef.h>
#include <stdint.h>

static inline uint16_t sl_dyadic_middle(uint16_t a, uint16_t b) { return (uint16_t)((a + b) / 2); }

/* Gives corners of a child; corners: 3 or 4, of the parent and of the child. */
void sl_dyadic_child(int corners, const uint16_t *u, const uint16_t *v, int child, uint16_t *child_u,
                     uint16_t *child_v);
/* Gives the weights of corners 1 and 2 of a triangle at a point of its root; of a quadrilateral how far it is
 * to corner 1, and to corner 3. */
static inline void sl_dyadic_local(int corners, const uint16_t *u, const uint16_t *v, double at_u,
                                   double at_v, double *a, double *b) {
    *a = (at_u - (double)u[0]) / ((double)u[1] - (double)u[0]);
    *b = (at_v - (double)v[0]) / ((double)v[corners - 1] - (double)v[0]);
}
/* Returns the child that holds such a point. */
static inline int sl_dyadic_child_at(int corners, double a, double b) {
    if (corners == 3) return a >= 0.5 ? 1 : b >= 0.5 ? 2 : a + b <= 0.5 ? 0 : 3;
    return a < 0.5 ? (b < 0.5 ? 0 : 3) : (b < 0.5 ? 1 : 2);
}

#endif
