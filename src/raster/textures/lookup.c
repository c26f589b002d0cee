/* Texture lookups one by one: the plain form, which says what a lookup is; and many at once, in blocks
 * through the kernels of the instruction set that was found when the texture was made (texture_kernels.c), to
 * the same bits. */
#include "raster/textures/textures.h"
#include "raster/textures/texel_place.h"

SL_KERNEL_TABLE(sl_texture_kernels, sl_texture_kernels)

/* The four texels around a point, lower left, lower right, upper left, upper right, and the weights between
 * them. */
typedef struct {
    const float *texel[4];
    double right, up;
} footprint;

static double filter(const footprint *f, int c) {
    double low = sl_mix((double)f->texel[0][c], (double)f->texel[1][c], f->right);
    double high = sl_mix((double)f->texel[2][c], (double)f->texel[3][c], f->right);
    return sl_mix(low, high, f->up);
}

/* Blends two levels, and rounds once. */
static void filter_two(const footprint *fine, const footprint *coarse, double weight, float rgba[4]) {
    for (int c = 0; c < 4; c++) {
        double value = filter(fine, c);
        if (weight > 0.0) value = sl_mix(value, filter(coarse, c), weight);
        rgba[c] = (float)value;
    }
}

static footprint footprint_in_level(const sl_texture_image *image, int level, float s, float t) {
    int width = image->width[level];
    sl_texel_pair column = sl_texels_around(sl_clamped(s), width),
                  row = sl_texels_around(sl_clamped(t), image->height[level]);
    footprint f = {.right = column.weight, .up = row.weight};
    for (int k = 0; k < 4; k++) {
        int32_t texel = (k & 2 ? row.high : row.low) * width + (k & 1 ? column.high : column.low);
        f.texel[k] = image->texels + 4 * ((size_t)image->first[level] + (size_t)texel);
    }
    return f;
}

void sl_texture_sample(const sl_texture_image *image, float s, float t, float lod, float rgba[4]) {
    sl_level_pair level = sl_levels_around(lod, image->levels);
    footprint fine = footprint_in_level(image, level.fine, s, t),
              coarse = footprint_in_level(image, level.coarse, s, t);
    filter_two(&fine, &coarse, level.weight, rgba);
}

static footprint footprint_in_face(const sl_cube_map *cube, int level, sl_cube_place p) {
    /* Half a texel up, as in sl_texels_around(); the first texel of a pair, or the second, may be the
     * border's. */
    double x = p.s * (double)cube->level_size[level] + 0.5, y = p.t * (double)cube->level_size[level] + 0.5;
    int column = (int)x, row = (int)y;
    footprint f = {.right = x - (double)column, .up = y - (double)row};
    for (int k = 0; k < 4; k++)
        f.texel[k] = sl_cube_map_texel(cube, level, p.face, column - 1 + (k & 1), row - 1 + (k >> 1));
    return f;
}

void sl_cube_map_sample(const sl_cube_map *cube, sl_vec3 direction, float lod, float rgba[4]) {
    sl_cube_place place = sl_cube_place_of(direction.x, direction.y, direction.z);
    sl_level_pair level = sl_levels_around(lod, cube->levels);
    footprint fine = footprint_in_face(cube, level.fine, place),
              coarse = footprint_in_face(cube, level.coarse, place);
    filter_two(&fine, &coarse, level.weight, rgba);
}

/* ---- many ---- */

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
