/* Material libraries (MTL) as the importer reads them right. */
#ifndef SL_SCENE_MTL_TEXT_H
#define SL_SCENE_MTL_TEXT_H

#include "scene/text.h"

/* The same library without indentation and blanks at line ends, which would be part of a texture's name, and with three numbers for
 * each Ka, Kd, Ks, Ke that has one; release it. A file that is empty or in UTF-16 gives an empty text. */
sl_status sl_mtl_text_read(const char *path, sl_text *plain, sl_error *error);

#endif
