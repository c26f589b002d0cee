/* Quadtrees on surfaces: a tree of patches for each root, one patch cut in four, values at their shared
 * vertices. The shading cache keeps one of them (E and L_s), multi-mesh caching several over the same
 * triangles (F of one light, or radiance), each refined on its own.
 *
 *        2          A triangle is cut at the middles of its edges. Children 0, 1, 2 keep the corner of that
 *       / \         number; child 3 is the middle one, with its corners at the middles opposite to corners
 *      / 2 \        0, 1, 2. Corners of children are in the order of their parent's, so that each child is
 *     /_____\       its parent, halved and moved (child 3: turned by half a turn). A sliver's children are
 *    / \ 3 / \      no worse than itself.
 *   / 0 \ / 1 \
 *  0 ----*---- 1    A quadrilateral is cut at the middles of its edges and the centre; child i keeps corner
 *                   i. Corners go around counter-clockwise from (0, 0) in (u, v).
 *
 * Corners lie at whole numbers of 1/SL_PATCH_DYADIC in their root's parameters (u, v), so halves are exact. A
 * vertex is known by the place that stands for all that share it (sl_root_canonical()), from which its
 * position is computed: neighbours have it with the same bits.
 *
 *   patches.c          trees: roots, splits, dropped children, blocks that are used again; points in them
 *   patch_vertices.c   vertices: a hash table of places; counted by the splits and roots that asked for them
 *   patch_around.c     leaves around a vertex, vertices along a leaf's edge
 *   patch_extrapolate.c     vertices without light of their own
 *   patch_evict.c      children that nobody has seen for long, or that are below a pixel
 *   fan.h              where vertices lie on leaves' edges
 *   patch_marks.c      edges and shares as those who look on are shown them
 *   sample_points.c    where vertices are sampled
 *   screen_size.c      sizes in the picture
 *   mesh.h             values between vertices, for multi-mesh caching
 *   irradiance.h       a mesh for each light
 *   display/           drawn by the hardware; visible pixels by roots */
#pragma once

#include "cache/patches/fan.h"
#include "cache/patches/primitives.h"
#include "raster/raster.h"

/* Flags of a patch. Those below SL_PATCH_TRIANGLE and above SL_PATCH_ALIVE are multi-mesh's (mesh.h). */
enum {
    SL_PATCH_EDGES = 0x3f,       /* of triangles: what is known of edge i, at bits 2 i, 2 i + 1 (mesh.h) */
    SL_PATCH_TRIANGLE = 0x100,   /* three corners, not four */
    SL_PATCH_ALIVE = 0x200       /* the others below patch_count are not in use */
};

typedef struct sl_patch {
    uint32_t child;              /* first of four; SL_NO_INDEX: a leaf */
    /* of the id map that show it; in the shading cache in update `seen`: new children have a quarter each */
    uint32_t pixels;
    union {
        uint32_t seen;           /* shading cache: the last update in which the id map held it */
        float priority;          /* multi-mesh: of inner patches the largest of their children's */
    };
    uint32_t flags;
} sl_patch;

/* Shared by four children. Their corners are their parent's and the five vertices that its split made: the
 * middles of edges i (corner i to i + 1), and the centre. Triangles have three. */
typedef struct sl_patch_block {
    uint32_t parent;             /* SL_NO_INDEX: four roots */
    uint32_t root;               /* the one they belong to; of roots: index of the first in sl_patches.root */
    uint32_t middle[5];
} sl_patch_block;

enum { SL_VERTEX_NEVER = 0 };    /* evaluated: updates count from 1 */

typedef struct sl_patch_vertex {
    union {
        sl_root_place place;     /* the one that stands for all that share it */
        struct {
            uint32_t root;
            uint16_t u, v;
        };
    };
    uint32_t references : 2;     /* SL_REFERENCES_MANY: so many, or more */
    /* the update in which its value came, or SL_VERTEX_NEVER; in multi-mesh an sl_vertex_state (mesh.h) */
    uint32_t evaluated : 24;
    uint32_t asked : 1;          /* it is in the list of those that are to be shaded */
    uint32_t halved : 1;         /* some edge that ends in it has a vertex in its middle */
    /* it was evaluated, but has no light of its own (it lies inside other geometry, or no number came): its
     * value is that of those around it */
    uint32_t extrapolated : 1;
    /* it is shaded with many points on each light, as leaves of one pixel want it */
    uint32_t dense : 1;
    uint32_t is_dense : 1;       /* ... its value was */
    uint32_t is_quick : 1;       /* its value was shaded with few points on lights */
} sl_patch_vertex;

/* A vertex in the middle of an edge is that of two splits. Where so many ask for one, it is a root's corner,
 * as a rule, and those stay for good: it does. */
enum { SL_REFERENCES_MANY = 3 };

/* Where a value may be the mean of several sets of samples. */
typedef struct sl_vertex_sets {
    float variance;              /* of the mean of its channels' mean */
    uint32_t count;
} sl_vertex_sets;

/* A root that is there. */
typedef struct sl_wanted_root {
    uint32_t root, patch;
    uint32_t corner[4];          /* its vertices; [3] SL_NO_INDEX of triangles */
} sl_wanted_root;

typedef struct sl_patches_settings {
    /* of a vertex: F 1, radiance or E 3, E and then L_s towards the eye 6 */
    int channels;
    int max_depth;               /* at most SL_PATCH_DEPTH_MAX */
    bool shown;                  /* splits and drops hand on `seen` and `pixels` */
    bool sets;                   /* how many sets of samples, and their variance, is kept */
} sl_patches_settings;

typedef struct sl_patches {
    const sl_primitives *primitives;
    sl_patches_settings settings;
    sl_wanted_root *root;        /* in the order in which they were wanted: four to a block of patches */
    size_t root_count, root_capacity;
    uint32_t *root_slot;         /* hash of indices into root, at most three quarters full */
    size_t root_slots;
    sl_patch *patch;
    size_t patch_count, patch_capacity, patches_alive, leaves_alive;
    sl_patch_block *block;       /* one for four patches: sl_patch_block_of() */
    uint32_t first_free;         /* blocks that are not in use, by their patches' child */
    uint32_t last_root_block;    /* first patch of the block that new roots go to */
    sl_patch_vertex *vertex;
    float *value;                /* by vertex, so many channels each */
    sl_vertex_sets *sets;        /* by vertex; NULL: nobody asks, and all are one set */
    size_t vertex_count, vertex_capacity, vertices_alive;
    uint32_t first_free_vertex;  /* numbers not in use; each names the next in `root` */
    uint32_t *slot;              /* hash of vertices by their places, with linear probing */
    size_t slots;
    bool extrapolates;           /* some vertex is */
} sl_patches;

sl_status sl_patches_create(const sl_primitives *primitives, const sl_patches_settings *settings,
                            sl_patches **patches, sl_error *error);
void sl_patches_destroy(sl_patches *patches);
/* Makes *copy (NULL, or a copy of before, whose memory serves again) the same as the patches. After a
 * failure it can be destroyed, no more. */
sl_status sl_patches_copy(const sl_patches *patches, sl_patches **copy, sl_error *error);
/* Removes all roots, patches and vertices; the memory stays for the next ones. */
void sl_patches_clear(sl_patches *patches);
/* Returns the bytes of all that grows with the patches. */
size_t sl_patches_memory_bytes(const sl_patches *patches);

/* Returns the root's patch, made if there is none yet. SL_NO_INDEX with *status where memory ends. */
uint32_t sl_patches_root(sl_patches *patches, uint32_t root, sl_status *status, sl_error *error);
/* Returns the same, if there is one, or SL_NO_INDEX. */
uint32_t sl_patches_find_root(const sl_patches *patches, uint32_t root);
/* Patches are never moved; those below patch_count that are not in use are skipped by this. */
static inline bool sl_patch_is_alive(const sl_patches *p, uint32_t patch) {
    return p->patch[patch].flags & SL_PATCH_ALIVE;
}
static inline bool sl_patch_is_leaf(const sl_patches *p, uint32_t patch) {
    return p->patch[patch].child == SL_NO_INDEX;
}
static inline int sl_patch_corners(const sl_patches *p, uint32_t patch) {
    return p->patch[patch].flags & SL_PATCH_TRIANGLE ? 3 : 4;
}
static inline sl_patch_block *sl_patch_block_of(const sl_patches *p, uint32_t patch) {
    return &p->block[patch / 4];
}
static inline uint32_t sl_patch_parent(const sl_patches *p, uint32_t patch) {
    return sl_patch_block_of(p, patch)->parent;
}
static inline uint32_t sl_patch_root(const sl_patches *p, uint32_t patch) {
    const sl_patch_block *block = sl_patch_block_of(p, patch);
    return block->parent == SL_NO_INDEX ? p->root[block->root + patch % 4].root : block->root;
}
/* Returns the vertex at a corner of a patch: corner i of child i is its parent's, and so on upwards.
 * Triangles have SL_NO_INDEX for corner 3. */
static inline uint32_t sl_patch_corner(const sl_patches *p, uint32_t patch, int corner) {
    static const uint8_t triangle[4][4] = {{0, 0, 2, 3}, {0, 0, 1, 3}, {2, 1, 0, 3}, {1, 2, 0, 3}};
    static const uint8_t quad[4][4] = {{0, 0, 4, 3}, {0, 0, 1, 4}, {4, 1, 0, 2}, {3, 4, 2, 0}};
    uint32_t parent = sl_patch_parent(p, patch);
    for (; parent != SL_NO_INDEX && patch % 4 == (uint32_t)corner; parent = sl_patch_parent(p, patch))
        patch = parent;
    const sl_patch_block *block = sl_patch_block_of(p, patch);
    if (parent == SL_NO_INDEX) return p->root[block->root + patch % 4].corner[corner];
    return block->middle[p->patch[patch].flags & SL_PATCH_TRIANGLE ? triangle[patch % 4][corner]
                                                                   : quad[patch % 4][corner]];
}

static inline void sl_vertex_mark(sl_patch_vertex *v, uint32_t update) {
    v->evaluated = update & (UINT32_MAX >> 8);
}
static inline float *sl_vertex_value(const sl_patches *p, uint32_t vertex) {
    return p->value + (size_t)vertex * (size_t)p->settings.channels;
}
static inline sl_vec3 sl_vertex_position(const sl_patches *p, uint32_t vertex) {
    const sl_patch_vertex *v = &p->vertex[vertex];
    return sl_root_position(p->primitives, v->root, v->u, v->v);
}
/* Returns L_s of a vertex, towards the eye; NULL: none is kept. */
static inline float *sl_vertex_lobe(const sl_patches *p, uint32_t vertex) {
    return p->settings.channels > 3 ? sl_vertex_value(p, vertex) + 3 : NULL;
}

/* A patch with its corners' (u, v), in 1/SL_PATCH_DYADIC. */
typedef struct sl_patch_place {
    uint32_t patch, root;
    int depth, corners;
    uint16_t u[4], v[4];
} sl_patch_place;
/* Returns that of a root; SL_NO_INDEX in patch: it is not there. */
sl_patch_place sl_patch_root_place(const sl_patches *patches, uint32_t root);
/* Returns that of a patch, from its root downwards. */
sl_patch_place sl_patch_place_of(const sl_patches *patches, uint32_t patch);
sl_patch_place sl_patch_child_place(const sl_patches *patches, const sl_patch_place *parent, int child);
/* Returns the leaf that holds a point of a root. SL_NO_INDEX in patch: the root is not there. */
sl_patch_place sl_patch_locate(const sl_patches *patches, uint32_t root, double u, double v);
/* The same leaf's number, from a root's patch (or SL_NO_INDEX, which stays so) with so many corners; u and v
 * in [0, 1]. */
uint32_t sl_patch_leaf_at(const sl_patches *patches, uint32_t patch, int corners, double u, double v);
/* Returns which child of a patch, there or not, holds a point of its root. */
int sl_patch_child_at(const sl_patch_place *place, double u, double v);
/* Gives the weights of corners 1 and 2 of a triangle at a point of its root; of a quadrilateral how far it is
 * to corner 1, and to corner 3. u and v in 1/SL_PATCH_DYADIC. */
static inline void sl_patch_local(const sl_patch_place *place, double u, double v, double *a, double *b) {
    *a = (u - (double)place->u[0]) / ((double)place->u[1] - (double)place->u[0]);
    *b = (v - (double)place->v[0]) / ((double)place->v[place->corners - 1] - (double)place->v[0]);
}

/* Cuts a leaf in four (SL_OK and nothing at max_depth, or where a child would be degenerate: it stays a
 * leaf). Vertices that are new are not evaluated. Without memory nothing changes. */
sl_status sl_patch_split(sl_patches *patches, const sl_patch_place *place, sl_error *error);
/* Removes all below it. Its pixels become those of what was below. */
void sl_patch_drop_children(sl_patches *patches, uint32_t patch);

/* Returns the vertex at a place, or SL_NO_INDEX. */
uint32_t sl_vertex_find(const sl_patches *patches, sl_root_place place);
/* Returns the same, made where there is none; it stays for good. SL_NO_INDEX with *status: memory ended. */
uint32_t sl_vertex_make(sl_patches *patches, sl_root_place place, sl_status *status, sl_error *error);
/* Returns the middle of an edge of a leaf, made where there is none; it stays for good. Edge i is that from
 * corner i to the next. SL_NO_INDEX: memory ended, or the depth is reached. */
uint32_t sl_patch_edge_middle(sl_patches *patches, const sl_patch_place *place, int edge, sl_status *status,
                              sl_error *error);
/* Returns the middle of two places of a root. False: they are as near as dyadic fractions go. */
static inline bool sl_middle_place(const sl_patch_place *place, int a, int b, sl_root_place *middle) {
    uint32_t u = (uint32_t)place->u[a] + place->u[b], v = (uint32_t)place->v[a] + place->v[b];
    *middle = (sl_root_place){place->root, (uint16_t)(u / 2), (uint16_t)(v / 2)};
    return (u | v) % 2 == 0;
}

/* Gives the value at a point of a leaf from its corners: barycentric or bilinear. Where corners have never
 * been evaluated the nearest ancestor whose corners all are stands in; false: there is none. */
bool sl_patch_value(const sl_patches *patches, const sl_patch_place *leaf, double u, double v, float *value);
/* Gives the same where a vertex lies between others, and which they are; false: nothing around it has been
 * evaluated. */
bool sl_vertex_shares_around(const sl_patches *patches, uint32_t vertex, sl_vertex_shares *shares);
bool sl_vertex_surroundings(const sl_patches *patches, uint32_t vertex, float *value);

/* Lists the vertices on a leaf's edges, between their ends, that finer leaves beside it have: edge by edge (i
 * from corner i to i + 1), in order. levels: halvings of an edge that are looked at. state: only those whose
 * `evaluated` is that, or 0. spoke has room for SL_HANGING_MOST for each edge, which are all that are listed,
 * or for 2^levels - 1 if that is less. */
enum { SL_HANGING_MOST = 1024 };
size_t sl_patch_spokes(const sl_patches *patches, const sl_patch_place *leaf, int levels, uint32_t state,
                       sl_fan_spoke *spoke);

/* Tells whether it has none for sure, which is quick to say. */
bool sl_patch_has_no_spokes(const sl_patches *patches, uint32_t leaf);

/* Returns when the oldest of all that a leaf shows was evaluated: of its corners (SL_VERTEX_NEVER: one never
 * was), and of what hangs on its edges and was evaluated at all. */
uint32_t sl_leaf_oldest(const sl_patches *patches, uint32_t leaf);

/* Visits all leaves around a place of a root, of all roots that meet there; one may come twice. */
typedef void sl_leaf_visitor(sl_patches *patches, const sl_patch_place *leaf, void *context);
void sl_patches_visit_around(sl_patches *patches, sl_root_place place, sl_leaf_visitor *visit, void *context);

/* ---- screen_size.c ---- */

/* Homogeneous: x, y, distance from the near plane, w. Linear along a straight edge. */
typedef struct sl_clip_point {
    float at[4];
} sl_clip_point;
sl_clip_point sl_clip_point_of(const sl_view *view, sl_vec3 point);

/* The size of the part in the picture and beyond the near plane: pixels squared, and pixels of the longest
 * side. Both 0: nothing is left. */
typedef struct sl_screen_size {
    float area, edge;
} sl_screen_size;
/* Returns that of what the camera sees of a patch. */
sl_screen_size sl_patch_projected(const sl_patches *patches, const sl_patch_place *place,
                                  const sl_view *view);

/* ---- sample_points.c: where light is asked for, a little beside the vertices ---- */

/* Gives where a vertex is shaded: on its root's border it is moved inwards by 1/256 of the way to the middle,
 * as in the crease between two walls it would see half of what is behind the other. */
void sl_vertex_sample_point(const sl_patches *patches, uint32_t vertex, sl_lit_point *at);
/* Nudges the point of a vertex that lies inside a solid until it does not: by 1, by 5 and by 20 % of the
 * largest patches that have the vertex for a corner. False: it still does, and no light there is anybody's.
 */
bool sl_leave_solid(const sl_patches *patches, const sl_tracer *tracer, const sl_vec3 *eye, uint32_t vertex,
                    sl_lit_point *at, bool *moved, sl_counters *counters);
/* Marks a vertex as without light of its own: it was asked for, and inside other geometry, or no number came.
 */
void sl_patches_set_extrapolated(sl_patches *patches, uint32_t vertex);
/* Before a build of the display: they get their values anew from the corners around them that have light of
 * their own. */
void sl_patches_extrapolate(sl_patches *patches);

/* Evicts down to 90 % of `limit` patches where there are more: children of patches none of which was seen
 * since update `since`, and of patches that cover less than `small` pixels; oldest first, lower index on a
 * tie, from the leaves up. */
sl_status sl_patches_evict(sl_patches *patches, size_t limit, uint32_t since, double small,
                           sl_counters *counters, sl_error *error);

/* Returns the edges of the leaves that `shows` holds for as marks, each once, their colour the mean of what
 * `colour` gives to their ends; the caller's to free. NULL: there are none, or memory ended. */
typedef struct sl_edge_marking {
    bool (*shows)(const void *context, uint32_t leaf);
    sl_rgb (*colour)(const void *context, uint32_t vertex);
    const void *context;
} sl_edge_marking;
sl_mark *sl_patches_edge_marks(const sl_patches *patches, const sl_edge_marking *how, size_t *count);
