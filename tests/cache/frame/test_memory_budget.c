/* Memory within bounds: what a picture takes, as the system counts it, against what was allowed. */
#include <math.h>
#include <malloc.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "unit_test.h"
#include "base/sanitized.h"
#include "rendering.h"
#include "trace_scenes.h"

static const double mega = 0x1p20;

/* ---- a picture in a process of its own ---- */

typedef struct outcome {
    sl_status status;
    double peak, need; /* bytes: of the whole process; and what was said before */
    bool sound, reduced;
    char message[1024]; /* the error, or the reduction */
} outcome;

static sl_scene *cornell(void) { return load_scene("scenes/cornell.json"); }

/* A ball of 4 rings^2 triangles with bumps, and a lamp. */
static sl_scene *ball_of(unsigned rings) {
    trace_mesh m = trace_mesh_begin();
    uint32_t grey = trace_mesh_diffuse(&m, 0.6f), lamp = trace_mesh_lamp(&m, 20.0f);
    trace_mesh_box(&m, sl_v3(-3, -3, -3), sl_v3(3, 3, 3), true, grey);
    trace_mesh_sphere(&m, sl_v3(0, -1, 0), 1.5f, rings, 0.1f, false, grey);
    trace_mesh_quad(&m, sl_v3(-0.5f, 2.9f, -0.5f), sl_v3(1, 0, 0), sl_v3(0, 0, 1), lamp);
    assert_true(sl_camera_look_at(&m.camera, sl_v3(0, 1, 2.9f), sl_v3(0, -0.5f, 0), sl_v3(0, 1, 0), 1.1f));
    m.has_camera = true;
    return trace_mesh_build(&m);
}

static sl_scene *bumpy_ball(void) { return ball_of(80); } /* 26,000 triangles */
static sl_scene *smooth_ball(void) { return ball_of(20); }
static sl_scene *fine_ball(void) { return ball_of(170); } /* 116,000 triangles */

static void run(sl_scene *scene, const sl_settings *settings, outcome *o) {
    sl_error error = {SL_OK, ""};
    sl_method *method = NULL;
    sl_image *image = NULL;
    sl_progress progress = {0};
    uint64_t need = 0;
    o->status = sl_method_memory_need(scene, settings, &need, &error);
    o->need = (double)need;
    if (o->status == SL_OK) o->status = sl_method_create(scene, settings, &method, &error);
    while (o->status == SL_OK && !progress.done && progress.batches < 2000)
        o->status = sl_method_update(method, &progress, &error);
    if (o->status == SL_OK) o->status = sl_method_resolve(method, &image, &error);
    snprintf(o->message, sizeof o->message, "%s", error.message);
    if (o->status != SL_OK) return;
    size_t values = 3 * (size_t)image->width * (size_t)image->height;
    o->sound = true;
    for (size_t i = 0; i < values; i++) o->sound &= isfinite(image->planes[i]) && image->planes[i] >= 0.0f;
    const char *reduced = sl_method_reduction(method);
    o->reduced = reduced != NULL;
    snprintf(o->message, sizeof o->message, "%s", reduced ? reduced : "");
    const char path[] = "/tmp/softlux-budget.exr";
    o->status = sl_image_write(image, path, &error);
    unlink(path);
}

/* Making a scene by hand takes more for a moment than the scene: that is given back, and the process's peak
 * is counted from here. */
static void forget_peak(void) {
    FILE *file = fopen("/proc/self/clear_refs", "w");
    malloc_trim(0);
    if (file) fputs("5", file), fclose(file);
}

static outcome in_a_process(sl_scene *(*make)(void), const sl_settings *settings) {
    int ends[2];
    outcome o = {.status = SL_ERROR_RESOURCES};
    assert_int_equal(pipe(ends), 0);
    fflush(NULL);
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        struct rusage usage;
        sl_scene *scene = make();
        forget_peak();
        run(scene, settings, &o);
        getrusage(RUSAGE_SELF, &usage);
        o.peak = 1024.0 * (double)usage.ru_maxrss;
        _exit(write(ends[1], &o, sizeof o) == sizeof o ? 0 : 1);
    }
    close(ends[1]);
    bool whole = read(ends[0], &o, sizeof o) == sizeof o;
    close(ends[0]);
    assert_int_equal(waitpid(child, NULL, 0), child);
    assert_true(whole);
    return o;
}

/* ---- what may be taken ---- */

static sl_settings settings_of(const char *method, int size) {
    sl_settings s = small_settings(method, size, size);
    s.spp = 1;
    s.light_octree.photons = 20000;
    s.shading_cache.updates = 4;
    s.shading_cache.indirect_samples = 4;
    return s;
}

/* "needs at least 64M" */
static double least_of(const char *message) {
    const char *at = strstr(message, "at least ");
    if (!at) fail_msg("'%s' tells no least need", message);
    return atof(at + strlen("at least ")) * mega;
}

static void assert_within(const char *method, const outcome *o, double budget) {
    if (o->status != SL_OK) fail_msg("%s with %.0fM: %s", method, budget / mega, o->message);
    assert_true(o->sound);
    if (!SL_SANITIZED && o->peak > budget)
        fail_msg("%s takes %.1fM of %.1fM (%s)", method, o->peak / mega, budget / mega, o->message);
}

static void check_budgets(sl_scene *(*make)(void), int size, int budgets, double most_above) {
    for (size_t i = 0; sl_method_name(i); i++) {
        sl_settings s = settings_of(sl_method_name(i), size);
        outcome o = in_a_process(make, &s);
        const double need = o.need;
        assert_within(s.method, &o, need); /* what it says, it takes, and no more */
        if (!SL_SANITIZED && need - 32.0 * mega > most_above * o.peak)
            fail_msg("%s says %.1fM, and takes %.1fM", s.method, need / mega, o.peak / mega);
        assert_false(o.reduced);
        s.memory_bytes = (uint64_t)(1 << 24);
        o = in_a_process(make, &s);
        assert_int_equal(o.status, SL_ERROR_RESOURCES);
        const double least = least_of(o.message);
        assert_true(least <= need + 2.0 * mega);
        for (int k = 0; k < budgets; k++) { /* the least, and between it and enough */
            s.memory_bytes = (uint64_t)(least + mega + 0.4 * k * (need > least ? need - least : 0.0));
            o = in_a_process(make, &s);
            assert_within(s.method, &o, (double)s.memory_bytes);
        }
    }
}

static void pictures_of_a_small_scene_stay_within_every_budget(void **state) {
    check_budgets(cornell, 64, 2, 3.0);
}

static void pictures_of_many_triangles_stay_within_every_budget(void **state) {
    check_budgets(bumpy_ball, 32, 1, 2.5);
}

/* Holds forecast against measured growth: by how much more is taken for more pixels or triangles, so that the
 * program's own memory hides no mistake. */
static void check_growth(const char *method, sl_scene *(*few)(void), int small, sl_scene *(*many)(void),
                         int large) {
    const double slack = 2.0 * mega;
    sl_settings s = settings_of(method, small), l = settings_of(method, large);
    const outcome of_few = in_a_process(few, &s), of_many = in_a_process(many, &l);
    const double need = of_many.need - of_few.need;
    assert_int_equal(of_few.status, SL_OK);
    assert_int_equal(of_many.status, SL_OK);
    if (SL_SANITIZED) return;
    const double taken = of_many.peak - of_few.peak;
    if (taken > need + slack || need > 2.0 * taken + slack)
        fail_msg("%s says %.1fM more, and takes %.1fM more", method, need / mega, taken / mega);
}

static void more_pixels_take_what_is_said_of_them(void **state) {
    static const char *const methods[] = {"path",      "bidirectional", "direct-radiance",
                                          "splatting", "light-octree",  "multi-mesh"};
    for (size_t i = 0; i < sizeof methods / sizeof methods[0]; i++)
        check_growth(methods[i], smooth_ball, 32, smooth_ball, 448);
}

static void more_triangles_take_what_is_said_of_them(void **state) {
    static const char *const methods[] = {"path", "direct-radiance", "splatting", "shading-cache"};
    for (size_t i = 0; i < sizeof methods / sizeof methods[0]; i++)
        check_growth(methods[i], smooth_ball, 16, fine_ball, 16);
}

static void what_is_done_less_is_told_and_does_not_depend_on_threads(void **state) {
    sl_scene *scene = cornell();
    static const struct {
        const char *method, *told;
        double share; /* of the need */
    } cases[] = {{"light-octree", "stored photons", 0.55},
                 {"direct-radiance", "sample photons", 0.7},
                 {"splatting", "records end at", 0.0},
                 {"multi-mesh", "meshes end at", 0.0}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        sl_error error;
        sl_settings s = settings_of(cases[i].method, 48);
        if (i == 0) s.light_octree.photons = 100000;
        if (i > 1) s.quality = SL_QUALITY_NORMAL;
        if (i == 1) s.radiance_map.samples = 128;
        uint64_t need;
        s.threads = 1;
        assert_int_equal(sl_method_memory_need(scene, &s, &need, &error), SL_OK);
        s.memory_bytes = cases[i].share > 0.0 ? (uint64_t)(cases[i].share * (double)need) : need + 50000;
        sl_image *one = render(scene, &s, NULL);
        s.threads = 3;
        sl_image *three = render(scene, &s, NULL);
        const char *told = sl_image_metadata(three, "softlux.reduced");
        assert_non_null(told);
        if (!strstr(told, cases[i].told))
            fail_msg("%s: '%s' does not tell of %s", cases[i].method, told, cases[i].told);
        assert_non_null(sl_image_metadata(three, "softlux.memory"));
        assert_true(same_picture(one, three));
        destroy_pictures(one, three);
    }
    sl_scene_destroy(scene);
}

/* Keyframes give lamps an area that have none yet: what is said of a method holds for as long as it lives. */
static void lamps_that_grow_later_are_counted_from_the_start(void **state) {
    sl_scene *scene =
        scene_from_text("{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\", \"name\": \"floor\", "
                        "\"transform\": {\"scale\": 4}}, {\"file\": \"mesh.obj\", \"name\": \"lamps\", "
                        "\"material\": \"lamp\", \"keyframes\": [{\"time\": 0, \"translate\": [0, 2, 0], "
                        "\"scale\": 1e-30}, {\"time\": 1, \"translate\": [0, 2, 0]}]}], "
                        "\"materials\": {\"lamp\": {\"diffuse\": 0, \"emission\": 5}}, \"lights\": "
                        "[{\"type\": \"point\", \"position\": [0, 1, 0], \"intensity\": 1}], "
                        "\"camera\": {\"eye\": [0, 3, 6], \"target\": [0, 0, 0]}}",
                        "v 0 0 0\nv 0 0 1\nv 1 0 0\nv 0 0.5 -1\nv 0 0.5 0\nv 1 0.5 -1\nv -1 0.2 0\nv -1 0.2 "
                        "1\nv 0 0.2 0\nf 1 3 2\nf 4 6 5\nf 7 9 8\n");
    for (size_t i = 0; sl_method_name(i); i++) {
        sl_settings s = settings_of(sl_method_name(i), 16);
        s.threads = 1;
        sl_error error;
        uint64_t before, after;
        assert_int_equal(sl_scene_set_time(scene, 0.0, NULL, &error), SL_OK);
        assert_int_equal(sl_method_memory_need(scene, &s, &before, &error), SL_OK);
        s.memory_bytes = before;
        sl_method *method = created_method(scene, &s);
        go_to_time(scene, method, 1.0);
        for (sl_progress p = {0}; !p.done && p.batches < 100;)
            assert_int_equal(sl_method_update(method, &p, &error), SL_OK);
        assert_int_equal(sl_method_memory_need(scene, &s, &after, &error), SL_OK);
        const double taken =
            (double)(sl_method_memory_bytes(method) + sl_scene_memory_bytes(scene)) + 32.0 * mega;
        print_message("%-16s says %.2fM, holds %.2fM; with lamps it would say %.2fM\n", s.method,
                      (double)before / mega, taken / mega, (double)after / mega);
        assert_true(taken <= (double)before);
        assert_true(after <= before);
        sl_method_destroy(method);
    }
    sl_scene_destroy(scene);
}

static void enough_memory_changes_no_bit(void **state) {
    sl_scene *scene = cornell();
    for (size_t i = 0; sl_method_name(i); i++) {
        sl_settings s = settings_of(sl_method_name(i), 16);
        sl_image *free_one = render(scene, &s, NULL);
        s.memory_bytes = (uint64_t)1 << 34;
        sl_image *bounded = render(scene, &s, NULL);
        assert_true(same_picture(free_one, bounded));
        assert_null(sl_image_metadata(bounded, "softlux.reduced"));
        destroy_pictures(free_one, bounded);
    }
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        /* Processes begin as large as this one is: what renders in it comes last. */
        cmocka_unit_test(more_pixels_take_what_is_said_of_them),
        cmocka_unit_test(more_triangles_take_what_is_said_of_them),
        cmocka_unit_test(pictures_of_a_small_scene_stay_within_every_budget),
        cmocka_unit_test(pictures_of_many_triangles_stay_within_every_budget),
        cmocka_unit_test(what_is_done_less_is_told_and_does_not_depend_on_threads),
        cmocka_unit_test(lamps_that_grow_later_are_counted_from_the_start),
        cmocka_unit_test(enough_memory_changes_no_bit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
