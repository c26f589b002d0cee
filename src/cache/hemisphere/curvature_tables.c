/* Tables for second derivatives: how the walls between cells, and the corners where four of them meet, move with the receiver beyond the
 * first order (Schwarzhaupt, Jensen, Jarosz 2012 have the idea that occlusion belongs into the Hessian). */
#include "cache/hemisphere/gather_tables.h"
#include "cache/hemisphere/hemisphere_tables.h"

static void set(float *xx, float *xy, float *yy, sl_curvature k) {
    *xx = (float)k.xx;
    *xy = (float)k.xy;
    *yy = (float)k.yy;
}

static bool is_cell(const sl_gather_tables *t, int x, int y) {
    return x >= 0 && y >= 0 && t->length[(size_t)y * (size_t)t->width + (size_t)x] > 0.0f;
}

void sl_gather_fill_curvatures(sl_gather_tables *t, sl_gather_corner *corner, double half_tangent) {
    for (int y = 0; y < t->height; y++) {
        for (int x = 0; x < t->width; x++) {
            size_t i = (size_t)y * (size_t)t->width + (size_t)x;
            if (!is_cell(t, x, y)) continue;
            bool has_left = is_cell(t, x - 1, y), has_below = is_cell(t, x, y - 1);
            sl_vec3d here = corner(t, half_tangent, x, y), right = corner(t, half_tangent, x + 1, y),
                     up = corner(t, half_tangent, x, y + 1);
            /* Seen along the wall, the cell lies on its right. */
            if (has_left) set(&t->column_xx[i], &t->column_xy[i], &t->column_yy[i], sl_wall_curvature(here, up));
            if (has_below) set(&t->row_xx[i], &t->row_xy[i], &t->row_yy[i], sl_wall_curvature(right, here));
            if (!has_left || !has_below || !is_cell(t, x - 1, y - 1)) continue;
            sl_curvature k = sl_vertex_curvature(here, right, corner(t, half_tangent, x - 1, y), up, corner(t, half_tangent, x, y - 1));
            set(&t->vertex_xx[i], &t->vertex_xy[i], &t->vertex_yy[i], k);
        }
    }
}
