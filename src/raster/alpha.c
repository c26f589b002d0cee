/* Triangles with an alpha mask: pixel by pixel, with the same coverage and depth as the hot loop, and the mask's
 * test before the write. They are few, and the order of drawing does not matter, so they need no place in the hot
 * loop. */
#include "raster/barycentrics.h"

static bool covers(const sl_batch *b, uint32_t t, int x, int y) {
    int64_t inside = 0;
    for (int k = 0; k < 3; k++) inside |= (int64_t)b->a[k][t] * x + (int64_t)b->b[k][t] * y + b->c[k][t];
    return inside >= 0;
}

static float depth_at(const sl_batch *b, uint32_t t, int x, int y) {
    float z = b->depth_origin[t] + b->depth_dv[t] * (float)(y * SL_SUBPIXEL - b->origin_v[t]);
    z = z + b->depth_du[t] * (float)(x * SL_SUBPIXEL - b->origin_u[t]);
    z = z < b->depth_min[t] ? b->depth_min[t] : z;
    return z > b->depth_max[t] ? b->depth_max[t] : z;
}

static bool opaque_at(const sl_raster *raster, const sl_view *view, uint32_t triangle, const sl_vec3 q[3], int x, int y) {
    float w1, w2;
    sl_barycentric_weights(view->clip, q[0], q[1], q[2], sl_pixel_centre((uint32_t)x, view->width),
                           sl_pixel_centre((uint32_t)y, view->height), &w1, &w2);
    return sl_scene_is_opaque(raster->scene, triangle, w1, w2);
}

void sl_rasterize_masked(const sl_raster *raster, const sl_view *view, const sl_pass_view *pass, const sl_batch *b,
                         uint32_t t, uint32_t *id, float *depth) {
    const sl_scene *scene = raster->scene;
    uint32_t me = b->id[t];
    sl_vec3 q[3];
    for (int k = 0; k < 3; k++) q[k] = sl_sub(sl_scene_position(scene, scene->vertex[k][me]), view->origin);
    for (int y = b->y0[t]; y <= b->y1[t]; y++) {
        for (int x = b->x0[t]; x <= b->x1[t]; x++) {
            if (!covers(b, t, x, y)) continue;
            size_t i = (size_t)y * (size_t)pass->width + (size_t)x;
            float z = depth_at(b, t, x, y);
            bool nearer = pass->inverse_w ? z > depth[i] : z < depth[i];
            if (!nearer && !(z == depth[i] && (int32_t)me < (int32_t)id[i])) continue;
            if (!opaque_at(raster, view, me, q, x, y)) continue;
            depth[i] = z;
            id[i] = me;
        }
    }
}
