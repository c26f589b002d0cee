/* Inside pass 4: which objects are curved mirrors, where their cubes are taken from and without what, and what is kept of them. */
#ifndef SL_CACHE_DIRECT_RADIANCE_MIRROR_OBJECTS_H
#define SL_CACHE_DIRECT_RADIANCE_MIRROR_OBJECTS_H

#include "cache/direct_radiance/mirrors.h"
#include "raster/textures/textures.h"

typedef struct sl_mirror_object {
    uint32_t object;      /* of the scene */
    sl_vec3 low, high;    /* box of its curved mirror surface */
    sl_vec3 centre;       /* its middle, where the cube's eye is */
} sl_mirror_object;

typedef struct sl_mirror_objects {
    size_t count;
    sl_mirror_object *object; /* in scene order */
    uint32_t *cube_of;        /* by the scene's object: its number here, or SL_NO_INDEX */
} sl_mirror_objects;

/* Mirror material, and in no plane that is followed as a planar mirror. */
static inline bool sl_is_curved_mirror(const sl_scene *scene, const sl_mirrors *planar, uint32_t triangle) {
    return sl_material_is_mirror(&scene->materials[scene->material_index[triangle]]) &&
           !(planar && planar->of_triangle[triangle] != SL_NO_INDEX);
}

/* Those that `seen` shows, or NULL: all. count may be 0. */
sl_status sl_mirror_objects_find(const sl_scene *scene, const sl_mirrors *planar, const sl_receivers *seen, sl_mirror_objects *objects,
                                 sl_error *error);
void sl_mirror_objects_release(sl_mirror_objects *objects);
/* Marks, by triangle, the mirror surface of the object within its box: its curved one, and planar parts of the same body (a lid, a facet);
 * a flat mirror on a wall that is part of the same object is not left out. */
void sl_mirror_object_mark(const sl_scene *scene, const sl_mirror_object *object, uint8_t *left_out);

/* Light apart by where it comes from; a part that a cube cannot hold is NULL. */
enum { SL_CUBE_EMISSION, SL_CUBE_DIRECT, SL_CUBE_INDIRECT, SL_CUBE_PARTS };
typedef struct sl_environment_cube {
    sl_cube_map *part[SL_CUBE_PARTS];
} sl_environment_cube;

struct sl_curved_mirrors {
    const sl_scene *scene;
    const sl_mirrors *planar;
    sl_mirror_objects objects;
    sl_environment_cube *cube; /* of each object */
};

#endif
