/* Which leaf is served next: priorities up to the roots, the heap, the paper's chain. */
#include <stdio.h>

#include "cache/multi_mesh/displayed.h"
#include "multi_mesh_field.h"

typedef struct largest {
    const sl_displayed *d;
    float priority;
} largest;
static void look_at_leaf(void *context, const sl_patch_place *leaf) {
    largest *l = context;
    float priority =
        sl_patch_is_leaf(l->d->mesh, leaf->patch) ? l->d->mesh->patch[leaf->patch].priority : 0.0f;
    l->priority = priority > l->priority ? priority : l->priority;
}

/* Each root has the largest of its leaves' priorities, and the heap's top the largest of all. */
static void assert_priorities(const sl_displayed *d) {
    float all = 0.0f;
    for (size_t e = 0; e < d->pixels->face_count; e++) {
        sl_patch_place root = sl_patch_root_place(d->mesh, d->pixels->face[e].face);
        largest l = {d, 0.0f};
        visit_below(d->mesh, &root, look_at_leaf, &l);
        assert_true(d->mesh->patch[root.patch].priority == l.priority);
        all = l.priority > all ? l.priority : all;
    }
    assert_true(sl_displayed_priority(d) == all);
}

/* Holds the priorities that incremental updates have left against those computed anew. */
static void assert_priorities_are_up_to_date(rig *r) {
    const sl_patches *mesh = r->mesh->mesh;
    float *priority = malloc(mesh->patch_count * sizeof *priority);
    assert_non_null(priority);
    for (size_t n = 0; n < mesh->patch_count; n++) priority[n] = mesh->patch[n].priority;
    sl_displayed_prioritise(r->mesh);
    for (uint32_t n = 0; n < mesh->patch_count; n++) {
        if (sl_patch_is_alive(mesh, n) && mesh->patch[n].pixels)
            assert_true(priority[n] == mesh->patch[n].priority);
    }
    free(priority);
}

static void roots_have_the_largest_priority_of_their_leaves_after_10000_splits(void **state) {
    rig r = rig_in_view(striped_room(), (field){stripes, NULL}, 480, 360);
    assert_priorities(r.mesh);
    for (int i = 0; r.counters.value[SL_COUNT_SPLITS] < 10000; i++) {
        assert_true(rig_step(&r, 32) > 0);
        if (i % 100 == 99) assert_priorities(r.mesh);
    }
    assert_priorities(r.mesh);
    assert_priorities_are_up_to_date(&r);
    assert_priorities(r.mesh);
    rig_discard(&r);
}

static void a_leaf_that_is_taken_is_not_taken_twice(void **state) {
    rig r = rig_in_view(striped_room(), (field){stripes, NULL}, 96, 72);
    float last = sl_displayed_priority(r.mesh);
    size_t taken = 0;
    for (sl_patch_place leaf; (leaf = sl_displayed_take(r.mesh)).patch != SL_NO_INDEX; taken++) {
        assert_true(r.mesh->mesh->patch[leaf.patch].flags & SL_NODE_TAKEN);
        assert_true(sl_displayed_priority(r.mesh) <= last);
        last = sl_displayed_priority(r.mesh);
        assert_true(taken < r.mesh->root_count);
    }
    assert_true(taken > 100);
    assert_priorities(r.mesh);
    rig_discard(&r);
}

/* ---- the paper's chain ---- */

typedef struct leaf_list {
    sl_patch_place *leaf;
    size_t count, room;
} leaf_list;
static void append_leaf(void *context, const sl_patch_place *leaf) {
    leaf_list *l = context;
    if (l->count == l->room) {
        l->room = l->room ? 2 * l->room : 1024;
        l->leaf = realloc(l->leaf, l->room * sizeof *l->leaf);
        assert_non_null(l->leaf);
    }
    l->leaf[l->count++] = *leaf;
}

/* The sum of the priorities that were chosen, one leaf at a time. */
static double chosen_after(rig *r, size_t splits) {
    double sum = 0.0;
    for (size_t i = 0; i < splits; i++) {
        sl_patch_place leaf = sl_displayed_take(r->mesh);
        if (leaf.patch == SL_NO_INDEX) break;
        r->mesh->mesh->patch[leaf.patch].flags &= ~(uint32_t)SL_NODE_TAKEN;
        sum += (double)sl_displayed_leaf_priority(r->mesh, &leaf); /* what it was worth before it was taken */
        uint32_t vertex[6];
        size_t count;
        assert_int_equal(sl_displayed_request(r->mesh, &leaf, vertex, &count, NULL), SL_OK);
        rig_sample(r, vertex, count);
        assert_int_equal(sl_displayed_commit(r->mesh, &leaf, &r->counters, NULL), SL_OK);
    }
    return sum;
}

static void chain_and_heap_come_to_the_same_leaves(void **state) {
    leaf_list list[2] = {{NULL, 0, 0}, {NULL, 0, 0}};
    double chosen[2][3], roots = 0.0;
    const double rounds[3] = {0.1, 0.5, 2.5};
    for (int s = 0; s < 2; s++) {
        sl_displayed_settings settings = usual_settings();
        settings.selection = s == 0 ? SL_SELECT_HEAP : SL_SELECT_CHAIN;
        rig r = rig_of(striped_room(), (field){stripes, NULL}, &settings, 160, 120);
        rig_look(&r, NULL, 1);
        roots = (double)roots_in_view(r.mesh);
        for (int k = 0; k < 3; k++) {
            double before = k == 0 ? 0.0 : rounds[k - 1];
            chosen[s][k] = (k == 0 ? 0.0 : chosen[s][k - 1]) +
                           chosen_after(&r, (size_t)(roots * rounds[k]) - (size_t)(roots * before));
        }
        rig_finish(&r);
        assert_true(sl_displayed_priority(r.mesh) <= 0.0f);
        visit_leaves(r.mesh, append_leaf, &list[s]);
        rig_discard(&r);
    }
    printf(
        "chain's chosen priority over the heap's after 0.1, 0.5, 2.5 tests a root (%.0f): %.2f %.2f %.2f\n",
        roots, chosen[1][0] / chosen[0][0], chosen[1][1] / chosen[0][1], chosen[1][2] / chosen[0][2]);
    assert_true(chosen[1][2] / chosen[0][2] > 0.8);
    assert_true(chosen[1][0] <= chosen[0][0]);
    assert_int_equal(list[0].count, list[1].count);
    for (size_t i = 0; i < list[0].count; i++) {
        const sl_patch_place *a = &list[0].leaf[i], *b = &list[1].leaf[i];
        assert_true(a->root == b->root && a->depth == b->depth && !memcmp(a->u, b->u, sizeof a->u) &&
                    !memcmp(a->v, b->v, sizeof a->v));
    }
    free(list[0].leaf);
    free(list[1].leaf);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(roots_have_the_largest_priority_of_their_leaves_after_10000_splits),
        cmocka_unit_test(a_leaf_that_is_taken_is_not_taken_twice),
        cmocka_unit_test(chain_and_heap_come_to_the_same_leaves),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
