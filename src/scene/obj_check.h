/* A look over an OBJ file before it is imported: the importer gives no line numbers. */
#ifndef SL_SCENE_OBJ_CHECK_H
#define SL_SCENE_OBJ_CHECK_H

#include "scene/model.h"

/* Numbers of v, vt, vn and indices of f; what is wrong is an input error with file and line. A material library that does not
 * exist is a warning. */
sl_status sl_obj_check(const char *path, sl_model *model, sl_error *error);

#endif
