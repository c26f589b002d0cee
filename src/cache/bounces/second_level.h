/* What the parts of the second-level cache share. */
#ifndef SL_CACHE_HIDDEN_H
#define SL_CACHE_HIDDEN_H

#include "base/isa.h"
#include "cache/bounces/bounces.h"
#include "cache/splatting/record_weight.h"

/* ---- walls (walls.c) ---- */

/* What a record must not reach past is known by direction: sixteen sectors of its tangent plane, and how far
 * each is free. So it may reach further than the guard allows, lest corners fill up with records (R_min). */
enum { SL_WALL_SECTORS = 16 };
typedef struct sl_second_walls {
    sl_vec3 x, y;                        /* the tangent frame */
    float free_squared[SL_WALL_SECTORS];
} sl_second_walls;

/* record: of this point, behind_a_wall if it reaches past its guard; then: if any wall stands within its
 * reach. */
void sl_second_walls_find(const sl_scene *scene, const sl_tracer *tracer, const sl_gather_point *point,
                          float accuracy, sl_record *record, sl_second_walls *walls, sl_counters *counters);

/* Sectors are told apart by signs and ratios: no angle is computed. tan(22.5 degrees) halves an octant. */
static inline unsigned sl_wall_sector(float x, float y) {
    float ax = x < 0.0f ? -x : x, ay = y < 0.0f ? -y : y;
    float small = ax < ay ? ax : ay, large = ax < ay ? ay : ax;
    return (unsigned)(x < 0.0f) | (unsigned)(y < 0.0f) << 1 | (unsigned)(ay > ax) << 2 |
           (unsigned)(small > 0.41421356f * large) << 3;
}
static inline int sl_wall_stands_between(const sl_second_walls *walls, float dx, float dy, float dz) {
    float x = dx * walls->x.x + dy * walls->x.y + dz * walls->x.z,
          y = dx * walls->y.x + dy * walls->y.y + dz * walls->y.z;
    return x * x + y * y > walls->free_squared[sl_wall_sector(x, y)];
}

/* ---- records ---- */

typedef struct sl_second_list {
    sl_record *records;
    sl_gather_point *points;   /* where they gather: once for every bounce */
    sl_record_terms *terms;    /* what the look-up reads of a record; its light is that of the last bounce */
    sl_second_walls *walls;    /* of records that say behind_a_wall */
    size_t count, capacity;
} sl_second_list;

/* Takes the translational gradient from a record whose radius is R_min. */
void sl_second_tame(sl_record *record);
void sl_second_list_free(sl_second_list *list);

/* The weight of one record at one point, to the same bits as the look-up's. */
float sl_second_weight(const sl_second_list *list, size_t record, sl_vec3 position, sl_vec3 normal);

/* ---- which records lie around a point (record_tree.c) ---- */

enum { SL_TREE_LANES = 16, SL_TREE_LEVELS = 12 };
#define SL_TREE_WALLS 0x80000000u /* this record's walls matter */

/* Sixteen records side by side, in the order of their indices; unused places have a reach that nothing is
 * within. */
typedef struct sl_tree_block {
    _Alignas(64) float x[SL_TREE_LANES], y[SL_TREE_LANES], z[SL_TREE_LANES];
    float normal_x[SL_TREE_LANES], normal_y[SL_TREE_LANES], normal_z[SL_TREE_LANES];
    float inverse_radius[SL_TREE_LANES], reach_squared[SL_TREE_LANES], front[SL_TREE_LANES],
        behind[SL_TREE_LANES];
    uint32_t record[SL_TREE_LANES];
} sl_tree_block;

typedef struct sl_tree_node {
    uint32_t first;  /* of eight children, or of the leaf's blocks */
    uint32_t blocks; /* SL_NO_INDEX: has children */
} sl_tree_node;

/* An octree over the scene's box; a leaf lists the records that reach into its cell. */
typedef struct sl_record_tree {
    sl_vec3 low;
    float cell, cells_per_length; /* side of a cell of the deepest level, and its inverse */
    float widen;                  /* records were listed as if they reached so many times further */
    sl_tree_node *nodes;
    size_t node_count, node_capacity;
    sl_tree_block *blocks;
    size_t block_count, block_capacity;
    size_t records;               /* the first so many of the list */
} sl_record_tree;

/* leaf_records: leaves with more are split, where that helps. */
sl_status sl_record_tree_build(const sl_scene *scene, const sl_second_list *list, float widen,
                               size_t leaf_records, sl_record_tree *tree, sl_error *error);
void sl_record_tree_free(sl_record_tree *tree);
size_t sl_record_tree_bytes(const sl_record_tree *tree);

static inline uint32_t sl_tree_coordinate(float p, float low, float cells_per_length) {
    float u = (p - low) * cells_per_length, last = (float)((1 << SL_TREE_LEVELS) - 1);
    return u > 0.0f ? (uint32_t)(u < last ? u : last) : 0u; /* a NaN goes to cell 0 and is within no reach */
}
static inline const sl_tree_node *sl_tree_leaf(const sl_record_tree *t, float px, float py, float pz) {
    uint32_t x = sl_tree_coordinate(px, t->low.x, t->cells_per_length),
             y = sl_tree_coordinate(py, t->low.y, t->cells_per_length);
    uint32_t z = sl_tree_coordinate(pz, t->low.z, t->cells_per_length);
    const sl_tree_node *node = t->nodes;
    for (int bit = SL_TREE_LEVELS - 1; node->blocks == SL_NO_INDEX; bit--)
        node = t->nodes + node->first + ((x >> bit & 1u) | (y >> bit & 1u) << 1 | (z >> bit & 1u) << 2);
    return node;
}

/* ---- irradiance at points (look_up.c, look_up_kernels.c) ---- */

typedef struct sl_second_field {
    const sl_second_list *list;
    const sl_record_tree *near, *wide; /* wide: for points that no record covers, or NULL */
    sl_weight_rules rules;
    const sl_tracer *tracer;
    float offset;                      /* of rays, along normals */
} sl_second_field;

enum { SL_LOOK_UP_MAX = 256 };
typedef struct sl_second_sums {
    float r[SL_LOOK_UP_MAX], g[SL_LOOK_UP_MAX], b[SL_LOOK_UP_MAX]; /* sums of w E' */
    /* sums of w, records in the order of their indices */
    float weight[SL_LOOK_UP_MAX];
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
    sl_record_tree near, wide;
    sl_second_field field;
    sl_look_up_kernel *kernel;
    sl_second_light light;
    bool shines;              /* before the first bounce is done there is no indirect light */
    sl_second_report report;
};

/* Makes ready for the look-up what the list holds. */
sl_status sl_second_cache_shine(sl_second_cache *cache, sl_error *error);
/* Without records, gathers or light. */
sl_status sl_second_cache_blank(const sl_scene *scene, const sl_tracer *tracer,
                                const sl_second_settings *settings, sl_second_cache **cache, sl_error *error);
/* Room for so many records in all. */
sl_status sl_second_list_reserve(sl_second_list *list, size_t capacity, sl_error *error);

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
    sl_look_up_kernel *kernel;
    sl_weight_rules rules;
    sl_radius_rules radii;
    float covered_weight;
    unsigned threads;
} sl_cover_pass;

/* Points that no record of the list covers get one, as if they were visited one by one, in a fixed order;
 * until among those not yet looked at few are left that have none, as a share, or the list is about so long.
 */
sl_status sl_cover_points(const sl_cover_pass *pass, const sl_probed *points, double few_uncovered,
                          size_t most_records, sl_second_list *list, sl_counters *counters, sl_error *error);
/* Share of the points that no record reaches at all. */
float sl_share_out_of_reach(const sl_second_field *field, sl_look_up_kernel *kernel, const sl_probed *points);

#endif
