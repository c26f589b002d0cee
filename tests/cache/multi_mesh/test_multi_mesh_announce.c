/* What an observer of multi-mesh caching is told, and what a stopwatch is. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <string.h>

#include "cache/multi_mesh/multi_mesh_internal.h"
#include "rendering.h"

typedef struct listener {
    size_t passes, pictures, edges;
    bool ids, merge;
} listener;

static void listen(void *context, const sl_pass *pass) {
    listener *l = context;
    l->passes++;
    l->pictures += pass->buffer != NULL;
    l->edges += !strncmp(pass->name, "edges of", 8);
    l->ids |= !strncmp(pass->name, "identifiers", 11);
    l->merge |= !strcmp(pass->name, "merge");
}

static sl_image *observed(const sl_scene *scene, bool names_alone, listener *l) {
    const sl_observer observer = {l, listen};
    sl_settings settings = small_settings("multi-mesh", 32, 32);
    sl_transport transport;
    sl_progress progress = {0};
    sl_image *image;
    void *state;
    *l = (listener){0};
    settings.quality = SL_QUALITY_DRAFT;
    settings.observer = &observer;
    sl_multi_mesh_complete(&settings);
    sl_multi_mesh_transport(&settings, &transport);
    assert_int_equal(sl_multi_mesh_method.create(scene, &settings, &transport, &state, NULL), SL_OK);
    ((sl_multi_mesh_state *)state)->announcer.names_alone = names_alone;
    while (!progress.done) assert_int_equal(sl_multi_mesh_method.update(state, &progress, NULL), SL_OK);
    assert_int_equal(sl_multi_mesh_method.resolve(state, &image, NULL), SL_OK);
    sl_multi_mesh_method.destroy(state);
    return image;
}

/* Edges of meshes, one gather and one light sample are made for whoever looks at them: who times passes wants
 * none of it. */
static void a_stopwatch_is_told_of_passes_and_nothing_is_made_for_it(void **state) {
    (void)state;
    sl_scene *scene = load_scene("scenes/cornell.json");
    listener looks, times;
    sl_image *a = observed(scene, false, &looks), *b = observed(scene, true, &times);
    assert_true(looks.ids && looks.merge && looks.edges > 0 && looks.pictures > 0);
    assert_true(times.ids && times.merge);
    assert_int_equal(times.edges, 0);
    assert_int_equal(times.pictures, 0);
    assert_true(times.passes < looks.passes);
    assert_true(same_picture(a, b));
    sl_image_destroy(a);
    sl_image_destroy(b);
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_stopwatch_is_told_of_passes_and_nothing_is_made_for_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
