/* A twin of a scene: what keyframes and cameras move is its own, all the rest is the scene's. So two threads can have the same scene at two times: what is
 * shown follows at once, while samples are still taken where things were. */
#ifndef SL_SCENE_TWIN_H
#define SL_SCENE_TWIN_H

#include "scene/scene.h"

/* As the scene stands now. It can be moved (sl_scene_set_time(), sl_scene_set_camera()) and looked at as any scene can; the scene must outlive it, and may be
 * moved at the same time. */
sl_status sl_scene_twin(const sl_scene *scene, sl_scene **twin, sl_error *error);
/* What a twin takes. */
size_t sl_scene_twin_bytes(const sl_scene *scene);
void sl_scene_twin_destroy(sl_scene *twin); /* NULL is allowed; not sl_scene_destroy(), which would take the scene along */

#endif
