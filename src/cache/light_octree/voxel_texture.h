/* The octree and its lights as the paper's hardware holds them: bricks of 2x2x2 RGBA8 texels in a 3D texture, 24-bit addresses, and a
 * texture of lights (section 2.6). */
#ifndef SL_CACHE_LIGHT_OCTREE_VOXEL_TEXTURE_H
#define SL_CACHE_LIGHT_OCTREE_VOXEL_TEXTURE_H

#include "cache/light_octree/lights.h"
#include "cache/light_octree/octree.h"
#include "raster/textures/textures.h"

enum { SL_TEXEL_VOID = 0, SL_TEXEL_NODE = 127, SL_TEXEL_LEAF = 255 }; /* alpha */

typedef struct sl_voxel_texture {
    int depth;
    sl_vec3d origin;
    double edge;
    sl_volume *bricks;          /* RGBA8 */
    size_t brick_count;
    int lights;                 /* n: texels of an array */
    int width, height;          /* of the texture of lights: arrays never wrap */
    sl_directional_light *light; /* width * height texels */
    uint32_t *index;            /* a leaf number for each cell of the deepest level, SL_NO_INDEX for void: the CPU's short cut; may be NULL */
    bool wide_directions;
} sl_voxel_texture;

/* lights: n for each leaf, leaf by leaf, unused ones 0. More leaves than addresses is an error that says how many. */
sl_status sl_voxel_texture_create(const sl_octree *octree, int n, const sl_directional_light *lights, bool wide_directions, bool dense_index,
                                  sl_voxel_texture **texture, sl_error *error);
void sl_voxel_texture_destroy(sl_voxel_texture *texture);
size_t sl_voxel_texture_bytes(const sl_voxel_texture *texture); /* bricks and lights alone */
/* The descent: the texel at which it ends, and the array's address where that is a leaf. fetches is added to. */
uint32_t sl_voxel_texture_find(const sl_voxel_texture *texture, sl_vec3 p, uint32_t *address, uint64_t *fetches);
const sl_directional_light *sl_voxel_texture_lights(const sl_voxel_texture *texture, uint32_t address);

#endif
