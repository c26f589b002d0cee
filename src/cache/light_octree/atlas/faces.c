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

/* Finds the first vertex at each vertex's position. False: no memory. */
static bool weld(const sl_scene *s, uint32_t *first_at) {
    placed_vertex *placed = sl_allocate(s->vertex_count, sizeof *placed);
    if (!placed) return false;
    for (uint32_t v = 0; v < s->vertex_count; v++) { /* -0 and 0 are one place */
        const float at[3] = {s->position_x[v] + 0.0f, s->position_y[v] + 0.0f, s->position_z[v] + 0.0f};
        memcpy(placed[v].bits, at, sizeof at);
        placed[v].vertex = v;
    }
    qsort(placed, s->vertex_count, sizeof *placed, by_place);
    for (size_t i = 0, first = 0; i < s->vertex_count; i++) {
        if (memcmp(placed[i].bits, placed[first].bits, sizeof placed[i].bits) != 0) first = i;
        first_at[placed[i].vertex] = placed[first].vertex;
    }
    sl_free(placed);
    return true;
}

/* ---- edges ---- */

typedef struct half_edge {
    uint32_t low, high, index;
} half_edge;

static bool same_edge(const half_edge *a, const half_edge *b) {
    return a->low == b->low && a->high == b->high;
}

static int by_edge(const void *a, const void *b) {
    const half_edge *x = a, *y = b;
    if (x->low != y->low) return x->low < y->low ? -1 : 1;
    if (x->high != y->high) return x->high < y->high ? -1 : 1;
    return (x->index > y->index) - (x->index < y->index);
}

/* Glues the flattest pair of faces at an edge that run opposite ways, then the flattest of the rest. */
static void glue_flattest(sl_atlas_faces *f, const half_edge *e, size_t count) {
    enum { MOST = 64 }; /* a fan of more pages than this stays open */
    for (bool glued = count <= MOST; glued;) {
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
        glued = left != SL_NO_INDEX;
        if (glued) f->opposite[left] = right, f->opposite[right] = left;
    }
}

/* Glues all half-edges. False: no memory. */
static bool glue_all(sl_atlas_faces *f) {
    size_t count = 3 * f->count;
    half_edge *edge = sl_allocate(count, sizeof *edge);
    if (!edge) return false;
    for (uint32_t h = 0; h < count; h++) {
        uint32_t a = f->point[h], b = f->point[sl_atlas_next(h)];
        edge[h] = (half_edge){a < b ? a : b, a < b ? b : a, h};
        f->opposite[h] = SL_NO_INDEX;
    }
    qsort(edge, count, sizeof *edge, by_edge);
    for (size_t i = 0, end; i < count; i = end) {
        for (end = i + 1; end < count && same_edge(&edge[end], &edge[i]);) end++;
        if (end - i > 1) glue_flattest(f, edge + i, end - i);
    }
    sl_free(edge);
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
        good = glue_all(f);
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
