/* Samples that look at all texels of their block, against photons that flash as single texels jump between surfaces.
 *
 *     radiance   the paper's: L_o from a level of a MIP map, position and normal from the sample's texel. Its mean mixes L_o and not
 *                L_o A, so it does not conserve energy, and can light a near surface with a far one's colour.
 *     flux       sums of Psi, which do: a photon for each surface that the block shows */
#include "base/error.h"
#include "base/math.h"
#include "cache/direct_radiance/photon_groups.h"
#include "raster/textures/textures.h"

/* ---- radiance ---- */

/* The face's colours with their MIP map; where nothing is, black, alpha 0. */
static sl_status picture_of(const sl_radiance_map *map, const sl_map_face *face, sl_texture_image **image, sl_error *error) {
    sl_status status = sl_texture_image_create(face->width, face->height, true, image, error);
    if (status != SL_OK) return status;
    size_t texels = (size_t)face->width * (size_t)face->height;
    for (size_t i = 0; i < texels; i++) {
        bool covered = map->triangle[face->first + i] != SL_NO_INDEX;
        float *rgba = (*image)->texels + 4 * i;
        for (int c = 0; c < 3; c++) rgba[c] = covered ? map->color[c][face->first + i] : 0.0f;
        rgba[3] = covered ? 1.0f : 0.0f;
    }
    sl_texture_image_build(*image, 1);
    return SL_OK;
}

/* Trilinear, of level log2(texels a block): one texel of the level for each block, where w / m is a power of two. */
static void filtered_color(const sl_texture_image *image, const sl_map_face *face, int column, int row, double color[3]) {
    double texels = (double)sl_block_texels(face);
    float s = (float)(((double)column + 0.5 * texels) / face->width), t = (float)(((double)row + 0.5 * texels) / face->height), rgba[4];
    sl_texture_sample(image, s, t, sl_log2f((float)texels), rgba);
    for (int c = 0; c < 3; c++) color[c] = (double)rgba[c];
}

static sl_status filtered_face(sl_photon_list *list, const sl_map_face *f, sl_error *error) {
    sl_texture_image *image;
    sl_status status = picture_of(list->map, f, &image, error);
    if (status != SL_OK) return status;
    for (int row = 0; row < f->height; row += sl_block_texels(f)) {
        for (int column = 0; column < f->width; column += sl_block_texels(f)) {
            double color[3];
            filtered_color(image, f, column, row, color);
            sl_photon_at_point(list, f, column, row, color);
        }
    }
    sl_texture_image_destroy(image);
    return SL_OK;
}

sl_status sl_photons_of_filtered_radiance(sl_photon_list *list, const sl_map_face *face, size_t face_count, sl_error *error) {
    for (size_t f = 0; f < face_count; f++) {
        sl_status status = filtered_face(list, &face[f], error);
        if (status != SL_OK) return status;
    }
    return SL_OK;
}

/* ---- flux ---- */

static void group_block(sl_photon_list *list, const sl_map_face *f, int column, int row) {
    int texels = sl_block_texels(f);
    sl_photon_groups groups = {.group = {{.luminance = 0.0}}};
    double block = sl_block_angle(list->map, f, column, row);
    for (int y = row; y < row + texels; y++) {
        for (int x = column; x < column + texels; x++) sl_photon_groups_add(list, f, x, y, block, &groups);
    }
    if (!sl_photon_groups_finish(list, f, &groups)) list->photons->dropped++;
}

sl_status sl_photons_of_groups(sl_photon_list *list, const sl_map_face *face, size_t face_count, sl_error *error) {
    (void)error;
    for (const sl_map_face *f = face; f < face + face_count; f++) {
        for (int row = 0; row < f->height; row += sl_block_texels(f)) {
            for (int column = 0; column < f->width; column += sl_block_texels(f)) group_block(list, f, column, row);
        }
    }
    return SL_OK;
}
