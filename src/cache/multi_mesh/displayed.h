/* A mesh as the eye uses it: the direct diffuse, direct specular and indirect meshes. It knows which pixels
 * show which leaf, which leaf matters most, when a leaf is fine enough, and redraws what has changed.
 *
 *   displayed.c    visible pixels down the quadtrees (pass 1); Gouraud: a leaf's pixels (pass 3)
 *   priorities.c   the size criterion; P = n_px (delta + delta_0), maxima up to the roots and above these; or
 *                  the paper's random chain
 *   refine.c       the test of a leaf and its edges, split, undo
 *   probes.c       leaves whose edges agree, and yet something lies between them
 *   renew.c        values of before an edit, which are seen until they are taken again
 *
 * One step of refinement:
 *   leaf = sl_displayed_take(mesh)          the one that matters most; it is marked as taken
 *   sl_displayed_request(mesh, leaf, ...)   vertices whose values its test wants: corners, then the middles
 *                                           of untested edges; the caller samples them, puts their values
 *   sl_displayed_commit(mesh, leaf)         tests edges; splits, closes or collapses
 *
 * A leaf that is closed then, and larger than the finest that the size criterion knows, is taken once more:
 *   sl_is_unprobed(mesh, leaf)              it is to be probed instead: the caller looks at pixels of it
 *   sl_displayed_probed(mesh, leaf, ...)    it stays closed, or is cut after all
 */
#pragma once

#include <math.h>
#include <string.h>

#include "cache/patches/display/pixels.h"
#include "cache/patches/mesh.h"
#include "cache/patches/perception.h"

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
    uint32_t *order;              /* indices into pixels' arrays, those of a node together */
    uint32_t *first;              /* by node: where its own begin in `order` */
    size_t order_capacity, patch_capacity;
    /* selection */
    uint32_t *root;               /* by entry of pixels->face: its patch; SL_NO_INDEX: not wanted here */
    size_t root_count;            /* that are wanted */
    /* the roots' priorities from `leaves` on, a power of two; before them the larger one of two each */
    float *highest;
    size_t leaves, leaves_room;
    uint32_t chain_entry;         /* the chain's current root */
    uint64_t chain_draws;
    /* by vertex: the world that its value was taken in, 0: it never was. Edits make another world (renew.c)
     * */
    uint32_t *world_of;
    uint32_t world;               /* as it is now: 1 before any edit */
    uint32_t put_as;              /* the world that values are put for */
    float *weight;                /* by vertex: 0, but while old ones are listed */
    size_t vertex_room;
    uint32_t *touched;            /* leaves whose edges are to be tested again, SL_NODE_TOUCHED */
    size_t touched_count, touched_room;
    bool dirty_all;               /* all leaves are to be drawn, not those with SL_NODE_DIRTY alone */
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
/* Lists vertices of visible leaves that are UNKNOWN, ascending by first use, each marked REQUESTED; at most
 * `room`. Returns how many. */
size_t sl_displayed_missing(sl_displayed *displayed, uint32_t *vertex, size_t room);
/* A vertex's value: INVALID where it is not `valid`, or no number, which is counted. Where it is another than
 * it was, the leaves around are touched. */
void sl_displayed_put(sl_displayed *displayed, uint32_t vertex, sl_rgb value, bool valid,
                      sl_counters *counters);
/* Priorities of visible leaves from what is known now: after values of missing vertices were filled in. */
void sl_displayed_prioritise(sl_displayed *displayed);
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

/* ---- renew.c: after edits. Values stay, and are shown, until they are taken again ---- */

/* Makes another world: values for which `check` (NULL: none) does not hold are old from now on. */
void sl_displayed_age(sl_displayed *displayed, uint32_t worlds, const sl_mesh_check *check);
/* Forgets that leaves were probed, or put together: those for which `stays` does not hold. */
typedef struct sl_leaf_check {
    bool (*stays)(const void *context, const sl_patches *mesh, const sl_patch_place *leaf);
    const void *context;
} sl_leaf_check;
void sl_displayed_doubt(sl_displayed *displayed, const sl_leaf_check *check);

/* A vertex in view with an old value. */
typedef struct sl_old_vertex {
    uint32_t vertex, leaf;     /* a leaf that shows it */
    float weight;              /* the pixels of leaves that show it, times the worlds since */
} sl_old_vertex;
/* Lists those that were taken in worlds before `world`, heaviest first; the caller's to free, also after a
 * failure. */
sl_status sl_displayed_list_old(sl_displayed *displayed, uint32_t world, sl_old_vertex **old, size_t *count,
                                sl_error *error);
/* Tests edges of touched leaves again, as far as their values are of now; closes and puts together. */
void sl_displayed_settle(sl_displayed *displayed, sl_counters *counters);
/* The same of all leaves in view: what else is seen beside them may have changed. */
void sl_displayed_settle_all(sl_displayed *displayed, sl_counters *counters);

/* Tells whether a value is to be taken again: quick samples of lights are not, as long as such are put; quick
 * gathers are, being too rough to cut leaves by. */
static inline bool sl_is_old(const sl_displayed *d, uint32_t vertex) {
    const uint32_t least = d->settings.component == SL_INDIRECT ? d->world : d->put_as;
    return d->world > 1 && vertex < d->vertex_room && d->world_of[vertex] < least;
}
/* Touches the leaves around a vertex whose value has changed. */
void sl_displayed_touch(sl_displayed *displayed, uint32_t vertex);

/* Flags of patches, beside those of patches.h and the states of their edges. */
enum {
    SL_NODE_TAKEN = 0x40,  /* chosen for a batch that is not done yet */
    SL_NODE_TOUCHED = 0x80, /* it is in the list of those to be tested again */
    SL_NODE_DIRTY = 0x400, /* it is to be drawn again */
    SL_NODE_SMALL = 0x800, /* meets the size criterion in the view as it stands */
    SL_NODE_TESTED_SHIFT = 16 /* the upper half: sl_mesh_tested_size() or sl_mesh_probed_size() */
};

/* The upper half of a float's bits; what has been probed alone has the sign of a negative one. */
static inline float sl_mesh_upper_half(const sl_patch *node) {
    uint32_t bits = node->flags >> SL_NODE_TESTED_SHIFT << SL_NODE_TESTED_SHIFT;
    float size;
    memcpy(&size, &bits, sizeof size);
    return size;
}
static inline void sl_mesh_set_upper_half(sl_patch *node, float size) {
    uint32_t bits;
    memcpy(&bits, &size, sizeof bits);
    node->flags = (node->flags & 0xffffu) | bits >> SL_NODE_TESTED_SHIFT << SL_NODE_TESTED_SHIFT;
}
/* Returns a node's size in pixels when it collapsed: it is not opened again before it is twice that; 0: it
 * never did. */
static inline float sl_mesh_tested_size(const sl_patch *node) {
    return fmaxf(sl_mesh_upper_half(node), 0.0f);
}
static inline void sl_mesh_set_tested_size(sl_patch *node, float size) {
    sl_mesh_set_upper_half(node, size > 0.0f ? size : 0.0f); /* NaN, too */
}
/* Returns the size up to which a leaf with closed edges need not be probed again (displayed.h): as it was
 * when it was probed, or twice what it was when it collapsed; 0: it is yet to be probed. */
static inline float sl_mesh_probed_size(const sl_patch *node) {
    float size = sl_mesh_upper_half(node);
    return size < 0.0f ? -size : 2.0f * size;
}
/* A hundredth more, for what the lower half loses. */
static inline void sl_mesh_set_probed_size(sl_patch *node, float size) {
    sl_mesh_set_upper_half(node, size > 0.0f && size < 1e30f ? -1.01f * size : -1e30f);
}

/* Returns what a face shows at a point where the mesh has a value. */
static inline sl_rgb sl_displayed_shown(const sl_displayed *d, uint32_t face, float w1, float w2,
                                        const float value[3]) {
    const sl_shown_radiance *shown = &d->settings.shown;
    return shown->radiance(shown->context, d->settings.component, face, w1, w2,
                           (sl_rgb){value[0], value[1], value[2]});
}

/* ---- between the parts: displayed.c ---- */

/* Returns the index into pixels' arrays of the k-th pixel of a node. */
static inline uint32_t sl_displayed_pixel(const sl_displayed *d, uint32_t node, uint32_t k) {
    return d->order[d->first[node] + k];
}
/* Visits the leaves of an entry's root that show pixels; none where it is not wanted. */
typedef void sl_seen_leaf_visitor(const sl_patch_place *leaf, void *context);
void sl_displayed_visit(const sl_displayed *d, size_t entry, sl_seen_leaf_visitor *visit, void *context);
/* Hands a node's pixels to its children. */
void sl_displayed_hand_down(sl_displayed *d, const sl_patch_place *place);
/* Room for what goes with nodes, after the mesh has grown. */
sl_status sl_displayed_grow(sl_displayed *d, sl_error *error);
static inline bool sl_displayed_wants(const sl_displayed *d, size_t entry) {
    return d->root[entry] != SL_NO_INDEX;
}

/* ---- priorities.c ---- */

/* Tells whether it is known already that the leaf is to be cut: it is too large, or an edge is. */
static inline bool sl_needs_cut(const sl_patch *node) {
    bool cut = !(node->flags & SL_NODE_SMALL);
    for (int e = 0; e < 3; e++) cut |= sl_edge_of(node, e) == SL_EDGE_SPLIT;
    return cut;
}
/* Tells whether the leaf may be cut at all, and is worth it. */
bool sl_may_split(const sl_displayed *d, const sl_patch_place *leaf);
/* Closed, small enough, and yet to be probed. */
static inline bool sl_is_unprobed(const sl_displayed *d, const sl_patch *node) {
    return d->settings.probed_area > 0.0f && (node->flags & SL_NODE_SMALL) && sl_all_edges_closed(node) &&
           !(node->flags >> SL_NODE_TESTED_SHIFT);
}
static inline sl_screen_size sl_displayed_size(const sl_displayed *d, const sl_patch_place *leaf) {
    return sl_patch_projected(d->mesh, leaf, &d->pixels->view);
}
/* Tells whether it meets the size criterion, whatever else is known of it. */
bool sl_displayed_meets_size(const sl_displayed *d, sl_screen_size size);
/* Sets or clears SL_NODE_SMALL. */
void sl_displayed_judge_size(sl_displayed *d, const sl_patch_place *leaf);
/* Returns the largest contrast between any two corners of a leaf, as shown; those that are not known do not
 * count. */
float sl_displayed_corner_contrast(const sl_displayed *d, const sl_patch_place *leaf);
float sl_displayed_leaf_priority(const sl_displayed *d, const sl_patch_place *leaf);
/* Sets the largest of the children's priorities from a node's parent up to the root, and the root's place in
 * the heap. */
void sl_displayed_raise(sl_displayed *d, uint32_t face, uint32_t node);

/* ---- refine.c ---- */

/* A leaf stays as it is: parents whose children are all closed by now go, and priorities are raised. */
void sl_displayed_close(sl_displayed *d, const sl_patch_place *leaf, sl_counters *counters);

/* Tests edges again that have been tested, and whose values are of now. */
void sl_displayed_retest(sl_displayed *d, const sl_patch_place *leaf);

/* ---- probes.c ---- */

/* A leaf whose edges have just been closed, or that is seen anew, of that size: what need not be probed says
 * so. */
void sl_displayed_judge_probes(const sl_displayed *d, sl_patch *node, sl_screen_size size);
/* Tells whether the leaf is to be cut because a probe told so; and whether it is, or any node above it has
 * been. */
bool sl_displayed_is_contradicted(const sl_displayed *d, const sl_patch_place *leaf);
bool sl_displayed_within_contradicted(const sl_displayed *d, const sl_patch_place *leaf);

/* ---- priorities.c: selection ---- */

/* Ranks all roots by their priorities. */
void sl_displayed_rank(sl_displayed *d);

/* A leaf's vertices or those on its edges have changed: it is drawn again. */
static inline void sl_displayed_mark(sl_displayed *d, uint32_t leaf) {
    d->mesh->patch[leaf].flags |= SL_NODE_DIRTY;
}
