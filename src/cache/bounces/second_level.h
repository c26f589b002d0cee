/* What the parts of the second-level cache share. */
#ifndef SL_CACHE_BOUNCES_SECOND_LEVEL_H
#define SL_CACHE_BOUNCES_SECOND_LEVEL_H

#include "base/isa.h"
#include "cache/bounces/bounces.h"
#include "cache/splatting/record_weight.h"

/* ---- records ---- */

typedef struct sl_second_list {
    sl_record *records;
    sl_gather_point *points;   /* where they gather: once for every bounce */
    sl_record_terms *terms;    /* what the look-up reads of a record; its light is that of the last bounce */
    size_t count, capacity;
} sl_second_list;

/* Takes the translational gradient from a record whose radius is R_min. */
void sl_second_tame(sl_record *record);
void sl_second_list_free(sl_second_list *list);

/* ---- which records lie around a point (record_octree.c) ---- */

enum { SL_OCTREE_LANES = 16, SL_OCTREE_LEVELS = 12 };

/* Sixteen records side by side; unused places have a reach that nothing is within. */
typedef struct sl_record_block {
    _Alignas(64) float x[SL_OCTREE_LANES], y[SL_OCTREE_LANES], z[SL_OCTREE_LANES];
    float normal_x[SL_OCTREE_LANES], normal_y[SL_OCTREE_LANES], normal_z[SL_OCTREE_LANES];
    float inverse_radius[SL_OCTREE_LANES], reach_squared[SL_OCTREE_LANES], front[SL_OCTREE_LANES],
        behind[SL_OCTREE_LANES];
    uint32_t record[SL_OCTREE_LANES];
    uint32_t count, next; /* of the node's blocks; 0: none */
} sl_record_block;

typedef struct sl_record_node {
    uint32_t child[8];    /* 0: none, as the root is no child */
    uint32_t first, last; /* blocks; 0: none */
} sl_record_node;

/* Ward's octree (1988) over the scene's box: a record is listed in the cells that it reaches into, at the
 * level whose cells are about as wide as its reach. So what reaches a point is listed on the way from the
 * root down to it. {0} is empty. */
typedef struct sl_record_octree {
    sl_vec3 low;
    float side, cells_per_length; /* of the root; of the deepest level */
    sl_record_node *nodes;
    size_t node_count, node_capacity;
    sl_record_block *blocks;      /* the first is none */
    size_t block_count, block_capacity;
} sl_record_octree;

sl_status sl_record_octree_insert(const sl_scene *scene, const sl_record_terms *terms, uint32_t record,
                                  sl_record_octree *octree, sl_error *error);
void sl_record_octree_free(sl_record_octree *octree);

static inline uint32_t sl_octree_coordinate(float p, float low, float cells_per_length) {
    float u = (p - low) * cells_per_length, last = (float)((1 << SL_OCTREE_LEVELS) - 1);
    return u > 0.0f ? (uint32_t)(u < last ? u : last) : 0u; /* a NaN goes to cell 0 and is within no reach */
}

/* The nodes from the root down to the point's own cell; returns how many. */
static inline int sl_octree_way(const sl_record_octree *t, float px, float py, float pz,
                                const sl_record_node *way[SL_OCTREE_LEVELS + 1]) {
    const uint32_t x = sl_octree_coordinate(px, t->low.x, t->cells_per_length),
                   y = sl_octree_coordinate(py, t->low.y, t->cells_per_length),
                   z = sl_octree_coordinate(pz, t->low.z, t->cells_per_length);
    int count = 0;
    if (!t->node_count) return 0;
    way[count++] = t->nodes;
    for (int bit = SL_OCTREE_LEVELS - 1; bit >= 0; bit--) {
        const unsigned octant = (x >> bit & 1u) | (y >> bit & 1u) << 1 | (z >> bit & 1u) << 2;
        const uint32_t child = way[count - 1]->child[octant];
        if (!child) break;
        way[count++] = t->nodes + child;
    }
    return count;
}

/* ---- irradiance at points (look_up.c, look_up_kernels.c) ---- */

typedef struct sl_second_field {
    const sl_second_list *list;
    const sl_record_octree *octree;
    sl_weight_rules rules;
} sl_second_field;

enum { SL_LOOK_UP_MAX = 256 };
typedef struct sl_second_sums {
    float r[SL_LOOK_UP_MAX], g[SL_LOOK_UP_MAX], b[SL_LOOK_UP_MAX]; /* sums of w E' */
    float weight[SL_LOOK_UP_MAX]; /* sums of w */
} sl_second_sums;

/* Points [first, first + count) of points, count <= SL_LOOK_UP_MAX. without_light: sums of w alone, the same
 * bits. */
typedef void sl_look_up_kernel(const sl_second_field *field, const sl_second_points *points, size_t first,
                               size_t count, bool without_light, sl_second_sums *sums);
SL_KERNEL_VARIANTS(sl_look_up_kernel, sl_look_up);
sl_look_up_kernel *sl_look_up_kernel_for(sl_isa isa);

/* Adds the irradiance at the points to r, g, b. */
void sl_second_look_up(const sl_second_field *field, sl_look_up_kernel *kernel,
                       const sl_second_points *points, float *r, float *g, float *b, sl_counters *counters);

/* ---- the cache (bounces.c) ---- */

struct sl_second_cache {
    sl_second_settings settings;
    const sl_scene *scene;
    const sl_tracer *tracer;
    sl_gather *gather;
    sl_gather_scratch **scratch;
    sl_second_list list;
    sl_record_octree octree;
    sl_second_field field;
    sl_look_up_kernel *kernel;
    sl_second_light light;
    bool shines;              /* before the first bounce is done there is no indirect light */
    sl_second_report report;
};

/* ---- places (probe.c, cover.c) ---- */

/* Points seen from others, `rays` (a square number) from each; points of which nothing is reflected have the
 * triangle SL_NO_INDEX. */
typedef struct sl_probed {
    sl_gather_point *points;
    size_t count;
} sl_probed;

/* points: about so many, spread over the picture. */
sl_status sl_probe_camera(const sl_scene *scene, const sl_tracer *tracer, const sl_second_settings *settings,
                          unsigned points, sl_probed *seen, sl_counters *counters, sl_error *error);
/* most: of so many origins, spread over them all, if there are more. */
sl_status sl_probe_from(const sl_scene *scene, const sl_tracer *tracer, const sl_second_settings *settings,
                        const sl_gather_point *origins, size_t count, size_t most, uint64_t generation,
                        sl_probed *seen, sl_counters *counters, sl_error *error);
void sl_probed_free(sl_probed *probed);

typedef struct sl_cover_pass {
    const sl_scene *scene;
    const sl_tracer *tracer;
    const sl_gather *gather;
    sl_gather_scratch *const *scratch;
    const sl_second_field *field;
    sl_look_up_kernel *kernel;
    sl_radius_rules radii;
    float covered_weight;
    unsigned threads;
} sl_cover_pass;

/* Points that no record of the list covers get one, as if they were visited one by one, in a fixed order;
 * until among those not yet looked at few are left that have none, as a share, or the list is about so long.
 * The pass's field is of this list and octree. */
sl_status sl_cover_points(const sl_cover_pass *pass, const sl_probed *points, double few_uncovered,
                          size_t most_records, sl_second_list *list, sl_record_octree *octree,
                          sl_counters *counters, sl_error *error);
/* Sum of w at a point. */
float sl_second_weight(const sl_second_field *field, sl_look_up_kernel *kernel, const sl_gather_point *point);
/* Share of the points that no record reaches at all. */
float sl_share_out_of_reach(const sl_second_field *field, sl_look_up_kernel *kernel, const sl_probed *points);

#endif
