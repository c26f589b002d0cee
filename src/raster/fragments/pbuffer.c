/* Pbuffers with memory of their own. */
#include "raster/fragments/pbuffer.h"

#include "base/error.h"
#include "base/memory.h"
#include "raster/view.h"

int sl_pbuffer_channels(sl_pbuffer_format format) {
    static const int channels[] = {
        [SL_PBUFFER_R32UI] = 0, [SL_PBUFFER_R32F] = 1, [SL_PBUFFER_RGB32F] = 3, [SL_PBUFFER_RGBA32F] = 4};
    return channels[format];
}

sl_status sl_pbuffer_create(int width, int height, sl_pbuffer_format format, sl_pbuffer **pbuffer,
                            sl_error *error) {
    *pbuffer = NULL;
    if (width < 1 || height < 1 || width > SL_RASTER_MAX_SIZE || height > SL_RASTER_MAX_SIZE) {
        return sl_fail(error, SL_ERROR_USAGE, "a pbuffer of %d x %d pixels: from 1 to %d each way", width,
                       height, (int)SL_RASTER_MAX_SIZE);
    }
    size_t pixels = (size_t)width * (size_t)height;
    sl_pbuffer *p = sl_allocate(1, sizeof *p);
    if (!p) return sl_fail_memory(error, "a pbuffer");
    *p = (sl_pbuffer){.width = width, .height = height, .format = format};
    bool ok = true;
    if (format == SL_PBUFFER_R32UI) {
        p->word = sl_allocate(pixels, sizeof *p->word);
        ok = p->word != NULL;
    }
    for (int c = 0; c < sl_pbuffer_channels(format) && ok; c++) {
        p->channel[c] = sl_allocate(pixels, sizeof *p->channel[c]);
        ok = p->channel[c] != NULL;
    }
    if (!ok) {
        sl_pbuffer_destroy(p);
        return sl_fail_memory(error, "a pbuffer");
    }
    *pbuffer = p;
    return SL_OK;
}

void sl_pbuffer_destroy(sl_pbuffer *pbuffer) {
    if (!pbuffer) return;
    sl_free(pbuffer->word);
    for (int c = 0; c < 4; c++) sl_free(pbuffer->channel[c]);
    sl_free(pbuffer);
}
