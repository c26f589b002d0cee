/* Features of glTF files beyond plain surfaces: had as they are meant, told in a line, or refused. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "unit_test.h"
#include "scene/scene.h"
#include "rendering.h"
#include "scene_files.h"

/* A triangle with uv (0,0) (1,0) (0,1) and a picture of 2 x 2 in the file, top row red and transparent blue,
 * bottom row green and white. The material has what stands for %s; so has the texture. */
static const char form[] =
    "{\"asset\":{\"version\":\"2.0\"},%s\"materials\":[{\"name\":\"m\",%s}],\"textures\":[{\"source\":0%s}],"
    "\"images\":[{\"mimeType\":\"image/png\",\"uri\":\"data:image/png;base64,"
    "iVBORw0KGgoAAAANSUhEUgAAAAIAAAACCAYAAABytg0kAAAAEUlEQVR4nGP4z8AAQUD8HwQAP9II+N0OsiwAAAAASUVORK5CYII="
    "\"}],\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],"
    "\"buffers\":[{\"byteLength\":68,\"uri\":\"data:application/octet-stream;base64,"
    "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAABAAIAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAgD8="
    "\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36},{\"buffer\":0,\"byteOffset\":36,\"byteLength\":6}"
    ",{\"buffer\":0,\"byteOffset\":44,\"byteLength\":24}],"
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\"min\":[0,0,0],"
    "\"max\":[1,1,0]},"
    "{\"bufferView\":1,\"componentType\":5123,\"count\":3,\"type\":\"SCALAR\"},{\"bufferView\":2,"
    "\"componentType\":5126,\"count\":3,\"type\":\"VEC2\"}],"
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":2},\"indices\":1,"
    "\"material\":0%s}]}]}";

static const char *file(const char *top, const char *material, const char *texture, const char *primitive) {
    static char text[8192];
    snprintf(text, sizeof text, form, top, material, texture, primitive);
    return scene_file_text("features.gltf", text);
}

static const sl_material *first_material(const sl_scene *s) { return &s->materials[s->material_index[0]]; }

static size_t warnings_of(const sl_scene *s, const char *words) {
    size_t count = 0;
    for (size_t i = 0; i < sl_scene_warning_count(s); i++)
        count += strstr(sl_scene_warning(s, i), words) != NULL;
    return count;
}

/* Loads a file, which tells that once. */
static void tells(const char *path, const char *words) {
    sl_scene *s = load_scene(path);
    if (warnings_of(s, words) != 1)
        fail_msg("expected '%s' once, got it %zu times", words, warnings_of(s, words));
    sl_scene_destroy(s);
}

static void refuses(const char *path, const char *words) {
    const char *message = load_refused(path);
    if (!strstr(message, words)) fail_msg("expected '%s', got '%s'", words, message);
}

#define DULL "\"pbrMetallicRoughness\":{\"metallicFactor\":0}"

/* ---- had ------------------------------------------------------------------------------------- */

static void near(float a, float b) {
    if (fabsf(a - b) > 1e-5f) fail_msg("expected %g, got %g", (double)b, (double)a);
}

/* glTF's v runs down from the picture's top. */
static void pictures_inside_the_file_colour_and_mask(void **state) {
    sl_scene *s = load_scene(file("",
                                  "\"alphaMode\":\"MASK\",\"pbrMetallicRoughness\":{\"baseColorTexture\":{"
                                  "\"index\":0},\"metallicFactor\":0,\"roughnessFactor\":1}",
                                  "", ""));
    assert_int_equal(s->texture_count, 1);
    assert_int_equal(first_material(s)->texture, 0);
    assert_int_equal(first_material(s)->alpha_texture, 0);
    sl_rgb red = sl_scene_diffuse(s, 0, 0.25f, 0.25f), green = sl_scene_diffuse(s, 0, 0.25f, 0.75f),
           blue = sl_scene_diffuse(s, 0, 0.75f, 0.25f);
    assert_true(red.r > 0.9f && red.g == 0.0f && green.g > 0.9f && green.r == 0.0f && blue.b > 0.9f &&
                blue.r == 0.0f);
    assert_true(sl_scene_has_alpha(s, 0) && sl_scene_is_opaque(s, 0, 0.25f, 0.25f) &&
                !sl_scene_is_opaque(s, 0, 0.75f, 0.25f));
    sl_scene_destroy(s);
}

static void specular_glossiness_gives_kd_ks_and_exponent(void **state) {
    sl_scene *s =
        load_scene(file("\"extensionsUsed\":[\"KHR_materials_pbrSpecularGlossiness\"],"
                        "\"extensionsRequired\":[\"KHR_materials_pbrSpecularGlossiness\"],",
                        "\"extensions\":{\"KHR_materials_pbrSpecularGlossiness\":{\"diffuseFactor\":[0.5,"
                        "0.25,0.125,1],\"specularFactor\":[0.1,0.2,0.3],\"glossinessFactor\":0.5}}",
                        "", ""));
    const sl_material *m = first_material(s);
    near(m->diffuse.r, 0.35f); /* times 1 - 0.3 */
    near(m->diffuse.b, 0.0875f);
    near(m->specular.r, 0.1f);
    near(m->specular.b, 0.3f);
    near(m->exponent, 30.0f); /* 2 / 0.5^4 - 2 */
    assert_int_equal(warnings_of(s, "pbrSpecularGlossiness"), 0);
    sl_scene_destroy(s);
    s = load_scene(
        file("\"extensionsUsed\":[\"KHR_materials_pbrSpecularGlossiness\"],",
             "\"extensions\":{\"KHR_materials_pbrSpecularGlossiness\":{\"diffuseTexture\":{\"index\":0},"
             "\"specularGlossinessTexture\":{\"index\":0},\"specularFactor\":[0.1,0.1,0.1]}}",
             "", ""));
    m = first_material(s);
    assert_int_equal(m->texture, 0);
    near(m->specular.r, 0.05f);                         /* red and white of four */
    /* glossiness 1 times a mean alpha of 3/4 */
    near(m->exponent, 2.0f / 0.25f / 0.25f / 0.25f / 0.25f - 2.0f);
    assert_int_equal(warnings_of(s, "specular colour and glossiness are those of its texture's mean"), 1);
    sl_scene_destroy(s);
}

static sl_rgb seen(const sl_scene *s, float u, float v) { return sl_scene_diffuse_nearest(s, 0, u, v); }

static void texture_transforms_are_applied_to_the_base_texture(void **state) {
    /* At uv (0.1, 0.1), from the top: red; half a picture further blue; a quarter turn counter-clockwise
     * there too (u' = v, v' = -u); scaled by 4 and moved up, green. */
    static const struct {
        const char *transform;
        sl_rgb expected;
    } cases[] = {{"{}", {1, 0, 0}},
                 {"{\"offset\":[0.5,0]}", {0, 0, 1}},
                 {"{\"offset\":[0,0.5]}", {0, 1, 0}},
                 {"{\"rotation\":1.5707963267948966}", {0, 1, 0}},
                 {"{\"scale\":[6,1]}", {0, 0, 1}},
                 {"{\"rotation\":1.5707963267948966,\"scale\":[1,6]}", {1, 1, 1}},
                 {"{\"texCoord\":7}", {1, 0, 0}}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char material[400];
        snprintf(material, sizeof material,
                 "\"pbrMetallicRoughness\":{\"metallicFactor\":0,\"roughnessFactor\":1,\"baseColorTexture\":{"
                 "\"index\":0,\"extensions\":{\"KHR_texture_transform\":%s}}}",
                 cases[i].transform);
        sl_scene *s =
            load_scene(file("\"extensionsRequired\":[\"KHR_texture_transform\"],\"extensionsUsed\":["
                            "\"KHR_texture_transform\"],",
                            material, "", ""));
        sl_rgb found = seen(s, 0.1f, 0.1f);
        if ((found.r > 0.5f) != (cases[i].expected.r > 0.5f) ||
            (found.g > 0.5f) != (cases[i].expected.g > 0.5f) ||
            (found.b > 0.5f) != (cases[i].expected.b > 0.5f)) {
            fail_msg("%s: got %g %g %g", cases[i].transform, (double)found.r, (double)found.g,
                     (double)found.b);
        }
        assert_int_equal(warnings_of(s, "not applied") + warnings_of(s, "KHR_texture_transform"), 0);
        sl_scene_destroy(s);
    }
}

/* Materials a, b, c and cameras of 0.5 and 1 radian, of which the nodes lead to c, a and the second camera; a
 * child comes before its parent. */
static void what_is_read_of_materials_and_cameras_is_that_of_their_own(void **state) {
    static char text[8192];
    snprintf(text, sizeof text, form,
             "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.5,\"znear\":1}},{\"type\":"
             "\"perspective\",\"perspective\":{\"yfov\":1,\"znear\":1,\"aspectRatio\":1.5}}],",
             "\"emissiveFactor\":[1,0,0],\"extensions\":{\"KHR_materials_emissive_strength\":{"
             "\"emissiveStrength\":2}}},"
             "{\"name\":\"b\",\"extensions\":{\"KHR_materials_emissive_strength\":{\"emissiveStrength\":4}}},"
             "{\"name\":\"c\",\"emissiveFactor\":[0,1,0],\"extensions\":{\"KHR_materials_emissive_strength\":"
             "{\"emissiveStrength\":8}}",
             "",
             "},{\"attributes\":{\"POSITION\":0},\"indices\":1,\"material\":2}]},{\"primitives\":[{"
             "\"attributes\":{\"POSITION\":0},\"indices\":1,\"material\":2");
    char *nodes = strstr(text, "[{\"mesh\":0}]");
    assert_non_null(nodes);
    static const char tree[] = "[{\"mesh\":0,\"children\":[1]},{\"mesh\":1,\"camera\":1}]";
    memmove(nodes + strlen(tree), nodes + 12, strlen(nodes + 12) + 1);
    memcpy(nodes, tree, strlen(tree));
    sl_scene *s = load_scene(scene_file_text("order.gltf", text));
    for (size_t i = 0; i < s->material_count; i++) {
        const sl_material *m = &s->materials[i];
        if (strcmp(m->name, "m") == 0) assert_true(m->emission.r == 2.0f && m->emission.g == 0.0f);
        if (strcmp(m->name, "c") == 0) assert_true(m->emission.g == 8.0f && m->emission.r == 0.0f);
    }
    assert_int_equal(s->emitter_count, 3);
    assert_true(s->camera.vertical_fov == 1.0f);
    sl_scene_destroy(s);
}

static void what_is_unlit_is_diffuse_of_its_base_colour(void **state) {
    sl_scene *s =
        load_scene(file("\"extensionsUsed\":[\"KHR_materials_unlit\"],",
                        "\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.5,0.25,1,1]},\"extensions\":{"
                        "\"KHR_materials_unlit\":{}}",
                        "", ""));
    const sl_material *m = first_material(s);
    assert_true(m->diffuse.r == 0.5f && m->diffuse.b == 1.0f && sl_rgb_max(m->specular) == 0.0f);
    assert_int_equal(
        warnings_of(s,
                    "KHR_materials_unlit is not supported: it is drawn as diffuse, and lit"),
        1);
    sl_scene_destroy(s);
}

/* ---- told ------------------------------------------------------------------------------------ */

static void features_that_are_not_had_are_told_by_name(void **state) {
    tells(file("", DULL ",\"normalTexture\":{\"index\":0}", "", ""),
          "normal maps are not used");
    tells(
        file("", DULL ",\"extensions\":{\"KHR_materials_transmission\":{\"transmissionFactor\":1}}", "", ""),
        "KHR_materials_transmission is not supported: it is drawn opaque");
    tells(file("\"extensionsUsed\":[\"KHR_materials_clearcoat\"],",
               DULL ",\"extensions\":{\"KHR_materials_clearcoat\":{}}", "", ""),
          "KHR_materials_clearcoat is not supported: it is left out");
    tells(file("\"extensionsUsed\":[\"EXT_mesh_gpu_instancing\"],", DULL, "", ""),
          "EXT_mesh_gpu_instancing is not supported: it is left out");
    tells(file("", DULL, "", ",\"targets\":[{\"POSITION\":0}]"), "morph targets are not applied");
    tells(file("\"animations\":[{\"channels\":[],\"samplers\":[]}],", DULL, "", ""),
          "animations are not played");
}

/* ---- refused --------------------------------------------------------------------------------- */

static void a_file_that_requires_what_is_not_had_is_refused(void **state) {
    static const char *const lacking[] = {
        "KHR_materials_unlit",     "KHR_materials_transmission", "KHR_materials_volume",
        "KHR_materials_clearcoat", "KHR_materials_sheen",        "KHR_materials_specular",
        "KHR_materials_ior",       "KHR_draco_mesh_compression", "EXT_of_nobody"};
    for (size_t i = 0; i < sizeof lacking / sizeof *lacking; i++) {
        char top[100], words[100];
        snprintf(top, sizeof top, "\"extensionsRequired\":[\"%s\"],", lacking[i]);
        snprintf(words, sizeof words, ": requires the glTF extension %s,", lacking[i]);
        refuses(file(top, DULL, "", ""), words);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pictures_inside_the_file_colour_and_mask),
        cmocka_unit_test(specular_glossiness_gives_kd_ks_and_exponent),
        cmocka_unit_test(texture_transforms_are_applied_to_the_base_texture),
        cmocka_unit_test(what_is_read_of_materials_and_cameras_is_that_of_their_own),
        cmocka_unit_test(what_is_unlit_is_diffuse_of_its_base_colour),
        cmocka_unit_test(features_that_are_not_had_are_told_by_name),
        cmocka_unit_test(a_file_that_requires_what_is_not_had_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, scene_files_teardown);
}
