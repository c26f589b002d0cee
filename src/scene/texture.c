#include "scene/texture.h"

#include <math.h>

#include "scene/texture_rules.h"

/* The four texels around a point and the weights between them. */
typedef struct footprint {
    const uint8_t *texel[4]; /* lower left, lower right, upper left, upper right */
    float right, up;
} footprint;

static footprint footprint_at(const sl_texture *texture, float u, float v) {
    footprint f;
    sl_texel_pair column = sl_texel_pair_at(u, texture->width), row = sl_texel_pair_at(v, texture->height);
    f.right = column.beyond;
    f.up = row.beyond;
    for (int i = 0; i < 4; i++) {
        size_t from_top = (size_t)(texture->height - 1 - (i < 2 ? row.texel : row.next));
        f.texel[i] = texture->texels +
                     4 * (from_top * (size_t)texture->width + (size_t)(i % 2 ? column.next : column.texel));
    }
    return f;
}

static float filter(const footprint *f, const float value[4]) {
    return sl_texel_bilinear(value[0], value[1], value[2], value[3], f->right, f->up);
}

sl_rgb sl_texture_color(const sl_texture *texture, float u, float v) {
    footprint f = footprint_at(texture, u, v);
    float channel[3];
    for (int c = 0; c < 3; c++) {
        float value[4];
        for (int i = 0; i < 4; i++) value[i] = sl_srgb_to_linear[f.texel[i][c]];
        channel[c] = filter(&f, value);
    }
    return (sl_rgb){channel[0], channel[1], channel[2]};
}

/* The texel along one axis that a coordinate lies in, wrapped. */
static int place_nearest(float coordinate, int size) {
    if (!(fabsf(coordinate) < 0x1p24f)) return 0; /* beyond, floats have no fraction; also NaN */
    float turn = coordinate - (float)(int)coordinate;
    int index = (int)((turn < 0.0f ? turn + 1.0f : turn) * (float)size);
    return index < size ? index : size - 1;
}

const uint8_t *sl_texture_nearest_texel(const sl_texture *texture, float u, float v) {
    size_t column = (size_t)place_nearest(u, texture->width),
           row = (size_t)(texture->height - 1 - place_nearest(v, texture->height));
    return texture->texels + 4 * (row * (size_t)texture->width + column);
}

sl_rgb sl_texture_nearest(const sl_texture *texture, float u, float v) {
    const uint8_t *t = sl_texture_nearest_texel(texture, u, v);
    return (sl_rgb){sl_srgb_to_linear[t[0]], sl_srgb_to_linear[t[1]], sl_srgb_to_linear[t[2]]};
}

float sl_texture_height(const sl_texture *texture, float u, float v) {
    footprint f = footprint_at(texture, u, v);
    float value[4];
    for (int i = 0; i < 4; i++)
        value[i] = (float)((int)f.texel[i][0] + (int)f.texel[i][1] + (int)f.texel[i][2]);
    return filter(&f, value) * (1.0f / 765.0f);
}

float sl_texture_alpha(const sl_texture *texture, float u, float v) {
    footprint f = footprint_at(texture, u, v);
    float value[4];
    for (int i = 0; i < 4; i++) {
        const uint8_t *t = f.texel[i];
        value[i] = texture->has_alpha ? (float)t[3]
                                      : sl_luminance((sl_rgb){(float)t[0], (float)t[1], (float)t[2]});
    }
    return filter(&f, value) * (1.0f / 255.0f);
}
