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

/* The same of a triangle and several ellipsoids that differ in radius alone: it is stretched until they are
 * spheres about the origin. */
typedef struct sl_stretched_edge {
    sl_vec3d from, along;
    /* the point nearest to the disc's centre: where (0 to 1 is on the edge), how far */
    double length_squared, nearest, foot_squared;
    /* twice the area of the triangle that the edge makes with that centre */
    double turn;
} sl_stretched_edge;
typedef struct sl_stretched_triangle {
    sl_vec3d corner[3];
    /* before stretching; 0 where there is none, or it is not finite */
    double area;
    double farthest_squared;
    /* the rest is there: wanted where the sphere's surface cuts the triangle */
    bool planar;
    sl_vec3d normal;
    double twice, height_squared;                 /* twice the area; the plane's distance */
    sl_stretched_edge edge[3];                    /* in the plane, about the foot of its normal */
    double border_squared;                        /* from there to the nearest point of an edge */
    bool around;                                  /* the foot is inside */
} sl_stretched_triangle;
sl_stretched_triangle sl_stretch_triangle(const sl_ellipsoid *e, sl_vec3d a, sl_vec3d b, sl_vec3d c);
double sl_stretched_inside(sl_stretched_triangle *triangle, double radius);

#endif
