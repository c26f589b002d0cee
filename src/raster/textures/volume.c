/* 3D textures: memory. Their lookups are in lookup.c and texture_kernels.c. */
#include "base/error.h"
#include "base/memory.h"
#include "raster/textures/lookup_kernels.h"

sl_status sl_volume_create(int width, int height, int depth, sl_volume_format format, sl_volume **volume, sl_error *error) {
    *volume = NULL;
    bool fits = width >= 1 && height >= 1 && depth >= 1 && width <= SL_TEXTURE_SIZE_MAX && height <= SL_TEXTURE_SIZE_MAX &&
                depth <= SL_TEXTURE_SIZE_MAX && (int64_t)width * height * depth <= INT32_MAX;
    if (!fits) {
        return sl_fail(error, SL_ERROR_USAGE, "a 3D texture of %d x %d x %d texels: from 1 to %d each way, less than 2^31", width,
                       height, depth, (int)SL_TEXTURE_SIZE_MAX);
    }
    size_t texels = (size_t)width * (size_t)height * (size_t)depth;
    sl_volume *v = sl_allocate(1, sizeof *v);
    if (!v) return sl_fail_memory(error, "a 3D texture");
    *v = (sl_volume){.width = width, .height = height, .depth = depth, .format = format, .kernels = sl_texture_kernels_best()};
    if (format == SL_VOLUME_RGBA8) v->bytes = sl_allocate(texels, 4);
    else v->texels = sl_allocate(texels, 4 * sizeof *v->texels);
    if (!v->bytes && !v->texels) {
        sl_volume_destroy(v);
        return sl_fail_memory(error, "a 3D texture");
    }
    *volume = v;
    return SL_OK;
}

void sl_volume_destroy(sl_volume *volume) {
    if (!volume) return;
    sl_free(volume->texels);
    sl_free(volume->bytes);
    sl_free(volume);
}
