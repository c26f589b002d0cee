/* Whole pictures by the light octree: against the path tracer, from depth to depth, and whatever the threads.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "unit_test.h"
#include "matched.h"
#include "rendering.h"
#include "scene/scene.h"
#include "scene_parts.h"

/* Few photons: a test takes a moment, not minutes. */
static sl_settings octree_settings(int size) {
    sl_settings s = small_settings("light-octree", size, size);
    s.light_octree.photons = 40000;
    s.light_octree.neighbours = 100;
    return s;
}

static void the_cornell_box_is_lit_as_by_all_of_its_paths(void **state) {
    sl_scene *scene = load_scene("scenes/cornell.json");
    sl_settings settings = octree_settings(40);
    sl_comparison c = against_path_tracer(scene, &settings, 128, NULL);
    assert_true(fabs(c.bias) < 0.02);
    assert_true(c.rel_mse - c.rel_mse_noise < 0.02);
    sl_scene_destroy(scene);
}

/* The photon map itself: the same paths, the same light, and no voxel anywhere. */
static void photons_gathered_at_pixels_light_the_cornell_box_too(void **state) {
    sl_scene *scene = load_scene("scenes/cornell.json");
    sl_settings settings = octree_settings(40);
    settings.light_octree.photons_at_pixels = true;
    sl_comparison c = against_path_tracer(scene, &settings, 64, NULL);
    assert_true(fabs(c.bias) < 0.02);
    assert_true(c.rel_mse - c.rel_mse_noise < 0.02);
    sl_counters counters;
    settings.width = settings.height = 16;
    settings.light_octree.photons = 5000;
    sl_image_destroy(render(scene, &settings, &counters));
    assert_true(counters.value[SL_COUNT_LEAVES] == 0 && counters.value[SL_COUNT_DIRECTIONAL_LIGHTS] == 0);
    assert_true(counters.value[SL_COUNT_PHOTONS_GATHERED] > 16 * 16 * 50);
    assert_same_bits_with_any_threads(scene, &settings);
    sl_scene_destroy(scene);
}

/* Albedo 1/2: the light reflected at least once is as much again as the direct light, everywhere. */
static void an_integrating_sphere_holds_rho_over_one_minus_rho(void **state) {
    sl_scene *scene = load_scene("scenes/sphere.json");
    sl_settings settings = octree_settings(32);
    settings.light_octree.indirect_only = true;
    sl_counters counters;
    sl_image *image = render(scene, &settings, &counters);
    const float *plane = sl_image_channel(image, "indirect.G");
    double sum = 0.0, square = 0.0;
    for (int i = 0; i < 32 * 32; i++) sum += (double)plane[i], square += (double)plane[i] * (double)plane[i];
    double mean = sum / 1024.0, scatter = sqrt(fmax(0.0, square / 1024.0 - mean * mean)) / mean;
    print_message("radiance %.4f (0.5 / pi = 0.1592), scatter %.2f %%\n", mean, 100.0 * scatter);
    assert_true(fabs(mean - 0.5 / 3.14159265) < 0.03 * 0.1592);
    assert_true(scatter < 0.1);
    assert_true(counters.value[SL_COUNT_SHADOW_RAYS] == 0);
    destroy_picture(image, scene);
}

/* ---- depth by depth ---- */

typedef struct {
    int depths;
    float *green[8];
} seen_depths;

static void keep_depth(void *context, const sl_pass *pass) {
    seen_depths *seen = context;
    if (!strstr(pass->name, "indirect light, depth") || !pass->buffer) return;
    size_t pixels = (size_t)pass->buffer->width * (size_t)pass->buffer->height;
    seen->green[seen->depths] = malloc(pixels * sizeof(float));
    memcpy(seen->green[seen->depths++], sl_image_channel(pass->buffer, "G"), pixels * sizeof(float));
}

static void each_depth_on_the_way_is_what_that_depth_gives_alone(void **state) {
    sl_scene *scene = load_scene("scenes/cornell.json");
    sl_settings settings = octree_settings(32);
    seen_depths seen = {0, {NULL}};
    sl_observer observer = {&seen, keep_depth};
    settings.light_octree.depth = 6;
    settings.light_octree.photons = 10000;
    settings.observer = &observer;
    sl_image_destroy(render(scene, &settings, NULL));
    assert_int_equal(seen.depths, 3);
    settings.observer = NULL;
    for (int k = 0; k < 3; k++) {
        settings.light_octree.depth = 4 + k;
        sl_image *alone = render(scene, &settings, NULL);
        assert_memory_equal(seen.green[k], sl_image_channel(alone, "indirect.G"), 32 * 32 * sizeof(float));
        sl_image_destroy(alone);
        free(seen.green[k]);
    }
    sl_scene_destroy(scene);
}

/* ---- what is kept ---- */

static void a_new_camera_keeps_photons_and_voxels(void **state) {
    sl_scene *scene = load_scene("scenes/cornell.json");
    sl_settings settings = octree_settings(24);
    sl_method *method = created_method(scene, &settings);
    run_to_end(method);
    sl_counters before = *sl_method_counters(method);
    const float eye[3] = {200.0f, 300.0f, -700.0f}, target[3] = {278.0f, 250.0f, 280.0f},
                up[3] = {0.0f, 1.0f, 0.0f};
    assert_int_equal(sl_scene_set_camera(scene, eye, target, up, 0.7f, NULL), SL_OK);
    assert_int_equal(sl_method_edit(method, SL_CHANGED_CAMERA, NULL), SL_OK);
    run_to_end(method);
    sl_image *alone = render(scene, &settings, NULL);
    sl_image *moved = resolved_picture(method);
    assert_true(same_picture(moved, alone));
    const sl_counters *after = sl_method_counters(method);
    assert_int_equal(after->value[SL_COUNT_PHOTONS_EMITTED], before.value[SL_COUNT_PHOTONS_EMITTED]);
    assert_int_equal(after->value[SL_COUNT_LEAVES], before.value[SL_COUNT_LEAVES]);
    destroy_pictures(moved, alone);
    destroy_method(method, scene);
}

/* ---- mirrors, caustics, the stored paths ---- */

static void mirrors_show_what_they_reflect(void **state) {
    sl_scene *scene = load_scene("scenes/cornell-mirror.json");
    sl_settings settings = octree_settings(40);
    sl_comparison c = against_path_tracer(scene, &settings, 128, NULL);
    assert_true(fabs(c.bias) < 0.03);
    sl_scene_destroy(scene);
}

/* A glossy floor, seen in a mirror that fills the picture, and the same floor from where the eye's image in
 * the mirror stands: the picture is turned round, and its highlights are in the same places. */
static sl_scene *glossy_floor(bool mirror) {
    char json[1024], obj[512];
    snprintf(json, sizeof json,
             "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\", \"material\": \"floor\"}%s], "
             "\"materials\": {\"floor\": {\"diffuse\": 0.1,"
             " \"specular\": 0.8, \"exponent\": 40}%s}, \"lights\": [{\"type\": \"spot\", \"position\": "
             "[0.5, 2, 1], \"direction\": [0, -1, 1],"
             " \"intensity\": 5, \"outer_deg\": 40}], \"camera\": {\"eye\": [0, 1, %d], \"target\": [0, 0.7, "
             "0], \"fov_deg\": 60}}",
             mirror ? ", {\"file\": \"mesh.obj\", \"name\": \"glass\", \"material\": \"glass\", "
                      "\"transform\": {\"rotate_deg\": [-90, 0, 0]}}"
                    : "",
             mirror ? ", \"glass\": {\"mirror\": 1}" : "", mirror ? 1 : -1);
    snprintf(obj, sizeof obj, "v -9 0 0\nv 9 0 0\nv 9 0 9\nv -9 0 9\nf 4 3 2 1\n");
    return scene_from_text(json, obj);
}

static void highlights_in_mirrors_are_where_the_mirror_reflects_them(void **state) {
    enum { SIZE = 24 };
    sl_scene *mirrored = glossy_floor(true), *plain = glossy_floor(false);
    sl_settings settings = octree_settings(SIZE);
    settings.light_octree.store = SL_STORE_ALL;
    sl_image *in_mirror = render(mirrored, &settings, NULL), *truth = render(plain, &settings, NULL);
    const char *const layers[] = {"direct.G", "indirect.G"};
    for (int k = 0; k < 2; k++) {
        const float *a = sl_image_channel(in_mirror, layers[k]), *b = sl_image_channel(truth, layers[k]);
        double apart = 0.0, sum = 0.0;
        for (int i = 0; i < SIZE * SIZE; i++) {
            apart += fabs((double)a[i] - (double)b[i / SIZE * SIZE + SIZE - 1 - i % SIZE]);
            sum += (double)b[i];
        }
        print_message("%s: %.4f of %.4f\n", layers[k], apart / (SIZE * SIZE), sum / (SIZE * SIZE));
        assert_true(sum > 0.0 && apart < (k == 0 ? 1e-3 : 0.2) * sum);
    }
    destroy_pictures(in_mirror, truth);
    sl_scene_destroy(mirrored);
    sl_scene_destroy(plain);
}

static double indirect_of(const sl_scene *scene, sl_photon_store store) {
    sl_settings settings = octree_settings(32);
    settings.light_octree.store = store;
    settings.light_octree.indirect_only = true;
    sl_image *image = render(scene, &settings, NULL);
    double sum = 0.0;
    for (int i = 0; i < 32 * 32; i++) sum += (double)sl_image_channel(image, "indirect.G")[i];
    sl_image_destroy(image);
    return sum / 1024.0;
}

static void caustics_are_a_part_of_indirect_light_and_that_of_all(void **state) {
    sl_scene *mirror = load_scene("scenes/cornell-mirror.json"), *diffuse = load_scene("scenes/cornell.json");
    double caustic = indirect_of(mirror, SL_STORE_CAUSTIC), indirect = indirect_of(mirror, SL_STORE_INDIRECT),
           all = indirect_of(mirror, SL_STORE_ALL);
    print_message("caustic %.4f, indirect %.4f, all %.4f\n", caustic, indirect, all);
    assert_true(0.0 < caustic && caustic < indirect && indirect < all);
    assert_true(indirect_of(diffuse, SL_STORE_CAUSTIC) == 0.0);
    sl_scene_destroy(mirror);
    sl_scene_destroy(diffuse);
}

/* ---- the sky ---- */

static const char floor_obj[] = "v -2 0 -2\nv 2 0 -2\nv 2 0 2\nv -2 0 2\nf 1 4 3 2\n";

/* A floor of albedo 1/2 alone under a sky of radiance 1. */
static void a_smooth_sky_is_in_the_octree_and_pixels_have_no_noise_of_it(void **state) {
    sl_scene *scene = scene_from_text(
        "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\", \"material\": \"grey\"}], \"materials\": "
        "{\"grey\": "
        "{\"diffuse\": [0.5, 0.5, 0.5]}}, \"environment\": {\"radiance\": [1, 1, 1]}, \"camera\": "
        "{\"eye\": [0, 2, 0.1], \"target\": [0, 0, 0], \"fov_deg\": 30}}",
        floor_obj);
    sl_settings settings = octree_settings(24);
    sl_image *kept = render(scene, &settings, NULL);
    double sum = 0.0;
    for (int i = 0; i < 24 * 24; i++) {
        assert_true(sl_image_channel(kept, "direct.G")[i] == 0.0f);
        assert_true(fabsf(sl_image_channel(kept, "G")[i] - 0.5f) < 0.35f);
        sum += (double)sl_image_channel(kept, "G")[i];
    }
    print_message("radiance %.4f, wanted 0.5\n", sum / 576.0);
    assert_true(fabs(sum / 576.0 - 0.5) < 0.02);
    destroy_picture(kept, scene);
}

/* ---- mirrors with a cube map ---- */

/* A mirror under a sky that varies from side to side, and nothing else in reach of its rays. */
static sl_scene *mirror_under_the_sky(void) {
    enum { W = 64, H = 32 };
    static float texels[3 * W * H];
    for (int row = 0; row < H; row++) {
        for (int column = 0; column < W; column++) {
            float *t = texels + 3 * (row * W + column), turn = (float)column / W;
            t[0] = 1.0f + 0.5f * (float)sin(6.28318530718 * (double)turn);
            t[1] = 1.0f;
            t[2] = 2.0f - (float)row / H;
        }
    }
    const float xyz[] = {-2, 0, 2, 2, 0, 2, 2, 0, -2, -2, 0, -2, 40, -40, 0, 41, -40, 0, 40, -40, 1};
    const uint32_t corners[] = {0, 1, 2, 0, 2, 3, 4, 5, 6}, of[] = {0, 0, 1};
    const sl_material m[] = {
        {.mirror = {0.9f, 0.8f, 0.7f}, .texture = SL_NO_INDEX, .alpha_texture = SL_NO_INDEX},
        {.diffuse = {0.5f, 0.5f, 0.5f}, .texture = SL_NO_INDEX, .alpha_texture = SL_NO_INDEX}};
    const sl_environment sky = {.present = true, .width = W, .height = H, .texels = texels};
    const sl_scene_parts parts = {.vertex_count = 7,
                                  .positions = xyz,
                                  .triangle_count = 3,
                                  .indices = corners,
                                  .material_index = of,
                                  .material_count = 2,
                                  .materials = m,
                                  .environment = &sky};
    sl_scene *scene = scene_built(&parts);
    const float eye[3] = {0, 1, 2}, target[3] = {0, 0, 0}, up[3] = {0, 1, 0};
    assert_int_equal(sl_scene_set_camera(scene, eye, target, up, 0.8f, NULL), SL_OK);
    return scene;
}

static void mirrors_show_a_far_environment_alone_as_by_rays(void **state) {
    sl_scene *scene = mirror_under_the_sky();
    sl_settings settings = octree_settings(48);
    settings.light_octree.photons = 1000;
    settings.light_octree.indirect_only = true;
    sl_counters counters, with_rays;
    sl_image *rays = render(scene, &settings, &with_rays);
    settings.light_octree.environment_mirrors = true;
    sl_image *cube = render(scene, &settings, &counters);
    sl_comparison c = comparison_of(cube, rays);
    print_message("the environment alone: relRMSE %.3f %%, bias %.3f %%\n", 100.0 * c.rel_rmse,
                  100.0 * c.bias);
    assert_true(c.rel_rmse < 0.03 && fabs(c.bias) < 0.003);
    assert_true(c.mean_image > 0.5);
    /* one for each pixel of the mirror */
    assert_true(with_rays.value[SL_COUNT_RAYS] > counters.value[SL_COUNT_RAYS] + 1000);
    destroy_pictures(rays, cube);
    sl_scene_destroy(scene);
}

/* ---- the atlas ---- */

static void by_way_of_the_atlas_the_picture_is_the_same_but_for_filtering(void **state) {
    sl_scene *scene = load_scene("scenes/cornell-mirror.json");
    sl_settings settings = octree_settings(48);
    settings.light_octree.photons = 20000;
    sl_image *octree = render(scene, &settings, NULL);
    settings.light_octree.atlas = true;
    settings.light_octree.atlas_size = 512;
    sl_image *atlas = render(scene, &settings, NULL);
    sl_comparison c = comparison_of(atlas, octree);
    print_message("relRMSE between the two %.2f %%, bias %.2f %%\n", 100.0 * c.rel_rmse, 100.0 * c.bias);
    assert_true(!c.identical && c.rel_mse < 1e-3);
    destroy_pictures(octree, atlas);
    sl_scene_destroy(scene);
}

static void a_new_camera_looks_its_light_up_in_the_atlas_that_is_there(void **state) {
    sl_scene *scene = load_scene("scenes/cornell.json");
    sl_settings settings = octree_settings(24);
    settings.light_octree.photons = 5000;
    settings.light_octree.depth = 4;
    settings.light_octree.atlas = true;
    settings.light_octree.atlas_size = 256;
    settings.light_octree.indirect_only = true;
    sl_method *method = created_method(scene, &settings);
    run_to_end(method);
    uint64_t baked = sl_method_counters(method)->value[SL_COUNT_TEXTURE_FETCHES];
    assert_int_equal(sl_method_edit(method, SL_CHANGED_CAMERA, NULL), SL_OK);
    run_to_end(method);
    uint64_t looked_up = sl_method_counters(method)->value[SL_COUNT_TEXTURE_FETCHES] - baked;
    assert_true(looked_up <= 24 * 24);
    destroy_method(method, scene);
}

/* ---- nothing there ---- */

static void without_light_or_reflection_no_photon_flies(void **state) {
    static const char obj[] = "mtllib mesh.mtl\nv -2 0 -2\nv 2 0 -2\nv 2 0 2\nv -2 0 2\nf 1 4 3 2\n";
    sl_scene *dark =
        scene_from_text("{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\", \"material\": \"black\"}], "
                        "\"materials\": {\"black\": "
                        "{\"diffuse\": [0, 0, 0]}}, \"lights\": [{\"type\": \"point\", \"position\": [0, 1, "
                        "0], \"intensity\": [1, 1, 1]}], "
                        "\"camera\": {\"eye\": [0, 2, 4], \"target\": [0, 0, 0], \"fov_deg\": 50}}",
                        obj);
    sl_settings settings = octree_settings(16);
    sl_counters counters;
    sl_image *image = render(dark, &settings, &counters);
    assert_int_equal(counters.value[SL_COUNT_PHOTONS_EMITTED], 0);
    for (int i = 0; i < 3 * 256; i++) assert_true(image->planes[i] == 0.0f);
    destroy_picture(image, dark);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_cornell_box_is_lit_as_by_all_of_its_paths),
        cmocka_unit_test(photons_gathered_at_pixels_light_the_cornell_box_too),
        cmocka_unit_test(an_integrating_sphere_holds_rho_over_one_minus_rho),
        cmocka_unit_test(each_depth_on_the_way_is_what_that_depth_gives_alone),
        cmocka_unit_test(a_new_camera_keeps_photons_and_voxels),
        cmocka_unit_test(mirrors_show_what_they_reflect),
        cmocka_unit_test(highlights_in_mirrors_are_where_the_mirror_reflects_them),
        cmocka_unit_test(caustics_are_a_part_of_indirect_light_and_that_of_all),
        cmocka_unit_test(a_smooth_sky_is_in_the_octree_and_pixels_have_no_noise_of_it),
        cmocka_unit_test(mirrors_show_a_far_environment_alone_as_by_rays),
        cmocka_unit_test(by_way_of_the_atlas_the_picture_is_the_same_but_for_filtering),
        cmocka_unit_test(a_new_camera_looks_its_light_up_in_the_atlas_that_is_there),
        cmocka_unit_test(without_light_or_reflection_no_photon_flies),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
