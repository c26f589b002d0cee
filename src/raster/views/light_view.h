/* View of an area light from a surface point: the off-axis pyramid that just holds the light's part above the
 * point's horizon. Rendering the scene into it samples the light's visibility with every pixel ("sub-frustum"
 * of multi-mesh caching with hardware sampling).
 *
 *                  ___ light ___
 *          right  /            /
 *             \  /____________/             It looks along the middle of the light's directions: any light,
 *              \      |      /  left        from any position.
 *               \     |     /
 *                \    |z   /
 *    horizon ------ point ------
 *
 * The pyramid is conservative: every point of the light that is above the horizon and turned to the point
 * lies inside all planes, also after the float roundings of the transform. */
#pragma once

#include "raster/raster.h"

/* Triangles, three corners each, counter-clockwise seen from where they shine. Up to SL_LIGHT_TRIANGLES are
 * held one by one; a light of more by the box around them, which is larger. Triangles that are not finite are
 * passed over. */
enum { SL_LIGHT_TRIANGLES = 16 };
typedef struct sl_light_shape {
    const sl_vec3 *corner;
    size_t triangles;
    bool two_sided;
} sl_light_shape;

typedef enum sl_light_sight {
    /* below the horizon, turned away or edge-on, no area: irradiance 0, nothing to render */
    SL_LIGHT_HIDDEN,
    SL_LIGHT_IN_VIEW,
    SL_LIGHT_TOO_WIDE /* the point touches or nearly touches it: no single pyramid is wide enough */
} sl_light_sight;

typedef struct sl_light_view {
    sl_view view;
    sl_frame frame;                 /* x right, y up, z the way it looks */
    float left, right, bottom, top; /* tangents of the sides at distance 1 along z */
    float nearest, farthest;        /* distances along z of the part that is in view */
} sl_light_view;

/* normal: of the surface at the eye; (0,0,0) for no horizon. near: clipped at w >= near, or nearer where the
 * light itself is. The tightest rectangle around the light is taken among those along its edges. */
sl_light_sight sl_view_light(sl_vec3 eye, sl_vec3 normal, const sl_light_shape *light, int width, int height,
                             float near, sl_light_view *out);
