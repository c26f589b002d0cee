/* Which cells of a grid a triangle meets: separating axes (Akenine-Moeller 2001), in double, and the part of
 * it that lies in one. */
#ifndef SL_CACHE_LIGHT_OCTREE_TRIANGLE_CELLS_H
#define SL_CACHE_LIGHT_OCTREE_TRIANGLE_CELLS_H

#include "base/vec.h"

#include <stdbool.h>

/* Three axes are the box's, nine are cross products of its edges with the triangle's, one is the normal. */
typedef struct sl_cell_triangle {
    sl_vec3d corner[3], edge[3], normal; /* the normal not unit: its length is twice the area */
} sl_cell_triangle;

sl_cell_triangle sl_cell_triangle_of(sl_vec3d a, sl_vec3d b, sl_vec3d c);
/* Does it meet the closed box? */
bool sl_triangle_meets_box(const sl_cell_triangle *triangle, sl_vec3d low, sl_vec3d high);

/* Of a triangle's part in a box: corners in order, area and centroid. */
enum { SL_TRIANGLE_PART_CORNERS = 9 };
typedef struct sl_triangle_part {
    int count;   /* of corners: 0 if nothing is left */
    sl_vec3d corner[SL_TRIANGLE_PART_CORNERS];
    double area;
    sl_vec3d centroid; /* mean of the corners where the area is 0 */
} sl_triangle_part;
void sl_triangle_in_box(const sl_cell_triangle *triangle, sl_vec3d low, sl_vec3d high,
                        sl_triangle_part *clipped);

#endif
