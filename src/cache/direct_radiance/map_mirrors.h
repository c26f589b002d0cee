/* Planar mirrors in a light's view: the light's image L' behind the mirror takes pictures of its own.
 *
 *        L                 The picture is one of L's own, cut to the rectangle around the mirror, and reflected: every
 *         \    y           texel sees y along the unfolded way from L', within the solid angle in which L sees it by way
 *       ___\__/___         of the mirror (a plane mirror keeps solid angles). Texels in which L does not see the mirror
 *           \/   mirror    itself (something stands before it, or it ends) are empty: a first pass, the stencil, tells. */
#ifndef SL_CACHE_DIRECT_RADIANCE_MAP_MIRRORS_H
#define SL_CACHE_DIRECT_RADIANCE_MAP_MIRRORS_H

#include "cache/direct_radiance/map_faces.h"

/* The triangles of each mirror, mirror after mirror: mirror m's are triangle[first[m]] to triangle[first[m + 1]]. */
typedef struct sl_mirror_triangles {
    size_t *first;
    uint32_t *triangle;
} sl_mirror_triangles;

sl_status sl_mirror_triangles_list(const sl_scene *scene, const sl_mirrors *mirrors, sl_mirror_triangles *list, sl_error *error);
void sl_mirror_triangles_free(sl_mirror_triangles *list);

/* The face that `of` sees in mirror m; false where the mirror lies outside of it, or the light in the mirror's plane. Blocks are about as
 * large as the picture's own, and at least half as many each way. */
bool sl_map_face_in_mirror(const sl_scene *scene, const sl_mirrors *mirrors, const sl_mirror_triangles *list, uint32_t mirror,
                           const sl_map_light *light, const sl_face_shape *shape, const sl_planned_face *of, sl_planned_face *mirrored);

#endif
