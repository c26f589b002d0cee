/* A pass's buffer as a picture that people can look at. */
#ifndef SL_APP_STEPS_SHOW_H
#define SL_APP_STEPS_SHOW_H

#include "app/steps/narrative.h"
#include "cache/frame/settings.h"

/* R, G, B in the order of the buffer, ready for a PNG without tone mapping; light excepted, which is to be
 * tone-mapped. The caller destroys it. */
sl_status sl_show_buffer(const sl_image *buffer, sl_show show, sl_image **picture, sl_error *error);

#endif
