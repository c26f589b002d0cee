/* What meshes do where memory ends: this file has its own of all that base/memory.h has, and it fails when told to. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/random.h"
#include "cache/multi_mesh/mesh.h"
#include "failing_memory.h"
#include "trace_scenes.h"

static sl_scene *scene_of_a_sphere(void) {
    trace_mesh parts = trace_mesh_begin();
    trace_mesh_material(&parts, 0.5f, 0, 0, 0, 0);
    trace_mesh_sphere(&parts, sl_v3(0, 0, 0), 1.0f, 4, 0.1f, false, 0);
    return trace_mesh_build(&parts);
}

static void a_topology_without_memory_is_an_error_and_leaves_nothing_behind(void **state) {
    (void)state;
    sl_scene *scene = scene_of_a_sphere();
    sl_status status = SL_ERROR_RESOURCES;
    long failed = 0;
    while (status != SL_OK) {
        sl_topology *topology;
        sl_error error;
        long held = blocks_held;
        allocations_left = failed;
        status = sl_topology_create(scene, false, &topology, &error);
        allocations_left = -1;
        if (status != SL_OK) {
            assert_int_equal(status, SL_ERROR_RESOURCES);
            assert_null(topology);
            assert_int_equal(blocks_held, held);
            failed++;
        }
        sl_topology_destroy(topology);
        assert_int_equal(blocks_held, held);
    }
    assert_true(failed > 25);
    sl_scene_destroy(scene);
}

/* Roots and splits at random places. Where memory ends, the same step is tried again with one allocation more. */
static void build(sl_mesh *mesh, bool failing, long *failures) {
    uint64_t key = sl_random_key(4, 4);
    uint32_t faces = (uint32_t)mesh->topology->face_count;
    for (uint64_t i = 0; i < 3000; i++) {
        sl_status status = SL_ERROR_RESOURCES;
        for (long room = 0; status != SL_OK; room++) {
            size_t leaves = mesh->leaf_count;
            uint32_t face = sl_random_bits(key, 3 * i) % faces;
            allocations_left = failing ? room : -1;
            uint32_t root = sl_mesh_root(mesh, face, &status, NULL);
            assert_int_equal(root == SL_NO_INDEX, status != SL_OK);
            if (status == SL_OK) {
                float w1, w2;
                sl_mesh_place leaf = sl_mesh_locate(mesh, face, sl_random_unit(key, 3 * i + 1), sl_random_unit(key, 3 * i + 2), &w1, &w2);
                leaves = mesh->leaf_count;
                status = sl_mesh_split(mesh, &leaf, NULL);
                if (status != SL_OK) assert_true(sl_mesh_is_leaf(mesh, leaf.node));
            }
            allocations_left = -1;
            if (status == SL_OK) continue;
            assert_int_equal(status, SL_ERROR_RESOURCES);
            assert_int_equal(mesh->leaf_count, leaves);
            ++*failures;
        }
    }
}

/* Two meshes with the same in them: the first is tidied up at once, the second when there is room for all that it takes. */
static void tidy_where_memory_ends(sl_mesh *a, sl_mesh *b) {
    uint32_t *node_of = malloc(a->node_count * sizeof *node_of);
    long failed = -1, held = blocks_held;
    size_t nodes = b->node_count, capacity = b->node_capacity, vertices = b->vertex_count;
    assert_true(node_of != NULL && sl_mesh_tidy(a, true, node_of));
    for (bool good = false; !good; failed++) {
        allocations_left = failed + 1;
        good = sl_mesh_tidy(b, true, node_of);
        allocations_left = -1;
        assert_int_equal(blocks_held, held);
        if (!good) assert_true(b->node_count == nodes && b->node_capacity == capacity && b->vertex_count == vertices);
    }
    assert_int_equal(failed, 6);
    assert_int_equal(a->vertex_count, b->vertex_count);
    assert_memory_equal(a->node, b->node, a->node_count * sizeof *a->node);
    assert_memory_equal(a->key, b->key, a->vertex_count * sizeof *a->key);
    free(node_of);
}

static void a_mesh_that_ran_out_of_memory_goes_on_as_if_it_had_not(void **state) {
    (void)state;
    sl_scene *scene = scene_of_a_sphere();
    sl_topology *topology;
    sl_mesh *mesh[2];
    long failures = 0, none = 0, held = blocks_held;
    assert_int_equal(sl_topology_create(scene, false, &topology, NULL), SL_OK);
    for (int i = 0; i < 2; i++) {
        assert_int_equal(sl_mesh_create(topology, 3, 8, &mesh[i], NULL), SL_OK);
        build(mesh[i], i == 1, i == 1 ? &failures : &none);
    }
    assert_true(failures > 50 && none == 0);
    assert_int_equal(mesh[0]->leaf_count, mesh[1]->leaf_count);
    assert_int_equal(mesh[0]->node_count, mesh[1]->node_count);
    assert_int_equal(mesh[0]->vertex_count, mesh[1]->vertex_count);
    assert_memory_equal(mesh[0]->node, mesh[1]->node, mesh[0]->node_count * sizeof *mesh[0]->node);
    assert_memory_equal(mesh[0]->key, mesh[1]->key, mesh[0]->vertex_count * sizeof *mesh[0]->key);
    tidy_where_memory_ends(mesh[0], mesh[1]);
    for (int i = 0; i < 2; i++) sl_mesh_destroy(mesh[i]);
    sl_topology_destroy(topology);
    assert_int_equal(blocks_held, held);
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_topology_without_memory_is_an_error_and_leaves_nothing_behind),
        cmocka_unit_test(a_mesh_that_ran_out_of_memory_goes_on_as_if_it_had_not),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
