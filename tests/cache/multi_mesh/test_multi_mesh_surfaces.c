/* Whole pictures of surfaces with holes, of files with vertices that are no numbers, and of strips at the
 * foot of walls. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "unit_test.h"
#include "matched.h"
#include "rendering.h"
#include "trace_scenes.h"

enum { SIDE = 64, PIXELS = SIDE * SIDE };

static sl_image *picture_of(const sl_scene *scene) {
    sl_settings s = small_settings("multi-mesh", SIDE, SIDE);
    s.quality = SL_QUALITY_NORMAL;
    sl_image *image = render(scene, &s, NULL);
    assert_sound_picture(image, "by multi-mesh caching");
    return image;
}

/* ---- holes ---- */

/* A leaf between a lamp and a floor beside a wall, x from -1 to 1. Masked: its right half is clear. Else it
 * ends at x = 0. */
static sl_scene *floor_below_a_leaf(bool masked) {
    static uint8_t texels[16] = {255, 255, 255, 255, 255, 255, 255, 0, 255, 255, 255, 255, 255, 255, 255, 0};
    trace_mesh mesh = trace_mesh_begin();
    uint32_t white = trace_mesh_diffuse(&mesh, 0.7f), leaf = trace_mesh_diffuse(&mesh, 0.3f);
    uint32_t lamp = trace_mesh_lamp(&mesh, 20.0f);
    trace_mesh_quad(&mesh, sl_v3(-2, 0, 2), sl_v3(4, 0, 0), sl_v3(0, 0, -4), white);
    trace_mesh_quad(&mesh, sl_v3(-2, 0, -2), sl_v3(4, 0, 0), sl_v3(0, 2, 0), white);
    trace_mesh_quad(&mesh, sl_v3(-0.3f, 2, -0.3f), sl_v3(0.6f, 0, 0), sl_v3(0, 0, 0.6f), lamp);
    if (masked) {
        mesh.textures[0] = (sl_texture){NULL, 2, 2, true, texels};
        mesh.texture_count = 1;
        mesh.materials[leaf].alpha_texture = 0;
    }
    trace_mesh_quad(&mesh, sl_v3(-1, 0.8f, 1), sl_v3(masked ? 2.0f : 1.0f, 0, 0), sl_v3(0, 0, -2), leaf);
    assert_true(
        sl_camera_look_at(&mesh.camera, sl_v3(0.3f, 3, 2.5f), sl_v3(0.2f, 0, 0), sl_v3(0, 1, 0), 0.9f));
    return trace_mesh_build(&mesh);
}

static void a_masked_leaf_is_seen_and_shades_as_the_half_that_is_opaque(void **state) {
    sl_scene *masked = floor_below_a_leaf(true), *half = floor_below_a_leaf(false);
    sl_image *a = picture_of(masked), *b = picture_of(half);
    const float *direct[2] = {sl_image_channel(a, "direct.G"), sl_image_channel(b, "direct.G")};
    const float *indirect[2] = {sl_image_channel(a, "indirect.G"), sl_image_channel(b, "indirect.G")};
    double sum[2] = {0}, off[2] = {0};
    for (int i = 0; i < PIXELS; i++) {
        off[0] += fabs((double)direct[0][i] - (double)direct[1][i]);
        off[1] += fabs((double)indirect[0][i] - (double)indirect[1][i]);
        sum[0] += (double)direct[1][i];
        sum[1] += (double)indirect[1][i];
    }
    print_message("direct %.2f %%, indirect %.2f %% apart\n", 100.0 * off[0] / sum[0],
                  100.0 * off[1] / sum[1]);
    assert_true(off[0] < 0.02 * sum[0] && off[1] < 0.1 * sum[1]);
    destroy_pictures(a, b);
    sl_scene_destroy(masked);
    sl_scene_destroy(half);
}

/* A floor under a lamp of which the mask leaves two opposite quarters, or nothing. */
static sl_scene *floor_below_a_masked_lamp(uint8_t left) {
    uint8_t texels[16] = {255, 255, 255, left, 255, 255, 255, 0, 255, 255, 255, 0, 255, 255, 255, left};
    trace_mesh mesh = trace_mesh_begin();
    uint32_t white = trace_mesh_diffuse(&mesh, 0.7f), lamp = trace_mesh_lamp(&mesh, 20.0f);
    trace_mesh_quad(&mesh, sl_v3(-2, 0, 2), sl_v3(4, 0, 0), sl_v3(0, 0, -4), white);
    mesh.textures[0] = (sl_texture){NULL, 2, 2, true, texels};
    mesh.texture_count = 1;
    mesh.materials[lamp].alpha_texture = 0;
    trace_mesh_quad(&mesh, sl_v3(-0.4f, 2, -0.4f), sl_v3(0.8f, 0, 0), sl_v3(0, 0, 0.8f), lamp);
    assert_true(sl_camera_look_at(&mesh.camera, sl_v3(0, 1.5f, 2.5f), sl_v3(0, 0, 0), sl_v3(0, 1, 0), 0.9f));
    return trace_mesh_build(&mesh);
}

static double mean_green(const sl_scene *scene, const sl_settings *settings) {
    sl_image *image = render(scene, settings, NULL);
    const float *plane = sl_image_channel(image, "G");
    double sum = 0.0;
    for (int i = 0; i < PIXELS; i++) sum += (double)plane[i];
    sl_image_destroy(image);
    return sum / PIXELS;
}

static void a_masked_lamp_gives_the_light_of_what_its_mask_leaves(void **state) {
    static const char *const methods[] = {"multi-mesh", "direct-radiance"};
    for (int k = 0; k < 4; k++) {
        sl_scene *scene = floor_below_a_masked_lamp(k < 2 ? 255 : 0);
        sl_settings ours = small_settings(methods[k % 2], SIDE, SIDE),
                    truth = small_settings("path", SIDE, SIDE);
        truth.transport = "direct";
        truth.spp = 64;
        double mean = mean_green(scene, &ours), wanted = mean_green(scene, &truth);
        print_message("%s %.5f, paths %.5f\n", methods[k % 2], mean, wanted);
        assert_true(k < 2 ? wanted > 0.004 : wanted == 0.0);
        assert_true(fabs(mean - wanted) <= 0.04 * wanted);
        sl_scene_destroy(scene);
    }
}

/* ---- the foot of a wall ---- */

/* A strip of floor at the foot of a wall with a lamp behind: the way from the strip's vertices to the middles
 * of its triangles runs along the wall. */
static void a_narrow_strip_at_the_foot_of_a_wall_gets_no_light_from_behind_it(void **state) {
    static const char *const strip[] = {
        "v 0 0 -2\nv 0 0 2\nv 0.05 0 2\nv 0.05 0 -2\nv 0 1 2\nv 0 1 -2\nf 1 2 3 4\nf 2 1 6 5\n",
        "v 0 0 -2\nv 0 0 2\nv 0.05 0 2\nv 0.05 0 -2\nv 0 1 2\nv 0 1 -2\nf 2 3 4 1\nf 2 1 6 5\n"};
    for (int k = 0; k < 2; k++) {
        sl_scene *scene = scene_from_text("{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\"}], "
                                          "\"lights\": [{\"type\": \"quad\", \"corner\": [-1, 0.2, -1], "
                                          "\"edge1\": [0, 0.6, 0], \"edge2\": [0, 0, 2], \"radiance\": 50}], "
                                          "\"camera\": {\"eye\": [0.025, 0.1, 0.1], \"target\": "
                                          "[0.025, 0, 0.1], \"up\": [0, 0, 1], \"fov_deg\": 60}}",
                                          strip[k]);
        sl_image *image = picture_of(scene);
        const float *direct = sl_image_channel(image, "direct.G");
        double most = 0.0;
        for (int i = 0; i < PIXELS; i++) most = fmax(most, (double)direct[i]);
        print_message("brightest %g\n", most);
        assert_true(most == 0.0);
        destroy_picture(image, scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_masked_leaf_is_seen_and_shades_as_the_half_that_is_opaque),
        cmocka_unit_test(a_masked_lamp_gives_the_light_of_what_its_mask_leaves),
        cmocka_unit_test(a_narrow_strip_at_the_foot_of_a_wall_gets_no_light_from_behind_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
