/* The explanations of all pixels of a picture, packed for a page: what made each pixel, and how much of it.
 */
#pragma once

#include "app/steps/marks.h"

#include <cjson/cJSON.h>

/* Asks the method for the explanation of every pixel of the picture that it resolved last. A JSON object,
 * which the caller deletes: "kinds", pairs of a layer and what stands there; and in base 64 "begin", where
 * each pixel's terms begin; "terms"; and "rounding", what they leave of the pixel's exact value. */
sl_status sl_explanations_collect(sl_method *method, const sl_image *picture, const sl_mark_view *view,
                                  cJSON **explanations, sl_error *error);
/* Orders the terms, largest first, and makes one of those beyond `most`, of layer "several". */
void sl_explanation_fold(sl_explanation *explanation, size_t most);
