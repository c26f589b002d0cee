/* The trees: where patches lie, how they are cut and uncut, what they show. */
#include "cache/patches/patches.h"

#include <math.h>
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "cache/patches/dyadic.h"
#include "cache/patches/patch_parts.h"

/* ---- life ------------------------------------------------------------------------------------ */

sl_status sl_patches_create(const sl_primitives *primitives, unsigned kept, sl_patches **patches,
                            sl_error *error) {
    *patches = NULL;
    sl_patches *p = sl_allocate(1, sizeof *p);
    if (!p) return sl_fail_memory(error, "patches");
    size_t roots = 2 * primitives->count;
    p->primitives = primitives;
    p->table.stride = sizeof *p->vertex;
    p->first_free = p->resting[0] = p->resting[1] = p->last_root_block = p->first_free_vertex[0] =
        p->first_free_vertex[1] = SL_NO_INDEX;
    p->lobes = kept & SL_PATCHES_LOBES;
    p->root_patch = sl_allocate_unset(roots, sizeof *p->root_patch);
    p->wanted_root = sl_allocate(roots, sizeof *p->wanted_root);
    bool sets = kept & SL_PATCHES_SETS;
    if (sets) p->sets = sl_allocate(0, sizeof *p->sets); /* that it is there says that it is wanted */
    sl_status status = sl_vertices_reserve(p, 0, 4, error);
    if (!p->root_patch || !p->wanted_root || (sets && !p->sets) || status != SL_OK) {
        sl_patches_destroy(p);
        return sl_fail_memory(error, "patches");
    }
    memset(p->root_patch, 0xff, roots * sizeof *p->root_patch); /* SL_NO_INDEX */
    *patches = p;
    return SL_OK;
}

void sl_patches_destroy(sl_patches *p) {
    if (!p) return;
    for (size_t i = 0; i < p->block_chunks; i++) sl_free(p->block_chunk[i]);
    void *all[] = {p->root_patch, p->wanted_root, p->root_corner, p->patch, p->flags, p->block_chunk,
                   p->vertex,     p->sets,        p->lobe_group,  p->lobe,  p->table.slot, p->waiting};
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) sl_free(all[i]);
    sl_free(p);
}

size_t sl_patches_memory_bytes(const sl_patches *p) {
    size_t of_chunk = SL_BLOCKS_A_CHUNK * sizeof **p->block_chunk + sizeof *p->block_chunk;
    size_t of_vertex = sizeof *p->vertex + (p->sets ? sizeof *p->sets : 0),
           groups = p->lobes ? p->vertex_capacity / SL_VERTEX_GROUP : 0;
    return p->patch_capacity * (sizeof *p->patch + 1) + p->block_chunks * of_chunk +
           p->wanted_capacity * sizeof *p->root_corner + p->vertex_capacity * of_vertex +
           groups * sizeof *p->lobe_group + p->lobe_capacity * sizeof *p->lobe +
           p->table.count * sizeof *p->table.slot + p->waiting_capacity * sizeof *p->waiting;
}

/* ---- blocks of four patches ------------------------------------------------------------------ */

sl_status sl_patches_enlarge(sl_growing *all, int count, sl_error *error) {
    bool failed = false;
    for (int i = 0; i < count; i++) failed |= !(all[i].larger = sl_allocate_unset(all[i].room, 1));
    for (int i = 0; i < count; i++) {
        void *unwanted = failed ? all[i].larger : *all[i].array;
        if (!failed && all[i].used) memcpy(all[i].larger, *all[i].array, all[i].used);
        if (!failed) *all[i].array = all[i].larger;
        sl_free(unwanted);
    }
    return failed ? sl_fail_memory(error, "patches") : SL_OK;
}

static sl_status reserve_chunk(sl_patches *p, sl_error *error) {
    if (p->patch_count < 4 * SL_BLOCKS_A_CHUNK * p->block_chunks) return SL_OK;
    if (p->block_chunks == p->block_chunks_room) {
        size_t room = sl_patches_room(p->block_chunks, 0), size = sizeof *p->block_chunk;
        sl_growing all[] = {{(void **)&p->block_chunk, p->block_chunks * size, room * size, NULL}};
        sl_status status = sl_patches_enlarge(all, 1, error);
        if (status != SL_OK) return status;
        p->block_chunks_room = room;
    }
    sl_patch_block *chunk = sl_allocate_unset(SL_BLOCKS_A_CHUNK, sizeof *chunk);
    if (!chunk) return sl_fail_memory(error, "patches");
    p->block_chunk[p->block_chunks++] = chunk;
    return SL_OK;
}

static sl_status reserve_block(sl_patches *p, sl_error *error) {
    size_t used = p->patch_count;
    if (p->first_free != SL_NO_INDEX) return SL_OK;
    sl_status status = reserve_chunk(p, error);
    if (status != SL_OK || used + 4 <= p->patch_capacity) return status;
    size_t capacity = sl_patches_room(p->patch_capacity, used + 4) / 4 * 4;
    if (capacity >= SL_NO_INDEX) return sl_fail(error, SL_ERROR_RESOURCES, "too many patches");
    sl_growing all[] = {{(void **)&p->patch, used * sizeof *p->patch, capacity * sizeof *p->patch, NULL},
                     {(void **)&p->flags, used, capacity, NULL}};
    status = sl_patches_enlarge(all, 2, error);
    if (status == SL_OK) p->patch_capacity = capacity;
    return status;
}

static sl_status reserve_root(sl_patches *p, sl_error *error) {
    if (p->wanted_count < p->wanted_capacity) return SL_OK;
    size_t capacity = sl_patches_room(p->wanted_capacity, p->wanted_count + 1), size = sizeof *p->root_corner;
    sl_growing all[] = {{(void **)&p->root_corner, p->wanted_count * size, capacity * size, NULL}};
    sl_status status = sl_patches_enlarge(all, 1, error);
    if (status == SL_OK) p->wanted_capacity = capacity;
    return status;
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
    for (uint32_t k = 0; k < 4; k++) {
        p->patch[first + k] = (sl_patch){.child = SL_NO_INDEX};
        p->flags[first + k] = 0;
    }
    return first;
}

/* Its patches are still to be taken out of the display. */
static void give_block_back(sl_patches *p, uint32_t first) {
    for (uint32_t k = 0; k < 4; k++) p->flags[first + k] = SL_PATCH_DIRTY;
    p->patch[first].child = p->resting[0];
    p->resting[0] = first;
}

/* The copy that was just built knows nothing of what was given back before, and is the one that is drawn. A
 * frame may still be under way from the other one, but not when that is built the next time. */
void sl_patches_rested(sl_patches *p) {
    uint32_t *last = &p->resting[1];
    while (*last != SL_NO_INDEX) last = &p->patch[*last].child;
    *last = p->first_free;
    p->first_free = p->resting[1];
    p->resting[1] = p->resting[0];
    p->resting[0] = SL_NO_INDEX;
}

/* ---- places ---------------------------------------------------------------------------------- */

static bool root_is_triangle(const sl_patches *p, uint32_t root) {
    return p->primitives->kind[root / 2] == SL_PRIMITIVE_TRIANGLE;
}

static sl_patch_place root_place(const sl_patches *p, uint32_t root) {
    const uint16_t one = SL_PATCH_DYADIC;
    if (root_is_triangle(p, root))
        return (sl_patch_place){p->root_patch[root], root, 0, 3, {0, one, 0, 0}, {0, 0, one, 0}};
    return (sl_patch_place){p->root_patch[root], root, 0, 4, {0, one, one, 0}, {0, 0, one, one}};
}

sl_patch_place sl_patch_child_place(const sl_patches *p, const sl_patch_place *parent, int child) {
    uint32_t first = p->patch[parent->patch].child;
    sl_patch_place place = {first == SL_NO_INDEX ? first : first + (uint32_t)child,
                            parent->root,
                            parent->depth + 1,
                            parent->corners,
                            {0},
                            {0}};
    sl_dyadic_child(parent->corners, parent->u, parent->v, child, place.u, place.v);
    return place;
}

sl_patch_place sl_patch_place_of(const sl_patches *p, uint32_t patch) {
    int way[SL_PATCH_DEPTH_MAX], depth = 0;
    for (uint32_t at = patch; sl_patch_parent(p, at) != SL_NO_INDEX; at = sl_patch_parent(p, at))
        way[depth++] = (int)(at % 4);
    sl_patch_place place = root_place(p, sl_patch_root(p, patch));
    while (depth > 0) place = sl_patch_child_place(p, &place, way[--depth]);
    return place;
}

static double scaled(double t) { return t > 0.0 ? (t < 1.0 ? t * SL_PATCH_DYADIC : SL_PATCH_DYADIC) : 0.0; }

static int child_at(const sl_patch_place *place, double u, double v) {
    double a, b;
    sl_dyadic_local(place->corners, place->u, place->v, u, v, &a, &b);
    return sl_dyadic_child_at(place->corners, a, b);
}

int sl_patch_child_at(const sl_patch_place *place, double u, double v) {
    return child_at(place, scaled(u), scaled(v));
}

sl_patch_place sl_patch_locate(const sl_patches *p, uint32_t root, double u, double v) {
    sl_patch_place place = root_place(p, root);
    u = scaled(u);
    v = scaled(v);
    while (place.patch != SL_NO_INDEX && !sl_patch_is_leaf(p, place.patch)) {
        place = sl_patch_child_place(p, &place, child_at(&place, u, v));
    }
    return place;
}

/* ---- roots ----------------------------------------------------------------------------------- */

uint32_t sl_patches_root(sl_patches *p, uint32_t root, sl_status *status, sl_error *error) {
    *status = SL_OK;
    if (p->root_patch[root] != SL_NO_INDEX) return p->root_patch[root];
    bool block = p->wanted_count % 4 == 0;
    *status = sl_vertices_reserve(p, root, 4, error);
    if (*status == SL_OK) *status = reserve_root(p, error);
    if (*status == SL_OK && block) *status = reserve_block(p, error);
    if (*status != SL_OK) return SL_NO_INDEX;
    if (block) p->last_root_block = take_block(p, SL_NO_INDEX, (uint32_t)p->wanted_count);
    uint32_t patch = p->last_root_block + (uint32_t)(p->wanted_count % 4),
             *corner = p->root_corner[p->wanted_count];
    p->wanted_root[p->wanted_count++] = root;
    p->root_patch[root] = patch;
    p->flags[patch] =
        (uint8_t)(SL_PATCH_ALIVE | SL_PATCH_DIRTY | (root_is_triangle(p, root) ? SL_PATCH_TRIANGLE : 0));
    sl_patch_place place = root_place(p, root);
    bool created;
    for (int c = 0; c < 4; c++) {
        corner[c] = c < place.corners
                        ? sl_vertex_take(p, (sl_root_place){root, place.u[c], place.v[c]}, &created)
                        : SL_NO_INDEX;
    }
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
    for (int c = 0; c < place->corners; c++) {
        corner[c] = sl_to_double(sl_root_position(p->primitives, place->root, place->u[c], place->v[c]));
    }
}

/* A quarter of a plane patch has a quarter of its area, unless floats no longer tell its corners apart: where
 * less than half of that is left. A part of a curved one need only have some. Slivers need nothing else: as
 * all children have the shape of their parent, cutting them in four never makes them worse, and whether a
 * split is worth while is for their projected size to say. */
static bool is_degenerate(const sl_patches *p, const sl_patch_place *child, sl_vec3d parent_area) {
    sl_vec3d corner[4];
    corner_positions(p, child, corner);
    if (p->primitives->kind[child->root / 2] != SL_PRIMITIVE_BICUBIC) {
        return !(sl_dotd(area_vector(corner, child->corners), parent_area) >
                 0.125 * sl_dotd(parent_area, parent_area));
    }
    sl_vec3d first = area_vector(corner, 3),
             second = area_vector((sl_vec3d[4]){corner[0], corner[2], corner[3]}, 3);
    double sum = sl_lengthd(first) + sl_lengthd(second);
    return !(sum > 0.0 && isfinite(sum));
}

static bool can_be_split(const sl_patches *p, const sl_patch_place *place) {
    if (place->depth >= SL_PATCH_DEPTH_MAX) return false;
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
static int middles_of(const sl_patch_place *parent) { return parent->corners == 3 ? 3 : MIDDLES; }

/* Leaves that a new vertex lies on the edge of have to know of it. */
static void take_middles(sl_patches *p, const sl_patch_place *parent, uint32_t first) {
    for (int m = 0; m < middles_of(parent); m++) {
        int a = m == 4 ? 0 : m, b = m == 4 ? 2 : (m + 1) % parent->corners;
        sl_root_place at = {parent->root, sl_dyadic_middle(parent->u[a], parent->u[b]),
                            sl_dyadic_middle(parent->v[a], parent->v[b])};
        bool created = false;
        sl_patch_block_of(p, first)->middle[m] = sl_vertex_take(p, at, &created);
        if (created) sl_patches_touch_place(p, at);
    }
}

sl_status sl_patch_split(sl_patches *p, uint32_t patch, sl_error *error) {
    sl_patch_place place = sl_patch_place_of(p, patch);
    if (!sl_patch_is_leaf(p, patch) || !can_be_split(p, &place)) return SL_OK;
    sl_status status = sl_vertices_reserve(p, place.root, MIDDLES, error);
    if (status == SL_OK) status = reserve_block(p, error);
    if (status != SL_OK) return status;
    uint32_t first = take_block(p, patch, place.root);
    sl_patch *parent = &p->patch[patch];
    uint8_t flags = p->flags[patch] & (SL_PATCH_TRIANGLE | SL_PATCH_CHANGING);
    for (uint32_t k = 0; k < 4; k++) {
        p->flags[first + k] = (uint8_t)(flags | SL_PATCH_ALIVE | SL_PATCH_DIRTY | (place.depth + 1));
        p->patch[first + k].seen = parent->seen;
        p->patch[first + k].pixels = parent->pixels / 4 + (parent->pixels % 4 != 0);
    }
    take_middles(p, &place, first);
    parent->child = first;
    p->flags[patch] |= SL_PATCH_DIRTY;
    p->patches_alive += 4;
    p->leaves_alive += 3;
    return SL_OK;
}

static void gather_pixels(sl_patches *p, uint32_t patch) {
    sl_patch *parent = &p->patch[patch];
    uint32_t latest = 0, pixels = 0;
    for (uint32_t k = 0; k < 4; k++) {
        const sl_patch *child = &p->patch[parent->child + k];
        if (child->seen > latest) latest = child->seen, pixels = 0;
        if (child->seen == latest) pixels += child->pixels;
    }
    if (latest < parent->seen) return;
    parent->seen = latest;
    parent->pixels = pixels;
}

void sl_patch_drop_children(sl_patches *p, uint32_t patch) {
    uint32_t first = p->patch[patch].child;
    if (first == SL_NO_INDEX) return;
    for (uint32_t k = 0; k < 4; k++) sl_patch_drop_children(p, first + k);
    gather_pixels(p, patch);
    p->patch[patch].child = SL_NO_INDEX;
    for (int m = 0; m < MIDDLES; m++) {
        uint32_t vertex = sl_patch_block_of(p, first)->middle[m];
        if (vertex == SL_NO_INDEX) continue;
        sl_root_place place = sl_vertex_place(&p->vertex[vertex]);
        if (sl_vertex_release(p, vertex)) sl_patches_touch_place(p, place);
    }
    give_block_back(p, first);
    p->flags[patch] |= SL_PATCH_DIRTY;
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

static double between_0_and_1(double t) { return t > 0.0 ? (t < 1.0 ? t : 1.0) : 0.0; }

static void corner_weights(const sl_patch_place *place, double u, double v, double weight[4]) {
    double a, b;
    sl_dyadic_local(place->corners, place->u, place->v, u, v, &a, &b);
    a = between_0_and_1(a);
    b = between_0_and_1(b);
    if (place->corners == 3) {
        double sum = a + b > 1.0 ? a + b : 1.0;
        weight[1] = a / sum;
        weight[2] = b / sum;
        weight[0] = between_0_and_1(1.0 - weight[1] - weight[2]);
        weight[3] = 0.0;
    } else {
        weight[0] = (1.0 - a) * (1.0 - b);
        weight[1] = a * (1.0 - b);
        weight[2] = a * b;
        weight[3] = (1.0 - a) * b;
    }
}

bool sl_patch_value(const sl_patches *p, const sl_patch_place *leaf, double u, double v, bool second,
                    float value[3]) {
    sl_patch_place place = *leaf;
    if (place.patch == SL_NO_INDEX) return false;
    while (!all_evaluated(p, place.patch)) {
        uint32_t parent = sl_patch_parent(p, place.patch);
        if (parent == SL_NO_INDEX) return false;
        place = sl_patch_place_of(p, parent);
    }
    double weight[4];
    corner_weights(&place, scaled(u), scaled(v), weight);
    double sum[3] = {0, 0, 0};
    for (int c = 0; c < place.corners; c++) {
        uint32_t vertex = sl_patch_corner(p, place.patch, c);
        const float *of = second ? sl_vertex_lobe(p, vertex) : p->vertex[vertex].value;
        for (int i = 0; of && i < 3; i++) sum[i] += weight[c] * (double)of[i];
    }
    for (int i = 0; i < 3; i++) value[i] = (float)sum[i];
    return true;
}
