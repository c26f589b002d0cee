/* What the parts of lighting voxels share: light_octree.c (a set of lights, step by step), voxel_gather.c
 * (its photons and their area), voxel_lights.c (all sets), voxel_sets.c (memory, and which sets a voxel has).
 */
#ifndef SL_CACHE_LIGHT_OCTREE_VOXEL_WORK_H
#define SL_CACHE_LIGHT_OCTREE_VOXEL_WORK_H

#include "cache/light_octree/normal_groups.h"
#include "cache/light_octree/photon_area.h"
#include "cache/light_octree/voxel_lobes.h"

enum { SL_LEAVES_A_TASK = 16 };

/* Where gathered photons lie on the ellipsoid's disc, those of the front first; for their hull. */
typedef struct sl_photon_places {
    float *x, *y;             /* NULL: not asked for */
    double *distance;         /* delta^2 */
    size_t front, count;
    sl_hull_points hull;
} sl_photon_places;

/* A worker's own. */
typedef struct sl_voxel_worker {
    sl_gathered_photons gathered;
    sl_lobe_photons photons;      /* both sides: room for twice k */
    sl_photon_places places;
    sl_triangle_marks marks;
    sl_voxel_piece *pieces;
    sl_counters counters;
} sl_voxel_worker;

/* The photons that lie in each leaf. */
typedef struct sl_own_photons {
    uint32_t *first;   /* leaf_count + 1 */
    uint32_t *place;   /* in the tree's list, by leaf, then id */
    size_t most;       /* in one leaf */
} sl_own_photons;

typedef struct sl_voxel_work {
    const sl_scene *scene;
    const sl_octree *octree;
    const sl_photon_tree *tree;
    bool clip;                    /* areas are those of clipped triangles */
    sl_own_photons own;           /* own_photons alone */
    double cos_acceptance;
    /* photons are taken side by side; off: all of them, whatever their normals */
    bool by_side;
    unsigned workers;
    sl_voxel_worker *worker;
} sl_voxel_work;

/* A for the photons in front and behind, and that of all surfaces together. */
typedef struct sl_voxel_area {
    double side[2], all;
} sl_voxel_area;

typedef struct sl_voxel_gather {
    sl_ellipsoid ellipsoid;       /* R; f = 1 without a normal */
    double kappa;
    size_t found;
    sl_lobe_photons front, back;  /* by the side of n_v; all in front where sides are not told apart */
    sl_vec3d mean_normal, mean_place; /* of the photons, turned to n_v's side; about the centre */
} sl_voxel_gather;

sl_photon_query sl_voxel_query(const sl_voxel_work *work, const sl_voxel_light_options *o, sl_vec3 centre,
                               sl_vec3 normal, double radius);
sl_voxel_gather sl_voxel_gather_photons(const sl_voxel_work *work, const sl_photon_query *query,
                                        sl_voxel_worker *w);
/* The photons of every leaf; and those of one. */
sl_status sl_own_photons_find(const sl_octree *octree, const sl_photon_tree *tree, sl_own_photons *own,
                              sl_error *error);
void sl_own_photons_release(sl_own_photons *own);
sl_voxel_gather sl_voxel_own_photons(const sl_voxel_work *work, const sl_voxel_set *set,
                                     const sl_photon_query *query, sl_voxel_worker *w);
/* The largest k that any voxel can take. */
size_t sl_voxel_most_neighbours(const sl_voxel_light_options *o);
/* Takes what is next to nothing (photons beside the geometry) for the disc. */
sl_voxel_area sl_voxel_areas(const sl_voxel_work *work, const sl_voxel_light_options *o,
                             const sl_voxel_gather *gather, sl_voxel_worker *w);

/* ---- light_octree.c ---- */

typedef struct sl_voxel_result {
    int lights;
    double irradiance[2];      /* E, luminance, on either side */
    sl_lobe_spread spread;
    double surface;            /* area of all the surfaces that the photons were strewn over */
    double density;            /* flux over that area: luminance */
} sl_voxel_result;

sl_voxel_result sl_voxel_make_lights(const sl_voxel_work *work, const sl_voxel_light_options *o,
                                     const sl_voxel_gather *gather, sl_voxel_worker *w,
                                     const sl_voxel_set *set, sl_directional_light *light);
void sl_voxel_light_set(sl_voxel_lights *lights, size_t index, sl_voxel_worker *w);

/* ---- voxel_lights.c ---- */

/* Moves what the workers have counted to the counters. */
void sl_voxel_lights_count(sl_voxel_lights *lights, sl_counters *counters);
double sl_luminance_of_photons(const sl_lobe_photons *photons);
int sl_lights_of_front(const double irradiance[2], int lights);
sl_photon_query sl_voxel_query_of_set(const sl_voxel_work *work, const sl_voxel_light_options *o,
                                      const sl_voxel_set *set, sl_vec3 centre, double radius);
void sl_voxel_take_directions_of_parent(const sl_voxel_lights *lights, sl_voxel_set *set, sl_voxel_worker *w,
                                        sl_voxel_result *own, sl_directional_light *light);
void sl_voxel_report_gather(sl_voxel_set *set, const sl_voxel_gather *gather, sl_counters *counters);
void sl_voxel_report_lights(sl_voxel_set *set, const sl_voxel_light_options *o, const sl_voxel_result *result,
                            sl_counters *counters);

#endif
