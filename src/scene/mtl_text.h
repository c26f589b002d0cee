/* Material libraries (MTL) as the importer reads them right. */
#ifndef SL_SCENE_MTL_TEXT_H
#define SL_SCENE_MTL_TEXT_H

#include "scene/model.h"
#include "scene/text.h"

/* What stands for no name behind newmtl and usemtl: the name of the importer's own material. */
#define SL_NAMELESS_MATERIAL "DefaultMaterial"

/* The same library with what materials here have and nothing else: one statement a line, no comments, no
 * options of textures, three numbers for each Kd, Ks, Ke; release it. What is wrong is an input error with
 * file and line; what is not used is a warning, where there is a model for it (NULL: none). A file that is
 * empty or in UTF-16, which is not looked into, gives an empty text. */
sl_status sl_mtl_text_read(const char *path, sl_model *model, sl_text *plain, sl_error *error);

#endif
