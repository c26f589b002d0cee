/* Limits of a scene: at the limit it is read, one more is an error. */
#define _XOPEN_SOURCE 700
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "unit_test.h"
#include "scene/file.h"
#include "scene/json.h"
#include "scene/model.h"
#include "rendering.h"
#include "scene_files.h"

static void expect(const char *text, const char *words) {
    const char *message = load_refused(scene_file_text("limits.json", text));
    if (!strstr(message, words)) fail_msg("'%s' does not say '%s'", message, words);
}

/* `head`, `count` times `entry` with commas between, `tail`. */
static char *repeat(const char *head, const char *entry, size_t count, const char *tail) {
    size_t room = strlen(head) + (strlen(entry) + 1) * count + strlen(tail) + 1;
    char *text = malloc(room), *to = text;
    assert_non_null(text);
    to += sprintf(to, "%s", head);
    for (size_t i = 0; i < count; i++) to += sprintf(to, "%s%s", i ? "," : "", entry);
    sprintf(to, "%s", tail);
    return text;
}

static void expect_repeated(const char *head, const char *entry, size_t count, const char *tail,
                            const char *words) {
    char *text = repeat(head, entry, count, tail);
    expect(text, words);
    free(text);
}

static void lists_may_have_only_so_many_entries(void **state) {
    static const char *const lists[][3] = {
        {"{\"softlux\":1,\"lights\":[", "]}", "expected a light to be an object"},
        {"{\"softlux\":1,\"meshes\":[", "]}", "expected a mesh to be an object"},
        {"{\"softlux\":1,\"camera\":{\"eye\":[0,0,1],\"target\":[0,0,0],\"keyframes\":[", "]}}",
         "expected a keyframe to be an object"}};
    for (size_t i = 0; i < 3; i++) {
        expect_repeated(lists[i][0], "0", SL_JSON_ENTRIES, lists[i][1], lists[i][2]);
        expect_repeated(lists[i][0], "0", SL_JSON_ENTRIES + 1, lists[i][1],
                        "at most 65536 entries, got 65537");
    }
    expect_repeated("{\"softlux\":1,\"materials\":{", "\"m\":0", SL_JSON_ENTRIES, "}}",
                    "expected a material to be an object");
    expect_repeated("{\"softlux\":1,\"materials\":{", "\"m\":0", SL_JSON_ENTRIES + 1, "}}",
                    "at most 65536 entries, got 65537");
}

/* Neither many keys nor many lights take more than time in proportion: a minute's work were it their square.
 */
static void as_many_as_may_be_are_read_in_time(void **state) {
    expect_repeated("{\"softlux\":1,", "\"key\":0", 1000000, "}", "unknown key 'key'");
    char *text =
        repeat("{\"softlux\":1,\"environment\":{\"radiance\":1},\"lights\":[{\"type\":\"quad\",\"corner\":[0,"
               "0,0],\"edge1\":[1,0,0],\"edge2\":[0,1,0],\"radiance\":1},",
               "{\"type\":\"point\",\"position\":[0,0,0],\"intensity\":0,\"keyframes\":[{\"time\":0}]}",
               SL_JSON_ENTRIES - 1, "]}");
    sl_scene *scene = load_scene(scene_file_text("dark.json", text));
    assert_true(scene_warns_of(scene, "65535 lights have no intensity and are left out"));
    sl_scene_destroy(scene);
    free(text);
}

static void strings_may_be_only_so_long(void **state) {
    char *name = malloc(SL_JSON_STRING + 2), *text = malloc(SL_JSON_STRING + 100);
    assert_true(name && text);
    for (size_t more = 0; more < 2; more++) {
        memset(name, 'n', SL_JSON_STRING + more);
        name[SL_JSON_STRING + more] = 0;
        sprintf(text, "{\"softlux\":1,\"meshes\":[{\"file\":\"%s\"}]}", name);
        expect(text, more ? "expected 'file' to be a string of at most 4095 bytes, got 4096"
                          : "limits.json:1: mesh ");
    }
    free(name);
    free(text);
}

/* Sparse: nothing of it is on the disk. */
static void write_sparse(const char *name, const char *start, long long bytes) {
    const char *path = scene_file_text(name, start);
    assert_int_equal(truncate(path, bytes), 0);
}

static void files_may_be_only_so_large(void **state) {
    write_sparse("large.json", "{}", SL_JSON_BYTES + 1ll);
    assert_non_null(strstr(load_refused(scene_file_path("large.json")),
                           "expected a scene file of at most 67108864 bytes, got 67108865"));
    static const char *const names[] = {"large.obj", "large.ply", "large.gltf", "large.bpt"};
    for (size_t i = 0; i < 4; i++) {
        write_sparse(names[i], "x", (long long)SL_FILE_BYTES + 1);
        assert_non_null(strstr(load_refused(scene_file_path(names[i])),
                               "expected a file of at most 2147483647 bytes, got 2147483648"));
    }
    /* blanks and commas: no JSON, but small enough */
    char *text = repeat("{\"softlux\":1,\"lights\":[", " ", SL_JSON_BYTES / 2 - 16, "0]}");
    text[strlen(text) - 5] = ' ';
    expect(text, "expected valid JSON");
    free(text);
}

static void vertices_and_triangles_are_counted_in_32_bits(void **state) {
    sl_model model = {0};
    sl_error error = {0};
    size_t first;
    assert_int_equal(sl_model_add_vertices(&model, SL_NO_INDEX, &first, &error), SL_ERROR_RESOURCES);
    assert_non_null(strstr(error.message, "more than 4294967295 vertices"));
    assert_int_equal(sl_model_add_triangles(&model, (SL_NO_INDEX - 1) / 3 + 1, &first, &error),
                     SL_ERROR_RESOURCES);
    assert_non_null(strstr(error.message, "more than 1431655764 triangles"));
    assert_int_equal(sl_model_add_triangles(&model, SIZE_MAX, &first, &error), SL_ERROR_RESOURCES);
    assert_int_equal(sl_model_add_triangles(&model, 2, &first, &error), SL_OK);
    assert_int_equal(sl_model_add_triangles(&model, (SL_NO_INDEX - 1) / 3 - 1, &first, &error),
                     SL_ERROR_RESOURCES);
    assert_non_null(strstr(error.message, "more than 1431655764 triangles"));
    sl_model_clear(&model);
}

static void films_may_be_only_so_wide(void **state) {
    expect("{\"softlux\":1,\"film\":{\"width\":65537,\"height\":1}}",
           "expected 'width' from 1 to 65536, got 65537");
    expect("{\"softlux\":1,\"film\":{\"width\":65536,\"height\":65536}}", ": no triangles");
    sl_image *image = NULL;
    sl_error error = {0};
    assert_int_equal(sl_image_create(46341, 46341, 1, NULL, &image, &error), SL_ERROR_RESOURCES);
    assert_non_null(strstr(error.message, "too large"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lists_may_have_only_so_many_entries),
        cmocka_unit_test(as_many_as_may_be_are_read_in_time),
        cmocka_unit_test(strings_may_be_only_so_long),
        cmocka_unit_test(files_may_be_only_so_large),
        cmocka_unit_test(vertices_and_triangles_are_counted_in_32_bits),
        cmocka_unit_test(films_may_be_only_so_wide),
    };
    return cmocka_run_group_tests(tests, NULL, scene_files_teardown);
}
