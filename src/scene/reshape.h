/* Surfaces of a scene that become others by an edit: objects that come and go, vertices that move. */
#pragma once

#include "scene/model.h"

/* Vertices of an object, each as three numbers. */
typedef struct sl_moulding {
    uint32_t object;
    size_t count;
    float *positions, *normals; /* the latter NULL: those of the triangles around them */
} sl_moulding;

typedef struct sl_reshaping {
    sl_model more; /* what comes: names of objects, triangles that name these by their numbers in the scene */
    uint8_t *gone; /* by object of the scene, whether it goes; NULL: none does */
    sl_moulding *moulding;
    size_t mouldings, moulding_room;
} sl_reshaping;

static inline bool sl_reshapes(const sl_reshaping *r) {
    return r->gone || r->mouldings || r->more.scene.object_count;
}
void sl_reshaping_release(sl_reshaping *r);

/* Surfaces as they were. */
typedef struct sl_surfaces {
    sl_scene scene;
    uint32_t *track_of_vertex; /* these three are the animation's */
    sl_vec3 *rest_position, *rest_normal;
} sl_surfaces;

/* Gives the scene its other surfaces, at rest, all but what sl_scene_derive() finds out; *before gets what it
 * had. All or nothing. */
sl_status sl_reshape(sl_scene *scene, sl_reshaping *r, sl_surfaces *before, sl_error *error);
/* Puts them back; or lets go of them, and of what went with them. */
void sl_reshape_undo(sl_scene *scene, sl_surfaces *before);
void sl_reshape_settle(sl_reshaping *r, sl_surfaces *before);
