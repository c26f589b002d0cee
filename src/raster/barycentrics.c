/* Barycentric weights for lists of pixels: corners are fetched pixel by pixel, the arithmetic runs in vector lanes. */
#include <string.h>

#include "raster/barycentrics.h"

static void fetch_corners(const sl_raster *raster, const sl_view *view, uint32_t triangle, float q[9]) {
    const sl_raster_mesh *mesh = &raster->mesh;
    for (int k = 0; k < 3; k++) {
        sl_vec3 p = sl_sub(sl_mesh_position(mesh, mesh->vertex[k][triangle]), view->origin);
        q[3 * k] = p.x;
        q[3 * k + 1] = p.y;
        q[3 * k + 2] = p.z;
    }
}

static void fill_block(const sl_raster *raster, const sl_view *view, size_t count, const uint32_t *pixel,
                       const uint32_t *id, sl_barycentric_block *block) {
    uint32_t last = SL_NO_INDEX, width = (uint32_t)view->width;
    float q[9] = {0};
    for (size_t n = 0; n < count; n++) {
        if (id[n] != last && id[n] != SL_NO_INDEX) fetch_corners(raster, view, id[n], q);
        last = id[n];
        for (int k = 0; k < 9; k++) block->corner[k][n] = q[k];
        block->x[n] = sl_pixel_centre(pixel[n] % width, view->width);
        block->y[n] = sl_pixel_centre(pixel[n] / width, view->height);
    }
}

void sl_raster_barycentrics(const sl_raster *raster, const sl_view *view, size_t count, const uint32_t *pixel,
                            const uint32_t *id, float *w1, float *w2) {
    sl_pass_view pass = sl_pass_view_make(view, view->width, view->height);
    sl_barycentric_block block;
    memset(&block, 0, sizeof block);
    float b1[SL_BARYCENTRIC_BLOCK], b2[SL_BARYCENTRIC_BLOCK];
    for (size_t first = 0; first < count; first += SL_BARYCENTRIC_BLOCK) {
        size_t here = count - first < SL_BARYCENTRIC_BLOCK ? count - first : SL_BARYCENTRIC_BLOCK;
        fill_block(raster, view, here, pixel + first, id + first, &block);
        raster->kernels->barycentrics(&block, &pass, b1, b2);
        for (size_t n = 0; n < here; n++) {
            bool hit = id[first + n] != SL_NO_INDEX;
            w1[first + n] = hit ? b1[n] : 0.0f;
            w2[first + n] = hit ? b2[n] : 0.0f;
        }
    }
}
