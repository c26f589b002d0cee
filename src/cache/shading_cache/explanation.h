/* The terms of a pixel, and patches, samples and chosen pixels as marks: for those who look on. */
#ifndef SL_SHADING_CACHE_EXPLANATION_H
#define SL_SHADING_CACHE_EXPLANATION_H

#include "cache/shading_cache/leaf_lookup.h"
#include "cache/shading_cache/state.h"

/* A pixel of the last frame in the display's own window: L_e + kd E / pi + L_s, in parts. */
typedef struct sl_shown_pixel {
    const sl_display_copy *copy;
    uint32_t root;             /* SL_NO_INDEX: the background; emission is that */
    bool wanted;               /* false: it shows the guess */
    bool lobe;                 /* L_s, too */
    sl_leaf leaf;
    sl_rgb emission, diffuse, guess;
} sl_shown_pixel;
/* draw.c: by the functions that draw it. pixel: bottom row first. */
void sl_display_pixel(sl_display *display, size_t pixel, sl_shown_pixel *shown);

/* See sl_method_explanation(). */
sl_status sl_shading_explanation(void *state, int x, int y, sl_explanation_writer *writer, sl_error *error);

/* Nothing without an observer. Chosen pixels: hits green, random ones blue, floods red. */
void sl_shading_announce_choices(sl_shading_state *state, size_t choices);
void sl_shading_announce_priorities(sl_shading_state *state);
/* Leaves that were seen in the last update, by their edges; vertices with samples, in the colour of their
 * irradiance. */
void sl_shading_announce_patches(sl_shading_state *state);

#endif
