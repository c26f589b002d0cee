/* What follows from the triangles, and is computed again whenever they move: geometric normals, emitters,
 * bounds. */
#ifndef SL_SCENE_DERIVE_H
#define SL_SCENE_DERIVE_H

#include "scene/scene.h"

/* The geometric normal times twice the area, in double, so that slivers keep a direction. False where the
 * triangle has no area at all or is not finite. */
bool sl_triangle_cross(sl_vec3 a, sl_vec3 b, sl_vec3 c, sl_vec3d *cross);

/* Room for every triangle of an emissive material, then sl_scene_derive(). */
sl_status sl_scene_make_emitters(sl_scene *scene, sl_error *error);
/* Normals (a triangle that lost its area in motion takes a shading normal), emitters (only those with an
 * area; returns how many emissive triangles have none) and bounds. Allocates nothing. */
size_t sl_scene_derive(sl_scene *scene);
/* The scene's scale and core, by its vertices, box, diagonal and vantage. */
void sl_scene_measure(sl_scene *scene);
/* The same for another vantage, where nothing has moved. */
void sl_scene_measure_from(sl_scene *scene, sl_vec3 vantage);

/* The camera that a file without one gets: the whole scene from outside, or a room from inside. *shut_out: it
 * is outside, and no light of the scene is. */
sl_camera sl_camera_framed(const sl_scene *scene, bool *inside, bool *shut_out);
/* Adds the lights that a scene without any gets, or one without any where the camera is, by what that sees:
 * sun and sky, or a lamp in a room. */
sl_status sl_scene_light_by_default(sl_scene *scene, sl_error *error);

/* Copies what the environment holds, clears what is not light, and makes the sums that sampling needs. */
sl_status sl_environment_copy(const sl_environment *from, sl_environment *to, size_t *repaired,
                              sl_error *error);

/* Checks and repairs what a scene says of its surfaces and lights; failing is an input error that names the
 * culprit. */
sl_status sl_materials_check(sl_scene *scene, sl_error *error);
sl_status sl_lights_check(sl_scene *scene, sl_error *error);

char *sl_string_copy(const char *text); /* NULL: ""; release with sl_free() */
void sl_strings_free(char **list, size_t count); /* NULL: none */

#endif
