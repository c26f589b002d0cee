/* From a point of a root to its leaf in the display arrays, and to what the leaf shows there: the same leaf
 * as sl_patch_locate() finds. */
#pragma once

#include <string.h>

#include "cache/patches/display/display.h"

/* Places in a root count in 2^-24: so many digits has a float below 1, and no leaf is smaller than 2^-14. All
 * is exact. */
enum { SL_PLACE_BITS = 24, SL_PLACE_ONE = 1 << SL_PLACE_BITS };
static inline int32_t sl_place_of(float t) {
    return t > 0.0f ? (t < 1.0f ? (int32_t)(t * (float)SL_PLACE_ONE) : SL_PLACE_ONE) : 0;
}

/* A leaf and the way to it. */
typedef struct sl_leaf {
    const sl_wanted_root *root;
    bool triangle;
    int depth;                 /* -1: none yet */
    uint32_t word;
    uint32_t block[SL_PATCH_DEPTH_MAX + 1]; /* from depth 1 on: in which it is ... */
    uint8_t child[SL_PATCH_DEPTH_MAX + 1];  /* ... and which of the four */
    int32_t last_u, last_v;    /* squares: the place that was found; triangles: corner 0 */
    int32_t side;              /* negative for triangles turned by half a turn */
    float over_side;
    float a, b;                /* the place: 0 to 1 from corner 0 to corner 1, and to the last corner */
} sl_leaf;

static inline sl_leaf sl_leaf_begin(const sl_wanted_root *root, bool triangle) {
    return (sl_leaf){.root = root, .triangle = triangle, .depth = -1};
}

static inline uint32_t sl_leaf_patch(const sl_leaf *leaf) {
    return leaf->depth == 0 ? leaf->root->patch : 4 * leaf->block[leaf->depth] + leaf->child[leaf->depth];
}

static inline void sl_leaf_step(const sl_display_copy *copy, sl_leaf *leaf, uint32_t child) {
    leaf->depth++;
    leaf->block[leaf->depth] = leaf->word;
    leaf->child[leaf->depth] = (uint8_t)child;
    leaf->word = copy->word[4 * leaf->word + child];
}

/* Descends by the children that the digits of u and v tell. As many first digits as this place has in common
 * with the last one, so much of the way is the same. Returns whether it is the same leaf. */
static inline bool sl_leaf_of_square(const sl_display_copy *copy, sl_leaf *leaf, int32_t u, int32_t v) {
    int32_t inside_u = u < SL_PLACE_ONE ? u : SL_PLACE_ONE - 1,
            inside_v = v < SL_PLACE_ONE ? v : SL_PLACE_ONE - 1;
    uint32_t differing = (uint32_t)((inside_u ^ leaf->last_u) | (inside_v ^ leaf->last_v));
    leaf->last_u = inside_u;
    leaf->last_v = inside_v;
    if (leaf->depth >= 0) {
        if (differing >> (SL_PLACE_BITS - leaf->depth) == 0) return true;
        leaf->depth = __builtin_clz(differing) - (32 - SL_PLACE_BITS); /* up to where they part */
        leaf->word = leaf->block[leaf->depth + 1];
    } else {
        leaf->depth = 0;
        leaf->word = copy->word[leaf->root->patch];
    }
    while (!sl_is_leaf_word(leaf->word)) {
        int digit = SL_PLACE_BITS - 1 - leaf->depth;
        uint32_t right = (uint32_t)inside_u >> digit & 1, up = (uint32_t)inside_v >> digit & 1;
        sl_leaf_step(copy, leaf, (right ^ up) | up << 1);
    }
    leaf->side = SL_PLACE_ONE >> leaf->depth;
    leaf->over_side = 1.0f / (float)leaf->side;
    return false;
}

/* On edges it is for the tree to say: the last leaf still holds what lies strictly inside it. */
static inline bool sl_leaf_of_triangle(const sl_display_copy *copy, sl_leaf *leaf, int32_t u, int32_t v) {
    if (leaf->depth >= 0) {
        bool turned = leaf->side < 0;
        int32_t a = turned ? leaf->last_u - u : u - leaf->last_u,
                b = turned ? leaf->last_v - v : v - leaf->last_v;
        if (a > 0 && b > 0 && a + b < (turned ? -leaf->side : leaf->side)) return true;
    }
    int32_t a = u, b = v, half = SL_PLACE_ONE, turn = 1;
    leaf->depth = 0;
    leaf->word = copy->word[leaf->root->patch];
    leaf->last_u = leaf->last_v = 0;
    while (!sl_is_leaf_word(leaf->word)) {
        half >>= 1;
        bool right = a >= half, up = !right && b >= half, middle = !right && !up && a + b > half;
        leaf->last_u += right || middle ? turn * half : 0;
        leaf->last_v += up || middle ? turn * half : 0;
        a -= right ? half : 0;
        b -= up ? half : 0;
        a = middle ? half - a : a;
        b = middle ? half - b : b;
        turn = middle ? -turn : turn;
        sl_leaf_step(copy, leaf, right ? 1 : up ? 2 : middle ? 3 : 0);
    }
    leaf->side = turn * (SL_PLACE_ONE >> leaf->depth);
    leaf->over_side = 1.0f / (float)leaf->side;
    return false;
}

/* Returns whether it is the leaf that was found last. */
static inline bool sl_leaf_find(const sl_display_copy *copy, sl_leaf *leaf, int32_t u, int32_t v) {
    bool same = leaf->triangle ? sl_leaf_of_triangle(copy, leaf, u, v) : sl_leaf_of_square(copy, leaf, u, v);
    int32_t corner_u = leaf->triangle ? leaf->last_u : leaf->last_u & -leaf->side,
            corner_v = leaf->triangle ? leaf->last_v : leaf->last_v & -leaf->side;
    leaf->a = (float)(u - corner_u) * leaf->over_side;
    leaf->b = (float)(v - corner_v) * leaf->over_side;
    return same;
}

/* The vertices at its corners: corner i of child i is its parent's, and so on upwards; the others are those
 * that the split has made. */
static inline void sl_leaf_corners(const sl_display_copy *copy, const sl_leaf *leaf, uint32_t vertex[4]) {
    static const uint8_t made[2][4][4] = {{{0, 0, 4, 3}, {0, 0, 1, 4}, {4, 1, 0, 2}, {3, 4, 2, 0}},
                                          /* triangles have no corner 3 */
                                          {{0, 0, 2, 0}, {0, 0, 1, 0}, {2, 1, 0, 0}, {1, 2, 0, 0}}};
    int depth = leaf->depth;
    uint32_t own = depth > 0 ? leaf->child[depth] : 4;
    for (int c = 0; c < 4; c++) {
        vertex[c] = depth > 0 ? copy->middle[leaf->block[depth]][made[leaf->triangle][own][c]]
                              : leaf->root->corner[c];
    }
    if (own >= (leaf->triangle ? 3u : 4u)) return;
    do depth--;
    while (depth > 0 && leaf->child[depth] == own);
    vertex[own] = depth > 0 ? copy->middle[leaf->block[depth]][made[leaf->triangle][leaf->child[depth]][own]]
                            : leaf->root->corner[own];
}

/* ---- what it shows --------------------------------------------------------------------------- */

/* E, and with two colours L_s after it. */
static inline void sl_display_value(const sl_display_copy *copy, size_t colours, uint32_t vertex,
                                    float value[6]) {
    memcpy(value, copy->value + copy->channels * vertex, 3 * colours * sizeof *value);
}

/* The leaf's values as far as they do not depend on the place: k0 + a k1 + b k2 + a b k3, for each channel;
 * of fans their centre, k0, alone. */
typedef struct sl_leaf_field {
    uint32_t corner[4];
    float k[4][6];
} sl_leaf_field;

static inline void sl_leaf_field_of(const sl_display_copy *copy, size_t colours, const sl_leaf *leaf,
                                    sl_leaf_field *field) {
    float corner[4][6];
    bool fan = sl_is_fan_word(leaf->word);
    sl_leaf_corners(copy, leaf, field->corner);
    for (int c = 0; c < 4; c++)
        sl_display_value(copy, colours, field->corner[c == 3 && leaf->triangle ? 2 : c], corner[c]);
    for (size_t i = 0; i < 3 * colours; i++) {
        float v0 = corner[0][i], v1 = corner[1][i], v2 = corner[2][i], v3 = corner[3][i];
        field->k[0][i] = !fan             ? v0
                         : leaf->triangle ? (v0 + v1 + v2) * (1.0f / 3.0f)
                                          : ((v0 + v2) + (v1 + v3)) * 0.25f;
        field->k[1][i] = v1 - v0;
        field->k[2][i] = v3 - v0;
        field->k[3][i] = leaf->triangle ? 0.0f : (v0 - v1) + (v2 - v3);
    }
}

static inline void sl_leaf_value(const sl_display_copy *copy, size_t colours, const sl_leaf *leaf,
                                 const sl_leaf_field *field, float value[6]) {
    if (!sl_is_fan_word(leaf->word)) {
        float a = leaf->a, b = leaf->b, ab = a * b;
        for (size_t i = 0; i < 3 * colours; i++) {
            float plain = (field->k[0][i] + a * field->k[1][i]) + (b * field->k[2][i] + ab * field->k[3][i]);
            value[i] = plain > 0.0f ? plain : 0.0f; /* black corners stay black, whatever rounding says */
        }
        return;
    }
    const sl_fan_spoke *fan = sl_fan_at(&copy->fans, leaf->word);
    sl_fan_place place = sl_fan_place_of(leaf->triangle, leaf->a, leaf->b);
    uint32_t end[2];
    float from[6], to[6], along = sl_fan_piece(leaf->triangle ? 3 : 4, field->corner, fan->vertex, fan + 1,
                                               &place, end);
    sl_display_value(copy, colours, end[0], from);
    sl_display_value(copy, colours, end[1], to);
    for (size_t i = 0; i < 3 * colours; i++) {
        float on_edge = from[i] + along * (to[i] - from[i]);
        value[i] = field->k[0][i] + place.out * (on_edge - field->k[0][i]);
    }
}

/* ---- a pixel, told ------------------------------------------------------------------------------ */

/* What the pixels of one triangle have in common, and the leaf of the last one. */
typedef struct sl_shown_root {
    uint32_t root;             /* SL_NO_INDEX: the background; emission is that */
    const sl_wanted_root *wanted; /* NULL: not wanted yet, it shows the guess */
    bool curved;
    bool lobe;                 /* L_s, too */
    sl_rgb emission, diffuse;
    const sl_texture *texture; /* NULL: diffuse is all */
    sl_leaf leaf;
    sl_leaf_field field;
} sl_shown_root;
/* draw.c: tells of a pixel of the last frame in the display's own window what it shows, L_e + kd E / pi +
 * L_s, in parts, by the functions that draw it; diffuse with its texture. pixel: bottom row first. */
void sl_display_pixel(sl_display *display, size_t pixel, sl_shown_root *shown);
