/* Scenes that are written: read again they are the same, to the bits of their pictures. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "unit_test.h"
#include "base/math.h"
#include "base/random.h"
#include "least_settings.h"
#include "rendering.h"
#include "scene/lines.h"
#include "scene/scene.h"
#include "scene_files.h"

static sl_scene *write_and_read(const sl_scene *scene, const char *name) {
    sl_error error;
    scene_file_text(name, "");
    if (sl_scene_write(scene, scene_file_path(name), &error) != SL_OK) fail_msg("%s", error.message);
    return load_scene(scene_file_path(name));
}

static void assert_same_pictures(const sl_scene *a, const sl_scene *b, const char *what) {
    static const char *const methods[] = {"splatting",     "direct-radiance", "light-octree", "multi-mesh",
                                          "shading-cache", "path",            "bidirectional"};
    for (size_t m = 0; m < 7; m++) {
        const sl_settings settings = least_settings(methods[m], 16, 12);
        sl_image *x = render(a, &settings, NULL), *y = render(b, &settings, NULL);
        if (!same_picture(x, y)) fail_msg("%s: %s draws another picture", what, methods[m]);
        destroy_pictures(x, y);
    }
}

static void a_written_scene_is_the_same_scene(void **state) {
    static const char *const names[] = {"cornell",     "cornell-mirror", "cornell-point", "bricks",
                                        "mirror-balls", "sphere",        "two-rooms"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char path[64];
        snprintf(path, sizeof path, "scenes/%s.json", names[i]);
        sl_scene *scene = load_scene(path), *again = write_and_read(scene, "again.json");
        if (sl_scene_hash(scene) != sl_scene_hash(again)) fail_msg("%s: another hash", names[i]);
        if (i == 0 || i == 3) assert_same_pictures(scene, again, names[i]);
        sl_scene_destroy(scene);
        sl_scene_destroy(again);
    }
}

static void surfaces_and_triangles_around_them_keep_their_order(void **state) {
    sl_scene *scene = load_scene("scenes/vase.json"), *again = write_and_read(scene, "vase.json");
    assert_true(scene->bicubic_count > 0 && again->bicubic_count == scene->bicubic_count);
    assert_true(again->triangle_count == scene->triangle_count && again->vertex_count == scene->vertex_count);
    for (size_t t = 0; t < scene->triangle_count; t++) {
        for (int c = 0; c < 3; c++) assert_int_equal(again->vertex[c][t], scene->vertex[c][t]);
    }
    assert_same_pictures(scene, again, "vase");
    sl_scene_destroy(scene);
    sl_scene_destroy(again);
}

/* Two materials and two objects of one name, which no file could have; a mask; every kind of light. */
static sl_scene *odd_scene(void) {
    static const float corners[] = {-2, 0, -2, 2, 0, -2, 2, 0, 2, -2, 0, 2},
                       normals[] = {0.1f, 1, 0, 0, 1, 0.3f, -0.2f, 0.9f, 0.1f, 0, 3, 0},
                       uvs[] = {0, 0, 1e-9f, 1, 1, 1 / 3.0f, 7e-20f, -2.5f},
                       sky[] = {1, 2, 3, 0.1f, 1e-30f, 0};
    static const uint32_t indices[] = {0, 2, 1, 0, 3, 2};
    static const uint8_t texels[] = {10, 20, 30, 255, 40, 50, 60, 7};
    static const double lifted[16] = {0.3, 0, 0.1, 0, 0, 0.3, 0, 0, 0, 0, 0.3, 0, 0, 1.1, 0, 1};
    const size_t size = sizeof(sl_light_data);
    const sl_light_data lights[] = {
        {.size = size, .position = {0.1, 2, 0}, .strength = {5, 6, 7}},
        {.size = size, .type = SL_LIGHT_SPOT, .position = {1, 2, 0}, .direction = {-0.3, -1, 0.1},
         .strength = {3, 3, 3}, .inner_rad = 0.001, .outer_rad = 1.234567},
        {.size = size, .type = SL_LIGHT_DIRECTIONAL, .direction = {0.2, -1, 0.3}, .strength = {1, 2, 3}},
        {.size = size, .type = SL_LIGHT_QUAD, .position = {0.1, 1.7, 0.3}, .edge1 = {0.3, 0, 0},
         .edge2 = {0.1, 0, 0.4}, .strength = {9, 9, 9}, .name = "a \"lamp\"\n"}};
    sl_scene_builder *b;
    sl_scene *scene;
    const sl_texture_data t = {.size = sizeof t, .width = 2, .height = 1, .channels = 4, .srgb = texels};
    sl_material_data paint = {.size = sizeof paint, .name = "paint # 1 ", .diffuse = {1 / 3.0f, 0.2f, 0.1f},
                              .exponent = 0.1f, .bump_depth = 0.7f};
    sl_mesh_data mesh = {.size = sizeof mesh, .name = "\\", .vertex_count = 4, .positions = corners,
                         .normals = normals, .texture_coordinates = uvs, .triangle_count = 2,
                         .indices = indices};
    assert_int_equal(sl_scene_builder_create(&b, NULL), SL_OK);
    assert_int_equal(sl_scene_builder_texture(b, &t, &paint.texture, NULL), SL_OK);
    paint.bump = paint.alpha = paint.texture;
    for (int i = 0; i < 2; i++) {
        sl_instance_data placed = {.size = sizeof placed, .transform = i ? lifted : NULL};
        assert_int_equal(sl_scene_builder_material(b, &paint, &mesh.material, NULL), SL_OK);
        assert_int_equal(sl_scene_builder_mesh(b, &mesh, &placed.mesh, NULL), SL_OK);
        assert_int_equal(sl_scene_builder_instance(b, &placed, NULL), SL_OK);
        paint.texture = paint.alpha = paint.bump = 0;
        paint.specular[1] = 0.3f;
    }
    for (int i = 0; i < 4; i++) assert_int_equal(sl_scene_builder_light(b, &lights[i], NULL), SL_OK);
    assert_int_equal(sl_scene_builder_environment(b, 1, 2, sky, NULL), SL_OK);
    assert_int_equal(sl_scene_builder_camera(b, (float[3]){0.1f, 2, 5}, (float[3]){0.3f, 0.2f, 0},
                                             (float[3]){0.1f, 1, 0.2f}, 0.77f, NULL), SL_OK);
    assert_int_equal(sl_scene_builder_build(b, &scene, NULL), SL_OK);
    sl_scene_builder_destroy(b);
    return scene;
}

static void names_that_files_cannot_have_and_odd_numbers_do_no_harm(void **state) {
    sl_scene *scene = odd_scene(), *again = write_and_read(scene, "a \"name\" #1.json");
    assert_true(again->object_count == 3 && again->light_count == 3 && again->textures[0].has_alpha);
    assert_string_equal(again->object_names[0], "_");
    assert_string_equal(again->object_names[1], "object-1");
    assert_string_equal(again->object_names[2], "a _lamp__");
    assert_memory_equal(&again->camera, &scene->camera, sizeof scene->camera);
    assert_memory_equal(again->lights, scene->lights, 3 * sizeof *scene->lights);
    assert_same_pictures(scene, again, "odd");
    /* OBJ files bring a material along, once */
    sl_scene *third = write_and_read(again, "third.json");
    assert_true(sl_scene_hash(third) == sl_scene_hash(again));
    sl_scene_destroy(scene);
    sl_scene_destroy(again);
    sl_scene_destroy(third);
}

static void a_constant_sky_stays_constant_and_any_camera_its_frame(void **state) {
    sl_scene *scene = load_scene("scenes/sphere.json");
    const uint64_t key = sl_random_key(1, 2);
    scene->environment = (sl_environment){.present = true, .constant = {0.1f, 1 / 3.0f, 7e8f}};
    for (uint64_t i = 0; i < 20; i++) {
        float v[10];
        for (uint64_t k = 0; k < 10; k++) v[k] = sl_random_unit(key, 10 * i + k) + 0.001f;
        assert_int_equal(sl_scene_set_camera(scene, v, v + 3, v + 6, 3.1415f * v[9] / 1.001f, NULL), SL_OK);
        sl_scene *again = write_and_read(scene, "sky.json");
        assert_true(sl_scene_hash(again) == sl_scene_hash(scene));
        sl_scene_destroy(again);
    }
    sl_scene_destroy(scene);
}

static void numbers_in_mesh_files_are_read_back_to_the_bit(void **state) {
    const uint64_t key = sl_random_key(3, 4);
    char text[SL_NUMBER_ROOM];
    for (uint64_t i = 0; i < 200000; i++) {
        const uint32_t bits = sl_random_bits(key, i) >> (i % 5 ? 0 : i % 31);
        float value, read = 0.0f;
        memcpy(&value, &bits, sizeof value);
        if (!isfinite(value)) continue;
        sl_write_number(value, text);
        assert_true(sl_read_number(text, &read));
        if (memcmp(&read, &value, sizeof value) != 0)
            fail_msg("%.9g as %s is %.9g", (double)value, text, (double)read);
    }
}

static void what_cannot_be_written_is_told(void **state) {
    sl_scene *scene = load_scene("scenes/cornell.json");
    sl_error error;
    assert_int_equal(sl_scene_write(scene, "scene.obj", &error), SL_ERROR_USAGE);
    assert_non_null(strstr(error.message, "must end in .json"));
    assert_int_equal(sl_scene_write(scene, "/nowhere/at/all.json", &error), SL_ERROR_OUTPUT);
    assert_non_null(strstr(error.message, "cannot write /nowhere/at/all"));
    assert_int_equal(sl_scene_write(NULL, "a.json", &error), SL_ERROR_USAGE);
    assert_int_equal(sl_scene_write(scene, NULL, NULL), SL_ERROR_USAGE);
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_written_scene_is_the_same_scene),
        cmocka_unit_test(surfaces_and_triangles_around_them_keep_their_order),
        cmocka_unit_test(names_that_files_cannot_have_and_odd_numbers_do_no_harm),
        cmocka_unit_test(a_constant_sky_stays_constant_and_any_camera_its_frame),
        cmocka_unit_test(numbers_in_mesh_files_are_read_back_to_the_bit),
        cmocka_unit_test(what_cannot_be_written_is_told),
    };
    return cmocka_run_group_tests(tests, NULL, scene_files_teardown);
}
