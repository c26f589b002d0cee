/* The stories of all pixels of a picture, packed for a page: what made each pixel, and how much of it. */
#ifndef SL_APP_STEPS_STORIES_H
#define SL_APP_STEPS_STORIES_H

#include "app/steps/marks.h"
#include "softlux.h"

#include <stdio.h>

enum { SL_STORY_TERMS_SHOWN = 8 }; /* of a pixel; the smaller ones are told as one */

typedef struct sl_stories sl_stories;

/* Asks the method for the story of every pixel of the picture that it resolved last. */
sl_status sl_stories_collect(sl_method *method, const sl_image *picture, sl_stories **stories, sl_error *error);
void sl_stories_destroy(sl_stories *stories);
/* As one JSON object: kinds, items (kind, number, place in the picture) and, in base 64, where each pixel's terms begin, its item numbers, seven
 * floats a term (weight, contribution, value), and what is left to the pixel's exact value (three doubles). */
void sl_stories_put(const sl_stories *stories, const sl_mark_view *view, FILE *out);

#endif
