/* How objects have moved between two states of a scene, for what lies on them and moves along. */
#pragma once

#include "scene/affine.h"
#include "scene/scene.h"

/* Of one object. */
typedef struct sl_object_motion {
    bool moves;
    sl_affine places, turns; /* points; normals but for their lengths */
} sl_object_motion;

/* *placements: each object's motion from its rest state as the scene stands; to be freed. */
sl_status sl_object_placements_take(const sl_scene *scene, sl_affine **placements, sl_error *error);
/* Returns the motion from one placement to another; none from a flat one, which has no inverse. */
sl_object_motion sl_object_motion_between(const sl_affine *before, const sl_affine *now);
