/* What patches and bicubic surfaces do where memory ends: this file has its own of all that base/memory.h
 * has, and it fails when told to. */
#include "patch_support.h"

#include "base/counters.h"
#include "base/random.h"
#include "cache/shading_cache/change.h"
#include "cache/shading_cache/work.h"
#include "failing_memory.h"

static sl_scene *scene_of_quads_and_triangles(void) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_material(&mesh, 0.5f, 0, 0, 0, 0);
    trace_mesh_material(&mesh, 0.2f, 0.5f, 20, 0, 0);
    for (int i = 0; i < 3; i++)
        trace_mesh_quad(&mesh, sl_v3((float)i, 0, 0), sl_v3(1, 0, 0), sl_v3(0, 1, 0), 0);
    trace_mesh_sphere(&mesh, sl_v3(0, 0, 9), 1.0f, 3, 0.1f, false, 1);
    return trace_mesh_build(&mesh);
}

static sl_status load_vase(void *scene) { return sl_scene_load("scenes/vase.bpt", scene, NULL); }
static sl_status find(void *h) {
    return sl_primitives_find(((hierarchy *)h)->scene, &((hierarchy *)h)->primitives, NULL);
}
static sl_status create(void *h) {
    return sl_patches_create(((hierarchy *)h)->primitives, true, &((hierarchy *)h)->patches, NULL);
}

static void loading_finding_and_creating_without_memory_leave_nothing_behind(void **state) {
    (void)state;
    long held = blocks_held;
    hierarchy h = {0};
    assert_true(until_it_succeeds(load_vase, &h.scene, false, NULL) > 20);
    assert_int_equal(h.scene->bicubic_count, 16);
    assert_true(until_it_succeeds(find, &h, false, NULL) > 10);
    assert_true(until_it_succeeds(create, &h, false, NULL) > 4);
    hierarchy_discard(&h);
    assert_int_equal(blocks_held, held);
}

/* A root, a split or a drop at a random place. */
typedef struct step {
    sl_patches *patches;
    uint32_t root;
    double u, v;
    bool grow;
    long failures;
} step;

static sl_status take_step(void *context) {
    step *s = context;
    sl_patches *p = s->patches;
    sl_status status;
    uint32_t patch = sl_patches_root(p, s->root, &status, NULL);
    assert_int_equal(patch == SL_NO_INDEX, status != SL_OK);
    if (status != SL_OK) return status;
    patch = sl_patch_locate(p, s->root, s->u, s->v).patch;
    size_t patches = p->patches_alive, vertices = p->vertices_alive;
    if (s->grow) status = sl_patch_split(p, patch, NULL);
    else if (sl_patch_parent(p, patch) != SL_NO_INDEX) sl_patch_drop_children(p, sl_patch_parent(p, patch));
    if (status != SL_OK)
        assert_true(p->patches_alive == patches && p->vertices_alive == vertices &&
                    sl_patch_is_leaf(p, patch));
    return status;
}

static void look_now_and_then(void *context) {
    step *s = context;
    if (s->failures++ % 16 == 0) assert_sound(s->patches);
}

static long build(hierarchy *h, bool failing) {
    uint64_t key = sl_random_key(4, 4);
    step s = {.patches = h->patches};
    for (uint64_t i = 0; i < 4000; i++) {
        s.root = sl_random_bits(key, 4 * i) % (2 * (uint32_t)h->primitives->count);
        s.u = (double)sl_random_unit(key, 4 * i + 1);
        s.v = (double)sl_random_unit(key, 4 * i + 2);
        s.grow = sl_random_bits(key, 4 * i + 3) % 8 != 0;
        if (failing) until_it_succeeds(take_step, &s, true, look_now_and_then);
        else assert_int_equal(take_step(&s), SL_OK);
    }
    return s.failures;
}

static void patches_that_ran_out_of_memory_go_on_as_if_they_had_not(void **state) {
    (void)state;
    hierarchy h[2];
    for (int i = 0; i < 2; i++) {
        h[i] = hierarchy_of(scene_of_quads_and_triangles(), SL_PATCHES_LOBES);
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

/* ---- an update ---- */

enum { SIDE = 16 };

typedef struct update {
    hierarchy h;
    sl_pixel_selection how;
    sl_choice choice[128];
    size_t choices;
    sl_chosen_place place[64];
    uint32_t vertex[(4 + SL_HANGING_A_PATCH) * 64 + 64];
    size_t vertices;
    sl_counters counters;
    sl_changes *changes;
} update;

static sl_status choose(void *context) {
    update *u = context;
    static uint32_t leaf[SIDE * SIDE];
    static sl_leaf_priority leaves[SIDE];
    for (uint32_t i = 0; i < SIDE * SIDE; i++) leaf[i] = i % SIDE;
    for (uint32_t i = 0; i < SIDE; i++) leaves[i] = (sl_leaf_priority){i, SIDE, 1.0f, 0.9f};
    sl_selection_settings s = {.how = u->how,
                               .points = 64,
                               .random_share = 0.03f,
                               .flood_threshold = 0.5f,
                               .per_patch = 16,
                               .seed = 1};
    return sl_select_pixels(&s, SIDE, SIDE, leaf, SIDE, leaves, u->choice, &u->choices, &u->counters, NULL);
}

static sl_status work_out(void *context) {
    update *u = context;
    const sl_display_curve curve = {.reference = 1.0f};
    const sl_work_settings settings = {.split_above = 1.2f, .levels = 3, .crowd = 4, .now = 2};
    sl_camera camera = {sl_v3(0, 0, 2), sl_v3(1, 0, 0), sl_v3(0, 1, 0), sl_v3(0, 0, 1), 1.0f};
    return sl_work_out(u->h.patches, &curve, &settings, &camera, 512, 512, 64, u->place, u->vertex,
                       &u->vertices, &u->counters, NULL);
}

static void assert_sound_patches(void *context) { assert_sound(((update *)context)->h.patches); }

static sl_status create_changes(void *context) {
    return sl_changes_create(((update *)context)->h.scene, 2.0f, 3, &((update *)context)->changes, NULL);
}

static void an_update_without_memory_fails_and_the_next_one_does_the_same_as_ever(void **state) {
    (void)state;
    static update u, again;
    u.h = hierarchy_of(square_scene(), 0);
    for (int how = 0; how < 3; how++) {
        u.how = again.how = (sl_pixel_selection)how;
        assert_true(until_it_succeeds(choose, &u, false, NULL) >= 3);
        assert_int_equal(choose(&again), SL_OK);
        assert_int_equal(u.choices, again.choices);
        assert_memory_equal(u.choice, again.choice, u.choices * sizeof *u.choice);
    }
    assert_int_equal(until_it_succeeds(create_changes, &u, false, NULL), 2);
    sl_changes_destroy(u.changes);
    want_root(&u.h, 0);
    for (uint32_t i = 0; i < u.h.patches->vertex_count; i++) u.h.patches->vertex[i].evaluated = 1;
    uint32_t root = u.h.patches->root_patch[0];
    for (int i = 0; i < 64; i++)
        u.place[i] = (sl_chosen_place){root, (float)(i % 8) / 8.0f + 0.05f, (float)i / 64.0f};
    /* splits that succeeded stay: what is left is a hierarchy, and may grow on */
    until_it_succeeds(work_out, &u, true, assert_sound_patches);
    assert_true(u.counters.value[SL_COUNT_SPLITS] >= 1 && u.vertices <= 4 * 64);
    hierarchy_discard(&u.h);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(loading_finding_and_creating_without_memory_leave_nothing_behind),
        cmocka_unit_test(patches_that_ran_out_of_memory_go_on_as_if_they_had_not),
        cmocka_unit_test(an_update_without_memory_fails_and_the_next_one_does_the_same_as_ever),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
