/* Shared by the parts of the second-level cache. */
#pragma once

#include "base/isa.h"
#include "cache/bounces/bounces.h"
#include "cache/splatting/record_batch.h"
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

/* ---- irradiance at points (look_up_kernels.c) ---- */

/* Adds the irradiance at points to three planes; light NULL: only weighs them, with the same bits. weight,
 * if not NULL: gets the sums of w; missed: whether no record reaches the point. Returns how many points none
 * reaches. */
SL_KERNELS(uint64_t, sl_look_up,
           (const sl_second_cache *cache, const sl_second_points *points, float *const light[3],
            float *weight, bool *missed));

/* ---- what records send to each other (look_up_kernels.c, interreflection.c) ---- */

/* The share of a record's irradiance, by channel, that arrives at another one after one reflection. */
typedef struct sl_second_link {
    uint32_t from;
    float share[3];
} sl_second_link;

/* One worker's sums while it looks: share[record], below 0 where there is none; and which records have one.
 */
typedef struct sl_link_sums {
    float (*share)[3];
    uint32_t *touched;
    uint32_t count;
} sl_link_sums;

/* Adds what arrives from each record by way of the points that a gather sees, all of the same weight. */
SL_KERNELS(void, sl_second_links,
           (const sl_second_cache *cache, const sl_gather_hits_seen *seen, sl_link_sums *sums));

/* So many records whose turn it is gather light: of all of them, which have none yet, the first bounce. */
sl_status sl_second_gather(sl_second_cache *cache, size_t count, sl_counters *counters, sl_error *error);
/* Of records that have gathered it: the bounces that follow. */
sl_status sl_let_light_bounce(sl_second_cache *cache, sl_counters *counters, sl_error *error);

/* ---- the cache (bounces.c) ---- */

struct sl_second_cache {
    sl_second_settings settings;
    const sl_scene *scene;
    const sl_tracer *tracer;
    sl_gathers gathers; /* only while light bounces */
    sl_radius_rules radii;     /* of the records */
    bool fine;                 /* they are more, and nearer to each other, than as a rule */
    sl_second_list list;
    sl_record_octree octree;
    sl_weight_rules rules;
    sl_isa isa;
    sl_second_light light;
    bool shines;              /* before the first bounce is done there is no indirect light */
    size_t bounced;           /* records that there were when light last bounced, or began to */
    size_t waiting;           /* that are to gather again, in turns, for what more have come */
    bool moved;               /* things have: its light is renewed in turns */
    size_t next, renewed;     /* record whose turn it is; how many have had it since things last moved */
    sl_second_report report;
};

/* Makes gathers ready, if they are not. */
sl_status sl_second_open_gathers(sl_second_cache *cache, sl_error *error);

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
enum { SL_PROBE_RAYS = 64 };
/* SL_PROBE_RAYS points for each origin; most: of so many origins, spread over them all, if there are more. */
sl_status sl_probe_from(const sl_scene *scene, const sl_tracer *tracer, const sl_second_settings *settings,
                        const sl_gather_point *origins, size_t count, size_t most, uint64_t generation,
                        sl_probed *seen, sl_counters *counters, sl_error *error);
void sl_probed_free(sl_probed *probed);

/* Points that no record covers get one, as if they were visited one by one, in a fixed order; until among
 * those not yet looked at few are left that have none, as a share, or the records are about so many. */
sl_status sl_cover_points(sl_second_cache *cache, const sl_probed *points, double few_uncovered,
                          size_t most_records, sl_counters *counters, sl_error *error);
/* Returns the sum of w at a point. */
float sl_second_weight(const sl_second_cache *cache, const sl_gather_point *point);
