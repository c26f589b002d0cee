/* Dividing an area light into the points that receivers are lit from. */
#ifndef SL_CACHE_DIRECT_RADIANCE_LIGHT_POINTS_H
#define SL_CACHE_DIRECT_RADIANCE_LIGHT_POINTS_H

#include "cache/direct_radiance/lights.h"

/* Nearer than d = 2 s to an area light of side s, (9) errs (on its axis by 8 % at 2 s, 33 % at s): n x n cells of the least rectangle around
 * the light in its plane become a point each, at the middle of the light's part of the cell, with that part's share of the flux. At
 * most n * n points are written; returns how many: cells without light have none. emitter: the light's own. */
size_t sl_map_light_divide(const sl_scene *scene, const sl_map_light *light, const uint32_t *emitter, int n, sl_map_light_point *point);

/* The place of one of a masked triangle's points (sl_scene_mask_point()); false where the mask takes it away. */
bool sl_map_light_mask_point(const sl_scene *scene, uint32_t triangle, int index, sl_vec3d *at);

#endif
