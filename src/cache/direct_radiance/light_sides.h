/* The directions around a light, cut into six sides; shadow cubes and radiance maps look along the same ones.
 *
 *            0           side 0 looks along the light's own direction (its axis, its normal), 1 to 4 to the sides
 *          __|__         (+x -x +y -y of its frame), 5 back. The pictures of 1 to 4 have the light's direction as
 *      2 -|     |- 1     their up, so that their upper halves are a hemicube's.
 *            5
 *
 * An area light does not see its own triangles: what lies lower than they reach is cut away by the view's near plane. */
#ifndef SL_CACHE_DIRECT_RADIANCE_LIGHT_SIDES_H
#define SL_CACHE_DIRECT_RADIANCE_LIGHT_SIDES_H

#include "cache/direct_radiance/lights.h"
#include "raster/raster.h"

enum { SL_LIGHT_SIDES = 6, SL_LIGHT_AHEAD = 0, SL_LIGHT_BACK = 5 };

/* z along the light's direction; of a point light the world's axes, turned so that z looks down (0, -1, 0). */
sl_frame sl_light_frame(const sl_map_light *light);
/* x right, y up, z the way the side looks. */
sl_frame sl_light_side(const sl_frame *light, int side);
/* False where the whole side, 90 degrees each way, is dark. */
bool sl_light_shines_on(const sl_map_light *light, int side);

/* A pyramid from `eye`, on the light's front or back; near: of lights without area. clearance: of that side, of the light's triangles. */
typedef struct sl_light_picture {
    sl_vec3 eye;
    sl_frame frame;
    double left, right, bottom, top;
    int width, height;
    bool back;
    float clearance;
} sl_light_picture;
sl_view sl_light_picture_view(const sl_scene *scene, const sl_map_light *light, const sl_light_picture *picture);

/* The scene's box as a directional light sees it. */
typedef struct sl_parallel_picture {
    sl_vec3 centre; /* of the box */
    sl_frame frame; /* z the way light travels */
    float reach_x, reach_y, reach_z; /* half extents */
} sl_parallel_picture;
sl_parallel_picture sl_parallel_picture_of(const sl_scene *scene, const sl_map_light *light);
sl_view sl_parallel_view(const sl_parallel_picture *picture, int width, int height);

#endif
