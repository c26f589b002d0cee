#include "scene/edges.h"

#include "base/code_sort.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/random.h"

/* ---- places ---------------------------------------------------------------------------------- */

static bool is_one_place(const sl_scene *s, uint32_t a, uint32_t b) {
    const sl_vec3 p = sl_scene_position(s, a), q = sl_scene_position(s, b);
    return sl_float_bits(p.x + 0.0f) == sl_float_bits(q.x + 0.0f) &&
           sl_float_bits(p.y + 0.0f) == sl_float_bits(q.y + 0.0f) &&
           sl_float_bits(p.z + 0.0f) == sl_float_bits(q.z + 0.0f);
}

static uint64_t place_code(sl_vec3 p) {
    const uint64_t xy = (uint64_t)sl_float_bits(p.x + 0.0f) << 32 | sl_float_bits(p.y + 0.0f);
    return sl_hash64(sl_hash64(xy) ^ sl_float_bits(p.z + 0.0f));
}

/* Of those of one code, which nearly always are at one place, each has the first one that is where it is. */
static void find_first(const sl_scene *s, const sl_coded *run, size_t count, uint32_t *first_at) {
    for (size_t i = 0, k; i < count; i++) {
        for (k = 0; !is_one_place(s, run[k].item, run[i].item);) k++;
        first_at[run[i].item] = run[k].item;
    }
}

static uint32_t *find_places(const sl_scene *s) {
    const size_t count = s->vertex_count;
    sl_coded *placed = sl_allocate_unset(count, sizeof *placed);
    uint32_t *first_at = sl_allocate_unset(count, sizeof *first_at);
    for (uint32_t v = 0; placed && v < count; v++)
        placed[v] = (sl_coded){place_code(sl_scene_position(s, v)), v};
    if (placed) sl_sort_coded(placed, count);
    for (size_t first = 0, end; placed && first_at && first < count; first = end) {
        for (end = first + 1; end < count && placed[end].code == placed[first].code;) end++;
        find_first(s, placed + first, end - first, first_at);
    }
    if (!placed) sl_free(first_at), first_at = NULL;
    sl_free(placed);
    return first_at;
}

/* ---- half-edges ------------------------------------------------------------------------------ */

/* Lists them by their lower ends. first: where those of a place begin, for each vertex and one more. */
static void list_by_low(sl_half_edges *e, uint32_t *first) {
    const size_t vertices = e->scene->vertex_count;
    for (uint32_t i = 0; i < e->count; i++) first[sl_half_edge_of(e, i).low]++;
    for (size_t v = 1; v <= vertices; v++) first[v] += first[v - 1];
    for (uint32_t i = (uint32_t)e->count; i-- > 0;) e->index[--first[sl_half_edge_of(e, i).low]] = i;
}

static bool sort_by_high(sl_half_edges *e, const uint32_t *first) {
    uint32_t most = 0;
    for (size_t v = 0; v < e->scene->vertex_count; v++)
        most = first[v + 1] - first[v] > most ? first[v + 1] - first[v] : most;
    sl_coded *some = sl_allocate_unset(most, sizeof *some);
    for (size_t v = 0; some && v < e->scene->vertex_count; v++) {
        uint32_t *index = e->index + first[v];
        const uint32_t count = first[v + 1] - first[v];
        for (uint32_t i = 0; i < count; i++)
            some[i] = (sl_coded){sl_half_edge_of(e, index[i]).high, index[i]};
        sl_sort_coded(some, count);
        for (uint32_t i = 0; i < count; i++) index[i] = some[i].item;
    }
    sl_free(some);
    return some != NULL;
}

bool sl_half_edges_list(const sl_scene *s, sl_half_edges *e) {
    *e = (sl_half_edges){s, 3 * s->triangle_count, NULL, find_places(s)};
    uint32_t *first = e->places ? sl_allocate(s->vertex_count + 1, sizeof *first) : NULL;
    e->index = first ? sl_allocate_unset(e->count, sizeof *e->index) : NULL;
    if (e->index) list_by_low(e, first);
    const bool listed = e->index && sort_by_high(e, first);
    sl_free(first);
    return listed;
}

void sl_half_edges_release(sl_half_edges *e) {
    sl_free(e->index);
    sl_free(e->places);
    *e = (sl_half_edges){0};
}

size_t sl_half_edges_of_one(const sl_half_edges *e, size_t first) {
    const sl_half_edge one = sl_half_edge_at(e, first);
    for (size_t end = first + 1; end < e->count; end++) {
        const sl_half_edge next = sl_half_edge_at(e, end);
        if (next.low != one.low || next.high != one.high) return end;
    }
    return e->count;
}
