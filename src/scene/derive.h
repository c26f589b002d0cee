/* Geometric normals, emitters and bounds: they follow from the triangles, and are computed again whenever
 * these move. */
#pragma once

#include <string.h>

#include "scene/scene.h"

/* The geometric normal times twice the area, in double, so that slivers keep a direction. False where the
 * triangle has no area at all or is not finite. */
bool sl_triangle_cross(sl_vec3 a, sl_vec3 b, sl_vec3 c, sl_vec3d *cross);

/* Room for the lamps of all emissive triangles, then sl_scene_derive(). */
sl_status sl_scene_make_emitters(sl_scene *scene, sl_error *error);
/* Normals (a triangle that lost its area in motion takes a shading normal), emitters (only those with an
 * area; returns how many emissive triangles have none) and bounds. Allocates nothing. */
size_t sl_scene_derive(sl_scene *scene);
/* The scene's scale and central region, by its vertices, box, diagonal and vantage. */
void sl_scene_measure(sl_scene *scene);
/* The same for another vantage, where nothing has moved. */
void sl_scene_measure_from(sl_scene *scene, sl_vec3 vantage);

/* The camera that a file without one gets: the whole scene from outside, or a room from inside. *shut_out: it
 * is outside, and no light of the scene is. */
sl_camera sl_camera_framed(const sl_scene *scene, bool *inside, bool *shut_out);
/* Gives a scene the camera that is given (NULL: it is framed), with what the view has in place of that. */
sl_status sl_scene_place_camera(sl_scene *scene, const sl_camera *given, const sl_viewpoint *view,
                                bool *shut_out, sl_error *error);
/* Adds the lights that a scene without any gets, or one without any where the camera is, by what that sees:
 * sun and sky, or a lamp in a room. */
sl_status sl_scene_light_by_default(sl_scene *scene, sl_error *error);

/* Clears what is not light in an environment, and makes the sums that sampling needs. */
sl_status sl_environment_complete(sl_environment *environment, size_t *repaired, sl_error *error);

/* The arrays by vertex, by triangle, of lights and surfaces: where the scene has their pointers (of whatever
 * type: to be read and written as bytes), and what is in them. Of the first SL_HASHED_ARRAYS the light
 * depends on all. */
typedef struct sl_scene_array {
    void *pointer;
    size_t bytes;
    bool moves; /* keyframes, or what is derived from the triangles, change it */
} sl_scene_array;
enum { SL_SCENE_ARRAYS = 21, SL_HASHED_ARRAYS = 12 };
void sl_scene_arrays(sl_scene *scene, sl_scene_array list[SL_SCENE_ARRAYS]);
static inline void *sl_scene_array_at(const sl_scene_array *array) {
    void *at;
    memcpy(&at, array->pointer, sizeof at);
    return at;
}
static inline void sl_scene_array_put(const sl_scene_array *array, void *at) {
    memcpy(array->pointer, &at, sizeof at);
}
/* Frees all that a scene has, but not the scene. */
void sl_scene_release(sl_scene *scene);

/* Checks and repairs what a scene says of its surfaces and lights; failing is an input error that names the
 * culprit. */
sl_status sl_materials_check(sl_scene *scene, sl_error *error);
/* The same for one material, which need not be the scene's yet. */
sl_status sl_material_check(sl_scene *scene, sl_material *material, sl_error *error);
sl_status sl_lights_check(sl_scene *scene, sl_error *error);

char *sl_string_copy(const char *text); /* NULL: ""; release with sl_free() */
void sl_strings_free(char **list, size_t count); /* NULL: none */
