/* A scene reaches the files of its own folder, and others only where that is allowed. */
#define _XOPEN_SOURCE 700
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "unit_test.h"
#include "rendering.h"
#include "scene/scene.h"
#include "scene_files.h"

/* secret.* and inside/scene.json; what lies below inside/ may be read. */
static const char *at(const char *name) { return scene_file_path(name); }

static void write_text(const char *name, const char *text) { scene_file_text(name, text); }

static const char triangle[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\n";
/* TGA, one pixel */
static const uint8_t picture[] = {0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 1, 0, 24, 0, 10, 20, 30};

static int make_folders(void **state) {
    if (mkdir(at("inside"), 0700) != 0 || mkdir(at("inside/below"), 0700) != 0) return 1;
    write_text("secret.obj", triangle);
    write_text("secret.mtl", "newmtl m\nKd 1 0 0\n");
    scene_file_write("secret.tga", picture, sizeof picture);
    scene_file_write("secret.bin", (float[9]){0, 0, 0, 1, 0, 0, 0, 1, 0}, 36);
    write_text("secret.pfm", "PF\n1 1\n-1.0\nabcdefghijkl");
    write_text("inside/mesh.obj", triangle);
    scene_file_write("inside/below/inner.tga", picture, sizeof picture);
    return symlink("../secret.obj", at("inside/link.obj")) | symlink(at(""), at("inside/up")) |
           symlink("inside/mesh.obj", at("named.obj"));
}

/* Refused with one line that names the place, the file and the way to allow it; and allowed where that is
 * asked for. */
static void expect_refusal(const char *scene_file, const char *place, const char *file) {
    const char *message = load_refused(at(scene_file));
    const char *const words[] = {at(place), file, "lies outside of the scene's folder", "--allow-outside"};
    for (size_t i = 0; i < 4; i++) {
        if (!strstr(message, words[i])) fail_msg("'%s' does not say '%s'", message, words[i]);
    }
    sl_scene *scene = NULL;
    sl_error error;
    if (sl_scene_load_with(at(scene_file), &(sl_load_options){.allow_outside = true}, &scene, &error) !=
        SL_OK)
        fail_msg("%s", error.message);
    sl_scene_destroy(scene);
}

static void expect_scene(const char *scene_file) { sl_scene_destroy(load_scene(at(scene_file))); }

static void scene_of(const char *format, const char *name) {
    char text[512];
    snprintf(text, sizeof text, format, name);
    write_text("inside/scene.json", text);
}

static void meshes_outside_are_refused_whatever_leads_there(void **state) {
    static const char format[] = "{\"softlux\": 1,\n \"meshes\": [\n  {\"file\": \"%s\"}]}";
    const char *const names[] = {"../secret.obj", "link.obj", "up/secret.obj", "below/../../secret.obj",
                                 at("secret.obj")};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        scene_of(format, names[i]);
        expect_refusal("inside/scene.json", "inside/scene.json:3: mesh ", i == 1 ? "link.obj" : "secret.obj");
    }
    const char *const good[] = {"mesh.obj",           "./mesh.obj",         "below/../mesh.obj",
                                "../inside/mesh.obj", "up/inside/mesh.obj", at("inside/mesh.obj")};
    for (size_t i = 0; i < sizeof good / sizeof good[0]; i++) {
        scene_of(format, good[i]);
        expect_scene("inside/scene.json");
    }
}

static void textures_masks_and_skies_outside_are_refused(void **state) {
    static const char *const formats[] = {
        "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\", \"material\": \"n\"}],\n\"materials\": "
        "{\"n\": {\"texture\": \"%s\"}}}",
        "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\", \"material\": \"n\"}],\n\"materials\": "
        "{\"n\": {\"alpha\": \"%s\"}}}",
        "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\", \"material\": \"n\"}],\n\"materials\": "
        "{\"n\": {\"bump\": \"%s\"}}}",
        "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\"}],\n\"environment\": {\"file\": \"%s\"}}"};
    for (int i = 0; i < 4; i++) {
        scene_of(formats[i], i < 3 ? "../secret.tga" : "../secret.pfm");
        expect_refusal("inside/scene.json", "inside/scene.json:2: ", i < 3 ? "secret.tga" : "secret.pfm");
    }
    scene_of(formats[0], "below/inner.tga");
    expect_scene("inside/scene.json");
}

static void what_mesh_files_name_outside_is_refused(void **state) {
    char text[600];
    snprintf(text, sizeof text, "mtllib ../secret.mtl\n%s", triangle);
    write_text("inside/a.obj", text);
    expect_refusal("inside/a.obj", "inside/a.obj: names ", "secret.mtl");
    snprintf(text, sizeof text, "mtllib a.mtl\n%s", triangle);
    write_text("inside/a.obj", text);
    write_text("inside/a.mtl", "newmtl m\nmap_Kd ../secret.tga\n");
    expect_refusal("inside/a.obj", "inside/a.mtl:2: texture ", "secret.tga");
    snprintf(text, sizeof text, "newmtl m\nmap_Kd %s\n", at("secret.tga"));
    write_text("inside/a.mtl", text);
    expect_refusal("inside/a.obj", "inside/a.mtl:2: texture ", "secret.tga");
    write_text("inside/a.mtl", "newmtl m\nmap_Kd below\\inner.tga\n");
    expect_scene("inside/a.obj");
}

/* The folder of the machine that wrote the file is not asked for where the picture lies beside it. */
static void a_texture_beside_its_mesh_is_taken_whatever_folder_is_named(void **state) {
    char text[300];
    snprintf(text, sizeof text, "mtllib a.mtl\n%s", triangle);
    write_text("inside/a.obj", text);
    write_text("inside/a.mtl", "newmtl m\nmap_Kd ../secret.tga\n");
    scene_file_write("t.tga", picture, sizeof picture);
    scene_file_write("inside/t.tga", picture, sizeof picture);
    write_text("inside/a.mtl", "newmtl m\nmap_Kd ../t.tga\n");
    expect_scene("inside/a.obj");
    unlink(at("t.tga"));
}

static void buffers_of_gltf_outside_are_refused(void **state) {
    write_text("inside/a.gltf", "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
                                "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":"
                                "{\"POSITION\":0}}]}],\"accessors\":[{\"bufferView\":0,\"componentType\":"
                                "5126,\"count\":3,\"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[1,1,0]}],"
                                "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"buffers\":[{"
                                "\"byteLength\":36,\"uri\":\"../secret.bin\"}]}");
    expect_refusal("inside/a.gltf", "inside/a.gltf: names ", "secret.bin");
}

static void a_link_that_is_asked_for_by_name_is_followed(void **state) {
    expect_scene("named.obj");
    expect_scene("inside/link.obj");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(meshes_outside_are_refused_whatever_leads_there),
        cmocka_unit_test(textures_masks_and_skies_outside_are_refused),
        cmocka_unit_test(what_mesh_files_name_outside_is_refused),
        cmocka_unit_test(a_texture_beside_its_mesh_is_taken_whatever_folder_is_named),
        cmocka_unit_test(buffers_of_gltf_outside_are_refused),
        cmocka_unit_test(a_link_that_is_asked_for_by_name_is_followed),
    };
    return cmocka_run_group_tests(tests, make_folders, scene_files_teardown);
}
