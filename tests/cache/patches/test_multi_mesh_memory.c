/* What meshes do where memory ends: this file has its own of all that base/memory.h has, and it fails when
 * told to. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/random.h"
#include "cache/patches/mesh.h"
#include "failing_memory.h"
#include "trace_scenes.h"

static sl_scene *scene_of_a_sphere(void) {
    trace_mesh parts = trace_mesh_begin();
    trace_mesh_material(&parts, 0.5f, 0, 0, 0, 0);
    trace_mesh_sphere(&parts, sl_v3(0, 0, 0), 1.0f, 4, 0.1f, false, 0);
    return trace_mesh_build(&parts);
}

typedef struct making {
    const sl_scene *scene;
    sl_topology *topology;
} making;

static sl_status make_topology(void *context) {
    making *m = context;
    sl_error error;
    return sl_topology_create(m->scene, false, &m->topology, &error);
}

static void there_is_none(void *context) { assert_null(((making *)context)->topology); }

static void a_topology_without_memory_is_an_error_and_leaves_nothing_behind(void **state) {
    (void)state;
    sl_scene *scene = scene_of_a_sphere();
    making m = {.scene = scene};
    long held = blocks_held;
    assert_true(until_it_succeeds(make_topology, &m, false, there_is_none) > 25);
    sl_topology_destroy(m.topology);
    assert_int_equal(blocks_held, held);
    sl_scene_destroy(scene);
}

/* A root and a split at a random place. */
typedef struct step {
    sl_mesh *mesh;
    uint32_t face;
    float u, v;
} step;

static sl_status take_step(void *context) {
    step *s = context;
    sl_mesh *mesh = s->mesh;
    sl_status status;
    float w1, w2;
    size_t leaves = mesh->leaf_count;
    uint32_t root = sl_mesh_root(mesh, s->face, &status, NULL);
    assert_int_equal(root == SL_NO_INDEX, status != SL_OK);
    if (status == SL_OK) {
        sl_mesh_place leaf = sl_mesh_locate(mesh, s->face, s->u, s->v, &w1, &w2);
        leaves = mesh->leaf_count;
        status = sl_mesh_split(mesh, &leaf, NULL);
        if (status != SL_OK) assert_true(sl_mesh_is_leaf(mesh, leaf.node));
    }
    if (status != SL_OK) assert_int_equal(mesh->leaf_count, leaves);
    return status;
}

static long build(sl_mesh *mesh, bool failing) {
    uint64_t key = sl_random_key(4, 4);
    uint32_t faces = (uint32_t)mesh->topology->face_count;
    long failures = 0;
    for (uint64_t i = 0; i < 3000; i++) {
        step s = {mesh, sl_random_bits(key, 3 * i) % faces, sl_random_unit(key, 3 * i + 1),
                  sl_random_unit(key, 3 * i + 2)};
        if (failing) failures += until_it_succeeds(take_step, &s, true, NULL);
        else assert_int_equal(take_step(&s), SL_OK);
    }
    return failures;
}

static void a_mesh_that_ran_out_of_memory_goes_on_as_if_it_had_not(void **state) {
    (void)state;
    sl_scene *scene = scene_of_a_sphere();
    sl_topology *topology;
    sl_mesh *mesh[2];
    long held = blocks_held;
    assert_int_equal(sl_topology_create(scene, false, &topology, NULL), SL_OK);
    for (int i = 0; i < 2; i++) {
        assert_int_equal(sl_mesh_create(topology, 3, 8, &mesh[i], NULL), SL_OK);
        long failures = build(mesh[i], i == 1);
        assert_true(i == 0 ? failures == 0 : failures > 50);
    }
    assert_int_equal(mesh[0]->leaf_count, mesh[1]->leaf_count);
    assert_int_equal(mesh[0]->node_count, mesh[1]->node_count);
    assert_int_equal(mesh[0]->vertex_count, mesh[1]->vertex_count);
    assert_memory_equal(mesh[0]->node, mesh[1]->node, mesh[0]->node_count * sizeof *mesh[0]->node);
    assert_memory_equal(mesh[0]->key, mesh[1]->key, mesh[0]->vertex_count * sizeof *mesh[0]->key);
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
