/* Bicubic Bezier surfaces: points and normals of the surface itself, and its triangles in the scene. */
#pragma once

#include "scene/scene.h"

enum { SL_BICUBIC_STEPS = 16 }; /* of surfaces from files */

/* Point and unit normal, on the side of dB/du x dB/dv; where that is 0, as at poles, the limit of normals
 * from the middle of the surface. u, v in [0,1]. Either may be NULL. */
void sl_bicubic_at(const sl_bicubic *surface, double u, double v, sl_vec3 *position, sl_vec3 *normal);

/* Vertices and triangles of a surface, as sl_bicubic has them: (steps + 1)^2 positions, unit normals, texture
 * coordinates (u, v); 2 steps^2 triangles, those without area too, their corners counted from
 * surface->first_vertex on. */
void sl_bicubic_tessellate(const sl_bicubic *surface, float *positions, float *normals,
                           float *texture_coordinates, uint32_t *triangles);
/* Tells whether it has any area to speak of. */
bool sl_bicubic_has_area(const sl_bicubic *surface);
/* The scene triangle of a cell: half 0 has (+1, 0) for a corner, half 1 (0, +1). SL_NO_INDEX where it has no
 * area. */
uint32_t sl_bicubic_triangle(const sl_scene *scene, const sl_bicubic *surface, int column, int row, int half);
