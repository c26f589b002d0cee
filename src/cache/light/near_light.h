/* An emitter seen from a point that is near to it. Where its nearest part is much nearer than the rest,
 * points spread evenly over its area tell little of what arrives: few of them fall on that part, and those
 * outweigh all others. So directions are chosen by solid angle (Arvo 1995), of its part above the horizon,
 * with nearly the density of the cosine. */
#pragma once

#include "cache/light/light_kernels.h"

/* ---- a triangle as it is seen from a point: on the unit sphere around that ---- */

typedef struct sl_spherical_triangle {
    sl_vec3d a, b, c;            /* towards the corners, unit */
    double solid_angle;
    double cos_c;                /* of the side between a and b */
    double alpha, sine, cosine;  /* the angle at a, and its */
} sl_spherical_triangle;

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

/* ---- */

typedef struct sl_near_light {
    sl_seen_triangle seen;   /* without parts: too little of it for angles */
    double cosine[2][3];     /* above the point, towards the corners of each part */
    sl_vec3d out;            /* the emitter's normal */
    double height;           /* of the point above the emitter */
} sl_near_light;

/* Returns whether a point is nearer to an emitter's box than half the distance of its farthest corner from
 * its middle. */
static inline bool sl_light_is_near(const sl_polygon_light *light, sl_vec3 p) {
    const sl_vec3 outside = sl_outside_box(light->bounds, p);
    return sl_dot(outside, outside) < 0.25f * light->extent_squared;
}
void sl_near_light_make(const sl_polygon_light *light, sl_vec3 p, sl_vec3 n, sl_near_light *near);
/* A unit direction, its density times the solid angle of all that is seen, and where it meets the emitter;
 * distance 0: it does not. */
sl_vec3d sl_near_light_draw(const sl_near_light *near, double u1, double u2, double *density,
                            double *distance);
