/* Memory that ends anywhere, in any of the library's functions. The short form tries some of the call paths
 * that allocate; with SOFTLUX_EVERY_ALLOCATION=1 every one (tests/hard/allocations.sh). With a name only the
 * cases that hold it are tried; --list prints their names. */
#define _GNU_SOURCE

#include "unit_test.h"
#include "allocation_trials.h"
#include "least_settings.h"
#include "scene_files.h"

static const char *const methods[] = {
    "splatting", "direct-radiance", "light-octree", "multi-mesh", "shading-cache", "path", "bidirectional"};

static long most; /* paths tried in each case; 0: all */
static long faults;

/* ---- a scene with a little of everything ----------------------------------------------------- */

static const char everything[] =
    "{\"softlux\": 1,\n"
    " \"meshes\": [{\"file\": \"cornell-empty.obj\"},\n"
    "  {\"file\": \"tile.obj\", \"name\": \"tile\", \"material\": \"bricks\", \"transform\": {\"translate\": "
    "[180, 1, 180], \"scale\": 120}},\n"
    "  {\"file\": \"tile.obj\", \"name\": \"mirror\", \"material\": \"mirror\", \"transform\": "
    "{\"translate\": [300, 60, 350], \"scale\": 160}},\n"
    "  {\"file\": \"ball.obj\", \"name\": \"ball\", \"material\": \"%1$s\", \"transform\": {\"scale\": 70}, "
    "\"keyframes\":\n"
    "   [{\"time\": 0, \"translate\": [150, 80, 220]}, {\"time\": 1, \"translate\": [400, 120, 220]}]}],\n"
    " \"materials\": {\"mirror\": {\"mirror\": 0.8}%3$s,\n"
    "  \"bricks\": {\"diffuse\": 0.6, \"bump\": \"bricks.png\", \"bump_depth\": 0.05}},\n"
    " \"lights\": [{\"type\": \"quad\", \"corner\": [213, 540, 227], \"edge1\": [130, 0, 0], \"edge2\": [0, "
    "0, 105], \"radiance\": [17, 12, 4]},\n"
    "  {\"type\": \"spot\", \"position\": [100, 500, 100], \"direction\": [0.5, -1, 0.4], \"intensity\": "
    "[90000, 90000, 90000], \"outer_deg\": 50}%2$s],\n"
    " \"environment\": {\"file\": \"sky.pfm\", \"scale\": 1},\n"
    " \"camera\": {\"eye\": [278, 273, -800], \"target\": [278, 273, 0], \"fov_deg\": 39.3}}\n";

static void write_sky(void) {
    char text[32 + 8 * 4 * 3 * sizeof(float)];
    int at = snprintf(text, sizeof text, "PF\n8 4\n-1.0\n");
    for (int i = 0; i < 8 * 4 * 3; i++, at += (int)sizeof(float))
        memcpy(text + at, &(float){i % 7 == 0 ? 9.0f : 0.5f}, sizeof(float));
    scene_file_write("sky.pfm", text, (size_t)at);
}

static const char *write_scene(const char *name, const char *ball, const char *more_materials,
                               const char *more_lights) {
    char text[4096];
    snprintf(text, sizeof text, everything, ball, more_lights, more_materials);
    return scene_file_text(name, text);
}

static void write_files(void) {
    scene_file_copy("scenes/cornell-empty.obj", "cornell-empty.obj");
    scene_file_copy("scenes/cornell.mtl", "cornell.mtl");
    scene_file_copy("scenes/bricks.png", "bricks.png");
    scene_file_text(
        "tile.obj",
        "v 0 0 0\nv 1 0 0\nv 1 0.5 1\nv 0 0.5 1\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 4/4 3/3 2/2 1/1\n");
    scene_file_text("ball.obj", "v 1 0 0\nv -1 0 0\nv 0 1 0\nv 0 -1 0\nv 0 0 1\nv 0 0 -1\nvn 1 0 0\nvn -1 0 "
                                "0\nvn 0 1 0\nvn 0 -1 0\nvn 0 0 1\nvn 0 0 -1\n"
                                "f 1//1 3//3 5//5\nf 3//3 2//2 5//5\nf 2//2 4//4 5//5\nf 4//4 1//1 5//5\n"
                                "f 3//3 1//1 6//6\nf 2//2 3//3 6//6\nf 4//4 2//2 6//6\nf 1//1 4//4 6//6\n");
    write_sky();
    write_scene("glossy.json", "gloss",
                ", \"gloss\": {\"diffuse\": 0.3, \"specular\": 0.4, \"exponent\": 30}", "");
    write_scene(
        "mirrors.json", "mirror", "",
        ", {\"type\": \"point\", \"position\": [300, 300, 100], \"intensity\": [30000, 30000, 30000]}");
}

/* ---- methods: a picture, an explanation, an edit, the picture after it ----------------------- */

static sl_scene *scene; /* of a child */

static void load(const fault_case *c) {
    const char *const *names = c->what;
    sl_error error;
    const sl_load_options anywhere = {.allow_outside = true};
    if (sl_scene_load_with(scene_file_path(names[1]), &anywhere, &scene, &error) == SL_OK) return;
    fprintf(stderr, "%s\n", error.message);
    _exit(1);
}

static sl_status refine(sl_method *method, uint64_t *hash, sl_error *error) {
    enum { ENOUGH = 8 };
    sl_progress progress = {0};
    sl_image *image = NULL;
    sl_explanation *explanation = NULL;
    sl_status status = SL_OK;
    for (int i = 0; i < ENOUGH && status == SL_OK && !progress.done; i++)
        status = sl_method_update(method, &progress, error);
    if (status == SL_OK) status = sl_method_resolve(method, &image, error);
    if (status == SL_OK) *hash = hash_image(*hash, image);
    const char *name = image ? sl_image_metadata(image, "softlux.method") : "";
    if (status == SL_OK && strcmp(name, "path") != 0 && strcmp(name, "bidirectional") != 0) {
        status = sl_method_explanation(method, image, 4, 5, &explanation, error);
        if (status == SL_OK) *hash = hash_bytes(*hash, explanation->pixel, sizeof explanation->pixel);
        else if (explanation) *hash = 1;
    } else if (status != SL_OK && image) {
        *hash = 1; /* half a picture */
    }
    sl_explanation_destroy(explanation);
    sl_image_destroy(image);
    return status;
}

static void render_twice(const fault_case *c, fault_outcome *o) {
    const char *const *names = c->what;
    sl_settings settings = least_settings(names[0], 8, 6);
    sl_method *method = NULL;
    unsigned changes = 0;
    char *plan = NULL;
    if (names[2]) settings.threads = 2;
    if (strcmp(names[1], "mirrors.json") == 0) {
        settings.bounces = 2;
        settings.shading_cache.caustics = most == 0; /* photons take their time */
        settings.light_octree.atlas = true;
        settings.light_octree.atlas_size = 64;
        settings.radiance_map.visibility = SL_VISIBILITY_RAYS;
    }
    o->status = sl_scene_set_time(scene, 0.0, NULL, &o->error);
    if (o->status == SL_OK) o->status = sl_method_plan(scene, &settings, &plan, &o->error);
    if (o->status == SL_OK) o->status = sl_method_create(scene, &settings, &method, &o->error);
    if (o->status == SL_OK) o->status = refine(method, &o->hash, &o->error);
    if (o->status == SL_OK) o->status = sl_scene_set_time(scene, 0.5, &changes, &o->error);
    if (o->status == SL_OK) o->status = sl_method_edit(method, changes, &o->error);
    if (o->status == SL_OK) o->status = refine(method, &o->hash, &o->error);
    sl_method_destroy(method);
    free(plan);
}

/* ---- running --------------------------------------------------------------------------------- */

static void methods_where_memory_ends_say_so_and_lose_nothing(void **state) {
    static const char *const scenes[] = {"glossy.json", "mirrors.json"};
    char name[64];
    for (size_t m = 0; m < sizeof methods / sizeof methods[0]; m++) {
        for (size_t s = 0; s < 2; s++) {
            const char *names[3] = {methods[m], scenes[s], NULL};
            snprintf(name, sizeof name, "%s, %s", methods[m], scenes[s]);
            faults += try_named(
                &(fault_case){.name = name, .prepare = load, .work = render_twice, .what = names}, most);
        }
    }
    assert_int_equal(faults, 0);
}

int main(int argc, char **argv) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(methods_where_memory_ends_say_so_and_lose_nothing),
    };
    choose_cases(argc, argv);
    most = how_many_to_try(5);
    keep_deaths();
    write_files();
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    scene_files_remove();
    return failed;
}
