/* Where primitives meet: corners and edges that lie in one place, have one normal, one material and belong to
 * one object have one shading. They are joined in rings, and the lowest of a ring stands for all. */
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "base/random.h"
#include "cache/patches/primitive_parts.h"

/* Places are numbered 4 primitive + edge or corner. */
static uint32_t primitive_of(uint32_t code) { return code / 4; }
static int part_of(uint32_t code) { return (int)(code % 4); }

typedef struct place_key {
    float position[6]; /* of a corner; of an edge's ends, the lower one first */
    uint32_t material, object, curved;
} place_key;

typedef struct joint_kind {
    place_key (*key)(const sl_primitives *, uint32_t code);
    bool (*agree)(const sl_primitives *, uint32_t a, uint32_t b);
} joint_kind;

static uint64_t hash_of(const place_key *key) {
    uint64_t hash = (uint64_t)key->material << 32 | key->object, word;
    hash ^= (uint64_t)key->curved << 63;
    for (int i = 0; i < 6; i += 2) {
        memcpy(&word, &key->position[i], sizeof word);
        hash = sl_hash64(hash ^ word);
    }
    return hash;
}

static bool same_key(const place_key *a, const place_key *b) {
    return memcmp(a->position, b->position, sizeof a->position) == 0 && a->material == b->material &&
           a->object == b->object && a->curved == b->curved;
}

/* Each part is compared with the first ones of rings in its place, and begins one of its own where none of
 * them agrees. Where more facets meet than anyone can look at (the tip of a cone), the rest stay by
 * themselves. first: the lowest of each ring, or NULL. */
static sl_status join(const sl_primitives *p, const joint_kind *kind, uint32_t *first, uint32_t *next,
                      sl_error *error) {
    enum { MOST = 64 };
    size_t slots = 16;
    while (slots < 5 * p->count) slots *= 2;
    uint32_t *table = sl_allocate_unset(slots, sizeof *table);
    if (!table) return sl_fail_memory(error, "joining primitives");
    memset(table, 0xff, slots * sizeof *table); /* SL_NO_INDEX */
    for (uint32_t code = 0; code < 4 * (uint32_t)p->count; code++) {
        next[code] = code;
        if (first) first[code] = code;
        if (part_of(code) >= sl_primitive_corners(p, primitive_of(code))) continue;
        place_key key = kind->key(p, code);
        size_t slot = (size_t)hash_of(&key) & (slots - 1);
        int met = 0;
        for (; table[slot] != SL_NO_INDEX && met < MOST; slot = (slot + 1) & (slots - 1)) {
            uint32_t other = table[slot];
            place_key other_key = kind->key(p, other);
            if (!same_key(&key, &other_key)) continue;
            met++;
            if (!kind->agree(p, other, code)) continue;
            if (first) first[code] = other;
            next[code] = next[other];
            next[other] = code;
            break;
        }
        if (table[slot] == SL_NO_INDEX) table[slot] = code;
    }
    sl_free(table);
    return SL_OK;
}

/* ---- corners --------------------------------------------------------------------------------- */

static void put(float to[3], sl_vec3 p) {
    to[0] = p.x + 0.0f; /* -0 as +0 */
    to[1] = p.y + 0.0f;
    to[2] = p.z + 0.0f;
}

static sl_vec3 corner_position(const sl_primitives *p, uint32_t primitive, int corner) {
    return sl_scene_position(p->scene, sl_primitive_corner(p, primitive, corner));
}

static place_key empty_key(const sl_primitives *p, uint32_t primitive) {
    uint32_t t = p->first_triangle[primitive];
    return (place_key){{0}, p->scene->material_index[t], p->scene->object_index[t], 0};
}

static place_key corner_key(const sl_primitives *p, uint32_t code) {
    place_key key = empty_key(p, primitive_of(code));
    put(key.position, corner_position(p, primitive_of(code), part_of(code)));
    return key;
}

static sl_vec3 front_normal(const sl_primitives *p, uint32_t code, uint32_t t) {
    uint32_t u, v;
    sl_lit_point point;
    sl_edge_point(sl_primitive_corners(p, primitive_of(code)), part_of(code), t, &u, &v);
    sl_root_point_at(p, 2 * primitive_of(code), u, v, &point);
    return point.normal;
}

static bool corners_agree(const sl_primitives *p, uint32_t a, uint32_t b) {
    return sl_same_normal(front_normal(p, a, 0), front_normal(p, b, 0));
}

/* ---- edges ----------------------------------------------------------------------------------- */

/* Control points of a bicubic patch along an edge. */
static void control_points(const sl_primitives *p, uint32_t code, sl_vec3 point[4]) {
    static const int start[4][2] = {{0, 0}, {3, 0}, {3, 3}, {0, 3}},
                     step[4][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
    const sl_bicubic *b = &p->scene->bicubics[p->bicubic[primitive_of(code)]];
    int edge = part_of(code);
    for (int k = 0; k < 4; k++)
        point[k] = b->point[start[edge][1] + k * step[edge][1]][start[edge][0] + k * step[edge][0]];
}

static int order(sl_vec3 a, sl_vec3 b) {
    if (a.x != b.x) return a.x < b.x ? -1 : 1;
    if (a.y != b.y) return a.y < b.y ? -1 : 1;
    return a.z < b.z ? -1 : a.z > b.z;
}

static bool is_curved(const sl_primitives *p, uint32_t code) {
    return p->kind[primitive_of(code)] == SL_PRIMITIVE_BICUBIC;
}

/* Edges run from the lower to the higher end; loops are told apart by their inner control points. */
static uint8_t kind_of_edge(const sl_primitives *p, uint32_t code) {
    int corner = part_of(code), corners = sl_primitive_corners(p, primitive_of(code));
    if (!is_curved(p, code)) {
        int direction = order(corner_position(p, primitive_of(code), corner),
                              corner_position(p, primitive_of(code), (corner + 1) % corners));
        return direction > 0 ? SL_EDGE_BACKWARDS : 0;
    }
    sl_vec3 c[4];
    control_points(p, code, c);
    int direction = order(c[0], c[3]) ? order(c[0], c[3]) : order(c[1], c[2]);
    if (direction == 0 && order(c[0], c[1]) == 0) return SL_EDGE_POINT;
    return direction > 0 ? SL_EDGE_BACKWARDS : 0;
}

static place_key edge_key(const sl_primitives *p, uint32_t code) {
    uint32_t primitive = primitive_of(code);
    int corner = part_of(code), other = (corner + 1) % sl_primitive_corners(p, primitive);
    bool backwards = p->edge_kind[code] & SL_EDGE_BACKWARDS;
    place_key key = empty_key(p, primitive);
    put(key.position, corner_position(p, primitive, backwards ? other : corner));
    put(key.position + 3, corner_position(p, primitive, backwards ? corner : other));
    key.curved = is_curved(p, code);
    return key;
}

static bool same_curve(const sl_primitives *p, uint32_t a, uint32_t b) {
    sl_vec3 c[4], d[4];
    control_points(p, a, c);
    control_points(p, b, d);
    bool turned = (p->edge_kind[a] ^ p->edge_kind[b]) & SL_EDGE_BACKWARDS;
    for (int k = 0; k < 4; k++) {
        if (order(c[k], d[turned ? 3 - k : k]) != 0) return false;
    }
    return true;
}

/* Normals along a straight edge are interpolated; those along a curve are looked at in nine places. */
static bool edges_agree(const sl_primitives *p, uint32_t a, uint32_t b) {
    if ((p->edge_kind[a] | p->edge_kind[b]) & SL_EDGE_POINT) return false;
    if (is_curved(p, a) && !same_curve(p, a, b)) return false;
    uint32_t step = is_curved(p, a) ? SL_PATCH_DYADIC / 8 : SL_PATCH_DYADIC / 2;
    for (uint32_t t = 0; t <= SL_PATCH_DYADIC; t += step) {
        sl_vec3 n = front_normal(p, a, sl_edge_along(p, a, t));
        if (!sl_same_normal(n, front_normal(p, b, sl_edge_along(p, b, t)))) return false;
    }
    return true;
}

/* ---- the whole ------------------------------------------------------------------------------- */

sl_status sl_primitives_join(sl_primitives *p, sl_error *error) {
    uint32_t **lists[] = {&p->edge_next, &p->corner_first, &p->corner_next};
    for (size_t i = 0; i < 3; i++) {
        if (!(*lists[i] = sl_allocate_unset(4 * p->count, sizeof(uint32_t))))
            return sl_fail_memory(error, "joining primitives");
    }
    if (!(p->edge_kind = sl_allocate(4 * p->count, 1))) return sl_fail_memory(error, "joining primitives");
    for (uint32_t code = 0; code < 4 * (uint32_t)p->count; code++) {
        if (part_of(code) < sl_primitive_corners(p, primitive_of(code)))
            p->edge_kind[code] = kind_of_edge(p, code);
    }
    static const joint_kind edges = {edge_key, edges_agree}, corners = {corner_key, corners_agree};
    sl_status status = join(p, &edges, NULL, p->edge_next, error);
    if (status == SL_OK) status = join(p, &corners, p->corner_first, p->corner_next, error);
    return status;
}

static sl_root_place on_edge(const sl_primitives *p, uint32_t code, uint32_t t, uint32_t side) {
    uint32_t u, v;
    sl_edge_point(sl_primitive_corners(p, primitive_of(code)), part_of(code), t, &u, &v);
    return (sl_root_place){2 * primitive_of(code) + side, (uint16_t)u, (uint16_t)v};
}

/* Returns the lowest of the edges that are one; two are, as a rule. */
static uint32_t first_edge(const sl_primitives *p, uint32_t code) {
    uint32_t first = code;
    for (uint32_t at = p->edge_next[code]; at != code; at = p->edge_next[at]) first = at < first ? at : first;
    return first;
}

sl_root_place sl_root_canonical(const sl_primitives *p, sl_root_place place) {
    uint32_t primitive = place.root / 2, side = place.root % 2, t;
    int edge = sl_edge_at(sl_primitive_corners(p, primitive), place.u, place.v, &t);
    if (edge < 0) return place;
    uint32_t code = 4 * primitive + (uint32_t)edge;
    if (t == 0 || p->edge_kind[code] & SL_EDGE_POINT) return on_edge(p, p->corner_first[code], 0, side);
    const uint32_t first = first_edge(p, code);
    return on_edge(p, first, sl_edge_along(p, first, sl_edge_along(p, code, t)), side);
}
