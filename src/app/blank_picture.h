/* Pictures in which nothing can be seen. */
#ifndef SL_APP_BLANK_PICTURE_H
#define SL_APP_BLANK_PICTURE_H

#include "app/picture.h"

/* Says on stderr that a picture is black, or as a PNG black or white all over, and the likely reason. */
void sl_tell_blank_picture(const sl_render_options *options, const sl_scene *scene, const sl_image *image);

#endif
