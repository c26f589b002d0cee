/* A mesh over all faces, refined on its own (the multi-mesh paper keeps several of them over the same
 * triangles): a quadtree of triangles for each face, the sampled values at their corners. A face is a side of
 * a triangle. Vertices are shared: a vertex is known by the place that stands for all of its places in faces
 * (primitives.h), from which its position is computed, so neighbours have it with the same bits.
 *
 * Values live in vertices: `channels` floats each (irradiance from one light: 1; colours: 3). A vertex whose
 * value is known and that lies in the middle of an edge counts for interpolation on both sides of it, be the
 * triangles there split or not: so there are no T-vertices, and no step of colour along edges.
 *
 *   mesh.c              places, split, collapse
 *   mesh_nodes.c        memory of nodes; roots
 *   mesh_vertices.c     where vertices lie (places.h: how they are found)
 *   mesh_interpolate.c  values between vertices
 *   mesh_neighbours.c   the other side of an edge */
#ifndef SL_PATCHES_MESH_H
#define SL_PATCHES_MESH_H

#include "cache/patches/dyadic.h"
#include "cache/patches/places.h"

enum {
    SL_MESH_DEPTH_MAX = 12,
    SL_MESH_DYADIC = SL_PATCH_DYADIC, /* what barycentrics of vertices are multiples of 1/ of */
    SL_MESH_SLIVER = 2000000000
};
#define SL_MESH_ROOT 0x80000000u

typedef enum sl_vertex_state {
    SL_VERTEX_UNKNOWN,
    SL_VERTEX_REQUESTED, /* someone is about to sample it */
    SL_VERTEX_KNOWN,
    SL_VERTEX_INVALID /* sampled, and of no use (inside other geometry, not finite): in each leaf the mean of
                         the leaf's known corners stands in */
} sl_vertex_state;

/* Edge states, two bits each in flags: edge i is opposite to corner i. */
typedef enum sl_edge_state { SL_EDGE_UNTESTED, SL_EDGE_CLOSED, SL_EDGE_SPLIT } sl_edge_state;
enum {
    SL_NODE_EDGES = 0x3f,  /* three edge states: edge i at bits 2 i, 2 i + 1 */
    SL_NODE_TAKEN = 0x40,  /* chosen for a batch that is not done yet */
    SL_NODE_DIRTY = 0x80,  /* its pixels are to be drawn again */
    SL_NODE_SMALL = 0x800, /* meets the size criterion in the view as it stands (displayed meshes) */
    /* a node above it is closed and small there: only another view asked for more */
    SL_NODE_SETTLED = 0x1000,
    SL_NODE_TESTED_SHIFT = 16 /* the upper half: of leaves with closed edges sl_mesh_tested_size() or
                                 sl_mesh_probed_size(), of others sl_mesh_minor() */
};

typedef struct sl_mesh_node {
    uint32_t child;            /* first of its children, which lie one after another; SL_NO_INDEX: a leaf */
    uint32_t parent;           /* or SL_MESH_ROOT + its face; SL_NO_INDEX: it is free */
    uint32_t vertex[3];
    /* of a leaf: how much it matters to the eye; of others the largest of their children's */
    float priority;
    uint32_t pixels;           /* of the id map that show it (displayed meshes) */
    uint32_t flags;
} sl_mesh_node;

/* A node's size in pixels when it collapsed: it is not opened again before it is twice that; 0: it never did.
 * The upper half of a float's bits. */
float sl_mesh_tested_size(const sl_mesh_node *node);
void sl_mesh_set_tested_size(sl_mesh_node *node, float size);
/* Returns the size up to which a leaf with closed edges need not be probed again (displayed.h): as it was
 * when it was probed, or twice what it was when it collapsed; 0: it is yet to be probed. */
float sl_mesh_probed_size(const sl_mesh_node *node);
void sl_mesh_set_probed_size(sl_mesh_node *node, float size);
/* Of a leaf whose edges are not all closed: how many pixels it had when a picture was done without a look
 * into it; 0: it never was. */
static inline uint32_t sl_mesh_minor(const sl_mesh_node *node) { return node->flags >> SL_NODE_TESTED_SHIFT; }
static inline void sl_mesh_set_minor(sl_mesh_node *node, uint32_t pixels) {
    node->flags = (node->flags & 0xffffu) | pixels << SL_NODE_TESTED_SHIFT;
}

typedef struct sl_mesh {
    const sl_primitives *primitives; /* triangles, each by itself */
    int channels, max_depth;
    /* hash of roots by their faces, at most three quarters full: most views show few of a scene's faces */
    uint32_t *root;
    size_t root_count, root_slots;
    sl_mesh_node *node;
    /* node_count: the highest ever used; those that collapse leave are used again first */
    size_t node_count, node_capacity;
    size_t free_nodes;
    uint32_t first_free;       /* chain of free blocks, through node.child */
    size_t vertex_count, vertex_capacity;
    sl_root_place *place;      /* by vertex: the one that stands for all that share it */
    uint8_t *halved;           /* whether any edge that ends in it has a vertex in its middle */
    float *value;              /* vertex_count x channels */
    uint8_t *state;            /* sl_vertex_state */
    sl_place_table table;      /* of places, at most three quarters full */
    size_t leaf_count;         /* of all roots */
} sl_mesh;

sl_status sl_mesh_create(const sl_primitives *primitives, int channels, int max_depth, sl_mesh **mesh,
                         sl_error *error);
void sl_mesh_destroy(sl_mesh *mesh);
size_t sl_mesh_memory_bytes(const sl_mesh *mesh);
/* No roots, nodes and vertices any more; the memory stays for the next ones. */
void sl_mesh_clear(sl_mesh *mesh);

/* Returns the face's root, made if there is none yet; its vertices are UNKNOWN if they are new. SL_NO_INDEX
 * with *status where memory ends. */
uint32_t sl_mesh_root(sl_mesh *mesh, uint32_t face, sl_status *status, sl_error *error);
static inline bool sl_mesh_is_leaf(const sl_mesh *mesh, uint32_t node) {
    return mesh->node[node].child == SL_NO_INDEX;
}
/* SL_NO_INDEX: it is a root. */
static inline uint32_t sl_mesh_parent(const sl_mesh *mesh, uint32_t node) {
    uint32_t parent = mesh->node[node].parent;
    return parent & SL_MESH_ROOT ? SL_NO_INDEX : parent;
}
static inline bool sl_mesh_is_root(const sl_mesh *mesh, uint32_t node) {
    uint32_t parent = mesh->node[node].parent;
    return (parent & SL_MESH_ROOT) && parent != SL_NO_INDEX;
}
/* SL_NO_INDEX: the face has no root yet. */
uint32_t sl_mesh_root_of(const sl_mesh *mesh, uint32_t face);
/* Tells whether a number below node_count is a node as the mesh stands, not free: for loops over all of them.
 */
static inline bool sl_mesh_is_used(const sl_mesh *mesh, uint32_t node) {
    return mesh->node[node].parent != SL_NO_INDEX;
}

/* A node with where it lies: what walks hand on, so that nodes need not hold it. Corner i's weights of the
 * face's corners 1 and 2 are p[i], q[i] in 1/SL_MESH_DYADIC. */
typedef struct sl_mesh_place {
    uint32_t node, face;
    int depth;
    uint16_t p[3], q[3];
} sl_mesh_place;
sl_mesh_place sl_mesh_root_place(const sl_mesh *mesh, uint32_t face);
sl_mesh_place sl_mesh_child_place(const sl_mesh *mesh, const sl_mesh_place *parent, int child);
/* From any node, upwards and down again. */
sl_mesh_place sl_mesh_place_of(const sl_mesh *mesh, uint32_t node);
/* The leaf that holds a point, and the point's weights of the leaf's own corners 1 and 2. SL_NO_INDEX in
 * node: the face has no root. */
/* Points on borders belong to the lower child; weights outside the face are first moved onto it (NaN: 0). */
sl_mesh_place sl_mesh_locate(const sl_mesh *mesh, uint32_t face, float w1, float w2, float *leaf_w1,
                             float *leaf_w2);
/* A point's weights of a node's own corners 1 and 2, from those of the face's. Not rounded but at the end. */
void sl_mesh_weights_within(const sl_mesh_place *place, float w1, float w2, float *leaf_w1, float *leaf_w2);

/* Returns the vertex in the middle of edge i of a node; made if there is none (UNKNOWN). SL_NO_INDEX: memory
 * ended, or the depth is reached. */
uint32_t sl_mesh_middle(sl_mesh *mesh, const sl_mesh_place *place, int edge, sl_status *status,
                        sl_error *error);
/* Returns the same, if there is one. */
uint32_t sl_mesh_find_middle(const sl_mesh *mesh, const sl_mesh_place *place, int edge);
/* Returns a vertex by a place within a face (weights in 1/SL_MESH_DYADIC), made if there is none. */
uint32_t sl_mesh_vertex_at(sl_mesh *mesh, uint32_t face, uint32_t p, uint32_t q, sl_status *status,
                           sl_error *error);
/* Returns the same, if there is one. */
uint32_t sl_mesh_find_vertex(const sl_mesh *mesh, uint32_t face, uint32_t p, uint32_t q);

/* Cuts a leaf in four; children are leaves with all edges untested, but for what is
 * left of closed edges, which are not tested again: state CLOSED. At max_depth, and where a child would have
 * no area (coordinates end, the triangle is degenerate), it returns SL_OK with nothing done: the node stays a
 * leaf. Node pointers move. */
sl_status sl_mesh_split(sl_mesh *mesh, const sl_mesh_place *place, sl_error *error);
/* Children that are all leaves go; vertices and their values stay. */
void sl_mesh_collapse(sl_mesh *mesh, uint32_t node);

/* Where a vertex lies in the world: what samplers need. */
typedef struct sl_mesh_point {
    sl_vec3 position;
    sl_vec3 normal;            /* shading, unit, on the face's side */
    sl_vec3 geometric_normal;  /* of the face for vertices inside one; else as `normal` */
    uint32_t triangle;         /* SL_NO_INDEX where several meet */
    uint32_t face;             /* one of those that share it: the lowest */
} sl_mesh_point;
static inline bool sl_mesh_point_in_solid(const sl_primitives *primitives, const sl_tracer *tracer,
                                          const sl_mesh_point *at, sl_counters *counters) {
    return sl_solids_hold(primitives->solids, tracer, at->position, at->geometric_normal, at->triangle, NULL,
                          counters);
}
void sl_mesh_point_at(const sl_primitives *primitives, sl_root_place place, sl_mesh_point *point);
void sl_mesh_point_of(const sl_mesh *mesh, uint32_t vertex, sl_mesh_point *point);
/* Returns the middle of a leaf. */
static inline sl_root_place sl_mesh_leaf_middle(const sl_mesh_place *leaf) {
    return (sl_root_place){leaf->face, (uint16_t)((leaf->p[0] + leaf->p[1] + leaf->p[2]) / 3),
                           (uint16_t)((leaf->q[0] + leaf->q[1] + leaf->q[2]) / 3)};
}
static inline sl_root_place sl_mesh_face_middle(uint32_t face) {
    return (sl_root_place){face, SL_MESH_DYADIC / 3, SL_MESH_DYADIC / 3};
}
/* A vertex, moved towards the middle of a leaf that has it by a share of the way (0.01, 0.05, 0.2): where it
 * is asked for when it lies inside other geometry. */
void sl_mesh_point_nudged(const sl_mesh *mesh, uint32_t vertex, sl_root_place middle, double share,
                          sl_mesh_point *point);

/* The value at a point of a leaf (weights of its corners 1 and 2), `channels` floats. Linear between corners
 * where no edge has a known middle; else a fan around the leaf's centre: with b the smallest of the three
 * weights, the point lies s = 1 - 3 b of the way from the centre to a point of the edge opposite to that
 * corner, and value = (1 - s) mean of the corners + s value on the edge, which is piecewise linear between
 * its known vertices. hanging: false ignores them. Where a corner is not known yet, or all are invalid:
 * false, and nothing is written. */
bool sl_mesh_interpolate(const sl_mesh *mesh, const sl_mesh_place *leaf, float w1, float w2, bool hanging,
                         float *value);
/* The same for many points of one leaf: the known vertices on its edges are looked up once (SL_FAN_LEVELS
 * halvings deep, on either side of an edge alike). */
enum { SL_FAN_LEVELS = 6, SL_FAN_EDGE = (1 << SL_FAN_LEVELS) + 1 };
typedef struct sl_mesh_fan {
    int channels;
    bool hanging;                          /* any edge has a known middle */
    float corner[3][3], centre[3];         /* by corner, by channel */
    /* on edge i, ends included, from corner i + 1 to corner i + 2 (mod 3) */
    int points[3];
    float along[3][SL_FAN_EDGE];           /* 0 to 1 */
    float on_edge[3][SL_FAN_EDGE][3];
} sl_mesh_fan;
/* The known vertices between the ends of edge i of a leaf that make its fan, from corner i + 1 on, and where
 * they are in 1/2^SL_FAN_LEVELS. */
typedef struct sl_edge_vertices {
    int count;
    uint32_t vertex[SL_FAN_EDGE - 2];
    uint16_t at[SL_FAN_EDGE - 2];
} sl_edge_vertices;
void sl_mesh_edge_vertices(const sl_mesh *mesh, const sl_mesh_place *leaf, int edge, sl_edge_vertices *list);
bool sl_mesh_fan_make(const sl_mesh *mesh, const sl_mesh_place *leaf, bool hanging, sl_mesh_fan *fan);
void sl_mesh_fan_value(const sl_mesh_fan *fan, float w1, float w2, float *value);
/* sl_mesh_locate() and sl_mesh_interpolate(). */
bool sl_mesh_value(const sl_mesh *mesh, uint32_t face, float w1, float w2, float *value);

/* Lists leaves that touch edge i of a node on its other side, or end in it: those whose pixels change when
 * the edge's middle becomes known. At most `room`; returns how many there are. */
size_t sl_mesh_neighbours(const sl_mesh *mesh, const sl_mesh_place *place, int edge, uint32_t *leaf,
                          size_t room);

#endif
