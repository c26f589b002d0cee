/* The lights as Direct Radiance Mapping takes them: points from which pictures are taken, each with an
 * intensity by direction.
 *
 *   point        I = Phi / 4 pi                                       (3)
 *   spot         I inside its cone, falling to 0 at the edge
 *   directional  an irradiance; its picture is a parallel projection of the scene's box
 *   area         I = Phi cos theta' / pi                              (6), (9): a very distant area light
 *
 * What a light of the scene is, and which triangles are one area light, is told by cache/light/lights.h. A
 * planar area light is n x n points, a solid one (a bulb) 24 n x n points of its surface; fewer where lamps
 * are many. */
#pragma once

#include "cache/light/depth_cube.h"
#include "cache/light/lights.h"

enum { SL_MAP_LIGHTS_MAX = 256 };

typedef struct sl_map_light {
    /* colour: W/sr. Point, spot; area: along the normal, L_e times area, its size being in `area`.
     * Directional: W/m^2. Pictures of an area light do not see its lamp's own triangles. */
    sl_light_source source;
    float area;                 /* area lights: of the part that the point stands for, > 0 */
    uint32_t lamp;              /* in sl_map_lights.lamps */
    uint32_t siblings;          /* points of the same lamp, this one included; 0 counts as 1 */
} sl_map_light;

typedef struct sl_map_lights {
    size_t count;               /* at most SL_MAP_LIGHTS_MAX */
    sl_map_light *light;        /* lamp by lamp */
    sl_depth_cube *cube;        /* of each light; NULL: nothing throws shadows */
    sl_sampled_lights *lamps;   /* those of the scene */
} sl_map_lights;

/* subdivision: n >= 1, see sl_radiance_map_settings.emitter_samples; less where points would be more than
 * SL_MAP_LIGHTS_MAX. Of more lamps than that the strongest shine for all. */
sl_status sl_map_lights_find(const sl_scene *scene, int subdivision, sl_map_lights **lights, sl_error *error);
void sl_map_lights_destroy(sl_map_lights *lights);
size_t sl_map_lights_bytes(const sl_map_lights *lights);

/* Radiant intensity (W/sr; directional: W/m^2) of a light in the unit direction away from it, as its map sees
 * it. */
sl_rgb sl_map_light_intensity(const sl_map_light *light, sl_vec3 direction);
/* W; of a directional light its irradiance. */
sl_rgb sl_map_light_flux(const sl_map_light *light);

/* ---- pass 1: a depth cube around every light (direct.c) ---- */

/* size: texels a side of a face, less where an area light is divided (its n x n cubes together have n times
 * the texels of one) or lights are so many that their cubes would take more than 128 MiB. */
sl_status sl_map_lights_draw_cubes(sl_map_lights *lights, const sl_scene *scene, const sl_raster *raster,
                                   int size, unsigned threads, sl_counters *counters, sl_error *error);
