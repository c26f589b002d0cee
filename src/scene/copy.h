/* A copy of a scene: what keyframes and cameras move is its own, all the rest is the scene's. So two threads
 * can have the same scene at two times: what is shown follows at once, while samples are still taken where
 * things were. */
#pragma once

#include "scene/scene.h"

/* As the scene stands now. It can be moved (sl_scene_set_time(), sl_scene_set_camera()) and looked at as any
 * scene can; the scene must outlive it, and may be moved at the same time. */
sl_status sl_scene_copy(const sl_scene *scene, sl_scene **scene_copy, sl_error *error);
/* Returns what a copy takes. */
size_t sl_scene_copy_bytes(const sl_scene *scene);
/* NULL is allowed; not sl_scene_destroy(), which would take the scene along */
void sl_scene_copy_destroy(sl_scene *scene_copy);
