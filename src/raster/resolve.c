/* Blocks of pixels: their runs, their corners, their weights. */
#include "raster/resolve.h"

static inline void put_corner(sl_resolve_block *block, uint32_t run, int corner, sl_vec3 p) {
    block->corner.x[corner][run] = p.x;
    block->corner.y[corner][run] = p.y;
    block->corner.z[corner][run] = p.z;
}

static void fetch_corners(const sl_raster *raster, sl_resolve_block *block) {
    const sl_raster_mesh *mesh = &raster->mesh;
    for (uint32_t r = 0; r < block->runs; r++) {
        uint32_t triangle = sl_run_triangle(block, r);
        if (triangle == SL_NO_INDEX) {
            for (int k = 0; k < 3; k++) put_corner(block, r, k, sl_v3(0.0f, 0.0f, 0.0f));
        } else {
            for (int k = 0; k < 3; k++) put_corner(block, r, k, sl_mesh_position(mesh, mesh->vertex[k][triangle]));
        }
    }
}

size_t sl_resolve_next(const sl_raster *raster, const sl_pass_view *view, size_t count, size_t first,
                       const uint32_t *pixel, const uint32_t *id, sl_resolve_block *block) {
    if (!count) return 0;
    block->id = id;
    block->pixel = pixel;
    block->first = (uint32_t)first;
    raster->kernels->resolve->runs(block, count);
    fetch_corners(raster, block);
    raster->kernels->resolve->weights(block, view);
    return block->count;
}

uint64_t sl_resolve_shaded(const sl_resolve_block *block) {
    uint64_t shaded = 0;
    for (uint32_t r = 0; r < block->runs; r++) {
        if (sl_run_triangle(block, r) != SL_NO_INDEX) shaded += block->start[r + 1] - block->start[r];
    }
    return shaded;
}
