#include "cache/light_octree/voxel_texture.h"

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"

/* ---- a direction in one float beside its light's colour ---- */

/* Polar angle and azimuth in equal steps, a = columns * q_theta + q_phi. The number of steps of theta is
 * even, so that the six axes have codes of their own; an integer below 2^24 is exact in 32 bits. */
enum { COLUMNS = 256, STEPS = 254 /* of theta, from pole to pole */ };

/* sin and cos of step / steps of a full turn; steps is a multiple of four or twice an odd number, quarter
 * turns are exact. */
static void turn(uint32_t step, uint32_t steps, double *sine, double *cosine) {
    uint32_t quarters = 4 * step / steps;
    /* in the quarter */
    double angle = 2.0 * SL_PI * ((double)(4 * step - quarters * steps) / (4.0 * (double)steps));
    double s = 4 * step == quarters * steps ? 0.0 : sl_sin(angle),
           c = 4 * step == quarters * steps ? 1.0 : sl_cos(angle);
    switch (quarters & 3) {
    case 0: *sine = s, *cosine = c; break;
    case 1: *sine = c, *cosine = -s; break;
    case 2: *sine = -s, *cosine = -c; break;
    default: *sine = -c, *cosine = s; break;
    }
}

float sl_direction_pack(sl_vec3d d) {
    const double columns = COLUMNS, steps = STEPS;
    double length = sl_lengthd(d);
    if (!(length > 0.0 && length <= DBL_MAX)) return 0.0f; /* the pole */
    double theta = sl_acos(d.z / length), phi = sl_atan2(d.y, d.x);
    if (phi < 0.0) phi += 2.0 * SL_PI;
    double q_theta = floor(steps * theta / SL_PI + 0.5), q_phi = floor(columns * phi / (2.0 * SL_PI) + 0.5);
    return (float)(columns * q_theta + (q_phi < columns ? q_phi : 0.0));
}

static sl_vec3 compose(double sin_theta, double cos_theta, double sin_phi, double cos_phi) {
    return sl_v3((float)(sin_theta * cos_phi), (float)(sin_theta * sin_phi), (float)cos_theta);
}

/* Returns the nearest code of what is none. */
static uint32_t code_of(float packed) {
    static const uint32_t last = COLUMNS * STEPS + COLUMNS - 1;
    if (!(packed > 0.0f)) return 0;
    return packed < (float)last ? (uint32_t)packed : last;
}

sl_vec3 sl_direction_unpack(float packed) {
    uint32_t code = code_of(packed);
    double sin_theta, cos_theta, sin_phi, cos_phi;
    turn(code / COLUMNS, 2 * STEPS, &sin_theta, &cos_theta);
    turn(code % COLUMNS, COLUMNS, &sin_phi, &cos_phi);
    return compose(sin_theta, cos_theta, sin_phi, cos_phi);
}

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
    for (size_t i = 0; i < octree->leaf_count; i++)
        count += i == 0 || octree->leaf[i].morton >> shift != octree->leaf[i - 1].morton >> shift;
    return count;
}

/* As near to a cuboid without waste as it gets. */
static sl_status create_bricks(sl_voxel_texture *t, const sl_octree *octree, sl_error *error) {
    size_t count = 1, side = BRICKS_A_SIDE;
    for (int level = 1; level < octree->depth; level++) count += nodes_at(octree, level);
    size_t deep = (count + side * side - 1) / (side * side), high = (count + side * deep - 1) / (side * deep),
           wide = (count + high * deep - 1) / (high * deep);
    if (deep > side)
        return sl_fail(error, SL_ERROR_RESOURCES,
                       "the octree has %zu bricks, 24 bits address %zu: a smaller depth is needed", count,
                       side * side * side);
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
    size_t x = at % SL_LIGHT_TEXTURE_SIZE, y = at / SL_LIGHT_TEXTURE_SIZE;
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

static size_t texels_of_leaf(const sl_voxel_lights *lights, size_t leaf) {
    size_t lit = 0, sets = lights->first_set[leaf + 1] - lights->first_set[leaf];
    for (uint32_t s = lights->first_set[leaf]; s < lights->first_set[leaf + 1]; s++)
        lit += lights->set[s].lights;
    return lit > 0 ? sets + lit : 0;
}

/* In order of leaves; those without light share the first texel. */
static sl_status place_leaves(sl_voxel_texture *t, const sl_voxel_lights *lights, uint32_t *place_of_leaf,
                              sl_error *error) {
    const size_t width = SL_LIGHT_TEXTURE_SIZE, most = width * width;
    size_t dark = 0, texels = 0;
    for (size_t i = 0; i < lights->leaf_count; i++) {
        size_t here = texels_of_leaf(lights, i);
        if (here == 0) dark = 1;
        else t->set_count += lights->first_set[i + 1] - lights->first_set[i];
        texels += here;
    }
    size_t at = dark;
    t->set_count += dark;
    for (size_t i = 0; i < lights->leaf_count && at <= most; i++) {
        size_t here = texels_of_leaf(lights, i);
        if (at % width + here > width) at += width - at % width; /* one leaf's never wrap */
        place_of_leaf[i] = here > 0 ? (uint32_t)at : 0;
        at += here;
    }
    t->texel_count = at;
    if (at <= most) return SL_OK;
    return sl_fail(error, SL_ERROR_RESOURCES,
                   "%zu sets of lights take %zu texels, 24 bits address %zu: fewer lights or a smaller "
                   "depth are needed",
                   t->set_count, texels + dark, most);
}

static sl_unpacked_light texel_of(sl_vec3 direction, const float color[3]) {
    return (sl_unpacked_light){{direction.x, direction.y, direction.z}, {color[0], color[1], color[2]}};
}

/* A head's red is the number of lights, its green the flags, its blue the height of a layer. */
enum { TURNS = 1, MORE = 2, LAYER = 4 };

/* Returns how many texels the set took. */
static size_t put_set(sl_unpacked_light *texel, const sl_voxel_lights *lights, uint32_t number, bool more) {
    const sl_voxel_set *set = &lights->set[number];
    const sl_directional_light *light = lights->light + (size_t)number * (size_t)lights->texels;
    const int flags = (set->opposed ? 0 : TURNS) | (more ? MORE : 0) | (set->layered ? LAYER : 0);
    const float head[3] = {(float)set->lights, (float)flags, set->height};
    sl_vec3 normal = set->normal;
    if (sl_dot(normal, normal) > 0.0f)
        normal = sl_direction_unpack(sl_direction_pack(sl_to_double(normal)));
    texel[0] = texel_of(normal, head);
    for (size_t j = 0; j < set->lights; j++)
        texel[1 + j] = texel_of(sl_direction_unpack(light[j].packed), light[j].color);
    return 1 + (size_t)set->lights;
}

/* Dark leaves' texel, the first, stays 0: no lights, no normal. */
static void fill_lights(sl_voxel_texture *t, const sl_voxel_lights *lights, const uint32_t *place_of_leaf) {
    for (size_t i = 0; i < lights->leaf_count; i++) {
        size_t at = place_of_leaf[i];
        if (texels_of_leaf(lights, i) == 0) continue;
        for (uint32_t s = lights->first_set[i], end = lights->first_set[i + 1]; s < end; s++)
            at += put_set(t->light + at, lights, s, s + 1 < end);
    }
}

sl_shade_set sl_voxel_texture_set(const sl_voxel_texture *t, size_t texel) {
    const sl_unpacked_light *head = &t->light[texel];
    const int flags = (int)head->color[1];
    return (sl_shade_set){.light = head + 1,
                          .lights = (int)head->color[0],
                          .normal = {head->direction[0], head->direction[1], head->direction[2]},
                          .turn = (flags & TURNS) != 0,
                          .layer = (flags & LAYER) != 0,
                          .height = head->color[2],
                          .more = (flags & MORE) != 0};
}

/* ---- the whole ---- */

static sl_status fill(sl_voxel_texture *t, const sl_octree *octree, const sl_voxel_lights *lights,
                      uint32_t *place_of_leaf, sl_error *error) {
    sl_status status = place_leaves(t, lights, place_of_leaf, error);
    if (status == SL_OK) status = create_bricks(t, octree, error);
    if (status != SL_OK) return status;
    t->light = sl_allocate(t->texel_count, sizeof *t->light);
    if (!t->light) return sl_fail_memory(error, "the texture of lights");
    fill_bricks(t, octree, place_of_leaf);
    fill_lights(t, lights, place_of_leaf);
    return SL_OK;
}

sl_status sl_voxel_texture_create(const sl_octree *octree, const sl_voxel_lights *lights,
                                  sl_voxel_texture **result, sl_error *error) {
    *result = NULL;
    sl_voxel_texture *t = sl_allocate(1, sizeof *t);
    uint32_t *place_of_leaf = sl_allocate(octree->leaf_count, sizeof *place_of_leaf);
    sl_status status = t && place_of_leaf ? SL_OK : sl_fail_memory(error, "the octree's texture");
    if (status == SL_OK) {
        *t = (sl_voxel_texture){.depth = octree->depth,
                                .origin = octree->origin,
                                .edge = octree->edge,
                                .scale = (double)(1u << octree->depth) / octree->edge,
                                .lobes = lights->options.lobes,
                                .lights = lights->texels};
        status = fill(t, octree, lights, place_of_leaf, error);
    }
    sl_free(place_of_leaf);
    if (status != SL_OK) sl_voxel_texture_destroy(t);
    else *result = t;
    return status;
}

void sl_voxel_texture_destroy(sl_voxel_texture *t) {
    if (!t) return;
    sl_volume_destroy(t->bricks);
    SL_FREE_ALL(t->light, t);
}

size_t sl_voxel_texture_bytes(const sl_voxel_texture *t) {
    size_t texels = (size_t)t->bricks->width * (size_t)t->bricks->height * (size_t)t->bricks->depth;
    return 4 * texels + t->texel_count * sizeof(sl_directional_light);
}

size_t sl_voxel_texture_resident_bytes(const sl_voxel_texture *t) {
    const size_t more = sizeof(sl_unpacked_light) - sizeof(sl_directional_light);
    return sizeof *t + sl_voxel_texture_bytes(t) + t->texel_count * more;
}

/* ---- the descent ---- */

/* Decodes the address of a leaf: 12 bits of x, 12 of y. */
static size_t place_of(uint32_t address) {
    uint32_t r = address & 255, g = address >> 8 & 255, b = address >> 16 & 255;
    size_t x = r << 4 | g >> 4, y = (g & 15) << 8 | b;
    return y * SL_LIGHT_TEXTURE_SIZE + x;
}

/* cell = floor(2 frac(p 2^D)) is a bit of floor(p 2^d). Void ends it. */
size_t sl_voxel_texture_find(const sl_voxel_texture *t, const int32_t cell[3], uint64_t *fetches) {
    int place[3] = {0, 0, 0};
    uint32_t texel = 0, cells = 1u << t->depth;
    if ((uint32_t)cell[0] >= cells || (uint32_t)cell[1] >= cells || (uint32_t)cell[2] >= cells)
        return SIZE_MAX;
    for (int bit = t->depth - 1; bit >= 0; bit--) {
        texel = sl_volume_fetch(t->bricks, 2 * place[0] + (cell[0] >> bit & 1),
                                2 * place[1] + (cell[1] >> bit & 1), 2 * place[2] + (cell[2] >> bit & 1));
        ++*fetches;
        if (texel >> 24 != SL_TEXEL_NODE) break;
        for (int axis = 0; axis < 3; axis++) place[axis] = (int)(texel >> 8 * axis & 255);
    }
    return texel >> 24 == SL_TEXEL_LEAF ? place_of(texel & 0xffffffu) : SIZE_MAX;
}
