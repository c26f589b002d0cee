/* The balanced kd-tree over photons, implicit in their order, and the k nearest of them in a flattened
 * ellipsoid: delta^2 = |p_t|^2 + (u / f)^2, u the distance from the plane and p_t the way along it, f the
 * flatness. Nodes are split at the median of the longest extent, by (coordinate, id), down to sixteen
 * photons; each has its box. */
#pragma once

#include "cache/photons/photon_search.h"
#include "cache/photons/photons.h"

typedef struct sl_photon_tree sl_photon_tree;

/* Takes the photons over: reorders them, and destroys the list with the tree, or at once where it fails. */
sl_status sl_photon_tree_create(sl_photon_list *list, unsigned threads, sl_photon_tree **tree,
                                sl_error *error);
void sl_photon_tree_destroy(sl_photon_tree *tree);
const sl_photon_list *sl_photon_tree_list(const sl_photon_tree *tree);
/* The place in the list before it was reordered. */
uint32_t sl_photon_tree_id(const sl_photon_tree *tree, size_t place);
size_t sl_photon_tree_bytes(const sl_photon_tree *tree);

enum { SL_NEIGHBOURS_MAX = 4096 };

/* delta^2(p) = |p_t|^2 + (u / f)^2, u = (p - centre) . normal. */
typedef struct sl_photon_query {
    sl_vec3 centre;
    sl_vec3 normal;      /* unit; (0,0,0): a sphere whatever the flatness, photons of all normals */
    double flatness;     /* f */
    double radius;       /* r */
    double minimum;      /* R is at least that: coincident photons */
    double cos_acceptance; /* photon normals with a smaller cosine to `normal` are passed over; -1: none */
    bool both_sides;     /* the cosine's size alone counts: photons on the back of a sheet are found too */
    size_t neighbours;   /* k; SL_NEIGHBOURS_MAX where it is more */
} sl_photon_query;

typedef struct sl_gathered_photons {
    size_t count;        /* found: at most k */
    uint32_t *place;     /* of the photons in the list, in order of their ids; room for k */
    double *distance;    /* delta^2, beside them; room for k */
    uint64_t *keys;      /* for the search: room for 3 k + 2 SL_PHOTON_BUCKET */
    double radius;       /* R: set by the k-th, or r where fewer were found */
    bool full;           /* k were found: E carries (k-1)/k */
} sl_gathered_photons;

/* Ties of distance go to the lower id, exactly k are kept. Allocates nothing. */
void sl_photon_tree_gather(const sl_photon_tree *tree, const sl_photon_query *query,
                           sl_gathered_photons *gathered);
