/* Values between vertices: linear, or where vertices hang on a leaf's edges a fan around the leaf's centre,
 * so that both sides of an edge have the same values along it. Differences are added to a corner's value, so
 * that what is constant stays so in every bit. */
#include <math.h>
#include <string.h>

#include "cache/patches/fan.h"
#include "cache/patches/mesh.h"

/* The values of the leaf's corners; the mean of the known ones at those that are of no use. */
static bool read_corners(const sl_mesh *mesh, const sl_mesh_place *leaf, sl_mesh_fan *fan) {
    const uint32_t *vertex = mesh->node[leaf->node].vertex;
    int known = 0;
    float sum[3] = {0.0f, 0.0f, 0.0f};
    for (int c = 0; c < 3; c++) {
        if (mesh->state[vertex[c]] == SL_VERTEX_INVALID) continue;
        if (mesh->state[vertex[c]] != SL_VERTEX_KNOWN) return false;
        known++;
        for (int i = 0; i < mesh->channels; i++)
            sum[i] += fan->corner[c][i] = mesh->value[(size_t)vertex[c] * (size_t)mesh->channels + (size_t)i];
    }
    if (known == 0) return false;
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < mesh->channels && mesh->state[vertex[c]] == SL_VERTEX_INVALID; i++)
            fan->corner[c][i] = sum[i] / (float)known;
    return true;
}

/* Halves are looked at only where the middle is known, so both of an edge's sides find the same vertices.
 * Where no edge that ends in the middle has one nothing is on the halves: most often so, and quicker to tell
 * than by looking for it. */
static uint32_t known_at(const void *tree, sl_root_place place, bool *further) {
    const sl_mesh *mesh = tree;
    uint32_t vertex = sl_mesh_find_vertex(mesh, place.root, place.u, place.v);
    if (vertex == SL_NO_INDEX || mesh->state[vertex] != SL_VERTEX_KNOWN) return SL_NO_INDEX;
    *further = mesh->halved[vertex];
    return vertex;
}

void sl_mesh_edge_vertices(const sl_mesh *mesh, const sl_mesh_place *leaf, int edge, sl_edge_vertices *list) {
    int j = (edge + 1) % 3, k = (edge + 2) % 3;
    sl_hanging_walk walk = {mesh, known_at, list->vertex, list->at, 0, SL_FAN_EDGE - 2};
    sl_walk_hanging(&walk, (sl_root_place){leaf->face, leaf->p[j], leaf->q[j]},
                    (sl_root_place){leaf->face, leaf->p[k], leaf->q[k]}, 0, SL_FAN_EDGE - 1);
    list->count = (int)walk.count;
}

static void append(sl_mesh_fan *fan, int edge, int at, const float *value) {
    int n = fan->points[edge]++;
    fan->along[edge][n] = (float)at / (float)(SL_FAN_EDGE - 1);
    for (int i = 0; i < fan->channels; i++) fan->on_edge[edge][n][i] = value[i];
}

bool sl_mesh_fan_make(const sl_mesh *mesh, const sl_mesh_place *leaf, bool hanging, sl_mesh_fan *fan) {
    fan->channels = mesh->channels;
    fan->hanging = false;
    if (!read_corners(mesh, leaf, fan)) return false;
    for (int i = 0; i < fan->channels; i++) {
        float first = fan->corner[0][i];
        fan->centre[i] = first + ((fan->corner[1][i] - first) + (fan->corner[2][i] - first)) * (1.0f / 3.0f);
    }
    for (int edge = 0; edge < 3; edge++) {
        sl_edge_vertices list;
        list.count = 0;
        if (hanging) sl_mesh_edge_vertices(mesh, leaf, edge, &list);
        fan->hanging = fan->hanging || list.count > 0;
        fan->points[edge] = 0;
        append(fan, edge, 0, fan->corner[(edge + 1) % 3]);
        for (int i = 0; i < list.count; i++)
            append(fan, edge, list.at[i], &mesh->value[(size_t)list.vertex[i] * (size_t)mesh->channels]);
        append(fan, edge, SL_FAN_EDGE - 1, fan->corner[(edge + 2) % 3]);
    }
    return true;
}

static float clamp01(float x) { return x > 0.0f ? fminf(x, 1.0f) : 0.0f; }

/* Piecewise linear between an edge's vertices, t from the first one. */
static void edge_value(const sl_mesh_fan *fan, int edge, float t, float *value) {
    const float *along = fan->along[edge];
    int low = 0, high = fan->points[edge] - 1;
    while (high - low > 1) {
        int half = (low + high) / 2;
        if (along[half] <= t) low = half;
        else high = half;
    }
    float s = (t - along[low]) / (along[high] - along[low]);
    for (int i = 0; i < fan->channels; i++) {
        float a = fan->on_edge[edge][low][i], b = fan->on_edge[edge][high][i];
        value[i] = s <= 0.5f ? a + s * (b - a) : b + (1.0f - s) * (a - b); /* exact at both ends */
    }
}

void sl_mesh_fan_value(const sl_mesh_fan *fan, float w1, float w2, float *value) {
    w1 = clamp01(w1);
    w2 = clamp01(w2);
    if (!fan->hanging) {
        for (int i = 0; i < fan->channels; i++)
            value[i] = fan->corner[0][i] + (w1 * (fan->corner[1][i] - fan->corner[0][i]) +
                                            w2 * (fan->corner[2][i] - fan->corner[0][i]));
        return;
    }
    sl_fan_place at = sl_fan_place_of(true, w1, w2);
    float on_edge[3];
    edge_value(fan, (at.edge + 2) % 3, at.along, on_edge);
    for (int i = 0; i < fan->channels; i++)
        value[i] = fan->centre[i] + at.out * (on_edge[i] - fan->centre[i]);
}

bool sl_mesh_interpolate(const sl_mesh *mesh, const sl_mesh_place *leaf, float w1, float w2, bool hanging,
                         float *value) {
    sl_mesh_fan fan;
    if (!sl_mesh_fan_make(mesh, leaf, hanging, &fan)) return false;
    sl_mesh_fan_value(&fan, w1, w2, value);
    return true;
}

bool sl_mesh_value(const sl_mesh *mesh, uint32_t face, float w1, float w2, float *value) {
    float leaf_w1, leaf_w2;
    sl_mesh_place leaf = sl_mesh_locate(mesh, face, w1, w2, &leaf_w1, &leaf_w2);
    return leaf.node != SL_NO_INDEX && sl_mesh_interpolate(mesh, &leaf, leaf_w1, leaf_w2, true, value);
}
