/* Messages from viewers, taken apart. SL_ERROR_INPUT: malformed; SL_ERROR_USAGE: well formed, and cannot
 * be. */
#pragma once

#include "app/serve/world.h"

#include <cjson/cJSON.h>

/* What may be left out is left alone; *there (or NULL) tells. */
sl_status sl_take_number(const cJSON *message, const char *name, double least, double most, double *value,
                         bool *there, sl_error *error);
sl_status sl_take_flag(const cJSON *message, const char *name, bool *value, sl_error *error);
/* The text belongs to the message; at most 200 bytes. */
sl_status sl_take_text(const cJSON *message, const char *name, const char **value, sl_error *error);
sl_status sl_take_numbers(const cJSON *message, const char *name, size_t count, double *values, bool *there,
                          sl_error *error);
/* "a" (0) or "b" (1). */
sl_status sl_take_side(const cJSON *message, int *side, sl_error *error);
/* "x" and "y", within the picture of those settings. */
sl_status sl_take_pixel(const cJSON *message, const sl_settings *settings, double *x, double *y,
                        sl_error *error);
/* Of the scene's camera what the message leaves out. */
sl_status sl_take_camera(const cJSON *message, const sl_scene *scene, sl_camera *camera, sl_error *error);
/* *count of at most SL_ITEMS. */
sl_status sl_take_edits(const cJSON *message, const sl_world *world, sl_item *items, size_t *count,
                        sl_error *error);
