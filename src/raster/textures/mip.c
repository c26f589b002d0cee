#include "raster/textures/mip.h"

#include "base/error.h"
#include "base/memory.h"
#include "image/color.h"
#include "raster/textures/textures.h"
#include "scene/surface_rules.h"
#include "scene/texture_rules.h"

#include <math.h>

static bool colours_surfaces(const sl_scene *scene, uint32_t texture) {
    for (size_t i = 0; i < scene->material_count; i++) {
        if (scene->materials[i].texture == texture) return true;
    }
    return false;
}

/* Fills in the sizes; returns the bytes of all texels. */
static size_t plan_levels(const sl_texture *texture, sl_mip *mip) {
    size_t bytes = 0;
    int32_t width = texture->width, height = texture->height;
    for (mip->count = 0; mip->count < SL_MIP_LEVELS;
         width = sl_half_size(width), height = sl_half_size(height)) {
        mip->level[mip->count++] = (sl_mip_level){width, height, NULL};
        if (mip->count > 1) bytes += 4 * sizeof(uint16_t) * (size_t)width * (size_t)height;
        if (width == 1 && height == 1) break;
    }
    return bytes;
}

size_t sl_mips_need(const sl_scene *scene) {
    size_t bytes = 0;
    for (size_t i = 0; i < scene->texture_count; i++) {
        sl_mip mip;
        if (colours_surfaces(scene, (uint32_t)i))
            bytes += sizeof mip + plan_levels(&scene->textures[i], &mip);
    }
    return bytes;
}

/* ---- means ---- */

static float *linear_texels(const sl_texture *texture) {
    const size_t texels = (size_t)texture->width * (size_t)texture->height;
    float *linear = sl_allocate_unset(texels, 4 * sizeof *linear);
    for (size_t i = 0; linear && i < 4 * texels; i++) linear[i] = sl_srgb_to_linear[texture->texels[i]];
    return linear;
}

static bool store(const float *linear, sl_mip_level *level) {
    const size_t values = 4 * (size_t)level->width * (size_t)level->height;
    level->texels = sl_allocate_unset(values, sizeof *level->texels);
    for (size_t i = 0; level->texels && i < values; i++)
        level->texels[i] = (uint16_t)(linear[i] * SL_MIP_ONE + 0.5f);
    return level->texels != NULL;
}

static bool make_levels(const sl_texture *texture, unsigned threads, sl_mip *mip) {
    float *fine = linear_texels(texture);
    bool made = fine != NULL;
    for (int32_t k = 1; k < mip->count && made; k++) {
        const sl_mip_level *above = &mip->level[k - 1];
        sl_mip_level *level = &mip->level[k];
        float *coarse =
            sl_allocate_unset((size_t)level->width * (size_t)level->height, 4 * sizeof *coarse);
        made = coarse != NULL;
        if (made) sl_mip_halve(fine, above->width, above->height, coarse, threads);
        made = made && store(coarse, level);
        sl_free(fine);
        fine = coarse;
    }
    sl_free(fine);
    return made;
}

sl_status sl_mips_create(const sl_scene *scene, unsigned threads, sl_mip **mips, sl_error *error) {
    *mips = NULL;
    if (sl_mips_need(scene) == 0) return SL_OK;
    sl_mip *all = *mips = sl_allocate(scene->texture_count, sizeof *all);
    bool made = all != NULL;
    for (size_t i = 0; i < scene->texture_count && made; i++) {
        if (!colours_surfaces(scene, (uint32_t)i)) continue;
        plan_levels(&scene->textures[i], &all[i]);
        made = make_levels(&scene->textures[i], threads, &all[i]);
    }
    if (made) return SL_OK;
    sl_mips_destroy(scene, all);
    *mips = NULL;
    return sl_fail_memory(error, "MIP maps");
}

void sl_mips_destroy(const sl_scene *scene, sl_mip *mips) {
    for (size_t i = 0; mips && i < scene->texture_count; i++) {
        for (int32_t k = 0; k < mips[i].count; k++) sl_free(mips[i].level[k].texels);
    }
    sl_free(mips);
}

/* ---- lookups ---- */

static sl_rgb level_color(const sl_mip_level *level, float u, float v) {
    const sl_texel_pair column = sl_texel_pair_at(u, level->width), row = sl_texel_pair_at(v, level->height);
    const uint16_t *low = level->texels + 4 * (size_t)(level->height - 1 - row.texel) * (size_t)level->width,
                   *high = level->texels + 4 * (size_t)(level->height - 1 - row.next) * (size_t)level->width;
    float value[3];
    for (int c = 0; c < 3; c++)
        value[c] = sl_texel_bilinear((float)low[4 * column.texel + c], (float)low[4 * column.next + c],
                                     (float)high[4 * column.texel + c], (float)high[4 * column.next + c],
                                     column.beyond, row.beyond) *
                   (1.0f / SL_MIP_ONE);
    return (sl_rgb){value[0], value[1], value[2]};
}

/* Returns texels of level 0 in a unit of area of the triangle. */
static float texels_an_area(const sl_scene *scene, const sl_texture *texture, const uint32_t corner[3]) {
    const float *u = scene->texture_u, *v = scene->texture_v;
    const sl_vec3 a = sl_scene_position(scene, corner[0]), b = sl_scene_position(scene, corner[1]),
                  c = sl_scene_position(scene, corner[2]);
    const float area = sl_length(sl_cross(sl_sub(b, a), sl_sub(c, a))),
                texels = (u[corner[1]] - u[corner[0]]) * (v[corner[2]] - v[corner[0]]) -
                         (u[corner[2]] - u[corner[0]]) * (v[corner[1]] - v[corner[0]]);
    return area > 0.0f ? fabsf(texels) * (float)texture->width * (float)texture->height / area : 0.0f;
}

sl_rgb sl_scene_diffuse_within(const sl_scene *scene, const sl_mip *mips, uint32_t triangle, float w1,
                               float w2, float width) {
    const sl_material *material = sl_triangle_material(scene, triangle);
    if (!mips || material->texture == SL_NO_INDEX) return sl_scene_diffuse(scene, triangle, w1, w2);
    const uint32_t corner[3] = {scene->vertex[0][triangle], scene->vertex[1][triangle],
                                scene->vertex[2][triangle]};
    const sl_texture *texture = &scene->textures[material->texture];
    const sl_mip *mip = &mips[material->texture];
    const int32_t level =
        sl_mip_level_for(texels_an_area(scene, texture, corner) * width * width, mip->count);
    if (level == 0) return sl_scene_diffuse(scene, triangle, w1, w2);
    const sl_texture_place at = sl_texture_place_at(scene, triangle, w1, w2);
    return sl_rgb_mul(material->diffuse, level_color(&mip->level[level], at.u, at.v));
}
