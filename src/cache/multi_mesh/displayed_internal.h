/* Shared by the parts of a displayed mesh. */
#ifndef SL_MULTI_MESH_DISPLAYED_INTERNAL_H
#define SL_MULTI_MESH_DISPLAYED_INTERNAL_H

#include <string.h>

#include "cache/multi_mesh/displayed.h"

/* Flags of patches, beside those of patches.h and the states of their edges. */
enum {
    SL_NODE_TAKEN = 0x40,  /* chosen for a batch that is not done yet */
    SL_NODE_SMALL = 0x800, /* meets the size criterion in the view as it stands */
    /* a node above it is closed and small there: only another view asked for more */
    SL_NODE_SETTLED = 0x1000,
    SL_NODE_TESTED_SHIFT = 16 /* the upper half: of leaves with closed edges sl_mesh_tested_size() or
                                 sl_mesh_probed_size(), of others sl_mesh_minor() */
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
static inline float sl_mesh_tested_size(const sl_patch *node) { return fmaxf(sl_mesh_upper_half(node), 0.0f); }
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
/* Returns of a leaf whose edges are not all closed how many pixels it had when a picture was done without a
 * look into it; 0: it never was. */
static inline uint32_t sl_mesh_minor(const sl_patch *node) { return node->flags >> SL_NODE_TESTED_SHIFT; }
static inline void sl_mesh_set_minor(sl_patch *node, uint32_t pixels) {
    node->flags = (node->flags & 0xffffu) | pixels << SL_NODE_TESTED_SHIFT;
}

/* ---- displayed.c ---- */

/* Hands a node's pixels to its children. */
void sl_displayed_hand_down(sl_displayed *d, const sl_patch_place *place);
/* Room for what goes with nodes, after the mesh has grown. */
sl_status sl_displayed_grow(sl_displayed *d, sl_error *error);
static inline bool sl_displayed_wants(const sl_displayed *d, size_t entry) {
    return d->heap_place[entry] != SL_NO_INDEX;
}
static inline uint32_t sl_displayed_root(const sl_displayed *d, size_t entry) {
    return sl_patches_find_root(d->mesh, d->pixels->face[entry].face);
}

/* ---- priorities.c ---- */

/* Tells whether it is known already that the leaf is to be cut: it is too large, or an edge is. */
static inline bool sl_needs_cut(const sl_patch *node) {
    bool cut = !(node->flags & SL_NODE_SMALL);
    for (int e = 0; e < 3; e++) cut |= sl_edge_of(node, e) == SL_EDGE_SPLIT;
    return cut;
}
/* Few pixels whose corners are much alike: to look into the leaf would take as many samples as it has pixels,
 * and what an eye can tell of a few pixels is less the fewer they are (Ricco's law: threshold times area is
 * constant). Without known corners there is nothing to be told. */
bool sl_displayed_is_minor(const sl_displayed *d, const sl_patch_place *leaf);
/* Tells whether it was one when a picture was done; with no more pixels it still is. */
static inline bool sl_was_minor(const sl_patch *node) {
    return !sl_all_edges_closed(node) && node->pixels <= sl_mesh_minor(node);
}
/* Tells whether a corner is inside other geometry. Then direct light ends somewhere in the leaf, and its
 * other corners do not say where. */
static inline bool sl_has_hidden_corner(const sl_displayed *d, const sl_patch_place *leaf) {
    bool hidden = false;
    for (int c = 0; c < 3 && d->settings.sharp && !hidden; c++)
        hidden = sl_mesh_state(d->mesh, sl_patch_corner(d->mesh, leaf->patch, c)) == SL_VERTEX_INVALID;
    return hidden;
}
/* More than a pixel long on the screen. */
bool sl_displayed_exceeds_pixel(const sl_displayed *d, const sl_patch_place *leaf);
/* Tells whether the leaf may be cut at all. Patches of a pixel or less are not; one that shows in a single
 * pixel is only to find where light ends. */
static inline bool sl_may_split_but_for_minor(const sl_displayed *d, const sl_patch_place *leaf) {
    uint32_t pixels = d->mesh->patch[leaf->patch].pixels;
    if (pixels == 0 || leaf->depth >= d->settings.max_depth) return false;
    return pixels > 1 || d->settings.below_pixels ||
           (sl_has_hidden_corner(d, leaf) && sl_displayed_exceeds_pixel(d, leaf));
}
static inline bool sl_may_split(const sl_displayed *d, const sl_patch_place *leaf) {
    return sl_may_split_but_for_minor(d, leaf) && !sl_displayed_is_minor(d, leaf);
}
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
/* Priorities in the tree below a node; returns the largest. */
float sl_displayed_prioritise_below(sl_displayed *d, const sl_patch_place *place);
/* Sets the largest of the children's priorities from a node's parent up to the root, and the root's place in
 * the heap. */
void sl_displayed_raise(sl_displayed *d, uint32_t face, uint32_t node);

/* ---- refine.c ---- */

/* A leaf stays as it is: parents whose children are all closed by now go, and priorities are raised. */
void sl_displayed_close(sl_displayed *d, const sl_patch_place *leaf, sl_counters *counters);

/* ---- probes.c ---- */

/* A leaf whose edges have just been closed, or that is seen anew, of that size: what need not be probed says
 * so. */
void sl_displayed_judge_probes(const sl_displayed *d, sl_patch *node, sl_screen_size size);
/* Tells whether the leaf is to be cut because a probe told so. */
bool sl_displayed_is_contradicted(const sl_displayed *d, const sl_patch_place *leaf);
/* Tells whether any node above it has been. */
bool sl_displayed_below_contradicted(const sl_displayed *d, const sl_patch_place *leaf);

/* ---- priorities.c: selection ---- */

void sl_displayed_heap_build(sl_displayed *d);
void sl_displayed_heap_update(sl_displayed *d, uint32_t entry);

/* ---- refine.c: edges ---- */

/* Tests the edge's middle and those of its parts, as far as they are known. */
sl_edge_state sl_displayed_test_edge(const sl_displayed *d, const sl_patch_place *place, int edge);
/* The edge's middle has become known: leaves beyond the edge are drawn again, and split if they can tell. */
void sl_displayed_tell_neighbours(sl_displayed *d, uint32_t middle);

/* ---- displayed.c: drawing ---- */

/* A leaf's vertices or those on its edges have changed: it is drawn again. */
void sl_displayed_mark(sl_displayed *d, uint32_t leaf);

#endif
