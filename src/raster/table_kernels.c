/* The table of this instruction set's kernels. */
#include "raster/pipeline.h"

void SL_KERNEL(sl_raster_cull)(const sl_raster *raster, const sl_pass_view *view, sl_visible *visible);
void SL_KERNEL(sl_raster_transform)(const sl_raster *raster, uint32_t cluster, const sl_pass_view *view,
                                    sl_vertex_buffer *out);
void SL_KERNEL(sl_raster_classify)(const sl_raster *raster, uint32_t cluster, const sl_pass_view *view,
                                   const sl_tile *tile, const sl_vertex_buffer *vertices,
                                   sl_classes *classes);
void SL_KERNEL(sl_raster_cover_tiny)(const sl_raster *raster, uint32_t cluster, const sl_tile *tile,
                                     const sl_vertex_buffer *vertices, const sl_classes *classes,
                                     sl_tiny *tiny);
void SL_KERNEL(sl_raster_set_up_edges)(const sl_tile *tile, sl_triangle_batch *batch, uint32_t first);
void SL_KERNEL(sl_raster_set_up_depth)(const sl_pass_view *view, sl_triangle_batch *batch);
void SL_KERNEL(sl_raster_rasterize_tiny)(const sl_pass_view *view, const sl_tile *tile,
                                         const sl_triangle_batch *batch, const sl_tiny *tiny);
void SL_KERNEL(sl_raster_rasterize)(const sl_pass_view *view, const sl_tile *tile,
                                    const sl_triangle_batch *batch, uint32_t first);
bool SL_KERNEL(sl_raster_occluded)(const sl_pass_view *view, const sl_tile *tile, sl_rectangle pixels,
                                   float nearest);
void SL_KERNEL(sl_raster_clear)(const sl_pass_view *view, const sl_tile *tile);
void SL_KERNEL(sl_raster_copy_out)(const sl_pass_view *view, const sl_tile *tile, uint32_t *id, float *depth);
extern const struct sl_resolve_kernels SL_KERNEL(sl_resolve_kernels);

extern const sl_raster_kernels SL_KERNEL(sl_raster_kernels);
const sl_raster_kernels SL_KERNEL(sl_raster_kernels) = {
    .cull = SL_KERNEL(sl_raster_cull),
    .transform = SL_KERNEL(sl_raster_transform),
    .classify = SL_KERNEL(sl_raster_classify),
    .cover_tiny = SL_KERNEL(sl_raster_cover_tiny),
    .set_up_edges = SL_KERNEL(sl_raster_set_up_edges),
    .set_up_depth = SL_KERNEL(sl_raster_set_up_depth),
    .rasterize_tiny = SL_KERNEL(sl_raster_rasterize_tiny),
    .rasterize = SL_KERNEL(sl_raster_rasterize),
    .occluded = SL_KERNEL(sl_raster_occluded),
    .clear = SL_KERNEL(sl_raster_clear),
    .copy_out = SL_KERNEL(sl_raster_copy_out),
    .resolve = &SL_KERNEL(sl_resolve_kernels),
};
