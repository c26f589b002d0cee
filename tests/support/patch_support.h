/* Shared by the tests of patches: scenes with their primitives and patches, whole levels of splits, and
 * everything that must hold of any hierarchy. */
#pragma once

#include <stdlib.h>
#include <string.h>

#include "unit_test.h"
#include "cache/patches/patches.h"
#include "trace_scenes.h"

typedef struct hierarchy {
    sl_scene *scene; /* its own */
    sl_primitives *primitives;
    sl_patches *patches;
} hierarchy;

enum { KEEP_LOBES = 1, KEEP_SETS = 2 };

/* Takes the scene. */
static inline hierarchy hierarchy_of(sl_scene *scene, unsigned kept) {
    hierarchy h = {.scene = scene};
    sl_error error = {0};
    const sl_patches_settings settings = {.channels = kept & KEEP_LOBES ? 6 : 3,
                                          .max_depth = SL_PATCH_DEPTH_MAX,
                                          .shown = true,
                                          .sets = kept & KEEP_SETS};
    if (sl_primitives_find(scene, &h.primitives, &error) != SL_OK) fail_msg("%s", error.message);
    if (sl_patches_create(h.primitives, &settings, &h.patches, &error) != SL_OK)
        fail_msg("%s", error.message);
    return h;
}

static inline void hierarchy_discard(hierarchy *h) {
    sl_patches_destroy(h->patches);
    sl_primitives_destroy(h->primitives);
    sl_scene_destroy(h->scene);
}

static inline uint32_t want_root(hierarchy *h, uint32_t root) {
    sl_status status;
    uint32_t patch = sl_patches_root(h->patches, root, &status, NULL);
    assert_int_equal(status, SL_OK);
    return patch;
}

/* Marks the leaves around a place, and no others. */
enum { MARKED = 0x4000 };
static inline void mark_leaf(sl_patches *p, const sl_patch_place *leaf, void *context) {
    (void)context;
    p->patch[leaf->patch].flags |= MARKED;
}
static inline void mark_around(sl_patches *p, sl_root_place place) {
    for (size_t i = 0; i < p->patch_count; i++) p->patch[i].flags &= ~(uint32_t)MARKED;
    sl_patches_visit_around(p, place, mark_leaf, NULL);
}

static inline void split(hierarchy *h, uint32_t patch) {
    sl_patch_place place = sl_patch_place_of(h->patches, patch);
    assert_int_equal(sl_patch_split(h->patches, &place, NULL), SL_OK);
}

static inline void split_levels(hierarchy *h, uint32_t patch, int levels) {
    if (levels == 0) return;
    split(h, patch);
    uint32_t child = h->patches->patch[patch].child;
    if (child == SL_NO_INDEX) return;
    for (uint32_t k = 0; k < 4; k++) split_levels(h, child + k, levels - 1);
}

/* Lists what hangs on an edge of a leaf; at: or NULL. */
static inline size_t hanging_on(const sl_patches *p, const sl_patch_place *leaf, int edge, uint32_t *vertex,
                                uint16_t *at, size_t room) {
    sl_fan_spoke spoke[4 * SL_HANGING_MOST];
    size_t all = sl_patch_spokes(p, leaf, SL_PATCH_DEPTH_MAX, 0, spoke), count = 0;
    for (size_t i = 0; i < all && count < room; i++) {
        if (spoke[i].edge != edge) continue;
        if (at) at[count] = spoke[i].along;
        vertex[count++] = spoke[i].vertex;
    }
    return count;
}

static inline int deepest(const sl_patches *p) {
    int depth = 0;
    for (uint32_t i = 0; i < p->patch_count; i++) {
        int here = sl_patch_is_alive(p, i) ? sl_patch_place_of(p, i).depth : 0;
        depth = here > depth ? here : depth;
    }
    return depth;
}

/* One square of side 2 in the plane z = 0, or one half of it. */
static inline sl_scene *square_scene_of(float specular) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_material(&mesh, 0.5f, specular, 20, 0, 0);
    trace_mesh_quad(&mesh, sl_v3(-1, -1, 0), sl_v3(2, 0, 0), sl_v3(0, 2, 0), 0);
    return trace_mesh_build(&mesh);
}
static inline sl_scene *square_scene(void) { return square_scene_of(0.0f); }
static inline sl_scene *triangle_scene(void) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_diffuse(&mesh, 0.5f);
    uint32_t a = trace_mesh_vertex(&mesh, -1, -1, 0), b = trace_mesh_vertex(&mesh, 1, -1, 0),
             c = trace_mesh_vertex(&mesh, -1, 1, 0);
    trace_mesh_triangle(&mesh, a, b, c, 0);
    return trace_mesh_build(&mesh);
}

/* ---- what must always hold ---- */

static inline bool same_root_place(sl_root_place a, sl_root_place b) {
    return a.root == b.root && a.u == b.u && a.v == b.v;
}

/* Parents name their children and the other way round, corners lie where places say, vertices have as many
 * references as splits and roots have asked for them (or many), no two are one, and what is counted is there.
 */
static inline void assert_sound(const sl_patches *p) {
    size_t patches = 0, leaves = 0, vertices = 0;
    uint32_t *references = calloc(p->vertex_count + 1, sizeof *references);
    assert_non_null(references);
    for (uint32_t i = 0; i < p->patch_count; i++) {
        if (!sl_patch_is_alive(p, i)) continue;
        patches++;
        leaves += sl_patch_is_leaf(p, i);
        sl_patch_place place = sl_patch_place_of(p, i);
        assert_int_equal(place.patch, i);
        assert_int_equal(place.root, sl_patch_root(p, i));
        assert_int_equal(place.corners, sl_patch_corners(p, i));
        uint32_t parent = sl_patch_parent(p, i);
        if (parent == SL_NO_INDEX) {
            assert_int_equal(sl_patches_find_root(p, place.root), i);
        } else {
            assert_true(sl_patch_is_alive(p, parent));
            assert_int_equal(p->patch[parent].child, i / 4 * 4);
        }
        for (int c = 0; c < place.corners; c++) {
            uint32_t vertex = sl_patch_corner(p, i, c);
            assert_true(vertex < p->vertex_count);
            const sl_patch_vertex *v = &p->vertex[vertex];
            sl_root_place lies = {v->root, v->u, v->v};
            assert_true(same_root_place(
                lies, sl_root_canonical(p->primitives, (sl_root_place){place.root, place.u[c], place.v[c]})));
            if (parent == SL_NO_INDEX) references[vertex]++;
        }
        if (place.corners == 3) assert_int_equal(sl_patch_corner(p, i, 3), SL_NO_INDEX);
        for (int m = 0; m < 5 && !sl_patch_is_leaf(p, i); m++) {
            uint32_t vertex = sl_patch_block_of(p, p->patch[i].child)->middle[m];
            assert_int_equal(vertex == SL_NO_INDEX, place.corners == 3 && m > 2);
            if (vertex != SL_NO_INDEX) references[vertex]++;
        }
    }
    for (uint32_t i = 0; i < p->vertex_count; i++) {
        bool many = p->vertex[i].references == SL_REFERENCES_MANY && references[i] > 0;
        if (!many) assert_int_equal(p->vertex[i].references, references[i]);
        vertices += references[i] > 0;
    }
    size_t in_table = 0;
    for (size_t i = 0; i < p->slots; i++) in_table += p->slot[i] != SL_NO_INDEX;
    assert_int_equal(in_table, vertices);
    assert_int_equal(patches, p->patches_alive);
    assert_int_equal(leaves, p->leaves_alive);
    assert_int_equal(vertices, p->vertices_alive);
    size_t free_blocks = 0, free_vertices = 0;
    for (uint32_t i = p->first_free; i != SL_NO_INDEX; i = p->patch[i].child, free_blocks++)
        assert_false(sl_patch_is_alive(p, i));
    for (uint32_t i = p->first_free_vertex; i != SL_NO_INDEX; i = p->vertex[i].root, free_vertices++)
        assert_int_equal(p->vertex[i].references, 0);
    size_t root_blocks = (p->root_count + 3) / 4;
    assert_int_equal(p->patch_count, 4 * root_blocks + (patches - p->root_count) + 4 * free_blocks);
    assert_int_equal(p->vertex_count, vertices + free_vertices);
    free(references);
}

/* Of what is there, not of where it is stored: the same for any order of splits. Sums of hashes do not know
 * an order. */
static inline uint64_t structure_of(const sl_patches *p) {
    uint64_t sum = 0;
    for (uint32_t i = 0; i < p->patch_count; i++) {
        if (!sl_patch_is_alive(p, i)) continue;
        sl_patch_place place = sl_patch_place_of(p, i);
        uint64_t hash = place.root;
        for (int c = 0; c < place.corners; c++) {
            const sl_patch_vertex *v = &p->vertex[sl_patch_corner(p, i, c)];
            hash = (hash ^ ((uint64_t)v->root << 32 | (uint64_t)v->u << 16 | v->v)) * 0x9e3779b97f4a7c15u;
            hash ^= hash >> 29;
        }
        sum += hash * (1 + (uint64_t)sl_patch_is_leaf(p, i));
    }
    return sum;
}
