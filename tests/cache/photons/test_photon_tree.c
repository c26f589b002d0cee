/* The nearest photons: the tree finds exactly what a search through all of them finds, whatever the ties. */
#include <stdlib.h>
#include <string.h>

#include "unit_test.h"
#include "base/isa.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/random.h"
#include "cache/photons/photon_search.h"
#include "cache/photons/photon_tree.h"

static float number(uint64_t stream, uint64_t i) { return sl_random_unit(sl_random_key(21, stream), i); }

static sl_vec3 direction(uint64_t stream, uint64_t i) {
    return sl_normalize_or(sl_v3(number(stream, 3 * i) - 0.5f, number(stream, 3 * i + 1) - 0.5f,
                                 number(stream, 3 * i + 2) - 0.5f),
                           sl_v3(0, 0, 1));
}

static sl_photon_list *empty_list(size_t count) {
    sl_photon_list *list = sl_allocate(1, sizeof *list);
    assert_non_null(list);
    list->count = count;
    list->photon = sl_allocate(count, sizeof *list->photon);
    assert_non_null(list->photon);
    return list;
}

static void put(sl_photon_list *list, size_t i, sl_vec3 position, sl_vec3 normal) {
    list->photon[i] = (sl_photon){.position = {position.x, position.y, position.z},
                                  .flux = {(float)i, 1, 2},
                                  .direction = sl_octahedral_encode(direction(8, i)),
                                  .normal = sl_octahedral_encode(normal)};
}

/* Photons in a box and on two of its faces, some of them in the same places. */
static sl_photon_list *cloud(size_t count, sl_vec3 corner, float size) {
    sl_photon_list *list = empty_list(count);
    for (size_t i = 0; i < count; i++) {
        sl_vec3 p = sl_v3(number(1, i), i % 5 == 1 ? 0.0f : number(2, i), i % 5 == 2 ? 1.0f : number(3, i));
        sl_vec3 n = direction(4, i);
        p = sl_mad(corner, size, p);
        if (i % 7 == 6)
            p = sl_v3(list->photon[i / 2].position[0], list->photon[i / 2].position[1],
                      list->photon[i / 2].position[2]);
        put(list, i, p, n);
    }
    return list;
}

static sl_photon_list *copy_of(const sl_photon_list *list) {
    sl_photon_list *copy = empty_list(list->count);
    if (list->count > 0) memcpy(copy->photon, list->photon, list->count * sizeof *list->photon);
    return copy;
}

static sl_photon_tree *tree_of(sl_photon_list *list, unsigned threads) {
    sl_photon_tree *tree;
    sl_error error;
    if (sl_photon_tree_create(list, threads, &tree, &error) != SL_OK) fail_msg("%s", error.message);
    return tree;
}

typedef struct found {
    float distance;
    uint32_t id;
} found;

static int by_distance(const void *a, const void *b) {
    const found *f = a, *g = b;
    if (f->distance != g->distance) return f->distance < g->distance ? -1 : 1;
    return f->id < g->id ? -1 : f->id > g->id;
}

static int by_id(const void *a, const void *b) {
    const found *f = a, *g = b;
    return f->id < g->id ? -1 : f->id > g->id;
}

/* Looks at every photon. Returns how many. */
static size_t search_all(const sl_photon_list *list, const sl_photon_query *q, found *all) {
    bool sphere = q->normal.x == 0.0f && q->normal.y == 0.0f && q->normal.z == 0.0f;
    float stretch = sphere ? 0.0f : (float)(1.0 / (q->flatness * q->flatness) - 1.0);
    size_t count = 0;
    for (size_t i = 0; i < list->count; i++) {
        sl_vec3 p = sl_sub(
            sl_v3(list->photon[i].position[0], list->photon[i].position[1], list->photon[i].position[2]),
            q->centre);
        float u = sl_dot(p, q->normal), distance = sl_dot(p, p) + stretch * (u * u);
        if (!sphere && q->cos_acceptance > -1.0 &&
            !(sl_dot(sl_octahedral_decode(list->photon[i].normal), q->normal) >= (float)q->cos_acceptance))
            continue;
        if (distance <= (float)(q->radius * q->radius)) all[count++] = (found){distance, (uint32_t)i};
    }
    qsort(all, count, sizeof *all, by_distance);
    count = count < q->neighbours ? count : q->neighbours;
    qsort(all, count, sizeof *all, by_id);
    return count;
}

typedef struct gather_room {
    uint32_t place[SL_NEIGHBOURS_MAX];
    double distance[SL_NEIGHBOURS_MAX];
    uint64_t keys[3 * SL_NEIGHBOURS_MAX + 2 * SL_PHOTON_BUCKET];
    sl_gathered_photons gathered;
} gather_room;

static const sl_gathered_photons *gather(const sl_photon_tree *tree, const sl_photon_query *query,
                                         gather_room *room) {
    room->gathered =
        (sl_gathered_photons){.place = room->place, .distance = room->distance, .keys = room->keys};
    sl_photon_tree_gather(tree, query, &room->gathered);
    return &room->gathered;
}

static void compare_with_all(const sl_photon_list *original, const sl_photon_tree *tree,
                             const sl_photon_query *query, found *all) {
    static gather_room room;
    const sl_gathered_photons *g = gather(tree, query, &room);
    size_t count = search_all(original, query, all);
    assert_int_equal(g->count, count);
    assert_int_equal(g->full, query->neighbours > 0 && count == query->neighbours);
    double farthest = 0.0;
    for (size_t i = 0; i < count; i++) {
        assert_int_equal(sl_photon_tree_id(tree, g->place[i]), all[i].id);
        assert_true(g->distance[i] == (double)all[i].distance);
        farthest = fmax(farthest, g->distance[i]);
    }
    assert_true(g->radius == fmax(g->full ? sqrt(farthest) : query->radius, query->minimum));
}

static void queries_find_what_a_search_through_all_finds(const sl_photon_list *original, sl_vec3 corner,
                                                         float size, unsigned queries) {
    sl_photon_tree *tree = tree_of(copy_of(original), 2);
    found *all = calloc(original->count + 1, sizeof *all);
    const double flatness[] = {0.25, 1.0, 0.05, 0.002}, radius[] = {0.02, 0.1, 0.3, 5.0},
                 acceptance[] = {0.5, -1.0, 0.9, 0.0};
    const size_t neighbours[] = {1, 7, 50, 300, 1000};
    for (uint64_t i = 0; i < queries; i++) {
        sl_vec3 at = sl_mad(
            corner, size,
            sl_v3(number(5, 3 * i), number(5, 3 * i + 1) * (i % 2 ? 1.0f : 0.0f), number(5, 3 * i + 2)));
        sl_photon_query q = {.centre = at,
                             .normal = i % 2 ? direction(6, i) : sl_v3(0, 1, 0),
                             .flatness = flatness[i / 2 % 4],
                             .radius = radius[i / 3 % 4] * (double)size,
                             .minimum = 1e-6,
                             .cos_acceptance = acceptance[i / 5 % 4],
                             .neighbours = neighbours[i % 5]};
        if (i % 11 == 10) q.normal = sl_v3(0, 0, 0);
        if (i % 13 == 12) q.centre = sl_mad(q.centre, 2.0f * size, direction(7, i)); /* from outside */
        compare_with_all(original, tree, &q, all);
    }
    free(all);
    sl_photon_tree_destroy(tree);
}

static void gathers_are_those_of_a_search_through_all_photons(void **state) {
    sl_photon_list *list = cloud(8000, sl_v3(0, 0, 0), 1.0f);
    queries_find_what_a_search_through_all_finds(list, sl_v3(0, 0, 0), 1.0f, 1200);
    sl_photon_list_destroy(list);
}

static void gathers_stay_exact_far_from_the_origin_and_at_any_scale(void **state) {
    const struct {
        sl_vec3 corner;
        float size;
    } worlds[] = {
        {{1e6f, -2e6f, 3e5f}, 10.0f}, {{-5, 3, 2}, 1e-3f}, {{-1e12f, 0, 0}, 2e12f}, {{0, 0, 0}, 1e-12f}};
    for (int w = 0; w < 4; w++) {
        sl_photon_list *list = cloud(3000, worlds[w].corner, worlds[w].size);
        queries_find_what_a_search_through_all_finds(list, worlds[w].corner, worlds[w].size, 200);
        sl_photon_list_destroy(list);
    }
}

static void every_photon_has_its_place(void **state) {
    sl_photon_list *list = cloud(5003, sl_v3(0, 0, 0), 1.0f);
    sl_photon_tree *tree = tree_of(copy_of(list), 2);
    const sl_photon_list *ordered = sl_photon_tree_list(tree);
    assert_int_equal(ordered->count, list->count);
    char *seen = calloc(list->count, 1);
    for (size_t place = 0; place < list->count; place++) {
        uint32_t id = sl_photon_tree_id(tree, place);
        assert_true(id < list->count && !seen[id]);
        seen[id] = 1;
        assert_memory_equal(&ordered->photon[place], &list->photon[id], sizeof(sl_photon));
    }
    assert_true(sl_photon_tree_bytes(tree) > list->count * sizeof(sl_photon));
    free(seen);
    sl_photon_tree_destroy(tree);
    sl_photon_list_destroy(list);
}

static void coincident_photons_are_kept_by_their_ids(void **state) {
    static gather_room room;
    sl_photon_list *list = empty_list(1000);
    for (size_t i = 0; i < 1000; i++) put(list, i, sl_v3(1, 2, 3), sl_v3(0, 1, 0));
    sl_photon_tree *tree = tree_of(list, 2);
    sl_photon_query q = {.centre = {1, 2, 3},
                         .normal = {0, 1, 0},
                         .flatness = 0.25,
                         .radius = 1.0,
                         .minimum = 1e-3,
                         .cos_acceptance = 0.5,
                         .neighbours = 37};
    const sl_gathered_photons *g = gather(tree, &q, &room);
    assert_int_equal(g->count, 37);
    assert_true(g->full && g->radius == 1e-3);
    for (size_t i = 0; i < 37; i++) assert_int_equal(sl_photon_tree_id(tree, g->place[i]), i);
    sl_photon_tree_destroy(tree);
}

static bool same_tree(const sl_photon_tree *a, const sl_photon_tree *b) {
    const sl_photon_list *p = sl_photon_tree_list(a), *q = sl_photon_tree_list(b);
    for (size_t i = 0; i < p->count; i++) {
        if (sl_photon_tree_id(a, i) != sl_photon_tree_id(b, i)) return false;
    }
    return memcmp(p->photon, q->photon, p->count * sizeof *p->photon) == 0;
}

static void trees_are_the_same_at_any_number_of_threads(void **state) {
    sl_photon_list *list = cloud(60000, sl_v3(-1, -1, -1), 2.0f);
    sl_photon_tree *one = tree_of(copy_of(list), 1);
    for (unsigned threads = 2; threads <= 5; threads++) {
        sl_photon_tree *more = tree_of(copy_of(list), threads);
        assert_true(same_tree(one, more));
        sl_photon_tree_destroy(more);
    }
    sl_photon_tree_destroy(one);
    sl_photon_list_destroy(list);
}

static void every_instruction_set_finds_the_same_photons(void **state) {
    static gather_room baseline, other;
    sl_photon_list *list = cloud(30000, sl_v3(0, 0, 0), 1.0f);
    sl_photon_tree *trees[SL_ISAS];
    sl_isa best = sl_isa_best();
    for (int isa = 0; isa <= (int)best; isa++) {
        setenv("SOFTLUX_ISA", sl_isa_name((sl_isa)isa), 1);
        trees[isa] = tree_of(copy_of(list), 1);
    }
    unsetenv("SOFTLUX_ISA");
    for (uint64_t i = 0; i < 300; i++) {
        sl_photon_query q = {.centre = {number(5, i), number(6, i), number(7, i)},
                             .normal = direction(6, i),
                             .flatness = 0.3,
                             .radius = 0.2,
                             .cos_acceptance = 0.2,
                             .neighbours = 150};
        const sl_gathered_photons *a = gather(trees[0], &q, &baseline);
        for (int isa = 1; isa <= (int)best; isa++) {
            const sl_gathered_photons *b = gather(trees[isa], &q, &other);
            assert_true(a->count == b->count && a->radius == b->radius);
            assert_memory_equal(a->place, b->place, a->count * sizeof *a->place);
            assert_memory_equal(a->distance, b->distance, a->count * sizeof *a->distance);
        }
    }
    for (int isa = 0; isa <= (int)best; isa++) sl_photon_tree_destroy(trees[isa]);
    sl_photon_list_destroy(list);
}

static void odd_questions_get_answers_without_nan(void **state) {
    static gather_room room;
    sl_photon_list *list = cloud(5000, sl_v3(0, 0, 0), 1.0f);
    for (size_t i = 0; i < 100; i++) list->photon[i].position[i % 3] = i % 2 ? NAN : INFINITY;
    sl_photon_tree *tree = tree_of(list, 1);
    const sl_photon_query plain = {.centre = {0.5f, 0.5f, 0.5f},
                                   .normal = {0, 1, 0},
                                   .flatness = 0.25,
                                   .radius = 10.0,
                                   .minimum = 1e-3,
                                   .cos_acceptance = -1.0,
                                   .neighbours = 50};
    sl_photon_query q = plain;
    q.radius = INFINITY;
    assert_int_equal(gather(tree, &q, &room)->count, 50);
    assert_true(isfinite(room.gathered.radius));
    q = plain;
    q.neighbours = 100000; /* more than are allowed: as many as are */
    assert_int_equal(gather(tree, &q, &room)->count, SL_NEIGHBOURS_MAX);
    assert_true(room.gathered.full);
    for (size_t i = 0; i < SL_NEIGHBOURS_MAX; i++) assert_true(sl_photon_tree_id(tree, room.place[i]) >= 100);
    q = plain;
    q.neighbours = 0;
    assert_int_equal(gather(tree, &q, &room)->count, 0);
    assert_false(room.gathered.full);
    q = plain;
    q.radius = NAN;
    assert_int_equal(gather(tree, &q, &room)->count, 0);
    assert_true(room.gathered.radius == 1e-3);
    q = plain;
    q.centre.y = NAN;
    assert_int_equal(gather(tree, &q, &room)->count, 0);
    q = plain;
    q.flatness = 0.0;
    q.normal = sl_v3(0, 0, 1);
    gather(tree, &q, &room);
    for (size_t i = 0; i < room.gathered.count; i++) assert_true(isfinite(room.distance[i]));
    q.flatness = NAN;
    assert_int_equal(gather(tree, &q, &room)->count, 50);
    sl_photon_tree_destroy(tree);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(gathers_are_those_of_a_search_through_all_photons),
        cmocka_unit_test(gathers_stay_exact_far_from_the_origin_and_at_any_scale),
        cmocka_unit_test(every_photon_has_its_place),
        cmocka_unit_test(coincident_photons_are_kept_by_their_ids),
        cmocka_unit_test(trees_are_the_same_at_any_number_of_threads),
        cmocka_unit_test(every_instruction_set_finds_the_same_photons),
        cmocka_unit_test(odd_questions_get_answers_without_nan),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
