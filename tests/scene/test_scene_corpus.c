/* A folder of real and of damaged scenes, if there is one: SOFTLUX_CORPUS, or ../shared/scenes. Every file
 * either loads or is refused with one line; the well-known scenes have the right number of triangles. */
#define _XOPEN_SOURCE 700
#include <ftw.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include <cmocka.h>

#include "scene/scene.h"

static const char *corpus(void) {
    const char *folder = getenv("SOFTLUX_CORPUS");
    struct stat about;
    if (!folder) folder = "../shared/scenes";
    if (stat(folder, &about) == 0) return folder;
    print_message("no folder %s (set SOFTLUX_CORPUS): nothing to load\n", folder);
    return NULL;
}

static int loaded, refused;

static bool is_mesh(const char *path) {
    static const char *const others[] = {".png",  ".jpg", ".jpeg", ".txt", ".md",  ".mtl",  ".bin",  ".webp",
                                         ".json", ".xml", ".scn",  ".exr", ".hdr", ".ktx2", ".vert", ".frag"};
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++) {
        size_t length = strlen(path), wanted = strlen(others[i]);
        if (length > wanted && strcmp(path + length - wanted, others[i]) == 0) return false;
    }
    return true;
}

/* A loaded scene holds what the rest of the program relies on. */
static void check_scene(const char *path, const sl_scene *s) {
    bool good = s->triangle_count > 0 && s->diagonal > 0.0f && s->material_count > 0;
    for (size_t t = 0; t < s->triangle_count; t++) {
        sl_vec3 n = sl_scene_geometric_normal(s, (uint32_t)t);
        good = good && s->material_index[t] < s->material_count && s->object_index[t] < s->object_count;
        good = good && sl_dot(n, n) > 0.99f && sl_dot(n, n) < 1.01f;
        for (int c = 0; c < 3; c++) good = good && s->vertex[c][t] < s->vertex_count;
    }
    for (uint32_t v = 0; v < s->vertex_count; v++) {
        sl_vec3 n = sl_scene_normal(s, v);
        good = good && sl_is_finite(sl_scene_position(s, v)) && sl_dot(n, n) > 0.99f && sl_dot(n, n) < 1.01f;
    }
    for (size_t i = 0; i < s->material_count; i++) {
        const sl_material *m = &s->materials[i];
        good = good && m->diffuse.r + m->specular.r <= 1.0f && m->diffuse.g + m->specular.g <= 1.0f &&
               m->diffuse.b + m->specular.b <= 1.0f;
    }
    if (!good) fail_msg("%s: the scene is not what it promises", path);
}

static int visit(const char *path, const struct stat *about, int kind, struct FTW *where) {
    (void)about;
    (void)where;
    if (kind != FTW_F || !is_mesh(path)) return 0;
    sl_scene *scene;
    sl_error error = {0};
    sl_status status = sl_scene_load(path, &scene, &error);
    if (status == SL_OK) {
        loaded++;
        check_scene(path, scene);
        sl_scene_destroy(scene);
        return 0;
    }
    refused++;
    if (scene || status != SL_ERROR_INPUT || !error.message[0] || strchr(error.message, '\n'))
        fail_msg("%s: %d %s", path, status, error.message);
    return 0;
}

static void every_file_loads_or_is_refused_with_one_line(void **state) {
    (void)state;
    const char *folder = corpus();
    if (!folder) skip();
    assert_int_equal(nftw(folder, visit, 16, FTW_PHYS), 0);
    print_message("%d files loaded, %d refused\n", loaded, refused);
    assert_true(loaded + refused > 0);
}

static void known_scenes_have_their_triangles(void **state) {
    (void)state;
    const char *folder = corpus();
    if (!folder) skip();
    static const struct {
        const char *file;
        size_t triangles; /* without those that have no area */
    } known[] = {{"sponza-crytek/sponza-crytek.obj", 262267 - 1},
                 {"sponza-dabrovic/sponza-dabrovic.obj", 66454 - 1},
                 {"veach-ajar/veach-ajar.obj", 23506 - 64},
                 {"luxcore-classroom/luxcore-classroom.obj", 111164 - 1},
                 {"fzk-haus/fzk-haus.obj", 35906 - 4},
                 {"map-complex/map-complex.obj", 12389 - 21},
                 {"godot-living-room/godot-living-room.obj", 5088 - 3573},
                 {"cornell-mcguire/CornellBox-Glossy.obj", 1112},
                 {"cornell-mcguire/CornellBox-Original.obj", 36},
                 {"cornell-mitsuba/cornell-mitsuba.obj", 38},
                 {"meshes/stanford-bunny.obj", 69451},
                 {"meshes/stanford-dragon-100k.obj", 100000},
                 {"meshes/spot.obj", 5856}};
    int found = 0;
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        char path[1024];
        struct stat about;
        snprintf(path, sizeof path, "%s/%s", folder, known[i].file);
        if (stat(path, &about) != 0) continue;
        sl_scene *scene;
        sl_error error = {0};
        if (sl_scene_load(path, &scene, &error) != SL_OK) fail_msg("%s", error.message);
        if (sl_scene_triangle_count(scene) != known[i].triangles) {
            fail_msg("%s: expected %zu triangles, got %zu", path, known[i].triangles,
                     sl_scene_triangle_count(scene));
        }
        sl_scene_destroy(scene);
        found++;
    }
    if (!found) skip();
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_file_loads_or_is_refused_with_one_line),
        cmocka_unit_test(known_scenes_have_their_triangles),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
