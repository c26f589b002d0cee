/* For those who look on: the edges of leaves as marks, and the shares of vertices in what a place shows. */
#include "base/code_sort.h"
#include "base/memory.h"
#include "cache/patches/patches.h"

/* Two vertices, the lower one in the upper half: two leaves have the same. */
static uint64_t pair_of(uint32_t a, uint32_t b) {
    return a < b ? (uint64_t)a << 32 | b : (uint64_t)b << 32 | a;
}

static size_t list_edges(const sl_patches *p, const sl_edge_marking *how, sl_coded *edge) {
    size_t count = 0;
    for (uint32_t i = 0; i < p->patch_count; i++) {
        if (!sl_patch_is_alive(p, i) || !sl_patch_is_leaf(p, i) || !how->shows(how->context, i)) continue;
        int corners = sl_patch_corners(p, i);
        for (int c = 0; c < corners; c++)
            edge[count++] = (sl_coded){
                pair_of(sl_patch_corner(p, i, c), sl_patch_corner(p, i, (c + 1) % corners)), 0};
    }
    sl_sort_coded(edge, count);
    return count;
}

static void put(float to[3], sl_vec3 p) { to[0] = p.x, to[1] = p.y, to[2] = p.z; }

static sl_mark mark_of(const sl_patches *p, const sl_edge_marking *how, uint64_t pair) {
    uint32_t a = (uint32_t)(pair >> 32), b = (uint32_t)pair;
    sl_mark mark = {.kind = SL_MARK_SEGMENT};
    put(mark.at, sl_vertex_position(p, a));
    put(mark.to, sl_vertex_position(p, b));
    sl_rgb sum = sl_rgb_add(how->colour(how->context, a), how->colour(how->context, b));
    put(mark.colour, sl_v3(0.5f * sum.r, 0.5f * sum.g, 0.5f * sum.b));
    return mark;
}

sl_mark *sl_patches_edge_marks(const sl_patches *p, const sl_edge_marking *how, size_t *count) {
    sl_coded *edge = sl_allocate_unset(4 * p->leaves_alive, sizeof *edge);
    size_t edges = edge ? list_edges(p, how, edge) : 0;
    sl_mark *marks = edges ? sl_allocate(edges, sizeof *marks) : NULL;
    *count = 0;
    for (size_t i = 0; marks && i < edges; i++)
        if (i == 0 || edge[i].code != edge[i - 1].code) marks[(*count)++] = mark_of(p, how, edge[i].code);
    sl_free(edge);
    return marks;
}

/* ---- shares ---------------------------------------------------------------------------------- */

void sl_share_add(sl_vertex_shares *s, uint32_t vertex, double weight) {
    size_t at = 0;
    while (at < s->count && s->vertex[at] != vertex) at++;
    if (at == s->count) s->weight[s->count++] = 0.0;
    s->vertex[at] = vertex;
    s->weight[at] += weight;
}

/* Barycentric, and bilinear. */
static void corner_weights(bool triangle, double a, double b, double weight[4]) {
    a = sl_clamp_unit(a);
    b = sl_clamp_unit(b);
    double sum = triangle && a + b > 1.0 ? a + b : 1.0, x = a / sum, y = b / sum;
    weight[0] = triangle ? sl_clamp_unit(1.0 - x - y) : (1.0 - x) * (1.0 - y);
    weight[1] = triangle ? x : x * (1.0 - y);
    weight[2] = triangle ? y : x * y;
    weight[3] = (1.0 - x) * y;
}

/* Of a fan: from the centre, the mean of the corners, to a piece of an edge. */
sl_vertex_shares sl_leaf_shares(int corners, const uint32_t *corner, size_t count, const sl_fan_spoke *spoke,
                                double a, double b) {
    sl_vertex_shares s = {.count = 0};
    if (count == 0) {
        double weight[4];
        corner_weights(corners == 3, a, b, weight);
        for (int c = 0; c < corners; c++) sl_share_add(&s, corner[c], weight[c]);
        return s;
    }
    sl_fan_place place = sl_fan_place_of(corners == 3, (float)a, (float)b);
    uint32_t end[2];
    double along = (double)sl_fan_piece(corners, corner, count, spoke, &place, end), out = (double)place.out;
    for (int c = 0; c < corners; c++) sl_share_add(&s, corner[c], (1.0 - out) / corners);
    sl_share_add(&s, end[0], out * (1.0 - along));
    sl_share_add(&s, end[1], out * along);
    return s;
}
