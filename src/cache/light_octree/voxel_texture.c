#include "cache/light_octree/voxel_texture.h"

#include <math.h>
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "cache/light_octree/triangle_cells.h"

/* ---- bricks ---- */

enum { BRICKS_A_SIDE = 256 }; /* a byte of address for each axis */

/* Bricks are numbered level after level, in Morton order; these are the numbers' places in the 3D texture. */
static void brick_place(const sl_volume *bricks, size_t brick, int place[3]) {
    size_t across = (size_t)bricks->width / 2, up = (size_t)bricks->height / 2;
    place[0] = (int)(brick % across);
    place[1] = (int)(brick / across % up);
    place[2] = (int)(brick / across / up);
}

static uint8_t *brick_texel(const sl_volume *bricks, size_t brick, unsigned cell) {
    int place[3];
    brick_place(bricks, brick, place);
    size_t x = 2 * (size_t)place[0] + (cell & 1), y = 2 * (size_t)place[1] + (cell >> 1 & 1),
           z = 2 * (size_t)place[2] + (cell >> 2);
    return bricks->bytes + 4 * ((z * (size_t)bricks->height + y) * (size_t)bricks->width + x);
}

static size_t nodes_at(const sl_octree *octree, int level) {
    int shift = 3 * (octree->depth - level);
    size_t count = 0;
    for (size_t i = 0; i < octree->leaf_count; i++) {
        count += i == 0 || octree->leaf[i].morton >> shift != octree->leaf[i - 1].morton >> shift;
    }
    return count;
}

/* As near to a cuboid without waste as it gets. */
static sl_status create_bricks(sl_voxel_texture *t, const sl_octree *octree, sl_error *error) {
    size_t count = 1, side = BRICKS_A_SIDE;
    for (int level = 1; level < octree->depth; level++) count += nodes_at(octree, level);
    size_t deep = (count + side * side - 1) / (side * side), high = (count + side * deep - 1) / (side * deep),
           wide = (count + high * deep - 1) / (high * deep);
    if (deep > side) {
        return sl_fail(error, SL_ERROR_RESOURCES,
                       "the octree has %zu bricks, 24 bits address %zu: a smaller depth is needed", count,
                       side * side * side);
    }
    t->brick_count = count;
    return sl_volume_create(2 * (int)wide, 2 * (int)high, 2 * (int)deep, &t->bricks, error);
}

static void put_node(sl_voxel_texture *t, size_t brick, unsigned cell, size_t child) {
    uint8_t *texel = brick_texel(t->bricks, brick, cell);
    int place[3];
    brick_place(t->bricks, child, place);
    for (int axis = 0; axis < 3; axis++) texel[axis] = (uint8_t)place[axis];
    texel[3] = SL_TEXEL_NODE;
}

/* x and y in the texture of lights: 12 bits each. */
static void put_leaf(sl_voxel_texture *t, size_t brick, unsigned cell, size_t at) {
    uint8_t *texel = brick_texel(t->bricks, brick, cell);
    size_t x = at % (size_t)t->width, y = at / (size_t)t->width;
    texel[0] = (uint8_t)(x >> 4);
    texel[1] = (uint8_t)((x & 15) << 4 | y >> 8);
    texel[2] = (uint8_t)(y & 255);
    texel[3] = SL_TEXEL_LEAF;
}

/* A level's nodes are the codes' prefixes; their bricks hold the next level's. */
static void fill_bricks(sl_voxel_texture *t, const sl_octree *octree, const uint32_t *place_of_leaf) {
    size_t first = 0;
    for (int level = 0; level < octree->depth; level++) {
        int shift = 3 * (octree->depth - level);
        size_t nodes = level == 0 ? 1 : nodes_at(octree, level), node = 0, child = 0;
        for (size_t i = 0; i < octree->leaf_count; i++) {
            uint64_t code = octree->leaf[i].morton, before = i > 0 ? octree->leaf[i - 1].morton : code;
            node += code >> shift != before >> shift;
            child += code >> (shift - 3) != before >> (shift - 3);
            unsigned cell = (unsigned)(code >> (shift - 3) & 7);
            if (level + 1 == octree->depth) put_leaf(t, first + node, cell, place_of_leaf[i]);
            else put_node(t, first + node, cell, first + nodes + child);
        }
        first += nodes;
    }
}

/* ---- lights ---- */

static bool is_dark(const sl_voxel_lights *lights, size_t leaf) {
    for (uint32_t s = lights->first_set[leaf]; s < lights->first_set[leaf + 1]; s++) {
        if (lights->set[s].lights > 0) return false;
    }
    return true;
}

static bool stands_alone(const sl_voxel_texture *t, const sl_voxel_set *set) {
    return set->flat && !set->layered && set->lights == 1 && t->lobes == SL_LOBES_PERPENDICULAR;
}

static size_t texels_of_leaf(const sl_voxel_texture *t, const sl_voxel_lights *lights, size_t leaf) {
    size_t texels = 0;
    if (is_dark(lights, leaf)) return 0;
    if (!t->split) return (size_t)t->lights;
    for (uint32_t s = lights->first_set[leaf]; s < lights->first_set[leaf + 1]; s++) {
        texels += stands_alone(t, &lights->set[s]) ? 1 : 1 + (size_t)lights->set[s].lights;
    }
    return texels;
}

/* So wide that the texels take few rows and these are full; one leaf's never wrap. */
static void choose_width(sl_voxel_texture *t, size_t texels, size_t longest) {
    size_t step = t->split ? 1 : (size_t)t->lights, widest = SL_LIGHT_TEXTURE_SIZE / step * step,
           rows = (texels + widest - 1) / widest;
    size_t width = rows > 0 ? (texels / step + rows - 1) / rows * step : step;
    if (t->split && rows > 1) width += longest;
    t->width = (int)(width < longest ? longest : width < widest ? width : widest);
}

/* In order of leaves; those without light share the first texel, or array. */
static sl_status place_leaves(sl_voxel_texture *t, const sl_voxel_lights *lights, uint32_t *place_of_leaf,
                              sl_error *error) {
    size_t dark = 0, texels = 0, longest = t->split ? 1 : (size_t)t->lights,
           most = (size_t)SL_LIGHT_TEXTURE_SIZE * SL_LIGHT_TEXTURE_SIZE;
    for (size_t i = 0; i < lights->leaf_count; i++) {
        size_t here = texels_of_leaf(t, lights, i);
        if (here == 0) dark = 1;
        else t->array_count += lights->first_set[i + 1] - lights->first_set[i];
        texels += here;
        longest = here > longest ? here : longest;
    }
    size_t shared = dark * (t->split ? 1 : (size_t)t->lights), at = shared;
    t->array_count += dark;
    choose_width(t, texels + shared, longest);
    for (size_t i = 0; i < lights->leaf_count && at <= most; i++) {
        size_t here = texels_of_leaf(t, lights, i), width = (size_t)t->width;
        if (at % width + here > width) at += width - at % width;
        place_of_leaf[i] = here > 0 ? (uint32_t)at : 0;
        at += here;
    }
    t->texel_count = at;
    t->height = at > 0 ? (int)((at - 1) / (size_t)t->width) + 1 : 1;
    if (at <= most && t->height <= SL_LIGHT_TEXTURE_SIZE) return SL_OK;
    return sl_fail(error, SL_ERROR_RESOURCES,
                   "%zu arrays of lights take %zu texels, 24 bits address %zu: fewer lights or a smaller "
                   "depth are needed",
                   t->array_count, texels + shared, most);
}

static sl_status create_lights(sl_voxel_texture *t, sl_error *error) {
    size_t texels = (size_t)t->width * (size_t)t->height;
    t->light = sl_allocate(texels, sizeof *t->light);
    t->unpacked = sl_allocate(texels, sizeof *t->unpacked);
    if (!t->split) t->facing = sl_allocate(texels / (size_t)t->lights, sizeof *t->facing);
    return t->light && t->unpacked && (t->facing || t->split)
               ? SL_OK
               : sl_fail_memory(error, "the texture of lights");
}

/* Returns how many texels the set took. */
static size_t put_set(sl_voxel_texture *t, const sl_voxel_lights *lights, size_t at, uint32_t number,
                      bool more) {
    const sl_voxel_set *set = &lights->set[number];
    const sl_directional_light *light = lights->light + (size_t)number * (size_t)lights->texels;
    bool one_sided = set->lights > 0 && !set->both_sides;
    int flags =
        (set->opposed ? 0 : SL_SET_TURNS) | (more ? SL_SET_MORE : 0) | (one_sided ? SL_SET_ONE_SIDED : 0);
    size_t count = set->lights;
    if (stands_alone(t, set)) {
        t->light[at] = *light;
        t->light[at].packed += (float)(65536 * flags);
        return 1;
    }
    flags |=
        (sl_dot(set->normal, set->normal) == 0.0f ? SL_SET_NO_NORMAL : 0) | (set->layered ? SL_SET_LAYER : 0);
    t->light[at] = (sl_directional_light){{-1.0f - (float)count, (float)flags, set->height},
                                          sl_direction_pack(sl_to_double(set->normal))};
    memcpy(t->light + at + 1, light, count * sizeof *light);
    return 1 + count;
}

static void fill_lights(sl_voxel_texture *t, const sl_voxel_lights *lights, const uint32_t *place_of_leaf) {
    /* dark, where there is such a leaf */
    if (t->split) t->light[0] = (sl_directional_light){{-1.0f, SL_SET_NO_NORMAL, 0.0f}, 0.0f};
    for (size_t i = 0; i < lights->leaf_count; i++) {
        if (is_dark(lights, i)) continue;
        uint32_t first = lights->first_set[i], end = lights->first_set[i + 1];
        size_t at = place_of_leaf[i];
        if (t->split) {
            for (uint32_t s = first; s < end; s++) at += put_set(t, lights, at, s, s + 1 < end);
            continue;
        }
        memcpy(t->light + at, lights->light + (size_t)first * (size_t)lights->texels,
               (size_t)t->lights * sizeof *t->light);
        t->facing[at / (size_t)t->lights] =
            (sl_array_facing){lights->set[first].normal, lights->set[first].both_sides};
    }
}

sl_set_head sl_voxel_texture_head(const sl_voxel_texture *t, size_t texel) {
    const sl_directional_light *first = &t->light[texel];
    bool head = first->color[0] < 0.0f;
    uint32_t flags = (uint32_t)(head ? first->color[1] : first->packed / 65536.0f);
    return (sl_set_head){.texels = head,
                         .lights = head ? (int)(-1.0f - first->color[0]) : 1,
                         .has_normal = !(flags & SL_SET_NO_NORMAL),
                         .turn = (flags & SL_SET_TURNS) != 0,
                         .one_sided = (flags & SL_SET_ONE_SIDED) != 0,
                         .layer = (flags & SL_SET_LAYER) != 0,
                         .height = head ? first->color[2] : 0.0f,
                         .more = (flags & SL_SET_MORE) != 0};
}

static void unpack_lights(sl_voxel_texture *t) {
    for (size_t i = 0; i < t->texel_count; i++) {
        float flags = t->split ? floorf(t->light[i].packed / 65536.0f) : 0.0f;
        sl_vec3 d = sl_direction_unpack(t->light[i].packed - 65536.0f * flags);
        t->unpacked[i] = (sl_unpacked_light){
            {d.x, d.y, d.z}, {t->light[i].color[0], t->light[i].color[1], t->light[i].color[2]}};
    }
}

static sl_status fill_index(sl_voxel_texture *t, const sl_octree *octree, const uint32_t *place_of_leaf,
                            sl_error *error) {
    size_t cells = (size_t)1 << octree->depth;
    t->index = sl_allocate(cells * cells * cells, sizeof *t->index);
    if (!t->index) return sl_fail_memory(error, "the octree's index");
    memset(t->index, 0xff, cells * cells * cells * sizeof *t->index);
    for (size_t i = 0; i < octree->leaf_count; i++) {
        uint32_t c[3];
        sl_morton_decode(octree->leaf[i].morton, c);
        t->index[(c[2] * cells + c[1]) * cells + c[0]] = place_of_leaf[i];
    }
    return SL_OK;
}

/* ---- the whole ---- */

static sl_status fill(sl_voxel_texture *t, const sl_octree *octree, const sl_voxel_lights *lights,
                      uint32_t *place_of_leaf, bool dense_index, sl_error *error) {
    sl_status status = place_leaves(t, lights, place_of_leaf, error);
    if (status == SL_OK) status = create_bricks(t, octree, error);
    if (status == SL_OK) status = create_lights(t, error);
    if (status != SL_OK) return status;
    fill_bricks(t, octree, place_of_leaf);
    fill_lights(t, lights, place_of_leaf);
    unpack_lights(t);
    return dense_index ? fill_index(t, octree, place_of_leaf, error) : status;
}

sl_status sl_voxel_texture_create(const sl_octree *octree, const sl_voxel_lights *lights, bool dense_index,
                                  sl_voxel_texture **result, sl_error *error) {
    *result = NULL;
    sl_voxel_texture *t = sl_allocate(1, sizeof *t);
    uint32_t *place_of_leaf = sl_allocate(octree->leaf_count, sizeof *place_of_leaf);
    sl_status status = t && place_of_leaf ? SL_OK : sl_fail_memory(error, "the octree's texture");
    if (status == SL_OK) {
        *t = (sl_voxel_texture){.depth = octree->depth,
                                .origin = octree->origin,
                                .edge = octree->edge,
                                .lobes = lights->options.lobes,
                                .split = lights->options.split_by_normal,
                                .lights = lights->texels};
        status = fill(t, octree, lights, place_of_leaf, dense_index, error);
    }
    sl_free(place_of_leaf);
    if (status != SL_OK) sl_voxel_texture_destroy(t);
    else *result = t;
    return status;
}

void sl_voxel_texture_destroy(sl_voxel_texture *t) {
    if (!t) return;
    sl_volume_destroy(t->bricks);
    sl_free(t->light);
    sl_free(t->unpacked);
    sl_free(t->facing);
    sl_free(t->index);
    sl_free(t);
}

size_t sl_voxel_texture_bytes(const sl_voxel_texture *t) {
    size_t texels = (size_t)t->bricks->width * (size_t)t->bricks->height * (size_t)t->bricks->depth;
    return 4 * texels + (size_t)t->width * (size_t)t->height * sizeof *t->light;
}

size_t sl_voxel_texture_resident_bytes(const sl_voxel_texture *t) {
    size_t lights = (size_t)t->width * (size_t)t->height, cells = (size_t)1 << 3 * t->depth;
    return sizeof *t + sl_voxel_texture_bytes(t) + lights * sizeof *t->unpacked +
           (t->facing ? lights / (size_t)t->lights * sizeof *t->facing : 0) +
           (t->index ? cells * sizeof *t->index : 0);
}

/* ---- the descent ---- */

/* cell = floor(2 frac(p 2^D)) is a bit of floor(p 2^d). Void ends it. */
uint32_t sl_voxel_texture_find_cell(const sl_voxel_texture *t, const int32_t cell[3], uint64_t *fetches) {
    int place[3] = {0, 0, 0};
    uint32_t texel = 0, cells = 1u << t->depth;
    if ((uint32_t)cell[0] >= cells || (uint32_t)cell[1] >= cells || (uint32_t)cell[2] >= cells) return 0;
    for (int bit = t->depth - 1; bit >= 0; bit--) {
        texel = sl_volume_fetch(t->bricks, 2 * place[0] + (cell[0] >> bit & 1),
                                2 * place[1] + (cell[1] >> bit & 1), 2 * place[2] + (cell[2] >> bit & 1));
        ++*fetches;
        if (texel >> 24 != SL_TEXEL_NODE) break;
        for (int axis = 0; axis < 3; axis++) place[axis] = (int)(texel >> 8 * axis & 255);
    }
    return texel;
}

uint32_t sl_voxel_texture_find(const sl_voxel_texture *t, sl_vec3 p, uint32_t *address, uint64_t *fetches) {
    double cells = (double)(1u << t->depth);
    sl_vec3d u = sl_scaled(sl_subd(sl_to_double(p), t->origin), cells / t->edge);
    const double at[3] = {u.x, u.y, u.z};
    int32_t cell[3];
    *address = 0;
    for (int axis = 0; axis < 3; axis++) {
        if (!(at[axis] >= 0.0 && at[axis] < cells)) return SL_TEXEL_VOID; /* outside, or NaN: no light */
        cell[axis] = (int32_t)at[axis];
    }
    uint32_t texel = sl_voxel_texture_find_cell(t, cell, fetches);
    if (texel >> 24 == SL_TEXEL_LEAF) *address = texel & 0xffffffu;
    return texel;
}

size_t sl_voxel_texture_place(const sl_voxel_texture *t, uint32_t address) {
    uint32_t r = address & 255, g = address >> 8 & 255, b = address >> 16 & 255;
    size_t x = r << 4 | g >> 4, y = (g & 15) << 8 | b;
    return y * (size_t)t->width + x;
}

const sl_directional_light *sl_voxel_texture_lights(const sl_voxel_texture *t, uint32_t address) {
    return t->light + sl_voxel_texture_place(t, address);
}
