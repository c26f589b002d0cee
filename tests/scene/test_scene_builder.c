/* Scenes from arrays: the same bits as from files, by every method, and the same rules; what breaks them is
 * told in one line that names the culprit. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "unit_test.h"
#include "base/math.h"
#include "base/random.h"
#include "least_settings.h"
#include "rendering.h"
#include "scene/scene.h"
#include "scene_files.h"

#define GOOD(call)           \
    do {                     \
        sl_error said = {SL_OK, ""}, *error = &said; \
        good(call, error);   \
    } while (0)

static sl_scene_builder *new_builder(void) {
    sl_scene_builder *b;
    GOOD(sl_scene_builder_create(&b, error));
    return b;
}

static sl_scene *finish(sl_scene_builder *b) {
    sl_scene *scene;
    GOOD(sl_scene_builder_build(b, &scene, error));
    sl_scene_builder_destroy(b);
    return scene;
}

/* ---- the same as a file ---------------------------------------------------------------------- */

static void give_surfaces(sl_scene_builder *b, const sl_scene *s) {
    uint32_t number;
    for (size_t i = 0; i < s->texture_count; i++) {
        const sl_texture_data t = {.size = sizeof t,
                                   .name = s->textures[i].file,
                                   .width = s->textures[i].width,
                                   .height = s->textures[i].height,
                                   .channels = 4,
                                   .srgb = s->textures[i].texels};
        GOOD(sl_scene_builder_texture(b, &t, &number, error));
        assert_int_equal(number, i + 1);
    }
    for (size_t i = 0; i < s->material_count; i++) {
        sl_material_data d;
        assert_true(sl_scene_material(s, (uint32_t)i + 1, &d));
        GOOD(sl_scene_builder_material(b, &d, &number, error));
        assert_int_equal(number, i + 1);
    }
}

/* All triangles of one object, each with vertices of its own: equal ones become one. */
static void give_object(sl_scene_builder *b, const sl_scene *s, uint32_t object, bool borrowed) {
    enum { MOST = 4000 };
    static float positions[9 * MOST], normals[9 * MOST], uvs[6 * MOST];
    static uint32_t indices[3 * MOST], materials[MOST];
    sl_mesh_data d = {.size = sizeof d, .name = s->object_names[object], .positions = positions,
                      .normals = normals, .texture_coordinates = uvs, .indices = indices,
                      .materials = materials, .borrowed = borrowed};
    for (size_t t = 0; t < s->triangle_count; t++) {
        if (s->object_index[t] != object) continue;
        assert_true(d.triangle_count < MOST);
        for (size_t c = 0; c < 3; c++) {
            const uint32_t v = s->vertex[c][t];
            const size_t to = d.vertex_count++;
            memcpy(positions + 3 * to, (float[3]){s->position_x[v], s->position_y[v], s->position_z[v]}, 12);
            memcpy(normals + 3 * to, (float[3]){s->normal_x[v], s->normal_y[v], s->normal_z[v]}, 12);
            memcpy(uvs + 2 * to, (float[2]){s->texture_u[v], s->texture_v[v]}, 8);
            indices[to] = (uint32_t)to;
        }
        materials[d.triangle_count++] = s->material_index[t] + 1;
    }
    uint32_t mesh;
    GOOD(sl_scene_builder_mesh(b, &d, &mesh, error));
    const sl_instance_data instance = {.size = sizeof instance, .mesh = mesh};
    GOOD(sl_scene_builder_instance(b, &instance, error));
    if (!borrowed) memset(positions, 0xff, sizeof positions); /* they were copied */
}

static sl_scene_builder *give_all(const sl_scene *s) {
    sl_scene_builder *b = new_builder();
    give_surfaces(b, s);
    for (uint32_t i = 0; i < s->object_count; i++) give_object(b, s, i, i + 1 == s->object_count);
    if (s->environment.present)
        GOOD(sl_scene_builder_environment(b, s->environment.width, s->environment.height,
                                          s->environment.texels, error));
    GOOD(sl_scene_builder_film(b, s->film_width, s->film_height, error));
    return b;
}

static void assert_same_scene(sl_scene *made, sl_scene *loaded) {
    static const char *const methods[] = {"splatting",     "direct-radiance", "light-octree", "multi-mesh",
                                          "shading-cache", "path",            "bidirectional"};
    assert_true(sl_scene_hash(made) == sl_scene_hash(loaded));
    for (size_t m = 0; m < 7; m++) {
        const sl_settings settings = least_settings(methods[m], 16, 12);
        sl_image *a = render(made, &settings, NULL), *b = render(loaded, &settings, NULL);
        if (!same_picture(a, b)) fail_msg("%s draws another picture", methods[m]);
        destroy_pictures(a, b);
    }
    sl_scene_destroy(made);
    sl_scene_destroy(loaded);
}

static void the_cornell_box_from_arrays_is_that_of_its_file_by_every_method(void **state) {
    sl_scene *loaded = load_scene("scenes/cornell.json");
    sl_scene_builder *b = give_all(loaded);
    GOOD(sl_scene_builder_camera(b, (float[3]){278, 273, -800}, (float[3]){278, 273, 0}, (float[3]){0, 1, 0},
                                 (float)(39.3 * (SL_PI / 180.0)), error));
    assert_same_scene(finish(b), loaded);
}

static void write_sky(const char *name) {
    sl_image *sky = blank_image(8, 4, 3);
    for (int i = 0; i < 8 * 4 * 3; i++) sky->planes[i] = i % 7 == 0 ? 9.0f : 0.3f;
    assert_int_equal(sl_image_write(sky, scene_file_path(name), NULL), SL_OK);
    sl_image_destroy(sky);
}

#define SKY_AND_VIEW                                                                                       \
    "\"environment\": {\"file\": \"sky.exr\"}, \"camera\": {\"eye\": [0, 1.5, 1.9], \"target\": [0, 1.3, " \
    "-2], "                                                                                                \
    "\"fov_deg\": 75}, \"film\": {\"width\": 40, \"height\": 30}}"

static void look_likewise(sl_scene_builder *b) {
    GOOD(sl_scene_builder_camera(b, (float[3]){0, 1.5f, 1.9f}, (float[3]){0, 1.3f, -2}, (float[3]){0, 1, 0},
                                 (float)(75.0 * (SL_PI / 180.0)), error));
}

static sl_scene *load_bricks(void) {
    scene_file_copy("scenes/bricks.obj", "bricks.obj");
    scene_file_copy("scenes/bricks.png", "bricks.png");
    write_sky("sky.exr");
    return load_scene(scene_file_text(
        "bricks.json",
        "{\"softlux\": 1, \"meshes\": [{\"file\": \"bricks.obj\"}], \"materials\": {\"bricks\": "
        "{\"texture\": \"bricks.png\", \"specular\": 0.2, \"exponent\": 20, \"bump\": "
        "\"bricks.png\", \"bump_depth\": 0.1, \"alpha\": \"bricks.png\"}}, " SKY_AND_VIEW));
}

static void a_textured_scene_under_a_sky_is_that_of_its_file_by_every_method(void **state) {
    sl_scene *loaded = load_bricks();
    sl_scene_builder *b = give_all(loaded);
    look_likewise(b);
    assert_same_scene(finish(b), loaded);
}

/* ---- lights and instances -------------------------------------------------------------------- */

static const float corners[] = {-1, 0, -1, 1, 0, -1, 1, 0, 1, -1, 0, 1};
static const uint32_t square[] = {0, 2, 1, 0, 3, 2};

static sl_mesh_data floor_of(size_t vertices, const uint32_t *indices) {
    return (sl_mesh_data){.size = sizeof(sl_mesh_data), .name = "floor", .vertex_count = vertices,
                          .positions = corners, .triangle_count = 2, .indices = indices};
}

static uint32_t add_floor(sl_scene_builder *b) {
    const sl_mesh_data d = floor_of(4, square);
    uint32_t mesh;
    GOOD(sl_scene_builder_mesh(b, &d, &mesh, error));
    return mesh;
}

static const double quarter = SL_PI / 180.0 * 25.0, third = SL_PI / 180.0 * 40.0;
static const char lights_of_file[] =
    "\"lights\": [{\"type\": \"point\", \"position\": [0.1, 2, 0], \"power\": [5, 6, 7]},\n"
    "{\"type\": \"spot\", \"position\": [1, 2, 0], \"direction\": [-0.3, -1, 0.1], \"intensity\": 3, "
    "\"inner_deg\": 25, \"outer_deg\": 40},\n"
    "{\"type\": \"directional\", \"direction\": [0.2, -1, 0.3], \"irradiance\": [1, 2, 3]},\n"
    "{\"type\": \"quad\", \"corner\": [0.1, 1.7, 0.3], \"edge1\": [0.3, 0, 0], \"edge2\": [0.1, 0, 0.4], "
    "\"power\": 9, \"two_sided\": true}], ";

static void add_lights(sl_scene_builder *b) {
    const size_t size = sizeof(sl_light_data);
    const sl_light_data lights[] = {
        {.size = size, .position = {0.1, 2, 0}, .strength = {5, 6, 7}, .is_power = true},
        {.size = size, .type = SL_LIGHT_SPOT, .position = {1, 2, 0}, .direction = {-0.3, -1, 0.1},
         .strength = {3, 3, 3}, .inner_rad = quarter, .outer_rad = third},
        {.size = size, .type = SL_LIGHT_DIRECTIONAL, .direction = {0.2, -1, 0.3}, .strength = {1, 2, 3}},
        {.size = size, .type = SL_LIGHT_QUAD, .position = {0.1, 1.7, 0.3}, .edge1 = {0.3, 0, 0},
         .edge2 = {0.1, 0, 0.4}, .strength = {9, 9, 9}, .is_power = true, .two_sided = true}};
    for (int i = 0; i < 4; i++) GOOD(sl_scene_builder_light(b, &lights[i], error));
}

static void lights_and_placed_meshes_are_those_of_a_file(void **state) {
    static const double mirrored[16] = {-0.7, 0, 0.1, 0, 0.2, 0.9, 0, 0, 0, 0.3, 1, 0, 0.5, 0.25, -2, 1};
    scene_file_text("floor.obj",
                    "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\no floor\nf 1 3 2\nf 1 4 3\n");
    write_sky("sky.exr");
    char text[2000];
    snprintf(text, sizeof text,
             "{\"softlux\": 1, \"meshes\": [{\"file\": \"floor.obj\"}, {\"file\": \"floor.obj\", "
             "\"transform\": [-0.7, 0, 0.1, 0, 0.2, 0.9, 0, 0, 0, 0.3, 1, 0, 0.5, 0.25, -2, 1]}], %s%s",
             lights_of_file, SKY_AND_VIEW);
    sl_scene *loaded = load_scene(scene_file_text("lights.json", text));
    sl_scene_builder *b = new_builder();
    uint32_t of_file[2];
    for (int i = 0; i < 2; i++) { /* that every OBJ file brings along */
        const sl_material_data grey = {
            .size = sizeof grey, .name = "DefaultMaterial", .diffuse = {0.6f, 0.6f, 0.6f}};
        GOOD(sl_scene_builder_material(b, &grey, &of_file[i], error));
    }
    const uint32_t mesh = add_floor(b);
    for (int i = 0; i < 2; i++) {
        const sl_instance_data d = {.size = sizeof d, .mesh = mesh, .material = of_file[i],
                                    .transform = i ? mirrored : NULL};
        GOOD(sl_scene_builder_instance(b, &d, error));
    }
    add_lights(b);
    GOOD(sl_scene_builder_environment(b, 8, 4, loaded->environment.texels, error));
    look_likewise(b);
    GOOD(sl_scene_builder_film(b, 40, 30, error));
    assert_same_scene(finish(b), loaded);
}

static void what_is_not_given_is_as_in_a_file_that_does_not_say(void **state) {
    sl_scene_builder *b = new_builder();
    const uint32_t mesh = add_floor(b);
    for (int i = 0; i < 2; i++) {
        const sl_instance_data d = {.size = sizeof d, .mesh = mesh, .name = i ? "second" : NULL};
        GOOD(sl_scene_builder_instance(b, &d, error));
    }
    GOOD(sl_scene_builder_environment(b, 0, 0, (float[3]){1, 2, 3}, error));
    sl_scene *s = finish(b);
    int width, height;
    sl_scene_film(s, &width, &height);
    assert_true(width == 512 && height == 512 && s->environment.constant.g == 2.0f);
    assert_string_equal(s->object_names[0], "floor");
    assert_string_equal(s->object_names[1], "second");
    assert_true(s->material_count == 1 && s->materials[0].diffuse.r == 0.5f && s->triangle_count == 4);
    assert_non_null(strstr(sl_scene_warning(s, 0), "no camera"));
    sl_scene_destroy(s);
}

static void texels_in_linear_light_are_the_nearest_bytes(void **state) {
    float linear[2 * 256 * 2];
    uint8_t srgb[2 * 256 * 2];
    for (int i = 0; i < 512; i++) {
        srgb[2 * i] = (uint8_t)(i % 256);
        srgb[2 * i + 1] = (uint8_t)(255 - i % 256);
        const double code = i % 256 / 255.0;
        linear[2 * i] = (float)(code <= 0.04045 ? code / 12.92 : pow((code + 0.055) / 1.055, 2.4));
        linear[2 * i + 1] = (float)(255 - i % 256) / 255.0f;
    }
    sl_scene_builder *b = new_builder();
    for (int i = 0; i < 2; i++) {
        const sl_texture_data t = {.size = sizeof t, .name = "ramp", .width = 256, .height = 2, .channels = 2,
                                   .srgb = i ? NULL : srgb, .linear = i ? linear : NULL};
        uint32_t number;
        GOOD(sl_scene_builder_texture(b, &t, &number, error));
        assert_int_equal(number, i + 1);
    }
    const sl_instance_data d = {.size = sizeof d, .mesh = add_floor(b)};
    GOOD(sl_scene_builder_instance(b, &d, error));
    sl_scene *s = finish(b);
    assert_memory_equal(s->textures[0].texels, s->textures[1].texels, 4 * 512);
    assert_true(s->textures[0].has_alpha && s->textures[0].texels[4 * 3 + 2] == 3);
    sl_scene_destroy(s);
}

/* ---- what is refused ------------------------------------------------------------------------- */

static void refused(sl_status status, const sl_error *error, sl_status wanted, const char *words) {
    if (status != wanted || error->status != wanted || !strstr(error->message, words) ||
        strchr(error->message, '\n'))
        fail_msg("status %d, '%s' instead of '%s'", (int)status, error->message, words);
}
#define REFUSED(wanted, words, call)  \
    do {                              \
        sl_error said = {SL_OK, ""}, *error = &said; \
        const sl_status got = (call); \
        refused(got, error, wanted, words); \
    } while (0)
#define INPUT(words, call) REFUSED(SL_ERROR_INPUT, words, call)
#define USAGE(words, call) REFUSED(SL_ERROR_USAGE, words, call)

static void meshes_and_instances_that_break_a_rule_are_told_by_name_and_index(void **state) {
    static const uint32_t wild[] = {0, 2, 1, 0, 12, 2}, materials[] = {0, 9};
    static const double flat[16] = {1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    sl_scene_builder *b = new_builder();
    sl_mesh_data d = floor_of(4, wild);
    uint32_t mesh = 7;
    INPUT("mesh 'floor': index 4 of triangle 1 is 12, the mesh has 4 vertices",
          sl_scene_builder_mesh(b, &d, &mesh, error));
    assert_int_equal(mesh, 0);
    d = floor_of(4, square);
    d.materials = materials;
    INPUT("mesh 'floor': the material of triangle 1 is number 9, of 0",
          sl_scene_builder_mesh(b, &d, &mesh, error));
    d.materials = NULL;
    d.positions = NULL;
    d.name = NULL;
    INPUT("mesh 'mesh 1': expected its vertices' positions", sl_scene_builder_mesh(b, &d, &mesh, error));
    d.size = 3;
    USAGE("'size' of sl_mesh_data", sl_scene_builder_mesh(b, &d, &mesh, error));
    d.size = sizeof d + 8;
    USAGE("'size' of sl_mesh_data", sl_scene_builder_mesh(b, &d, &mesh, error));
    sl_instance_data i = {.size = sizeof i, .mesh = add_floor(b), .name = "x", .transform = flat};
    INPUT("instance 'x': expected 'transform' to be a matrix", sl_scene_builder_instance(b, &i, error));
    i.material = 3;
    INPUT("instance 'x': 'material' is number 3, of 0", sl_scene_builder_instance(b, &i, error));
    i.mesh = 2;
    INPUT("instance 'x': 'mesh' is number 2, of 1", sl_scene_builder_instance(b, &i, error));
    sl_scene_builder_destroy(b);
}

static void surfaces_that_break_a_rule_are_told_by_name(void **state) {
    const float texels[] = {0, 1, 0.5f, 0, NAN, 0};
    const uint8_t bytes[6] = {0};
    uint32_t number;
    sl_scene_builder *b = new_builder();
    sl_texture_data t = {
        .size = sizeof t, .name = "wood", .width = 2, .height = 1, .channels = 3, .linear = texels};
    INPUT("texture 'wood': row 0, column 1: expected 'linear' from 0 to 1, got ",
          sl_scene_builder_texture(b, &t, &number, error));
    t.srgb = bytes;
    INPUT("expected either 'srgb' or 'linear'", sl_scene_builder_texture(b, &t, &number, error));
    t.channels = 5;
    INPUT("expected 'channels' from 1 to 4, got 5", sl_scene_builder_texture(b, &t, &number, error));
    const sl_material_data fine = {.size = sizeof fine, .name = "oak"};
    sl_material_data m = fine;
    m.diffuse[1] = 1.5f;
    INPUT("material 'oak': expected 'diffuse' from 0 to 1, got 1.5",
          sl_scene_builder_material(b, &m, &number, error));
    m = fine;
    m.emission[2] = INFINITY;
    INPUT("material 'oak': expected 'emission' from 0 to", sl_scene_builder_material(b, &m, &number, error));
    m = fine;
    m.mirror[0] = m.specular[0] = 0.5f;
    INPUT("expected either 'mirror'", sl_scene_builder_material(b, &m, &number, error));
    m = fine;
    m.bump = 1;
    INPUT("material 'oak': 'bump' is number 1, of 0", sl_scene_builder_material(b, &m, &number, error));
    sl_scene_builder_destroy(b);
}

static void lights_cameras_and_films_that_break_a_rule_are_told(void **state) {
    const float here[3] = {0, 0, 1}, up[3] = {0, 1, 0};
    sl_scene_builder *b = new_builder();
    sl_light_data l = {.size = sizeof l, .type = SL_LIGHT_SPOT, .name = "lamp", .direction = {0, -1, 0},
                       .inner_rad = third, .outer_rad = quarter};
    INPUT("light 'lamp': expected 'inner_deg' of at most 'outer_deg', 25",
          sl_scene_builder_light(b, &l, error));
    l.is_power = true;
    INPUT("only point and quad lights have 'power'", sl_scene_builder_light(b, &l, error));
    l.direction[1] = 0.0;
    INPUT("expected 'direction' to be other than 0", sl_scene_builder_light(b, &l, error));
    l.type = SL_LIGHT_QUAD;
    INPUT("expected a quad light with an area", sl_scene_builder_light(b, &l, error));
    l.position[1] = (double)NAN;
    INPUT("expected 'corner' from", sl_scene_builder_light(b, &l, error));
    l.type = (sl_light_type)9;
    INPUT("unknown light type 9", sl_scene_builder_light(b, &l, error));
    INPUT("camera: expected the camera's 'eye' apart from",
          sl_scene_builder_camera(b, here, here, up, 1.0f, error));
    INPUT("camera: expected 'fov_deg' from 0.01 to 179",
          sl_scene_builder_camera(b, here, up, up, 3.2f, error));
    INPUT("film: expected 'height' from 1 to 65536, got 0", sl_scene_builder_film(b, 4, 0, error));
    INPUT("environment: expected 'width'", sl_scene_builder_environment(b, -1, 4, here, error));
    INPUT("environment: expected 'radiance'",
          sl_scene_builder_environment(b, 0, 0, (float[3]){0, -1, 0}, error));
    sl_scene *scene = (void *)(uintptr_t)64;
    INPUT("no triangles", sl_scene_builder_build(b, &scene, error));
    assert_null(scene);
    USAGE("can only be destroyed", sl_scene_builder_film(b, 4, 4, error));
    USAGE("can only be destroyed", sl_scene_builder_build(b, &scene, error));
    sl_scene_builder_destroy(b);
}

static void nulls_are_refused(void **state) {
    sl_scene_builder *b = new_builder();
    uint32_t n;
    const float v[3] = {0, 0, 1};
    USAGE("builder", sl_scene_builder_create(NULL, error));
    USAGE("builder", sl_scene_builder_texture(b, NULL, &n, error));
    USAGE("builder", sl_scene_builder_material(b, NULL, &n, error));
    USAGE("builder", sl_scene_builder_mesh(NULL, NULL, &n, error));
    USAGE("builder", sl_scene_builder_mesh(b, &(sl_mesh_data){.size = sizeof(sl_mesh_data)}, NULL, error));
    USAGE("builder", sl_scene_builder_instance(b, NULL, error));
    USAGE("builder", sl_scene_builder_light(b, NULL, error));
    USAGE("builder", sl_scene_builder_environment(b, 1, 1, NULL, error));
    USAGE("builder", sl_scene_builder_camera(b, v, NULL, v, 1.0f, error));
    USAGE("builder", sl_scene_builder_film(NULL, 1, 1, error));
    USAGE("builder", sl_scene_builder_build(b, NULL, error));
    sl_scene_builder_destroy(b);
    sl_scene_builder_destroy(NULL);
}

/* ---- inputs that nobody wrote ---------------------------------------------------------------- */

static uint64_t trial, rolled;
static uint32_t roll(uint32_t sides) { return sl_random_bits(sl_random_key(28, trial), rolled++) % sides; }
static float odd(void) {
    static const float values[] = {0,     1,       -1,     0.5f, 0.3f, 1e-30f,  1e30f,
                                   -0.0f, 3.4e38f, 1e-45f, 2,    NAN,  INFINITY};
    return values[roll(roll(8) ? 6 : 13)];
}
static void fill(float *to, int count) {
    for (int i = 0; i < count; i++) to[i] = odd();
}
static void fill_doubles(double *to, int count) {
    for (int i = 0; i < count; i++) to[i] = (double)odd() * (roll(9) ? 1.0 : 1e300);
}

static void one_clear_line(sl_status status, const sl_error *error) {
    const size_t length = strlen(error->message);
    assert_true(status == SL_OK || status == SL_ERROR_INPUT || status == SL_ERROR_USAGE);
    if (status != SL_OK) assert_true(length > 10 && length < 500 && !strchr(error->message, '\n'));
}
#define EITHER(call)                  \
    do {                              \
        sl_error said = {SL_OK, ""}, *error = &said; \
        one_clear_line(call, error);  \
    } while (0)

static void add_anything(sl_scene_builder *b) {
    float numbers[64], v[9];
    double matrix[16];
    uint8_t bytes[64];
    uint32_t indices[12], number;
    fill(numbers, 64);
    fill(v, 9);
    fill_doubles(matrix, 16);
    if (roll(4)) matrix[3] = matrix[7] = matrix[11] = 0.0, matrix[15] = 1.0;
    for (int i = 0; i < 12; i++) indices[i] = roll(10) ? roll(4) : roll(UINT32_MAX);
    memset(bytes, (int)roll(256), sizeof bytes);
    sl_texture_data t = {
        .size = sizeof t, .width = (int)roll(5) - 1, .height = (int)roll(4), .channels = (int)roll(5)};
    if (roll(2)) t.srgb = bytes;
    else t.linear = numbers;
    sl_material_data m = {.size = roll(20) ? sizeof m : roll(300), .exponent = odd(), .two_sided = roll(2),
                          .texture = roll(3), .alpha = roll(3), .bump = roll(3), .bump_depth = odd()};
    fill(roll(2) ? m.diffuse : m.mirror, 3);
    fill(roll(2) ? m.specular : m.emission, 3);
    sl_mesh_data d = {.size = sizeof d,
                      .name = roll(2) ? "a\nb" : NULL,
                      .vertex_count = 3 + roll(3),
                      .positions = numbers,
                      .normals = roll(2) ? numbers : NULL,
                      .texture_coordinates = roll(2) ? numbers : NULL,
                      .triangle_count = roll(4),
                      .indices = indices,
                      .materials = roll(3) ? NULL : indices,
                      .material = roll(3)};
    const sl_instance_data i = {
        .size = sizeof i, .mesh = roll(5), .material = roll(4), .transform = roll(2) ? matrix : NULL};
    sl_light_data l = {.size = sizeof l,
                       .type = (sl_light_type)roll(5),
                       .is_power = roll(2),
                       .two_sided = roll(2),
                       .inner_rad = (double)odd(),
                       .outer_rad = (double)odd()};
    fill_doubles(l.position, 3);
    fill_doubles(l.direction, 3);
    fill_doubles(l.edge1, 3);
    fill_doubles(l.edge2, 3);
    fill(l.strength, 3);
    switch (roll(9)) {
    case 0: EITHER(sl_scene_builder_texture(b, &t, &number, error)); break;
    case 1: EITHER(sl_scene_builder_material(b, &m, &number, error)); break;
    case 2: EITHER(sl_scene_builder_light(b, &l, error)); break;
    case 3: EITHER(sl_scene_builder_environment(b, (int)roll(5), (int)roll(4), numbers, error)); break;
    case 4: EITHER(sl_scene_builder_camera(b, v, v + 3, v + 6, odd(), error)); break;
    case 5: EITHER(sl_scene_builder_film(b, (int)roll(40) - 1, (int)roll(40), error)); break;
    case 6: EITHER(sl_scene_builder_mesh(b, &d, &number, error)); break;
    default: EITHER(sl_scene_builder_instance(b, &i, error));
    }
}

static void random_inputs_give_a_scene_or_one_line_and_never_crash(void **state) {
    enum { TRIALS = 4000 };
    int built = 0;
    for (uint32_t k = 0; k < TRIALS; k++) {
        sl_scene_builder *b = new_builder();
        sl_scene *scene;
        trial = k;
        if (roll(2)) add_floor(b);
        for (uint32_t steps = roll(30); steps > 0; steps--) add_anything(b);
        EITHER(sl_scene_builder_build(b, &scene, error));
        built += scene != NULL;
        sl_scene_destroy(scene);
        sl_scene_builder_destroy(b);
    }
    assert_true(built > TRIALS / 20 && built < TRIALS);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_cornell_box_from_arrays_is_that_of_its_file_by_every_method),
        cmocka_unit_test(a_textured_scene_under_a_sky_is_that_of_its_file_by_every_method),
        cmocka_unit_test(lights_and_placed_meshes_are_those_of_a_file),
        cmocka_unit_test(what_is_not_given_is_as_in_a_file_that_does_not_say),
        cmocka_unit_test(texels_in_linear_light_are_the_nearest_bytes),
        cmocka_unit_test(meshes_and_instances_that_break_a_rule_are_told_by_name_and_index),
        cmocka_unit_test(surfaces_that_break_a_rule_are_told_by_name),
        cmocka_unit_test(lights_cameras_and_films_that_break_a_rule_are_told),
        cmocka_unit_test(nulls_are_refused),
        cmocka_unit_test(random_inputs_give_a_scene_or_one_line_and_never_crash),
    };
    return cmocka_run_group_tests(tests, NULL, scene_files_teardown);
}
