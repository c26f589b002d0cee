/* --memory, from outside: what a command takes, as the system counts it, is not more than that, the scene's
 * loading and what is written included. What cannot be done with so little is refused, and how much is needed
 * is said. As tests/cache/frame/test_memory_budget.c, which asks the library. */
#define _GNU_SOURCE /* wait4() */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "unit_test.h"
#include "app/commands.h"
#include "base/sanitized.h"
#include "command.h"
#include "scene_files.h"
#include "softlux.h"

/* ---- a command in a process of its own ------------------------------------------------------- */

typedef struct outcome {
    int status;
    double peak; /* megabytes, of the whole process */
    char said[4096]; /* on standard error */
} outcome;

static outcome run(command *c, const char *format, ...) {
    outcome o = {0};
    char line[2048];
    const char *errors = scene_file_path("said");
    struct rusage usage;
    int how = 0;
    va_list values;
    va_start(values, format);
    assert_true(vsnprintf(line, sizeof line, format, values) < (int)sizeof line);
    va_end(values);
    pid_t child = command_start(c, line, "", NULL, errors);
    assert_true(child > 0 && wait4(child, &how, 0, &usage) == child);
    FILE *said = fopen(errors, "r");
    assert_true(said && WIFEXITED(how));
    o.said[fread(o.said, 1, sizeof o.said - 1, said)] = '\0';
    fclose(said);
    o.status = WEXITSTATUS(how);
    o.peak = (double)usage.ru_maxrss / 1024.0;
    return o;
}

/* ---- a scene --------------------------------------------------------------------------------- */

static void write_hills(const char *name, int side) {
    const size_t room = 100 * (size_t)side * (size_t)side;
    char *text = malloc(room);
    size_t at = 0;
    assert_non_null(text);
    for (int i = 0; i < side * side; i++) {
        int x = i % side, z = i / side;
        at += (size_t)snprintf(text + at, room - at, "v %g %g %g\n", 0.1 * x, 0.02 * ((x * x + 3 * z) % 7),
                               0.1 * z);
    }
    for (int i = 0; i < (side - 1) * (side - 1); i++) {
        int a = i % (side - 1) + i / (side - 1) * side + 1;
        at += (size_t)snprintf(text + at, room - at, "f %d %d %d\nf %d %d %d\n", a, a + side, a + 1, a + 1,
                               a + side, a + side + 1);
    }
    assert_true(at + 1 < room);
    scene_file_text(name, text);
    free(text);
}

/* Hills of 20,000 triangles below a lamp, and a tile that moves. */
static void write_scene(void) {
    write_hills("hills.obj", 101);
    scene_file_text("tile.obj", "v 0 0 0\nv 1 0 0\nv 1 0.5 1\nv 0 0.5 1\nf 4 3 2 1\n");
    scene_file_text("hills.json",
                    "{\"softlux\": 1, \"meshes\": [{\"file\": \"hills.obj\", \"material\": \"grey\"},"
                    "{\"file\": \"tile.obj\", \"name\": \"tile\", \"material\": \"grey\","
                    " \"keyframes\": [{\"time\": 0, \"translate\": [4, 1, 4]}, {\"time\": 1, \"translate\": "
                    "[6, 1, 4]}]}],\n"
                    "\"materials\": {\"grey\": {\"diffuse\": 0.6}},\n\"lights\": [{\"type\": \"quad\", "
                    "\"corner\": [4, 5, 4], \"edge1\": [2, 0, 0],"
                    " \"edge2\": [0, 0, 2], \"radiance\": [9, 9, 9]}],\n"
                    "\"camera\": {\"eye\": [5, 6, 14], \"target\": [5, 0, 5], \"fov_deg\": 45}}");
}

/* ---- what may be taken ----------------------------------------------------------------------- */

/* "needs at least 64M"; a refusal is one line, and has no doubt about it. */
static double least_of(const char *what, const outcome *o) {
    const char *at = strstr(o->said, "at least ");
    if (o->status != SL_ERROR_RESOURCES || !at || strchr(o->said, '\n') != o->said + strlen(o->said) - 1)
        fail_msg("%s: status %d, and no refusal that names the least need: %s", what, o->status, o->said);
    return atof(at + strlen("at least "));
}

/* Asks for less than can do, takes the answer for it, and is then held to that. */
static void check_least(command *c, const char *name, const char *method, const char *more) {
    const double too_little = 44.0;
    const char *scene = scene_file_path("hills.json");
    char arguments[1024];
    snprintf(arguments, sizeof arguments, "%s -m %s -q draft -t 2 %s -o %s", scene, method, more,
             scene_file_path(name));
    outcome o = run(c, "%s --memory %.0fM", arguments, too_little);
    const double least = least_of(arguments, &o);
    assert_true(least > too_little);
    o = run(c, "%s --memory %.0fM", arguments, least);
    if (o.status != 0) fail_msg("%s with %.0fM: status %d, %s", arguments, least, o.status, o.said);
    if (!SL_SANITIZED && o.peak > least)
        fail_msg("%s takes %.1f MB of %.0f: %s", arguments, o.peak, least, o.said);
    /* with one sample there is nothing that could be done less; of shows rounding to megabytes hides it */
    const bool has_less = strcmp(method, "path") != 0 && c == sl_command_render;
    if (has_less && !strstr(o.said, "to keep within --memory: "))
        fail_msg("%s with %.0fM does not say what it does less: %s", arguments, least, o.said);
}

static void pictures_of_every_method_stay_within_what_is_allowed(void **state) {
    for (size_t i = 0; sl_method_name(i); i++)
        check_least(sl_command_render, "a.exr", sl_method_name(i), "-s 256x256 --spp 1");
}

/* The scene_copy that moves, the frames, and what is written of them are in it. */
static void shows_of_every_method_stay_within_what_is_allowed(void **state) {
    for (size_t i = 0; sl_method_name(i); i++)
        check_least(sl_command_live, "a.y4m", sl_method_name(i), "-s 128x128 --spp 1 --fps 8 --frames 8");
    /* so large that what the program has to spare hides nothing */
    check_least(sl_command_live, "a.y4m", "direct-radiance", "-s 1200x1200 --fps 8 --frames 12");
}

/* The pictures that pages show of passes are not in it; that their scenes are loaded within it, and that
 * there is an answer to too little, is. */
static void pages_load_their_scene_within_what_is_allowed(void **state) {
    if (SL_SANITIZED) skip(); /* nothing limits them there */
    write_hills("many.obj", 401);
    const char *scene = scene_file_path("many.obj");
    outcome o =
        run(sl_command_steps, "%s -s 16x16 -q draft -t 1 --quiet --memory 20M -o /nowhere/at/all", scene);
    assert_int_equal(o.status, SL_ERROR_RESOURCES);
    assert_non_null(strstr(o.said, "20M of memory are not enough to load it"));
    assert_true(o.peak < 20.0 + 16.0); /* code and tables of libraries, which are no data */
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pictures_of_every_method_stay_within_what_is_allowed),
        cmocka_unit_test(shows_of_every_method_stay_within_what_is_allowed),
        cmocka_unit_test(pages_load_their_scene_within_what_is_allowed),
    };
    write_scene();
    return cmocka_run_group_tests(tests, NULL, scene_files_teardown);
}
