/* Irradiance records: what is cached, how far it reaches, and with which weight it contributes to a pixel
 * (Gautron et al. 2005; Ward et al. 1988 for the split-sphere weight; Krivanek et al. 2006 for neighbour
 * clamping). */
#pragma once

#include "base/isa.h"
#include "cache/hemisphere/gather.h"
#include "scene/object_motion.h"

/* Neighbour clamping asks of every record for the least R_j + |p - p_j| over all others (rule 5 below). An
 * octree whose nodes hold one record each, and know the least R_j below, answers by looking at a few
 * (record_list.c). */
typedef struct sl_reach_node {
    sl_vec3 position;
    float radius, least; /* of the node's own record; of all at and below it */
    sl_box box;          /* of those */
    uint32_t child[8];   /* by octant about the position; 0: none, as the root is no child */
} sl_reach_node;

/* {0} is empty. */
typedef struct sl_reach_tree {
    sl_reach_node *nodes;
    size_t count, capacity;
} sl_reach_tree;

sl_status sl_reach_tree_insert(sl_reach_tree *tree, sl_vec3 position, float radius, sl_error *error);
/* Returns the least of `radius` and all R_j + |p - p_j|: the same bits in whatever order the points came.
 * Thread-safe between insertions. */
float sl_reach_tree_limit(const sl_reach_tree *tree, sl_vec3 position, float radius);

/* A wall that stands near a record: what lies behind it is another room's. */
typedef struct sl_record_wall {
    sl_vec3 normal;            /* towards the record; 0: no wall */
    float offset;              /* p is behind it where (p - p_k) . normal < offset */
} sl_record_wall;

enum { SL_RECORD_WALLS = 2 };

typedef struct sl_record {
    sl_vec3 position, normal;
    float radius;              /* R; the record reaches accuracy * R */
    sl_rgb irradiance;         /* E, W/m^2 */
    sl_vec3 rotational[3];     /* grad_r E per channel, W/m^2/rad */
    sl_vec3 translational[3];  /* grad_t E per channel, W/m^3 */
    float rotational_length[3];
    float own_radius;          /* R by the record's own gather alone, before its neighbours had a say */
    float minimum_radius;      /* R_min at this record */
    /* the rules' sigma: 1 where R is Ward's, 1/a where R is made from the reach aR (hessian) */
    float stretch;
    sl_record_wall walls[SL_RECORD_WALLS];
    uint32_t triangle;
    uint32_t renewed;          /* with which edit of the scene it has gathered last (ages.c) */
    /* of the gather, its low half first: the same again meets the same, where nothing has moved */
    uint32_t key[2];
} sl_record;

typedef struct sl_radius_rules {
    double accuracy;           /* a */
    double minimum_pixels;     /* aR_min in footprints of a pixel at the record; 0: it is minimum_reach */
    double steep;              /* share of Y that may change within aR_min before it halves; 0: it does not */
    double maximum_radius;     /* aR_max = diagonal / 10 */
    bool guard;
    sl_gather_kind gather;
    double plane_tangent;      /* tan(fov/2) of the plane gather */
    double minimum_reach;      /* aR_min, m, of records that must not depend on a view */
    sl_radius_metric metric;   /* decided: AUTO counts as HARMONIC here */
} sl_radius_rules;

/* A record's reach, by metric (record.c has the formulas):
 *
 *   harmonic  a times the cosine-weighted harmonic mean distance: what can change is near
 *   hessian   so far that the error of linear extrapolation, summed over what it lights, is the same for all
 *
 * Then come the rules of the radius. sigma is sl_record.stretch, Y the mean of the channels of E:
 *
 *   1  R <= sigma Y / |grad_t Y|   the linear extrapolation E + delta . grad_t E stays positive within
 *                                  R / sigma
 *   2  R <= s^2 rho_min / a        the guard: a R ends before the walls that the gather has seen. rho_min is
 *                                  the least r / cos theta' over its hits, theta' the angle there;
 *                                  s^2 = t^2 / (1 + t^2) for a plane of half side t, else 1
 *   3  R >= R_min                  a R_min is minimum_pixels footprints of a pixel, or minimum_reach; half of
 *                                  it where |grad_t Y| a R_min > steep Y. Where R then breaks rule 1,
 *                                  grad_t E is scaled by sigma Y / (R |grad_t Y|), at R_min with
 *                                  max(1, 0.33 sigma) for sigma; where R breaks rule 2, walls end it
 *                                  (record_walls.c)
 *   4  R <= R_max                  a R_max is maximum_radius; R_min is never above it
 *   5  R_i / sigma <= R_j / sigma + |p_i - p_j| for all j, then R >= R_min again: neighbour clamping
 *                                  (Krivanek et al. 2006)
 *
 * 1, 2 and 4 are bounds from above, whose order does not matter; 3 has the last word over them. 5 needs all
 * records.
 *
 * Makes a record from a gather: values copied, R by the metric and rules 1 to 4. footprint: of a pixel at the
 * record, m. */
sl_record sl_record_make(const sl_gather_point *point, const sl_irradiance *irradiance,
                         const sl_radius_rules *rules, float footprint);
/* Returns the R that rule 2 allows; infinite where the guard is off or nothing is seen. */
double sl_record_guard(const sl_irradiance *irradiance, const sl_radius_rules *rules);
/* Rule 2 where a record reaches further than `guard`, as R_min or the Hessian have it: it gets the walls that
 * stand around it, and does not count behind them (record_walls.c). Within it, too, but only of what stands
 * across the way: gathers of few rays make the guard a tenth too generous. */
void sl_record_find_walls(const sl_scene *scene, const sl_tracer *tracer, const sl_gather_point *point,
                          double accuracy, double guard, sl_record *record, sl_counters *counters);
/* Returns R by rule 5; the tree holds R / sigma of all records, by rules 1 to 4. */
float sl_record_clamped_radius(const sl_reach_tree *reaches, const sl_record *record);
/* Moves what lies on an object along with it. */
void sl_gather_point_carry(sl_gather_point *point, const sl_object_motion *motion);
void sl_record_carry(sl_record *record, const sl_object_motion *motion);
/* Sets R and scales the translational gradient as rule 3 does, so that the linear extrapolation stays
 * positive within R / sigma. */
void sl_record_set_radius(sl_record *record, float radius);

/* ---- weights ---- */

/* Pixels as the fragment program reads them: one class of receivers, bottom row first. */
typedef struct sl_splat_receivers {
    int width, height;
    const float *position_x, *position_y, *position_z;
    const float *normal_x, *normal_y, *normal_z;
    const uint32_t *receives; /* 0: no geometry, or nothing to reflect */
} sl_splat_receivers;

typedef struct sl_weight_rules {
    float accuracy;           /* a: contributes iff D <= a, (3) with the threshold 1/a */
    float offset;             /* 1/a for smooth weights, 0 for Ward's own */
    float front_tolerance;    /* 1e-5 of the scene's scale */
} sl_weight_rules;

/* w_min: smooth weights count a point as covered by one record at D <= 0.9 a, so that none hangs on a
 * vanishing weight. */
static inline float sl_covered_weight(float accuracy) { return 1.0f / (9.0f * accuracy); }

typedef struct sl_splat_buffer {
    float *r, *g, *b;         /* sum of w E' */
    float *weight;            /* sum of w */
    float *count;             /* records that contributed */
    /* sum of w times what the glossy lobe reflects, per unit ks; NULL where no receiver is glossy */
    float *glossy[3];
} sl_splat_buffer;

enum { SL_SPLAT_GROUP = 16 };

/* One tile of all these planes, as the fragment program works on it; SL_SPLAT_TILE pixels a row. A pixel that
 * does not receive is nowhere: its position is NaN, which no test of a distance accepts. */
typedef struct sl_tile_planes {
    _Alignas(64) float position_x[SL_SPLAT_TILE_PIXELS];
    float position_y[SL_SPLAT_TILE_PIXELS], position_z[SL_SPLAT_TILE_PIXELS];
    float normal_x[SL_SPLAT_TILE_PIXELS], normal_y[SL_SPLAT_TILE_PIXELS], normal_z[SL_SPLAT_TILE_PIXELS];
    float weight[SL_SPLAT_TILE_PIXELS], r[SL_SPLAT_TILE_PIXELS], g[SL_SPLAT_TILE_PIXELS],
        b[SL_SPLAT_TILE_PIXELS], count[SL_SPLAT_TILE_PIXELS];
    float glossy[3][SL_SPLAT_TILE_PIXELS];
    bool receives[SL_SPLAT_TILE_PIXELS / SL_SPLAT_GROUP]; /* any of so many pixels of a row */
    bool any_receives;                                    /* of the region */
} sl_tile_planes;

/* Fetches the receivers of a region that starts in column region.x0 - x, row region.y0 - y of the tile. */
SL_KERNELS(void, sl_splat_fetch,
           (const sl_splat_receivers *receivers, int x, int y, sl_splat_rect region, sl_tile_planes *tile));
/* Algorithm 1, steps 2 to 6, for the pixels of a rectangle within the tile; without light the sum of weights
 * alone, with the same bits. weights, if not NULL: gets that of every pixel of the rectangle, pixel (x, y) of
 * the tile at [y * SL_SPLAT_TILE + x]. Returns how many pixels took part. */
SL_KERNELS(uint64_t, sl_splat_record,
           (const sl_record *record, const sl_weight_rules *rules, sl_splat_rect rect, bool light,
            sl_tile_planes *tile, float *weights));
/* w at one pixel; 0 where the record does not contribute. */
SL_KERNELS(float, sl_splat_weight,
           (const sl_record *record, const sl_weight_rules *rules, const sl_splat_receivers *receivers,
            size_t pixel));
