/* The direct radiance map, passes 2a to 2c: pictures taken from the lights, of what they light directly. They tell, texel by texel, where
 * light is reflected (positions), how much (radiance, or where materials are not Lambertian their true colour) and in which
 * directions (normals).
 *
 *      light
 *       /|\          a face: w x w texels, or w x ceil(w/2) for the sides of a hemicube, cut into m x m blocks; each block's
 *      / | \         middle is a sample, and each sample stands for the block's solid angle
 *     +--+--+
 *     |  y  |  n_y   Psi = rho I dOmega / pi is finite wherever y lies and however the surface is tilted there
 *     +-----+
 *
 * Planar mirrors near the light show it again: the light's mirror image takes pictures of its own, cut to the mirror; y is real, and
 * b = |y - L'| is the whole way. */
#ifndef SL_CACHE_DIRECT_RADIANCE_RADIANCE_MAP_H
#define SL_CACHE_DIRECT_RADIANCE_RADIANCE_MAP_H

#include "cache/frame/settings.h"
#include "cache/direct_radiance/lights.h"
#include "raster/raster.h"
#include "raster/views/mirror.h"

typedef struct sl_map_face {
    uint32_t light;
    uint32_t mirror;                 /* the light's image in that planar mirror; or SL_NO_INDEX */
    sl_vec3 eye;                     /* the light, or its image L' */
    sl_rgb reflectance;              /* of the mirror; 1 without */
    sl_view view;
    sl_frame frame;                  /* x right, y up, z the way it looks; mirrored along with a mirror's picture */
    double left, right, bottom, top; /* of the picture plane: at distance 1 along z; directional: in world units around eye */
    int width, height;               /* texels */
    int columns, rows;               /* blocks: width / columns = height / rows = w / m texels each way */
    size_t first;                    /* its first texel in the planes, row 0 at the bottom */
} sl_map_face;

typedef struct sl_radiance_map {
    const sl_map_lights *lights;
    size_t face_count;
    sl_map_face *face;               /* light by light */
    size_t texels;                   /* of all faces together; the planes hold so many values */
    uint32_t *triangle;              /* SL_NO_INDEX: nothing there (coverage 0) */
    float *position[3];
    float *color[3];                 /* Lambertian scenes: L_o, W/(m^2 sr), as it leaves: mirrors on the light's way have had their share;
                                        others: true colour, kd with its texture, and nothing else */
    float *normal[3];                /* shading normals turned to the light; NULL where no weight or material asks for them */
    float *geometric[3];             /* geometric ones, likewise turned; always there, as they decide sides */
    float *block_angle;              /* per texel: solid angle in sr (directional: area in m^2) of the texel itself, footprint.h */
    float *path;                     /* per texel: b, the way from the light; of traced mirrors the unfolded one */
    float *spread;                   /* per texel: NULL, or of traced light: the area perpendicular to the light's arrival that the texel
                                        stands for, instead of b^2 dOmega; 0 where the light came straight */
    float *arrival[3];               /* beside spread: unit, at y towards where its light comes from; NULL without */
    float *carried[3];               /* beside spread: the reflectances of the traced mirrors on the way, multiplied; NULL without */
    bool lambertian;                 /* color holds L_o */
    bool mirrored_light;             /* some faces are images in mirrors */
    sl_map_shape shape;              /* as asked for */
    double fov;
} sl_radiance_map;

typedef struct sl_radiance_map_options {
    const sl_mirrors *mirrors;       /* planar mirrors, or NULL */
    bool lambertian;                 /* no surface is glossy: radiance instead of true colour */
    bool normals;                    /* pass 2c */
    const struct sl_tracer *tracer;  /* for settings->traced_light_mirrors; NULL: curved mirrors in a light's view stay dark */
    unsigned threads;
} sl_radiance_map_options;

/* Takes the pictures. settings are complete. Faces that are dark, faces that meet no geometry, and all of lights without flux are skipped
 * and counted as such. What lies lower than an area light's own triangles reach is not in its pictures. Lights that shine into one
 * hemisphere have hemicubes where cubes are asked for; directional lights one parallel picture, whatever is asked for. */
sl_status sl_radiance_map_render(const sl_scene *scene, const sl_raster *raster, const sl_map_lights *lights,
                                 const sl_radiance_map_settings *settings, const sl_radiance_map_options *options, sl_radiance_map **map,
                                 sl_counters *counters, sl_error *error);
void sl_radiance_map_destroy(sl_radiance_map *map);
size_t sl_radiance_map_bytes(const sl_radiance_map *map);
/* Share of a light's flux that leaves inside its map's faces, hit or not: 1 for a cube around a point; 0.554 for one 90 degree frustum
 * of an area light. */
double sl_radiance_map_captured(const sl_radiance_map *map, uint32_t light);

#endif
