/* Images whose every pixel is about to be written: clearing the planes first costs as much as a small
 * picture. */
#pragma once

#include "softlux.h"

/* sl_image_create() but for the planes' values, which are anything. */
sl_status sl_image_create_unset(int width, int height, int channels, const char *const *channel_names,
                                sl_image **image, sl_error *error);
/* Makes all planes black. */
void sl_image_clear(sl_image *image);
