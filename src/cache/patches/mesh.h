/* Patches as multi-mesh caching has them: triangles by themselves (sl_primitives_of_triangles()), whose
 * vertices are sampled before leaves are cut. A root is a face, a side of a triangle; edge i of a leaf is
 * opposite to its corner i. A vertex whose value is known and that lies in the middle of an edge counts for
 * interpolation on both sides of it, be the triangles there split or not: so there are no T-vertices, and no
 * step of colour along edges. */
#pragma once

#include "base/isa.h"
#include "cache/patches/patches.h"

enum { SL_MESH_DEPTH_MAX = 12 };

/* In sl_patch_vertex.evaluated. */
typedef enum sl_vertex_state {
    SL_VERTEX_UNKNOWN,
    SL_VERTEX_REQUESTED, /* someone is about to sample it */
    SL_VERTEX_KNOWN,
    SL_VERTEX_INVALID /* sampled, and of no use (inside other geometry, not finite): in each leaf the mean of
                         the leaf's known corners stands in */
} sl_vertex_state;
static inline sl_vertex_state sl_mesh_state(const sl_patches *mesh, uint32_t vertex) {
    return (sl_vertex_state)mesh->vertex[vertex].evaluated;
}
static inline void sl_mesh_set_state(sl_patches *mesh, uint32_t vertex, sl_vertex_state state) {
    sl_vertex_mark(&mesh->vertex[vertex], (uint32_t)state);
}
/* Tells whether there is such a vertex, and it was sampled. */
static inline bool sl_mesh_is_sampled(const sl_patches *mesh, uint32_t vertex) {
    return vertex != SL_NO_INDEX && sl_mesh_state(mesh, vertex) >= SL_VERTEX_KNOWN;
}

typedef enum sl_edge_state { SL_EDGE_UNTESTED, SL_EDGE_CLOSED, SL_EDGE_SPLIT } sl_edge_state;
static inline sl_edge_state sl_edge_of(const sl_patch *leaf, int edge) {
    return (sl_edge_state)(leaf->flags >> 2 * edge & 3u);
}
static inline void sl_set_edge(sl_patch *leaf, int edge, sl_edge_state state) {
    leaf->flags = (leaf->flags & ~(3u << 2 * edge)) | (uint32_t)state << 2 * edge;
}
enum { SL_ALL_EDGES_CLOSED = SL_EDGE_CLOSED | SL_EDGE_CLOSED << 2 | SL_EDGE_CLOSED << 4 };
static inline bool sl_all_edges_closed(const sl_patch *leaf) {
    return (leaf->flags & SL_PATCH_EDGES) == SL_ALL_EDGES_CLOSED;
}

/* Returns the vertex in the middle of an edge, made if there is none (UNKNOWN). SL_NO_INDEX: memory ended, or
 * the depth is reached. */
static inline uint32_t sl_mesh_middle(sl_patches *mesh, const sl_patch_place *place, int edge,
                                      sl_status *status, sl_error *error) {
    return sl_patch_edge_middle(mesh, place, (edge + 1) % 3, status, error);
}
/* Returns the same, if there is one. */
static inline uint32_t sl_mesh_find_middle(const sl_patches *mesh, const sl_patch_place *place, int edge) {
    sl_root_place at;
    bool is_there = sl_middle_place(place, (edge + 1) % 3, (edge + 2) % 3, &at);
    return is_there ? sl_vertex_find(mesh, at) : SL_NO_INDEX;
}
/* Cuts a leaf in four. Children's edges are untested, but halves of closed ones are closed. */
sl_status sl_mesh_split(sl_patches *mesh, const sl_patch_place *place, sl_error *error);
/* Closes the halves of a patch's closed edges, which were closed with them; its other children's edges are
 * untested then. */
void sl_mesh_hand_down_edges(sl_patches *mesh, uint32_t patch);

/* The test of an edge: `differs` tells whether an eye can tell the value at a point of a face from the mean
 * of what lies on either side of it. It is asked of the middle of the edge and its ends, and of the middles
 * of the edge's parts that have a value already since someone on the other side asked for it: an edge is
 * tested once, for both its sides. Otherwise a large leaf beside a small shadow would draw the shadow's
 * vertex on its edge as a spike to its own centre. Where one of the three is INVALID light ends somewhere
 * along the edge. */
typedef struct sl_edge_test {
    bool (*differs)(const void *context, uint32_t face, float w1, float w2, const float *mean,
                    const float *value);
    const void *context;
} sl_edge_test;
/* SL_EDGE_UNTESTED: an end or the middle was not sampled. */
sl_edge_state sl_mesh_test_edge(const sl_patches *mesh, const sl_patch_place *leaf, int edge,
                                const sl_edge_test *test);
/* Tells whether anything that was sampled on the edge differs. only: that middle alone; SL_NO_INDEX: all. */
bool sl_mesh_edge_differs(const sl_patches *mesh, const sl_patch_place *leaf, int edge, uint32_t only,
                          const sl_edge_test *test);

/* Forgets samples that no longer hold: their vertices are UNKNOWN, and edges of leaves on which one of them
 * lies UNTESTED. What was cut stays cut. None is REQUESTED. */
typedef struct sl_mesh_check {
    bool (*holds)(const void *context, const sl_patches *mesh, uint32_t vertex);
    const void *context;
} sl_mesh_check;
void sl_mesh_forget(sl_patches *mesh, const sl_mesh_check *check);

/* Returns the leaf that holds a point of a face, told by its weights of corners 1 and 2: those outside the
 * face are first moved onto it (NaN: 0). */
sl_patch_place sl_mesh_locate(const sl_patches *mesh, uint32_t face, float w1, float w2);
/* Moves weights of corners 1 and 2 into [0,1], together at most 1; NaN: 0. */
static inline void sl_mesh_clamp_weights(float w1, float w2, double *clamped1, double *clamped2) {
    const double a = sl_clamp_unit((double)w1), b = sl_clamp_unit((double)w2),
                 sum = a + b > 1.0 ? a + b : 1.0;
    *clamped1 = a / sum;
    *clamped2 = b / sum;
}
/* Gives a point's weights of a leaf's own corners 1 and 2. */
void sl_mesh_weights_within(const sl_patch_place *place, float w1, float w2, float *leaf_w1, float *leaf_w2);

/* Where a vertex lies in the world: what samplers need. */
typedef struct sl_mesh_point {
    sl_lit_point lit;          /* its geometric normal is the shading one where several faces meet */
    uint32_t face;             /* one of those that share it: the lowest */
} sl_mesh_point;
sl_mesh_point sl_mesh_point_at(const sl_primitives *primitives, sl_root_place place);
static inline sl_mesh_point sl_mesh_point_of(const sl_patches *mesh, uint32_t vertex) {
    return sl_mesh_point_at(mesh->primitives, mesh->vertex[vertex].place);
}
/* Moves a point on an edge into its face, at least `inwards` from all its edges unless the face is too small.
 */
void sl_step_inside(const sl_scene *scene, double inwards, sl_mesh_point *at);

/* The values of a leaf: linear between corners where no edge has a known middle; else a fan around the leaf's
 * centre: with b the smallest of the three weights, a point lies s = 1 - 3 b of the way from the centre to a
 * point of the edge opposite to that corner, and value = (1 - s) mean of the corners + s value on the edge,
 * which is piecewise linear between its known vertices (SL_FAN_LEVELS halvings deep, on either side of an
 * edge alike). */
enum { SL_FAN_LEVELS = 6, SL_FAN_VERTICES = 3 + 3 * ((1 << SL_FAN_LEVELS) - 1) };
typedef struct sl_mesh_fan {
    int channels;
    size_t count;                          /* spokes */
    /* the leaf's corners, then what hangs on its edges and is known: spokes name these by their number here
     */
    uint32_t vertex[SL_FAN_VERTICES];
    float value[SL_FAN_VERTICES][3];
    sl_fan_spoke spoke[SL_FAN_VERTICES - 3];
    float centre[3];
} sl_mesh_fan;
/* What a fan's values are made of, in the fan or where it is kept. */
typedef struct sl_fan_shown {
    int channels;
    size_t count;                          /* spokes */
    const float (*value)[3];               /* of the corners, then of the spokes */
    const sl_fan_spoke *spoke;
    float centre[3];
} sl_fan_shown;
static inline sl_fan_shown sl_mesh_fan_shows(const sl_mesh_fan *fan) {
    return (sl_fan_shown){fan->channels, fan->count, fan->value, fan->spoke,
                          {fan->centre[0], fan->centre[1], fan->centre[2]}};
}
/* hanging: false ignores what lies on edges. Where a corner is not known yet, or all are invalid: false. */
bool sl_mesh_fan_make(const sl_patches *mesh, const sl_patch_place *leaf, bool hanging, sl_mesh_fan *fan);
/* The same of the nearest of a patch and its ancestors that has one, as it is shown. */
bool sl_mesh_fan_shown(const sl_patches *mesh, sl_patch_place *place, bool hanging, sl_mesh_fan *fan);

/* The same for points side by side (fan_kernels.c). */
enum { SL_FAN_LANES = 16 };
/* Gives weights of a leaf's own corners at up to SL_FAN_LANES points of its face, and anything in the other
 * lanes. Returns how many of the first lie in the leaf for sure, and so are what sl_mesh_locate() finds
 * there: on its edges none but the first point, which is taken to. */
SL_KERNELS(size_t, sl_mesh_run, (const sl_patch_place *leaf, size_t count, const float *w1, const float *w2,
                                 float *leaf_w1, float *leaf_w2));
/* Gives all lanes' values, a row a channel. */
SL_KERNELS(void, sl_mesh_fan_values,
           (const sl_fan_shown *fan, const float *w1, const float *w2, float value[3][SL_FAN_LANES]));

/* The same for one point, by weights of the leaf's own corners. */
bool sl_mesh_interpolate(const sl_patches *mesh, const sl_patch_place *leaf, float w1, float w2, bool hanging,
                         float *value);
/* ... of the leaf that holds a point of a face. */
bool sl_mesh_value(const sl_patches *mesh, uint32_t face, float w1, float w2, float *value);
