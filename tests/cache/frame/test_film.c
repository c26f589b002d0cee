/* The film: a pixel is the mean over its square. */
#include "unit_test.h"
#include "rendering.h"
#include "scene/scene.h"
#include "scene_files.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const char *const methods[] = {"splatting", "direct-radiance", "light-octree", "multi-mesh",
                                      "shading-cache"};
enum { METHODS = 5 };

static sl_settings on_film(const char *method, int side, unsigned samples) {
    sl_settings s = small_settings(method, side, side);
    s.filter = samples ? SL_FILTER_BOX : SL_FILTER_CENTRE;
    s.sub_samples = samples;
    s.shading_cache.updates = 60;
    return s;
}

/* ---- coverage, which is known ---- */

/* A square that shines with radiance 1, turned by some degrees, before nothing: seen with 90 degrees. */
static const char square_json[] =
    "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\"}], \"materials\": {\"m\": {\"diffuse\": [0, 0, "
    "0], "
    "\"emission\": [1, 1, 1]}}, \"camera\": {\"eye\": [0, 0, 0], \"target\": [0, 0, -1], \"fov_deg\": 90}}";

static sl_scene *shining_quad(double width, double height, double turn) {
    char obj[400], *at = obj;
    static const double corner[4][2] = {{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}};
    for (int k = 0; k < 4; k++) {
        const double x = corner[k][0] * width, y = corner[k][1] * height;
        at += sprintf(at, "v %.9f %.9f -1\n", x * cos(turn) - y * sin(turn), x * sin(turn) + y * cos(turn));
    }
    sprintf(at, "usemtl m\nf 1 2 3 4\n");
    return scene_from_text(square_json, obj);
}

/* The share of a pixel that the square covers, by 64 x 64 points. */
static double covered(int side, int x, int y, double width, double height, double turn) {
    enum { POINTS = 64 };
    int inside = 0;
    for (int i = 0; i < POINTS * POINTS; i++) {
        const double u = (x + (i % POINTS + 0.5) / POINTS) / side * 2.0 - 1.0,
                     v = 1.0 - (y + (i / POINTS + 0.5) / POINTS) / side * 2.0;
        const double a = u * cos(turn) + v * sin(turn), b = v * cos(turn) - u * sin(turn);
        inside += fabs(a) < 0.5 * width && fabs(b) < 0.5 * height;
    }
    return (double)inside / (POINTS * POINTS);
}

/* Of a lamp that is turned by -13.3 degrees the close-ups of its rim see all edges along their diagonals. */
static void a_pixel_shows_as_much_of_a_lamp_as_covers_it(void **state) {
    enum { SIDE = 24 };
    static const double turns[] = {0.3, -0.23183};
    for (int m = 0; m < 2 * METHODS; m++) {
        sl_scene *scene = shining_quad(0.9, 0.7, turns[m % 2]);
        const sl_settings settings = on_film(methods[m / 2], SIDE, 64);
        sl_image *image = render(scene, &settings, NULL);
        const float *red = sl_image_channel(image, "R");
        double sum = 0.0, truth = 0.0, most = 0.0;
        for (int i = 0; i < SIDE * SIDE; i++) {
            const double c = covered(SIDE, i % SIDE, i / SIDE, 0.9, 0.7, turns[m % 2]);
            most = fmax(most, fabs((double)red[i] - c));
            if (c == 0.0 || c == 1.0) assert_true((double)red[i] == c);
            sum += (double)red[i], truth += c;
        }
        print_message("%s: at most %.4f off, all %+.5f\n", methods[m / 2], most, sum / truth - 1.0);
        assert_true(most < 0.005 && fabs(sum / truth - 1.0) < 0.001);
        sl_image_destroy(image);
        sl_scene_destroy(scene);
    }
}

/* Sixteen rays for each of its sixteen samples look for the lamp alone. */
static void the_path_tracer_tells_a_lamps_rim_by_more_rays_than_paths(void **state) {
    enum { SIDE = 24 };
    sl_scene *scene = shining_quad(0.9, 0.7, 0.3);
    sl_settings settings = small_settings("path", SIDE, SIDE);
    settings.filter = SL_FILTER_BOX;
    settings.spp = 16;
    sl_image *image = render(scene, &settings, NULL);
    const float *red = sl_image_channel(image, "R");
    double squares = 0.0;
    for (int i = 0; i < SIDE * SIDE; i++) {
        const double off = (double)red[i] - covered(SIDE, i % SIDE, i / SIDE, 0.9, 0.7, 0.3);
        squares += off * off;
        assert_true(fabs(off) < 0.04);
    }
    assert_true(sqrt(squares / (SIDE * SIDE)) < 0.003);
    sl_image_destroy(image);
    sl_scene_destroy(scene);
}

/* The four-term window over 2 r, 1 in the middle. */
static double window_at(double x, double r) {
    const double turn = 3.14159265358979323846 * (x / r + 1.0);
    if (fabs(x) >= r) return 0.0;
    return 0.35875 - 0.48829 * cos(turn) + 0.14128 * cos(2.0 * turn) - 0.01168 * cos(3.0 * turn);
}

/* The mean of what the square covers around a pixel, by the window over 3 x 3 pixels. */
static double covered_smoothly(int side, int x, int y, double width, double height, double turn) {
    enum { POINTS = 60 };
    double sum = 0.0, all = 0.0;
    for (int i = 0; i < POINTS * POINTS; i++) {
        const double right = (i % POINTS + 0.5) / POINTS * 3.0 - 1.5,
                     up = (i / POINTS + 0.5) / POINTS * 3.0 - 1.5,
                     weight = window_at(right, 1.5) * window_at(up, 1.5);
        const double u = (x + 0.5 + right) / side * 2.0 - 1.0, v = 1.0 - (y + 0.5 + up) / side * 2.0;
        const double a = u * cos(turn) + v * sin(turn), b = v * cos(turn) - u * sin(turn);
        sum += fabs(a) < 0.5 * width && fabs(b) < 0.5 * height ? weight : 0.0;
        all += weight;
    }
    return sum / all;
}

static void a_smooth_filter_weighs_what_lies_around_a_pixel(void **state) {
    enum { SIDE = 16 };
    sl_scene *scene = shining_quad(0.9, 0.7, 0.3);
    const char *const kinds[] = {"splatting", "path"};
    for (int m = 0; m < 2; m++) {
        sl_settings settings = on_film(kinds[m], SIDE, 256);
        settings.filter = SL_FILTER_BLACKMAN_HARRIS;
        settings.spp = m ? 256 : 0;
        sl_image *image = render(scene, &settings, NULL);
        double sum = 0.0, truth = 0.0;
        for (int i = 0; i < SIDE * SIDE; i++) {
            const double c = covered_smoothly(SIDE, i % SIDE, i / SIDE, 0.9, 0.7, 0.3),
                         x = (double)sl_image_channel(image, "R")[i];
            if (fabs(x - c) > 0.06) fail_msg("%s: %g in place of %g", kinds[m], x, c);
            sum += x, truth += c;
        }
        assert_true(fabs(sum / truth - 1.0) < 0.005);
        sl_image_destroy(image);
    }
    sl_scene_destroy(scene);
}

static void a_hair_of_light_is_as_bright_as_it_is_thick(void **state) {
    enum { SIDE = 32, HAIRS = 40 };
    const double thickness = 0.02 * 2.0 / SIDE; /* a fiftieth of a pixel */
    double sum = 0.0;
    for (int turn = 0; turn < HAIRS; turn++) {
        sl_scene *scene = shining_quad(1.6, thickness, 0.05 + 0.37 * turn);
        const sl_settings settings = on_film("splatting", SIDE, 64);
        sl_image *image = render(scene, &settings, NULL);
        for (int i = 0; i < SIDE * SIDE; i++) sum += (double)sl_image_channel(image, "R")[i];
        sl_image_destroy(image);
        sl_scene_destroy(scene);
    }
    const double truth = HAIRS * 1.6 * thickness * SIDE * SIDE / 4.0;
    if (fabs(sum / truth - 1.0) > 0.1) fail_msg("%g, expected %g", sum, truth);
}

/* ---- a checkerboard to the horizon ---- */

/* Black and white squares of a fortieth of a unit under an even sky: beyond a few
 * units each pixel is grey. */
static sl_scene *checkerboard(void) {
    enum { SIDE = 32 };
    sl_scene *scene;
    sl_error error;
    sl_image *image = blank_image(SIDE, SIDE, 1);
    for (int i = 0; i < SIDE * SIDE; i++)
        image->planes[i] = (i % SIDE < SIDE / 2) == (i / SIDE < SIDE / 2) ? 1.0f : 0.0f;
    scene_file_text("squares.png", "");
    assert_int_equal(sl_image_write(image, scene_file_path("squares.png"), &error), SL_OK);
    sl_image_destroy(image);
    scene_file_text("floor.mtl", "newmtl m\nKd 1 1 1\nmap_Kd squares.png\n");
    scene_file_text("floor.obj",
                    "mtllib floor.mtl\nv -999 0 999\nv 999 0 999\nv 999 0 -999\nv -999 0 -999\nvt 0 0\n"
                    "vt 19980 0\nvt 19980 19980\nvt 0 19980\nusemtl m\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n");
    const char *path = scene_file_text(
        "floor.json",
        "{\"softlux\": 1, \"meshes\": [{\"file\": \"floor.obj\"}], \"environment\": {\"radiance\": [1, 1, "
        "1]}, \"camera\": {\"eye\": [0.3, 1, 0.4], \"target\": [0.3, 0.6, -2], \"fov_deg\": 60}}");
    if (sl_scene_load(path, &scene, &error) != SL_OK) fail_msg("%s", error.message);
    return scene;
}

static void a_checkerboard_is_grey_towards_the_horizon(void **state) {
    enum { SIDE = 64, FAR = 23, NEARER = 33 }; /* rows: the horizon lies in the 22nd */
    sl_scene *scene = checkerboard();
    const sl_settings settings = on_film("splatting", SIDE, 16);
    sl_image *image = render(scene, &settings, NULL);
    const float *red = sl_image_channel(image, "R");
    double sum = 0.0, squares = 0.0;
    for (int i = FAR * SIDE; i < NEARER * SIDE; i++) {
        sum += (double)red[i];
        squares += ((double)red[i] - 0.5) * ((double)red[i] - 0.5);
    }
    const double count = (NEARER - FAR) * SIDE, mean = sum / count, deviation = sqrt(squares / count);
    print_message("mean %.4f, off by %.4f\n", mean, deviation);
    assert_true(fabs(mean - 0.5) < 0.006 && deviation < 0.045);
    sl_image_destroy(image);
    sl_scene_destroy(scene);
}

/* ---- pictures ---- */

static double error_of(const sl_scene *scene, const sl_settings *settings, const sl_image *reference,
                       double *bias) {
    sl_image *image = render(scene, settings, NULL);
    sl_comparison c = comparison_of(image, reference);
    sl_image_destroy(image);
    *bias = c.bias;
    return c.rel_rmse;
}

static void every_method_comes_near_to_the_mean_over_pixels(void **state) {
    enum { SIDE = 32 };
    sl_scene *scene = load_scene("scenes/cornell.json");
    for (int m = 0; m < METHODS; m++) {
        char paths[40];
        snprintf(paths, sizeof paths, "matched:%s", methods[m]);
        sl_settings path = small_settings("path", SIDE, SIDE);
        path.transport = paths;
        path.filter = SL_FILTER_BOX;
        path.spp = 256;
        sl_image *reference = render(scene, &path, NULL);
        const sl_settings centres = on_film(methods[m], SIDE, 0), box = on_film(methods[m], SIDE, 64);
        double bias, before = error_of(scene, &centres, reference, &bias),
                     after = error_of(scene, &box, reference, &bias);
        if (!(after < 0.15 * before) || !(fabs(bias) < 0.03))
            fail_msg("%s: %g of %g, bias %g", methods[m], after, before, bias);
        sl_image_destroy(reference);
    }
    sl_scene_destroy(scene);
}

/* Samples that light alone asks for lie where the pilot saw a border of a shadow; elsewhere four do. */
static void samples_lie_where_they_matter(void **state) {
    enum { SIDE = 48 };
    sl_scene *scene = load_scene("scenes/cornell.json");
    const sl_settings settings = on_film("splatting", SIDE, 64);
    sl_counters counters;
    sl_image_destroy(render(scene, &settings, &counters));
    const double samples = (double)counters.value[SL_COUNT_SAMPLES] / (SIDE * SIDE);
    assert_true(samples > 5.0 && samples < 45.0); /* of 68 */
    sl_scene_destroy(scene);
}

/* For things that move: edges are found at the first sub-frame, all else has one sample. */
static void of_four_sub_frames_one_is_whole_and_three_are_of_edges(void **state) {
    enum { SIDE = 24 };
    sl_scene *scene = shining_quad(0.9, 0.7, 0.3);
    for (int m = 0; m < METHODS; m++) {
        const sl_settings settings = on_film(methods[m], SIDE, 4);
        sl_image *image = render(scene, &settings, NULL);
        const float *red = sl_image_channel(image, "R"), *samples = sl_image_channel(image, "samples");
        double off = 0.0, drawn = 0.0;
        for (int i = 0; i < SIDE * SIDE; i++) {
            const double c = covered(SIDE, i % SIDE, i / SIDE, 0.9, 0.7, 0.3);
            const bool inside = c == 0.0 || c == 1.0;
            const float count = samples ? samples[i] : inside ? 1.0f : 4.0f;
            assert_true(count == 4.0f || (inside && count == 1.0f));
            assert_true(inside ? (double)red[i] == c : fabs((double)red[i] - c) < 0.4);
            off += fabs((double)red[i] - c) / (SIDE * SIDE);
            drawn += (double)count / (SIDE * SIDE);
        }
        assert_true(drawn < 2.5 && off < 0.02);
        sl_image_destroy(image);
    }
    sl_scene_destroy(scene);
}

static void the_bits_do_not_depend_on_threads(void **state) {
    sl_scene *scene = load_scene("scenes/cornell-mirror.json");
    for (int m = 0; m < METHODS; m++) {
        sl_settings settings = on_film(methods[m], 24, m % 2 ? 4 : 16);
        assert_same_bits_with_any_threads(scene, &settings);
    }
    sl_scene_destroy(scene);
}

static void a_film_follows_edits(void **state) {
    sl_scene *scene = load_scene("scenes/moving-ball.json"), *other = load_scene("scenes/moving-ball.json");
    const sl_settings settings = on_film("direct-radiance", 32, 16);
    sl_method *method = created_method(scene, &settings);
    sl_image_destroy(finished_picture(method));
    go_to_time(scene, method, 0.7);
    sl_image *moved = finished_picture(method);
    assert_int_equal(sl_scene_set_time(other, 0.7, NULL, NULL), SL_OK);
    sl_image *anew = render(other, &settings, NULL);
    assert_true(same_picture(moved, anew));
    destroy_pictures(moved, anew);
    destroy_method(method, scene);
    sl_scene_destroy(other);
}

/* Splatting draws it for records first, and for its picture when other sub-frames have theirs. */
static void direct_light_of_the_first_sub_frame_is_found_once(void **state) {
    sl_scene *scene = load_scene("scenes/cornell.json");
    const sl_settings centres = on_film("splatting", 32, 0), one = on_film("splatting", 32, 1);
    sl_counters of_centres, of_one;
    sl_image_destroy(render(scene, &centres, &of_centres));
    sl_image_destroy(render(scene, &one, &of_one));
    assert_true((double)of_one.value[SL_COUNT_SHADOW_RAYS] <
                1.1 * (double)of_centres.value[SL_COUNT_SHADOW_RAYS]);
    sl_scene_destroy(scene);
}

/* Whatever sub-frame it comes in the middle of. */
static void light_that_changes_is_seen_in_every_sub_frame(void **state) {
    sl_scene *other = load_scene("scenes/moving-light.json");
    const sl_settings settings = on_film("splatting", 24, 16);
    assert_int_equal(sl_scene_set_time(other, 0.7, NULL, NULL), SL_OK);
    sl_image *anew = render(other, &settings, NULL);
    for (int updates = 1; updates < 100; updates *= 2) {
        sl_scene *scene = load_scene("scenes/moving-light.json");
        sl_method *method = created_method(scene, &settings);
        sl_progress progress;
        for (int i = 0; i < updates; i++) assert_int_equal(sl_method_update(method, &progress, NULL), SL_OK);
        go_to_time(scene, method, 0.7);
        sl_image *moved = finished_picture(method);
        assert_true(same_picture(moved, anew));
        sl_image_destroy(moved);
        destroy_method(method, scene);
    }
    sl_image_destroy(anew);
    sl_scene_destroy(other);
}

/* ---- hard cases ---- */

/* An edge through the centres of a row of pixels covers half of each. */
static void edges_along_pixel_centres_are_half_seen(void **state) {
    enum { SIDE = 16 };
    const double pixel = 2.0 / SIDE;
    sl_scene *scene = shining_quad(9.0 * pixel, 7.0 * pixel, 0.0);
    for (int m = 0; m < METHODS; m++) {
        const sl_settings settings = on_film(methods[m], SIDE, 64);
        sl_image *image = render(scene, &settings, NULL);
        const float *red = sl_image_channel(image, "R");
        for (int i = 0; i < SIDE * SIDE; i++) {
            const double x = fabs(i % SIDE + 0.5 - SIDE / 2), y = fabs(i / SIDE + 0.5 - SIDE / 2);
            const double expected = (x < 4.0   ? 1.0
                                     : x < 5.0 ? 0.5
                                               : 0.0) *
                                    (y < 3.0   ? 1.0
                                     : y < 4.0 ? 0.5
                                               : 0.0);
            if (fabs((double)red[i] - expected) > 0.02)
                fail_msg("%s: %g, not %g", methods[m], red[i], expected);
        }
        sl_image_destroy(image);
    }
    sl_scene_destroy(scene);
}

/* Leaves: a mask whose holes are a quarter of it, each some hundredths of a pixel wide. */
static void a_lamp_behind_leaves_shines_through_their_holes(void **state) {
    enum { SIDE = 16, TEXELS = 64 };
    sl_scene *scene;
    sl_error error;
    sl_image *mask = blank_image(TEXELS, TEXELS, 1);
    for (int i = 0; i < TEXELS * TEXELS; i++)
        mask->planes[i] = i % TEXELS < TEXELS / 2 && i / TEXELS < TEXELS / 2 ? 0.0f : 1.0f;
    scene_file_text("holes.png", "");
    assert_int_equal(sl_image_write(mask, scene_file_path("holes.png"), &error), SL_OK);
    sl_image_destroy(mask);
    scene_file_text("leaves.mtl",
                    "newmtl leaf\nKd 0 0 0\nmap_d holes.png\nnewmtl lamp\nKd 0 0 0\nKe 1 1 1\n");
    scene_file_text(
        "leaves.obj",
        "mtllib leaves.mtl\nv -9 -9 -2\nv 9 -9 -2\nv 9 9 -2\nv -9 9 -2\nv -9 -9 -1\nv 9 -9 -1\nv 9 9 "
        "-1\nv -9 9 -1\nvt 0 0\nvt 777 0\nvt 777 777\nvt 0 777\nusemtl lamp\nf 1/1 2/2 3/3 4/4\nusemtl "
        "leaf\nf 5/1 6/2 7/3 8/4\n");
    const char *path =
        scene_file_text("leaves.json", "{\"softlux\": 1, \"meshes\": [{\"file\": \"leaves.obj\"}], "
                                       "\"camera\": {\"eye\": [0, 0, 0], \"target\": [0, 0, -1], "
                                       "\"fov_deg\": 90}}");
    if (sl_scene_load(path, &scene, &error) != SL_OK) fail_msg("%s", error.message);
    const sl_settings settings = on_film("splatting", SIDE, 64);
    sl_image *image = render(scene, &settings, NULL);
    double sum = 0.0;
    for (int i = 0; i < SIDE * SIDE; i++) sum += (double)sl_image_channel(image, "R")[i] / (SIDE * SIDE);
    print_message("%.4f of the lamp\n", sum);
    assert_true(fabs(sum - 0.25) < 0.02);
    sl_image_destroy(image);
    sl_scene_destroy(scene);
}

static void a_pixel_of_a_film_is_not_explained(void **state) {
    sl_scene *scene = load_scene("scenes/cornell.json");
    const sl_settings settings = on_film("splatting", 8, 4);
    sl_method *method = created_method(scene, &settings);
    sl_image *image = finished_picture(method);
    sl_explanation *explanation;
    sl_error error;
    assert_int_equal(sl_method_explanation(method, image, 3, 3, &explanation, &error), SL_ERROR_USAGE);
    assert_non_null(strstr(error.message, "filter=centre"));
    sl_image_destroy(image);
    destroy_method(method, scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_pixel_shows_as_much_of_a_lamp_as_covers_it),
        cmocka_unit_test(the_path_tracer_tells_a_lamps_rim_by_more_rays_than_paths),
        cmocka_unit_test(a_smooth_filter_weighs_what_lies_around_a_pixel),
        cmocka_unit_test(a_hair_of_light_is_as_bright_as_it_is_thick),
        cmocka_unit_test(a_checkerboard_is_grey_towards_the_horizon),
        cmocka_unit_test(every_method_comes_near_to_the_mean_over_pixels),
        cmocka_unit_test(samples_lie_where_they_matter),
        cmocka_unit_test(of_four_sub_frames_one_is_whole_and_three_are_of_edges),
        cmocka_unit_test(the_bits_do_not_depend_on_threads),
        cmocka_unit_test(a_film_follows_edits),
        cmocka_unit_test(direct_light_of_the_first_sub_frame_is_found_once),
        cmocka_unit_test(light_that_changes_is_seen_in_every_sub_frame),
        cmocka_unit_test(edges_along_pixel_centres_are_half_seen),
        cmocka_unit_test(a_lamp_behind_leaves_shines_through_their_holes),
        cmocka_unit_test(a_pixel_of_a_film_is_not_explained),
    };
    return cmocka_run_group_tests(tests, NULL, scene_files_teardown);
}
