/* Barycentric weights for lists of pixels. */
#include <string.h>

#include "raster/resolve/resolve.h"

void sl_raster_barycentrics(const sl_raster *raster, const sl_view *view, size_t count, const uint32_t *pixel,
                            const uint32_t *id, float *w1, float *w2) {
    sl_pass_view pass = sl_pass_view_make(view, view->width, view->height);
    sl_resolve_block block;
    memset(&block, 0, sizeof block);
    for (size_t at = 0; at < count; at += block.count) {
        sl_resolve_next(raster, &pass, count - at, 0, pixel + at, id + at, &block);
        memcpy(w1 + at, block.w1, block.count * sizeof *w1);
        memcpy(w2 + at, block.w2, block.count * sizeof *w2);
    }
}
