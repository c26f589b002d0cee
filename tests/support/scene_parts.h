/* Scenes made by hand. */
#pragma once

#include "scene/scene.h"

/* A scene from plain arrays, which are copied and checked as files are: triangles with non-finite
 * or out-of-range vertices or without area are dropped, with a warning. Vertices come out in the order of
 * their first use. A corner without a normal gets its facet's geometric normal, and with it a vertex of its
 * own, so that facets stay facets. */
typedef struct sl_scene_parts {
    size_t vertex_count;
    const float *positions;      /* xyz */
    const float *normals;        /* xyz, or NULL; (0,0,0) or non-finite: computed from the geometry */
    const float *texture_coordinates; /* uv, or NULL */
    size_t triangle_count;
    const uint32_t *indices;     /* three a triangle */
    const uint32_t *material_index; /* one a triangle, or NULL: all 0 */
    const uint32_t *object_index;   /* or NULL: all 0 */
    size_t material_count;
    const sl_material *materials;
    size_t texture_count;
    const sl_texture *textures;
    size_t light_count;
    const sl_light *lights;
    const sl_environment *environment; /* CDFs are made here; NULL: none */
    const sl_camera *camera;     /* or NULL: framed */
    const sl_viewpoint *view;         /* in place of what the camera has; or NULL */
    int film_width, film_height; /* 0: 512 */
    bool default_light;          /* if nothing gives light, add the stated default */
    size_t object_count;         /* 0: as many as object_index names */
    const char *const *object_names; /* object_count, or NULL */
} sl_scene_parts;

sl_status sl_scene_build(const sl_scene_parts *parts, sl_scene **scene, sl_error *error);
/* The same, and fails the test where that fails. */
sl_scene *scene_built(const sl_scene_parts *parts);
