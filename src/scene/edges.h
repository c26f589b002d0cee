/* Where triangles meet. A scene's vertices are split by normal and texture coordinates, so positions tell
 * which corners meet: equal bits, equal place (-0 is 0). */
#ifndef SL_SCENE_EDGES_H
#define SL_SCENE_EDGES_H

#include "scene/scene.h"

/* A triangle's edge, from one corner to the next. */
typedef struct sl_half_edge {
    uint32_t low, high; /* its ends' places, the lower one first */
    uint32_t index;     /* 3 triangle + the corner where it begins */
    bool upwards;       /* it begins at the lower end */
} sl_half_edge;

/* Finds by vertex the first one at its place: vertex_count of them, which the caller frees. NULL: no memory.
 */
uint32_t *sl_scene_places(const sl_scene *scene);
/* Lists all half-edges, those between the same two places together, by their index: 3 triangle_count of them,
 * which the caller frees. NULL: no memory. */
sl_half_edge *sl_scene_half_edges(const sl_scene *scene, const uint32_t *places);
/* Returns the end of those that lie between the same places as the first, count at most. */
size_t sl_half_edges_of_one(const sl_half_edge *edges, size_t first, size_t count);

/* Returns the vertex where a half-edge begins, or, one further, where it ends. */
static inline uint32_t sl_half_edge_vertex(const sl_scene *s, uint32_t index, uint32_t further) {
    return s->vertex[(index % 3 + further) % 3][index / 3];
}

#endif
