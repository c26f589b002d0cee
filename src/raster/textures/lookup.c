/* Texture lookups one by one: the plain form, which says what a lookup is. The vectorised form (texture_kernels.c)
 * gives the same bits, and is what passes call. */
#include "raster/textures/lookup.h"

#include "raster/textures/lookup_kernels.h"

static int clamp_index(int i, int n) { return i < 0 ? 0 : i < n ? i : n - 1; }

const float *sl_texture_fetch(const sl_texture_image *image, int level, int x, int y) {
    int l = clamp_index(level, image->levels), width = image->width[l], height = image->height[l];
    size_t texel = (size_t)clamp_index(y, height) * (size_t)width + (size_t)clamp_index(x, width);
    return image->texels + 4 * ((size_t)image->first[l] + texel);
}

static sl_level_pair levels_of(int levels, sl_mip mip, float lod) {
    if (mip == SL_MIP_LINEAR) return sl_levels_around(lod, levels);
    int level = mip == SL_MIP_NEAREST ? sl_level_nearest(lod, levels) : 0;
    return (sl_level_pair){level, level, 0.0};
}

static sl_footprint footprint_in_level(const sl_texture_image *image, sl_sampler sampler, int level, float s, float t) {
    int width = image->width[level], height = image->height[level];
    sl_axis along_s = sl_axis_of(sampler.wrap_s), along_t = sl_axis_of(sampler.wrap_t);
    double x = sl_wrapped(s, along_s), y = sl_wrapped(t, along_t);
    if (!sampler.linear) {
        const float *texel = sl_texture_fetch(image, level, sl_nearest_texel(x, width), sl_nearest_texel(y, height));
        return (sl_footprint){{texel, texel, texel, texel}, 0.0, 0.0};
    }
    sl_texel_pair column = sl_texels_around(x, width, along_s);
    sl_texel_pair row = sl_texels_around(y, height, along_t);
    sl_footprint f = {.right = column.weight, .up = row.weight};
    for (int k = 0; k < 4; k++) {
        f.texel[k] = sl_texture_fetch(image, level, k & 1 ? column.high : column.low, k & 2 ? row.high : row.low);
    }
    return f;
}

void sl_texture_sample(const sl_texture_image *image, sl_sampler sampler, float s, float t, float lod, float rgba[4]) {
    sl_level_pair level = levels_of(image->levels, sampler.mip, lod);
    sl_footprint fine = footprint_in_level(image, sampler, level.fine, s, t);
    sl_footprint coarse = footprint_in_level(image, sampler, level.coarse, s, t);
    sl_filter_two(&fine, &coarse, level.weight, sampler.linear, rgba);
}

float sl_texture_lod(int width, int height, double ds_dx, double dt_dx, double ds_dy, double dt_dy) {
    double u_x = ds_dx * (double)width, v_x = dt_dx * (double)height, u_y = ds_dy * (double)width, v_y = dt_dy * (double)height;
    double x = u_x * u_x + v_x * v_x, y = u_y * u_y + v_y * v_y;
    return 0.5f * sl_log2f((float)(x > y ? x : y)); /* the logarithm of the root */
}

/* ---- cube maps ---- */

static sl_footprint footprint_in_face(const sl_cube_map *cube, bool linear, int level, sl_cube_place p) {
    int size = cube->level_size[level];
    if (!linear) {
        const float *texel = sl_cube_map_texel(cube, level, p.face, sl_nearest_texel(p.s, size), sl_nearest_texel(p.t, size));
        return (sl_footprint){{texel, texel, texel, texel}, 0.0, 0.0};
    }
    /* Half a texel up, as in sl_texels_around(); the first texel of a pair, or the second, may be the border's. */
    double x = p.s * (double)size + 0.5, y = p.t * (double)size + 0.5;
    int column = (int)x, row = (int)y;
    sl_footprint f = {.right = x - (double)column, .up = y - (double)row};
    for (int k = 0; k < 4; k++) f.texel[k] = sl_cube_map_texel(cube, level, p.face, column - 1 + (k & 1), row - 1 + (k >> 1));
    return f;
}

void sl_cube_map_sample(const sl_cube_map *cube, sl_sampler sampler, sl_vec3 direction, float lod, float rgba[4]) {
    sl_cube_place place = sl_cube_place_of(direction.x, direction.y, direction.z);
    sl_level_pair level = levels_of(cube->levels, sampler.mip, lod);
    sl_footprint fine = footprint_in_face(cube, sampler.linear, level.fine, place);
    sl_footprint coarse = footprint_in_face(cube, sampler.linear, level.coarse, place);
    sl_filter_two(&fine, &coarse, level.weight, sampler.linear, rgba);
}

/* On the face s = (s_c / m + 1) / 2, so ds = (ds_c m - s_c dm) / (2 m^2). */
float sl_cube_map_lod(const sl_cube_map *cube, sl_vec3 direction, sl_vec3 d_dx, sl_vec3 d_dy) {
    sl_frame frame = sl_cube_face_frame(sl_cube_place_of(direction.x, direction.y, direction.z).face);
    sl_vec3d s = sl_to_double(frame.x), t = sl_to_double(frame.y), m = sl_to_double(frame.z), d = sl_to_double(direction);
    sl_vec3d along[2] = {sl_to_double(d_dx), sl_to_double(d_dy)};
    double major = sl_dotd(m, d), over = 0.5 / (major * major), ds[2], dt[2];
    for (int k = 0; k < 2; k++) {
        double dm = sl_dotd(m, along[k]);
        ds[k] = (sl_dotd(s, along[k]) * major - sl_dotd(s, d) * dm) * over;
        dt[k] = (sl_dotd(t, along[k]) * major - sl_dotd(t, d) * dm) * over;
    }
    return sl_texture_lod(cube->size, cube->size, ds[0], dt[0], ds[1], dt[1]);
}

/* ---- 3D textures ---- */

static size_t volume_texel(const sl_volume *volume, int x, int y, int z) {
    return ((size_t)z * (size_t)volume->height + (size_t)y) * (size_t)volume->width + (size_t)x;
}

static uint32_t packed(const uint8_t *b) {
    return (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

uint32_t sl_volume_fetch(const sl_volume *volume, int x, int y, int z) {
    size_t texel = volume_texel(volume, clamp_index(x, volume->width), clamp_index(y, volume->height),
                                clamp_index(z, volume->depth));
    return packed(volume->bytes + 4 * texel);
}

typedef struct {
    sl_texel_pair column, row, slice;
} cell;

static cell cell_at(const sl_volume *volume, sl_sampler sampler, float s, float t, float r) {
    const float coordinate[3] = {s, t, r};
    const int size[3] = {volume->width, volume->height, volume->depth};
    const sl_wrap wrap[3] = {sampler.wrap_s, sampler.wrap_t, sampler.wrap_r};
    sl_texel_pair pair[3];
    for (int k = 0; k < 3; k++) {
        sl_axis axis = sl_axis_of(wrap[k]);
        double x = sl_wrapped(coordinate[k], axis);
        int nearest = sl_nearest_texel(x, size[k]);
        pair[k] = sampler.linear ? sl_texels_around(x, size[k], axis) : (sl_texel_pair){nearest, nearest, 0.0};
    }
    return (cell){pair[0], pair[1], pair[2]};
}

uint32_t sl_volume_nearest(const sl_volume *volume, sl_sampler sampler, float s, float t, float r) {
    sampler.linear = false;
    cell c = cell_at(volume, sampler, s, t, r);
    return sl_volume_fetch(volume, c.column.low, c.row.low, c.slice.low);
}

/* Bytes as whole numbers, which are divided by 255 after filtering. */
static void texel_values(const sl_volume *volume, int x, int y, int z, float value[4]) {
    size_t texel = volume_texel(volume, x, y, z);
    for (size_t c = 0; c < 4; c++) {
        value[c] = volume->format == SL_VOLUME_RGBA8 ? (float)volume->bytes[4 * texel + c] : volume->texels[4 * texel + c];
    }
}

void sl_volume_sample(const sl_volume *volume, sl_sampler sampler, float s, float t, float r, float rgba[4]) {
    cell at = cell_at(volume, sampler, s, t, r);
    float value[8][4];
    sl_footprint slice[2];
    for (int k = 0; k < 8; k++) {
        texel_values(volume, k & 1 ? at.column.high : at.column.low, k & 2 ? at.row.high : at.row.low,
                     k & 4 ? at.slice.high : at.slice.low, value[k]);
        slice[k / 4].texel[k % 4] = value[k];
    }
    for (int k = 0; k < 2; k++) {
        slice[k].right = at.column.weight;
        slice[k].up = at.row.weight;
    }
    if (volume->format == SL_VOLUME_RGBA32F) {
        sl_filter_two(&slice[0], &slice[1], at.slice.weight, sampler.linear, rgba);
        return;
    }
    for (int c = 0; c < 4; c++) {
        double low = sl_filter_channel(&slice[0], c), high = sl_filter_channel(&slice[1], c);
        rgba[c] = (float)(sl_mix(low, high, at.slice.weight) / 255.0);
    }
}
