/* Photons in the making: a sample in double, before it is written as the 64 bytes of sl_map_photon. */
#ifndef SL_CACHE_DIRECT_RADIANCE_PHOTON_LIST_H
#define SL_CACHE_DIRECT_RADIANCE_PHOTON_LIST_H

#include "cache/direct_radiance/map_texel.h"
#include "cache/direct_radiance/photons.h"

/* Part of a face in texel coordinates, half-open: what a photon stands for. */
typedef struct sl_texel_rectangle {
    double left, bottom, right, top;
} sl_texel_rectangle;

static inline sl_texel_rectangle sl_texel_rectangle_join(sl_texel_rectangle a, sl_texel_rectangle b) {
    return (sl_texel_rectangle){fmin(a.left, b.left), fmin(a.bottom, b.bottom), fmax(a.right, b.right), fmax(a.top, b.top)};
}

typedef struct sl_photon_sample {
    sl_vec3d position, normal, shading, to_light;
    double cos_alpha, footprint, way;
    double flux[3], radiance[3];
    double diffuse[3], specular[3], exponent; /* with lobes */
    uint32_t object;
    bool bent;               /* of several texels whose normals differ */
    sl_texel_rectangle rectangle;
} sl_photon_sample;

/* The list, and what its samples are taken from. */
typedef struct sl_photon_list {
    const sl_scene *scene;
    const sl_radiance_map *map;
    sl_map_photons *photons;
} sl_photon_list;

/* Texels each way of a block. */
static inline int sl_block_texels(const sl_map_face *face) { return face->width / face->columns; }
static inline bool sl_face_is_directional(const sl_radiance_map *map, const sl_map_face *face) {
    return map->lights->light[face->light].kind == SL_MAP_LIGHT_DIRECTIONAL;
}

/* Solid angle of the block whose lower left texel that is (directional: area). */
double sl_block_angle(const sl_radiance_map *map, const sl_map_face *face, int column, int row);

/* L_o; with lobes, which need to know who looks, E. */
static inline double sl_printed_radiance(const sl_radiance_map *map, const sl_map_texel *t, int channel) {
    return map->lambertian ? t->color[channel] : t->flux[channel] * (t->cos_alpha / t->footprint);
}

/* `times` a texel: its flux and footprint scaled, all else as it stands. */
sl_photon_sample sl_photon_of_texel(const sl_photon_list *list, const sl_map_texel *texel, double times, sl_texel_rectangle rectangle);
/* Appends the sample; nothing where it holds no light, or where a float cannot hold it. */
void sl_photon_add(sl_photon_list *list, const sl_map_face *face, const sl_photon_sample *sample);

/* The regular sample of the block whose lower left texel that is; color (or NULL) stands in for its texel's. */
void sl_photon_at_point(sl_photon_list *list, const sl_map_face *face, int column, int row, const double *color);

/* The ways to take samples. Each appends the photons of a light's faces, which lie side by side in the map. */
typedef sl_status sl_take_photons(sl_photon_list *list, const sl_map_face *face, size_t face_count, sl_error *error);
sl_take_photons sl_photons_at_points;            /* photons.c */
sl_take_photons sl_photons_of_filtered_radiance; /* map_filter.c */
sl_take_photons sl_photons_of_groups;            /* map_filter.c */

/* The footprint's corners on the sample's tangent plane (photon_quad.c). */
void sl_photon_quad_find(const sl_radiance_map *map, const sl_map_face *face, const sl_photon_sample *sample, sl_photon_quad *quad);

#endif
