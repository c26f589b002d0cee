/* Many lookups: in blocks, through the kernels of the instruction set that was found when the texture was made. */
#include "raster/textures/lookup_kernels.h"

extern const sl_texture_kernels sl_texture_kernels_baseline;
#ifndef SL_BASELINE_ONLY
extern const sl_texture_kernels sl_texture_kernels_avx2, sl_texture_kernels_avx512;
#endif

const sl_texture_kernels *sl_texture_kernels_best(void) {
#ifndef SL_BASELINE_ONLY
    switch (sl_isa_best()) {
    case SL_ISA_AVX512: return &sl_texture_kernels_avx512;
    case SL_ISA_AVX2: return &sl_texture_kernels_avx2;
    default: break;
    }
#endif
    return &sl_texture_kernels_baseline;
}

static size_t block_end(size_t first, size_t count) {
    return count - first < SL_TEXTURE_BLOCK ? count - first : SL_TEXTURE_BLOCK;
}

static void planes_from(float *const plane[4], size_t first, float *shifted[4]) {
    for (int c = 0; c < 4; c++) shifted[c] = plane[c] ? plane[c] + first : NULL;
}

void sl_texture_sample_many(const sl_texture_image *image, sl_sampler sampler, size_t count, const float *s, const float *t,
                            const float *lod, float *const plane[4]) {
    for (size_t i = 0; i < count; i += SL_TEXTURE_BLOCK) {
        float *out[4];
        planes_from(plane, i, out);
        image->kernels->texture(image, sampler, block_end(i, count), s + i, t + i, lod ? lod + i : NULL, out);
    }
}

void sl_cube_map_sample_many(const sl_cube_map *cube, sl_sampler sampler, size_t count, const float *x, const float *y,
                             const float *z, const float *lod, float *const plane[4]) {
    for (size_t i = 0; i < count; i += SL_TEXTURE_BLOCK) {
        float *out[4];
        planes_from(plane, i, out);
        cube->kernels->cube(cube, sampler, block_end(i, count), x + i, y + i, z + i, lod ? lod + i : NULL, out);
    }
}

void sl_volume_sample_many(const sl_volume *volume, sl_sampler sampler, size_t count, const float *s, const float *t,
                           const float *r, float *const plane[4]) {
    for (size_t i = 0; i < count; i += SL_TEXTURE_BLOCK) {
        float *out[4];
        planes_from(plane, i, out);
        volume->kernels->volume(volume, sampler, block_end(i, count), s + i, t + i, r + i, out);
    }
}

void sl_volume_nearest_many(const sl_volume *volume, sl_sampler sampler, size_t count, const float *s, const float *t,
                            const float *r, uint32_t *bytes) {
    for (size_t i = 0; i < count; i += SL_TEXTURE_BLOCK) {
        volume->kernels->volume_nearest(volume, sampler, block_end(i, count), s + i, t + i, r + i, bytes + i);
    }
}

void sl_volume_fetch_many(const sl_volume *volume, size_t count, const int32_t *x, const int32_t *y, const int32_t *z,
                          uint32_t *bytes) {
    for (size_t i = 0; i < count; i += SL_TEXTURE_BLOCK) {
        volume->kernels->volume_fetch(volume, block_end(i, count), x + i, y + i, z + i, bytes + i);
    }
}
