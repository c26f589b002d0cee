/* A triangle as it is seen from a point: on the unit sphere around that. */
#ifndef SL_CACHE_LIGHT_SPHERICAL_TRIANGLE_H
#define SL_CACHE_LIGHT_SPHERICAL_TRIANGLE_H

#include "base/vec.h"

/* A direction from p to the triangle, uniform in its solid angle for u1, u2 uniform in [0,1). False where that is below a millionth of a
 * steradian: the triangle is seen edge-on or is very small. */
bool sl_spherical_point(const sl_vec3 corner[3], sl_vec3 p, double u1, double u2, sl_vec3d *direction, double *solid_angle);

#endif
