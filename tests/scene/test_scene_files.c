/* Scene and mesh files: what good ones give, and that each mistake is one line that names file, line and what
 * was expected. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "unit_test.h"
#include "base/math.h"
#include "scene/scene.h"
#include "image_support.h"
#include "rendering.h"
#include "scene_files.h"

static const char box_obj[] = "mtllib box.mtl\n"
                              "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\n"
                              "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
                              "usemtl wall\nf 1/1 2/2 3/3\nusemtl lamp\nf -4/-4 -2/-2 -1/-1\n";
static const char box_mtl[] =
    "newmtl wall\nKd 0.1 0.2 0.3\nKs 0.4 0.4 0.4\nNs 25\nmap_Kd texel.png\nillum 2\n"
    "newmtl lamp\nKd 0 0 0\nKe 17 12 4\n"
    "newmtl glass\nKd 0 0 0\nKs 0.9 0.8 0.7\nillum 5\n";

static void write_box(void) {
    scene_file_text("box.obj", box_obj);
    scene_file_text("box.mtl", box_mtl);
    sl_image *image = blank_image(2, 1, 3);
    image->planes[0] = 1.0f; /* red, black */
    scene_file_text("texel.png", "");
    assert_int_equal(sl_image_write(image, scene_file_path("texel.png"), NULL), SL_OK);
    sl_image_destroy(image);
}

static sl_scene *load_json(const char *json) {
    write_box();
    return load_scene(scene_file_text("scene.json", json));
}

static const sl_material *material(const sl_scene *s, const char *name) {
    for (size_t i = 0; i < s->material_count; i++) {
        if (strcmp(s->materials[i].name, name) == 0) return &s->materials[i];
    }
    fail_msg("no material '%s'", name);
    return NULL;
}

/* The file must be refused as input, with a line that begins with its path and then `rest`. */
static void refuse(const char *path, const char *rest) {
    const char *message = load_refused(path);
    size_t length = strlen(path);
    if (strncmp(message, path, length) != 0 || strncmp(message + length, rest, strlen(rest)) != 0)
        fail_msg("expected '%s%s', got '%s'", path, rest, message);
}

static void refuse_json(const char *json, const char *rest) {
    refuse(scene_file_text("bad.json", json), rest);
}

/* ---- mesh files ------------------------------------------------------------------------------ */

static void an_obj_file_alone_is_a_scene(void **state) {
    write_box();
    sl_scene *s = load_scene(scene_file_path("box.obj"));
    assert_int_equal(sl_scene_triangle_count(s), 2);
    assert_int_equal(s->emitter_count, 1);
    const sl_material *wall = material(s, "wall"), *lamp = material(s, "lamp");
    assert_true(wall->diffuse.g == 0.2f && wall->specular.r == 0.4f && wall->exponent == 25.0f);
    assert_true(lamp->emission.r == 17.0f && lamp->emission.b == 4.0f && !lamp->emission_two_sided);
    assert_true(s->geometric_normal_z[0] == 1.0f);
    assert_int_equal(s->texture_count, 1);
    assert_true(sl_scene_diffuse(s, 0, 0.0f, 0.25f).r > 0.09f); /* u = v = 0.25: the red texel */
    assert_true(sl_scene_diffuse(s, 0, 0.0f, 0.75f).r < 0.01f);
    assert_true(scene_warns_of(s, "no camera"));
    sl_scene_destroy(s);
}

static void mtl_mirrors_are_illum_3_or_5_without_diffuse(void **state) {
    write_box();
    sl_scene *s = load_scene(
        scene_file_text("glass.obj", "mtllib box.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl glass\nf 1 2 3\n"));
    const sl_material *glass = material(s, "glass");
    assert_true(glass->mirror.g == 0.8f && sl_rgb_max(glass->specular) == 0.0f);
    sl_scene_destroy(s);
}

static void height_maps_come_from_mtl_and_scene_files(void **state) {
    write_box();
    scene_file_text("box.mtl",
                    "newmtl wall\nKd 0.1 0.2 0.3\nmap_bump -bm 3 texel.png\nnewmtl lamp\nKd 0.5 0.5 0.5\n");
    const char *const json[] = {"{\"softlux\": 1, \"meshes\": [{\"file\": \"box.obj\"}]}",
                                "{\"softlux\": 1, \"meshes\": [{\"file\": \"box.obj\"}], \"materials\": "
                                "{\"wall\": {\"bump\": null}, \"lamp\": "
                                "{\"bump\": \"texel.png\", \"bump_depth\": 0.5}}}"};
    const uint32_t wall[] = {0, SL_NO_INDEX}, lamp[] = {SL_NO_INDEX, 0};
    for (int k = 0; k < 2; k++) {
        sl_scene *s = load_scene(scene_file_text("scene.json", json[k]));
        assert_int_equal(material(s, "wall")->height_map, wall[k]);
        assert_int_equal(material(s, "lamp")->height_map, lamp[k]);
        assert_true(material(s, k == 0 ? "wall" : "lamp")->bump_depth == (k == 0 ? 0.04f : 0.5f));
        sl_scene_destroy(s);
    }
    write_box();
}

static void a_normal_map_is_no_height_map_and_is_told(void **state) {
    sl_image *map = blank_image(2, 1, 3);
    /* encoded, (0.5, 0.5, 1) and (0.7, 0.3, 0.93); or grey as bright as their blue */
    for (int blue = 1; blue >= 0; blue--) {
        const float texels[6] = {blue ? 0.214f : 0.85f, blue ? 0.448f : 0.85f, blue ? 0.214f : 0.85f,
                                 blue ? 0.073f : 0.85f, blue ? 1.0f : 0.85f,   0.85f};
        memcpy(map->planes, texels, sizeof texels);
        scene_file_text("n.png", "");
        assert_int_equal(sl_image_write(map, scene_file_path("n.png"), NULL), SL_OK);
        scene_file_text(
            "n.mtl",
            "newmtl a\nKd 0.3\nmap_Bump n.png\nnorm n.png\nmap_Ks n.png\nnewmtl b\nKd 0.3\nnorm n.png\n");
        sl_scene *s = load_scene(scene_file_text(
            "n.obj", "mtllib n.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\n"));
        assert_int_equal(material(s, "a")->height_map != SL_NO_INDEX, !blue);
        assert_int_equal(
            scene_warns_of(s, "material 'a': its bump map holds normals, not heights, and is not used"),
            blue);
        assert_true(scene_warns_of(s, "n.mtl:4: norm, a normal map, is not used") &&
                    !scene_warns_of(s, "n.mtl:8: norm") &&
                    scene_warns_of(s, "n.mtl:5: map_Ks, a texture of Ks, is not used"));
        sl_scene_destroy(s);
    }
    sl_image_destroy(map);
}

static void missing_textures_and_libraries_are_warnings(void **state) {
    scene_file_text("lost.mtl", "newmtl a\nKd 0.3 0.3 0.3\nmap_Kd nowhere.png\n");
    sl_scene *s = load_scene(scene_file_text(
        "lost.obj", "mtllib lost.mtl\nmtllib other.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n"));
    assert_true(scene_warns_of(s, "nowhere.png"));
    assert_true(scene_warns_of(s, "lost.obj:2: material library 'other.mtl'"));
    assert_int_equal(material(s, "a")->texture, SL_NO_INDEX);
    assert_true(material(s, "a")->diffuse.r == 0.3f);
    sl_scene_destroy(s);
}

static void files_that_are_no_meshes_are_refused_by_name(void **state) {
    refuse(scene_file_path("nowhere.obj"), ": cannot be opened");
    refuse(scene_file_path("nowhere.json"), ": cannot be opened");
    refuse(scene_file_path("nowhere.glb"), ": cannot be opened");
    refuse("/tmp", ": expected a file");
    refuse(scene_file_text("a.txt", "hello"), ": expected a scene file (.json) or a mesh file");
    refuse(scene_file_text("empty.obj", ""), ": no triangles");
    refuse(scene_file_text("empty.stl", ""), ": cannot be read as a mesh");
    refuse(scene_file_text("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\np 1 2 3\n"), ": no triangles");
    refuse(scene_file_text("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"), ": no triangles");
}

static void headers_that_announce_too_much_are_refused(void **state) {
    const char *head =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 1\nproperty list uchar int vertex_indices\n";
    char text[600];
    snprintf(text, sizeof text, "%send_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", head);
    sl_scene *s = load_scene(scene_file_text("good.ply", text));
    assert_int_equal(sl_scene_triangle_count(s), 1);
    sl_scene_destroy(s);
    snprintf(text, sizeof text, "%send_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n", head);
    refuse(scene_file_text("range.ply", text),
           ": mesh '': index 2 of triangle 0 is 7, the mesh has 3 vertices");
    refuse(scene_file_text("cut.ply", head), ":9: expected a PLY header that ends with 'end_header'");
    refuse(scene_file_text(
               "long.ply",
               "ply\nformat ascii 1.0\nelement vertex 3000000000\nproperty float x\nend_header\n0\n"),
           ": expected at least 6000000000 bytes");
}

/* ---- glTF ------------------------------------------------------------------------------------ */

/* One triangle, data in the JSON: positions (0,0,0) (1,0,0) (0,1,0), indices 0 1 2. */
#define GLTF_BUFFER                                                                                          \
    "\"buffers\":[{\"byteLength\":44,\"uri\":\"data:application/octet-stream;base64,"                        \
    "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAABAAIAAAA=\"}],"                                      \
    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36},{\"buffer\":0,\"byteOffset\":36,\"byteLength\":6}],"  \
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\"min\":[0,0,0]," \
    "\"max\":[1,1,0]},"                                                                                      \
    "{\"bufferView\":1,\"componentType\":5123,\"count\":3,\"type\":\"SCALAR\"}],"                            \
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,\"material\":0}]}]"

static const char lit_gltf[] =
    "{\"asset\":{\"version\":\"2.0\"},\"extensionsUsed\":[\"KHR_lights_punctual\",\"KHR_materials_emissive_"
    "strength\"],"
    "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"point\",\"name\":\"bulb\",\"color\":[1,"
    "0.5,0.25],\"intensity\":8},"
    "{\"type\":\"spot\",\"name\":\"beam\",\"intensity\":3,\"spot\":{\"innerConeAngle\":0.25,"
    "\"outerConeAngle\":0.5}}]}},"
    "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.75,\"znear\":0.1}}],"
    "\"materials\":[{\"name\":\"paint\",\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.8,0.6,0.4,1],"
    "\"metallicFactor\":0.5,\"roughnessFactor\":0.5},"
    "\"emissiveFactor\":[1,0.5,0],\"extensions\":{\"KHR_materials_emissive_strength\":{\"emissiveStrength\":"
    "10}}}],"
    "\"scene\":0,\"scenes\":[{\"nodes\":[0,1,2,3]}],\"nodes\":[{\"mesh\":0,\"scale\":[-2,1,1],"
    "\"translation\":[0,0,1]},"
    "{\"name\":\"eye\",\"camera\":0,\"translation\":[1,2,3]},"
    "{\"name\":\"bulb\",\"translation\":[0,4,0],\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}},"
    "{\"name\":\"beam\",\"translation\":[0,5,0],\"extensions\":{\"KHR_lights_punctual\":{\"light\":1}}}]"
    "," GLTF_BUFFER "}";

static void gltf_gives_camera_lights_and_materials(void **state) {
    sl_scene *s = load_scene(scene_file_text("lit.gltf", lit_gltf));
    assert_int_equal(sl_scene_triangle_count(s), 1);
    assert_true(s->camera.eye.x == 1.0f && s->camera.eye.y == 2.0f && s->camera.eye.z == 3.0f);
    assert_true(s->camera.back.z == 1.0f && s->camera.vertical_fov == 0.75f);
    assert_int_equal(s->light_count, 2);
    assert_true(s->lights[0].type == SL_LIGHT_POINT && s->lights[0].position.y == 4.0f &&
                s->lights[0].intensity.g == 4.0f);
    assert_true(s->lights[1].type == SL_LIGHT_SPOT && s->lights[1].direction.z == -1.0f);
    assert_true(fabs((double)s->lights[1].cos_inner - cos(0.25)) < 1e-6 &&
                fabs((double)s->lights[1].cos_outer - cos(0.5)) < 1e-6);
    const sl_material *m = material(s, "paint");
    /* 0.04 + (0.8 - 0.04) / 2 */
    assert_true(fabsf(m->diffuse.r - 0.4f) < 1e-6f && fabsf(m->specular.r - 0.42f) < 1e-6f);
    /* 2 / 0.5^4 - 2 */
    assert_true(fabsf(m->exponent - 30.0f) < 1e-4f);
    assert_true(m->emission.r == 10.0f && m->emission.g == 5.0f);
    /* a mirrored node keeps its front in front */
    assert_true(s->geometric_normal_z[0] == 1.0f && s->box_min.x == -2.0f);
    sl_scene_destroy(s);
}

static void what_is_no_gltf_is_refused(void **state) {
    refuse(scene_file_text("broken.gltf", "{\"asset\":"), ": expected a glTF file");
    refuse(scene_file_text("short.glb", "glTF\2\0\0"), ": expected a glTF file");
}

/* ---- scene files ----------------------------------------------------------------------------- */

static void a_scene_file_places_and_overrides(void **state) {
    sl_scene *s =
        load_json("{\"softlux\": 1, \"up\": \"y\",\n"
                  " \"meshes\": [{\"file\": \"box.obj\", \"name\": \"a\", \"transform\": [2,0,0,0, 0,2,0,0, "
                  "0,0,2,0, 1,2,3,1]},\n"
                  "  {\"file\": \"box.obj\", \"material\": \"gold\", \"transform\": {\"translate\": "
                  "[0,0,-1], \"rotate_deg\": [0,90,0], \"scale\": 3}}],\n"
                  " \"materials\": {\"wall\": {\"specular\": 0.25}, \"gold\": {\"mirror\": [0.9,0.7,0.3], "
                  "\"two_sided\": true}},\n"
                  " \"lights\": [{\"type\": \"point\", \"position\": [0,5,0], \"power\": 12.566370614}, "
                  "{\"type\": \"directional\", \"direction\": [0,-2,0], \"irradiance\": [1,2,3]},\n"
                  "  {\"type\": \"spot\", \"position\": [0,1,0], \"direction\": [0,-1,0], \"intensity\": 2, "
                  "\"inner_deg\": 10, \"outer_deg\": 60},\n"
                  "  {\"type\": \"quad\", \"corner\": [0,9,0], \"edge1\": [2,0,0], \"edge2\": [0,0,3], "
                  "\"power\": [6,12,18]}],\n"
                  " \"environment\": {\"radiance\": [1,2,3], \"scale\": 0.5},\n"
                  " \"camera\": {\"eye\": [0,0,9], \"target\": [0,0,0], \"fov_deg\": 60}, \"film\": "
                  "{\"width\": 320, \"height\": 200}}");
    assert_int_equal(sl_scene_triangle_count(s), 6);
    assert_true(s->box_max.x == 5.0f && s->box_max.z == 3.0f);
    assert_string_equal(s->object_names[s->object_index[0]], "a");
    const sl_material *wall = material(s, "wall"), *gold = material(s, "gold");
    /* key by key */
    assert_true(wall->diffuse.g == 0.2f && wall->specular.g == 0.25f && wall->exponent == 25.0f);
    assert_true(gold->mirror.r == 0.9f && gold->emission_two_sided && sl_rgb_max(gold->diffuse) == 0.0f);
    assert_ptr_equal(&s->materials[s->material_index[2]], gold);
    assert_true(fabsf(s->geometric_normal_x[2] - 1.0f) < 1e-6f);
    assert_int_equal(s->light_count, 3);
    assert_true(fabsf(s->lights[0].intensity.r - 1.0f) < 1e-6f && s->lights[1].direction.y == -1.0f);
    assert_true(fabsf(s->lights[2].cos_outer - 0.5f) < 1e-6f);
    const sl_emitter *quad = &s->emitters[s->emitter_count - 1];
    assert_true(fabsf(quad->area - 3.0f) < 1e-6f && fabs((double)quad->radiance.g - 2.0 / SL_PI) < 1e-6);
    assert_true(s->geometric_normal_y[5] == -1.0f); /* edge1 x edge2 */
    assert_true(s->environment.constant.b == 1.5f);
    int width, height;
    sl_scene_film(s, &width, &height);
    assert_true(width == 320 && height == 200 && fabs((double)s->camera.vertical_fov - SL_PI / 3.0) < 1e-6);
    assert_int_equal(sl_scene_warning_count(s), 0);
    sl_scene_destroy(s);
}

static void a_mesh_can_be_asked_to_be_faceted(void **state) {
    scene_file_text("bent.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 1 0 1\nf 1//1 2//1 3//1\n");
    sl_scene *smooth = load_scene(scene_file_text(
        "smooth.json", "{\"softlux\": 1, \"meshes\": [{\"file\": \"bent.obj\", \"normals\": \"file\"}]}"));
    sl_scene *faceted = load_scene(scene_file_text(
        "faceted.json",
        "{\"softlux\": 1, \"meshes\": [{\"file\": \"bent.obj\", \"normals\": \"faceted\"}]}"));
    assert_true(smooth->normal_x[0] > 0.7f);
    assert_true(faceted->normal_x[0] == 0.0f && faceted->normal_z[0] == 1.0f);
    sl_scene_destroy(smooth);
    sl_scene_destroy(faceted);
}

static void z_up_is_turned_once(void **state) {
    sl_scene *s = load_json("{\"softlux\": 1, \"up\": \"z\", \"meshes\": [{\"file\": \"box.obj\", "
                            "\"transform\": {\"translate\": [0,0,7]}}],\n"
                            " \"lights\": [{\"type\": \"point\", \"position\": [1,2,3], \"intensity\": 1}],\n"
                            " \"camera\": {\"eye\": [0,-9,1], \"target\": [0,0,1], \"up\": [0,0,1]}}");
    assert_true(s->geometric_normal_y[0] == 1.0f && s->box_min.y == 7.0f && s->box_min.z == -2.0f);
    assert_true(s->lights[0].position.y == 3.0f && s->lights[0].position.z == -2.0f);
    assert_true(s->camera.eye.z == 9.0f && s->camera.up.y == 1.0f && s->camera.back.z == 1.0f);
    sl_scene_destroy(s);
}

static void an_environment_picture_keeps_its_top_row_up(void **state) {
    sl_image *image = blank_image(4, 2, 3);
    for (int i = 0; i < 24; i++) image->planes[i] = i % 8 < 4 ? 3.0f : 0.5f;
    scene_file_text("sky.pfm", "");
    assert_int_equal(sl_image_write(image, scene_file_path("sky.pfm"), NULL), SL_OK);
    sl_image_destroy(image);
    sl_scene *s = load_json("{\"softlux\": 1, \"meshes\": [{\"file\": \"box.obj\"}], \"environment\": "
                            "{\"file\": \"sky.pfm\", \"scale\": 2}}");
    assert_true(sl_environment_radiance(&s->environment, sl_v3(0, 1, 0)).g == 6.0f);
    assert_true(sl_environment_radiance(&s->environment, sl_v3(0, -1, 0)).g == 1.0f);
    sl_scene_destroy(s);
}

/* A sky of 2 x 1 texels: red left and green right, or what else the file says of them. */
static const char *sky_file(const exr_test_file *from) {
    static const float red[2] = {0.9505f, 0.0f}, green[2] = {1.0f, 1.0f}, blue[2] = {1.0891f, 0.0f};
    const exr_test_channel channels[] = {
        {"B", EXR_PIXEL_FLOAT, blue, 1}, {"G", EXR_PIXEL_FLOAT, green, 1}, {"R", EXR_PIXEL_FLOAT, red, 1}};
    exr_test_file file = *from;
    file.width = 2, file.height = 1, file.channels = channels, file.channel_count = 3;
    write_exr(scene_file_text("sky.exr", ""), &file);
    return "{\"softlux\": 1,\n\"meshes\": [{\"file\": \"box.obj\"}], \"environment\": {\"file\": "
           "\"sky.exr\"}}";
}

static void a_sky_with_primaries_of_its_own_is_refused(void **state) {
    write_box();
    const exr_attr_chromaticities_t xyz = {1, 0, 0, 1, 0, 0, 1.0f / 3, 1.0f / 3},
                                    rec709 = {0.64f, 0.33f, 0.3f, 0.6f, 0.15f, 0.06f, 0.3127f, 0.329f};
    sl_scene *s = load_json(sky_file(&(exr_test_file){.chromaticities = &rec709}));
    assert_true(s->environment.texels[0] == 0.9505f && s->environment.texels[4] == 1.0f);
    sl_scene_destroy(s);
    refuse_json(sky_file(&(exr_test_file){.chromaticities = &xyz}), ":2: environment: ");
}

static void a_sky_lies_in_its_data_window_only_if_it_says_that_it_is_one(void **state) {
    write_box();
    const exr_envmap_t round = EXR_ENVMAP_LATLONG, cube = EXR_ENVMAP_CUBE;
    const exr_attr_box2i_t display = {.min = {.x = 0, .y = 0}, .max = {.x = 3, .y = 1}};
    sl_scene *s = load_json(sky_file(&(exr_test_file){.left = 2, .display = &display, .envmap = &round}));
    assert_true(s->environment.width == 2 && s->environment.height == 1 &&
                s->environment.texels[0] == 0.9505f);
    sl_scene_destroy(s);
    s = load_json(sky_file(&(exr_test_file){.left = 2, .display = &display}));
    assert_true(s->environment.width == 4 && s->environment.height == 2 && s->environment.texels[0] == 0.0f &&
                s->environment.texels[6] == 0.9505f);
    sl_scene_destroy(s);
    refuse_json(sky_file(&(exr_test_file){.envmap = &cube}), ":2: environment: ");
}

#define MESH "\"meshes\": [{\"file\": \"box.obj\"}]"

static void scene_file_mistakes_are_told_by_line(void **state) {
    write_box();
    const char *cases[][2] = {
        {"", ":1: expected valid JSON, got the end of the file"},
        {"{\"softlux\": 1,\n \"up\": }", ":2: expected valid JSON, got }"},
        {"{\"softlux\": 1,\n \"up\": [0, .5, 0]}", ":2: expected valid JSON, got .5, 0]}"},
        {"{\"softlux\": 1,\n \"up\": [0, 1e, 0]}", ":2: expected valid JSON, got 1e, 0]}"},
        {"{\"softlux\": 1,\n \"up\": [0, 012, 0]}", ":2: expected valid JSON, got 012, 0]}"},
        {"{\"softlux\": 1,\n \"up\": [0, 2., 0]}", ":2: expected valid JSON, got 2., 0]}"},
        {"{\"softlux\": 1,\n \"up\": [0, +1, 0]}", ":2: expected valid JSON, got +1, 0]}"},
        {"{\"softlux\": 1,\n \"up\": [0, 1,\n 0,]}", ":3: expected valid JSON, got ,]}"},
        {"{\"softlux\": 1,\n \"up\": [0, 1, 0],\n}\n\n", ":2: expected valid JSON, got ,"},
        {"[]", ":1: expected the scene to be an object"},
        {"{" MESH "}", ":1: expected a key 'softlux' here"},
        {"{\"softlux\": 1, " MESH ", \"camera\": {\"eye\": [0,0,1], \"target\": [0,0,0],\n\"fov\": 80}}",
         ":2: unknown key 'fov' in the camera; expected 'fov_deg'?"},
        {"{\"softlux\": 1,\n\n\"mehses\": []}", ":3: unknown key 'mehses' in the scene; expected 'meshes'?"},
        {"{\"softlux\": 1, \"softlux\": 1}", ":1: key 'softlux' is given twice"},
        {"{\"softlux\": 1, \"up\": \"x\"}", ":1: expected 'up' to be \"y\" or \"z\""},
        {"{\"softlux\": 1}", ": no triangles"},
        {"{\"softlux\": 1, \"meshes\": {}}", ":1: expected 'meshes' to be an array"},
        {"{\"softlux\": 1, \"meshes\": [\n{}]}", ":2: expected a key 'file' here"},
        {"{\"softlux\": 1, \"meshes\": [\n{\"file\":\n 3}]}", ":2: expected 'file' to be a string"},
        {"{\"softlux\": 1, \"meshes\": [\n{\"file\": \"none.obj\"}]}", ":2: mesh "},
        {"{\"softlux\": 1, \"meshes\": [{\"file\": \"box.obj\",\n\"normals\": \"smooth\"}]}",
         ":2: expected 'normals' to be 'file' or 'faceted', got 'smooth'"},
        {"{\"softlux\": 1, \"meshes\": [{\"file\": \"box.obj\",\n\"transform\": [1,2]}]}",
         ":2: expected 'transform' to be an array of 16 numbers"},
        {"{\"softlux\": 1, \"meshes\": [{\"file\": \"box.obj\",\n\"transform\": {\"scale\": 0}}]}",
         ":2: expected 'scale' to be other than 0"},
        {"{\"softlux\": 1, \"meshes\": [{\"file\": \"box.obj\",\n\"transform\": "
         "[0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,1]}]}",
         ":2: expected 'transform' to be a matrix"},
        {"{\"softlux\": 1, \"meshes\": [{\"file\": \"box.obj\",\n\"material\": \"wal\"}]}",
         ":2: no mesh has a material 'wal'; expected 'wall'?"},
        {"{\"softlux\": 1, " MESH ", \"materials\": {\n\"walls\": {}}}",
         ":2: no mesh has a material 'walls'; expected 'wall'?"},
        {"{\"softlux\": 1, " MESH ", \"materials\": {\"wall\": {\n\"diffuse\": [1, -1, 0]}}}",
         ":2: expected 'diffuse' to be at least 0"},
        {"{\"softlux\": 1, " MESH ", \"materials\": {\"wall\": {\n\"emission\": 1e999}}}",
         ":2: expected 'emission' to be a number"},
        {"{\"softlux\": 1, " MESH ", \"materials\": {\"wall\": {\n\"texture\": \"no.png\"}}}",
         ":2: texture "},
        {"{\"softlux\": 1, " MESH ", \"materials\": {\"wall\": {\n\"mirror\": 1, \"diffuse\": 1}}}",
         ":2: expected either 'mirror'"},
        {"{\"softlux\": 1, " MESH ", \"materials\": {\"wall\": {\n\"two_sided\": 1}}}",
         ":2: expected 'two_sided' to be true or false"},
        {"{\"softlux\": 1, " MESH ", \"lights\": [\n{\"type\": \"pont\"}]}",
         ":2: unknown light type 'pont'; expected 'point'"},
        {"{\"softlux\": 1, " MESH ", \"lights\": [\n{\"type\": \"point\", \"position\": [0,0,0]}]}",
         ":2: expected either 'intensity' or 'power' here"},
        {"{\"softlux\": 1, " MESH
         ", \"lights\": [\n{\"type\": \"directional\", \"direction\": [0,0,0], \"irradiance\": 1}]}",
         ":2: expected 'direction' to be other than 0"},
        {"{\"softlux\": 1, " MESH
         ", \"lights\": [\n{\"type\": \"spot\", \"position\": [0,0,0], \"direction\": [0,0,1], "
         "\"intensity\": 1,\n \"inner_deg\": 50, \"outer_deg\": 40}]}",
         ":3: expected 'inner_deg' of at most 'outer_deg', 40"},
        {"{\"softlux\": 1, " MESH ", \"lights\": [\n{\"type\": \"quad\", \"corner\": [0,0,0], \"edge1\": "
                                  "[1,0,0], \"edge2\": [2,0,0], \"radiance\": 1}]}",
         ":2: expected a quad light with an area"},
        {"{\"softlux\": 1, " MESH ", \"environment\": {\n\"file\": \"none.exr\"}}", ":2: environment: "},
        {"{\"softlux\": 1, " MESH ", \"camera\": {\n\"eye\": [0,0,1]}}", ":1: expected a key 'target' here"},
        {"{\"softlux\": 1, " MESH ",\n\"camera\": {\"eye\": [0,0,1], \"target\": [0,0,1]}}",
         ":2: expected the camera's 'eye' apart from its 'target'"},
        {"{\"softlux\": 1, " MESH ", \"camera\": {\"eye\": [0,0,1], \"target\": [0,0,0],\n\"fov_deg\": 180}}",
         ":2: expected 'fov_deg' from 0.01 to 179, got 180"},
        {"{\"softlux\": 1, " MESH ", \"camera\": {\"eye\": [0,0,1],\n\"frame\": [1,0,0,0,1,0,0,0,-1]}}",
         ":2: expected 'frame' to be three unit vectors"},
        {"{\"softlux\": 1, " MESH
         ", \"camera\": {\"eye\": [0,0,1], \"target\": [0,0,0],\n\"frame\": [1,0,0,0,1,0,0,0,1]}}",
         ":2: expected no 'target', 'up' or 'keyframes' beside 'frame'"},
        {"{\"softlux\": 1, " MESH ",\n\"film\": {\"width\": 1.5, \"height\": 5}}",
         ":2: expected 'width' and 'height' to be whole numbers"},
        {"{\"softlux\": 1, \"meshes\": [{\"file\": \"box.obj\", \"keyframes\": [\n{\"time\": 1},\n{\"time\": "
         "1}]}]}",
         ":3: expected keyframes in the order of their times"},
        {"{\"softlux\": 1, \"meshes\": [{\"file\": \"box.obj\", \"keyframes\": [\n{\"time\": 1, \"scale\": "
         "-1}]}]}",
         ":2: expected 'scale' to be above 0"},
        {"{\"softlux\": 1, \"meshes\": [{\"file\": \"box.obj\",\n\"keyframes\": []}]}",
         ":2: expected at least one keyframe"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) refuse_json(cases[i][0], cases[i][1]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_obj_file_alone_is_a_scene),
        cmocka_unit_test(mtl_mirrors_are_illum_3_or_5_without_diffuse),
        cmocka_unit_test(height_maps_come_from_mtl_and_scene_files),
        cmocka_unit_test(a_normal_map_is_no_height_map_and_is_told),
        cmocka_unit_test(missing_textures_and_libraries_are_warnings),
        cmocka_unit_test(files_that_are_no_meshes_are_refused_by_name),
        cmocka_unit_test(headers_that_announce_too_much_are_refused),
        cmocka_unit_test(gltf_gives_camera_lights_and_materials),
        cmocka_unit_test(what_is_no_gltf_is_refused),
        cmocka_unit_test(a_scene_file_places_and_overrides),
        cmocka_unit_test(a_mesh_can_be_asked_to_be_faceted),
        cmocka_unit_test(z_up_is_turned_once),
        cmocka_unit_test(an_environment_picture_keeps_its_top_row_up),
        cmocka_unit_test(a_sky_with_primaries_of_its_own_is_refused),
        cmocka_unit_test(a_sky_lies_in_its_data_window_only_if_it_says_that_it_is_one),
        cmocka_unit_test(scene_file_mistakes_are_told_by_line),
    };
    return cmocka_run_group_tests(tests, NULL, scene_files_teardown);
}
