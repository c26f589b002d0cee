/* A triangle as it is seen from a point: on the unit sphere around that. */
#ifndef SL_CACHE_LIGHT_SPHERICAL_TRIANGLE_H
#define SL_CACHE_LIGHT_SPHERICAL_TRIANGLE_H

#include "base/vec.h"

typedef struct sl_spherical_triangle {
    sl_vec3d a, b, c;            /* towards the corners, unit */
    double solid_angle;
    double cos_c;                /* of the side between a and b */
    double alpha, sine, cosine;  /* the angle at a, and its */
} sl_spherical_triangle;

/* False where it spans less than a millionth of a steradian: it is seen edge-on or is very small. */
bool sl_spherical_triangle_make(const sl_vec3 corner[3], sl_vec3 p, sl_spherical_triangle *triangle);
/* A direction in it, uniform in solid angle for u1, u2 uniform in [0,1). u2 = 0 is corner b, whatever u1; u2
 * = 1 goes from a to c. */
sl_vec3d sl_spherical_triangle_point(const sl_spherical_triangle *triangle, double u1, double u2);

/* The part of a triangle above the horizon of p, whose normal is n: up to two spherical triangles. */
typedef struct sl_seen_triangle {
    int parts;                   /* 0: nothing, or too little for angles */
    sl_spherical_triangle part[2];
    double solid_angle;          /* of all parts */
} sl_seen_triangle;
void sl_seen_triangle_make(const sl_vec3 corner[3], sl_vec3 p, sl_vec3 n, sl_seen_triangle *seen);
/* The part that u1 in [0,1) chooses by solid angle; u1 is left stretched to [0,1) again. */
int sl_seen_triangle_part(const sl_seen_triangle *seen, double *u1);

#endif
