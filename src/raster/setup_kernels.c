/* Set-up: from three window vertices to edge functions and a depth plane, many triangles together. */
#include <math.h>

#include "raster/tile.h"
#include "raster/triangles.h"

/* ---- edges ---- */

/* The pixels whose centres the box may hold, cut to the tile; a triangle without area has none. */
static void find_pixels(const sl_tile *tile, sl_triangle_batch *restrict batch, uint32_t first,
                        uint32_t end) {
    const int32_t tile_x0 = tile->x0, tile_x1 = tile->x1 - 1, tile_y0 = tile->y0, tile_y1 = tile->y1 - 1;
#pragma omp simd
    for (uint32_t t = first; t < end; t++) {
        int32_t u0 = batch->snapped_u[0][t], u1 = batch->snapped_u[1][t], u2 = batch->snapped_u[2][t];
        int32_t v0 = batch->snapped_v[0][t], v1 = batch->snapped_v[1][t], v2 = batch->snapped_v[2][t];
        int32_t x0 = (sl_min3(u0, u1, u2) + 255) >> 8, x1 = (sl_max3(u0, u1, u2) - 1) >> 8;
        int32_t y0 = (sl_min3(v0, v1, v2) + 255) >> 8, y1 = (sl_max3(v0, v1, v2) - 1) >> 8;
        batch->x0[t] = x0 > tile_x0 ? x0 : tile_x0;
        batch->y0[t] = y0 > tile_y0 ? y0 : tile_y0;
        batch->x1[t] = x1 < tile_x1 ? x1 : tile_x1;
        batch->y1[t] = y1 < tile_y1 ? y1 : tile_y1;
    }
}

/* As sl_widen_edges(). All differences are below 2^15 here, so the products fit 32 bits; larger triangles,
 * drawn span by span, are given zeros, and never look at these. */
static void find_edges(const sl_tile *tile, sl_triangle_batch *restrict batch, uint32_t first, uint32_t end) {
    const int32_t left = tile->left, low = tile->low;
#pragma omp simd
    for (uint32_t t = first; t < end; t++) {
        int32_t u0 = batch->snapped_u[0][t], u1 = batch->snapped_u[1][t], u2 = batch->snapped_u[2][t];
        int32_t v0 = batch->snapped_v[0][t], v1 = batch->snapped_v[1][t], v2 = batch->snapped_v[2][t];
        int32_t wide = sl_max3(u0, u1, u2) - sl_min3(u0, u1, u2),
                high = sl_max3(v0, v1, v2) - sl_min3(v0, v1, v2);
        int32_t fits = sl_if_negative((wide > high ? wide : high) - (SL_SPAN * SL_SUBPIXEL + 1));
        fits &= ~(sl_if_negative(batch->x1[t] - batch->x0[t]) | sl_if_negative(batch->y1[t] - batch->y0[t]));
        /* The first block's first pixel; the tile starts at a multiple of the blocks. */
        int32_t u = (left + ((batch->x0[t] - left) & -SL_BLOCK)) * SL_SUBPIXEL;
        int32_t v = (low + ((batch->y0[t] - low) & -SL_BLOCK)) * SL_SUBPIXEL;
        u0 = (u0 - u) & fits, u1 = (u1 - u) & fits, u2 = (u2 - u) & fits;
        v0 = (v0 - v) & fits, v1 = (v1 - v) & fits, v2 = (v2 - v) & fits;
        int32_t area = (u1 - u0) * (v2 - v0) - (u2 - u0) * (v1 - v0);
        int32_t turned = sl_if_negative(area);
        int32_t a0 = sl_turn_if(turned, v1 - v2), a1 = sl_turn_if(turned, v2 - v0),
                a2 = sl_turn_if(turned, v0 - v1);
        int32_t b0 = sl_turn_if(turned, u2 - u1), b1 = sl_turn_if(turned, u0 - u2),
                b2 = sl_turn_if(turned, u1 - u0);
        batch->a[0][t] = a0, batch->a[1][t] = a1, batch->a[2][t] = a2;
        batch->b[0][t] = b0, batch->b[1][t] = b1, batch->b[2][t] = b2;
        batch->e[0][t] = sl_edge_constant(a0, b0, u1, v1);
        batch->e[1][t] = sl_edge_constant(a1, b1, u2, v2);
        batch->e[2][t] = sl_edge_constant(a2, b2, u0, v0);
        int32_t flat = ~sl_if_nonzero(area) & fits;
        batch->x1[t] = (batch->x1[t] & ~flat) | ((batch->x0[t] - 1) & flat);
    }
}

void SL_KERNEL(sl_raster_set_up_edges)(const sl_tile *tile, sl_triangle_batch *batch, uint32_t first) {
    find_pixels(tile, batch, first, batch->count);
    find_edges(tile, batch, first, batch->count);
}

/* ---- depth ---- */

/* The plane through the three unsnapped vertices, in double, told at the snapped position of the corner with
 * the smallest depth: for 1/w that is the far end, where absolute rounding errors would hurt. Slivers may
 * have wild slopes: the rasterizer clamps to the corners' range, slopes that could overflow count as none,
 * and where the terms along u and v are many times the depth that they add up to, float is not enough
 * (sl_steep_depth_at()). */
static void find_planes(sl_depth_rule rule, sl_triangle_batch *restrict batch, uint32_t end) {
    const float limit = rule == SL_NEARER_IS_SMALLER ? 1.0f : INFINITY;
#pragma omp simd
    for (uint32_t t = 0; t < end; t++) {
        float z0 = batch->depth[0][t], z1 = batch->depth[1][t], z2 = batch->depth[2][t];
        double u0 = (double)((batch->x[0][t] - 0.5f) * 256.0f),
               v0 = (double)((batch->y[0][t] - 0.5f) * 256.0f);
        double du1 = (double)((batch->x[1][t] - 0.5f) * 256.0f) - u0,
               dv1 = (double)((batch->y[1][t] - 0.5f) * 256.0f) - v0;
        double du2 = (double)((batch->x[2][t] - 0.5f) * 256.0f) - u0,
               dv2 = (double)((batch->y[2][t] - 0.5f) * 256.0f) - v0;
        double dz1 = (double)z1 - (double)z0, dz2 = (double)z2 - (double)z0;
        double area = du1 * dv2 - dv1 * du2;
        double over = 1.0 / (area != 0.0 ? area : 1.0);
        double du = (dz1 * dv2 - dz2 * dv1) * over, dv = (dz2 * du1 - dz1 * du2) * over;
        bool wild = !((fabs(du) < 1e20) & (fabs(dv) < 1e20)) | (area == 0.0);
        du = wild ? 0.0 : du;
        dv = wild ? 0.0 : dv;
        bool use1 = z1 < z0, use2 = z2 < (use1 ? z1 : z0);
        int32_t origin_u = use2   ? batch->snapped_u[2][t]
                           : use1 ? batch->snapped_u[1][t]
                                  : batch->snapped_u[0][t];
        int32_t origin_v = use2   ? batch->snapped_v[2][t]
                           : use1 ? batch->snapped_v[1][t]
                                  : batch->snapped_v[0][t];
        /* of what was clipped, they may lie before or beyond the view */
        float least = use2 ? z2 : use1 ? z1 : z0;
        least = least > 0.0f ? least : 0.0f;
        float most = z0 > z1 ? z0 : z1;
        most = most > z2 ? most : z2;
        most = most < limit ? most : limit;
        double terms = fabs(du) * (fabs(du1) + fabs(du2)) + fabs(dv) * (fabs(dv1) + fabs(dv2));
        batch->steep[t] = terms > 8.0 * (double)most ? 1 : 0;
        batch->depth_du[t] = (float)du;
        batch->depth_dv[t] = (float)dv;
        batch->depth_origin[t] =
            (float)((double)z0 + (du * ((double)origin_u - u0) + dv * ((double)origin_v - v0)));
        batch->depth_min[t] = least;
        batch->depth_max[t] = most;
        batch->origin_u[t] = origin_u;
        batch->origin_v[t] = origin_v;
    }
}

/* OSMesa's plane: float all through, told at the target's corner. llvmpipe exchanges the first two corners of
 * triangles that turn one way, which changes the rounding. */
static void find_opengl_planes(sl_triangle_batch *restrict batch, uint32_t end) {
    for (uint32_t t = 0; t < end; t++) {
        int64_t du1 = batch->snapped_u[1][t] - batch->snapped_u[0][t],
                du2 = batch->snapped_u[2][t] - batch->snapped_u[0][t];
        int64_t dv1 = batch->snapped_v[1][t] - batch->snapped_v[0][t],
                dv2 = batch->snapped_v[2][t] - batch->snapped_v[0][t];
        int first = du1 * dv2 - du2 * dv1 > 0 ? 1 : 0, second = 1 - first;
        float x0 = batch->x[first][t], y0 = batch->y[first][t], z0 = batch->depth[first][t];
        float dx01 = x0 - batch->x[second][t], dy01 = y0 - batch->y[second][t],
              dz01 = z0 - batch->depth[second][t];
        float dx20 = batch->x[2][t] - x0, dy20 = batch->y[2][t] - y0, dz20 = batch->depth[2][t] - z0;
        float ooa = 1.0f / (dx01 * dy20 - dy01 * dx20);
        float dzdx = dz01 * (dy20 * ooa) - dz20 * (dy01 * ooa),
              dzdy = dz20 * (dx01 * ooa) - dz01 * (dx20 * ooa);
        batch->depth_du[t] = dzdx;
        batch->depth_dv[t] = dzdy;
        batch->depth_origin[t] = z0 - (dzdx * (x0 - 0.5f) + dzdy * (y0 - 0.5f));
        batch->depth_min[t] = 0.0f;
        batch->depth_max[t] = 1.0f;
    }
}

void SL_KERNEL(sl_raster_set_up_depth)(const sl_pass_view *view, sl_triangle_batch *batch) {
    if (view->rule == SL_OPENGL_PLANE) find_opengl_planes(batch, batch->count);
    else find_planes(view->rule, batch, batch->count);
}
