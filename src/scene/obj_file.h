/* Mesh files that are text and are read here, where every mistake has its line: OBJ, with its material
 * libraries, and OFF. */
#ifndef SL_SCENE_OBJ_FILE_H
#define SL_SCENE_OBJ_FILE_H

#include "scene/model.h"

/* Append objects and materials to a model. What is wrong is an input error with file and line. */
sl_status sl_obj_file_load(const char *path, const sl_affine *placement, sl_model *model, sl_error *error);
sl_status sl_off_file_load(const char *path, const sl_affine *placement, sl_model *model, sl_error *error);

#endif
