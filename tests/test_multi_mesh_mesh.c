/* Quadtrees of triangles: counts, shared vertices, continuity, reuse. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "base/memory.h"
#include "base/random.h"
#include "cache/multi_mesh/mesh.h"
#include "trace_scenes.h"

typedef struct world {
    sl_scene *scene;
    sl_topology *topology;
    sl_mesh *mesh;
} world;

static world world_of(trace_mesh *parts, int channels, int depth) {
    world w = {.scene = trace_mesh_build(parts)};
    assert_int_equal(sl_topology_create(w.scene, false, &w.topology, NULL), SL_OK);
    assert_int_equal(sl_mesh_create(w.topology, channels, depth, &w.mesh, NULL), SL_OK);
    return w;
}

static void discard(world *w) {
    sl_mesh_destroy(w->mesh);
    sl_topology_destroy(w->topology);
    sl_scene_destroy(w->scene);
}

static uint32_t root(world *w, uint32_t face) {
    sl_status status;
    uint32_t node = sl_mesh_root(w->mesh, face, &status, NULL);
    assert_int_equal(status, SL_OK);
    return node;
}

static void split_all(sl_mesh *mesh, sl_mesh_place place, int levels) {
    if (levels == 0) return;
    if (sl_mesh_is_leaf(mesh, place.node)) assert_int_equal(sl_mesh_split(mesh, &place, NULL), SL_OK);
    assert_false(sl_mesh_is_leaf(mesh, place.node));
    for (int c = 0; c < sl_mesh_children(mesh, place.node); c++) split_all(mesh, sl_mesh_child_place(mesh, &place, c), levels - 1);
}

static trace_mesh one_triangle(void) {
    trace_mesh m = trace_mesh_begin();
    trace_mesh_material(&m, 0.5f, 0, 0, 0, 0);
    uint32_t a = trace_mesh_vertex(&m, 0, 0, 0), b = trace_mesh_vertex(&m, 1, 0, 0), c = trace_mesh_vertex(&m, 0, 1, 0);
    trace_mesh_triangle(&m, a, b, c, 0);
    return m;
}

static void a_triangle_split_d_times_has_the_leaves_and_vertices_of_a_grid(void **state) {
    (void)state;
    for (int depth = 0; depth <= 6; depth++) {
        trace_mesh parts = one_triangle();
        world w = world_of(&parts, 1, 12);
        root(&w, 0);
        split_all(w.mesh, sl_mesh_root_place(w.mesh, 0), depth);
        size_t side = (size_t)1 << depth;
        assert_int_equal(w.mesh->leaf_count, side * side);
        assert_int_equal(w.mesh->vertex_count, (side + 1) * (side + 2) / 2);
        discard(&w);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_triangle_split_d_times_has_the_leaves_and_vertices_of_a_grid),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
