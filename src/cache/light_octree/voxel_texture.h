/* The octree and its lights as the paper's hardware holds them: bricks of 2x2x2 RGBA8 texels in a 3D texture,
 * 24-bit addresses, and a texture of lights. */
#ifndef SL_CACHE_LIGHT_OCTREE_VOXEL_TEXTURE_H
#define SL_CACHE_LIGHT_OCTREE_VOXEL_TEXTURE_H

#include "cache/light_octree/voxel_lights.h"
#include "raster/textures/textures.h"

enum { SL_TEXEL_VOID = 0, SL_TEXEL_NODE = 127, SL_TEXEL_LEAF = 255 }; /* alpha */
enum { SL_LIGHT_TEXTURE_SIZE = 4096 }; /* 12 + 12 bits of address */

/* A light as the processor likes it: its direction is unpacked. */
typedef struct sl_unpacked_light {
    float direction[3], color[3];
} sl_unpacked_light;

/* Of a whole voxel's set: n_v, or (0,0,0); turn: it stands for the other side too. */
typedef struct sl_array_facing {
    sl_vec3 normal;
    bool turn;
} sl_array_facing;

/* What a leaf's address leads to. Of whole voxels, an array of n lights each. Split ones have a set of lights
 * for each group of normals, one after the other, as long as it has to be: a head, whose direction is the
 * group's normal, and as many lights as there are. A set that is a single light along its normal (a flat
 * surface) is that light alone. A leaf's sets lie in one row; leaves without light share the first texel. */
typedef struct sl_voxel_texture {
    int depth;
    sl_vec3d origin;
    double edge;
    sl_volume *bricks;          /* RGBA8 */
    size_t brick_count;
    sl_voxel_lobes lobes;
    bool split;                 /* by normals */
    int lights;                 /* texels of an array; the most lights of a split voxel's set */
    int width, height;          /* of the texture of lights */
    size_t array_count;         /* sets with light, and one for all leaves without */
    size_t texel_count;         /* in use */
    sl_directional_light *light; /* width * height texels */
    sl_unpacked_light *unpacked; /* the same: the CPU's short cut, as is */
    sl_array_facing *facing;    /* of each whole voxel's array */
    /* the first texel's place for each cell of the deepest level, SL_NO_INDEX for void: may be NULL */
    uint32_t *index;
} sl_voxel_texture;

/* The first texel of a split voxel's set. A head's red is -1 - lights, its green the flags, its blue the
 * height of a layer; of a light alone they stand above the sixteen bits of its direction. */
enum { SL_SET_TURNS = 1, SL_SET_MORE = 2, SL_SET_NO_NORMAL = 4, SL_SET_ONE_SIDED = 8, SL_SET_LAYER = 16 };
typedef struct sl_set_head {
    int texels;                 /* of the head: 1, or 0 where the light stands alone */
    int lights;
    bool has_normal;            /* its direction */
    bool turn;                  /* which turns to the viewer, to choose among the voxel's sets */
    /* lit on that side alone: it tells nothing of what faces the other way, as a floor does below a sofa */
    bool one_sided;
    /* another of the voxel's sets has its normal: points take the one at their height */
    bool layer;
    float height;               /* of a layer above the voxel's centre, in voxels */
    bool more;                  /* another set follows */
} sl_set_head;
sl_set_head sl_voxel_texture_head(const sl_voxel_texture *texture, size_t texel);

/* More arrays than addresses is an error that says how many. */
sl_status sl_voxel_texture_create(const sl_octree *octree, const sl_voxel_lights *lights, bool dense_index,
                                  sl_voxel_texture **texture, sl_error *error);
void sl_voxel_texture_destroy(sl_voxel_texture *texture);
/* bricks and lights alone: what the hardware would hold */
size_t sl_voxel_texture_bytes(const sl_voxel_texture *texture);
/* and the CPU's short cuts: unpacked lights, normals of whole voxels, the index */
size_t sl_voxel_texture_resident_bytes(const sl_voxel_texture *texture);
/* The descent: the texel at which it ends, and the array's address where that is a leaf. fetches is added to.
 */
uint32_t sl_voxel_texture_find(const sl_voxel_texture *texture, sl_vec3 p, uint32_t *address,
                               uint64_t *fetches);
const sl_directional_light *sl_voxel_texture_lights(const sl_voxel_texture *texture, uint32_t address);
/* The same by cell of the deepest level: the texel (void outside the root); and the place of the first texel
 * at an address. */
uint32_t sl_voxel_texture_find_cell(const sl_voxel_texture *texture, const int32_t cell[3],
                                    uint64_t *fetches);
size_t sl_voxel_texture_place(const sl_voxel_texture *texture, uint32_t address);

#endif
