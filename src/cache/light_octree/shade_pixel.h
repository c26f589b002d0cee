/* One pixel as the shader has it, before the loop over lights: for those who tell what made it. */
#ifndef SL_CACHE_LIGHT_OCTREE_SHADE_PIXEL_H
#define SL_CACHE_LIGHT_OCTREE_SHADE_PIXEL_H

#include "cache/light_octree/shade.h"
#include "cache/light_octree/shade_kernels.h"

typedef struct sl_octree_pixel {
    sl_shade_block block;      /* the pixel, SL_SHADE_LANES times */
    sl_shade_cells cells;      /* its eight voxels, or the nearest alone */
    int32_t cell[3];           /* the first of them */
    bool glossy;
    float diffuse[3], specular[3];
} sl_octree_pixel;

/* Of a pixel that shows a surface which is no mirror. False where that gets no light. */
bool sl_octree_pixel_cells(const sl_octree_shading *shading, const sl_scene *scene, const sl_gbuffer *gbuffer,
                           sl_vec3 eye, size_t pixel, sl_octree_pixel *out);

#endif
