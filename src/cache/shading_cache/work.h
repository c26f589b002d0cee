/* From chosen pixels to work: vertices to be shaded, patches to be split (section on processing requests). */
#pragma once

#include "cache/shading_cache/change.h"
#include "cache/shading_cache/selection.h"

/* Where in its patch a chosen pixel lies. */
typedef struct sl_chosen_place {
    uint32_t patch;
    float u, v;                /* of the root */
} sl_chosen_place;

typedef struct sl_work_settings {
    const sl_view *view;
    const sl_display_curve *curve;
    /* pixels: projected area that a patch needs for a split: 1.2 stop sizes; and its root for its longest
     * edge */
    float split_above;
    bool moves;                /* values of few points on lights will do */
    const sl_changes *changes; /* which vertices are stale, which objects change */
    /* leaves of one pixel have dense points on lights: their parent's corners get them before the split */
    bool dense;
    /* leaves of polished surfaces are split below a pixel while their corners differ by SL_SHARP_LEVELS */
    bool sharp;
    /* > 0: children of patches of changing objects need more than so many pixels^2, triangles half of it */
    float coarsest;
} sl_work_settings;

/* The picture in a mirror or a narrow lobe may be smaller than a pixel: a corner that meets a lamp would
 * colour all of its leaf, whose pixel shows something else. Such leaves are split down to this share of what
 * is split elsewhere. */
enum { SL_SHARP_LEVELS = 32, SL_SHARP_PARTS = 16 };

/* A vertex that has been evaluated, but before its object or the eye moved, or with few points on lights
 * while things moved that rest by now: it is shaded again from its first set of samples. Others in the list
 * that were evaluated get one more set. */
bool sl_vertex_is_stale(const sl_patches *patches, const sl_work_settings *settings, uint32_t vertex);

/* Tells whether nothing is left to refine in a leaf: its corners were evaluated, and it is too small for a
 * split. Where that holds for all visible leaves, and nothing is stale, a picture of a still scene is
 * done. */
bool sl_patch_is_finished(const sl_patches *patches, const sl_work_settings *settings, uint32_t patch);

/* Handles all places, patch by patch: requests vertices never evaluated; else splits and hands places on.
 * What is stale is asked for by renewal, and holds up no split. vertex: the vertices to be shaded, each
 * once, in that order; room for 4 * count + 64. */
sl_status sl_work_out(sl_patches *patches, const sl_work_settings *settings, size_t count,
                      const sl_chosen_place *places, uint32_t *vertex, size_t *vertex_count,
                      sl_counters *counters, sl_error *error);
