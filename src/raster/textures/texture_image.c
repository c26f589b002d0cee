/* 2D textures: memory and MIP chain. */
#include "base/error.h"
#include "base/memory.h"
#include "raster/textures/lookup_kernels.h"
#include "raster/textures/mip_chain.h"

sl_status sl_texture_image_create(int width, int height, bool mip, sl_texture_image **image,
                                  sl_error *error) {
    *image = NULL;
    if (width < 1 || height < 1 || width > SL_TEXTURE_SIZE_MAX || height > SL_TEXTURE_SIZE_MAX) {
        return sl_fail(error, SL_ERROR_USAGE, "a texture of %d x %d texels: from 1 to %d each way", width,
                       height, (int)SL_TEXTURE_SIZE_MAX);
    }
    sl_texture_image *m = sl_allocate(1, sizeof *m);
    if (!m) return sl_fail_memory(error, "a texture");
    *m = (sl_texture_image){.levels = mip ? sl_mip_levels(width, height) : 1,
                            .kernels = sl_texture_kernels_best()};
    int32_t texels = 0; /* less than 2^29 */
    for (int l = 0; l < m->levels; l++) {
        m->width[l] = l == 0 ? width : sl_half_size(m->width[l - 1]);
        m->height[l] = l == 0 ? height : sl_half_size(m->height[l - 1]);
        m->first[l] = texels;
        texels += m->width[l] * m->height[l];
    }
    m->texels = sl_allocate((size_t)texels, 4 * sizeof *m->texels);
    if (!m->texels) {
        sl_texture_image_destroy(m);
        return sl_fail_memory(error, "a texture");
    }
    *image = m;
    return SL_OK;
}

void sl_texture_image_destroy(sl_texture_image *image) {
    if (!image) return;
    sl_free(image->texels);
    sl_free(image);
}

void sl_texture_image_build(sl_texture_image *image, unsigned threads) {
    for (int l = 0; l + 1 < image->levels; l++) {
        sl_mip_halve(image->texels + 4 * (size_t)image->first[l], image->width[l], image->height[l],
                     (size_t)image->width[l], image->texels + 4 * (size_t)image->first[l + 1],
                     (size_t)image->width[l + 1], threads);
    }
}
