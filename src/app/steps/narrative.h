/* What is told of a method and its passes (narratives.json): its paper, and for each pass that the method
 * announces a title, two or three sentences, the equation, and the function that computes it; and how the
 * pass's buffer becomes a picture. */
#pragma once

#include "softlux.h"

#include <cjson/cJSON.h>

/* Returns the narrative of a method, which the caller deletes; NULL: there is none. */
cJSON *sl_narrative_of(const char *method);
/* Returns the entry that the longest beginning of the pass's name has, and its place in the paper's order;
 * NULL: nothing is told of it. */
const cJSON *sl_narrative_pass(const cJSON *narrative, const char *pass, size_t *place);
/* Makes R, G, B in the order of the buffer. tone: it is light, to be tone-mapped; else it is ready for a PNG.
 * told: the pass's entry, or NULL. */
sl_status sl_pass_picture(const sl_image *buffer, const cJSON *told, sl_image **picture, bool *tone,
                          sl_error *error);
