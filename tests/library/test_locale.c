/* A program whose locale has a decimal comma, as many with windows have: what the library reads and says is
 * the same. */
#define _GNU_SOURCE
#include <locale.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "unit_test.h"
#include "rendering.h"
#include "scene_files.h"
#include "softlux.h"

static char folder[] = "/tmp/softlux-locale-XXXXXX";

/* Few machines have such a locale: one is made. */
static int make_locale(void **state) {
    char command[256];
    if (!mkdtemp(folder)) return -1;
    snprintf(command, sizeof command, "localedef -f UTF-8 -i de_DE %s/de_DE.UTF-8 >%s/said 2>&1", folder,
             folder);
    if (system(command) != 0)
        print_message("skip: there is nothing to make a locale of (Debian's package 'locales')\n");
    return setenv("LOCPATH", folder, 1);
}

static int remove_locale(void **state) {
    char command[64];
    snprintf(command, sizeof command, "rm -rf %s", folder);
    return scene_files_teardown(state) + system(command);
}

static void begin_comma(void) {
    char half[8];
    if (!setlocale(LC_ALL, "de_DE.UTF-8")) skip();
    snprintf(half, sizeof half, "%.1f", 0.5);
    assert_string_equal(half, "0,5");
}

static void end_comma(void) { setlocale(LC_ALL, "C"); }

static uint64_t hash_of(const char *path) {
    sl_scene *scene = load_scene(path);
    uint64_t hash = sl_scene_hash(scene);
    sl_scene_destroy(scene);
    return hash;
}

static void files_of_all_kinds_are_read_alike(void **state) {
    scene_file_text("m.mtl", "newmtl m\nKd 0.25 .5 0.75\nNs 1.5\n");
    const char *const files[] = {
        scene_file_text("m.obj", "mtllib m.mtl\nv 0.5 0 0\nv 1.25 .5 0\nv 0 1.5e-1 0\nusemtl m\nf 1 2 3\n"),
        scene_file_text(
            "m.ply",
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
            "element face 1\nproperty list uchar int vertex_indices\nend_header\n0.5 0 0\n1.25 0.5 0\n0 "
            "1.5e-1 0\n3 0 1 2\n"),
        scene_file_text("m.off", "OFF\n3 1 0\n0.5 0 0\n1.25 0.5 0\n0 0.15 0\n3 0 1 2\n"),
        "scenes/vase.json",
        "scenes/cornell-glossy.json",
        "scenes/walk.json"};
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++) {
        uint64_t hash = hash_of(files[i]);
        begin_comma();
        assert_true(hash_of(files[i]) == hash);
        end_comma();
    }
}

static void what_is_wrong_in_a_file_is_told_with_points(void **state) {
    char with_points[512];
    const char *path = scene_file_text("bad.json", "{\"softlux\": 1, \"meshes\": [{\"file\": \"m.obj\"}], "
                                                   "\"materials\": {\"m\": {\"diffuse\": 1000000.5}}}");
    snprintf(with_points, sizeof with_points, "%s", load_refused(path));
    begin_comma();
    const char *with_commas = load_refused(path);
    end_comma();
    assert_string_equal(with_commas, with_points);
}

static void scenes_are_written_with_points(void **state) {
    sl_scene *scene = load_scene("scenes/cornell-glossy.json");
    const char *path = scene_file_text("written.json", "");
    begin_comma();
    assert_int_equal(sl_scene_write(scene, path, NULL), SL_OK);
    end_comma();
    assert_true(hash_of(path) == sl_scene_hash(scene));
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(files_of_all_kinds_are_read_alike),
        cmocka_unit_test(what_is_wrong_in_a_file_is_told_with_points),
        cmocka_unit_test(scenes_are_written_with_points),
    };
    return cmocka_run_group_tests(tests, make_locale, remove_locale);
}
