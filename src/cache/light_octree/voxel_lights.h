/* From the photon map to the virtual directional lights of every voxel:
 *
 *     leaf ── gather k photons about c_v ── area, E ── clusters of directions ── V_j, d_j, c_j
 *
 * Leaves do not depend on each other, so they may be done in batches, in any order and in parallel. */
#ifndef SL_CACHE_LIGHT_OCTREE_VOXEL_LIGHTS_H
#define SL_CACHE_LIGHT_OCTREE_VOXEL_LIGHTS_H

#include "cache/light_octree/lights.h"
#include "cache/light_octree/photon_area.h"

/* All of them wanted; nothing is a default. */
typedef struct sl_voxel_light_options {
    size_t neighbours;       /* k >= 2 */
    double radius;           /* r > 0 */
    double flatness;         /* f in (0,1] */
    /* radians between a photon's normal and the voxel's; pi: all photons, whatever their side */
    double acceptance;
    sl_photon_area area;
    sl_voxel_lobes lobes;
    int lights;              /* n of directional lights */
    bool unit_weights;       /* K-means with equal weights */
    bool own_photons;        /* those that lie in the voxel, instead of the k nearest; all normals */
    bool split_by_normal;    /* a set of lights for each group of normals */
} sl_voxel_light_options;

/* 1.4 sqrt(k A / (pi N)): 1.4 times the radius of a disc that holds k of N photons strewn evenly over the
 * scene's area A. At least one voxel. */
double sl_voxel_radius(const sl_octree *octree, size_t neighbours, uint64_t photons);

enum { SL_VOXEL_SETS_MAX = 6 };

/* A voxel's lights, or those of one of its groups of normals. */
typedef struct sl_voxel_set {
    sl_vec3 centroid;      /* the gather's centre */
    sl_vec3 normal;        /* turned to the side on which the photons lie; (0,0,0): none */
    float height;          /* of the centroid above the voxel's centre along the normal, in voxels */
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
    bool both_sides;       /* photons on both sides */
    bool flat;             /* light is seen by that normal alone: a light along it says all */
    bool done;
} sl_voxel_set;

typedef struct sl_voxel_lights {
    sl_voxel_light_options options;
    size_t leaf_count, set_count;
    uint32_t *first_set;   /* leaf_count + 1; a leaf has one set unless split by normal */
    sl_voxel_set *set;
    int texels;            /* of a set: n, or 1 (colour octree) */
    sl_directional_light *light; /* set_count * texels, unused ones 0 */
    const sl_scene *scene;
    const sl_octree *octree;
    const sl_photon_tree *tree;  /* NULL: no photons */
    struct sl_own_photons {      /* those that lie in each leaf: own_photons alone */
        uint32_t *first;         /* leaf_count + 1 */
        uint32_t *place;         /* in the tree's list, by leaf */
        size_t most;             /* in one leaf */
    } own;
    double cos_acceptance;
    bool by_side;                /* photons are taken side by side; off: whatever their normals */
    unsigned workers;
    struct sl_voxel_worker *worker;
} sl_voxel_lights;

/* Are areas those of clipped triangles? */
static inline bool sl_voxel_lights_clip(const sl_voxel_light_options *options) {
    return options->area == SL_PHOTON_AREA_CLIP && !options->own_photons;
}

/* Scene, octree and tree must outlive the lights. */
sl_status sl_voxel_lights_create(const sl_scene *scene, const sl_octree *octree,
                                 const sl_photon_tree *tree, const sl_voxel_light_options *options,
                                 unsigned threads, sl_voxel_lights **lights, sl_error *error);
/* The lights of leaves [first, first + count). Adds what was gathered, leaves, and lights to the counters. */
void sl_voxel_lights_compute(sl_voxel_lights *lights, size_t first, size_t count, unsigned threads,
                             sl_counters *counters);
/* Moves what the workers have counted to the counters. */
void sl_voxel_lights_count(sl_voxel_lights *lights, sl_counters *counters);
void sl_voxel_lights_destroy(sl_voxel_lights *lights);
size_t sl_voxel_lights_bytes(const sl_voxel_lights *lights);

/* Over the sets that are done. Means are over the lit ones. */
typedef struct sl_voxel_statistics {
    uint64_t sets, lit;
    uint64_t lights, photons;
    double mean_photons, mean_radius;
    double rms_angle;        /* sqrt of the mean square, by irradiance: radians */
    double flux;             /* sum of flux density times the voxel's own area: luminance, W */
} sl_voxel_statistics;
void sl_voxel_lights_statistics(const sl_voxel_lights *lights, const sl_octree *octree,
                                sl_voxel_statistics *statistics);

/* ---- which sets a voxel has (voxel_sets.c) ---- */

enum { SL_LEAVES_A_TASK = 16 };

/* What lies in a voxel, triangle by triangle; a worker's scratch. */
typedef struct sl_voxel_piece {
    sl_vec3d normal, moment; /* unit; area times position, in cells about the voxel's first corner */
    double area;
    int group;
    bool flat;               /* one shading normal, and it reflects light of all directions alike */
} sl_voxel_piece;

/* Makes all sets and room for their lights. */
sl_status sl_voxel_sets_create(sl_voxel_lights *lights, sl_error *error);

/* ---- what a set keeps of its photons (voxel_lobes.c) ---- */

/* Photons on one side of a surface, as arrays, in order of their ids; a worker's scratch. */
typedef struct sl_lobe_photons {
    size_t count;
    float *x, *y, *z;             /* omega */
    float *flux[3];
    double *luminance;            /* Y(flux) > 0 */
    double *inverse_cosine;       /* 1 / max(n_i . omega, epsilon) */
    double *weight, *nearest;     /* room for the clusters */
    uint8_t *of;
} sl_lobe_photons;

sl_status sl_lobe_photons_create(size_t capacity, sl_lobe_photons *photons, sl_error *error);
void sl_lobe_photons_release(sl_lobe_photons *photons);
/* The photons from `first` on. */
sl_lobe_photons sl_lobe_photons_from(const sl_lobe_photons *photons, size_t first, size_t count);
/* Adds a photon, unless it carries nothing, or nothing finite. normal: on the photon's side. */
void sl_lobe_photons_add(sl_lobe_photons *photons, sl_vec3 direction, sl_vec3 normal, const float flux[3]);

static const double SL_GRAZING = 0.05; /* epsilon: bounds a photon's weight, not its energy */

typedef struct sl_lobe_spread {
    double cost, weight;  /* J, sum w: of all clusters */
} sl_lobe_spread;

/* E = scale * sum of fluxes, scale = kappa / A. normal: n_v on the photons' side, or (0,0,0). flat: the
 * surface reflects light of all directions alike, and one light along its normal makes the same irradiance.
 * Writes at most `room` lights; returns how many texels are used. spread (clusters alone) is added to. */
int sl_lobes_of_photons(const sl_lobe_photons *photons, const sl_voxel_light_options *options, double scale,
                        sl_vec3 normal, bool flat, int room, sl_directional_light *light,
                        sl_lobe_spread *spread);
int sl_lobe_texels(const sl_voxel_light_options *options);

/* ---- one set, step by step (leaf.c) ---- */

/* A worker's own. */
typedef struct sl_voxel_worker {
    sl_gathered_photons gathered;
    sl_lobe_photons photons;      /* of both sides */
    sl_triangle_marks marks;
    sl_voxel_piece *pieces;
    sl_counters counters;
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

sl_photon_query sl_voxel_query(const sl_voxel_lights *lights, sl_vec3 centre, sl_vec3 normal, double radius);
sl_voxel_gather sl_voxel_gather_photons(const sl_voxel_lights *lights, const sl_photon_query *query,
                                        sl_voxel_worker *worker);
sl_voxel_area sl_voxel_areas(const sl_voxel_lights *lights, const sl_voxel_gather *gather,
                             sl_voxel_worker *worker);
void sl_voxel_light_set(sl_voxel_lights *lights, size_t index, sl_voxel_worker *worker);

#endif
