/* Texture lookups in blocks, through the kernels of the instruction set that was found when the texture was
 * made (texture_kernels.c). */
#include "raster/textures/textures.h"

SL_KERNEL_TABLE(sl_texture_kernels, sl_texture_kernels)

static size_t block_end(size_t first, size_t count) {
    return count - first < SL_TEXTURE_BLOCK ? count - first : SL_TEXTURE_BLOCK;
}

static void planes_from(float *const plane[4], size_t first, float *shifted[4]) {
    for (int c = 0; c < 4; c++) shifted[c] = plane[c] ? plane[c] + first : NULL;
}

void sl_texture_sample_many(const sl_texture_image *image, size_t count, const float *s, const float *t,
                            const float *lod, float *const plane[4]) {
    for (size_t i = 0; i < count; i += SL_TEXTURE_BLOCK) {
        float *out[4];
        planes_from(plane, i, out);
        image->kernels->texture(image, block_end(i, count), s + i, t + i, lod ? lod + i : NULL, out);
    }
}

void sl_cube_map_sample_many(const sl_cube_map *cube, size_t count, const float *x, const float *y,
                             const float *z, const float *lod, float *const plane[4]) {
    for (size_t i = 0; i < count; i += SL_TEXTURE_BLOCK) {
        float *out[4];
        planes_from(plane, i, out);
        cube->kernels->cube(cube, block_end(i, count), x + i, y + i, z + i, lod ? lod + i : NULL, out);
    }
}
