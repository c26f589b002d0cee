/* Splatting follows mirrors from the eye: what they show, and which records reach it. */
#include <math.h>
#include <stdlib.h>

#include "unit_test.h"
#include "base/random.h"
#include "cache/splatting/splatting.h"
#include "rendering.h"

/* ---- pictures ---- */

/* A corner of two mirrors, x = 2 and z = -2, above a glossy floor, and a wall behind the camera that is seen
 * in the mirrors alone. */
static const char corner_obj[] =
    "v -4 0 -2\nv 2 0 -2\nv 2 0 4\nv -4 0 4\nv -4 3 -2\nv 2 3 -2\nv 2 3 4\nv -4 3 4\n"
    "usemtl floor\nf 1 4 3 2\nusemtl silver\nf 1 2 6 5\nf 2 3 7 6\nusemtl wall\nf 3 4 8 7\n";
static const char corner_json[] =
    "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\"}],\n"
    " \"materials\": {\"floor\": {\"diffuse\": 0.4, \"specular\": 0.4, \"exponent\": 12}, \"wall\": "
    "{\"diffuse\": [0.8, 0.5, 0.2]},\n"
    "               \"silver\": {\"mirror\": [0.9, 0.8, 0.7]}},\n"
    " \"lights\": [{\"type\": \"point\", \"position\": [-1, 2.5, 2], \"intensity\": [10, 10, 10]}],\n"
    " \"camera\": {\"eye\": [-2, 1.5, 3], \"target\": [1.5, 0.8, -2], \"up\": [0, 1, 0], \"fov_deg\": 60},\n"
    " \"film\": {\"width\": 48, \"height\": 48}}";

/* relMSE against the path tracer on the same paths, less that one's noise. */
static double squared_error(const sl_scene *scene, const sl_image *image, uint32_t samples) {
    sl_settings path = small_settings("path", 48, 48);
    path.transport = "matched:splatting";
    path.spp = samples;
    sl_image *reference = render(scene, &path, NULL);
    sl_comparison c = comparison_of(image, reference);
    print_message("relMSE %.5f, noise %.5f, bias %+.4f\n", c.rel_mse, c.rel_mse_noise, c.bias);
    assert_true(fabs(c.bias) < 0.005);
    sl_image_destroy(reference);
    return c.rel_mse - c.rel_mse_noise;
}

static void what_mirrors_show_is_what_the_path_tracer_says(void **state) {
    sl_scene *scene = scene_from_text(corner_json, corner_obj);
    sl_settings settings = small_settings("splatting", 48, 48);
    sl_image *image = render(scene, &settings, NULL);
    assert_true(squared_error(scene, image, 128) < 0.0005);
    const float *weight = sl_image_channel(image, "weight.Y"), *direct = sl_image_channel(image, "direct.R");
    /* records reach all that is lit */
    for (int i = 0; i < 48 * 48; i++) assert_true(direct[i] == 0.0f || weight[i] > 0.0f);
    destroy_picture(image, scene);
}

/* From a view of mirrors to one without and to another with them: nothing of an earlier view's mirrors is
 * left, and its records stay. */
static void a_camera_may_turn_away_from_mirrors_and_back(void **state) {
    static const float up[3] = {0.0f, 1.0f, 0.0f};
    static const float eyes[3][3] = {{-2.0f, 1.5f, 2.5f}, {1.0f, 0.8f, 1.0f}, {-2.0f, 1.5f, 2.5f}};
    static const float targets[3][3] = {{1.5f, 0.8f, -2.0f}, {-2.0f, 0.0f, 4.0f}, {0.0f, 1.2f, -2.0f}};
    sl_scene *scene = scene_from_text(corner_json, corner_obj);
    sl_settings settings = small_settings("splatting", 48, 48);
    settings.records_per_frame = 1000000000; /* records that do not depend on the view they were made for */
    sl_method *method = created_method(scene, &settings);
    sl_image_destroy(finished_picture(method));
    for (int view = 0; view < 3; view++) {
        assert_int_equal(sl_scene_set_camera(scene, eyes[view], targets[view], up, 1.0f, NULL), SL_OK);
        assert_int_equal(sl_method_edit(method, SL_CHANGED_CAMERA, NULL), SL_OK);
        sl_image *turned = finished_picture(method);
        assert_true(squared_error(scene, turned, 32) < 0.0005);
        sl_image_destroy(turned);
    }
    destroy_method(method, scene);
}

/* ---- rectangles ---- */

enum { WIDTH = 150, HEIGHT = 100, PIXELS = WIDTH * HEIGHT };

/* Pixels that show something by way of a mirror: a disc of the picture, their positions a bent and folded
 * sheet. */
static void show_a_disc(sl_gbuffer *g, sl_reflections *r) {
    r->pixel = malloc(PIXELS * sizeof *r->pixel);
    assert_non_null(r->pixel);
    for (uint32_t i = 0; i < PIXELS; i++) {
        int x = (int)i % WIDTH - 70, y = (int)i / WIDTH - 45;
        if (x * x + y * y > 40 * 40) continue;
        g->position_x[i] = fabsf((float)x * 0.1f);
        g->position_y[i] = (float)y * 0.1f;
        g->position_z[i] = 0.02f * (float)(x * y % 17);
        g->material[i] = (x + y) % 13 ? 0 : SL_NO_INDEX; /* some show nothing */
        r->pixel[r->count++] = i;
    }
}

static bool holds(sl_splat_rect r, int x, int y) { return x >= r.x0 && x < r.x1 && y >= r.y0 && y < r.y1; }

static void every_pixel_that_a_sphere_reaches_lies_in_its_rectangle(void **state) {
    sl_gbuffer *g;
    sl_reflections r = {0};
    uint64_t key = sl_random_key(1, 2), next = 0;
    assert_int_equal(sl_gbuffer_create(WIDTH, HEIGHT, &g, NULL), SL_OK);
    show_a_disc(g, &r);
    const sl_mirror_pixels mirrors = sl_mirror_pixels_find(g, &r);
    size_t reached = 0;
    for (int run = 0; run < 300; run++) {
        float n[4];
        for (int k = 0; k < 4; k++) n[k] = sl_random_unit(key, next++);
        const sl_vec3 centre = sl_v3(5.0f * n[0] - 0.5f, 9.0f * n[1] - 4.5f, n[2] - 0.5f);
        const float reach = 1.5f * n[3] * n[3];
        const sl_splat_rect seen = {run % 140, run % 90, run % 140 + run % 3 * 5, run % 90 + 8};
        const sl_splat_rect all = sl_mirror_bounds(&mirrors, centre, reach, seen);
        for (size_t k = 0; k < r.count; k++) {
            const size_t i = r.pixel[k];
            const int x = (int)i % WIDTH, y = (int)i / WIDTH;
            const sl_vec3 d = sl_sub(sl_v3(g->position_x[i], g->position_y[i], g->position_z[i]), centre);
            if (g->material[i] == SL_NO_INDEX || sl_dot(d, d) > reach * reach) continue;
            assert_true(holds(all, x, y));
            reached++;
        }
        assert_true(seen.x0 == seen.x1 ||
                    (holds(all, seen.x0, seen.y0) && holds(all, seen.x1 - 1, seen.y1 - 1)));
    }
    assert_true(reached > 5000);
    free(r.pixel);
    sl_gbuffer_destroy(g);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_mirrors_show_is_what_the_path_tracer_says),
        cmocka_unit_test(a_camera_may_turn_away_from_mirrors_and_back),
        cmocka_unit_test(every_pixel_that_a_sphere_reaches_lies_in_its_rectangle),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
