/* The patch hierarchy: a tree of patches for each root, one in four, shading at their shared vertices,
 * computed lazily.
 *
 *   patches.c          trees: roots, splits, dropped children, blocks that are used again
 *   patch_vertices.c   vertices: shared inside a root by where they lie, and between roots along edges where
 *                      position, normal and material agree (places.h: how they are found)
 *   patch_size.c       sizes in the picture
 *   patch_around.c     leaves around a vertex, vertices along a leaf's edge
 *   patch_borrow.c     vertices without light of their own
 *   patch_evict.c      ageing: children that nobody has seen for long, or that are below a pixel, go when
 *                      there are too many
 *
 * dyadic.h has how patches are cut. Vertices are counted by the splits (and roots) that asked for them: the
 * last one to go takes its vertex with it. */
#ifndef SL_PATCHES_PATCHES_H
#define SL_PATCHES_PATCHES_H

#include "cache/patches/places.h"
#include "cache/patches/screen_size.h"

enum {
    SL_PATCH_LEVEL = 0xf,        /* depth below the root */
    SL_PATCH_TRIANGLE = 0x10,    /* three corners, not four */
    SL_PATCH_DIRTY = 0x20,       /* its display arrays are to be made again */
    SL_PATCH_CHANGING = 0x40,    /* it belongs to an object whose shading is changing */
    SL_PATCH_ALIVE = 0x80        /* the others below patch_count are not in use */
};

typedef struct sl_patch {
    uint32_t child;              /* first of four; SL_NO_INDEX: a leaf */
    /* the last update in which the id map held it (of inner patches: one below it) */
    uint32_t seen;
    /* ... and how many pixels then; new children: the parent's, and a quarter of its pixels */
    uint32_t pixels;
} sl_patch;

/* Shared by four children. Their corners are their parent's and the five vertices that its split made: the
 * middles of edges i (corner i to i + 1), and the centre. Triangles have three. */
typedef struct sl_patch_block {
    uint32_t parent;             /* SL_NO_INDEX: four roots */
    uint32_t root;               /* the one they belong to; of roots: index of the first in wanted_root */
    uint32_t middle[5];
} sl_patch_block;

/* Blocks lie in chunks that never move, and one that was given back rests for two builds of the display: so
 * frames may be drawn from them while patches are split. */
enum { SL_BLOCKS_A_CHUNK = 64 };

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
    uint32_t evaluated : 26;     /* update; SL_VERTEX_NEVER */
    uint32_t waiting : 1;        /* in the list of those around which nobody had light to lend */
    /* it was, but has no light of its own (it lies inside other geometry, or no number came): its value is
     * that of those around it */
    uint32_t borrowed : 1;
    /* it is shaded with many points on each light, as leaves of one pixel want it */
    uint32_t dense : 1;
    uint32_t is_dense : 1;       /* ... its value was */
    float value[3];              /* E, W/m^2 */
} sl_patch_vertex;

/* A vertex in the middle of an edge is that of two splits. Where so many ask for one, it is a root's corner,
 * as a rule, and those stay for good: it does. */
enum { SL_REFERENCES_MANY = 3 };

/* Where a value may be the mean of several sets of samples. */
typedef struct sl_vertex_sets {
    float variance;              /* of the mean of its channels' mean */
    uint32_t count;
} sl_vertex_sets;

/* Values of vertices that are kept besides E. */
/* exitant radiance of the lobe towards the eye, of those whose material has one */
enum { SL_PATCHES_LOBES = 1,
       SL_PATCHES_SETS = 2 };    /* how many sets of samples, and their variance */
/* Where lobes are kept, numbers of vertices are given out in groups, with them or without. */
enum { SL_VERTEX_GROUP = 16 };

typedef struct sl_patches {
    const sl_primitives *primitives;
    uint32_t *root_patch;        /* 2 x primitives, or SL_NO_INDEX: not wanted yet */
    /* the wanted ones in the order in which they were: four to a block of patches */
    uint32_t *wanted_root;
    uint32_t (*root_corner)[4];  /* their vertices; [3] SL_NO_INDEX of triangles */
    size_t wanted_count, wanted_capacity;
    sl_patch *patch;
    uint8_t *flags;              /* by patch: SL_PATCH_ bits */
    size_t patch_count, patch_capacity, patches_alive, leaves_alive;
    sl_patch_block **block_chunk; /* one block for four patches: sl_patch_block_of() */
    size_t block_chunks, block_chunks_room;
    uint32_t first_free;         /* blocks that are not in use, by their patches' child */
    /* those given back since the last build of the display, and since the one before */
    uint32_t resting[2];
    uint32_t last_root_block;    /* first patch of the block that new roots go to */
    sl_patch_vertex *vertex;
    sl_vertex_sets *sets;        /* by vertex; NULL: nobody asks, and all are one set */
    size_t vertex_count, vertex_capacity, vertices_alive;
    bool lobes;                  /* some are kept */
    /* by group of vertices: which group of lobes is theirs; SL_NO_INDEX: they have none */
    uint32_t *lobe_group;
    float (*lobe)[3];
    size_t lobe_count, lobe_capacity;
    uint32_t first_free_vertex[2]; /* numbers not in use, without lobes and with them */
    size_t free_vertices[2];
    sl_place_table table;        /* of vertices */
    bool borrowing;              /* some vertex has been borrowed */
    uint32_t *waiting;           /* borrowed vertices with nobody around who had light */
    size_t waiting_count, waiting_capacity;
} sl_patches;

/* kept: SL_PATCHES_ bits. */
sl_status sl_patches_create(const sl_primitives *primitives, unsigned kept, sl_patches **patches,
                            sl_error *error);
void sl_patches_destroy(sl_patches *patches);
/* Everything that grows with the patches (and not what stands for the scene's primitives, wanted or not). */
size_t sl_patches_memory_bytes(const sl_patches *patches);

uint32_t sl_patches_root(sl_patches *patches, uint32_t root, sl_status *status, sl_error *error);
/* Patches are never moved; those below patch_count that are not in use are skipped by this. */
static inline bool sl_patch_is_alive(const sl_patches *p, uint32_t patch) {
    return p->flags[patch] & SL_PATCH_ALIVE;
}
static inline bool sl_patch_is_leaf(const sl_patches *p, uint32_t patch) {
    return p->patch[patch].child == SL_NO_INDEX;
}
static inline int sl_patch_corners(const sl_patches *p, uint32_t patch) {
    return p->flags[patch] & SL_PATCH_TRIANGLE ? 3 : 4;
}
static inline sl_patch_block *sl_patch_block_of(const sl_patches *p, uint32_t patch) {
    return &p->block_chunk[patch / (4 * SL_BLOCKS_A_CHUNK)][patch / 4 % SL_BLOCKS_A_CHUNK];
}
static inline uint32_t sl_patch_parent(const sl_patches *p, uint32_t patch) {
    return sl_patch_block_of(p, patch)->parent;
}
static inline uint32_t sl_patch_root(const sl_patches *p, uint32_t patch) {
    const sl_patch_block *block = sl_patch_block_of(p, patch);
    return block->parent == SL_NO_INDEX ? p->wanted_root[block->root + patch % 4] : block->root;
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
    if (parent == SL_NO_INDEX) return p->root_corner[block->root + patch % 4][corner];
    return block
        ->middle[p->flags[patch] & SL_PATCH_TRIANGLE ? triangle[patch % 4][corner] : quad[patch % 4][corner]];
}

static inline void sl_vertex_mark(sl_patch_vertex *v, uint32_t update) {
    v->evaluated = update & (UINT32_MAX >> 6);
}
static inline sl_root_place sl_vertex_place(const sl_patch_vertex *v) { return v->place; }
/* L_s of a vertex, towards the eye; NULL: its material has no lobe. */
static inline float *sl_vertex_lobe(const sl_patches *p, uint32_t vertex) {
    uint32_t group = p->lobes ? p->lobe_group[vertex / SL_VERTEX_GROUP] : SL_NO_INDEX;
    return group == SL_NO_INDEX ? NULL : p->lobe[(size_t)SL_VERTEX_GROUP * group + vertex % SL_VERTEX_GROUP];
}

/* A patch with its corners' (u, v), in 1/SL_PATCH_DYADIC. */
typedef struct sl_patch_place {
    uint32_t patch, root;
    int depth, corners;
    uint16_t u[4], v[4];
} sl_patch_place;
sl_patch_place sl_patch_place_of(const sl_patches *patches, uint32_t patch);
sl_patch_place sl_patch_child_place(const sl_patches *patches, const sl_patch_place *parent, int child);
/* Returns the leaf that holds a point of a root. SL_NO_INDEX in patch: the root is not wanted yet. */
sl_patch_place sl_patch_locate(const sl_patches *patches, uint32_t root, double u, double v);
/* Returns which child of a patch, there or not, holds a point of its root. */
int sl_patch_child_at(const sl_patch_place *place, double u, double v);

/* Four children (SL_OK and nothing at SL_PATCH_DEPTH_MAX, or where a child would be degenerate: it stays a
 * leaf). Vertices that are new are not evaluated. Splits and drops mark as SL_PATCH_DIRTY what they make,
 * what they leave unused, and all leaves around vertices that come or go. Without memory nothing changes. */
sl_status sl_patch_split(sl_patches *patches, uint32_t patch, sl_error *error);
/* All below it goes. Its pixels become those of what was below. */
void sl_patch_drop_children(sl_patches *patches, uint32_t patch);
/* The display has been built: blocks given back before the last build but one are in no copy any more, and
 * may be used again. */
void sl_patches_rested(sl_patches *patches);

/* The value at a point of a leaf from its corners: barycentric or bilinear. Where corners have never been
 * evaluated the nearest ancestor whose corners all are stands in; false: there is none. second: that of
 * lobes. */
bool sl_patch_value(const sl_patches *patches, const sl_patch_place *leaf, double u, double v, bool second,
                    float value[3]);
/* Lists vertices that lie on edge i of a leaf (corner i to i + 1), between its ends, in order; for leaves
 * beside finer ones. At most `room`. */
size_t sl_patch_hanging(const sl_patches *patches, const sl_patch_place *leaf, int edge, uint32_t *vertex,
                        size_t room);
/* Lists the same with how far along the edge each lies, in 1/SL_PATCH_DYADIC of it. */
size_t sl_patch_hanging_at(const sl_patches *patches, const sl_patch_place *leaf, int edge, uint32_t *vertex,
                           uint16_t *at, size_t room);

/* When the oldest of all that a leaf shows was evaluated: of its corners (SL_VERTEX_NEVER: one never was),
 * and of what hangs on its edges and was evaluated at all. */
uint32_t sl_leaf_oldest(const sl_patches *patches, uint32_t leaf);
/* Vertices on a leaf's edges that are looked at for that. */
enum { SL_HANGING_MOST = 1024 };

/* Returns the size of what the camera sees of a patch. */
sl_screen_size sl_patch_projected(const sl_patches *patches, const sl_patch_place *place,
                                  const sl_camera *camera, int width, int height);

/* Marks as SL_PATCH_DIRTY all leaves, of any root, that have the vertex as a corner or on an edge: after its
 * value has changed. */
void sl_patches_touch(sl_patches *patches, uint32_t vertex);

/* A vertex without light of its own: it was asked for, and inside other geometry, or no number came. */
void sl_patches_borrow(sl_patches *patches, uint32_t vertex);
/* Before a build of the display: those of leaves that are SL_PATCH_DIRTY get their values anew from the
 * corners around them that have light of their own. Where nobody around has any they are looked at each time:
 * what lends from further away may have come. */
sl_status sl_patches_lend(sl_patches *patches, sl_error *error);

/* Eviction: down to `limit` patches where there are more (90 % of it): children of patches none of which was
 * seen since update `since`, and of patches that cover less than `small` pixels; oldest first, lower index on
 * a tie, from the leaves up. */
sl_status sl_patches_evict(sl_patches *patches, size_t limit, uint32_t since, double small,
                           sl_counters *counters, sl_error *error);

#endif
