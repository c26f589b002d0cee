/* From the photon map to the virtual directional lights of every voxel:
 *
 *     leaf ── gather k photons about c_v ── area, E ── clusters of directions ── V_j, d_j, c_j
 *
 * Leaves do not depend on each other, so they may be done in batches, in any order and in parallel. */
#pragma once

#include "base/isa.h"
#include "cache/frame/settings.h"
#include "cache/light_octree/photon_area.h"
#include "cache/photons/photon_tree.h"

/* ---- clusters of directions (cluster_kernels.c) ---- */

enum { SL_VOXEL_LIGHTS_MAX = 8, SL_CLUSTER_ITERATIONS = 32 };

/* Points to be clustered: unit vectors and their weights, n of each. */
typedef struct sl_directions {
    size_t count;
    const float *x, *y, *z;
    const double *weight; /* > 0 */
} sl_directions;

typedef struct sl_clusters {
    /* at most what was asked for; fewer where there are fewer distinct directions */
    int count;
    sl_vec3d centre[SL_VOXEL_LIGHTS_MAX];    /* unit */
    double cost;                             /* J = sum w |omega - d|^2 */
    int iterations;
} sl_clusters;

/* Deterministic: first centre nearest to the mean, next ones by largest weighted distance, ties to the lower
 * index; J never rises. iterations: at most so many. of: the cluster of each point; a cluster may end without
 * any. scratch: count doubles. */
SL_KERNELS(void, sl_cluster,
           (const sl_directions *directions, int wanted, int iterations, uint8_t *of, double *scratch,
            sl_clusters *clusters));

static inline void sl_cluster_directions(const sl_directions *directions, int wanted, uint8_t *of,
                                         double *scratch, sl_clusters *clusters) {
    SL_KERNEL_OF(sl_isa_best(), sl_cluster)(directions, wanted, SL_CLUSTER_ITERATIONS, of, scratch, clusters);
}

/* ---- a light ---- */

/* 16 bytes: one RGBA32F texel. */
typedef struct sl_directional_light {
    float color[3];      /* W/m^2 perpendicular to the direction, or on the surface */
    float packed;        /* the direction, an integer below 2^24: exact in a float */
} sl_directional_light;

/* 254 steps of the polar angle and 256 of the azimuth: 8 + 8 bits. Axes are exact. */
float sl_direction_pack(sl_vec3d direction);
sl_vec3 sl_direction_unpack(float packed);

/* ---- voxels ---- */

enum { SL_VOXEL_SETS_MAX = 6 };

/* A voxel's lights, or those of one of its groups of normals. */
typedef struct sl_voxel_set {
    sl_vec3 centroid;      /* c_v, the gather's centre: by area, of its triangles clipped to the voxel */
    sl_vec3 normal;        /* n_v, turned to the side on which the photons lie; (0,0,0): none */
    float height;          /* of the centroid above the voxel's centre along the normal, in voxels */
    float surface;         /* area of its triangles clipped to the voxel; what lies in a face that two voxels
                            * share counts half in each, so that all sets' add up to the scene's */
    uint32_t leaf;
    uint32_t photons;      /* gathered */
    float radius;          /* R */
    float area;            /* of the surfaces that the photons lie on, both faces of a wall together */
    float irradiance;      /* E, luminance; the sum of both sides */
    float density;         /* flux over that area */
    float rms_angle;       /* the spread of the clusters: radians, by weight */
    uint8_t lights;        /* used */
    /* another of the voxel's sets faces the other way: light of that side is that one's */
    bool opposed;
    bool layered;          /* another has about the same normal, but lies higher or lower */
    bool flat;             /* light is seen by that normal alone: a light along it says all */
} sl_voxel_set;

typedef struct sl_voxel_lights {
    sl_light_octree_settings options;
    double radius; /* r: theirs, or 1.4 sqrt(k A / (pi N)), 1.4 times the radius of a disc that holds k
                    * of N photons strewn evenly over the scene's area A; at least one voxel */
    bool split;            /* a set for each group of normals; else one a leaf */
    size_t leaf_count, set_count;
    uint32_t *first_set;   /* leaf_count + 1 */
    sl_voxel_set *set;
    int texels;            /* of a set: n, or 1 (colour octree) */
    sl_directional_light *light; /* set_count * texels, unused ones 0 */
    const sl_scene *scene;
    const sl_octree *octree;
    const sl_photon_tree *tree;  /* NULL: no photons */
    double cos_acceptance;
    bool by_side;                /* photons are taken side by side; off: whatever their normals */
    unsigned workers;
    struct sl_voxel_worker *worker;
} sl_voxel_lights;

/* Tells whether areas are those of clipped triangles. */
static inline bool sl_voxel_lights_clip(const sl_light_octree_settings *options) {
    return options->area == SL_PHOTON_AREA_CLIP && !options->own_photons;
}

/* Scene, octree and tree must outlive the lights. Options are completed. */
sl_status sl_voxel_lights_create(const sl_scene *scene, const sl_octree *octree,
                                 const sl_photon_tree *tree, const sl_light_octree_settings *options,
                                 unsigned threads, sl_voxel_lights **lights, sl_error *error);
/* The lights of leaves [first, first + count). Adds what was gathered, leaves, and lights to the counters. */
void sl_voxel_lights_compute(sl_voxel_lights *lights, size_t first, size_t count, unsigned threads,
                             sl_counters *counters);
void sl_voxel_lights_destroy(sl_voxel_lights *lights);
size_t sl_voxel_lights_bytes(const sl_voxel_lights *lights);

/* Over all sets. Means are over the lit ones. */
typedef struct sl_voxel_statistics {
    uint64_t sets, lit;
    uint64_t lights, photons;
    double mean_photons, mean_radius;
    double rms_angle;        /* sqrt of the mean square, by irradiance: radians */
    double flux;             /* sum of flux density times the sets' own area: luminance, W */
} sl_voxel_statistics;
sl_voxel_statistics sl_voxel_lights_statistics(const sl_voxel_lights *lights);

/* ---- which sets a voxel has (voxel_sets.c) ---- */

/* Makes all sets and room for their lights. */
sl_status sl_voxel_sets_create(sl_voxel_lights *lights, sl_error *error);

/* ---- what a set keeps of its photons (voxel_lobes.c) ---- */

/* Room for the photons of a gather, a worker's scratch. */
typedef struct sl_lobe_arrays {
    float x[SL_NEIGHBOURS_MAX], y[SL_NEIGHBOURS_MAX], z[SL_NEIGHBOURS_MAX], flux[3][SL_NEIGHBOURS_MAX];
    double luminance[SL_NEIGHBOURS_MAX], inverse_cosine[SL_NEIGHBOURS_MAX];
    double weight[SL_NEIGHBOURS_MAX], nearest[SL_NEIGHBOURS_MAX]; /* for the clusters */
    uint8_t of[SL_NEIGHBOURS_MAX];
} sl_lobe_arrays;

/* Photons on one side of a surface, a part of those arrays, in order of their ids. */
typedef struct sl_lobe_photons {
    size_t count;
    float *x, *y, *z;             /* omega */
    float *flux[3];
    double *luminance;            /* Y(flux) > 0 */
    double *inverse_cosine;       /* 1 / max(n_i . omega, epsilon) */
    double *weight, *nearest;
    uint8_t *of;
} sl_lobe_photons;

/* Returns none, with room from the arrays' place `first` on. */
sl_lobe_photons sl_lobe_photons_in(sl_lobe_arrays *arrays, size_t first);
/* Adds a photon, unless it carries nothing, or nothing finite. normal: on the photon's side. */
void sl_lobe_photons_add(sl_lobe_photons *photons, sl_vec3 direction, sl_vec3 normal, const float flux[3]);

static const double SL_GRAZING = 0.05; /* epsilon: bounds a photon's weight, not its energy */

typedef struct sl_lobe_spread {
    double cost, weight;  /* J, sum w: of all clusters */
} sl_lobe_spread;

/* E = scale * sum of fluxes, scale = kappa / A. normal: n_v on the photons' side, or (0,0,0). flat: the
 * surface reflects light of all directions alike, and one light along its normal makes the same irradiance.
 * Writes at most `room` lights; returns how many texels are used. spread (clusters alone) is added to. */
int sl_lobes_of_photons(const sl_lobe_photons *photons, const sl_light_octree_settings *options, double scale,
                        sl_vec3 normal, bool flat, int room, sl_directional_light *light,
                        sl_lobe_spread *spread);
int sl_lobe_texels(const sl_light_octree_settings *options);

/* ---- one set, step by step (leaf.c) ---- */

/* A worker's own. */
typedef struct sl_voxel_worker {
    sl_gathered_photons gathered; /* in the arrays */
    uint32_t place[SL_NEIGHBOURS_MAX];
    double distance[SL_NEIGHBOURS_MAX];
    uint64_t keys[3 * SL_NEIGHBOURS_MAX + 2 * SL_PHOTON_BUCKET];
    sl_lobe_arrays photons;       /* of both sides */
    sl_triangle_marks marks;
} sl_voxel_worker;

typedef struct sl_voxel_gather {
    sl_ellipsoid ellipsoid;       /* R; f = 1 without a normal */
    double kappa;
    size_t found, taken;
    sl_lobe_photons side[2];      /* by the side of n_v; all in front where sides are not told apart */
    sl_place_sums places[2];      /* likewise, but for caustics */
    sl_vec3d mean_normal, mean_place; /* of the photons, turned to n_v's side; about the centre */
} sl_voxel_gather;

/* A for the photons in front and behind, and that of all surfaces together. */
typedef struct sl_voxel_area {
    double side[2], all;
} sl_voxel_area;

sl_photon_query sl_voxel_query(const sl_voxel_lights *lights, sl_vec3 centre, sl_vec3 normal);
sl_voxel_gather sl_voxel_gather_photons(const sl_voxel_lights *lights, const sl_photon_query *query,
                                        sl_voxel_worker *worker);
sl_voxel_area sl_voxel_areas(const sl_voxel_lights *lights, const sl_voxel_gather *gather,
                             sl_voxel_worker *worker);
void sl_voxel_light_set(sl_voxel_lights *lights, size_t index, sl_voxel_worker *worker,
                        sl_counters *counters);
