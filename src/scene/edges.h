/* Where triangles meet. A scene's vertices are split by normal and texture coordinates, so positions tell
 * which corners meet: equal bits, equal place (-0 is 0). */
#pragma once

#include "scene/scene.h"

/* A triangle's edge, from one corner to the next. */
typedef struct sl_half_edge {
    uint32_t low, high; /* its ends' places, the lower one first */
    uint32_t index;     /* 3 triangle + the corner where it begins */
    bool upwards;       /* it begins at the lower end */
} sl_half_edge;

/* All half-edges, by the places of their ends, those between the same two by their index. */
typedef struct sl_half_edges {
    const sl_scene *scene;
    size_t count;     /* 3 for each triangle */
    uint32_t *index;
    uint32_t *places; /* by vertex: the first one at its place */
} sl_half_edges;

/* False: no memory. To be released, whatever comes of it. */
bool sl_half_edges_list(const sl_scene *scene, sl_half_edges *edges);
void sl_half_edges_release(sl_half_edges *edges);
/* Returns the end of those that lie between the same places as the first. */
size_t sl_half_edges_of_one(const sl_half_edges *edges, size_t first);

/* Returns the vertex where a half-edge begins, or, one further, where it ends. */
static inline uint32_t sl_half_edge_vertex(const sl_scene *s, uint32_t index, uint32_t further) {
    return s->vertex[(index % 3 + further) % 3][index / 3];
}

static inline sl_half_edge sl_half_edge_of(const sl_half_edges *e, uint32_t index) {
    const uint32_t a = e->places[sl_half_edge_vertex(e->scene, index, 0)],
                   b = e->places[sl_half_edge_vertex(e->scene, index, 1)];
    return (sl_half_edge){a < b ? a : b, a < b ? b : a, index, a < b};
}
static inline sl_half_edge sl_half_edge_at(const sl_half_edges *e, size_t i) {
    return sl_half_edge_of(e, e->index[i]);
}
