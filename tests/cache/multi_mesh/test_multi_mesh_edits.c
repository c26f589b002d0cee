/* A mesh for each light: what is known of it does not depend on colours. */
#include "unit_test.h"
#include "cache/multi_mesh/multi_mesh_internal.h"
#include "edited_methods.h"

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
    static const room_edit kinds[] = {EDIT_COLOUR, EDIT_LAMP, EDIT_POWER, EDIT_COLOUR, EDIT_POWER, EDIT_LAMP};
    sl_error error;
    sl_scene *scene;
    edited_room r = room_at_first(7);
    good(build_room(&r, &scene, &error), &error);
    sl_method *method = finished(scene, "multi-mesh");
    const sl_irradiance_meshes *meshes = meshes_of(method)->irradiance;
    const size_t lights = meshes_of(method)->now.lights->count;
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
    destroy_method(method, scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(light_in_other_colours_is_not_sampled_again)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
