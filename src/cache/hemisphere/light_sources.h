/* What a gather's hits draw light samples from: the emitters and the environment. One table in
 * structure-of-arrays form, with what it takes to tell how much each source can matter at a point and to
 * sample it.
 *
 * Emitters come in blocks of sixteen along a Morton curve, so that a block's lie together: what cannot be
 * seen from somewhere is mostly a whole block. The environment has one to itself. */
#ifndef SL_CACHE_GATHER_LIGHT_SOURCES_H
#define SL_CACHE_GATHER_LIGHT_SOURCES_H

#include "scene/scene.h"

enum {
    SL_LIGHT_SOURCES_MAX = 256, /* more are chosen by the light tree (trace/light_tree.h) */
    SL_SOURCE_LANES = 16,
    SL_SOURCE_BLOCKS_MAX = SL_LIGHT_SOURCES_MAX / SL_SOURCE_LANES + 2
};

/* `unit` is a power of two that makes the scene about 1 long, so that squared distances neither overflow nor
 * vanish; strengths are relative to the strongest source. Entries that fill up a block have strength 0. */
typedef struct sl_light_sources {
    const sl_scene *scene;
    size_t count, blocks;              /* entries; a multiple of 16 */
    size_t sky;                        /* the entry of the environment, behind the emitters'; or `count` */
    float unit;
    uint32_t *index;                   /* of the scene's emitter; SL_NO_INDEX: none */
    float *x, *y, *z;                  /* centroid */
    float *normal_x, *normal_y, *normal_z;
    float *extent;                     /* largest distance of a corner from the centroid, in units */
    float *near;                       /* within this squared distance (units) it is sampled by solid angle */
    float *two_sided;                  /* 1 or 0 */
    float *strength;                   /* radiance times area */
    float *radiance;                   /* mean, relative as the strength */
    float *corner[3][3];               /* corner, then axis */
    float *area;
    float *red, *green, *blue;         /* radiance */
    float absolute;                    /* what strength 1 is in W/m^2 */
    float sky_irradiance[6];           /* relative, on planes that face +x, -x, +y, -y, +z, -z */
    void *block;                       /* of the columns */
} sl_light_sources;

/* At most SL_LIGHT_SOURCES_MAX sources. */
sl_status sl_light_sources_create(const sl_scene *scene, sl_light_sources **sources, sl_error *error);
void sl_light_sources_destroy(sl_light_sources *sources);
size_t sl_light_sources_bytes(const sl_light_sources *sources);

#endif
