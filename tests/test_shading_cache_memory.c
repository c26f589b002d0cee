/* What patches and bicubic surfaces do where memory ends: this file has its own of all that base/memory.h has, and it fails when told to. */
#include "patch_support.h"

#include "base/counters.h"
#include "base/memory.h"
#include "base/random.h"

static long allocations_left = -1; /* until one fails, then all do; -1: none fails */
static long blocks_held;

void *sl_allocate(size_t count, size_t size) {
    if (allocations_left == 0) return NULL;
    if (allocations_left > 0) allocations_left--;
    size_t bytes = (count * size + 64) / 64 * 64;
    void *block = aligned_alloc(64, bytes);
    assert_non_null(block);
    blocks_held++;
    return memset(block, 0, bytes);
}

void *sl_allocate_unset(size_t count, size_t size) { return sl_allocate(count, size); }

void sl_free(void *block) {
    if (block != NULL) blocks_held--;
    free(block);
}

static sl_scene *scene_of_quads_and_triangles(void) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_material(&mesh, 0.5f, 0, 0, 0, 0);
    for (int i = 0; i < 3; i++) trace_mesh_quad(&mesh, sl_v3((float)i, 0, 0), sl_v3(1, 0, 0), sl_v3(0, 1, 0), 0);
    trace_mesh_sphere(&mesh, sl_v3(0, 0, 9), 1.0f, 3, 0.1f, false, 0);
    return trace_mesh_build(&mesh);
}

/* Calls something with ever more allocations until it succeeds; how often it failed. */
typedef sl_status attempt(void *context);
static long until_it_succeeds(attempt *call, void *context) {
    for (long room = 0;; room++) {
        long held = blocks_held;
        allocations_left = room;
        sl_status status = call(context);
        allocations_left = -1;
        if (status == SL_OK) return room;
        assert_int_equal(status, SL_ERROR_RESOURCES);
        assert_int_equal(blocks_held, held);
    }
}

static sl_status load_vase(void *scene) { return sl_scene_load("scenes/vase.bpt", scene, NULL); }
static sl_status find(void *h) { return sl_primitives_find(((hierarchy *)h)->scene, &((hierarchy *)h)->primitives, NULL); }
static sl_status create(void *h) { return sl_patches_create(((hierarchy *)h)->primitives, true, &((hierarchy *)h)->patches, NULL); }

static void loading_finding_and_creating_without_memory_leave_nothing_behind(void **state) {
    (void)state;
    long held = blocks_held;
    hierarchy h = {0};
    assert_true(until_it_succeeds(load_vase, &h.scene) > 20);
    assert_int_equal(h.scene->bicubic_count, 16);
    assert_true(until_it_succeeds(find, &h) > 10);
    assert_true(until_it_succeeds(create, &h) > 4);
    hierarchy_discard(&h);
    assert_int_equal(blocks_held, held);
}

/* Roots, splits and drops at random places. Where memory ends, the same step is tried again with one allocation more. */
static long build(hierarchy *h, bool failing) {
    sl_patches *p = h->patches;
    uint64_t key = sl_random_key(4, 4);
    long failures = 0;
    for (uint64_t i = 0; i < 4000; i++) {
        uint32_t root = sl_random_bits(key, 4 * i) % (2 * (uint32_t)h->primitives->count);
        double u = (double)sl_random_unit(key, 4 * i + 1), v = (double)sl_random_unit(key, 4 * i + 2);
        bool grow = sl_random_bits(key, 4 * i + 3) % 8 != 0;
        sl_status status = SL_ERROR_RESOURCES;
        for (long room = 0; status != SL_OK; room++) {
            allocations_left = failing ? room : -1;
            uint32_t patch = sl_patches_root(p, root, &status, NULL);
            assert_int_equal(patch == SL_NO_INDEX, status != SL_OK);
            if (status == SL_OK) {
                patch = sl_patch_locate(p, root, u, v).patch;
                size_t patches = p->patches_alive, vertices = p->vertices_alive;
                if (grow) status = sl_patch_split(p, patch, NULL);
                else if (sl_patch_parent(p, patch) != SL_NO_INDEX) sl_patch_drop_children(p, sl_patch_parent(p, patch));
                if (status != SL_OK) assert_true(p->patches_alive == patches && p->vertices_alive == vertices && sl_patch_is_leaf(p, patch));
            }
            allocations_left = -1;
            if (status == SL_OK) continue;
            assert_int_equal(status, SL_ERROR_RESOURCES);
            if (failures++ % 16 == 0) assert_sound(p);
        }
    }
    return failures;
}

static void patches_that_ran_out_of_memory_go_on_as_if_they_had_not(void **state) {
    (void)state;
    hierarchy h[2];
    for (int i = 0; i < 2; i++) {
        h[i] = hierarchy_of(scene_of_quads_and_triangles(), true);
        long failures = build(&h[i], i == 1);
        assert_true(i == 0 ? failures == 0 : failures > 50);
    }
    const sl_patches *a = h[0].patches, *b = h[1].patches;
    assert_int_equal(a->patch_count, b->patch_count);
    assert_int_equal(a->vertex_count, b->vertex_count);
    assert_memory_equal(a->patch, b->patch, a->patch_count * sizeof *a->patch);
    assert_memory_equal(a->flags, b->flags, a->patch_count);
    assert_memory_equal(a->vertex, b->vertex, a->vertex_count * sizeof *a->vertex);
    /* Eviction needs some, too. */
    sl_counters counters = {0};
    size_t patches = a->patches_alive;
    allocations_left = 0;
    sl_status status = sl_patches_evict(h[0].patches, 100, 7, 0.8, &counters, NULL);
    allocations_left = -1;
    assert_int_equal(status, SL_ERROR_RESOURCES);
    assert_int_equal(a->patches_alive, patches);
    assert_int_equal(sl_patches_evict(h[0].patches, 100, 7, 0.8, &counters, NULL), SL_OK);
    assert_true(a->patches_alive <= 100);
    assert_sound(a);
    for (int i = 0; i < 2; i++) hierarchy_discard(&h[i]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(loading_finding_and_creating_without_memory_leave_nothing_behind),
        cmocka_unit_test(patches_that_ran_out_of_memory_go_on_as_if_they_had_not),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
