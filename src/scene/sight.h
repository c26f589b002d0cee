/* A few dozen rays against every triangle, one after another: enough to tell what a point sees before there
 * is any hierarchy. Masks are not looked at. */
#pragma once

#include "scene/scene.h"

enum { SL_SIGHT_RAYS = 64 };

/* Rays from one point, and what they hit. */
typedef struct sl_sight {
    sl_vec3 origin;
    float x[SL_SIGHT_RAYS], y[SL_SIGHT_RAYS], z[SL_SIGHT_RAYS]; /* directions */
    float distance[SL_SIGHT_RAYS]; /* to the nearest triangle, in lengths of the direction; infinite: there is
                                      none */
    float facing[SL_SIGHT_RAYS];   /* above 0: its front is seen */
    uint32_t triangle[SL_SIGHT_RAYS]; /* which, if any */
} sl_sight;

void sl_sight_set(sl_sight *sight, int ray, sl_vec3 direction);
static inline sl_vec3 sl_sight_direction(const sl_sight *s, int ray) {
    return sl_v3(s->x[ray], s->y[ray], s->z[ray]);
}

void sl_sight_cast(sl_sight *sight, const sl_scene *scene);
/* Casts rays spread evenly over the sphere; over the picture of a camera, a grid of 8 x 8; around a point at
 * its height. */
void sl_sight_sphere(sl_sight *sight, const sl_scene *scene, sl_vec3 origin);
void sl_sight_view(sl_sight *sight, const sl_scene *scene, const sl_camera *camera);
void sl_sight_horizon(sl_sight *sight, const sl_scene *scene, sl_vec3 origin);

/* Of the rays that were cast: how many hit something, and how many of these a front. */
typedef struct sl_sight_count {
    int hit, front;
    int materials;        /* different ones among these */
    double mean_distance; /* of all that hit */
} sl_sight_count;
sl_sight_count sl_sight_counted(const sl_sight *sight, const sl_scene *scene);
