/* The settings of all methods: whether they make sense, and how a picture tells of them. */
#ifndef SL_FRAME_SETTINGS_H
#define SL_FRAME_SETTINGS_H

#include "softlux.h"

/* SL_ERROR_USAGE with what was expected. 0 is allowed wherever it stands for a default; width and height are not 0 any more. */
sl_status sl_settings_check(const sl_settings *settings, sl_error *error);
/* Metadata "softlux.NAME": those of every method, and those of the method that made the picture. */
sl_status sl_settings_stamp(const sl_settings *settings, sl_image *image, sl_error *error);

#endif
