/* The trees: where patches lie, how they are cut and uncut, what they show. */
#include "cache/patches/patches.h"

#include <math.h>
#include <string.h>

#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"
#include "cache/patches/patch_parts.h"

/* ---- life ------------------------------------------------------------------------------------ */

sl_status sl_patches_create(const sl_primitives *primitives, const sl_patches_settings *settings,
                            sl_patches **patches, sl_error *error) {
    *patches = NULL;
    sl_patches *p = sl_allocate(1, sizeof *p);
    if (!p) return sl_fail_memory(error, "patches");
    p->primitives = primitives;
    p->settings = *settings;
    if (settings->sets) p->sets = sl_allocate(0, sizeof *p->sets); /* that it is there says it is wanted */
    if ((settings->sets && !p->sets) || sl_vertices_reserve(p, 4, error) != SL_OK ||
        !sl_empty_slots(&p->root_slot, &p->root_slots, 16)) {
        sl_patches_destroy(p);
        return sl_fail_memory(error, "patches");
    }
    sl_patches_clear(p);
    *patches = p;
    return SL_OK;
}

void sl_patches_destroy(sl_patches *p) {
    if (!p) return;
    SL_FREE_ALL(p->root, p->root_slot, p->patch, p->block, p->vertex, p->value, p->sets, p->slot, p);
}

/* Copies `count` elements into a block that had room for `had`, or into another. */
static bool copy_block(void *to, size_t had, const void *from, size_t count, size_t size) {
    void *block;
    memcpy(&block, to, sizeof block);
    if (count > had || !block) {
        void *larger = sl_allocate_unset(count, size);
        if (!larger) return false;
        sl_free(block);
        block = larger;
        memcpy(to, &block, sizeof block);
    }
    if (count) memcpy(block, from, count * size);
    return true;
}

static bool copy_all(const sl_patches *p, sl_patches *c) {
    size_t value = (size_t)p->settings.channels * sizeof *p->value;
    return copy_block(&c->root, c->root_capacity, p->root, p->root_capacity, sizeof *p->root) &&
           copy_block(&c->root_slot, c->root_slots, p->root_slot, p->root_slots, sizeof *p->root_slot) &&
           copy_block(&c->patch, c->patch_capacity, p->patch, p->patch_capacity, sizeof *p->patch) &&
           copy_block(&c->block, c->patch_capacity / 4, p->block, p->patch_capacity / 4, sizeof *p->block) &&
           copy_block(&c->vertex, c->vertex_capacity, p->vertex, p->vertex_capacity, sizeof *p->vertex) &&
           copy_block(&c->value, c->vertex_capacity, p->value, p->vertex_capacity, value) &&
           copy_block(&c->slot, c->slots, p->slot, p->slots, sizeof *p->slot) &&
           (!p->sets ||
            copy_block(&c->sets, c->vertex_capacity, p->sets, p->vertex_capacity, sizeof *p->sets));
}

sl_status sl_patches_copy(const sl_patches *p, sl_patches **copy, sl_error *error) {
    sl_patches *c = *copy ? *copy : sl_allocate(1, sizeof *c);
    if (!c) return sl_fail_memory(error, "a copy of patches");
    *copy = c;
    if (!copy_all(p, c)) return sl_fail_memory(error, "a copy of patches");
    sl_patches all = *p;
    all.root = c->root;
    all.root_slot = c->root_slot;
    all.patch = c->patch;
    all.block = c->block;
    all.vertex = c->vertex;
    all.value = c->value;
    all.slot = c->slot;
    all.sets = c->sets;
    *c = all;
    return SL_OK;
}

void sl_patches_clear(sl_patches *p) {
    memset(p->root_slot, 0xff, p->root_slots * sizeof *p->root_slot); /* SL_NO_INDEX */
    memset(p->slot, 0xff, p->slots * sizeof *p->slot);
    p->root_count = p->patch_count = p->patches_alive = p->leaves_alive = 0;
    p->vertex_count = p->vertices_alive = 0;
    p->first_free = p->last_root_block = p->first_free_vertex = SL_NO_INDEX;
    p->extrapolates = false;
}

size_t sl_patches_memory_bytes(const sl_patches *p) {
    size_t of_vertex = sizeof *p->vertex + (size_t)p->settings.channels * sizeof *p->value +
                       (p->sets ? sizeof *p->sets : 0);
    return sizeof *p + p->patch_capacity * sizeof *p->patch + p->patch_capacity / 4 * sizeof *p->block +
           p->root_capacity * sizeof *p->root + p->vertex_capacity * of_vertex +
           (p->slots + p->root_slots) * sizeof *p->slot;
}

/* ---- blocks of four patches ------------------------------------------------------------------ */

static bool reserve_block(sl_patches *p) {
    size_t used = p->patch_count;
    if (p->first_free != SL_NO_INDEX) return true;
    if (used + 4 <= p->patch_capacity) return true;
    size_t capacity = sl_patches_room(p->patch_capacity, used + 4) / 4 * 4;
    if (capacity >= SL_NO_INDEX || !sl_regrow(&p->patch, used, capacity, sizeof *p->patch) ||
        !sl_regrow(&p->block, used / 4, capacity / 4, sizeof *p->block))
        return false;
    p->patch_capacity = capacity;
    return true;
}

/* There is one: it has been reserved. */
static uint32_t take_block(sl_patches *p, uint32_t parent, uint32_t root) {
    uint32_t first = p->first_free;
    if (first != SL_NO_INDEX) {
        p->first_free = p->patch[first].child;
    } else {
        first = (uint32_t)p->patch_count;
        p->patch_count += 4;
    }
    *sl_patch_block_of(p, first) =
        (sl_patch_block){parent, root, {SL_NO_INDEX, SL_NO_INDEX, SL_NO_INDEX, SL_NO_INDEX, SL_NO_INDEX}};
    for (uint32_t k = 0; k < 4; k++) p->patch[first + k] = (sl_patch){.child = SL_NO_INDEX};
    return first;
}

static void give_block_back(sl_patches *p, uint32_t first) {
    for (uint32_t k = 0; k < 4; k++) p->patch[first + k].flags = 0;
    p->patch[first].child = p->first_free;
    p->first_free = first;
}

/* ---- places ---------------------------------------------------------------------------------- */

static bool root_is_triangle(const sl_patches *p, uint32_t root) {
    return p->primitives->kind[root / 2] == SL_PRIMITIVE_TRIANGLE;
}

/* patch: the root's, or none. */
static sl_patch_place root_place(const sl_patches *p, uint32_t root, uint32_t patch) {
    const uint16_t one = SL_PATCH_DYADIC;
    if (root_is_triangle(p, root)) return (sl_patch_place){patch, root, 0, 3, {0, one, 0, 0}, {0, 0, one, 0}};
    return (sl_patch_place){patch, root, 0, 4, {0, one, one, 0}, {0, 0, one, one}};
}

sl_patch_place sl_patch_root_place(const sl_patches *p, uint32_t root) {
    return root_place(p, root, sl_patches_find_root(p, root));
}

/* Each corner of a child is the middle of two corners of its parent, or one of them (then both are the same).
 */
static const uint8_t triangle_child[4][3][2] = {
    {{0, 0}, {0, 1}, {2, 0}}, {{0, 1}, {1, 1}, {1, 2}}, {{2, 0}, {1, 2}, {2, 2}}, {{1, 2}, {2, 0}, {0, 1}}};
static const uint8_t quad_child[4][4][2] = {{{0, 0}, {0, 1}, {0, 2}, {3, 0}},
                                            {{0, 1}, {1, 1}, {1, 2}, {0, 2}},
                                            {{0, 2}, {1, 2}, {2, 2}, {2, 3}},
                                            {{3, 0}, {0, 2}, {2, 3}, {3, 3}}};

sl_patch_place sl_patch_child_place(const sl_patches *p, const sl_patch_place *parent, int child) {
    uint32_t first = p->patch[parent->patch].child;
    sl_patch_place place = {first == SL_NO_INDEX ? first : first + (uint32_t)child,
                            parent->root,
                            parent->depth + 1,
                            parent->corners,
                            {0},
                            {0}};
    for (int c = 0; c < parent->corners; c++) {
        const uint8_t *of = parent->corners == 3 ? triangle_child[child][c] : quad_child[child][c];
        place.u[c] = (uint16_t)((parent->u[of[0]] + parent->u[of[1]]) / 2);
        place.v[c] = (uint16_t)((parent->v[of[0]] + parent->v[of[1]]) / 2);
    }
    return place;
}

sl_patch_place sl_patch_place_of(const sl_patches *p, uint32_t patch) {
    int way[SL_PATCH_DEPTH_MAX], depth = 0;
    uint32_t at = patch;
    for (; sl_patch_parent(p, at) != SL_NO_INDEX; at = sl_patch_parent(p, at)) way[depth++] = (int)(at % 4);
    sl_patch_place place = root_place(p, sl_patch_root(p, at), at);
    while (depth > 0) place = sl_patch_child_place(p, &place, way[--depth]);
    return place;
}

static double scaled(double t) { return SL_PATCH_DYADIC * sl_clamp_unit(t); }

/* Goes from a place in a triangle to that in one of its children, which is returned. */
static uint32_t go_down_triangle(double *a, double *b) {
    const uint32_t child = *a >= 0.5 ? 1 : *b >= 0.5 ? 2 : *a + *b <= 0.5 ? 0 : 3;
    if (child == 3) {
        *a = 1.0 - 2.0 * *a;
        *b = 1.0 - 2.0 * *b;
        return child;
    }
    *a = 2.0 * *a - (child == 1 ? 1.0 : 0.0);
    *b = 2.0 * *b - (child == 2 ? 1.0 : 0.0);
    return child;
}

static uint32_t go_down_quad(double *a, double *b) {
    const bool right = *a >= 0.5, up = *b >= 0.5;
    *a = 2.0 * *a - (right ? 1.0 : 0.0);
    *b = 2.0 * *b - (up ? 1.0 : 0.0);
    return up ? (right ? 2 : 3) : (right ? 1 : 0);
}

static uint32_t go_down(int corners, double *a, double *b) {
    return corners == 3 ? go_down_triangle(a, b) : go_down_quad(a, b);
}

int sl_patch_child_at(const sl_patch_place *place, double u, double v) {
    double a, b;
    sl_patch_local(place, scaled(u), scaled(v), &a, &b);
    return (int)go_down(place->corners, &a, &b);
}

uint32_t sl_patch_leaf_at(const sl_patches *p, uint32_t patch, int corners, double a, double b) {
    while (patch != SL_NO_INDEX && !sl_patch_is_leaf(p, patch))
        patch = p->patch[patch].child + go_down(corners, &a, &b);
    return patch;
}

sl_patch_place sl_patch_locate(const sl_patches *p, uint32_t root, double u, double v) {
    const sl_patch_place whole = sl_patch_root_place(p, root);
    const uint32_t leaf =
        sl_patch_leaf_at(p, whole.patch, whole.corners, sl_clamp_unit(u), sl_clamp_unit(v));
    return leaf == whole.patch ? whole : sl_patch_place_of(p, leaf);
}

/* ---- roots ----------------------------------------------------------------------------------- */

/* Returns where a root is in the table, or would be. */
static size_t root_slot(const sl_patches *p, uint32_t root) {
    size_t i = sl_slot_of_hash(sl_hash64(root), p->root_slots);
    while (p->root_slot[i] != SL_NO_INDEX && p->root[p->root_slot[i]].root != root)
        i = sl_slot_after(i, p->root_slots);
    return i;
}

uint32_t sl_patches_find_root(const sl_patches *p, uint32_t root) {
    uint32_t found = p->root_slot[root_slot(p, root)];
    return found == SL_NO_INDEX ? found : p->root[found].patch;
}

static bool reserve_root(sl_patches *p) {
    if (p->root_count == p->root_capacity) {
        size_t capacity = sl_grown_capacity(p->root_capacity, p->root_count + 16);
        if (!sl_regrow(&p->root, p->root_count, capacity, sizeof *p->root)) return false;
        p->root_capacity = capacity;
    }
    if (2 * (p->root_count + 1) <= p->root_slots) return true;
    if (!sl_empty_slots(&p->root_slot, &p->root_slots, 2 * p->root_slots)) return false;
    for (uint32_t i = 0; i < p->root_count; i++) p->root_slot[root_slot(p, p->root[i].root)] = i;
    return true;
}

uint32_t sl_patches_root(sl_patches *p, uint32_t root, sl_status *status, sl_error *error) {
    *status = SL_OK;
    uint32_t found = sl_patches_find_root(p, root);
    if (found != SL_NO_INDEX) return found;
    bool block = p->root_count % 4 == 0;
    *status = sl_vertices_reserve(p, 4, error);
    if (*status == SL_OK && !(reserve_root(p) && (!block || reserve_block(p))))
        *status = sl_fail_memory(error, "patches");
    if (*status != SL_OK) return SL_NO_INDEX;
    if (block) p->last_root_block = take_block(p, SL_NO_INDEX, (uint32_t)p->root_count);
    sl_wanted_root *made = &p->root[p->root_count];
    uint32_t patch = p->last_root_block + (uint32_t)(p->root_count % 4);
    sl_patch_place place = root_place(p, root, patch);
    *made = (sl_wanted_root){root, patch, {SL_NO_INDEX, SL_NO_INDEX, SL_NO_INDEX, SL_NO_INDEX}};
    for (int c = 0; c < place.corners; c++)
        made->corner[c] = sl_vertex_take(p, (sl_root_place){root, place.u[c], place.v[c]});
    p->patch[patch].flags = SL_PATCH_ALIVE | (place.corners == 3 ? SL_PATCH_TRIANGLE : 0u);
    p->root_slot[root_slot(p, root)] = (uint32_t)p->root_count++;
    p->patches_alive++;
    p->leaves_alive++;
    return patch;
}

/* ---- splits ---------------------------------------------------------------------------------- */

/* Returns twice the area as a vector, of a triangle or a quadrilateral. */
static sl_vec3d area_vector(const sl_vec3d corner[4], int corners) {
    if (corners == 3) return sl_crossd(sl_subd(corner[1], corner[0]), sl_subd(corner[2], corner[0]));
    return sl_crossd(sl_subd(corner[2], corner[0]), sl_subd(corner[3], corner[1]));
}

static void corner_positions(const sl_patches *p, const sl_patch_place *place, sl_vec3d corner[4]) {
    for (int c = 0; c < place->corners; c++)
        corner[c] = sl_to_double(sl_root_position(p->primitives, place->root, place->u[c], place->v[c]));
}

/* A quarter of a plane patch has a quarter of its area, unless floats no longer tell its corners apart: where
 * less than half of that is left. A part of a curved one need only have some. Slivers need nothing else: as
 * all children have the shape of their parent, cutting them in four never makes them worse, and whether a
 * split is worth while is for their projected size to say. */
static bool is_degenerate(const sl_patches *p, const sl_patch_place *child, sl_vec3d parent_area) {
    sl_vec3d corner[4];
    corner_positions(p, child, corner);
    if (p->primitives->kind[child->root / 2] != SL_PRIMITIVE_BICUBIC)
        return !(sl_dotd(area_vector(corner, child->corners), parent_area) >
                 0.125 * sl_dotd(parent_area, parent_area));
    sl_vec3d first = area_vector(corner, 3),
             second = area_vector((sl_vec3d[4]){corner[0], corner[2], corner[3]}, 3);
    double sum = sl_lengthd(first) + sl_lengthd(second);
    return !(sum > 0.0 && isfinite(sum));
}

static bool can_be_split(const sl_patches *p, const sl_patch_place *place) {
    uint32_t triangle = p->primitives->first_triangle[place->root / 2];
    if (place->depth >= p->settings.max_depth) return false;
    if (place->corners == 3 && sl_triangle_is_degenerate(p->primitives->scene, triangle)) return false;
    sl_vec3d corner[4];
    corner_positions(p, place, corner);
    sl_vec3d area = area_vector(corner, place->corners);
    for (int c = 0; c < 4; c++) {
        sl_patch_place child = sl_patch_child_place(p, place, c);
        if (is_degenerate(p, &child, area)) return false;
    }
    return true;
}

enum { MIDDLES = 5 };

static void mark_halved(sl_patches *p, uint32_t patch, int edge, int corners) {
    p->vertex[sl_patch_corner(p, patch, edge)].halved = 1;
    p->vertex[sl_patch_corner(p, patch, (edge + 1) % corners)].halved = 1;
}

static void take_middles(sl_patches *p, const sl_patch_place *parent, uint32_t first) {
    for (int m = 0; m < (parent->corners == 3 ? 3 : MIDDLES); m++) {
        sl_root_place at;
        sl_middle_place(parent, m == 4 ? 0 : m, m == 4 ? 2 : (m + 1) % parent->corners, &at);
        sl_patch_block_of(p, first)->middle[m] = sl_vertex_take(p, at);
        if (m < 4) mark_halved(p, parent->patch, m, parent->corners);
    }
}

uint32_t sl_patch_edge_middle(sl_patches *p, const sl_patch_place *place, int edge, sl_status *status,
                              sl_error *error) {
    sl_root_place middle;
    bool even = sl_middle_place(place, edge, (edge + 1) % place->corners, &middle);
    *status = SL_OK;
    if (place->depth >= p->settings.max_depth || !even) return SL_NO_INDEX;
    uint32_t vertex = sl_vertex_make(p, middle, status, error);
    if (vertex != SL_NO_INDEX) mark_halved(p, place->patch, edge, place->corners);
    return vertex;
}

sl_status sl_patch_split(sl_patches *p, const sl_patch_place *place, sl_error *error) {
    uint32_t patch = place->patch;
    if (!sl_patch_is_leaf(p, patch) || !can_be_split(p, place)) return SL_OK;
    sl_status status = sl_vertices_reserve(p, MIDDLES, error);
    if (status == SL_OK && !reserve_block(p)) status = sl_fail_memory(error, "patches");
    if (status != SL_OK) return status;
    uint32_t first = take_block(p, patch, place->root);
    sl_patch *parent = &p->patch[patch];
    for (uint32_t k = 0; k < 4; k++) {
        sl_patch *child = &p->patch[first + k];
        child->flags = SL_PATCH_ALIVE | (parent->flags & SL_PATCH_TRIANGLE);
        if (!p->settings.shown) continue;
        child->seen = parent->seen;
        child->pixels = parent->pixels / 4 + (parent->pixels % 4 != 0);
    }
    take_middles(p, place, first);
    parent->child = first;
    p->patches_alive += 4;
    p->leaves_alive += 3;
    return SL_OK;
}

static void gather_pixels(sl_patches *p, uint32_t patch) {
    sl_patch *parent = &p->patch[patch];
    uint32_t latest, pixels = sl_pixels_of_children(p, parent->child, &latest);
    if (latest < parent->seen) return;
    parent->seen = latest;
    parent->pixels = pixels;
}

void sl_patch_drop_children(sl_patches *p, uint32_t patch) {
    uint32_t first = p->patch[patch].child;
    if (first == SL_NO_INDEX) return;
    for (uint32_t k = 0; k < 4; k++) sl_patch_drop_children(p, first + k);
    if (p->settings.shown) gather_pixels(p, patch);
    p->patch[patch].child = SL_NO_INDEX;
    for (int m = 0; m < MIDDLES; m++) {
        uint32_t vertex = sl_patch_block_of(p, first)->middle[m];
        if (vertex != SL_NO_INDEX) sl_vertex_release(p, vertex);
    }
    give_block_back(p, first);
    p->patches_alive -= 4;
    p->leaves_alive -= 3;
}

/* ---- values ---------------------------------------------------------------------------------- */

static bool all_evaluated(const sl_patches *p, uint32_t patch) {
    for (int c = 0; c < sl_patch_corners(p, patch); c++) {
        if (p->vertex[sl_patch_corner(p, patch, c)].evaluated == SL_VERTEX_NEVER) return false;
    }
    return true;
}

static bool find_shares(const sl_patches *p, const sl_patch_place *leaf, double u, double v,
                        sl_vertex_shares *shares) {
    sl_patch_place place = *leaf;
    if (place.patch == SL_NO_INDEX) return false;
    while (!all_evaluated(p, place.patch)) {
        uint32_t parent = sl_patch_parent(p, place.patch);
        if (parent == SL_NO_INDEX) return false;
        place = sl_patch_place_of(p, parent);
    }
    uint32_t corner[4];
    double a, b;
    for (int c = 0; c < place.corners; c++) corner[c] = sl_patch_corner(p, place.patch, c);
    sl_patch_local(&place, scaled(u), scaled(v), &a, &b);
    *shares = sl_leaf_shares(place.corners, corner, 0, NULL, a, b);
    return true;
}

static void add_shares(const sl_patches *p, const sl_vertex_shares *shares, float *value) {
    double sum[6] = {0, 0, 0, 0, 0, 0};
    for (size_t k = 0; k < shares->count; k++) {
        const float *of = sl_vertex_value(p, shares->vertex[k]);
        for (int i = 0; i < p->settings.channels; i++) sum[i] += shares->weight[k] * (double)of[i];
    }
    for (int i = 0; i < p->settings.channels; i++) value[i] = (float)sum[i];
}

bool sl_patch_value(const sl_patches *p, const sl_patch_place *leaf, double u, double v, float *value) {
    sl_vertex_shares shares;
    if (!find_shares(p, leaf, u, v, &shares)) return false;
    add_shares(p, &shares, value);
    return true;
}

bool sl_vertex_shares_around(const sl_patches *p, uint32_t vertex, sl_vertex_shares *shares) {
    const sl_patch_vertex *v = &p->vertex[vertex];
    double a = (double)v->u / SL_PATCH_DYADIC, b = (double)v->v / SL_PATCH_DYADIC;
    sl_patch_place leaf = sl_patch_locate(p, v->root, a, b);
    return find_shares(p, &leaf, a, b, shares);
}

bool sl_vertex_surroundings(const sl_patches *p, uint32_t vertex, float *value) {
    sl_vertex_shares shares;
    if (!sl_vertex_shares_around(p, vertex, &shares)) return false;
    add_shares(p, &shares, value);
    return true;
}
