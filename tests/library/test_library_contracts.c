/* Promises of softlux.h for calls that ought not to be made: every function, every NULL, every number out of
 * range, every order but the right one. The status is the one that its comment names, one line says why (or
 * no one asked), and what was to be made is NULL, 0 or as it was. Run with sanitizers, too, which tell of
 * what leaks. Files that are damaged and memory that ends are elsewhere: test_image_damage,
 * test_every_allocation. */
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "unit_test.h"
#include "least_settings.h"
#include "rendering.h"
#include "scene_files.h"

#include "failing_memory.h"

static void assert_one_line(const sl_error *error, sl_status status) {
    size_t length = strlen(error->message);
    assert_int_equal(error->status, status);
    assert_true(length > 10 && length < sizeof error->message - 1);
    assert_null(strchr(error->message, '\n'));
}

/* `call` says `error` where it hands on where to complain; it may be nowhere. */
#define REFUSED(wanted, call)                \
    do {                                     \
        sl_error said = {SL_OK, ""}, *error = &said; \
        assert_int_equal(call, wanted);      \
        assert_one_line(&said, wanted);      \
        error = NULL;                        \
        assert_int_equal(call, wanted);      \
    } while (0)
#define USAGE(call) REFUSED(SL_ERROR_USAGE, call)
#define INPUT(call) REFUSED(SL_ERROR_INPUT, call)

enum { SIDE = 6 };
static const char box[] = "scenes/cornell.json";
static const char *const methods[] = {
    "splatting", "direct-radiance", "light-octree", "multi-mesh", "shading-cache", "path", "bidirectional"};
enum { METHODS = sizeof methods / sizeof methods[0] };

static sl_image *picture(int width, int height, int channels, const char *const *names) {
    sl_image *image;
    assert_int_equal(sl_image_create(width, height, channels, names, &image, NULL), SL_OK);
    return image;
}

static sl_method *method_of(const sl_scene *scene, const char *name) {
    const sl_settings settings = least_settings(name, SIDE, SIDE);
    return created_method(scene, &settings);
}

static void update_to_the_end(sl_method *method) { sl_image_destroy(finished_picture(method)); }

static bool all_zero(const void *data, size_t bytes) {
    const unsigned char *at = data;
    for (size_t i = 0; i < bytes; i++) {
        if (at[i]) return false;
    }
    return true;
}

/* Memory that no result is made of: what ought to be made NULL or 0 was. */
static void *const anything = (void *)(uintptr_t)0x5a5a5a5a5a5a5a40u;

/* ---- names and numbers ----------------------------------------------------------------------- */

static void nothing_can_be_destroyed(void **state) {
    sl_counters counters;
    memset(&counters, 1, sizeof counters);
    sl_image_destroy(NULL);
    sl_scene_destroy(NULL);
    sl_method_destroy(NULL);
    sl_explanation_destroy(NULL);
    sl_error_probe_destroy(NULL);
    sl_live_stop(NULL, NULL);
    sl_live_stop(NULL, &counters);
    assert_true(all_zero(&counters, sizeof counters));
}

/* A program that was built with an earlier header made room for just this. */
static void structs_that_callers_make_room_for_keep_their_sizes(void **state) {
    assert_string_equal(sl_version(), SL_VERSION);
    assert_int_equal(sizeof(sl_error), 1028);
    assert_int_equal(sizeof(sl_counters), 768);
    assert_int_equal(sizeof(sl_metadatum), 72);
    assert_int_equal(sizeof(sl_tone), 12);
    assert_int_equal(sizeof(sl_comparison), 184);
    assert_int_equal(sizeof(sl_compare_options), 80);
    assert_int_equal(sizeof(sl_viewpoint), 76);
    assert_int_equal(sizeof(sl_load_options), 80);
    assert_int_equal(sizeof(sl_mark), 44);
    assert_int_equal(sizeof(sl_observer), 16);
    assert_int_equal(sizeof(sl_progress), 56);
    assert_int_equal(sizeof(sl_explanation_term), 88);
    assert_int_equal(sizeof(sl_live_state), 136);
    assert_int_equal(sizeof(sl_error_estimate), 152);
}

/* ---- scenes ---------------------------------------------------------------------------------- */

static const char moving[] =
    "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\"}], \"camera\": {\"eye\": [0, 0, 5], \"target\": "
    "[0, 0, 0], \"fov_deg\": 50, \"keyframes\": [{\"time\": 0, \"eye\": [0, 0, 5], \"target\": [0, 0, 0], "
    "\"fov_deg\": 50}, {\"time\": 2, \"eye\": [0, 0, -5], \"target\": [0, 0, 0], \"fov_deg\": 50}]}}";
static const char triangle[] = "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n";

static void a_scene_moves_to_times_at_which_it_can_be_seen(void **state) {
    sl_scene *scene = scene_from_text(moving, triangle);
    const uint64_t still = sl_scene_hash(scene);
    const double no_times[] = {NAN, INFINITY, -INFINITY};
    unsigned changes = 99;
    USAGE(sl_scene_set_time(NULL, 0.0, &changes, error));
    assert_int_equal(changes, 0);
    for (int i = 0; i < 3; i++) USAGE(sl_scene_set_time(scene, no_times[i], &changes, error));
    changes = 99;
    INPUT(sl_scene_set_time(scene, 1.0, &changes, error)); /* half way the eye is at its target */
    assert_int_equal(changes, 0);
    assert_true(sl_scene_hash(scene) == still);
    assert_int_equal(sl_scene_set_time(scene, 1e308, NULL, NULL), SL_OK);
    assert_int_equal(sl_scene_set_time(scene, -1e308, &changes, NULL), SL_OK);
    assert_int_equal(changes, SL_CHANGED_CAMERA);
    assert_true(sl_scene_hash(scene) == still);
    sl_scene_destroy(scene);
}

static const float eye[3] = {0, 0, 4}, target[3] = {0, 0, 0}, up[3] = {0, 1, 0};

static void a_camera_has_a_frame_and_a_field_of_view(void **state) {
    sl_scene *scene = load_scene(box);
    const uint64_t still = sl_scene_hash(scene);
    const float zero[3] = {0, 0, 0}, along[3] = {0, 0, -2}, none[3] = {0, NAN, 0},
                endless[3] = {0, INFINITY, 0};
    const float no_angles[] = {0.0f, -1.0f, NAN, INFINITY, 3.1415927f};
    USAGE(sl_scene_set_camera(NULL, eye, target, up, 1.0f, error));
    USAGE(sl_scene_set_camera(scene, NULL, target, up, 1.0f, error));
    USAGE(sl_scene_set_camera(scene, eye, NULL, up, 1.0f, error));
    USAGE(sl_scene_set_camera(scene, eye, target, NULL, 1.0f, error));
    USAGE(sl_scene_set_camera(scene, eye, eye, up, 1.0f, error));
    USAGE(sl_scene_set_camera(scene, eye, target, zero, 1.0f, error));
    USAGE(sl_scene_set_camera(scene, eye, target, along, 1.0f, error));
    USAGE(sl_scene_set_camera(scene, none, target, up, 1.0f, error));
    USAGE(sl_scene_set_camera(scene, eye, endless, up, 1.0f, error));
    USAGE(sl_scene_set_camera(scene, eye, target, none, 1.0f, error));
    for (int i = 0; i < 5; i++) USAGE(sl_scene_set_camera(scene, eye, target, up, no_angles[i], error));
    assert_true(sl_scene_hash(scene) == still);
    sl_scene_destroy(scene);
}

/* A field of view of next to nothing, and one of next to everything. */
static void every_camera_that_is_taken_gives_numbers(void **state) {
    const float angles[] = {1e-40f, 1e-6f, 3.1415925f};
    sl_scene *scene = load_scene(box);
    for (size_t m = 0; m < METHODS; m++) {
        for (int a = 0; a < 3; a++) {
            const float here[3] = {278, 273, -800}, there[3] = {278, 273, 0};
            const sl_settings settings = least_settings(methods[m], SIDE, SIDE);
            assert_int_equal(sl_scene_set_camera(scene, here, there, up, angles[a], NULL), SL_OK);
            sl_image *image = render(scene, &settings, NULL);
            for (int i = 0; i < 3 * SIDE * SIDE; i++) {
                const float value = image->planes[i];
                if (!isfinite(value) || value < 0.0f)
                    fail_msg("%s at %g radians: %g", methods[m], (double)angles[a], (double)value);
            }
            sl_image_destroy(image);
        }
    }
    sl_scene_destroy(scene);
}

/* ---- settings -------------------------------------------------------------------------------- */

/* By everything that takes settings. */
static void assert_refused(sl_scene *scene, const sl_settings *settings, sl_status wanted) {
    sl_method *method = anything;
    sl_error_probe *probe = anything;
    sl_live *live = anything;
    char *plan = anything;
    uint64_t bytes = 7;
    REFUSED(wanted, sl_method_create(scene, settings, &method, error));
    REFUSED(wanted, sl_method_plan(scene, settings, &plan, error));
    REFUSED(wanted, sl_live_start(scene, settings, &live, error));
    if (!settings->memory_bytes) REFUSED(wanted, sl_method_memory_need(scene, settings, &bytes, error));
    if (!settings->memory_bytes) REFUSED(wanted, sl_error_probe_create(scene, settings, &probe, error));
    assert_true(!method && !plan && !live && (settings->memory_bytes || (!probe && bytes == 0)));
}

static void assert_not_settable(const sl_setting *setting, const char *value) {
    sl_settings *settings;
    char before[64], after[64];
    assert_int_equal(sl_settings_create(&settings, NULL), SL_OK);
    assert_int_equal(sl_settings_get(settings, setting->name, before, sizeof before, NULL), SL_OK);
    if (sl_settings_set(settings, setting->name, value, NULL) != SL_ERROR_USAGE)
        fail_msg("%s may be '%s'", setting->name, value);
    assert_int_equal(sl_settings_get(settings, setting->name, after, sizeof after, NULL), SL_OK);
    assert_string_equal(before, after);
    sl_settings_destroy(settings);
}

static void no_option_takes_a_value_that_is_none_or_out_of_its_range(void **state) {
    static const char *const never[] = {"", " ", "x", "-1", "nan", "1x", "1e999"};
    const sl_setting *s;
    for (size_t i = 0; (s = sl_setting_at(i)) != NULL; i++) {
        char text[32];
        for (size_t n = 0; n < sizeof never / sizeof *never; n++) assert_not_settable(s, never[n]);
        if (!(s->minimum < s->maximum) || !*s->unit) continue;
        snprintf(text, sizeof text, "%.17g", s->minimum - 0.001 * fabs(s->minimum) - (s->minimum == 0.0));
        assert_not_settable(s, text);
        snprintf(text, sizeof text, "%.0f", floor(s->maximum * 1.001 + 1.0));
        assert_not_settable(s, text);
    }
}

/* Fields set by the library's own callers are checked like that, too. */
static void fields_out_of_range_are_refused_by_whatever_takes_them(void **state) {
    sl_scene *scene = load_scene(box);
    static const double wrong[] = {0.0009, 2.001, NAN, INFINITY, -1.0};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        sl_settings settings = least_settings("splatting", SIDE, SIDE);
        settings.accuracy = wrong[i];
        assert_refused(scene, &settings, SL_ERROR_USAGE);
    }
    static const int sizes[] = {-2, 2, 5, 1026};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        sl_settings settings = least_settings("splatting", SIDE, SIDE);
        settings.gather_size = sizes[i];
        assert_refused(scene, &settings, SL_ERROR_USAGE);
    }
    sl_scene_destroy(scene);
}

static void assert_rendered_with(const sl_scene *scene, const char *name, const sl_setting *setting,
                                 const char *value) {
    sl_settings settings = least_settings(name, SIDE, SIDE);
    sl_method *method = NULL;
    sl_image *image = NULL;
    sl_progress progress;
    sl_error error = {SL_OK, ""};
    sl_status status = sl_settings_set(&settings, setting->name, value, &error);
    if (status == SL_OK) status = sl_method_create(scene, &settings, &method, &error);
    for (int k = 0; k < 2 && status == SL_OK; k++) status = sl_method_update(method, &progress, &error);
    if (status == SL_OK) status = sl_method_resolve(method, &image, &error);
    if (status != SL_OK) fail_msg("%s: %s=%s: %s", name, setting->name, value, error.message);
    sl_image_destroy(image);
    sl_method_destroy(method);
}

static void assert_rendered_by_its_methods(const sl_scene *scene, const sl_setting *setting,
                                           const char *value) {
    for (size_t m = 0; m < METHODS; m++) {
        if (!*setting->methods || strstr(setting->methods, methods[m]))
            assert_rendered_with(scene, methods[m], setting, value);
    }
}

static void assert_choices_are_taken(const sl_scene *scene, const sl_setting *setting) {
    char choices[128], *rest = NULL;
    snprintf(choices, sizeof choices, "%s", setting->unit);
    for (char *c = strtok_r(choices, "|", &rest); c; c = strtok_r(NULL, "|", &rest))
        assert_rendered_by_its_methods(scene, setting, c);
}

/* Of numbers the least, of what there are a few of all, and every choice. */
static void settings_within_their_range_are_taken_whole(void **state) {
    enum { A_FEW = 14 };
    const sl_setting *s;
    sl_scene *scene = load_scene(box);
    for (size_t i = 0; (s = sl_setting_at(i)) != NULL; i++) {
        char value[32];
        if (strcmp(s->name, "size") == 0 || strcmp(s->name, "memory") == 0)
            continue;
        if (strchr(s->unit, '|')) assert_choices_are_taken(scene, s);
        else if (!*s->unit) assert_rendered_by_its_methods(scene, s, "1");
        for (double n = s->minimum; *s->unit && s->minimum >= 1.0 && n <= s->maximum; n++) {
            if (n > s->minimum && s->maximum > A_FEW) break;
            snprintf(value, sizeof value, "%.0f", n);
            assert_rendered_by_its_methods(scene, s, value);
        }
    }
    sl_scene_destroy(scene);
}

static void methods_and_light_paths_that_do_not_exist_are_refused(void **state) {
    sl_scene *scene = load_scene(box);
    static const char *const names[] = {NULL, "", "Path", "path ", "splatting, path"};
    static const char *const transports[] = {
        "", "matched:", "matched:nothing", "two-bounce",
        "matched:path matched:path matched:path matched:path matched:path"};
    for (int i = 0; i < 5; i++) {
        sl_settings settings = least_settings(names[i], SIDE, SIDE);
        assert_refused(scene, &settings, SL_ERROR_USAGE);
        settings = least_settings("path", SIDE, SIDE);
        settings.transport = transports[i];
        assert_refused(scene, &settings, SL_ERROR_USAGE);
    }
    sl_settings settings = least_settings("splatting", SIDE, SIDE);
    settings.transport = "full"; /* only the reference tracers take another than their own */
    assert_refused(scene, &settings, SL_ERROR_USAGE);
    settings = least_settings("splatting", SIDE, SIDE);
    settings.memory_bytes = 1;
    assert_refused(scene, &settings, SL_ERROR_RESOURCES);
    settings = least_settings("path", SIDE, 0);
    assert_refused(scene, &settings, SL_ERROR_USAGE);
    sl_scene_destroy(scene);
}

static void what_takes_settings_takes_no_null(void **state) {
    sl_scene *scene = load_scene(box);
    const sl_settings settings = least_settings("path", SIDE, SIDE);
    sl_method *method = anything;
    sl_error_probe *probe = anything;
    sl_live *live = anything;
    char *plan = anything;
    uint64_t bytes = 7;
    USAGE(sl_method_create(scene, &settings, NULL, error));
    USAGE(sl_method_create(NULL, &settings, &method, error));
    USAGE(sl_method_create(scene, NULL, &method, error));
    USAGE(sl_method_plan(scene, &settings, NULL, error));
    USAGE(sl_method_plan(NULL, &settings, &plan, error));
    USAGE(sl_method_plan(scene, NULL, &plan, error));
    USAGE(sl_method_memory_need(scene, &settings, NULL, error));
    USAGE(sl_method_memory_need(NULL, &settings, &bytes, error));
    USAGE(sl_method_memory_need(scene, NULL, &bytes, error));
    USAGE(sl_live_start(scene, &settings, NULL, error));
    USAGE(sl_live_start(NULL, &settings, &live, error));
    USAGE(sl_live_start(scene, NULL, &live, error));
    USAGE(sl_error_probe_create(scene, &settings, NULL, error));
    USAGE(sl_error_probe_create(NULL, &settings, &probe, error));
    USAGE(sl_error_probe_create(scene, NULL, &probe, error));
    assert_true(!method && !plan && !bytes && !live && !probe);
    sl_scene_destroy(scene);
}

/* ---- methods --------------------------------------------------------------------------------- */

static void a_method_takes_no_null(void **state) {
    sl_scene *scene = load_scene(box);
    sl_method *method = method_of(scene, "splatting");
    sl_progress progress = {.batches = 77};
    sl_image *image = anything;
    sl_explanation *explanation = anything;
    USAGE(sl_method_update(NULL, &progress, error));
    USAGE(sl_method_update(method, NULL, error));
    assert_true(progress.batches == 77);
    USAGE(sl_method_rate(NULL, 100.0, error));
    USAGE(sl_method_resolve(NULL, &image, error));
    USAGE(sl_method_resolve(method, NULL, error));
    assert_null(image);
    USAGE(sl_method_edit(NULL, SL_CHANGED_CAMERA, error));
    USAGE(sl_method_edit(method, 128, error));
    USAGE(sl_method_edit(method, UINT_MAX, error));
    USAGE(sl_method_save(NULL, "a", error));
    USAGE(sl_method_save(method, NULL, error));
    USAGE(sl_method_load(NULL, "a", error));
    USAGE(sl_method_load(method, NULL, error));
    image = picture(SIDE, SIDE, 3, NULL);
    USAGE(sl_method_explanation(NULL, image, 0, 0, &explanation, error));
    USAGE(sl_method_explanation(method, NULL, 0, 0, &explanation, error));
    USAGE(sl_method_explanation(method, image, 0, 0, NULL, error));
    assert_null(explanation);
    sl_image_destroy(image);
    destroy_method(method, scene);
}

static void a_explanation_is_of_a_pixel_of_the_last_picture(void **state) {
    sl_scene *scene = load_scene(box);
    for (size_t m = 0; m < METHODS; m++) {
        sl_method *method = method_of(scene, methods[m]);
        sl_explanation *explanation = anything;
        sl_image *image, *other = picture(SIDE + 60, SIDE + 60, 3, NULL),
                         *same = picture(SIDE, SIDE, 3, NULL);
        USAGE(sl_method_explanation(method, same, 1, 1, &explanation, error)); /* nothing has been resolved */
        assert_null(explanation);
        update_to_the_end(method);
        image = resolved_picture(method);
        /* a pixel of that one, and of none that there is */
        USAGE(sl_method_explanation(method, other, SIDE + 50, SIDE + 50, &explanation, error));
        USAGE(sl_method_explanation(method, same, 1, 1, &explanation, error)); /* nobody's */
        USAGE(sl_method_explanation(method, image, SIDE, 0, &explanation, error));
        USAGE(sl_method_explanation(method, image, 0, INT_MAX, &explanation, error));
        USAGE(sl_method_explanation(method, image, INT_MIN, 0, &explanation, error));
        bool tells = strcmp(methods[m], "path") != 0 && strcmp(methods[m], "bidirectional") != 0;
        if (tells) assert_int_equal(sl_method_explanation(method, image, 1, 1, &explanation, NULL), SL_OK);
        sl_explanation_destroy(explanation);
        assert_int_equal(sl_method_edit(method, SL_CHANGED_CAMERA, NULL), SL_OK);
        /* which is no longer the last */
        USAGE(sl_method_explanation(method, image, 1, 1, &explanation, error));
        assert_null(explanation);
        destroy_pictures(image, other);
        sl_image_destroy(same);
        sl_method_destroy(method);
    }
    sl_scene_destroy(scene);
}

/* It would be a picture of two scenes. */
static void nothing_is_asked_of_a_method_that_does_not_know_what_has_changed(void **state) {
    sl_scene *scene = load_scene("scenes/moving-ball.json");
    for (size_t m = 0; m < METHODS; m++) {
        assert_int_equal(sl_scene_set_time(scene, 0.0, NULL, NULL), SL_OK);
        sl_method *method = method_of(scene, methods[m]);
        sl_progress progress;
        sl_explanation *explanation;
        unsigned changes;
        assert_int_equal(sl_method_update(method, &progress, NULL), SL_OK);
        sl_image *image = resolved_picture(method);
        assert_int_equal(sl_scene_set_time(scene, 1.0, &changes, NULL), SL_OK);
        USAGE(sl_method_explanation(method, image, 1, 1, &explanation, error));
        sl_image_destroy(image);
        USAGE(sl_method_update(method, &progress, error));
        USAGE(sl_method_resolve(method, &image, error));
        assert_null(image);
        assert_int_equal(sl_method_edit(method, changes, NULL), SL_OK);
        assert_int_equal(sl_scene_set_time(scene, 1.0, NULL, NULL), SL_OK); /* where it is */
        assert_int_equal(sl_method_update(method, &progress, NULL), SL_OK);
        sl_method_destroy(method);
    }
    sl_scene_destroy(scene);
}

static void caches_go_to_files_and_come_from_files_of_the_kind(void **state) {
    sl_scene *scene = load_scene(box);
    for (size_t m = 0; m < METHODS; m++) {
        sl_method *method = method_of(scene, methods[m]);
        if (sl_method_keeps_cache(method)) {
            REFUSED(SL_ERROR_OUTPUT, sl_method_save(method, "", error));
            REFUSED(SL_ERROR_OUTPUT, sl_method_save(method, "/nonexistent/cache", error));
            INPUT(sl_method_load(method, "", error));
            INPUT(sl_method_load(method, "/nonexistent/cache", error));
            INPUT(sl_method_load(method, box, error));
        } else {
            USAGE(sl_method_save(method, "cache", error));
            USAGE(sl_method_load(method, "cache", error));
        }
        update_to_the_end(method);
        sl_method_destroy(method);
    }
    sl_scene_destroy(scene);
}

/* Of all methods: what there is to say about it afterwards is no more than that. */
static void after_a_failed_update_a_method_can_only_be_destroyed(void **state) {
    sl_scene *scene = load_scene(box);
    int failed = 0;
    for (size_t m = 0; m < METHODS; m++) {
        sl_method *method = method_of(scene, methods[m]);
        sl_progress progress = {.batches = 77};
        sl_image *image = anything;
        long held = blocks_held;
        allocations_left = 0;
        sl_status status = sl_method_update(method, &progress, NULL);
        allocations_left = -1;
        if (status != SL_OK) {
            failed++;
            assert_int_equal(status, SL_ERROR_RESOURCES);
            assert_true(progress.batches == 77 && blocks_held <= held);
            USAGE(sl_method_update(method, &progress, error));
            USAGE(sl_method_resolve(method, &image, error));
            USAGE(sl_method_edit(method, SL_CHANGED_CAMERA, error));
            USAGE(sl_method_save(method, "cache", error));
            USAGE(sl_method_load(method, "cache", error));
            assert_true(progress.batches == 77 && !image);
        }
        sl_method_destroy(method);
    }
    assert_true(failed >= 3);
    sl_scene_destroy(scene);
}

/* The tracers hold their rays' hierarchy, and the others more than that: nobody follows objects without
 * memory. */
static void after_a_failed_edit_another_one_makes_all_anew(void **state) {
    sl_scene *scene = load_scene(box);
    for (size_t m = 0; m < METHODS; m++) {
        sl_method *method = method_of(scene, methods[m]);
        sl_progress progress;
        sl_image *none = anything, *after;
        update_to_the_end(method);
        sl_image *before = resolved_picture(method);
        allocations_left = 0;
        sl_status status = sl_method_edit(method, SL_CHANGED_OBJECTS, NULL);
        /* direct radiance mapping puts it off until then */
        if (status == SL_OK) status = sl_method_update(method, &progress, NULL);
        allocations_left = -1;
        assert_int_equal(status, SL_ERROR_RESOURCES);
        USAGE(sl_method_update(method, &progress, error));
        USAGE(sl_method_resolve(method, &none, error));
        assert_null(none);
        if (strcmp(methods[m], "direct-radiance") != 0) {
            assert_int_equal(sl_method_edit(method, SL_CHANGED_CAMERA, NULL), SL_OK);
            update_to_the_end(method);
            after = resolved_picture(method);
            /* which goes on from where it was */
            if (strcmp(methods[m], "shading-cache") != 0) assert_true(same_picture(before, after));
            sl_image_destroy(after);
        }
        sl_image_destroy(before);
        sl_method_destroy(method);
    }
    sl_scene_destroy(scene);
}

/* ---- live ------------------------------------------------------------------------------------ */

static void a_show_goes_on_after_what_it_refuses(void **state) {
    sl_scene *scene = scene_from_text(moving, triangle);
    const char *const names[] = {"shading-cache", "path"};
    for (int m = 0; m < 2; m++) {
        sl_settings settings = least_settings(names[m], SIDE, SIDE);
        const float none[3] = {0, NAN, 0};
        const sl_image *frame = anything;
        sl_live_state shown;
        sl_live *live;
        assert_int_equal(sl_live_start(scene, &settings, &live, NULL), SL_OK);
        USAGE(sl_live_frame(NULL, &frame, &shown, error));
        assert_null(frame);
        USAGE(sl_live_frame(live, NULL, &shown, error));
        USAGE(sl_live_move(NULL, 0.0, error));
        USAGE(sl_live_move(live, NAN, error));
        USAGE(sl_live_move(live, INFINITY, error));
        INPUT(sl_live_move(live, 1.0, error)); /* the eye at its target */
        USAGE(sl_live_rate(NULL, 100.0, error));
        USAGE(sl_live_rate(live, 0.5, error));
        USAGE(sl_live_rate(live, NAN, error));
        assert_int_equal(sl_live_log(NULL, NULL, 0), 0);
        USAGE(sl_live_look(NULL, eye, target, up, 1.0f, error));
        USAGE(sl_live_look(live, NULL, target, up, 1.0f, error));
        USAGE(sl_live_look(live, eye, NULL, up, 1.0f, error));
        USAGE(sl_live_look(live, eye, target, NULL, 1.0f, error));
        USAGE(sl_live_look(live, eye, eye, up, 1.0f, error));
        USAGE(sl_live_look(live, none, target, up, 1.0f, error));
        USAGE(sl_live_look(live, eye, target, up, 0.0f, error));
        assert_int_equal(sl_live_frame(live, &frame, NULL, NULL), SL_OK);
        assert_int_equal(sl_live_look(live, eye, target, up, 1.0f, NULL), SL_OK);
        assert_int_equal(sl_live_frame(live, &frame, &shown, NULL), SL_OK);
        assert_true(frame && shown.frames == 2);
        sl_counters counters;
        sl_live_stop(live, &counters);
        assert_int_equal(counters.value[SL_COUNT_FRAMES_DISPLAYED], 2);
    }
    sl_scene_destroy(scene);
}

/* ---- errors ---------------------------------------------------------------------------------- */

static void an_error_is_of_a_picture_that_the_probes_are_of(void **state) {
    static const char *const depth[] = {"Z"};
    sl_scene *scene = load_scene(box);
    const sl_settings settings = least_settings("path", SIDE, SIDE);
    sl_image *image = render(scene, &settings, NULL), *wide = picture(SIDE + 1, SIDE, 3, NULL),
             *plain = picture(SIDE, SIDE, 1, depth);
    const double no_errors[] = {0.0, -1.0, NAN};
    sl_error_probe *probe;
    sl_error_estimate e;
    assert_int_equal(sl_error_probe_create(scene, &settings, &probe, NULL), SL_OK);
#define USAGE_AND_ZERO(call) memset(&e, 1, sizeof e); USAGE(call); assert_true(all_zero(&e, sizeof e))
    USAGE_AND_ZERO(sl_error_probe_estimate(NULL, image, 4, 1, &e, error));
    USAGE_AND_ZERO(sl_error_probe_estimate(probe, NULL, 4, 1, &e, error));
    USAGE(sl_error_probe_estimate(probe, image, 4, 1, NULL, error));
    USAGE_AND_ZERO(sl_error_probe_judge(NULL, image, 0.1, 0, &e, error));
    USAGE_AND_ZERO(sl_error_probe_judge(probe, NULL, 0.1, 0, &e, error));
    USAGE(sl_error_probe_judge(probe, image, 0.1, 0, NULL, error));
    USAGE_AND_ZERO(sl_error_estimate_from_halves(NULL, NULL, &e, error));
    USAGE(sl_error_estimate_from_halves(image, NULL, NULL, error));
    USAGE(sl_error_probe_estimate(probe, image, 0, 1, &e, error));
    USAGE(sl_error_probe_estimate(probe, image, 1, 0, &e, error));
    for (int i = 0; i < 3; i++) USAGE(sl_error_probe_judge(probe, image, no_errors[i], 0, &e, error));
    memset(&e, 1, sizeof e);
    INPUT(sl_error_probe_estimate(probe, wide, 4, 1, &e, error));
    assert_true(all_zero(&e, sizeof e));
    INPUT(sl_error_probe_estimate(probe, plain, 4, 1, &e, error));
    INPUT(sl_error_probe_judge(probe, wide, 0.1, 0, &e, error));
    INPUT(sl_error_estimate_from_halves(wide, NULL, &e, error));
    INPUT(sl_error_estimate_from_halves(plain, NULL, &e, error));
    assert_int_equal(sl_error_probe_counters(probe)->value[SL_COUNT_SAMPLES], 0);
    assert_int_equal(sl_error_probe_estimate(probe, image, UINT64_MAX, 1, &e, NULL), SL_OK); /* every pixel */
    assert_int_equal(e.probes, SIDE * SIDE);
    assert_int_equal(sl_error_probe_estimate(probe, image, SIDE * SIDE, 1, &e, NULL), SL_OK);
    assert_int_equal(e.probes, SIDE * SIDE);
    destroy_pictures(image, wide);
    sl_image_destroy(plain);
    sl_error_probe_destroy(probe);
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_can_be_destroyed),
        cmocka_unit_test(structs_that_callers_make_room_for_keep_their_sizes),
        cmocka_unit_test(a_scene_moves_to_times_at_which_it_can_be_seen),
        cmocka_unit_test(a_camera_has_a_frame_and_a_field_of_view),
        cmocka_unit_test(every_camera_that_is_taken_gives_numbers),
        cmocka_unit_test(no_option_takes_a_value_that_is_none_or_out_of_its_range),
        cmocka_unit_test(fields_out_of_range_are_refused_by_whatever_takes_them),
        cmocka_unit_test(settings_within_their_range_are_taken_whole),
        cmocka_unit_test(methods_and_light_paths_that_do_not_exist_are_refused),
        cmocka_unit_test(what_takes_settings_takes_no_null),
        cmocka_unit_test(a_method_takes_no_null),
        cmocka_unit_test(a_explanation_is_of_a_pixel_of_the_last_picture),
        cmocka_unit_test(nothing_is_asked_of_a_method_that_does_not_know_what_has_changed),
        cmocka_unit_test(caches_go_to_files_and_come_from_files_of_the_kind),
        cmocka_unit_test(after_a_failed_update_a_method_can_only_be_destroyed),
        cmocka_unit_test(after_a_failed_edit_another_one_makes_all_anew),
        cmocka_unit_test(a_show_goes_on_after_what_it_refuses),
        cmocka_unit_test(an_error_is_of_a_picture_that_the_probes_are_of),
    };
    return cmocka_run_group_tests(tests, NULL, scene_files_teardown);
}
