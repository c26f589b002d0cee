/* The octree and its lights as the paper's hardware holds them: bricks of 2x2x2 RGBA8 texels in a 3D texture,
 * 24-bit addresses, and a texture of lights. */
#pragma once

#include "cache/light_octree/voxel_lights.h"
#include "raster/textures/textures.h"

enum { SL_TEXEL_VOID = 0, SL_TEXEL_NODE = 127, SL_TEXEL_LEAF = 255 }; /* alpha */
enum { SL_LIGHT_TEXTURE_SIZE = 4096 }; /* of lights: 12 + 12 bits of address */

/* A texel: a light, its direction unpacked. (The hardware's has it packed, and is one of 16 bytes.) */
typedef struct sl_unpacked_light {
    float direction[3], color[3];
} sl_unpacked_light;

/* Texels behind a leaf's address: a set of lights for each of its groups of normals, one after the other in
 * one row: a head, whose direction is the group's normal, and as many lights as there are. Leaves without
 * light share the first texel. */
typedef struct sl_voxel_texture {
    int depth;
    sl_vec3d origin;
    double edge, scale;         /* of the root; cells of the deepest level by length */
    sl_volume *bricks;          /* RGBA8 */
    sl_voxel_lobes lobes;
    int lights;                 /* of a set, at most */
    size_t set_count;           /* with light, and one for all leaves without */
    size_t texel_count;
    sl_unpacked_light *light;   /* row by row, the last not full */
} sl_voxel_texture;

/* A set's head, and its lights. */
typedef struct sl_shade_set {
    const sl_unpacked_light *light;
    int lights;
    sl_vec3 normal;             /* (0,0,0): none */
    bool turn;                  /* which turns to the viewer */
    /* another of the voxel's sets has its normal: points take the one at their height */
    bool layer;
    float height;               /* of a layer above the voxel's centre, in voxels */
    bool more;                  /* another set follows */
} sl_shade_set;
sl_shade_set sl_voxel_texture_set(const sl_voxel_texture *texture, size_t texel);

/* More sets than addresses is an error that says how many. */
sl_status sl_voxel_texture_create(const sl_octree *octree, const sl_voxel_lights *lights,
                                  sl_voxel_texture **texture, sl_error *error);
void sl_voxel_texture_destroy(sl_voxel_texture *texture);
/* Returns the bytes of bricks and lights that the hardware would hold. */
size_t sl_voxel_texture_bytes(const sl_voxel_texture *texture);
/* Returns the bytes that this takes. */
size_t sl_voxel_texture_resident_bytes(const sl_voxel_texture *texture);
/* Descends to a cell of the deepest level: the place of its leaf's first texel, or SIZE_MAX where it is void
 * or outside the root. fetches is added to. */
size_t sl_voxel_texture_find(const sl_voxel_texture *texture, const int32_t cell[3], uint64_t *fetches);
