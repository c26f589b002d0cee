/* Messages from viewers, taken apart. */
#pragma once

#include "app/serve/world.h"

#include <cjson/cJSON.h>

/* A message, and what is wrong with it. SL_ERROR_INPUT: malformed; SL_ERROR_USAGE: well formed, and cannot
 * be. The first mistake stays, so that it is looked for once all has been taken. */
typedef struct sl_taking {
    const cJSON *message;
    sl_error *error;
    sl_status status;
} sl_taking;

/* Notes a mistake, of a message that is sound so far: NAME: expected EXPECTED. */
void sl_malformed(sl_taking *t, const char *name, const char *expected);
/* Returns the status once `there` says that nothing is missing of what is expected of the name. */
sl_status sl_take_all(sl_taking *t, bool there, const char *name, const char *expected);

/* Return `otherwise` where the message has no such name. */
double sl_take_number(sl_taking *t, const char *name, double least, double most, double otherwise);
bool sl_take_flag(sl_taking *t, const char *name, bool otherwise);
/* The text belongs to the message; at most 200 bytes. */
const char *sl_take_text(sl_taking *t, const char *name, const char *otherwise);
bool sl_is_there(const sl_taking *t, const char *name);
/* "a" (0) or "b" (1). */
int sl_take_side(sl_taking *t);
/* "x" and "y", within the picture of those settings. */
sl_status sl_take_pixel(sl_taking *t, const sl_settings *settings, int *x, int *y);
/* Of the scene's camera what the message leaves out. */
sl_status sl_take_camera(sl_taking *t, const sl_scene *scene, sl_camera *camera);
/* *count of at most SL_ITEMS. */
sl_status sl_take_edits(sl_taking *t, const sl_world *world, sl_item *items, size_t *count);
