/* Pictures by what they shall be instead of by what shall be done: within an error (--error), the best within
 * a time (--time). */
#ifndef SL_APP_TARGET_H
#define SL_APP_TARGET_H

#include "app/picture.h"

/* Tells whether the options ask for that; other pictures are sl_render_pictures()'s. */
bool sl_target_wanted(const sl_render_options *options);
/* *end is left alone where all is done. */
sl_status sl_render_to_target(const sl_render_options *options, const sl_scene *scene, sl_render_end *end,
                              sl_error *error);
/* "0.05" or "5%": a share above 0. */
bool sl_parse_error_share(const char *text, double *share);

#endif
