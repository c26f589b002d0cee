/* Probes of visibility: a round shadow of six pixels is found whatever its position. Leaves of direct light
 * may be larger than such a shadow, and their edges pass it by. So every fourth pixel of every fourth row of
 * a leaf that is closed is asked whether it sees what the leaf's corners say it does: where all of them see
 * all of a light, or all of them nothing of it, a shadow ray towards its middle must say the same. No disc of
 * six pixels lies between four such pixels. Where it says something else, n x n rays tell by how much, and
 * whether an eye could tell.
 *
 * Nothing is asked where corners are in the penumbra: that their edges know. What is asked depends on the
 * view and on what the meshes know, and is forgotten at once. */
#include "cache/multi_mesh/multi_mesh_internal.h"

#include <math.h>

#include "base/batch.h"

enum { SPACING = 4, CLOSER_RAYS = 4 };
/* Of what a light could give at a corner: all of it, or nothing, but for what interpolation makes of them. */
static const float ALL = 0.9f, NOTHING = 0.05f;

typedef struct probed_leaf {
    const sl_multi_mesh_state *s;
    sl_component part;
    const sl_displayed *d;
    const sl_patch_place *place;
    sl_mesh_point corner[3];
    sl_counters *counters;
} probed_leaf;

static sl_mesh_point point_at(const probed_leaf *leaf, float p, float q) {
    float whole = (float)SL_PATCH_DYADIC;
    uint16_t at_p = (uint16_t)fminf(fmaxf(p + 0.5f, 0.0f), whole);
    uint16_t at_q = (uint16_t)fminf(fmaxf(q + 0.5f, 0.0f), whole - (float)at_p);
    return sl_mesh_point_at(leaf->s->primitives, (sl_root_place){leaf->place->root, at_p, at_q});
}

/* Returns the mesh's value from so much of one light alone. */
static sl_rgb value_of_light(const probed_leaf *leaf, size_t light, float share, const sl_mesh_point *point) {
    const sl_sampled_lights one = {.count = 1, .light = &leaf->s->now.lights->light[light]};
    return sl_multi_mesh_direct(leaf->s, leaf->part, &one, &share, point);
}

/* Tells whether an eye could tell the mesh's value at a point from what it is with more of a light, and less.
 */
static bool shows(const probed_leaf *leaf, float w1, float w2, const float value[3], sl_rgb more,
                  sl_rgb less) {
    const float changed[3] = {fmaxf(value[0] + more.r - less.r, 0.0f),
                              fmaxf(value[1] + more.g - less.g, 0.0f),
                              fmaxf(value[2] + more.b - less.b, 0.0f)};
    sl_rgb a = sl_displayed_shown(leaf->d, leaf->place->root, w1, w2, value),
           b = sl_displayed_shown(leaf->d, leaf->place->root, w1, w2, changed);
    return sl_display_contrast(&leaf->d->settings.perception, a, b) > 1.0f;
}

/* ---- one light ---- */

typedef enum seen_by_corners { CORNERS_DIFFER, CORNERS_SEE_ALL, CORNERS_SEE_NOTHING } seen_by_corners;

static seen_by_corners what_corners_see(const probed_leaf *leaf, size_t light, float share[3]) {
    const sl_patches *mesh = leaf->d->mesh, *irradiance = sl_irradiance_mesh(leaf->s->irradiance, light);
    bool all = true, nothing = true;
    for (int i = 0; i < 3; i++) {
        sl_root_place at = mesh->vertex[sl_patch_corner(mesh, leaf->place->patch, i)].place;
        float most = (float)sl_light_unoccluded(&leaf->s->now.lights->light[light], &leaf->corner[i].lit);
        if (!sl_irradiance_known(irradiance, at, &share[i])) return CORNERS_DIFFER;
        all = all && most > 0.0f && share[i] >= ALL * most;
        nothing = nothing && share[i] <= NOTHING * most;
    }
    return all ? CORNERS_SEE_ALL : nothing ? CORNERS_SEE_NOTHING : CORNERS_DIFFER;
}

/* Tells whether what a pixel sees of the light is something that an eye can tell from what corners make of
 * it. */
static bool differs(const probed_leaf *leaf, size_t light, const float share[3], bool lit_corners,
                    uint32_t pixel) {
    const sl_visible_pixels *pixels = leaf->d->pixels;
    float w1 = pixels->w1[pixel], w2 = pixels->w2[pixel], own_w1, own_w2, value[3];
    sl_mesh_point point = point_at(leaf, w1 * (float)SL_PATCH_DYADIC, w2 * (float)SL_PATCH_DYADIC);
    bool is_lit = sl_light_probe(leaf->s->now.sampling, light, &point.lit, 1, leaf->counters) > 0.0f;
    sl_mesh_weights_within(leaf->place, w1, w2, &own_w1, &own_w2);
    if (is_lit == lit_corners ||
        !sl_mesh_interpolate(leaf->d->mesh, leaf->place, own_w1, own_w2, true, value))
        return false;
    float interpolated = share[0] + own_w1 * (share[1] - share[0]) + own_w2 * (share[2] - share[0]);
    float seen = sl_light_probe(leaf->s->now.sampling, light, &point.lit, CLOSER_RAYS, leaf->counters);
    return shows(leaf, w1, w2, value, value_of_light(leaf, light, seen, &point),
                 value_of_light(leaf, light, interpolated, &point));
}

/* ---- a leaf ---- */

static bool is_probe(const probed_leaf *leaf, uint32_t i) {
    const sl_visible_pixels *pixels = leaf->d->pixels;
    uint32_t at = pixels->pixel[sl_displayed_pixel(leaf->d, leaf->place->patch, i)],
             width = (uint32_t)pixels->view.width;
    return at % width % SPACING == SPACING / 2 && at / width % SPACING == SPACING / 2;
}

static bool is_contradicted_by(const probed_leaf *leaf, size_t light) {
    float share[3];
    seen_by_corners corners = what_corners_see(leaf, light, share);
    if (corners == CORNERS_DIFFER) return false;
    uint32_t count = leaf->d->mesh->patch[leaf->place->patch].pixels;
    for (uint32_t i = 0; i < count; i++) {
        if (is_probe(leaf, i) && differs(leaf, light, share, corners == CORNERS_SEE_ALL,
                                         sl_displayed_pixel(leaf->d, leaf->place->patch, i)))
            return true;
    }
    return false;
}

static bool has_probes(const probed_leaf *leaf) {
    uint32_t count = leaf->d->mesh->patch[leaf->place->patch].pixels;
    for (uint32_t i = 0; i < count; i++)
        if (is_probe(leaf, i)) return true;
    return false;
}

static bool is_contradicted(probed_leaf *leaf) {
    const sl_patches *mesh = leaf->d->mesh;
    if (!has_probes(leaf)) return false;
    for (int i = 0; i < 3; i++) {
        uint32_t vertex = sl_patch_corner(mesh, leaf->place->patch, i);
        if (sl_mesh_state(mesh, vertex) != SL_VERTEX_KNOWN) return false;
        leaf->corner[i] = sl_mesh_point_of(mesh, vertex);
    }
    for (size_t l = 0; l < leaf->s->now.lights->count; l++)
        if (is_contradicted_by(leaf, l)) return true;
    return false;
}

/* ---- many ---- */

typedef struct probing {
    const sl_multi_mesh_state *s;
    sl_taken_leaf *leaf;
} probing;

static void probe_one(void *context, size_t i, unsigned worker, void *result, sl_counters *counters) {
    (void)worker;
    (void)result;
    const probing *p = context;
    sl_taken_leaf *of = &p->leaf[i];
    probed_leaf leaf = {
        .s = p->s, .part = of->part, .d = p->s->part[of->part], .place = &of->place, .counters = counters};
    of->contradicted = of->probed && is_contradicted(&leaf);
}

void sl_multi_mesh_probe(sl_multi_mesh_state *s, size_t count, sl_taken_leaf *leaves) {
    probing p = {s, leaves};
    const sl_batch batch = {.count = count, .work = probe_one, .context = &p};
    if (count) sl_batch_run(&batch, s->settings.threads, &s->counters);
}

/* Leaves that are probed. A leaf whose edges agree says nothing of what lies between them, and leaves may be
 * larger than the smallest shadow that an eye looks for. To make them smaller costs samples everywhere; to
 * look whether it would show something costs a ray. So a leaf that is closed, and larger than the finest of
 * size criteria, is probed once: the caller looks at some of its pixels. Where one tells of something that
 * the corners do not know, the leaf counts as too large after all. It is cut, and its children in turn, until
 * corners tell or they are as small as that; what is cut in vain is undone like any other cut for the sake of
 * size.
 *
 * It is done again when the leaf is seen larger than it was then. */

void sl_displayed_judge_probes(const sl_displayed *d, sl_patch *node, sl_screen_size size) {
    if (!(d->settings.probed_area > 0.0f) || !sl_all_edges_closed(node)) return;
    if (size.edge > sl_mesh_probed_size(node)) sl_mesh_set_tested_size(node, 0.0f);
    if (size.area <= d->settings.probed_area && size.edge <= d->settings.probed_edge &&
        sl_mesh_upper_half(node) == 0.0f)
        sl_mesh_set_probed_size(node, size.edge);
}

/* Of leaves only those that are small enough and do not count as such. */
bool sl_displayed_is_contradicted(const sl_displayed *d, const sl_patch_place *leaf) {
    const sl_patch *node = &d->mesh->patch[leaf->patch];
    if (!(d->settings.probed_area > 0.0f) || (node->flags & SL_NODE_SMALL) || !d->pixels) return false;
    return sl_displayed_meets_size(d, sl_displayed_size(d, leaf));
}

bool sl_displayed_within_contradicted(const sl_displayed *d, const sl_patch_place *leaf) {
    if (!(d->settings.probed_area > 0.0f)) return false;
    if (sl_displayed_is_contradicted(d, leaf)) return true;
    for (uint32_t n = sl_patch_parent(d->mesh, leaf->patch); n != SL_NO_INDEX;
         n = sl_patch_parent(d->mesh, n)) {
        if (d->mesh->patch[n].flags & SL_NODE_SMALL) continue;
        sl_patch_place place = sl_patch_place_of(d->mesh, n);
        return sl_displayed_is_contradicted(d, &place); /* what is above it is larger */
    }
    return false;
}

void sl_displayed_probed(sl_displayed *d, const sl_patch_place *leaf, bool contradicted,
                         sl_counters *counters) {
    sl_patch *node = &d->mesh->patch[leaf->patch];
    if (!d->pixels || !sl_patch_is_leaf(d->mesh, leaf->patch)) return;
    node->flags &= ~(uint32_t)SL_NODE_TAKEN;
    /* its vertices are asked for once more, and its edges tested again */
    if (sl_is_unprobed(d, node) && contradicted) {
        node->flags &= ~(uint32_t)(SL_NODE_SMALL | SL_PATCH_EDGES);
    } else if (sl_is_unprobed(d, node)) { /* and no neighbour has opened an edge in the meantime */
            sl_mesh_set_probed_size(node, sl_displayed_size(d, leaf).edge);
    }
    sl_displayed_close(d, leaf, counters);
}
