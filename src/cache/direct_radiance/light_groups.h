/* Which emissive triangles make one light, and which lights are merged where there are too many. */
#ifndef SL_CACHE_DIRECT_RADIANCE_LIGHT_GROUPS_H
#define SL_CACHE_DIRECT_RADIANCE_LIGHT_GROUPS_H

#include "scene/scene.h"

/* Group numbers of the scene's emitters, by their first emitter; SL_NO_INDEX for those without finite flux. Triangles of one object and
 * material that share a corner and lie in one plane are one group. */
sl_status sl_emitters_group(const sl_scene *scene, uint32_t *group, size_t *groups, sl_error *error);

/* One light among those to be merged. */
typedef struct sl_light_seed {
    int kind;         /* only seeds of one kind are merged */
    double power;     /* >= 0 */
    sl_vec3 position; /* 0 where it means nothing */
    sl_vec3 normal;
} sl_light_seed;

/* Which of at most `most` clusters each of `count` seeds belongs to, numbered by their first seed: the seeds themselves where they are few
 * enough; else the cluster that has most power spread widest, in position and normal, is split again and again: strong lights end up
 * alone, the weakest together. */
sl_status sl_light_seeds_merge(const sl_light_seed *seed, size_t count, size_t most, float size, uint32_t *cluster, size_t *clusters,
                               sl_error *error);

#endif
