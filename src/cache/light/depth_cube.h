/* Pictures that are taken from a light: the directions around it, and depth cubes, which tell what it sees. A
 * receiver is lit if its reciprocal planar depth is at least the stored one, less the most by which two
 * points of the receiver's own plane in one texel can differ (depth_cube_kernels.c). */
#pragma once

#include "cache/light/light_kernels.h"
#include "raster/raster.h"

/* ---- the directions around a light, cut into six sides ----
 *
 *            0           side 0 looks along the light's own direction (its axis, its normal), 1 to 4 to the
 *          __|__         sides (+x -x +y -y of its frame), 5 back. The pictures of 1 to 4 have the light's
 *       2 -|     |- 1    direction as their up, so that their upper halves are a hemicube's.
 *            5
 */
enum { SL_LIGHT_SIDES = 6, SL_LIGHT_AHEAD = 0, SL_LIGHT_BACK = 5 };

/* z along the light's direction; of a point light the world's axes, turned so that z looks down (0, -1, 0).
 */
sl_frame sl_light_frame(const sl_light_source *light);
/* x right, y up, z the way the side looks. */
sl_frame sl_light_side(const sl_frame *light, int side);
/* False where the whole side, 90 degrees each way, is dark. */
bool sl_light_shines_on(const sl_light_source *light, int side);

/* A pyramid from the light, or from its mirror image, on the light's front or back. */
typedef struct sl_pyramid_picture {
    sl_frame frame;
    double left, right, bottom, top;
    int width, height;
    bool back;
} sl_pyramid_picture;
sl_view sl_pyramid_view(const sl_scene *scene, const sl_light_source *light,
                              const sl_pyramid_picture *picture);

/* The scene's box as a directional light sees it. */
typedef struct sl_parallel_picture {
    sl_vec3 centre; /* of the box */
    sl_frame frame; /* z the way light travels */
    float extent_x, extent_y, extent_z; /* half extents */
} sl_parallel_picture;
sl_parallel_picture sl_parallel_picture_of(const sl_scene *scene, sl_vec3 direction);
sl_view sl_parallel_view(const sl_parallel_picture *picture, int width, int height);

/* ---- depth cubes ---- */

/* The depth pictures around a light. A cube's hold 1/z, z along the picture's own axis, and have a border of
 * one texel beyond 90 degrees, so that a filter never leaves its picture; a directional light's one holds 1 -
 * d, d in [0,1] linear in depth. So in both larger is nearer, 0 is empty, and a plane is a linear function. A
 * spot whose cone fits in the picture ahead has that one alone, no wider than the cone. */
struct sl_depth_cube {
    /* first a row of zeros, to which pictures without anything in them lead; then the pictures */
    float *depth;
    size_t texels;                   /* of all that */
    int32_t start[SL_LIGHT_SIDES];   /* where in depth each side's picture begins; 0: it has none */
    /* all bits of a place in the picture, or none where there is no picture */
    int32_t mask[SL_LIGHT_SIDES];
    int size;
    bool directional;
    /* of a cube's pictures: half their width at distance 1, without the border: 1, or a spot's own */
    float tangent;
    sl_vec3 eye;                     /* directional: the box's centre */
    sl_frame frame;                  /* of the light */
    float extent_x, extent_y, extent_z; /* directional: half extents */
    float rounding;                  /* by how much a receiver's position may be rounded */
};

/* Texels before the first picture. */
static inline size_t sl_depth_zeros(int size) { return ((size_t)size + 2 + 15) / 16 * 16; }

/* Pictures that no receiver can need (behind a one-sided area light, outside a spot's cone, without geometry)
 * are not drawn, and counted as skipped; of a dark light none is, and all is lit. */
sl_status sl_depth_cube_draw(const sl_scene *scene, const sl_raster *raster, const sl_light_source *light,
                             bool dark, int size, unsigned threads, sl_depth_cube *cube,
                             sl_counters *counters, sl_error *error);
void sl_depth_cube_release(sl_depth_cube *cube);
static inline size_t sl_depth_cube_bytes(const sl_depth_cube *cube) {
    return sizeof *cube + cube->texels * sizeof *cube->depth;
}
