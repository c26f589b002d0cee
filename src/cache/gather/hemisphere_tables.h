/* Exact cell integrals over the hemisphere, in double, by the project's own elementary functions (cache-math section 2). */
#ifndef SL_CACHE_HEMISPHERE_TABLES_H
#define SL_CACHE_HEMISPHERE_TABLES_H

#include "base/vec.h"

/* Closed forms, cell [u0,u1] x [v0,v1] of the plane at unit distance. */
double sl_plane_solid_angle(double u0, double u1, double v0, double v1);   /* box A */
double sl_plane_cosine_weight(double u0, double u1, double v0, double v1); /* box C */
sl_vec3d sl_plane_vector(double u0, double u1, double v0, double v1);      /* integral of omega d omega: (box X, box X^T, box C) */
double sl_plane_wall(double c, double v0, double v1);                      /* I(c; v0, v1), section 3.3 */
/* Half side face of the hemicube, u sideways, z upwards. */
double sl_side_cosine_weight(double u0, double u1, double z0, double z1);  /* box S */
/* Radial border extension of an outer edge on side v = t. */
double sl_border_solid_angle(double t, double u0, double u1);
double sl_border_cosine_weight(double t, double u0, double u1);
/* Any cell bounded by great circles, corners counter-clockwise seen from outside (section 2.1). */
sl_vec3d sl_cell_vector(const sl_vec3d *corners, int count);
double sl_cell_solid_angle(const sl_vec3d *corners, int count);
/* Sum of omega d omega over the border extension of the outer edge (u0..u1, t): the cell from the edge down to the horizon. */
sl_vec3d sl_border_vector(double t, double u0, double u1);
/* How a wall between two cells moves (section 3.2). The wall is the arc from direction a to direction b; it is made by surfaces
 * at depth 1 along the axis in whose units a and b are given. The vector g: displacing the receiver by delta gives the
 * cosine weight g . delta to the cell on the right of a -> b (for one who looks along +z, x right and y up), taken from the
 * cell on its left. */
sl_vec3d sl_wall_vector(sl_vec3d a, sl_vec3d b);

/* A symmetric 2 x 2 matrix of second derivatives in the local tangent plane: (xx, xy, yy). */
typedef struct sl_curvature {
    double xx, xy, yy;
} sl_curvature;
/* The next order of the same motion (section 3.5): displacing the receiver by a tangential delta gives the cell on the right
 * g . delta + delta . K delta / 2, where the wall's ends move as points of the world at depth 1. */
sl_curvature sl_wall_curvature(sl_vec3d a, sl_vec3d b);
/* Where four walls of different depths meet, none of their ends moves as its own wall does, but along its wall with the walls that
 * cross it. What that adds to delta . H delta / 2 is this form, times a factor made of the walls' steps and nearnesses
 * (gather_kernels.c). direction: of the corner; right, left, up, down: of the walls' other ends; all in units of depth. */
sl_curvature sl_vertex_curvature(sl_vec3d direction, sl_vec3d right, sl_vec3d left, sl_vec3d up, sl_vec3d down);

/* ---- light from polygons (section 8.1) ---- */

/* Irradiance at p with unit normal n from a one-sided Lambertian polygon of radiance 1 (vertices counter-clockwise seen from its
 * shining side), clipped to the horizon, and its gradient with respect to p; gradient may be NULL. count <= 16. */
double sl_polygon_irradiance(sl_vec3d p, sl_vec3d n, const sl_vec3d *vertices, int count, sl_vec3d *gradient);

#endif
