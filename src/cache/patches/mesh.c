/* Values between vertices: linear, or where vertices hang on a leaf's edges a fan around the leaf's centre,
 * so that both sides of an edge have the same values along it. Differences are added to a corner's value, so
 * that what is constant stays so in every bit. */
#include "cache/patches/mesh.h"

#include <math.h>

/* ---- splits, points -------------------------------------------------------------------------- */

/* Corner c of a child in four keeps the edge opposite to c half, unless c is the corner that it shares with
 * its parent. */
void sl_mesh_hand_down_edges(sl_patches *mesh, uint32_t patch) {
    const sl_patch *parent = &mesh->patch[patch];
    for (int child = 0; child < 3; child++)
        for (int c = 0; c < 3; c++)
            if (c != child)
                sl_set_edge(&mesh->patch[parent->child + (uint32_t)child], c,
                            sl_edge_of(parent, c) == SL_EDGE_CLOSED ? SL_EDGE_CLOSED : SL_EDGE_UNTESTED);
}

sl_status sl_mesh_split(sl_patches *mesh, const sl_patch_place *place, sl_error *error) {
    sl_status status = sl_patch_split(mesh, place, error);
    if (status == SL_OK && !sl_patch_is_leaf(mesh, place->patch))
        sl_mesh_hand_down_edges(mesh, place->patch);
    return status;
}

void sl_mesh_weights_within(const sl_patch_place *place, float w1, float w2, float *leaf_w1, float *leaf_w2) {
    double a, b;
    sl_mesh_clamp_weights(w1, w2, &a, &b);
    sl_patch_local(place, a * SL_PATCH_DYADIC, b * SL_PATCH_DYADIC, &a, &b);
    *leaf_w1 = (float)a;
    *leaf_w2 = (float)b;
}

sl_patch_place sl_mesh_locate(const sl_patches *mesh, uint32_t face, float w1, float w2) {
    double a, b;
    sl_mesh_clamp_weights(w1, w2, &a, &b);
    return sl_patch_locate(mesh, face, a, b);
}

sl_mesh_point sl_mesh_point_at(const sl_primitives *primitives, sl_root_place place) {
    sl_lit_point at;
    sl_root_point_at(primitives, place.root, place.u, place.v, &at);
    if (at.triangle == SL_NO_INDEX) at.geometric_normal = at.normal;
    return (sl_mesh_point){at, place.root};
}

/* ---- edges ----------------------------------------------------------------------------------- */

typedef struct edge_point {
    uint32_t vertex;
    uint16_t u, v;
} edge_point;

static edge_point end_of(const sl_patches *mesh, const sl_patch_place *place, int corner) {
    corner %= 3;
    return (edge_point){sl_patch_corner(mesh, place->patch, corner), place->u[corner], place->v[corner]};
}

static edge_point middle_of(const sl_patches *mesh, uint32_t face, edge_point a, edge_point b) {
    sl_patch_place ends = {.root = face, .u = {a.u, b.u}, .v = {a.v, b.v}};
    sl_root_place at;
    bool is_there = sl_middle_place(&ends, 0, 1, &at);
    return (edge_point){is_there ? sl_vertex_find(mesh, at) : SL_NO_INDEX, at.u, at.v};
}

static bool is_known(const sl_patches *mesh, edge_point at) {
    return sl_mesh_state(mesh, at.vertex) == SL_VERTEX_KNOWN;
}

static bool middle_differs(const sl_patches *mesh, uint32_t face, edge_point a, edge_point b,
                           edge_point middle, const sl_edge_test *test) {
    const float unit = 1.0f / (float)SL_PATCH_DYADIC;
    float mean[3];
    if (!is_known(mesh, a) || !is_known(mesh, b) || !is_known(mesh, middle)) return true;
    for (int i = 0; i < mesh->settings.channels; i++)
        mean[i] = 0.5f * (sl_vertex_value(mesh, a.vertex)[i] + sl_vertex_value(mesh, b.vertex)[i]);
    return test->differs(test->context, face, (float)middle.u * unit, (float)middle.v * unit, mean,
                         sl_vertex_value(mesh, middle.vertex));
}

static bool any_differs(const sl_patches *mesh, uint32_t face, edge_point a, edge_point b, uint32_t only,
                        const sl_edge_test *test) {
    edge_point middle = middle_of(mesh, face, a, b);
    if (!sl_mesh_is_sampled(mesh, middle.vertex)) return false;
    if ((only == SL_NO_INDEX || only == middle.vertex) && middle_differs(mesh, face, a, b, middle, test))
        return true;
    if (only == middle.vertex || !is_known(mesh, middle) || !mesh->vertex[middle.vertex].halved) return false;
    return any_differs(mesh, face, a, middle, only, test) || any_differs(mesh, face, middle, b, only, test);
}

bool sl_mesh_edge_differs(const sl_patches *mesh, const sl_patch_place *leaf, int edge, uint32_t only,
                          const sl_edge_test *test) {
    return any_differs(mesh, leaf->root, end_of(mesh, leaf, edge + 1), end_of(mesh, leaf, edge + 2), only,
                       test);
}

sl_edge_state sl_mesh_test_edge(const sl_patches *mesh, const sl_patch_place *leaf, int edge,
                                const sl_edge_test *test) {
    for (int k = 1; k < 3; k++)
        if (!sl_mesh_is_sampled(mesh, end_of(mesh, leaf, edge + k).vertex)) return SL_EDGE_UNTESTED;
    if (!sl_mesh_is_sampled(mesh, sl_mesh_find_middle(mesh, leaf, edge))) return SL_EDGE_UNTESTED;
    return sl_mesh_edge_differs(mesh, leaf, edge, SL_NO_INDEX, test) ? SL_EDGE_SPLIT : SL_EDGE_CLOSED;
}

/* ---- samples that no longer hold -------------------------------------------------------------- */

/* REQUESTED, until all edges have been looked at. */
static bool is_forgotten(const sl_patches *mesh, uint32_t vertex) {
    return vertex != SL_NO_INDEX && sl_mesh_state(mesh, vertex) == SL_VERTEX_REQUESTED;
}

static void reopen(sl_patches *mesh, uint32_t patch) {
    sl_patch_place leaf = sl_patch_place_of(mesh, patch);
    for (int e = 0; e < 3; e++) {
        bool gone = is_forgotten(mesh, sl_mesh_find_middle(mesh, &leaf, e));
        for (int k = 1; k < 3; k++) gone |= is_forgotten(mesh, end_of(mesh, &leaf, e + k).vertex);
        if (gone) sl_set_edge(&mesh->patch[patch], e, SL_EDGE_UNTESTED);
    }
}

void sl_mesh_forget(sl_patches *mesh, const sl_mesh_check *check) {
    for (uint32_t v = 0; v < mesh->vertex_count; v++)
        if (mesh->vertex[v].references && sl_mesh_is_sampled(mesh, v) &&
            !check->holds(check->context, mesh, v))
            sl_mesh_set_state(mesh, v, SL_VERTEX_REQUESTED);
    for (uint32_t n = 0; n < mesh->patch_count; n++)
        if (sl_patch_is_alive(mesh, n) && sl_patch_is_leaf(mesh, n) && mesh->patch[n].flags & SL_PATCH_EDGES)
            reopen(mesh, n);
    for (uint32_t v = 0; v < mesh->vertex_count; v++)
        if (mesh->vertex[v].references && is_forgotten(mesh, v))
            sl_mesh_set_state(mesh, v, SL_VERTEX_UNKNOWN);
}

/* ---- fans ------------------------------------------------------------------------------------ */

/* The values of the leaf's corners; the mean of the known ones at those that are of no use. */
static bool read_corners(const sl_patches *mesh, const sl_patch_place *leaf, sl_mesh_fan *fan) {
    int known = 0;
    bool invalid[3];
    float sum[3] = {0.0f, 0.0f, 0.0f};
    for (int c = 0; c < 3; c++) {
        uint32_t vertex = fan->vertex[c] = sl_patch_corner(mesh, leaf->patch, c);
        if (!sl_mesh_is_sampled(mesh, vertex)) return false;
        invalid[c] = sl_mesh_state(mesh, vertex) == SL_VERTEX_INVALID;
        known += !invalid[c];
        for (int i = 0; i < fan->channels && !invalid[c]; i++)
            sum[i] += fan->value[c][i] = sl_vertex_value(mesh, vertex)[i];
    }
    for (int c = 0; c < 3 && known > 0; c++)
        for (int i = 0; i < fan->channels && invalid[c]; i++) fan->value[c][i] = sum[i] / (float)known;
    return known > 0;
}

bool sl_mesh_fan_make(const sl_patches *mesh, const sl_patch_place *leaf, bool hanging, sl_mesh_fan *fan) {
    fan->channels = mesh->settings.channels;
    if (!read_corners(mesh, leaf, fan)) return false;
    for (int i = 0; i < fan->channels; i++) {
        float first = fan->value[0][i];
        fan->centre[i] = first + ((fan->value[1][i] - first) + (fan->value[2][i] - first)) * (1.0f / 3.0f);
    }
    fan->count = hanging ? sl_patch_spokes(mesh, leaf, SL_FAN_LEVELS, SL_VERTEX_KNOWN, fan->spoke) : 0;
    for (uint32_t k = 0; k < fan->count; k++) {
        uint32_t vertex = fan->vertex[3 + k] = fan->spoke[k].vertex;
        fan->spoke[k].vertex = 3 + k;
        for (int i = 0; i < fan->channels; i++) fan->value[3 + k][i] = sl_vertex_value(mesh, vertex)[i];
    }
    return true;
}

bool sl_mesh_fan_shown(const sl_patches *mesh, sl_patch_place *place, bool hanging, sl_mesh_fan *fan) {
    while (!sl_mesh_fan_make(mesh, place, hanging, fan)) {
        uint32_t parent = sl_patch_parent(mesh, place->patch);
        if (parent == SL_NO_INDEX) return false;
        *place = sl_patch_place_of(mesh, parent);
    }
    return true;
}

static void fan_value(const sl_mesh_fan *fan, float w1, float w2, float *value) {
    static const uint32_t corner[3] = {0, 1, 2};
    const float(*of)[3] = fan->value;
    w1 = sl_clamp_unitf(w1);
    w2 = sl_clamp_unitf(w2);
    if (fan->count == 0) {
        for (int i = 0; i < fan->channels; i++)
            value[i] = of[0][i] + (w1 * (of[1][i] - of[0][i]) + w2 * (of[2][i] - of[0][i]));
        return;
    }
    sl_fan_place at = sl_fan_place_of(true, w1, w2);
    uint32_t end[2];
    float s = sl_fan_piece(3, corner, fan->count, fan->spoke, &at, end);
    for (int i = 0; i < fan->channels; i++)
        value[i] = sl_fan_value(fan->centre[i], at.out, s, of[end[0]][i], of[end[1]][i]);
}

bool sl_mesh_interpolate(const sl_patches *mesh, const sl_patch_place *leaf, float w1, float w2, bool hanging,
                         float *value) {
    sl_mesh_fan fan;
    if (!sl_mesh_fan_make(mesh, leaf, hanging, &fan)) return false;
    fan_value(&fan, w1, w2, value);
    return true;
}

bool sl_mesh_value(const sl_patches *mesh, uint32_t face, float w1, float w2, float *value) {
    float leaf_w1, leaf_w2;
    sl_patch_place leaf = sl_mesh_locate(mesh, face, w1, w2);
    if (leaf.patch == SL_NO_INDEX) return false;
    sl_mesh_weights_within(&leaf, w1, w2, &leaf_w1, &leaf_w2);
    return sl_mesh_interpolate(mesh, &leaf, leaf_w1, leaf_w2, true, value);
}
