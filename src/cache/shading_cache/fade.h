/* Values that come in slowly, so that nothing pops (beta below 1; section on blending): a vertex of an unchanged scene that gets its first sample starts from what the picture
 * has shown there, and goes beta of the way in each update: (1 - beta)^k are left after k. After an edit nothing fades: what has changed is to be seen. */
#ifndef SL_SHADING_CACHE_FADE_H
#define SL_SHADING_CACHE_FADE_H

#include "cache/patches/patches.h"

typedef struct sl_fade {
    uint32_t vertex, evaluated; /* another value by now: evaluated in another update */
    float left;                 /* (1 - beta)^k */
    float value[3], lobe[3];    /* where it goes */
} sl_fade;

typedef struct sl_fades {
    sl_fade *fade;
    size_t count, capacity;
} sl_fades;

/* What the patches show at a vertex between others; false: nothing around it has been evaluated. lobe: wanted where the vertex has one. */
bool sl_fade_from(const sl_patches *patches, uint32_t vertex, float value[3], float lobe[3]);
/* The vertex has its value; from now on it shows what lies between `from` and that. Without memory it shows its value. */
void sl_fade_begin(sl_fades *fades, sl_patches *patches, uint32_t vertex, const float from[3], const float from_lobe[3], float beta);
/* Once an update, before new ones begin. */
void sl_fades_go_on(sl_fades *fades, sl_patches *patches, float beta);
void sl_fades_finish(sl_fades *fades, sl_patches *patches);
void sl_fades_release(sl_fades *fades);

#endif
