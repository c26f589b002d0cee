/* The lights as Direct Radiance Mapping takes them: each one a point from which pictures are taken, with an intensity by direction.
 *
 *   point        I = Phi / 4 pi                                       (3)
 *   spot         I inside its cone, falling to 0 at the edge
 *   directional  an irradiance; its picture is a parallel projection of the scene's box
 *   area         I = Phi cos theta' / pi from its centre              (6), (9): a very distant area light
 *
 * Emissive triangles become area lights: those of one object and material that lie side by side in one plane are one light (a quad, a
 * panel); where there are more than SL_MAP_LIGHTS_MAX lights the weakest of a kind are merged, by position and normal, so that no flux is
 * lost. */
#ifndef SL_CACHE_DIRECT_RADIANCE_LIGHTS_H
#define SL_CACHE_DIRECT_RADIANCE_LIGHTS_H

#include "scene/scene.h"

enum { SL_MAP_LIGHTS_MAX = 64, SL_MAP_POINTS_MAX = 256 };

typedef enum sl_map_light_kind { SL_MAP_LIGHT_POINT, SL_MAP_LIGHT_SPOT, SL_MAP_LIGHT_DIRECTIONAL, SL_MAP_LIGHT_AREA } sl_map_light_kind;

typedef struct sl_map_light {
    sl_map_light_kind kind;
    sl_vec3 position;           /* area: the centroid, by flux, brought before all of its triangles where they do not lie in one plane;
                                   directional: unused */
    sl_vec3 direction;          /* unit. Spot: its axis; directional: the way light travels; area: the normal of the shining side */
    sl_rgb intensity;           /* W/sr. Point, spot; area: along the normal, L_e times area. Directional: W/m^2 */
    float cos_inner, cos_outer; /* spot */
    float area;                 /* area lights: > 0 */
    bool two_sided;             /* area lights: the back shines as the front does */
    size_t first, count;        /* area lights: their emitters, in sl_map_lights.emitter */
} sl_map_light;

/* A point of a light that receivers are lit from: its centre, or one of the n x n into which an area light is divided. */
typedef struct sl_map_light_point {
    uint32_t light;
    sl_vec3 position;
    sl_rgb intensity;           /* the light's share, as above */
} sl_map_light_point;

typedef struct sl_map_lights {
    size_t count;
    sl_map_light *light;        /* point-like lights in scene order, then area lights by their first emitter */
    size_t emitter_count;
    uint32_t *emitter;          /* indices of scene->emitters, light by light */
    uint32_t *light_of_triangle; /* the scene's triangles; SL_NO_INDEX where they do not shine. NULL without emitters */
    size_t point_count;
    sl_map_light_point *point;  /* light by light */
    sl_rgb flux;                /* of all of them but directional ones, in W */
} sl_map_lights;

/* subdivision: n >= 1, see sl_radiance_map_settings.emitter_samples. The points' intensities add up to the light's. */
sl_status sl_map_lights_find(const sl_scene *scene, int subdivision, sl_map_lights **lights, sl_error *error);
void sl_map_lights_destroy(sl_map_lights *lights);
/* Every light point as a light of its own, for maps: what the middle of a large light does not see another part of it may. NULL where
 * no light is divided, or the points are more than SL_MAP_POINTS_MAX. Its light_of_triangle is NULL. */
sl_status sl_map_lights_by_point(const sl_map_lights *lights, sl_map_lights **by_point, sl_error *error);

/* Radiant intensity (W/sr; directional: W/m^2) of a light in the unit direction away from it, as its map sees it. */
sl_rgb sl_map_light_intensity(const sl_map_light *light, sl_vec3 direction);
/* W; of a directional light its irradiance. */
sl_rgb sl_map_light_flux(const sl_map_light *light);

/* An area light does not see itself: how far its own triangles reach above the plane through `eye` on the shining side (back: on the
 * other one). What lies lower is left out of pictures taken from the eye. */
float sl_map_light_clearance(const sl_scene *scene, const sl_map_lights *lights, size_t light, sl_vec3 eye, bool back);

#endif
