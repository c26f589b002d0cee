/* A look over an OBJ file before it is imported: the importer gives no line numbers, and drops vertices whose
 * spelling it does not know, so that all later indices mean others. */
#ifndef SL_SCENE_OBJ_CHECK_H
#define SL_SCENE_OBJ_CHECK_H

#include "scene/model.h"
#include "scene/text.h"

/* Numbers of v, vt, vn and indices of f, l, p, and the material libraries; what is wrong is an input error
 * with file and line. Libraries and materials that there are none of, and faces of fewer than three corners,
 * are warnings. `plain` becomes the same file as the importer reads it right: libraries first, no
 * indentation, no comments, no continued lines, no number that begins with its point, two numbers for each
 * vt, no colours, nothing but faces; `libraries` its material libraries likewise, as sl_import_run() takes
 * them; release both. A file in UTF-16 is not looked into: empty. */
sl_status sl_obj_check(const char *path, sl_model *model, sl_text *plain, sl_text *libraries,
                       sl_error *error);

#endif
