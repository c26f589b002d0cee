/* Triangles with an alpha mask: pixel by pixel, with the same coverage and depth as the hot loop, and the
 * mask's test before the write. They are few, and the order of drawing does not matter, so they need no place
 * in the hot loop. */
#include "raster/pipeline.h"
#include "raster/resolve/barycentrics.h"

static bool covers(const sl_wide_edges *e, int x, int y) {
    for (int k = 0; k < 3; k++) {
        if (e->a[k] * x + e->b[k] * y + e->c[k] < 0) return false;
    }
    return true;
}

static bool opaque_at(const sl_raster *raster, uint32_t triangle, const sl_edge_lines *lines, int x, int y) {
    float w1, w2;
    sl_weights_at(lines, (double)x, (double)y, &w1, &w2);
    return sl_scene_is_opaque(raster->scene, triangle, w1, w2);
}

void sl_rasterize_masked(const sl_raster *raster, const sl_view *view, const sl_pass_view *pass,
                         const sl_tile *tile, const sl_triangle_batch *b, uint32_t t) {
    uint32_t me = b->id[t];
    sl_wide_edges e;
    if (!sl_widen_edges(b, t, &e)) return;
    sl_vec3 q[3];
    for (int k = 0; k < 3; k++)
        q[k] = sl_sub(sl_mesh_position(&raster->mesh, raster->mesh.vertex[k][me]), view->origin);
    const sl_edge_lines lines = sl_edge_lines_make(pass, q[0], q[1], q[2]);
    for (int y = b->y0[t]; y <= b->y1[t]; y++) {
        for (int x = b->x0[t]; x <= b->x1[t]; x++) {
            if (!covers(&e, x, y)) continue;
            size_t i = sl_tile_index(tile, x, y);
            float z = sl_depth_at(pass->rule, b, t, x, y), old = tile->depth[i];
            bool nearer = pass->inverse_w ? z > old : z < old;
            if (!nearer && !(z == old && (int32_t)me < (int32_t)tile->id[i])) continue;
            if (!opaque_at(raster, me, &lines, x - view->x, y - view->y)) continue;
            tile->depth[i] = z;
            tile->id[i] = me;
        }
    }
}
