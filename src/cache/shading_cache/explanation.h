/* The terms of a pixel, and patches, samples and chosen pixels as marks: for those who look on. */
#ifndef SL_SHADING_CACHE_EXPLANATION_H
#define SL_SHADING_CACHE_EXPLANATION_H

#include "cache/patches/display/leaf_lookup.h"
#include "cache/shading_cache/state.h"

/* See sl_method_explanation(). */
sl_status sl_shading_explanation(void *state, int x, int y, sl_explanation_writer *writer, sl_error *error);

/* Nothing without an observer. Chosen pixels: hits green, random ones blue, floods red. */
void sl_shading_announce_choices(sl_shading_state *state, size_t choices);
void sl_shading_announce_priorities(sl_shading_state *state);
/* Leaves that were seen in the last update, by their edges; vertices with samples, in the colour of their
 * irradiance. */
void sl_shading_announce_patches(sl_shading_state *state);

#endif
