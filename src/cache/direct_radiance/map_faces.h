/* Which pictures a light takes: their frames and extents, before anything is drawn. */
#ifndef SL_CACHE_DIRECT_RADIANCE_MAP_FACES_H
#define SL_CACHE_DIRECT_RADIANCE_MAP_FACES_H

#include "cache/frame/settings.h"
#include "cache/direct_radiance/radiance_map.h"

/* Two hemicubes. */
enum { SL_LIGHT_FACES_MAX = 10 };

/* A face that is planned; of those of mirrors also the view in which the mirror itself is seen. */
typedef struct sl_planned_face {
    sl_map_face face;
    bool back;         /* of an area light */
    float clearance;   /* sl_map_light_clearance() of that side */
    sl_view through;
    size_t stencil;    /* where its mirror's picture begins */
} sl_planned_face;

typedef struct sl_face_shape {
    sl_map_shape shape; /* AUTO: by the light's kind */
    double fov;         /* of a frustum; 0: the spot's own, or 90 degrees */
    int samples, texels; /* m, and texels a side of a block: w / m */
} sl_face_shape;

sl_face_shape sl_face_shape_of(const sl_radiance_map_settings *settings);
/* A light's faces, without views; at most SL_LIGHT_FACES_MAX. aim: unit; where a point light's frustum or hemicube looks. Faces that are
 * dark all over (behind, outside a cone) are not among them; *dark says how many. A directional light has one face, which needs the scene. */
int sl_light_faces(const sl_scene *scene, const sl_map_light *light, const sl_face_shape *shape, sl_vec3 aim, const float clearance[2],
                   sl_planned_face *face, int *dark);
/* Texels a side of a block in a directional light's picture, of `texels` in others': it holds the whole scene, and the sun
 * that falls through a window is a small part of it. 8 times as many, up to 512 a side of the picture. */
int sl_parallel_texels(int samples, int texels);
/* What draws a face. */
sl_view sl_map_face_view(const sl_scene *scene, const sl_map_light *light, const sl_planned_face *planned);
/* A face of directional light is as deep as the scene's box looks from there, and begins that far before the box. */
float sl_parallel_depth(const sl_scene *scene, const sl_map_face *face);

#endif
