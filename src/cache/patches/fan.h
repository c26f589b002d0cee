/* Leaves beside finer ones are drawn as fans around their centres, over the vertices that hang on their
 * edges: so both sides of an edge show the same along it, and there are no T-vertices. A point's place in its
 * leaf's fan is the edge towards which it lies as seen from the centre (edge i runs from corner i to i + 1),
 * how far along that edge, and how far out from the centre, 0 to 1. */
#ifndef SL_PATCHES_FAN_H
#define SL_PATCHES_FAN_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

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
    float w[3] = {1.0f - a - b > 0.0f ? 1.0f - a - b : 0.0f, a, b};
    int edge = w[2] <= w[0] && w[2] <= w[1] ? 0 : w[0] <= w[1] ? 1 : 2;
    float least = w[(edge + 2) % 3], from = w[edge] - least, to = w[(edge + 1) % 3] - least;
    return (sl_fan_place){edge, from + to > 0.0f ? to / (from + to) : 0.5f,
                          from + to < 1.0f ? from + to : 1.0f};
}

/* What vertices add to a pixel: of a leaf's corners, and of the ends of a piece of its edge. */
typedef struct sl_vertex_shares {
    size_t count;
    uint32_t vertex[6];
    double weight[6];
} sl_vertex_shares;

static inline void sl_share_add(sl_vertex_shares *s, uint32_t vertex, double weight) {
    size_t at = 0;
    while (at < s->count && s->vertex[at] != vertex) at++;
    if (at == s->count) s->weight[s->count++] = 0.0;
    s->vertex[at] = vertex;
    s->weight[at] += weight;
}

#endif
