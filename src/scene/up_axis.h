/* Which axis of a mesh points up, where its format does not say. */
#ifndef SL_SCENE_UP_AXIS_H
#define SL_SCENE_UP_AXIS_H

#include "scene/model.h"

bool sl_up_axis_is_unsaid(const char *path);
/* Tells whether the model stands by its shape on the plane of least z, and not on that of least y. In doubt,
 * no. */
bool sl_model_stands_on_z(const sl_model *model);
/* (x, y, z) becomes (x, z, -y), for models of triangles alone: no lights, no camera, no surfaces. */
void sl_model_turn_z_up(sl_model *model);

#endif
