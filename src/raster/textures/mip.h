/* MIP maps: a texture's means over ever larger squares (Williams 1983), for what shows many texels at once.
 * Level 0 is the texture itself; the others are linear, since bytes in sRGB would shift the means. */
#pragma once

#include "base/math.h"
#include "scene/scene.h"

enum { SL_MIP_LEVELS = 16, SL_MIP_ONE = 65535 };

typedef struct sl_mip_level {
    int32_t width, height;
    /* four a texel, the fourth unused, SL_MIP_ONE is 1; the top row first; NULL at level 0 */
    uint16_t *texels;
} sl_mip_level;

typedef struct sl_mip {
    int32_t count; /* of levels: 0 where no surface is coloured by the texture */
    sl_mip_level level[SL_MIP_LEVELS];
} sl_mip;

/* Makes those of all textures that colour surfaces; *mips NULL: there are none. */
sl_status sl_mips_create(const sl_scene *scene, unsigned threads, sl_mip **mips, sl_error *error);
void sl_mips_destroy(const sl_scene *scene, sl_mip *mips);
/* Returns what the mips of a scene take. */
size_t sl_mips_need(const sl_scene *scene);

/* Returns the coarsest level whose texels are no wider than a footprint, whose square this is in texels of
 * level 0; 0 also for NaN. */
static inline int32_t sl_mip_level_for(float squared, int32_t count) {
    const int32_t level = ((int32_t)(sl_float_bits(squared >= 4.0f ? squared : 1.0f) >> 23) - 127) / 2;
    return level < count ? level : count - 1;
}

/* Returns k_d at a point whose footprint is so wide; isotropic: what is seen askance is filtered less than it
 * might be, never more. */
sl_rgb sl_scene_diffuse_within(const sl_scene *scene, const sl_mip *mips, uint32_t triangle, float w1,
                               float w2, float width);
