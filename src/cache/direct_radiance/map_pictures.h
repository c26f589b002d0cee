/* Passes 2a to 2c: the faces' triangles, and what they are resolved to. */
#ifndef SL_CACHE_DIRECT_RADIANCE_MAP_PICTURES_H
#define SL_CACHE_DIRECT_RADIANCE_MAP_PICTURES_H

#include "cache/direct_radiance/map_faces.h"

typedef struct sl_map_drawing {
    const sl_scene *scene;
    const sl_raster *raster;
    const sl_radiance_map_settings *settings;
    const sl_radiance_map_options *options;
    const sl_planned_face *planned; /* of each face of the map */
    const uint32_t *stencil;        /* triangles that mirrors' faces' lights see */
    sl_radiance_map *map;           /* faces and planes are there; pictures are written */
    sl_counters *counters;
} sl_map_drawing;

/* sl_raster_ids() for any number of small views, some at a time: each view of a call takes a tile's memory. */
sl_status sl_map_triangles_draw(const sl_raster *raster, size_t count, const sl_view *views, const sl_target *targets, unsigned threads,
                                sl_counters *counters, sl_error *error);

/* Draws all faces and resolves their pictures in one pass with multiple render targets. No shadows are looked up: what the light
 * sees is lit. */
sl_status sl_map_pictures_draw(const sl_map_drawing *drawing, sl_error *error);

/* What a texel shows: light that arrives along `arrival` (unit, at y towards it) with irradiance `facing` on a plane that faces it. */
typedef struct sl_texel_light {
    sl_vec3 arrival;
    sl_rgb facing;
    float way;
} sl_texel_light;
/* Writes texel i of the pictures. */
void sl_map_texel_write(const sl_map_drawing *drawing, size_t i, const sl_surface *surface, const sl_texel_light *light);

/* The direction in which a ray of the face's picture left the light itself: of mirrors' faces before the mirror. */
sl_vec3 sl_map_face_departure(const sl_map_drawing *drawing, const sl_map_face *face, sl_vec3 direction);

#endif
