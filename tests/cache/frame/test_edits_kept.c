/* What methods keep when a scene changes: the table in softlux.h at sl_method_edit(), entry by entry. */
#include <math.h>
#include <stdio.h>

#include "unit_test.h"
#include "cache/shading_cache/state.h"
#include "cache/splatting/state.h"
#include "edited_methods.h"

/* ---- the table ---- */

#define COLOURS (1u << EDIT_COLOUR | 1u << EDIT_LAMP)
#define LIGHT (COLOURS | 1u << EDIT_POWER | 1u << EDIT_PLACE | 1u << EDIT_SKY | 1u << EDIT_TRANSFORM)
#define CAMERA (1u << EDIT_CAMERA)
#define ANEW 1.0

/* After an edit of these kinds what is counted comes to at most that share of what a method counts that
 * begins with the scene as it is then. */
static const struct {
    const char *method;
    unsigned kinds;
    sl_counter counter;
    double most;
} entries[] = {
    {"splatting", CAMERA, SL_COUNT_GATHERS, 0.2},
    {"splatting", LIGHT, SL_COUNT_GATHERS, ANEW},
    {"direct-radiance", CAMERA, SL_COUNT_MAP_PHOTONS, 0.0},
    {"direct-radiance", LIGHT, SL_COUNT_MAP_PHOTONS, ANEW},
    {"light-octree", CAMERA, SL_COUNT_PHOTONS_EMITTED, 0.0},
    {"light-octree", CAMERA, SL_COUNT_LEAVES, 0.0},
    {"multi-mesh", CAMERA, SL_COUNT_LIGHT_SAMPLES, 0.1},
    {"multi-mesh", CAMERA, SL_COUNT_COARSE_SAMPLES, 0.0},
    {"multi-mesh", CAMERA, SL_COUNT_INDIRECT_SAMPLES, 0.3},
    {"multi-mesh", COLOURS, SL_COUNT_LIGHT_SAMPLES, 0.05},
    {"multi-mesh", 1u << EDIT_POWER, SL_COUNT_LIGHT_SAMPLES, 0.2}, /* the coarse mesh's, by other rays */
    {"multi-mesh", 1u << EDIT_PLACE, SL_COUNT_LIGHT_SAMPLES, 1.5},
    {"multi-mesh", 1u << EDIT_TRANSFORM, SL_COUNT_LIGHT_SAMPLES, 0.6},
    {"multi-mesh", LIGHT, SL_COUNT_INDIRECT_SAMPLES, 1.3},
    {"shading-cache", CAMERA, SL_COUNT_POINTS_SHADED, 0.3},
    {"shading-cache", LIGHT & ~(1u << EDIT_SKY), SL_COUNT_SPLITS, 0.2},
    {"shading-cache", 1u << EDIT_COLOUR, SL_COUNT_POINTS_SHADED, 0.6},
    {"shading-cache", LIGHT & ~(1u << EDIT_SKY), SL_COUNT_INDIRECT_SAMPLES, 0.99},
    {"path", CAMERA | LIGHT, SL_COUNT_SAMPLES, ANEW},
    {"bidirectional", CAMERA | LIGHT, SL_COUNT_SAMPLES, ANEW},
};

static void check_entry(size_t i, room_edit kind) {
    sl_error error;
    sl_scene *scene;
    const sl_counter counter = entries[i].counter;
    edited_room r = room_at_first(6);
    good(build_room(&r, &scene, &error), &error);
    sl_method *method = finished(scene, entries[i].method);
    const uint64_t before = sl_method_counters(method)->value[counter];
    assert_true(change(scene, &r, kind) != 0);
    follow(method);
    sl_method *fresh = finished(scene, entries[i].method);
    const uint64_t more = sl_method_counters(method)->value[counter] - before,
                   all = sl_method_counters(fresh)->value[counter];
    print_message("%-16s edit %d: %u %s, a fresh one %u\n", entries[i].method, kind, (unsigned)more,
                  sl_counter_name(counter), (unsigned)all);
    assert_true(all > 0);
    if (entries[i].most == ANEW) assert_int_equal(more, all);
    else assert_true((double)more <= entries[i].most * (double)all);
    sl_method_destroy(fresh);
    destroy_method(method, scene);
}

static void what_the_table_says_is_kept_is_not_computed_again(void **state) {
    for (size_t i = 0; i < sizeof entries / sizeof *entries; i++)
        for (int kind = 0; kind < ROOM_EDITS; kind++)
            if (entries[i].kinds >> kind & 1u) check_entry(i, (room_edit)kind);
}

/* ---- values that stay ---- */

static void change_some(sl_method *method, sl_scene *scene, edited_room *r) {
    static const room_edit kinds[] = {EDIT_COLOUR, EDIT_CAMERA, EDIT_PLACE, EDIT_CAMERA, EDIT_TRANSFORM,
                                      EDIT_POWER,  EDIT_CAMERA, EDIT_COLOUR, EDIT_CAMERA};
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        change(scene, r, kinds[i]);
        follow(method);
    }
}

/* Tells whether a record is what its place gathers, by the random numbers of one of the pixels: which, it does
 * not know. */
static bool is_its_gather(const sl_splat_state *s, const sl_record *r, sl_record_batch *b) {
    const sl_record_cache *cache = &s->cache[SL_RECEIVES_IRRADIANCE];
    sl_counters counters = {0};
    sl_vec3 normal = sl_scene_geometric_normal(s->scene, r->triangle);
    if (sl_dot(normal, r->normal) < 0.0f) normal = sl_scale(normal, -1.0f);
    *b = (sl_record_batch){.scene = s->scene, .tracer = s->tracer, .gathers = &cache->gathers,
                           .radii = cache->pass.radii, .count = 1};
    for (uint64_t pixel = 0; pixel < 24 * 24; pixel++) {
        b->point[0] = (sl_gather_point){r->position, normal, r->normal, r->triangle,
                                        sl_random_key(cache->pass.seed, pixel)};
        sl_record_batch_gather(b, &counters);
        if (memcmp(&b->record[0].irradiance, &r->irradiance, sizeof r->irradiance) == 0) return true;
    }
    return false;
}

static void every_record_is_its_gather_done_anew(void **state) {
    static sl_record_batch batch;
    sl_error error;
    sl_scene *scene;
    edited_room r = room_at_first(6);
    good(build_room(&r, &scene, &error), &error);
    sl_method *method = finished(scene, "splatting");
    change_some(method, scene, &r);
    const sl_splat_state *s = method->state;
    const sl_record_list *list = &s->cache[SL_RECEIVES_IRRADIANCE].list;
    assert_true(list->count > 50);
    for (size_t i = 0; i < list->count; i += 10) assert_true(is_its_gather(s, &list->records[i], &batch));
    destroy_method(method, scene);
}

/* An older value is shown until its turn comes. */
static void shading_since_the_last_edit_is_what_a_fresh_cache_computes(void **state) {
    sl_error error;
    sl_scene *scene;
    edited_room r = room_at_first(6);
    good(build_room(&r, &scene, &error), &error);
    sl_method *method = finished(scene, "shading-cache");
    change_some(method, scene, &r);
    sl_method *fresh = finished(scene, "shading-cache");
    const sl_shading_state *s = method->state;
    const sl_patches *p = s->patches, *q = ((const sl_shading_state *)fresh->state)->patches;
    size_t same = 0, older = 0, others = 0;
    for (uint32_t v = 0; v < p->vertex_count; v++) {
        const uint32_t w = p->vertex[v].references ? sl_vertex_find(q, p->vertex[v].place) : SL_NO_INDEX;
        if (w == SL_NO_INDEX || !p->vertex[v].evaluated || !q->vertex[w].evaluated) continue;
        const uint32_t object = sl_root_object(p->primitives, p->vertex[v].root);
        if (p->vertex[v].extrapolated || p->vertex[v].is_dense != q->vertex[w].is_dense) continue;
        const bool is_same = memcmp(sl_vertex_value(p, v), sl_vertex_value(q, w), 3 * sizeof(float)) == 0;
        same += is_same;
        older += !is_same && p->vertex[v].evaluated < s->changes.object[object].stale_before;
        others += !is_same && p->vertex[v].evaluated >= s->changes.object[object].stale_before;
    }
    print_message("%zu the same, %zu older, %zu others\n", same, older, others);
    assert_true(same > 200 && others == 0);
    sl_method_destroy(fresh);
    destroy_method(method, scene);
}

static void shine(sl_scene *scene, const float emission[3]) {
    sl_error error;
    sl_scene_edit *edit;
    sl_material_data data = {.size = sizeof data};
    const uint32_t lamp = sl_scene_find_material(scene, "light");
    assert_true(sl_scene_material(scene, lamp, &data));
    memcpy(data.emission, emission, sizeof data.emission);
    good(sl_scene_edit_begin(scene, &edit, &error), &error);
    good(sl_edit_material(edit, lamp, &data, &error), &error);
    good(sl_scene_edit_commit(edit, NULL, &error), &error);
}

static double most_apart(const sl_method *method, const sl_method *fresh) {
    const sl_patches *p = ((const sl_shading_state *)method->state)->patches,
                     *q = ((const sl_shading_state *)fresh->state)->patches;
    double most = 0.0;
    size_t same = 0;
    for (uint32_t v = 0; v < p->vertex_count; v++) {
        const uint32_t w = p->vertex[v].references ? sl_vertex_find(q, p->vertex[v].place) : SL_NO_INDEX;
        if (w == SL_NO_INDEX || !p->vertex[v].evaluated || !q->vertex[w].evaluated ||
            p->vertex[v].extrapolated || p->vertex[v].is_dense != q->vertex[w].is_dense)
            continue;
        for (int c = 0; c < 3; c++) {
            const double a = (double)sl_vertex_value(p, v)[c], b = (double)sl_vertex_value(q, w)[c];
            most = fmax(most, fabs(a - b) / fmax(b, 1e-3));
        }
        same++;
    }
    assert_true(same > 100);
    return most;
}

/* Of another colour no direct light is sampled but at new vertices. */
static void when_a_lamp_alone_has_another_power_nothing_is_sampled_and_values_are_within_rounding(
    void **state) {
    sl_scene *scene = load_scene("scenes/cornell.json");
    sl_method *method = finished(scene, "shading-cache");
    const sl_shading_state *s = method->state;
    const sl_rgb was = scene->materials[sl_scene_find_material(scene, "light") - 1].emission;
    const uint64_t before = sl_method_counters(method)->value[SL_COUNT_POINTS_SHADED];
    shine(scene, (const float[3]){1.7f * was.r, 1.7f * was.g, 1.7f * was.b});
    follow(method);
    assert_int_equal(sl_method_counters(method)->value[SL_COUNT_POINTS_SHADED], before);
    sl_method *fresh = finished(scene, "shading-cache");
    const double apart = most_apart(method, fresh);
    shine(scene, (const float[3]){31.0f, 7.0f, 5.5f});
    good(sl_method_edit(method, 0, NULL), NULL);
    for (uint32_t v = 0; v < s->patches->vertex_count; v++)
        assert_true(!s->patches->vertex[v].references || s->patches->vertex[v].extrapolated ||
                    !sl_vertex_is_stale(s->patches, &s->work, v));
    print_message("values are apart by %.2g of them at most\n", apart);
    assert_true(apart < 1e-5);
    sl_method_destroy(fresh);
    destroy_method(method, scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_the_table_says_is_kept_is_not_computed_again),
        cmocka_unit_test(every_record_is_its_gather_done_anew),
        cmocka_unit_test(shading_since_the_last_edit_is_what_a_fresh_cache_computes),
        cmocka_unit_test(when_a_lamp_alone_has_another_power_nothing_is_sampled_and_values_are_within_rounding),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
