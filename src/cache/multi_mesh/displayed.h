/* A mesh as the eye uses it: the direct diffuse, direct specular and indirect meshes. It knows which pixels
 * show which leaf, which leaf matters most, when a leaf is fine enough, and redraws what has changed.
 *
 *   displayed.c    visible pixels down the quadtrees (pass 1); Gouraud: a leaf's pixels (pass 3)
 *   priorities.c   the size criterion; P = n_px (delta + delta_0), maxima up to the roots; the heap over these,
 *                  or the paper's random chain
 *   refine.c       the test of a leaf and its edges, split, undo
 *   probes.c       leaves whose edges agree, and yet something lies between them
 *
 * One step of refinement:
 *   leaf = sl_displayed_take(mesh)          the one that matters most; it is marked as taken
 *   sl_displayed_request(mesh, leaf, ...)   vertices whose values its test wants: corners, then the middles of
 *                                           untested edges; the caller samples them and puts their values
 *   sl_displayed_commit(mesh, leaf)         tests edges; splits, closes or collapses
 *
 * A leaf that is closed then, and larger than the finest that the size criterion knows, is taken once more:
 *   sl_displayed_wants_probes(mesh, leaf)   it is to be probed instead: the caller looks at pixels of it
 *   sl_displayed_probed(mesh, leaf, ...)    it stays closed, or is cut after all
 */
#ifndef SL_MULTI_MESH_DISPLAYED_H
#define SL_MULTI_MESH_DISPLAYED_H

#include "cache/patches/mesh.h"
#include "cache/patches/perception.h"
#include "cache/multi_mesh/pixels.h"

typedef enum sl_component { SL_DIRECT_DIFFUSE, SL_DIRECT_SPECULAR, SL_INDIRECT, SL_COMPONENTS } sl_component;

/* Radiance that a face shows at a point when one component has the given value there, all other components as
 * they are now interpolated: reflectance included, and if textured the largest over the triangle. The method
 * provides it. */
typedef struct sl_shown_radiance {
    const void *context;
    sl_rgb (*radiance)(const void *context, sl_component component, uint32_t face, float w1, float w2,
                       sl_rgb value);
} sl_shown_radiance;

typedef struct sl_displayed_settings {
    sl_component component;
    float leaf_area, leaf_edge;   /* pixels^2, pixels: the size criterion */
    /* leaves that show fewer pixels than that are not looked into unless these, times the contrast between
     * the */
    uint32_t minor_pixels;
    float minor_contrast;        /* ... leaf's corners in thresholds, come to so much */
    /* pixels^2, pixels: leaves larger than that are probed before they stay closed; 0: none are */
    float probed_area, probed_edge;
    bool below_pixels;            /* leaves that show in one pixel alone may be cut */
    /* light can end where other geometry begins: leaves with corners in it are cut until it is known where,
     * to a pixel's size */
    bool sharp;
    int max_depth;
    sl_mesh_selection selection;
    uint64_t seed;                /* of the chain */
    bool hanging;                 /* neighbours' vertices on common edges are used */
    sl_perception perception;
    sl_shown_radiance shown;
    /* of sl_displayed_see() and sl_displayed_prioritise(); 0: one. `shown` is called on all of them */
    unsigned threads;
} sl_displayed_settings;

typedef struct sl_displayed {
    sl_displayed_settings settings;
    sl_patches *mesh;                /* its own; 3 channels */
    const sl_visible_pixels *pixels; /* of the view as it stands, or NULL */
    /* by node: its pixels are first .. first + node.pixels in pixels' arrays; */
    uint32_t *first;
    size_t patch_capacity;
    /* selection */
    uint32_t *heap;               /* entries of pixels->face, highest priority on top, lower face on a tie */
    uint32_t *heap_place;         /* by entry; SL_NO_INDEX: the component does not want it */
    size_t heap_count, heap_capacity;
    uint32_t chain_entry;         /* the chain's current root */
    uint64_t chain_draws;
    bool dirty_all;               /* all leaves are to be drawn, not those with SL_PATCH_DIRTY alone */
    /* roots' corners are being sampled: what touches them changes when they become known */
    bool corners_asked;
} sl_displayed;

sl_status sl_displayed_create(const sl_primitives *primitives, const sl_displayed_settings *settings,
                              sl_displayed **displayed, sl_error *error);
void sl_displayed_destroy(sl_displayed *displayed);
size_t sl_displayed_memory_bytes(const sl_displayed *displayed);

/* A new view: makes roots for the faces in view that want(context, face) says this component has, hands the
 * pixels down, sets priorities afresh, marks every visible leaf to be drawn. pixels must outlive the next
 * call. Unknown vertices of visible leaves are listed by sl_displayed_missing(). */
sl_status sl_displayed_see(sl_displayed *displayed, const sl_visible_pixels *pixels,
                           bool (*want)(const void *context, uint32_t face), const void *context,
                           sl_error *error);
/* Lists vertices of visible leaves that are UNKNOWN, ascending by first use, each marked REQUESTED, and the
 * faces whose corners they are; at most `room`. Returns how many. */
size_t sl_displayed_missing(sl_displayed *displayed, uint32_t *vertex, uint32_t *face, size_t room);
/* A vertex's value: INVALID where it is not `valid`, or no number, which is counted. */
void sl_displayed_put(sl_displayed *displayed, uint32_t vertex, sl_rgb value, bool valid,
                      sl_counters *counters);
/* Priorities of visible leaves from what is known now: after values of missing vertices were filled in. */
void sl_displayed_prioritise(sl_displayed *displayed);
/* Nothing is left to do in the view as it stands: what was not worth a look need not be judged again when it
 * is seen again, no larger. */
void sl_displayed_settle(sl_displayed *displayed);
/* Throws the whole mesh away but for its memory, as specular radiance is when the eye moves (call
 * sl_displayed_see() next). */
void sl_displayed_restart(sl_displayed *displayed);

/* Returns the highest priority of all leaves that are not taken; 0: nothing is left to do. */
float sl_displayed_priority(const sl_displayed *displayed);
/* Returns the leaf to be served next by the selection; node SL_NO_INDEX: none. Marks it. */
sl_patch_place sl_displayed_take(sl_displayed *displayed);
/* Vertices that its test wants and whose state is UNKNOWN: they are marked REQUESTED and appended; vertex has
 * room for 6. Returns how many. */
sl_status sl_displayed_request(sl_displayed *displayed, const sl_patch_place *leaf, uint32_t *vertex,
                               size_t *count, sl_error *error);
/* All that it asked for is KNOWN or INVALID. */
sl_status sl_displayed_commit(sl_displayed *displayed, const sl_patch_place *leaf, sl_counters *counters,
                              sl_error *error);
/* Tells whether the leaf's edges are all closed, and it is to be probed. Then nothing is requested. */
bool sl_displayed_wants_probes(const sl_displayed *displayed, const sl_patch_place *leaf);
/* Returns the i-th of a leaf's node.pixels pixels: an index into the arrays of the view. */
uint32_t sl_displayed_pixel(const sl_displayed *displayed, const sl_patch_place *leaf, uint32_t i);
/* It has been: does any probe say that its corners do not tell what lies between them? */
void sl_displayed_probed(sl_displayed *displayed, const sl_patch_place *leaf, bool contradicted,
                         sl_counters *counters);
/* Returns the number of levels from the root at which the size criterion is met here: as deep as irradiance
 * meshes must be, whatever their edges say. Where a probe has told of something between corners, a level
 * deeper than the leaf: its vertices are not to be interpolated. */
int sl_displayed_wanted_depth(const sl_displayed *displayed, const sl_patch_place *leaf);

/* Draws the pixels of all leaves that are marked into three planes (bottom row first); parallel over leaves.
 * Where corners are not known the nearest ancestor that has them shows, else `fallback`. */
void sl_displayed_draw(sl_displayed *displayed, unsigned threads, sl_rgb fallback, float *const planes[3],
                       sl_counters *counters);

#endif
