/* What a coarse mesh is made of, and the arrays in which gathers look up its colours.
 *
 * A face of level l is cut into n^2 coarse triangles, n = 2^l, by n - 1 lines along each of its sides:
 *
 *     2                  Lattice point (i, j) has weights i/n and j/n of the face's corners 1 and 2. Row j
 * holds 2 (n - j) - 1 triangles, upright ones
 *     |\                 (corners (i, j), (i+1, j), (i, j+1)) and between them those on their heads ((i+1,
 * j+1), (i, j+1), (i+1, j)):
 *     |_\                triangle number j (2n - j) + 2i + (1 if on its head).
 *     |\ |\              The corners of either kind are in the order of its own corners 0, 1, 2: weights
 * within it follow from the face's. 0-\|-\ 1
 *
 * A long face whose shortest edge is short enough (most of those that are cut at all: legs of tables, boards)
 * is cut across alone, into n slices along the two edges from its far corner, 0: that is, of the lattice's
 * points only (i, 0) and (0, i) are used. Slice i holds triangles 2i, with corners (i, 0), (i+1, 0), (0,
 * i+1), and (but for the first) 2i + 1, with corners (i, 0), (0, i+1), (0, i).
 *
 * Vertices are shared: one for each site in use, or for a cluster of them (coarse_clusters.c), 2^l - 1 on
 * each edge (l the highest level of the faces along it), and those inside a face. */
#ifndef SL_MULTI_MESH_COARSE_TABLES_H
#define SL_MULTI_MESH_COARSE_TABLES_H

#include "cache/multi_mesh/gather.h"

enum {
    SL_COARSE_ABSENT = 0xff, /* level of a face that is not in the coarse mesh */
    SL_COARSE_FLOATS = 12 /* of a coarse triangle: colour at its corner 0, differences of those at corners 1
                             and 2 from it; three to spare */
};

/* The first coarse triangles stand for faces that are absent and for what lies beyond all faces. */
enum { SL_COARSE_BLACK, SL_COARSE_NOTHING, SL_COARSE_FIRST };

/* By face: where its coarse triangles begin, and n, or -n where it is cut into slices. */
typedef struct sl_coarse_face {
    int32_t first, rows;
} sl_coarse_face;

struct sl_coarse {
    const sl_scene *scene;
    const sl_topology *topology;
    float edge;                /* as long as edges may be where they need not be finer */
    uint8_t *level;            /* by face, or SL_COARSE_ABSENT */
    /* by scene triangle: its lattice's corner k is its own corner (k + turn) % 3 */
    uint8_t *turn;
    uint8_t *edge_level;       /* by edge */
    uint32_t *site_vertex;     /* by site, or SL_NO_INDEX; clusters of sites have one */
    uint32_t *edge_vertex;     /* by edge: the first of those on it, counted from its lower site */
    uint32_t *inner_vertex;    /* by face: the first of those inside it */
    size_t vertex_count;
    sl_coarse_vertex *vertex;
    sl_rgb *value;             /* U_dd by vertex */
    uint8_t *valid;            /* 0: what was set was not a number */
    size_t triangle_count;     /* coarse ones */
    sl_coarse_face *face;      /* by face; two more for nothing, as if that were one more scene triangle */
    sl_rgb *reflectance;       /* by coarse triangle: k_d, the mean of its texture */
    bool reflectance_known;
    float *colour;             /* by coarse triangle, SL_COARSE_FLOATS each */
    sl_rgb *block_brightest;   /* by block of SL_COARSE_BLOCK faces */
    sl_rgb brightest;
};

enum { SL_COARSE_BLOCK = 512 };

/* Edges where light differs, to others: two levels. */
#define SL_COARSE_FINER 0.25

/* The site that stands for each: itself, or, where all faces about it are small (not cut), one of those in
 * the same cell of a grid and with much the same normal (coarse_clusters.c). */
sl_status sl_coarse_cluster(const sl_coarse *coarse, double cell, uint32_t *stand_in, sl_error *error);

/* Where light is asked for. */
sl_status sl_coarse_leave_borders(sl_coarse *coarse, sl_error *error);

/* The vertex at lattice point (i, j) of a face that is in the mesh. */
uint32_t sl_coarse_lattice_vertex(const sl_coarse *coarse, uint32_t face, int i, int j);

static inline int sl_coarse_rows(const sl_coarse *coarse, uint32_t face) {
    int rows = coarse->face[face].rows;
    return rows < 0 ? -rows : rows;
}
static inline bool sl_coarse_is_sliced(const sl_coarse *coarse, uint32_t face) {
    return coarse->face[face].rows < 0;
}
/* Returns the number of a face's coarse triangles; of slices the second one stands for none. */
static inline int sl_coarse_triangles(const sl_coarse *coarse, uint32_t face) {
    int n = sl_coarse_rows(coarse, face);
    return sl_coarse_is_sliced(coarse, face) ? 2 * n : n * n;
}

/* A coarse triangle of a face: its lattice corners. */
typedef struct sl_coarse_place {
    int i[3], j[3];
} sl_coarse_place;
static inline sl_coarse_place sl_coarse_place_of(int i, int j, int on_head) {
    if (on_head) return (sl_coarse_place){{i + 1, i, i + 1}, {j + 1, j + 1, j}};
    return (sl_coarse_place){{i, i + 1, i}, {j, j, j + 1}};
}
static inline sl_coarse_place sl_coarse_slice_place(int i, int second) {
    if (second) return (sl_coarse_place){{i, 0, 0}, {0, i + 1, i}};
    return (sl_coarse_place){{i, i + 1, 0}, {0, 0, i + 1}};
}

/* Where lattice point (u, v) of n rows lies: the triangle's number, and the weights of its corners 1 and 2.
 */
static inline int sl_coarse_in_lattice(float u, float v, int n, float *a, float *b) {
    int j = (int)v;
    j = j < n - 1 ? j : n - 1;
    int last = n - 1 - j, i = (int)u;
    i = i < last ? i : last;
    float x = u - (float)i, y = v - (float)j;
    int on_head = (x + y > 1.0f) & (i < last);
    *a = on_head ? 1.0f - x : x;
    *b = on_head ? 1.0f - y : y;
    return j * (2 * n - j) + 2 * i + on_head;
}

/* The same in slices: f of the way from edge (i, 0) to (0, i) to the next one. */
static inline int sl_coarse_in_slices(float u, float v, int n, float *a, float *b) {
    int i = (int)(u + v);
    i = i < n - 1 ? i : n - 1;
    float low = (float)i, f = u + v - low, across = v / (low + 1.0f), along = f - across;
    int second = (along < 0.0f) & (i > 0);
    float back = (v - f * (low + 1.0f)) / (low > 0.0f ? low : 1.0f);
    along = along > 0.0f ? along : 0.0f;
    back = back > 0.0f ? back : 0.0f;
    *a = second ? f : along;
    *b = second ? back : across;
    return 2 * i + second;
}

/* Weights of the lattice's corners 1 and 2. */
static inline int sl_coarse_locate(float w1, float w2, int rows, float *a, float *b) {
    int n = rows < 0 ? -rows : rows;
    float u = w1 * (float)n, v = w2 * (float)n, a1, b1, a2, b2;
    int lattice = sl_coarse_in_lattice(u, v, n, &a1, &b1), slices = sl_coarse_in_slices(u, v, n, &a2, &b2);
    *a = rows < 0 ? a2 : a1;
    *b = rows < 0 ? b2 : b1;
    return rows < 0 ? slices : lattice;
}

#endif
