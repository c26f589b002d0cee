/* The area over which gathered photons were strewn: disc, section of a tilted plane, or the scene's own
 * triangles clipped to the ellipsoid. */
#ifndef SL_CACHE_LIGHT_OCTREE_PHOTON_AREA_H
#define SL_CACHE_LIGHT_OCTREE_PHOTON_AREA_H

#include "base/vec.h"

typedef struct sl_ellipsoid {
    sl_vec3d centre;
    sl_vec3d normal; /* unit: its short axis; (0,0,0): a sphere */
    double flatness; /* f: half axes R, R, f R */
    double radius;   /* R */
} sl_ellipsoid;

double sl_disc_area(const sl_ellipsoid *e);
/* Of the plane with that unit normal at signed distance h from the centre; 0 where it misses. */
double sl_section_area(const sl_ellipsoid *e, sl_vec3d normal, double h);
/* Of a triangle's part inside: exact. */
double sl_triangle_in_ellipsoid(const sl_ellipsoid *e, sl_vec3d a, sl_vec3d b, sl_vec3d c);

#endif
