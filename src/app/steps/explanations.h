/* The explanations of all pixels of a picture, packed for a page: what made each pixel, and how much of it.
 */
#ifndef SL_APP_STEPS_EXPLANATIONS_H
#define SL_APP_STEPS_EXPLANATIONS_H

#include "app/steps/marks.h"
#include "softlux.h"

#include <stdio.h>

enum { SL_EXPLANATION_TERMS_SHOWN = 8 }; /* of a pixel; the smaller ones are told as one */

typedef struct sl_explanations sl_explanations;

/* Asks the method for the explanation of every pixel of the picture that it resolved last. */
sl_status sl_explanations_collect(sl_method *method, const sl_image *picture, sl_explanations **explanations,
                                  sl_error *error);
void sl_explanations_destroy(sl_explanations *explanations);
/* As one JSON object: kinds, items (kind, number, place in the picture) and, in base 64, where each pixel's
 * terms begin, its item numbers, seven floats a term (weight, contribution, value), and what is left to the
 * pixel's exact value (three doubles). */
void sl_explanations_put(const sl_explanations *explanations, const sl_mark_view *view, FILE *out);

#endif
