/* Edits and pictures again and again: what is held after many is what was held after a few. SOAK_SECONDS in
 * the environment makes it go on for so long (tests/hard/soak.sh); by itself it is over in seconds. */
#include <dirent.h>
#include <limits.h>
#include <malloc.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "unit_test.h"
#include "base/sanitized.h"
#include "least_settings.h"
#include "rendering.h"

/* A room of two materials with a box that turns, a lamp and a point light that move, and a camera on a way.
 */
static const char scene_text[] =
    "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\", \"name\": \"room\", \"material\": \"white\"},"
    " {\"file\": \"mesh.obj\", \"name\": \"box\", \"material\": \"gloss\", \"transform\": {\"scale\": 0.2, "
    "\"translate\": [0, 0, 0]},"
    "  \"keyframes\": [{\"time\": 0, \"translate\": [0.1, -0.6, 0]}, {\"time\": 8, \"translate\": [-0.4, "
    "-0.4, 0.3]}]}],"
    " \"materials\": {\"white\": {\"diffuse\": 0.6}, \"gloss\": {\"diffuse\": 0.3, \"specular\": 0.3, "
    "\"exponent\": 8}},"
    " \"lights\": [{\"type\": \"quad\", \"corner\": [-0.2, 0.95, -0.2], \"edge1\": [0.4, 0, 0], \"edge2\": "
    "[0, 0, 0.4], \"radiance\": 6},"
    " {\"type\": \"point\", \"position\": [0.5, 0.4, 0.3], \"intensity\": 0.3,"
    "  \"keyframes\": [{\"time\": 0, \"position\": [0.5, 0.4, 0.3]}, {\"time\": 8, \"position\": [-0.5, 0.2, "
    "-0.3]}]}],"
    " \"camera\": {\"eye\": [0, 0, 0.98], \"target\": [0, -0.1, 0], \"fov_deg\": 80},"
    " \"film\": {\"width\": 24, \"height\": 24}}";
static const char mesh_text[] =
    "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n"
    "f 1 2 3 4\nf 6 5 8 7\nf 5 1 4 8\nf 2 6 7 3\nf 4 3 7 8\nf 5 6 2 1\n";

typedef struct holdings {
    double bytes;      /* of the heap, in use */
    double resident;   /* pages */
    int descriptors, threads; /* early, one that ends may be among them */
} holdings;

static int entries(const char *folder) {
    DIR *d = opendir(folder);
    int count = 0;
    assert_non_null(d);
    while (readdir(d)) count++;
    closedir(d);
    return count;
}

static double resident_pages(void) {
    unsigned long whole = 0, resident = 0;
    FILE *file = fopen("/proc/self/statm", "r");
    assert_non_null(file);
    assert_int_equal(fscanf(file, "%lu %lu", &whole, &resident), 2);
    fclose(file);
    return (double)resident;
}

static double asked_seconds(void) {
    const char *text = getenv("SOAK_SECONDS");
    return text ? atof(text) : 0.0;
}

static holdings take_stock(void) {
    struct mallinfo2 heap = mallinfo2();
    return (holdings){(double)heap.uordblks + (double)heap.hblkhd, resident_pages(), entries("/proc/self/fd"),
                      threads_left(INT_MAX)};
}

static double seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

enum { SIDE = 16, PLACES = 4 };

static sl_settings quick(const char *method) {
    sl_settings s = least_settings(method, SIDE, SIDE);
    s.threads = 2;
    s.shading_cache.cache_limit = 0.1; /* full after a round */
    /* its patches are as small as they get after two rounds; with smaller ones they are after 150 */
    s.shading_cache.stop_size = 4.0;
    return s;
}

static void picture(sl_method *method) {
    sl_error error;
    sl_image *image = NULL;
    sl_progress progress = {0};
    sl_status status = SL_OK;
    for (int i = 0; i < 400 && !progress.done && status == SL_OK; i++)
        status = sl_method_update(method, &progress, &error);
    if (status == SL_OK) status = sl_method_resolve(method, &image, &error);
    if (status != SL_OK) fail_msg("%s", error.message);
    for (size_t i = 0; i < 3 * SIDE * SIDE; i++) assert_true(isfinite(image->planes[i]));
    sl_image_destroy(image);
}

/* Everything moves, the camera by hand; a few places, which come again. */
static void edit(sl_scene *scene, sl_method *method, unsigned step) {
    sl_error error;
    unsigned changes = 0;
    const float eye[3] = {0.2f * (float)(step % PLACES) - 0.4f, 0, 0.98f}, target[3] = {0, -0.1f, 0},
                up[3] = {0, 1, 0};
    sl_status status = sl_scene_set_time(scene, 2.0 * (double)(step % PLACES), &changes, &error);
    if (status == SL_OK) status = sl_scene_set_camera(scene, eye, target, up, 1.4f, &error);
    if (status == SL_OK && method) status = sl_method_edit(method, changes | SL_CHANGED_CAMERA, &error);
    if (status != SL_OK) fail_msg("%s", error.message);
}

static void assert_flat(const char *what, const holdings *early, const holdings *late) {
    int threads = threads_left(early->threads);
    if (early->descriptors != late->descriptors)
        fail_msg("%s: %d descriptors, then %d", what, early->descriptors, late->descriptors);
    if (threads > early->threads) fail_msg("%s: %d threads, then %d", what, early->threads, threads);
    if (late->bytes > 1.03 * early->bytes + 65536.0)
        fail_msg("%s: %.0f bytes of heap, then %.0f", what, early->bytes, late->bytes);
    if (!SL_SANITIZED && late->resident > 1.02 * early->resident + 256.0)
        fail_msg("%s: %.0f pages resident, then %.0f", what, early->resident, late->resident);
}

/* Rounds of the same work: WARM of them, or a third of the time that was asked for, until caches and the
 * allocator's arenas are as full as they get; then as many again, or the rest of the time. */
enum { WARM = 2 };

typedef struct soak {
    double begin, end;
    unsigned round, warm_round; /* warm_round: 0 until it is warm */
    holdings early;
} soak;

static soak start_soak(double share) {
    double now = seconds();
    return (soak){.begin = now, .end = now + share * asked_seconds()};
}

/* After each round: whether there is to be another. *warm: this is the first that counts. */
static bool next_round(soak *s, bool *warm) {
    double now = seconds();
    s->round++;
    *warm = !s->warm_round && s->round >= WARM && now >= s->begin + (s->end - s->begin) / 3.0;
    if (*warm) s->warm_round = s->round, s->early = take_stock();
    return !s->warm_round || s->round < s->warm_round + WARM || now < s->end;
}

/* One method, edited for ever. */
static void edit_for_ever(const char *name) {
    sl_error error;
    sl_scene *scene = scene_from_text(scene_text, mesh_text);
    sl_settings settings = quick(name);
    sl_method *method = NULL;
    if (sl_method_create(scene, &settings, &method, &error) != SL_OK) fail_msg("%s", error.message);
    soak s = start_soak(1.0 / 3.0 / 7.0);
    double held = 0.0;
    bool warm, more;
    do {
        for (unsigned step = 0; step < PLACES; step++) edit(scene, method, step), picture(method);
        more = next_round(&s, &warm);
        if (warm) held = (double)sl_method_memory_bytes(method);
    } while (more);
    holdings late = take_stock();
    assert_flat(name, &s.early, &late);
    double now = (double)sl_method_memory_bytes(method);
    if (now > 1.02 * held + 4096.0)
        fail_msg("%s says it holds %.0f bytes, then %.0f after %u rounds", name, held, now, s.round);
    if (asked_seconds() > 0.0)
        print_message(
            "%s: %u rounds of four edits and pictures, %.0f then %.0f bytes, pages %.0f then %.0f\n", name,
            s.round, held, now, s.early.resident, late.resident);
    destroy_method(method, scene);
}

static void edits_and_pictures_leave_nothing_behind_in_any_method(void **state) {
    for (size_t i = 0; sl_method_name(i); i++) edit_for_ever(sl_method_name(i));
}

static void show(const char *name) {
    sl_error error;
    sl_scene *scene = scene_from_text(scene_text, mesh_text);
    sl_settings settings = quick(name);
    sl_live *live = NULL;
    const sl_image *frame;
    if (sl_live_start(scene, &settings, &live, &error) != SL_OK) fail_msg("%s", error.message);
    for (int i = 0; i < 6; i++) {
        sl_status status = sl_live_move(live, (double)i, &error);
        for (int k = 0; k < 3 && status == SL_OK; k++) status = sl_live_frame(live, &frame, NULL, &error);
        if (status != SL_OK) fail_msg("%s", error.message);
    }
    sl_live_stop(live, NULL);
    sl_scene_destroy(scene);
}

static void shows_that_start_and_stop_leave_nothing_behind(void **state) {
    static const char *const names[] = {"shading-cache", "splatting", "direct-radiance"};
    soak s = start_soak(1.0 / 3.0);
    bool warm;
    do {
        for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) show(names[i]);
    } while (next_round(&s, &warm));
    holdings late = take_stock();
    assert_flat("shows", &s.early, &late);
    if (asked_seconds() > 0.0)
        print_message("shows: %u rounds of three, pages %.0f then %.0f\n", s.round, s.early.resident,
                      late.resident);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(edits_and_pictures_leave_nothing_behind_in_any_method),
        cmocka_unit_test(shows_that_start_and_stop_leave_nothing_behind),
    };
    /* else each of a process's first threads has one of its own, and those fill in the course of time: up to
     * 16 MB */
    mallopt(M_ARENA_MAX, 1);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
