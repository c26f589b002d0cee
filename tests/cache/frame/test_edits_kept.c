/* What methods keep when a scene changes: the table in softlux.h at sl_method_edit(), entry by entry. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "cache/multi_mesh/multi_mesh_internal.h"
#include "edited_room.h"
#include "rendering.h"

enum { SIZE = 24 };

static void good(sl_status status, const sl_error *error) {
    if (status != SL_OK) fail_msg("%s", error->message);
}

static void finish(sl_method *method) {
    sl_error error;
    for (sl_progress p = {0}; !p.done;) good(sl_method_update(method, &p, &error), &error);
}

static sl_method *finished(const sl_scene *scene, const char *name) {
    sl_error error;
    sl_method *method;
    sl_settings settings = small_settings(name, SIZE, SIZE);
    settings.spp = 4;
    settings.light_octree.depth = 4;
    settings.light_octree.photons = 4000;
    settings.gather_size = 16;
    settings.multi_mesh.coarse_depth = 2;
    settings.shading_cache.indirect_samples = 8;
    settings.shading_cache.area_samples = 8;
    good(sl_method_create(scene, &settings, &method, &error), &error);
    finish(method);
    return method;
}

/* Returns what has changed. */
static unsigned change(sl_scene *scene, edited_room *r, room_edit kind) {
    sl_error error;
    sl_scene_edit *e;
    unsigned changes;
    good(sl_scene_edit_begin(scene, &e, &error), &error);
    good(edit_room(r, kind, e, &error), &error);
    good(sl_scene_edit_commit(e, &changes, &error), &error);
    return changes;
}

static void follow(sl_method *method) {
    sl_error error;
    good(sl_method_edit(method, 0, &error), &error);
    finish(method);
}

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
    {"light-octree", LIGHT, SL_COUNT_PHOTONS_EMITTED, ANEW},
    {"multi-mesh", CAMERA, SL_COUNT_LIGHT_SAMPLES, 0.1},
    {"multi-mesh", CAMERA, SL_COUNT_COARSE_SAMPLES, 0.0},
    {"multi-mesh", CAMERA, SL_COUNT_INDIRECT_SAMPLES, 0.3},
    {"multi-mesh", COLOURS, SL_COUNT_LIGHT_SAMPLES, 0.05},
    {"multi-mesh", 1u << EDIT_POWER, SL_COUNT_LIGHT_SAMPLES, 0.2}, /* the coarse mesh's, by other rays */
    {"multi-mesh", 1u << EDIT_PLACE | 1u << EDIT_TRANSFORM, SL_COUNT_LIGHT_SAMPLES, ANEW},
    {"shading-cache", CAMERA, SL_COUNT_POINTS_SHADED, 0.3},
    {"shading-cache", LIGHT & ~(1u << EDIT_SKY), SL_COUNT_SPLITS, 0.2},
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
    sl_method_destroy(method);
    sl_scene_destroy(scene);
}

static void what_the_table_says_is_kept_is_not_computed_again(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof entries / sizeof *entries; i++)
        for (int kind = 0; kind < ROOM_EDITS; kind++)
            if (entries[i].kinds >> kind & 1u) check_entry(i, (room_edit)kind);
}

/* ---- a mesh for each light ---- */

static const sl_multi_mesh_state *meshes_of(const sl_method *method) { return method->state; }

/* Returns vertices of a light's mesh that are sampled. */
static size_t sampled(const sl_patches *mesh) {
    size_t count = 0;
    for (uint32_t v = 0; v < mesh->vertex_count; v++) count += sl_mesh_is_sampled(mesh, v);
    return count;
}

/* All that a mesh has of a light is what a method has there that is created now, bit for bit. */
static size_t assert_same_where_both_are(const sl_patches *mesh, const sl_patches *fresh) {
    size_t both = 0;
    for (uint32_t v = 0; v < mesh->vertex_count; v++) {
        const uint32_t of = sl_vertex_find(fresh, mesh->vertex[v].place);
        if (!sl_mesh_is_sampled(mesh, v) || !sl_mesh_is_sampled(fresh, of)) continue;
        assert_int_equal(sl_mesh_state(mesh, v), sl_mesh_state(fresh, of));
        assert_memory_equal(sl_vertex_value(mesh, v), sl_vertex_value(fresh, of), sizeof(float));
        both++;
    }
    return both;
}

static void light_in_other_colours_is_not_sampled_again(void **state) {
    (void)state;
    static const room_edit kinds[] = {EDIT_COLOUR, EDIT_LAMP, EDIT_POWER, EDIT_COLOUR, EDIT_POWER, EDIT_LAMP};
    sl_error error;
    sl_scene *scene;
    edited_room r = room_at_first(7);
    good(build_room(&r, &scene, &error), &error);
    sl_method *method = finished(scene, "multi-mesh");
    const sl_irradiance_meshes *meshes = meshes_of(method)->irradiance;
    const size_t lights = meshes_of(method)->lights->count;
    size_t first = 0, last = 0, both = 0;
    for (size_t l = 0; l < lights; l++) first += sampled(sl_irradiance_mesh(meshes, l));
    for (int i = 0; i < 6; i++) {
        const unsigned others = ~(unsigned)(SL_CHANGED_POWER | SL_CHANGED_MATERIALS);
        assert_int_equal(change(scene, &r, kinds[i]) & others, 0);
        follow(method);
    }
    assert_ptr_equal(meshes_of(method)->irradiance, meshes);
    sl_method *fresh = finished(scene, "multi-mesh");
    for (size_t l = 0; l < lights; l++) {
        const sl_patches *mesh = sl_irradiance_mesh(meshes, l);
        last += sampled(mesh);
        both += assert_same_where_both_are(mesh, sl_irradiance_mesh(meshes_of(fresh)->irradiance, l));
    }
    print_message("%u samples, %u after six edits, %u of a fresh one's\n", (unsigned)first, (unsigned)last,
                  (unsigned)both);
    assert_true(both > 100 && last < 2 * first);
    sl_method_destroy(fresh);
    sl_method_destroy(method);
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_the_table_says_is_kept_is_not_computed_again),
        cmocka_unit_test(light_in_other_colours_is_not_sampled_again),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
