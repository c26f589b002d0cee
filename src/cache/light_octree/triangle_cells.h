/* The part of a triangle that lies in a box, by clipping (Sutherland and Hodgman 1974), in double. */
#ifndef SL_CACHE_LIGHT_OCTREE_TRIANGLE_CELLS_H
#define SL_CACHE_LIGHT_OCTREE_TRIANGLE_CELLS_H

#include "base/vec.h"

typedef struct sl_cell_triangle {
    sl_vec3d corner[3], normal; /* the normal not unit: its length is twice the area */
} sl_cell_triangle;

static inline sl_cell_triangle sl_cell_triangle_of(sl_vec3d a, sl_vec3d b, sl_vec3d c) {
    return (sl_cell_triangle){{a, b, c}, sl_crossd(sl_subd(b, a), sl_subd(c, b))};
}

static inline double sl_along(sl_vec3d p, int axis) { return axis == 0 ? p.x : axis == 1 ? p.y : p.z; }

/* Of a triangle's part in a box: corners in order, area and centroid. */
enum { SL_TRIANGLE_PART_CORNERS = 12 /* 9, but for rounding */ };
typedef struct sl_triangle_part {
    int count;   /* of corners: 0 if nothing is left */
    sl_vec3d corner[SL_TRIANGLE_PART_CORNERS];
    double area;
    sl_vec3d centroid; /* mean of the corners where the area is 0 */
} sl_triangle_part;

/* Boxes are closed: what touches one leaves a point or an edge. */
void sl_triangle_in_box(const sl_cell_triangle *triangle, sl_vec3d low, sl_vec3d high,
                        sl_triangle_part *clipped);
/* Cuts off the part with sign * (p_axis - plane) <= 0; its corners alone. */
void sl_triangle_part_below(const sl_triangle_part *part, int axis, double plane, double sign,
                            sl_triangle_part *below);

#endif
