/* From the photon map to the virtual directional lights of every voxel:
 *
 *     leaf ── gather k photons about c_v ── area, E ── clusters of directions ── V_j, d_j, c_j
 *
 * Leaves do not depend on each other, so they may be done in batches, in any order and in parallel. */
#ifndef SL_CACHE_LIGHT_OCTREE_VOXEL_LIGHTS_H
#define SL_CACHE_LIGHT_OCTREE_VOXEL_LIGHTS_H

#include "cache/light_octree/lights.h"
#include "cache/light_octree/octree.h"

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
    bool split_by_normal;    /* a set of lights for each group of normals (normal_groups.h) */
} sl_voxel_light_options;

/* 1.4 sqrt(k A / (pi N)): 1.4 times the radius of a disc that holds k of N photons strewn evenly over the
 * scene's area A. At least one voxel. */
double sl_voxel_radius(const sl_octree *octree, size_t neighbours, uint64_t photons);

enum { SL_VOXEL_FEW = 8, SL_VOXEL_SETS_MAX = 6 };

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
    float power_ratio;     /* largest over mean power of a photon: fireflies */
    uint8_t lights;        /* used */
    /* another of the voxel's sets faces the other way: light of that side is that one's */
    bool opposed;
    bool layered;          /* another has about the same normal, but lies higher or lower */
    bool both_sides;       /* photons on both sides */
    bool flat;             /* light is seen by that normal alone: a light along it says all */
    /* fewer than SL_VOXEL_FEW photons: directions are those of the parent cell's photons */
    bool from_parent;
    bool done;
} sl_voxel_set;

typedef struct sl_voxel_lights {
    sl_voxel_light_options options;
    size_t leaf_count, set_count;
    uint32_t *first_set;   /* leaf_count + 1; a leaf has one set unless split by normal */
    sl_voxel_set *set;
    int texels;            /* of a set: n, or 1 (colour octree) */
    sl_directional_light *light; /* set_count * texels, unused ones 0 */
    struct sl_voxel_work *work;
} sl_voxel_lights;

/* Scene, octree and tree must outlive the lights. */
sl_status sl_voxel_lights_create(const sl_scene *scene, const sl_octree *octree,
                                 const sl_photon_tree *tree, const sl_voxel_light_options *options,
                                 unsigned threads, sl_voxel_lights **lights, sl_error *error);
/* The lights of leaves [first, first + count). Adds what was gathered, leaves, and lights to the counters. */
void sl_voxel_lights_compute(sl_voxel_lights *lights, size_t first, size_t count, unsigned threads,
                             sl_counters *counters);
void sl_voxel_lights_destroy(sl_voxel_lights *lights);
size_t sl_voxel_lights_bytes(const sl_voxel_lights *lights);

/* Over the sets that are done. Means are over the lit ones. */
typedef struct sl_voxel_statistics {
    uint64_t sets, lit, from_parent, coincident; /* coincident: R at its least */
    uint64_t lights, photons;
    double mean_photons, mean_radius;
    double rms_angle;        /* sqrt of the mean square, by irradiance: radians */
    double flux;             /* sum of flux density times the voxel's own area: luminance, W */
    double max_power_ratio;
} sl_voxel_statistics;
void sl_voxel_lights_statistics(const sl_voxel_lights *lights, const sl_octree *octree,
                                sl_voxel_statistics *statistics);

#endif
