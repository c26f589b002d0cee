/* 2D textures: memory, and where their texels come from. */
#include "base/error.h"
#include "base/memory.h"
#include "raster/textures/lookup_kernels.h"
#include "raster/textures/mip_chain.h"
#include "scene/texture.h"

sl_status sl_texture_image_create(int width, int height, bool mip, sl_texture_image **image, sl_error *error) {
    *image = NULL;
    if (width < 1 || height < 1 || width > SL_TEXTURE_SIZE_MAX || height > SL_TEXTURE_SIZE_MAX) {
        return sl_fail(error, SL_ERROR_USAGE, "a texture of %d x %d texels: from 1 to %d each way", width, height,
                       (int)SL_TEXTURE_SIZE_MAX);
    }
    sl_texture_image *m = sl_allocate(1, sizeof *m);
    if (!m) return sl_fail_memory(error, "a texture");
    *m = (sl_texture_image){.levels = mip ? sl_mip_levels(width, height) : 1, .kernels = sl_texture_kernels_best()};
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
        sl_mip_halve(image->texels + 4 * (size_t)image->first[l], image->width[l], image->height[l], (size_t)image->width[l],
                     image->texels + 4 * (size_t)image->first[l + 1], (size_t)image->width[l + 1], threads);
    }
}

sl_status sl_texture_image_of_texture(const sl_texture *texture, unsigned threads, sl_texture_image **image, sl_error *error) {
    sl_status status = sl_texture_image_create(texture->width, texture->height, true, image, error);
    if (status != SL_OK) return status;
    float *texel = (*image)->texels;
    for (int y = 0; y < texture->height; y++) {
        int row = texture->height - 1 - y; /* the file's are from the top */
        for (int x = 0; x < texture->width; x++, texel += 4) {
            sl_rgb color = sl_texture_texel(texture, x, row);
            uint8_t alpha = texture->texels[4 * ((size_t)row * (size_t)texture->width + (size_t)x) + 3];
            texel[0] = color.r;
            texel[1] = color.g;
            texel[2] = color.b;
            texel[3] = texture->has_alpha ? (float)alpha / 255.0f : 1.0f;
        }
    }
    sl_texture_image_build(*image, threads);
    return SL_OK;
}

sl_status sl_texture_image_of_pbuffer(const sl_pbuffer *pbuffer, unsigned threads, sl_texture_image **image, sl_error *error) {
    *image = NULL;
    int channels = sl_pbuffer_channels(pbuffer->format);
    if (channels == 0) return sl_fail(error, SL_ERROR_USAGE, "a pbuffer of whole numbers has no means");
    sl_status status = sl_texture_image_create(pbuffer->width, pbuffer->height, true, image, error);
    if (status != SL_OK) return status;
    size_t pixels = (size_t)pbuffer->width * (size_t)pbuffer->height;
    float *texel = (*image)->texels;
    for (size_t i = 0; i < pixels; i++) {
        for (int c = 0; c < 4; c++) texel[4 * i + (size_t)c] = c < channels ? pbuffer->channel[c][i] : c == 3 ? 1.0f : 0.0f;
    }
    sl_texture_image_build(*image, threads);
    return SL_OK;
}
