/* Exact cell integrals over the hemisphere, in double, by the project's own elementary functions. */
#ifndef SL_CACHE_HEMISPHERE_TABLES_H
#define SL_CACHE_HEMISPHERE_TABLES_H

#include "base/vec.h"

/* Any cell bounded by great circles, corners a_i counter-clockwise seen from outside, of any length. Integral
 * of omega d omega, of which the z component is the cosine weight (Lambert's formula), theta_i being the
 * angle between a_i and a_i+1: V = sum over edges of theta_i (a_i x a_i+1) / (2 |a_i x a_i+1|). */
sl_vec3d sl_cell_vector(const sl_vec3d *corners, int count);
/* Returns how a wall between two cells moves. The wall is the arc from direction a to direction b; it is made
 * by surfaces at depth 1 along the axis in whose units a and b are given. The vector g: displacing the
 * receiver by delta gives the cosine weight g . delta to the cell on the right of a -> b (for one who looks
 * along +z, x right and y up), taken from the cell on its left. With e the unit vector from a to b and d = a
 * + s e the points between them: g = integral of (e x d) d_z / |d|^4 ds. */
sl_vec3d sl_wall_vector(sl_vec3d a, sl_vec3d b);

/* A symmetric 2 x 2 matrix of second derivatives in the local tangent plane: (xx, xy, yy). */
typedef struct sl_curvature {
    double xx, xy, yy;
} sl_curvature;
/* The next order of the same motion: displacing the receiver by a tangential delta gives the cell on the
 * right g . delta + delta . K delta / 2, where the wall's ends move as points of the world at depth 1. */
sl_curvature sl_wall_curvature(sl_vec3d a, sl_vec3d b);

#endif
