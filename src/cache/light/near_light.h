/* An emitter seen from a point that is near to it. Where its nearest part is much nearer than the rest,
 * points spread evenly over its area tell little of what arrives: few of them fall on that part, and those
 * outweigh all others. So directions are chosen by solid angle (Arvo 1995), of its part above the horizon,
 * with nearly the density of the cosine. */
#ifndef SL_CACHE_LIGHT_NEAR_LIGHT_H
#define SL_CACHE_LIGHT_NEAR_LIGHT_H

#include "cache/light/light_kernels.h"
#include "cache/light/spherical_triangle.h"

typedef struct sl_near_light {
    sl_seen_triangle seen;   /* without parts: too little of it for angles */
    double cosine[2][3];     /* above the point, towards the corners of each part */
    sl_vec3d out;            /* the emitter's normal */
    double height;           /* of the point above the emitter */
} sl_near_light;

/* Returns whether a point is nearer to an emitter's box than half its extent. */
bool sl_light_is_near(const sl_polygon_light *light, sl_vec3 p);
void sl_near_light_make(const sl_polygon_light *light, sl_vec3 p, sl_vec3 n, sl_near_light *near);
/* A unit direction, its density times the solid angle of all that is seen, and where it meets the emitter;
 * distance 0: it does not. */
sl_vec3d sl_near_light_draw(const sl_near_light *near, double u1, double u2, double *density,
                            double *distance);

#endif
