/* From a point of a root to its leaf in the display arrays, and to what the leaf shows there: the same leaf as sl_patch_locate() finds. */
#ifndef SL_SHADING_CACHE_LEAF_LOOKUP_H
#define SL_SHADING_CACHE_LEAF_LOOKUP_H

#include <math.h>
#include <string.h>

#include "cache/shading_cache/display_parts.h"

/* The leaf that was found last: neighbours mostly lie in the same one. */
typedef struct sl_leaf {
    uint32_t patch, word;
    bool triangle;
    uint32_t vertex[4];
    double u, v, scale;        /* corner 0, and how many leaves to the root's side; negative for triangles turned by half a turn */
    double a, b;               /* the point: 0 to 1 from corner 0 to corner 1, and to the last corner */
} sl_leaf;

/* Strictly inside: on edges it is for the tree to say. All numbers are exact, as scales are powers of two. */
static inline bool sl_leaf_still_holds(sl_leaf *leaf, double u, double v) {
    double a = (u - leaf->u) * leaf->scale, b = (v - leaf->v) * leaf->scale;
    if (!(a > 0.0 && b > 0.0 && (leaf->triangle ? a + b < 1.0 : (a < 1.0 && b < 1.0)))) return false;
    leaf->a = a;
    leaf->b = b;
    return true;
}

/* Corners of children, in the parent's corners and then the vertices of their block: see patches.c. */
static const uint8_t sl_triangle_corner[4][4] = {{0, 4, 6, 0}, {4, 1, 5, 0}, {6, 5, 2, 0}, {5, 6, 4, 0}};
static const uint8_t sl_quad_corner[4][4] = {{0, 4, 8, 7}, {4, 1, 5, 8}, {8, 5, 2, 6}, {7, 8, 6, 3}};

static inline void sl_leaf_step(sl_leaf *leaf, const sl_display_block *block) {
    double a = 2.0 * leaf->a, b = 2.0 * leaf->b, side = 0.5 / leaf->scale;
    uint32_t child, vertex[9];
    memcpy(vertex, leaf->vertex, sizeof leaf->vertex);
    memcpy(vertex + 4, block->vertex, sizeof block->vertex);
    const uint8_t *corner;
    if (leaf->triangle) {
        child = a >= 1.0 ? 1 : b >= 1.0 ? 2 : a + b <= 1.0 ? 0 : 3;
        corner = sl_triangle_corner[child];
    } else {
        child = a < 1.0 ? (b < 1.0 ? 0 : 3) : (b < 1.0 ? 1 : 2);
        corner = sl_quad_corner[child];
    }
    bool right = child == 1 || (leaf->triangle ? child == 3 : child == 2), up = child >= 2, turned = leaf->triangle && child == 3;
    leaf->u += right ? side : 0.0;
    leaf->v += up ? side : 0.0;
    a -= right ? 1.0 : 0.0;
    b -= up ? 1.0 : 0.0;
    leaf->a = turned ? -a : a;
    leaf->b = turned ? -b : b;
    leaf->scale *= turned ? -2.0 : 2.0;
    for (int c = 0; c < 4; c++) leaf->vertex[c] = vertex[corner[c]];
    leaf->patch = 4 * leaf->word + child;
    leaf->word = block->child[child];
}

/* u and v in [0,1]. */
static inline void sl_leaf_find(const sl_display_copy *copy, const sl_display_root *root, bool triangle, double u, double v, sl_leaf *leaf) {
    *leaf = (sl_leaf){.patch = root->patch, .word = copy->block[root->patch / 4].child[root->patch % 4], .triangle = triangle,
                      .scale = 1.0, .a = u, .b = v};
    memcpy(leaf->vertex, root->vertex, sizeof leaf->vertex);
    while (!sl_is_leaf_word(leaf->word)) sl_leaf_step(leaf, &copy->block[leaf->word]);
}

/* ---- what it shows ------------------------------------------------------------------------------------------------------------ */

static inline const float *sl_display_value(const sl_display_copy *copy, size_t channels, uint32_t vertex) {
    return copy->value + channels * vertex;
}

static inline float sl_between_0_and_1(double t) { return t > 0.0 ? (t < 1.0 ? (float)t : 1.0f) : 0.0f; }

/* The edge towards which a point lies as seen from the centre (edge i is corner i to i + 1), how far along it, and how far out from the centre. */
typedef struct sl_fan_place {
    int edge;
    float along, out;
} sl_fan_place;

static inline sl_fan_place sl_fan_place_of(const sl_leaf *leaf) {
    float a = sl_between_0_and_1(leaf->a), b = sl_between_0_and_1(leaf->b);
    if (!leaf->triangle) {
        float x = 2.0f * a - 1.0f, y = 2.0f * b - 1.0f, ax = fabsf(x), ay = fabsf(y), out = ax > ay ? ax : ay;
        int edge = ay >= ax ? (y < 0.0f ? 0 : 2) : (x > 0.0f ? 1 : 3);
        float ahead = edge == 0 ? x : edge == 1 ? y : edge == 2 ? -x : -y;
        return (sl_fan_place){edge, out > 0.0f ? 0.5f + 0.5f * (ahead / out) : 0.5f, out};
    }
    float w[3] = {sl_between_0_and_1(1.0 - leaf->a - leaf->b), a, b};
    int edge = w[2] <= w[0] && w[2] <= w[1] ? 0 : w[0] <= w[1] ? 1 : 2;
    float least = w[(edge + 2) % 3], from = w[edge] - least, to = w[(edge + 1) % 3] - least;
    return (sl_fan_place){edge, from + to > 0.0f ? to / (from + to) : 0.5f, sl_between_0_and_1((double)(from + to))};
}

/* Ends of the piece of an edge on which a place lies, and how far along the piece it is. */
static inline float sl_fan_piece(const sl_fans *fans, const sl_leaf *leaf, const sl_fan_place *place, uint32_t end[2]) {
    const uint32_t *fan = fans->word + (size_t)SL_FAN_SMALLEST * (leaf->word & (SL_FAN_BIT - 1));
    uint32_t count[4], before = 0, all = 0;
    for (int e = 0; e < 4; e++) {
        count[e] = fan[e / 2] >> 16 * (e % 2) & 0xffff;
        before += e < place->edge ? count[e] : 0;
        all += count[e];
    }
    const uint32_t *vertex = fan + 2 + before;
    const uint16_t *at = (const uint16_t *)(fan + 2 + all) + before;
    float along = place->along * (float)SL_PATCH_DYADIC, low = 0.0f, high = SL_PATCH_DYADIC;
    int corners = leaf->triangle ? 3 : 4;
    end[0] = leaf->vertex[place->edge];
    end[1] = leaf->vertex[(place->edge + 1) % corners];
    for (uint32_t k = 0; k < count[place->edge]; k++) {
        if (along < (float)at[k]) {
            high = (float)at[k];
            end[1] = vertex[k];
            break;
        }
        low = (float)at[k];
        end[0] = vertex[k];
    }
    return (along - low) / (high - low);
}

/* Vertices of which a point's value is made, and their weights: four at most, or, in a fan, all corners for the centre and two on the edge. */
typedef struct sl_leaf_weights {
    int count;
    uint32_t vertex[6];
    float weight[6];
} sl_leaf_weights;

static inline sl_leaf_weights sl_leaf_weights_at(const sl_display_copy *copy, const sl_leaf *leaf) {
    sl_leaf_weights w = {.count = leaf->triangle ? 3 : 4};
    for (int c = 0; c < w.count; c++) w.vertex[c] = leaf->vertex[c];
    if (sl_is_fan_word(leaf->word)) {
        sl_fan_place place = sl_fan_place_of(leaf);
        for (int c = 0; c < w.count; c++) w.weight[c] = (1.0f - place.out) / (float)w.count;
        float along = sl_fan_piece(&copy->fans, leaf, &place, w.vertex + w.count);
        w.weight[w.count++] = place.out * (1.0f - along);
        w.weight[w.count++] = place.out * along;
        return w;
    }
    float a = sl_between_0_and_1(leaf->a), b = sl_between_0_and_1(leaf->b);
    if (leaf->triangle) {
        w.weight[0] = sl_between_0_and_1(1.0 - leaf->a - leaf->b);
        w.weight[1] = a;
        w.weight[2] = b;
    } else {
        w.weight[0] = (1.0f - a) * (1.0f - b);
        w.weight[1] = a * (1.0f - b);
        w.weight[2] = a * b;
        w.weight[3] = (1.0f - a) * b;
    }
    return w;
}

/* channels: 3 or 6. */
static inline void sl_leaf_value(const sl_display_copy *copy, size_t channels, const sl_leaf *leaf, float value[6]) {
    sl_leaf_weights w = sl_leaf_weights_at(copy, leaf);
    for (size_t c = 0; c < channels; c++) value[c] = 0.0f;
    for (int k = 0; k < w.count; k++) {
        const float *corner = sl_display_value(copy, channels, w.vertex[k]);
        for (size_t c = 0; c < channels; c++) value[c] += w.weight[k] * corner[c];
    }
}

#endif
