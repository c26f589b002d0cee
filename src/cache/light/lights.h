/* The lights of a scene as samplers of single lights see them: each of one colour, so that what arrives from
 * it at a point is a number times that colour. An area light is the emissive triangles of one object that
 * have one radiance and lie in one plane. Where they do not lie in one plane, what hangs together by common
 * corners is one light, planar or (a ball) not: four bulbs are four lights. A hollow of few planes, as a room
 * whose walls shine, is one light a plane. */
#pragma once

#include "scene/scene.h"

typedef enum sl_source_kind { /* as sl_light_type; and emitters */
    SL_SOURCE_POINT,       /* F = E / I, 1/m^2 */
    SL_SOURCE_SPOT,        /* likewise */
    SL_SOURCE_DIRECTIONAL, /* E / E_0, in [0,1] */
    SL_SOURCE_AREA,        /* planar: share E / (pi L), in [0,1]; or a point of it */
    SL_SOURCE_SOLID        /* triangles in several planes: likewise */
} sl_source_kind;
_Static_assert((int)SL_SOURCE_POINT == (int)SL_LIGHT_POINT && (int)SL_SOURCE_SPOT == (int)SL_LIGHT_SPOT &&
                   (int)SL_SOURCE_DIRECTIONAL == (int)SL_LIGHT_DIRECTIONAL,
               "lights without extent are of the same kinds");

typedef struct sl_sampled_light {
    sl_source_kind kind;
    sl_rgb colour;              /* that F multiplies to irradiance: pi L times `opaque`, I, or E_0 */
    sl_rgb radiance;            /* L of area lights where no mask takes it away; 0 of others */
    float opaque;               /* area lights: the share of them that alpha masks leave, all over alike */
    bool two_sided;
    size_t triangles;           /* area lights */
    const sl_vec3 *corner;      /* three a triangle, counter-clockwise seen from where they shine */
    const uint32_t *triangle;   /* their numbers in the scene, ascending */
    float extent;               /* largest distance of a corner from `position` */
    sl_vec3 normal;             /* planar ones: unit, of the shining side */
    sl_vec3 position;           /* of points and spots; the centroid of area lights */
    sl_vec3 direction;          /* of spots and directional lights: unit, the way the light travels */
    float cos_inner, cos_outer; /* spots */
    uint32_t object;            /* area lights: whose triangles they are */
} sl_sampled_light;

typedef struct sl_sampled_lights {
    size_t count;
    sl_sampled_light *light;    /* area lights in triangle order, then the scene's lights in theirs */
    uint32_t *light_of_triangle; /* by scene triangle: of emitters; else SL_NO_INDEX */
    sl_vec3 *corners;           /* behind light[i].corner */
    uint32_t *triangles;        /* behind light[i].triangle */
} sl_sampled_lights;

/* Returns a corner of an area light, and of its triangle t the normal, twice its area long. */
static inline sl_vec3d sl_light_corner(const sl_sampled_light *light, size_t k) {
    return sl_to_double(light->corner[k]);
}
static inline sl_vec3d sl_light_cross(const sl_sampled_light *light, size_t t) {
    const sl_vec3d a = sl_light_corner(light, 3 * t), b = sl_light_corner(light, 3 * t + 1);
    return sl_crossd(sl_subd(b, a), sl_subd(sl_light_corner(light, 3 * t + 2), a));
}

static inline bool sl_light_has_extent(const sl_sampled_light *light) {
    return light->kind == SL_SOURCE_AREA || light->kind == SL_SOURCE_SOLID;
}

sl_status sl_sampled_lights_find(const sl_scene *scene, sl_sampled_lights **lights, sl_error *error);
void sl_sampled_lights_destroy(sl_sampled_lights *lights);

/* ---- points spread over an area light (light_surface.c) ---- */

/* A parallelogram takes two numbers as they are, so that points are as even on it as in the unit square; of
 * other lights the first number chooses the triangle by area, and what is left of it serves for the place. */
typedef struct sl_light_surface {
    double area;
    double *area_before;        /* by triangle: the sum of the areas up to and with it */
    bool parallelogram;         /* of two triangles: corner 0 of the first, its edges e1, e2 */
    sl_vec3d corner, e1, e2;
} sl_light_surface;
sl_status sl_light_surface_make(const sl_sampled_light *light, sl_light_surface *surface, sl_error *error);
void sl_light_surface_release(sl_light_surface *surface);
/* A point of the triangles, neighbours to neighbours; which triangle it is on, and the weights there of its
 * corners 1 and 2. */
sl_vec3d sl_light_surface_point(const sl_sampled_light *light, const sl_light_surface *surface,
                                const double u[2], size_t *triangle, double weight[2]);
