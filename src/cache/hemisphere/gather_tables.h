/* The tables of an instrument: what every cell of its picture weighs, and how the walls between cells move
 * with the receiver. Made once, in double; read by every gather.
 *
 * All three instruments are one regular grid of cells, width x height, kept flat (cell = y * width + x):
 *   plane     N x N pixels of the plane at unit distance
 *   hemicube  2N x 2N: the top in the middle, the upper halves of the four sides folded out around it; the
 *             four corner blocks are blank
 *   rays      N x N cells of the concentric map (Shirley and Chiu 1997)
 * so that one loop sums any picture. Cell i's column wall lies between i - 1 and i, its row wall between i -
 * width and i; walls that do not exist have the vector 0. */
#pragma once

#include <stdint.h>

#include "base/vec.h"
#include "cache/hemisphere/gather.h"

enum { SL_GATHER_LANES = 8 };

/* Of walls: dE/dx, dE/dy = (L_i - L_i-1) (x, y) / smaller depth; and second derivatives, d2E/dx2, d2E/dxdy,
 * d2E/dy2 = (L_i - L_i-1) (xx, xy, yy) / smaller depth squared. */
typedef struct sl_wall_planes {
    float *x, *y, *xx, *xy, *yy;
} sl_wall_planes;

typedef struct sl_gather_tables {
    sl_gather_kind kind;
    sl_border border;    /* of the plane, as */
    double half_tangent;
    double scale;        /* of all weights: 1, or what divides by the plane's coverage */
    int size, width, height;
    size_t cells;  /* width * height */
    size_t padded; /* rounded up to whole lanes; everything beyond `cells` is 0 */
    size_t used;   /* cells that are not blank */
    double weight_sum;
    void *block;   /* the one allocation behind all the planes */

    /* Cosine weight W; W over the distance at unit depth (for the harmonic mean); tangential part of the
     * cell's vector V. */
    float *weight, *weight_by_depth, *vector_x, *vector_y;
    sl_wall_planes column, row;
    /* Direction of the cell's centre in the local frame, in units of its depth: (u, v, 1) on the plane, one
     * face axis 1 on the hemicube, unit for rays. And its length. */
    float *direction_x, *direction_y, *direction_z, *length;
    /* Used cells in the order in which they are traced and shaded: tiles of 4 x 4. */
    uint32_t *order;
    /* rays: the lower corner of cell order[k] in the square that the concentric map maps */
    float *slot_a, *slot_b;
} sl_gather_tables;

/* size: 4 to 1024, even for the hemicube (rounded up). half_tangent = tan(fov / 2), for the plane. Without
 * walls: for those who want no derivatives. */
sl_status sl_gather_tables_create(sl_gather_kind kind, int size, double half_tangent, sl_border border,
                                  bool walls, sl_gather_tables **tables, sl_error *error);
void sl_gather_tables_destroy(sl_gather_tables *tables);
size_t sl_gather_tables_bytes(const sl_gather_tables *tables);

/* Returns the direction of the picture's point (x, y), in cells from its lower left corner, in units of
 * depth. */
sl_vec3d sl_gather_direction(const sl_gather_tables *tables, double x, double y);

/* Returns whether the outer pixels stand for what lies between them and the horizon, too. */
static inline bool sl_gather_is_extended(const sl_gather_tables *tables) {
    return tables->kind == SL_GATHER_PLANE && tables->border == SL_BORDER_RADIAL;
}

/* The concentric map of Shirley and Chiu, [-1,1]^2 to the unit disc: radius a, azimuth pi/4 b/a where |a| >
 * |b|; else radius b, azimuth pi/2 - pi/4 a/b. A negative radius is the opposite side. Equal areas stay
 * equal. */
void sl_concentric_disc(double a, double b, double *x, double *y);

/* ---- exact integrals over cells and walls, in double ---- */

/* Any cell bounded by great circles, corners a_i counter-clockwise seen from outside, of any length. Integral
 * of omega d omega, of which the z component is the cosine weight (Lambert's formula), theta_i being the
 * angle between a_i and a_i+1: V = sum over edges of theta_i (a_i x a_i+1) / (2 |a_i x a_i+1|). */
sl_vec3d sl_cell_vector(const sl_vec3d *corners, int count);
/* Returns how a wall between two cells moves. The wall is the arc from direction a to direction b; it is made
 * by surfaces at depth 1 along the axis in whose units a and b are given. The vector g: displacing the
 * receiver by delta gives the cosine weight g . delta to the cell on the right of a -> b (for one who looks
 * along +z, x right and y up), taken from the cell on its left. With e the unit vector from a to b and d = a
 * + s e the points between them: g = integral of (e x d) d_z / |d|^4 ds. */
sl_vec3d sl_wall_vector(sl_vec3d a, sl_vec3d b);

/* A symmetric 2 x 2 matrix of second derivatives in the local tangent plane: (xx, xy, yy). */
typedef struct sl_curvature {
    double xx, xy, yy;
} sl_curvature;
/* The next order of the same motion: displacing the receiver by a tangential delta gives the cell on the
 * right g . delta + delta . K delta / 2, where the wall's ends move as points of the world at depth 1. */
sl_curvature sl_wall_curvature(sl_vec3d a, sl_vec3d b);
