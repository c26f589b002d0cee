/* The search for the nearest photons, compiled for every instruction set. Photons lie sixteen to a bucket,
 * the leaves of the kd-tree from left to right; its nodes are boxes in depth-first order: the left child
 * follows its parent, and a subtree of n leaves has 2 n - 1 nodes. */
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "base/isa.h"
#include "base/vec.h"

enum { SL_PHOTON_BUCKET = 16 };

/* Empty lanes of the last bucket are NaN: they are near to nothing. */
typedef struct sl_photon_bucket {
    _Alignas(64) float x[SL_PHOTON_BUCKET];
    float y[SL_PHOTON_BUCKET], z[SL_PHOTON_BUCKET];
    float normal_x[SL_PHOTON_BUCKET], normal_y[SL_PHOTON_BUCKET], normal_z[SL_PHOTON_BUCKET];
    uint32_t id[SL_PHOTON_BUCKET];
} sl_photon_bucket;

typedef struct sl_photon_box {
    float centre[3], half[3]; /* half: rounded up */
} sl_photon_box;

typedef struct sl_photon_buckets {
    size_t count;
    const sl_photon_bucket *bucket;
    const sl_photon_box *box; /* 2 count - 1 */
} sl_photon_buckets;

/* Leaves below the left child of a node with so many below it. */
static inline size_t sl_photon_left_leaves(size_t leaves) { return (leaves + 1) / 2; }

typedef struct sl_photon_search {
    sl_vec3 centre, normal;
    float stretch;       /* 1 / f^2 - 1: delta^2 = |p|^2 + stretch u^2, without a difference */
    float cos_acceptance;
    float back;          /* what a cosine below 0 is multiplied by: -1 where both sides count, else 1 */
    float bound;         /* delta^2 of the farthest photon that may still count */
    size_t wanted, room; /* k, and keys: at least k + 2 SL_PHOTON_BUCKET */
    size_t count;
    uint64_t *key;       /* bits of delta^2, then the id: their order is that of (delta^2, id) */
} sl_photon_search;

/* Leaves the k smallest keys, in no order. */
SL_KERNELS(void, sl_photon_search, (const sl_photon_buckets *buckets, sl_photon_search *search));
