/* Files of bicubic Bezier surfaces (.bpt), appended to a model. */
#ifndef SL_SCENE_BICUBIC_FILE_H
#define SL_SCENE_BICUBIC_FILE_H

#include "scene/model.h"

/* One object of one grey material, both called after the file. */
sl_status sl_bicubic_file_load(const char *path, const sl_affine *placement, sl_model *model,
                               sl_error *error);

#endif
