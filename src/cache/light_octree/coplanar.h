/* Coplanar triangles that lie over one another (a face modelled twice, decals, both windings of one sheet)
 * are one surface: its area, where photons fall, counts once. */
#ifndef SL_CACHE_LIGHT_OCTREE_COPLANAR_H
#define SL_CACHE_LIGHT_OCTREE_COPLANAR_H

#include "scene/scene.h"

/* Of each triangle's area, the share that no larger coplanar triangle covers (of equal ones none of a lower
 * number); *share is NULL where all are 1. Freed with sl_free(). Planes count as equal within 1e-6 of the
 * scene's size; each triangle is compared with the next 64 in its plane. */
sl_status sl_coplanar_shares(const sl_scene *scene, unsigned threads, float **share, sl_error *error);

#endif
