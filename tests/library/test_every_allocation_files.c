/* Memory that ends anywhere while scenes and pictures are read, compared and written, caches kept, shows
 * shown and errors estimated. As tests/library/test_every_allocation.c, which does methods. */
#define _GNU_SOURCE

#include "unit_test.h"
#include "allocation_trials.h"
#include "cache/frame/live.h"
#include "least_settings.h"
#include "scene/copy.h"
#include "scene_files.h"

static long most; /* paths tried in each case; 0: all */
static long faults;

/* ---- scenes ---------------------------------------------------------------------------------- */

static const char gltf[] =
    "{\"asset\": {\"version\": \"2.0\"}, \"scene\": 0, \"scenes\": [{\"nodes\": [0, 1, 2]}],\n"
    " \"nodes\": [{\"mesh\": 0, \"name\": \"tile\"}, {\"camera\": 0, \"translation\": [0, 0, 3]},\n"
    "  {\"extensions\": {\"KHR_lights_punctual\": {\"light\": 0}}, \"translation\": [0, 1, 2]}],\n"
    " \"cameras\": [{\"type\": \"perspective\", \"perspective\": {\"yfov\": 0.8, \"znear\": 0.1}}],\n"
    " \"extensionsUsed\": [\"KHR_lights_punctual\"], \"extensions\": {\"KHR_lights_punctual\": {\"lights\": "
    "[{\"type\": \"point\", \"intensity\": 50}]}},\n"
    " \"materials\": [{\"pbrMetallicRoughness\": {\"baseColorFactor\": [0.5, 0.6, 0.7, 1], "
    "\"roughnessFactor\": 0.5, \"baseColorTexture\": {\"index\": 0}}}],\n"
    " \"textures\": [{\"source\": 0}], \"images\": [{\"uri\": \"bricks.png\"}],\n"
    " \"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": 0, \"TEXCOORD_0\": 1}, \"material\": "
    "0}]}],\n"
    " \"accessors\": [{\"bufferView\": 0, \"componentType\": 5126, \"count\": 3, \"type\": \"VEC3\", "
    "\"min\": [0, 0, 0], \"max\": [0, 0, 0]},\n"
    "  {\"bufferView\": 0, \"componentType\": 5126, \"count\": 3, \"type\": \"VEC2\"}],\n"
    " \"bufferViews\": [{\"buffer\": 0, \"byteLength\": 36}],\n"
    " \"buffers\": [{\"byteLength\": 36, \"uri\": \"triangle.bin\"}]}\n";

static const char ply[] =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement "
    "face 1\n"
    "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

static void write_sky(const char *name) {
    static const char *const channels[] = {"R", "G", "B"};
    sl_image *sky;
    assert_int_equal(sl_image_create(8, 4, 3, channels, &sky, NULL), SL_OK);
    for (int i = 0; i < 8 * 4 * 3; i++) sky->planes[i] = i % 7 == 0 ? 9.0f : 0.5f;
    assert_int_equal(sl_image_set_metadata(sky, "made.by", "a test", NULL), SL_OK);
    scene_file_write(name, "", 0);
    assert_int_equal(sl_image_write(sky, scene_file_path(name), NULL), SL_OK);
    sl_image_destroy(sky);
}

static void write_files(void) {
    const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    scene_file_copy("scenes/bricks.png", "bricks.png");
    scene_file_copy("tests/data/waves.jpg", "waves.jpg");
    scene_file_copy("scenes/vase.bpt", "vase.bpt");
    scene_file_write("triangle.bin", corners, sizeof corners);
    scene_file_text("tile.gltf", gltf);
    scene_file_text("tile.ply", ply);
    scene_file_text("tile.obj", "mtllib tile.mtl\nv 0 0 0\nv 1 0 0\nv 1 0.5 1\nv 0 0.5 1\nvt 0 0\nvt 1 0\nvt "
                                "1 1\nvt 0 1\nusemtl m\nf 4/4 3/3 2/2 1/1\n");
    scene_file_text("tile.mtl", "newmtl m\nKd .5 .5 .5\nmap_Kd waves.jpg\n");
    for (int i = 0; i < 3; i++) write_sky((const char *const[]){"sky.exr", "sky.pfm", "sky.png"}[i]);
    scene_file_text("all.json", "{\"softlux\": 1, \"meshes\": [{\"file\": \"tile.obj\"}, {\"file\": "
                                "\"vase.bpt\", \"material\": \"m\"}],\n"
                                "\"materials\": {\"m\": {\"bump\": \"bricks.png\", \"bump_depth\": 0.1}}, "
                                "\"environment\": {\"file\": \"sky.exr\"}}");
}

static void load_scene(const fault_case *c, fault_outcome *o) {
    sl_scene *scene = NULL;
    o->status = sl_scene_load(c->what, &scene, &o->error);
    if (o->status == SL_OK) {
        uint64_t hash = sl_scene_hash(scene);
        o->hash = hash_bytes(0, &hash, sizeof hash);
    } else if (scene) {
        o->status = SL_OK; /* half a scene: the hash is wrong */
    }
    sl_scene_destroy(scene);
}

/* Two copies of one mesh with what a scene from arrays can have. */
static sl_status add_parts(sl_scene_builder *b, sl_error *error) {
    static const float corners[] = {0, 0, 0, 1, 0, 0, 0, 1, 0}, sky[] = {1, 2, 3, 4, 5, 6};
    static const uint32_t indices[] = {0, 1, 2};
    const sl_light_data quad = {.size = sizeof quad, .type = SL_LIGHT_QUAD, .edge1 = {1, 0, 0},
                                .edge2 = {0, 0, 1}, .strength = {1, 1, 1}},
                        point = {.size = sizeof point, .position = {1, 1, 1}, .strength = {1, 1, 1}};
    const sl_texture_data grey = {.size = sizeof grey, .width = 1, .height = 1, .channels = 3,
                                  .linear = corners};
    sl_material_data paint = {.size = sizeof paint, .diffuse = {0.5f, 0.5f, 0.5f}};
    sl_mesh_data mesh = {.size = sizeof mesh, .vertex_count = 3, .positions = corners, .normals = corners,
                         .texture_coordinates = corners, .triangle_count = 1, .indices = indices};
    sl_instance_data placed = {.size = sizeof placed};
    sl_status status = sl_scene_builder_texture(b, &grey, &paint.texture, error);
    if (status == SL_OK) status = sl_scene_builder_material(b, &paint, &mesh.material, error);
    if (status == SL_OK) status = sl_scene_builder_mesh(b, &mesh, &placed.mesh, error);
    for (int i = 0; i < 2 && status == SL_OK; i++) status = sl_scene_builder_instance(b, &placed, error);
    if (status == SL_OK) status = sl_scene_builder_light(b, &quad, error);
    if (status == SL_OK) status = sl_scene_builder_light(b, &point, error);
    return status == SL_OK ? sl_scene_builder_environment(b, 2, 1, sky, error) : status;
}

static void build_scene(const fault_case *c, fault_outcome *o) {
    sl_scene_builder *builder;
    sl_scene *scene = NULL;
    o->status = sl_scene_builder_create(&builder, &o->error);
    if (o->status == SL_OK) o->status = add_parts(builder, &o->error);
    if (o->status == SL_OK) o->status = sl_scene_builder_build(builder, &scene, &o->error);
    if (scene) {
        uint64_t hash = sl_scene_hash(scene);
        o->hash = hash_bytes(0, &hash, sizeof hash);
    }
    sl_scene_destroy(scene);
    sl_scene_builder_destroy(builder);
}

static sl_scene *loaded; /* of a child */

static void load_to_write(const fault_case *c) {
    if (sl_scene_load(c->what, &loaded, NULL) != SL_OK) _exit(1);
}

/* Reads what was written, where memory does not end. */
static void write_scene(const fault_case *c, fault_outcome *o) {
    const char *path = scene_file_path("written.json");
    sl_scene *again = NULL;
    remove(path);
    o->status = sl_scene_write(loaded, path, &o->error);
    atomic_store(&window_open, false);
    const bool there = access(path, F_OK) == 0;
    if (there != (o->status == SL_OK)) o->status = SL_OK, o->hash = 1;
    else if (there && sl_scene_load(path, &again, NULL) == SL_OK) {
        uint64_t hash = sl_scene_hash(again);
        o->hash = hash_bytes(0, &hash, sizeof hash);
    }
    sl_scene_destroy(again);
}

static void scenes_where_memory_ends_are_not_half_read(void **state) {
    static const char *const names[] = {"all.json", "tile.obj", "tile.gltf", "tile.ply"};
    faults = 0;
    for (size_t i = 0; i < 4; i++) {
        char name[64];
        snprintf(name, sizeof name, "loading %s", names[i]);
        faults += try_named(
            &(fault_case){.name = name, .work = load_scene, .what = scene_file_path(names[i])}, most);
    }
    faults += try_named(&(fault_case){.name = "loading moving-ball.json",
                                      .work = load_scene,
                                      .what = "scenes/moving-ball.json"},
                        most);
    faults += try_named(&(fault_case){.name = "building a scene", .work = build_scene}, most);
    faults += try_named(&(fault_case){.name = "writing all.json",
                                      .prepare = load_to_write,
                                      .work = write_scene,
                                      .what = scene_file_path("all.json")},
                        most);
    assert_int_equal(faults, 0);
}

/* ---- pictures -------------------------------------------------------------------------------- */

static void read_picture(const fault_case *c, fault_outcome *o) {
    sl_image *image = NULL;
    o->status = sl_image_read(c->what, &image, &o->error);
    if (image) o->hash = hash_image(0, image); /* NULL if it failed */
    if (image && o->status != SL_OK) o->status = SL_OK, o->hash = 1;
    sl_image_destroy(image);
}

static sl_image *picture, *other; /* of a child */

static void make_pictures(const fault_case *c) {
    if (sl_image_create(24, 16, 3, NULL, &picture, NULL) != SL_OK ||
        sl_image_create(24, 16, 3, NULL, &other, NULL) != SL_OK)
        _exit(1);
    for (int i = 0; i < 24 * 16 * 3; i++)
        picture->planes[i] = 0.01f * (float)(i % 101), other->planes[i] = 0.01f * (float)(i % 97);
    if (sl_image_set_metadata(picture, "made.by", "a test", NULL) != SL_OK) _exit(1);
}

/* Writes over a picture that is there: it is the old one or the new one. */
static void write_picture(const fault_case *c, fault_outcome *o) {
    char path[256];
    snprintf(path, sizeof path, "%s-%ld", "/tmp/softlux-every", (long)getppid());
    strcat(path, c->what);
    o->status = sl_image_write(picture, path, &o->error);
    atomic_store(&window_open, false);
    if (o->status == SL_OK) {
        FILE *in = fopen(path, "rb");
        char bytes[8192];
        size_t size = in ? fread(bytes, 1, sizeof bytes, in) : 0;
        if (in) fclose(in);
        o->hash = hash_bytes(0, bytes, size);
    }
    if (unlink(path) == 0 && o->status != SL_OK) o->status = SL_OK, o->hash = 1;
}

static void compare_pictures(const fault_case *c, fault_outcome *o) {
    sl_comparison result;
    sl_image *difference = NULL;
    sl_tone tone = {SL_TONE_REINHARD, 0.0f, true};
    uint8_t bytes[24 * 16 * 3];
    o->status = sl_image_compare(picture, other, NULL, &result, &difference, &o->error);
    if (o->status == SL_OK) o->hash = hash_image(hash_bytes(0, &result.flip, sizeof result.flip), difference);
    else if (difference) o->status = SL_OK;
    if (o->status == SL_OK) o->status = sl_image_srgb(picture, &tone, bytes, &o->error);
    if (o->status == SL_OK) o->status = sl_image_set_metadata(other, "made.by", "somebody", &o->error);
    sl_image_destroy(difference);
}

static void pictures_where_memory_ends_are_whole_or_not_there(void **state) {
    faults = 0;
    static const char *const read[] = {"sky.exr", "sky.pfm", "sky.png", "bricks.png", "waves.jpg"},
                             *const written[] = {".exr", ".pfm", ".png"};
    for (size_t i = 0; i < 5; i++) {
        char name[64];
        snprintf(name, sizeof name, "reading %s", read[i]);
        faults += try_named(
            &(fault_case){.name = name, .work = read_picture, .what = scene_file_path(read[i])}, most);
    }
    for (size_t i = 0; i < 3; i++) {
        char name[64];
        snprintf(name, sizeof name, "writing %s", written[i]);
        faults += try_named(
            &(fault_case){.name = name, .prepare = make_pictures, .work = write_picture, .what = written[i]},
            most);
    }
    faults += try_named(
        &(fault_case){.name = "comparing pictures", .prepare = make_pictures, .work = compare_pictures},
        most);
    assert_int_equal(faults, 0);
}

/* ---- caches, shows, errors ------------------------------------------------------------------- */

static sl_scene *scene;

static void load_for_all(const fault_case *c) {
    sl_error error;
    make_pictures(c);
    if (sl_scene_load("scenes/moving-ball.json", &scene, &error) == SL_OK) return;
    fprintf(stderr, "%s\n", error.message);
    _exit(1);
}

static void save_and_load(const fault_case *c, fault_outcome *o) {
    sl_settings settings = least_settings("splatting", 8, 6);
    sl_method *method = NULL, *next = NULL;
    sl_progress progress = {0};
    sl_image *image = NULL;
    char path[64];
    snprintf(path, sizeof path, "/tmp/softlux-every-%ld.cache", (long)getppid());
    o->status = sl_method_create(scene, &settings, &method, &o->error);
    while (o->status == SL_OK && !progress.done) o->status = sl_method_update(method, &progress, &o->error);
    if (o->status == SL_OK) o->status = sl_method_save(method, path, &o->error);
    if (o->status == SL_OK) o->status = sl_method_create(scene, &settings, &next, &o->error);
    if (o->status == SL_OK) o->status = sl_method_load(next, path, &o->error);
    if (o->status == SL_OK) o->status = sl_method_update(next, &progress, &o->error);
    if (o->status == SL_OK) o->status = sl_method_resolve(next, &image, &o->error);
    if (o->status == SL_OK) o->hash = hash_image(0, image);
    sl_image_destroy(image);
    sl_method_destroy(next);
    sl_method_destroy(method);
    unlink(path);
}

static void rest_a_little(void) { nanosleep(&(struct timespec){0, 2000000}, NULL); }

/* Frames depend on the clock, so this holds only that it works, and ends. Nobody looks before the first move,
 * so that a picture waits while something of what follows it fails, which then comes before the frame; later
 * frames come first. */
static void show(const fault_case *c, fault_outcome *o) {
    sl_settings settings = least_settings(c->what, 8, 6);
    sl_live *live = NULL;
    const sl_image *frame;
    const float eye[3] = {278, 273, -700}, target[3] = {278, 273, 0}, up[3] = {0, 1, 0};
    o->status = sl_live_start(scene, &settings, &live, &o->error);
    if (o->status != SL_OK && live) o->hash = 1;
    for (int i = 0; i < 12 && o->status == SL_OK; i++) {
        if (i % 4 == 1) o->status = sl_live_move(live, 0.1 * i, &o->error);
        if (i == 6 && o->status == SL_OK) o->status = sl_live_look(live, eye, target, up, 0.7f, &o->error);
        if (i < 6) rest_a_little();
        if (o->status == SL_OK && i > 0) o->status = sl_live_frame(live, &frame, NULL, &o->error);
        if (i >= 6) rest_a_little();
    }
    sl_live_stop(live, NULL);
}

static sl_status give_scene(void *context, sl_scene **updated, sl_error *error) {
    *updated = scene;
    return SL_OK;
}

static sl_status move_on(const void *seconds, sl_scene *moved, unsigned *changes, sl_error *error) {
    return sl_scene_set_time(moved, *(const double *)seconds, changes, error);
}

/* One that follows changes, and whose method is made by its own thread. */
static void show_beside(const fault_case *c, fault_outcome *o) {
    static const double seconds[3] = {0.1, 0.2, 0.3};
    sl_settings settings = least_settings(c->what, 8, 6);
    sl_scene *shown = NULL;
    sl_live *live = NULL;
    const sl_image *frame;
    o->status = sl_scene_copy(scene, &shown, &o->error);
    if (o->status == SL_OK)
        o->status = sl_live_start_beside(give_scene, NULL, shown, &settings, &live, &o->error);
    for (int i = 0; i < 12 && o->status == SL_OK; i++) {
        const sl_live_change change = {move_on, &seconds[i / 4], (uint64_t)i, 0};
        unsigned changes = 0;
        rest_a_little();
        o->status = sl_live_frame(live, &frame, NULL, &o->error);
        if (i % 4 != 1 || o->status != SL_OK) continue;
        o->status = move_on(change.what, shown, &changes, &o->error);
        if (o->status == SL_OK) o->status = sl_live_follow(live, &change, changes, &o->error);
    }
    sl_live_stop(live, NULL);
    sl_scene_copy_destroy(shown);
}

static void estimate(const fault_case *c, fault_outcome *o) {
    sl_settings settings = least_settings("path", 24, 16);
    sl_error_probe *probe = NULL;
    sl_error_estimate e[2];
    sl_image *image = NULL;
    o->status = sl_image_create(24, 16, 3, NULL, &image, &o->error);
    if (o->status == SL_OK) o->status = sl_error_probe_create(scene, &settings, &probe, &o->error);
    if (o->status == SL_OK) o->status = sl_error_probe_estimate(probe, image, 30, 1, &e[0], &o->error);
    if (o->status == SL_OK) o->status = sl_error_probe_judge(probe, image, 3.0, 0, &e[1], &o->error);
    if (o->status == SL_OK)
        o->hash = hash_bytes(hash_bytes(0, &e[0].rel_rmse, sizeof(double)), &e[1].rel_rmse, sizeof(double));
    sl_error_probe_destroy(probe);
    sl_image_destroy(image);
}

static void caches_shows_and_estimates_where_memory_ends_say_so(void **state) {
    faults = 0;
    faults += try_named(
        &(fault_case){.name = "keeping a cache", .prepare = load_for_all, .work = save_and_load}, most);
    faults += try_named(&(fault_case){.name = "estimating errors", .prepare = load_for_all, .work = estimate},
                        most);
    static const char *const methods[] = {"shading-cache", "splatting", "path", "multi-mesh"};
    for (size_t i = 0; i < 8; i++) {
        char name[64];
        snprintf(name, sizeof name, "a show %s %s", i < 4 ? "of" : "beside, of", methods[i % 4]);
        faults += try_named(&(fault_case){.name = name,
                                          .prepare = load_for_all,
                                          .work = i < 4 ? show : show_beside,
                                          .what = methods[i % 4],
                                          .all_threads = true},
                            most);
    }
    assert_int_equal(faults, 0);
}

int main(int argc, char **argv) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(scenes_where_memory_ends_are_not_half_read),
        cmocka_unit_test(pictures_where_memory_ends_are_whole_or_not_there),
        cmocka_unit_test(caches_shows_and_estimates_where_memory_ends_say_so),
    };
    choose_cases(argc, argv);
    most = how_many_to_try(10);
    keep_deaths();
    write_files();
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    scene_files_remove();
    return failed;
}
