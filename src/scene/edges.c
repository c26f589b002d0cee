#include "scene/edges.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

typedef struct placed_vertex {
    uint32_t bits[3], vertex;
} placed_vertex;

static int by_place(const void *a, const void *b) {
    const placed_vertex *p = a, *q = b;
    for (int k = 0; k < 3; k++) {
        if (p->bits[k] != q->bits[k]) return p->bits[k] < q->bits[k] ? -1 : 1;
    }
    return (p->vertex > q->vertex) - (p->vertex < q->vertex);
}

uint32_t *sl_scene_places(const sl_scene *s) {
    placed_vertex *placed = sl_allocate(s->vertex_count, sizeof *placed);
    uint32_t *first_at = sl_allocate(s->vertex_count, sizeof *first_at);
    for (uint32_t v = 0; placed && v < s->vertex_count; v++) {
        const float at[3] = {s->position_x[v] + 0.0f, s->position_y[v] + 0.0f, s->position_z[v] + 0.0f};
        memcpy(placed[v].bits, at, sizeof at);
        placed[v].vertex = v;
    }
    if (placed) qsort(placed, s->vertex_count, sizeof *placed, by_place);
    for (size_t i = 0, first = 0; placed && first_at && i < s->vertex_count; i++) {
        if (memcmp(placed[i].bits, placed[first].bits, sizeof placed[i].bits) != 0) first = i;
        first_at[placed[i].vertex] = placed[first].vertex;
    }
    if (!placed) sl_free(first_at), first_at = NULL;
    sl_free(placed);
    return first_at;
}

static int by_ends(const void *a, const void *b) {
    const sl_half_edge *x = a, *y = b;
    if (x->low != y->low) return x->low < y->low ? -1 : 1;
    if (x->high != y->high) return x->high < y->high ? -1 : 1;
    return (x->index > y->index) - (x->index < y->index);
}

sl_half_edge *sl_scene_half_edges(const sl_scene *s, const uint32_t *places) {
    const size_t count = 3 * s->triangle_count;
    sl_half_edge *edges = sl_allocate(count, sizeof *edges);
    for (uint32_t i = 0; edges && i < count; i++) {
        const uint32_t a = places[sl_half_edge_vertex(s, i, 0)], b = places[sl_half_edge_vertex(s, i, 1)];
        edges[i] = (sl_half_edge){a < b ? a : b, a < b ? b : a, i, a < b};
    }
    if (edges) qsort(edges, count, sizeof *edges, by_ends);
    return edges;
}

size_t sl_half_edges_of_one(const sl_half_edge *edges, size_t first, size_t count) {
    size_t end = first + 1;
    while (end < count && edges[end].low == edges[first].low && edges[end].high == edges[first].high) end++;
    return end;
}
