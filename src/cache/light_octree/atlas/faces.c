/* Which faces share an edge. A scene's vertices are split by normal and texture coordinates, so it is
 * positions that say which corners meet: equal bits, equal point. Along an edge of two faces that run
 * opposite ways these are glued; where more meet, the flattest such pairs; all else is a border. */
#include "cache/light_octree/atlas/parts.h"

#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"

/* Below this height over its longest edge a face's normal is noise. */
#define SLIVER 1e-4
/* Faces that fold back on each other as sharply as this are two sides of a sheet, and never in one chart. */
#define FOLD (-0.9)

/* ---- points ---- */

static uint64_t position_hash(const uint32_t bits[3]) {
    uint64_t h = bits[0] * UINT64_C(0x9e3779b97f4a7c15) ^ bits[1] * UINT64_C(0xc2b2ae3d27d4eb4f) ^
                 bits[2] * UINT64_C(0x165667b19e3779f9);
    h ^= h >> 29;
    h *= UINT64_C(0xbf58476d1ce4e5b9);
    return h ^ h >> 32;
}

static void position_bits(const sl_scene *s, uint32_t vertex, uint32_t bits[3]) {
    bits[0] = sl_float_bits(s->position_x[vertex] + 0.0f); /* -0 and 0 are one place */
    bits[1] = sl_float_bits(s->position_y[vertex] + 0.0f);
    bits[2] = sl_float_bits(s->position_z[vertex] + 0.0f);
}

/* The first vertex at each vertex's position. */
static bool weld(const sl_scene *s, uint32_t *first_at) {
    size_t slots = 16;
    while (slots < 2 * s->vertex_count) slots *= 2;
    uint32_t *slot = sl_allocate(slots, sizeof *slot); /* vertex + 1 */
    if (!slot) return false;
    for (size_t v = 0; v < s->vertex_count; v++) {
        uint32_t bits[3], other[3];
        position_bits(s, (uint32_t)v, bits);
        size_t i = position_hash(bits) & (slots - 1);
        for (; slot[i]; i = (i + 1) & (slots - 1)) {
            position_bits(s, slot[i] - 1, other);
            if (!memcmp(bits, other, sizeof bits)) break;
        }
        if (!slot[i]) slot[i] = (uint32_t)v + 1;
        first_at[v] = slot[i] - 1;
    }
    sl_free(slot);
    return true;
}

/* ---- edges ---- */

typedef struct half_edge {
    uint32_t low, high, index;
} half_edge;

static int by_edge(const void *a, const void *b) {
    const half_edge *x = a, *y = b;
    if (x->high != y->high) return x->high < y->high ? -1 : 1;
    return (x->index > y->index) - (x->index < y->index);
}

/* Half-edges in order of their lower point, then of the higher one, then of their index. */
static half_edge *sorted_half_edges(const sl_atlas_faces *f, size_t points) {
    size_t count = 3 * f->count;
    half_edge *sorted = sl_allocate(count, sizeof *sorted);
    size_t *first = sl_allocate(points + 2, sizeof *first);
    if (sorted && first) {
        for (uint32_t h = 0; h < count; h++) {
            uint32_t a = f->point[h], b = f->point[sl_atlas_next(h)];
            first[(a < b ? a : b) + 2]++;
        }
        for (size_t p = 2; p < points + 2; p++) first[p] += first[p - 1];
        for (uint32_t h = 0; h < count; h++) {
            uint32_t a = f->point[h], b = f->point[sl_atlas_next(h)];
            half_edge e = {a < b ? a : b, a < b ? b : a, h};
            sorted[first[e.low + 1]++] = e;
        }
        for (size_t p = 0; p < points; p++)
            if (first[p + 1] - first[p] > 1)
                qsort(sorted + first[p], first[p + 1] - first[p], sizeof *sorted, by_edge);
    } else {
        sl_free(sorted);
        sorted = NULL;
    }
    sl_free(first);
    return sorted;
}

static void glue(sl_atlas_faces *f, uint32_t a, uint32_t b) {
    f->opposite[a] = b;
    f->opposite[b] = a;
}

/* Glues the flattest pair of faces at an edge that run opposite ways, then the flattest of the rest. */
static void glue_flattest(sl_atlas_faces *f, const half_edge *e, size_t count) {
    enum { MOST = 64 }; /* a fan of more pages than this stays open */
    if (count > MOST) return;
    for (;;) {
        double best = FOLD;
        uint32_t left = SL_NO_INDEX, right = SL_NO_INDEX;
        for (size_t i = 0; i < count; i++)
            for (size_t j = i + 1; j < count; j++) {
                uint32_t a = e[i].index, b = e[j].index;
                if (f->opposite[a] != SL_NO_INDEX || f->opposite[b] != SL_NO_INDEX ||
                    f->point[a] == f->point[b])
                    continue;
                double flatness = sl_dotd(f->normal[a / 3], f->normal[b / 3]);
                if (flatness > best) best = flatness, left = a, right = b;
            }
        if (left == SL_NO_INDEX) return;
        glue(f, left, right);
    }
}

/* Glues all half-edges. False: no memory. */
static bool glue_all(sl_atlas_faces *f, size_t points) {
    size_t count = 3 * f->count;
    half_edge *sorted = sorted_half_edges(f, points);
    if (!sorted) return false;
    memset(f->opposite, 0xff, count * sizeof *f->opposite);
    for (size_t i = 0, end; i < count; i = end) {
        for (end = i + 1;
             end < count && sorted[end].low == sorted[i].low && sorted[end].high == sorted[i].high;)
            end++;
        if (end - i > 1) glue_flattest(f, sorted + i, end - i);
    }
    sl_free(sorted);
    return true;
}

/* ---- faces ---- */

static void measure(sl_atlas_faces *f, uint32_t face) {
    sl_vec3d p[3];
    double longest = 0.0;
    for (size_t k = 0; k < 3; k++) p[k] = sl_atlas_corner(f, 3 * (size_t)face + k);
    for (size_t k = 0; k < 3; k++) {
        double length = sl_lengthd(sl_subd(p[(k + 1) % 3], p[k]));
        if (length > longest) longest = length;
    }
    sl_vec3d n = sl_crossd(sl_subd(p[1], p[0]), sl_subd(p[2], p[0]));
    double twice = sl_lengthd(n);
    f->area[face] = 0.5 * twice;
    f->normal[face] = twice > SLIVER * longest * longest ? sl_scaled(n, 1.0 / twice) : sl_v3d(0.0, 0.0, 0.0);
}

sl_status sl_atlas_faces_create(const sl_scene *scene, sl_atlas_faces *f, sl_error *error) {
    size_t count = scene->triangle_count;
    *f = (sl_atlas_faces){.scene = scene, .count = count};
    f->point = sl_allocate(3 * count, sizeof *f->point);
    f->opposite = sl_allocate(3 * count, sizeof *f->opposite);
    f->normal = sl_allocate(count, sizeof *f->normal);
    f->area = sl_allocate(count, sizeof *f->area);
    uint32_t *first_at = sl_allocate(scene->vertex_count, sizeof *first_at);
    bool good =
        f->point && f->opposite && f->normal && f->area && first_at && weld(scene, first_at);
    if (good) {
        for (size_t c = 0; c < 3 * count; c++) f->point[c] = first_at[scene->vertex[c % 3][c / 3]];
        for (uint32_t face = 0; face < count; face++) measure(f, face);
        good = glue_all(f, scene->vertex_count);
    }
    sl_free(first_at);
    if (good) return SL_OK;
    sl_atlas_faces_release(f);
    return sl_fail_memory(error, "an atlas's faces");
}

void sl_atlas_faces_release(sl_atlas_faces *f) {
    sl_free(f->point);
    sl_free(f->opposite);
    sl_free(f->normal);
    sl_free(f->area);
    *f = (sl_atlas_faces){0};
}
