/* Which leaf matters most to the eye: P = n_px (delta + delta_0), the pixels that show it times what they may
 * be wrong by. delta is the largest difference between the colours at its corners in units of what an eye can
 * tell; delta_0 keeps a leaf in the race that is too large for its corners to say what lies between them.
 * Inner nodes have the largest of their children's. */
#include "cache/multi_mesh/displayed.h"

#include "base/parallel.h"
#include "base/random.h"

/* delta_0 while the size criterion is unmet, or an edge is known to need a cut; and for leaves that are small
 * enough, but with edges that nobody has looked at: corners of the same colour do not say that nothing is
 * between them. These come last. A leaf that is too large may be wrong by more than its corners: with 4
 * instead of 1/4 the room's picture (640 x 480, normal) has two thirds of the trimmed relative squared error
 * at 13,000 to 30,000 samples of direct light, nine tenths before and after, and the same at its end. */
static const float TOO_LARGE = 4.0f, UNTESTED = 1.0f / 64.0f;
/* No more can be told apart than black from white, at the smallest of thresholds that make sense. */
static const float CONTRAST_MAX = 25500.0f;

/* ---- the size criterion ---- */

bool sl_displayed_meets_size(const sl_displayed *d, sl_screen_size size) {
    return !(size.area > d->settings.leaf_area) && !(size.edge > d->settings.leaf_edge);
}

/* A leaf that was cut for its size alone and put together again stays so until it is twice as large. */
void sl_displayed_judge_size(sl_displayed *d, const sl_patch_place *leaf) {
    sl_patch *node = &d->mesh->patch[leaf->patch];
    sl_screen_size size = sl_displayed_size(d, leaf);
    bool small = sl_displayed_meets_size(d, size);
    bool known = sl_all_edges_closed(node) && size.edge < 2.0f * sl_mesh_tested_size(node);
    node->flags = (node->flags & ~(uint32_t)SL_NODE_SMALL) | (small || known ? SL_NODE_SMALL : 0u);
    if (small) sl_displayed_judge_probes(d, node, size);
}

int sl_displayed_wanted_depth(const sl_displayed *d, const sl_patch_place *leaf) {
    if (!d->pixels) return leaf->depth;
    if (sl_displayed_within_contradicted(d, leaf)) return leaf->depth + 1;
    sl_screen_size size = sl_displayed_size(d, leaf);
    float area = size.area / d->settings.leaf_area, edge = size.edge / d->settings.leaf_edge;
    int depth = leaf->depth;
    for (; depth > 0 && 4.0f * area <= 1.0f && 2.0f * edge <= 1.0f; depth--, area *= 4.0f, edge *= 2.0f)
        continue;
    for (; depth < d->settings.max_depth && (area > 1.0f || edge > 1.0f);
         depth++, area *= 0.25f, edge *= 0.5f)
        continue;
    return depth;
}

/* ---- of a leaf ---- */

float sl_displayed_corner_contrast(const sl_displayed *d, const sl_patch_place *leaf) {
    const sl_patches *mesh = d->mesh;
    float level[3][3], most = 0.0f;
    int known = 0;
    for (int i = 0; i < 3; i++) {
        uint32_t v = sl_patch_corner(mesh, leaf->patch, i);
        if (sl_mesh_state(mesh, v) != SL_VERTEX_KNOWN) continue;
        const float unit = 1.0f / (float)SL_PATCH_DYADIC;
        sl_rgb shown = sl_displayed_shown(d, leaf->root, (float)leaf->u[i] * unit, (float)leaf->v[i] * unit,
                                          sl_vertex_value(mesh, v));
        const float radiance[3] = {shown.r, shown.g, shown.b};
        for (int c = 0; c < 3; c++)
            level[known][c] = sl_display_level(d->settings.perception.exposure, radiance[c]);
        for (int j = 0; j < known; j++)
            for (int c = 0; c < 3; c++)
                most = fmaxf(most, sl_levels_contrast(&d->settings.perception, level[known][c], level[j][c]));
        known++;
    }
    return fminf(most, CONTRAST_MAX);
}

/* Tells whether a corner is inside other geometry. Then direct light ends somewhere in the leaf, and its
 * other corners do not say where. */
static bool has_hidden_corner(const sl_displayed *d, const sl_patch_place *leaf) {
    bool hidden = false;
    for (int c = 0; c < 3 && d->settings.sharp && !hidden; c++)
        hidden = sl_mesh_state(d->mesh, sl_patch_corner(d->mesh, leaf->patch, c)) == SL_VERTEX_INVALID;
    return hidden;
}

/* Patches of a pixel or less are not cut; one that shows in a single pixel is only to find where light
 * ends. */
static bool may_be_cut(const sl_displayed *d, const sl_patch_place *leaf) {
    uint32_t pixels = d->mesh->patch[leaf->patch].pixels;
    if (pixels == 0 || leaf->depth >= d->settings.max_depth) return false;
    return pixels > 1 || d->settings.below_pixels ||
           (has_hidden_corner(d, leaf) && sl_displayed_size(d, leaf).edge > 1.0f);
}

/* Few pixels whose corners are much alike: to look into the leaf would take as many samples as it has pixels,
 * and what an eye can tell of a few pixels is less the fewer they are (Ricco's law: threshold times area is
 * constant). Without known corners there is nothing to be told. */
static bool is_minor(const sl_displayed *d, uint32_t pixels, float contrast) {
    return (float)pixels * contrast < d->settings.minor_contrast;
}

/* So few pixels that their leaf may be one. A hidden corner's contrast with the others is not known, nor is
 * what a probe has told of. */
static bool may_be_minor(const sl_displayed *d, const sl_patch_place *leaf) {
    return d->mesh->patch[leaf->patch].pixels < d->settings.minor_pixels && !has_hidden_corner(d, leaf) &&
           !sl_displayed_within_contradicted(d, leaf);
}

bool sl_may_split(const sl_displayed *d, const sl_patch_place *leaf) {
    return may_be_cut(d, leaf) &&
           !(may_be_minor(d, leaf) &&
             is_minor(d, d->mesh->patch[leaf->patch].pixels, sl_displayed_corner_contrast(d, leaf)));
}

float sl_displayed_leaf_priority(const sl_displayed *d, const sl_patch_place *leaf) {
    const sl_patch *node = &d->mesh->patch[leaf->patch];
    bool small = node->flags & SL_NODE_SMALL, closed = sl_all_edges_closed(node),
         unprobed = sl_is_unprobed(d, node);
    /* most often so, and quick to tell */
    if ((node->flags & SL_NODE_TAKEN) || (small && closed && !unprobed)) return 0.0f;
    if (!may_be_cut(d, leaf)) return 0.0f;
    if (unprobed) return (float)node->pixels * UNTESTED;
    bool minor = may_be_minor(d, leaf);
    float contrast = sl_displayed_corner_contrast(d, leaf);
    return minor && is_minor(d, node->pixels, contrast)
               ? 0.0f
               : (float)node->pixels * (contrast + (sl_needs_cut(node) ? TOO_LARGE : UNTESTED));
}

/* ---- up to the roots ---- */

static float largest_of_children(const sl_patches *mesh, uint32_t node) {
    float most = 0.0f;
    for (int c = 0; c < 4; c++) {
        float priority = mesh->patch[mesh->patch[node].child + (uint32_t)c].priority;
        most = priority > most ? priority : most;
    }
    return most;
}

static void raise_at(sl_displayed *d, size_t at) {
    float a = d->highest[2 * at], b = d->highest[2 * at + 1];
    d->highest[at] = a > b ? a : b;
}

static void rank_root(sl_displayed *d, uint32_t entry) {
    size_t at = d->leaves + entry;
    d->highest[at] = d->mesh->patch[d->root[entry]].priority;
    while (at /= 2) raise_at(d, at);
}

void sl_displayed_raise(sl_displayed *d, uint32_t face, uint32_t node) {
    sl_patches *mesh = d->mesh;
    for (uint32_t n = sl_patch_parent(mesh, node); n != SL_NO_INDEX; n = sl_patch_parent(mesh, n)) {
        float most = largest_of_children(mesh, n);
        if (mesh->patch[n].priority == most) return;
        mesh->patch[n].priority = most;
    }
    uint32_t entry = d->pixels->entry_of_face[face];
    if (entry != SL_NO_INDEX && sl_displayed_wants(d, entry)) rank_root(d, entry);
}

/* Priorities in the tree below a node; returns the largest. */
static float prioritise_below(sl_displayed *d, const sl_patch_place *place) {
    sl_patch *node = &d->mesh->patch[place->patch];
    if (node->child == SL_NO_INDEX) return node->priority = sl_displayed_leaf_priority(d, place);
    float most = 0.0f;
    for (int c = 0; c < 4; c++) {
        if (!d->mesh->patch[node->child + (uint32_t)c].pixels) continue;
        sl_patch_place child = sl_patch_child_place(d->mesh, place, c);
        float priority = prioritise_below(d, &child);
        most = priority > most ? priority : most;
    }
    return node->priority = most;
}

static void prioritise_root(void *context, size_t entry, unsigned worker) {
    (void)worker;
    sl_displayed *d = context;
    if (!sl_displayed_wants(d, entry)) return;
    sl_patch_place root = sl_patch_root_place(d->mesh, d->pixels->face[entry].face);
    prioritise_below(d, &root);
}

void sl_displayed_prioritise(sl_displayed *d) {
    if (!d->pixels) return;
    sl_parallel_for(d->settings.threads, d->pixels->face_count, prioritise_root, d);
    sl_displayed_rank(d);
    d->dirty_all |= d->corners_asked;
    d->corners_asked = false;
}

/* Which leaf is served next. Of the roots in view that of highest priority, found as the leaf below it is: by
 * following the larger one of two maxima. Or the paper's chain: it stays at a root and moves to another,
 * drawn at random, if that one has more. The chain chooses worse than the heap at first, when quick pictures
 * matter most; it is the paper's way, and cheaper per step only where thousands of roots are in view. */

/* ---- the heap ---- */

static float priority_of(const sl_displayed *d, uint32_t entry) { return d->highest[d->leaves + entry]; }

void sl_displayed_rank(sl_displayed *d) {
    for (size_t e = 0; e < d->leaves; e++) {
        bool wanted = e < d->pixels->face_count && sl_displayed_wants(d, e);
        d->highest[d->leaves + e] = wanted ? d->mesh->patch[d->root[e]].priority : 0.0f;
    }
    for (size_t at = d->leaves; at-- > 1;) raise_at(d, at);
}

float sl_displayed_priority(const sl_displayed *d) { return d->root_count ? d->highest[1] : 0.0f; }

/* The first of equals. */
static uint32_t highest_entry(const sl_displayed *d) {
    size_t at = 1;
    while (at < d->leaves) at = 2 * at + (d->highest[2 * at] < d->highest[2 * at + 1]);
    return (uint32_t)(at - d->leaves);
}

/* ---- the paper's chain ---- */

static uint32_t random_entry(sl_displayed *d) {
    uint64_t bits =
        sl_random_bits(sl_random_key(d->settings.seed, (uint64_t)d->settings.component), d->chain_draws++);
    return (uint32_t)(bits * d->pixels->face_count >> 32);
}

/* Each step draws one root and moves there if its priority is higher. Where nothing is left at the current
 * one it goes on drawing; after as many failures as twice the number of roots it looks at all of them. */
static uint32_t next_of_chain(sl_displayed *d) {
    uint32_t current = d->chain_entry == SL_NO_INDEX ? highest_entry(d) : d->chain_entry;
    size_t failures = 0;
    do {
        uint32_t drawn = random_entry(d);
        if (priority_of(d, drawn) > priority_of(d, current)) current = drawn;
    } while (priority_of(d, current) <= 0.0f && ++failures < 2 * d->pixels->face_count);
    return d->chain_entry = priority_of(d, current) > 0.0f ? current : highest_entry(d);
}

/* ---- what both share ---- */

/* Returns the leaf of highest priority below a root, the first of equals. */
static sl_patch_place best_leaf(const sl_displayed *d, uint32_t face) {
    const sl_patches *mesh = d->mesh;
    sl_patch_place place = sl_patch_root_place(mesh, face);
    while (!sl_patch_is_leaf(mesh, place.patch)) {
        const sl_patch *child = &mesh->patch[mesh->patch[place.patch].child];
        int best = 0;
        for (int c = 1; c < 4; c++) best = child[c].priority > child[best].priority ? c : best;
        place = sl_patch_child_place(mesh, &place, best);
    }
    return place;
}

sl_patch_place sl_displayed_take(sl_displayed *d) {
    sl_patch_place none = {.patch = SL_NO_INDEX, .root = SL_NO_INDEX};
    if (!(sl_displayed_priority(d) > 0.0f)) return none;
    uint32_t entry = d->settings.selection == SL_SELECT_CHAIN ? next_of_chain(d) : highest_entry(d);
    sl_patch_place leaf = best_leaf(d, d->pixels->face[entry].face);
    d->mesh->patch[leaf.patch].flags |= SL_NODE_TAKEN;
    d->mesh->patch[leaf.patch].priority = 0.0f;
    sl_displayed_raise(d, leaf.root, leaf.patch);
    return leaf;
}
