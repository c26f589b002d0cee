/* Leaves beside finer ones are drawn as fans around their centres, over the vertices that hang on their
 * edges: so both sides of an edge show the same along it, and there are no T-vertices. A point's place in its
 * leaf's fan is the edge towards which it lies as seen from the centre (edge i runs from corner i to i + 1),
 * how far along that edge, and how far out from the centre, 0 to 1. */
#pragma once

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "cache/patches/primitives.h"

typedef struct sl_fan_place {
    int edge;
    float along, out;
} sl_fan_place;

/* a, b: weights of a triangle's corners 1 and 2; of a quadrilateral how far it is to corner 1, and to 3. */
static inline sl_fan_place sl_fan_place_of(bool triangle, float a, float b) {
    if (!triangle) {
        float x = 2.0f * a - 1.0f, y = 2.0f * b - 1.0f, ax = fabsf(x), ay = fabsf(y), out = ax > ay ? ax : ay;
        int edge = ay >= ax ? (y < 0.0f ? 0 : 2) : (x > 0.0f ? 1 : 3);
        float ahead = edge == 0 ? x : edge == 1 ? y : edge == 2 ? -x : -y;
        return (sl_fan_place){edge, out > 0.0f ? 0.5f + 0.5f * (ahead / out) : 0.5f, out};
    }
    /* by choice of numbers, so that lanes can have it */
    const float c = 1.0f - a - b > 0.0f ? 1.0f - a - b : 0.0f;
    const int edge = ((b <= c) & (b <= a)) ? 0 : c <= a ? 1 : 2;
    const float least = edge == 0 ? b : edge == 1 ? c : a,
                from = (edge == 0 ? c : edge == 1 ? a : b) - least,
                to = (edge == 0 ? a : edge == 1 ? b : c) - least, sum = from + to;
    return (sl_fan_place){edge, sum > 0.0f ? to / (sum > 0.0f ? sum : 1.0f) : 0.5f, sum < 1.0f ? sum : 1.0f};
}

/* Returns the value `out` of the way from the centre to a point s of the way along a piece of an edge, from a
 * to b: exactly these at its ends. */
static inline float sl_fan_value(float centre, float out, float s, float a, float b) {
    const bool near = s <= 0.5f;
    const float from = near ? a : b, to = near ? b : a;
    const float on_edge = from + (near ? s : 1.0f - s) * (to - from);
    return centre + out * (on_edge - centre);
}

/* A vertex on an edge of a leaf, so far along it in 1/SL_PATCH_DYADIC. */
typedef struct sl_fan_spoke {
    uint32_t vertex;
    uint16_t edge, along;
} sl_fan_spoke;

/* Gives the ends of the piece of the edge on which a place lies; returns how far along the piece it is.
 * Spokes are in order around the leaf. */
static inline float sl_fan_piece(int corners, const uint32_t *corner, size_t count, const sl_fan_spoke *spoke,
                                 const sl_fan_place *place, uint32_t end[2]) {
    const int32_t whole_edge = SL_PATCH_DYADIC;
    float along = place->along * (float)whole_edge;
    int32_t whole = (int32_t)along, low = 0, high = whole_edge, next = place->edge + 1;
    uint32_t from = corner[place->edge], to = corner[next == corners ? 0 : next];
    /* no choice of ways, but of numbers: nobody could guess the ways */
    for (size_t k = 0; k < count; k++) {
        int32_t at = spoke[k].along;
        bool here = spoke[k].edge == place->edge, before = here & (at <= whole),
             beyond = here & (at > whole) & (at < high);
        low = before ? at : low;
        from = before ? spoke[k].vertex : from;
        high = beyond ? at : high;
        to = beyond ? spoke[k].vertex : to;
    }
    end[0] = from;
    end[1] = to;
    return (along - (float)low) / (float)(high - low);
}

/* The part of a leaf's vertices in what a place shows: of its corners, and of the ends of a piece of an edge.
 */
typedef struct sl_vertex_shares {
    size_t count;
    uint32_t vertex[6];
    double weight[6];
} sl_vertex_shares;
void sl_share_add(sl_vertex_shares *shares, uint32_t vertex, double weight);
/* Returns those at a place (a, b) of a leaf, as sl_fan_place_of() has it; count 0: there are no spokes, and
 * the leaf is linear or bilinear. */
sl_vertex_shares sl_leaf_shares(int corners, const uint32_t *corner, size_t count, const sl_fan_spoke *spoke,
                                double a, double b);
