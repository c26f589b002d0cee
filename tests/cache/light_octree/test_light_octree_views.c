/* Pictures by the light octree: figure 2's ball, the paper's holes and their cures, edits of lights and
 * objects, and what is said beside a picture. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "unit_test.h"
#include "cache/light_octree/light_octree.h"
#include "rendering.h"

static sl_settings octree_settings(int size) {
    sl_settings s = small_settings("light-octree", size, size);
    s.light_octree.photons = 30000;
    s.light_octree.neighbours = 60;
    s.light_octree.indirect_only = true;
    return s;
}

static double mean_indirect(const sl_scene *scene, const sl_settings *settings) {
    sl_image *image = render(scene, settings, NULL);
    double mean = channel_mean(image, "indirect.G");
    sl_image_destroy(image);
    return mean;
}

/* ---- figure 2 ---- */

/* Rings of quads around the unit sphere, faces outwards, normals of the sphere. */
static char *ball_obj(void) {
    enum { RINGS = 16, COLUMNS = 32 };
    size_t room = 1 << 18, at = 0;
    char *text = malloc(room);
    assert_non_null(text);
    for (int j = 0; j <= RINGS; j++) {
        for (int i = 0; i < COLUMNS; i++) {
            double theta = 3.14159265358979 * (j + 0.01 * (j == 0) - 0.01 * (j == RINGS)) / RINGS,
                   phi = 6.28318530717959 * i / COLUMNS;
            double x = sin(theta) * cos(phi), y = cos(theta), z = sin(theta) * sin(phi);
            at += (size_t)snprintf(text + at, room - at, "v %.6f %.6f %.6f\nvn %.6f %.6f %.6f\n", x, y, z, x,
                                   y, z);
        }
    }
    for (int j = 0; j < RINGS; j++) {
        for (int i = 0; i < COLUMNS; i++) {
            int a = j * COLUMNS + i + 1, b = j * COLUMNS + (i + 1) % COLUMNS + 1, c = a + COLUMNS,
                d = b + COLUMNS;
            at += (size_t)snprintf(text + at, room - at, "f %d//%d %d//%d %d//%d\nf %d//%d %d//%d %d//%d\n",
                                   a, a, b, b, d, d, a, a, d, d, c, c);
        }
    }
    return text;
}

/* Root mean square difference of R and G from those of the reference. */
static double rms_from(const sl_image *image, const sl_image *truth) {
    size_t count = (size_t)truth->width * (size_t)truth->height;
    const char *const ours[] = {"indirect.R", "indirect.G"}, *const theirs[] = {"direct.R", "direct.G"};
    double sum = 0.0;
    for (int k = 0; k < 2; k++) {
        for (size_t i = 0; i < count; i++) {
            double d =
                (double)sl_image_channel(image, ours[k])[i] - (double)sl_image_channel(truth, theirs[k])[i];
            sum += d * d;
        }
    }
    return sqrt(sum / (2.0 * (double)count));
}

/* A ball under a red light and a green one, photons of direct light stored (figure 2): one colour a voxel
 * makes blocks, lights with directions follow the ball's own normals. */
static void lights_with_directions_shade_a_ball_that_colours_leave_flat(void **state) {
    char *obj = ball_obj();
    sl_scene *scene =
        scene_from_text("{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\", \"material\": \"grey\"}], "
                        "\"materials\": {\"grey\": {\"diffuse\": 0.7}}, "
                        "\"lights\": [{\"type\": \"spot\", \"position\": [-4, 3, 4], \"direction\": [4, -3, "
                        "-4], \"intensity\": [40, 0, 0], \"outer_deg\": 14},"
                        " {\"type\": \"spot\", \"position\": [5, 2, 3], \"direction\": [-5, -2, -3], "
                        "\"intensity\": [0, 40, 0], \"outer_deg\": 14}], "
                        "\"camera\": {\"eye\": [0, 0.5, 4], \"target\": [0, 0, 0], \"fov_deg\": 40}}",
                        obj);
    sl_settings settings = octree_settings(48), direct = octree_settings(48);
    /* direct light of pixels is exact where lights have no extent */
    direct.light_octree.indirect_only = false;
    sl_image *truth = render(scene, &direct, NULL);
    double rms[2];
    for (int colour = 0; colour < 2; colour++) {
        settings.light_octree.store = SL_STORE_ALL;
        settings.light_octree.depth = 2;
        settings.light_octree.photons = 60000;
        settings.light_octree.neighbours = 200;
        settings.light_octree.whole_voxels = true;
        settings.light_octree.lobes = colour ? SL_LOBES_NONE : SL_LOBES_PERPENDICULAR;
        sl_image *image = render(scene, &settings, NULL);
        rms[colour] = rms_from(image, truth);
        sl_image_destroy(image);
    }
    print_message("rms %.4f with directions, %.4f without, of a mean of %.4f\n", rms[0], rms[1],
                  channel_mean(truth, "direct.G"));
    assert_true(rms[0] < 0.75 * rms[1]);
    destroy_picture(truth, scene);
    free(obj);
}

/* ---- holes ---- */

/* Figure 16c: empty voxels that count as black darken; larger voxels leave fewer of them empty, and
 * renormalizing needs none of that. */
static void larger_voxels_close_the_holes_that_empty_ones_tear(void **state) {
    sl_scene *scene = load_scene("scenes/sphere.json");
    sl_settings settings = octree_settings(32);
    double plain = mean_indirect(scene, &settings);
    settings.light_octree.keep_void_dark = true;
    double holes = mean_indirect(scene, &settings);
    settings.light_octree.dilation = 0.5;
    double larger = mean_indirect(scene, &settings);
    settings.light_octree.keep_void_dark = false;
    double both = mean_indirect(scene, &settings);
    print_message("%.4f; with holes %.4f, with larger voxels %.4f; these without holes %.4f\n", plain, holes,
                  larger, both);
    assert_true(holes < 0.97 * plain && larger > holes + 0.7 * (plain - holes) && larger < 1.02 * plain);
    assert_true(fabs(both / plain - 1.0) < 0.03);
    sl_scene_destroy(scene);
}

/* ---- edits ---- */

static sl_image *next_frame(sl_method *method, unsigned changes) {
    if (changes) assert_int_equal(sl_method_edit(method, changes, NULL), SL_OK);
    return finished_picture(method);
}

/* Things that move, and lights that change, leave nothing behind: not in photons, not in voxels, not in the
 * atlas. */
static void a_frame_of_a_series_is_that_frame_alone(void **state) {
    const char *const scenes[] = {"scenes/moving-light.json", "scenes/moving-ball.json"};
    for (int k = 0; k < 4; k++) {
        sl_scene *scene = load_scene(scenes[k & 1]);
        sl_settings settings = octree_settings(24);
        settings.light_octree.photons = 5000;
        settings.light_octree.depth = 4;
        settings.light_octree.atlas = k & 2;
        settings.light_octree.atlas_size = 128;
        sl_method *method = created_method(scene, &settings);
        sl_image *first = next_frame(method, 0), *second;
        unsigned changes;
        assert_int_equal(sl_scene_set_time(scene, 0.9, &changes, NULL), SL_OK);
        assert_true(changes & (k & 1 ? SL_CHANGED_OBJECTS : SL_CHANGED_LIGHTS));
        second = next_frame(method, changes);
        sl_image *alone = render(scene, &settings, NULL);
        assert_true(same_picture(second, alone) && !same_picture(first, second));
        destroy_pictures(first, second);
        sl_image_destroy(alone);
        destroy_method(method, scene);
    }
}

/* Pixels of a triangle share points two by two while a picture moves: so it differs, and little. */
static void a_frame_in_motion_is_nearly_the_picture_at_rest(void **state) {
    sl_scene *scene = load_scene("scenes/cornell.json");
    enum { SIDE = 256 };
    const sl_settings settings = octree_settings(SIDE);
    sl_method *method = created_method(scene, &settings);
    sl_progress progress = {0};
    sl_image *rest = finished_picture(method);
    double apart = 0.0, total = 0.0;
    assert_int_equal(sl_method_edit(method, SL_CHANGED_CAMERA, NULL), SL_OK);
    assert_int_equal(sl_method_update(method, &progress, NULL), SL_OK);
    assert_true(progress.frame_done);
    sl_image *moving = resolved_picture(method);
    sl_image *again = finished_picture(method);
    for (size_t i = 0; i < SIDE * SIDE; i++) {
        const float there = sl_image_channel(rest, "indirect.G")[i];
        apart += fabs((double)sl_image_channel(moving, "indirect.G")[i] - (double)there);
        total += (double)there;
    }
    print_message("%.4f apart\n", apart / total);
    assert_true(apart > 0.0 && apart < 0.02 * total);
    assert_true(same_picture(rest, again));
    destroy_pictures(rest, moving);
    sl_image_destroy(again);
    destroy_method(method, scene);
}

static void a_frame_that_is_drawn_in_strips_is_that_of_whole_steps(void **state) {
    sl_scene *scene = load_scene("scenes/cornell.json");
    sl_settings settings = octree_settings(75); /* two strips, and some rows */
    settings.light_octree.indirect_only = false;
    sl_method *method = created_method(scene, &settings);
    sl_progress progress = {0};
    sl_image_destroy(finished_picture(method));
    sl_octree_state *s = method->state;
    const size_t bytes = SL_OCTREE_PLANES * 75 * 75 * sizeof(float);
    float *strips = malloc(bytes);
    int row = 0;
    assert_int_equal(sl_method_edit(method, SL_CHANGED_CAMERA, NULL), SL_OK);
    assert_int_equal(sl_method_update(method, &progress, NULL), SL_OK);
    assert_true(progress.frame_done && strips && sl_direct_is_mapped(s->motion.direct));
    memcpy(strips, s->planes, bytes);
    assert_int_equal(sl_octree_draw_gbuffer(s, NULL), SL_OK);
    assert_int_equal(
        sl_direct_rows(s->motion.direct, s->gbuffer, 75, &row, s->direct_light, &s->counters, NULL), SL_OK);
    assert_int_equal(sl_octree_light_picture(s, true, NULL), SL_OK);
    assert_memory_equal(strips, s->planes, bytes);
    free(strips);
    destroy_method(method, scene);
}

/* ---- what is said ---- */

static double number(const sl_image *image, const char *name) {
    char key[64];
    snprintf(key, sizeof key, "softlux.octree.%s", name);
    const char *text = sl_image_metadata(image, key);
    if (!text) fail_msg("no %s", key);
    return atof(text);
}

static void pictures_say_what_they_were_made_from(void **state) {
    sl_scene *scene = load_scene("scenes/cornell.json");
    sl_settings settings = octree_settings(16);
    sl_counters counters;
    sl_image *image = render(scene, &settings, &counters);
    assert_true(number(image, "depth") == 5.0 && number(image, "leaves") == 6320.0 &&
                number(image, "sets") > 6320.0);
    assert_true(number(image, "photons_emitted") == (double)counters.value[SL_COUNT_PHOTONS_EMITTED]);
    assert_true(number(image, "photons_stored") == (double)counters.value[SL_COUNT_PHOTONS_STORED]);
    assert_true(number(image, "photons_a_voxel") > 40.0 && number(image, "photons_a_voxel") <= 60.0);
    assert_true(number(image, "flux") > 0.0);
    assert_true(fabs(number(image, "radius_in_voxels") / number(image, "radius") * 555.0 / 32.0 - 1.0) <
                0.02);
    /* flat and matt: a head and a light */
    assert_true(number(image, "texture_bytes") > 6320.0 * 32.0 && number(image, "texture_bytes") < 4e5);
    /* the lights' texels in 24 bytes instead of 16 */
    assert_true(number(image, "resident_bytes") > number(image, "texture_bytes") + 6320.0 * 16.0 &&
                number(image, "resident_bytes") < 1.5 * number(image, "texture_bytes") + 1000.0);
    assert_null(sl_image_metadata(image, "softlux.warning"));
    sl_image_destroy(image);
    settings.light_octree.whole_voxels = true;
    image = render(scene, &settings, NULL);
    assert_true(number(image, "spread_deg") > 15.0 && number(image, "spread_deg") < 40.0);
    assert_true(number(image, "texture_bytes") > 6320.0 * 64.0 && number(image, "texture_bytes") < 8.0e5);
    destroy_picture(image, scene);
}

/* Few photons for voxels that count their own, and gathers far wider than voxels. */
static void few_photons_and_wide_gathers_are_warned_of(void **state) {
    sl_scene *scene = load_scene("scenes/cornell.json");
    for (int own = 0; own < 2; own++) {
        sl_settings settings = octree_settings(8);
        settings.light_octree.photons = 3000;
        settings.light_octree.depth = 6;
        settings.light_octree.own_photons = own;
        sl_image *image = render(scene, &settings, NULL);
        const char *warning = sl_image_metadata(image, "softlux.warning");
        assert_non_null(warning);
        assert_non_null(strstr(warning, own ? "photons a voxel are few" : "voxels around"));
        sl_image_destroy(image);
    }
    sl_scene_destroy(scene);
}

/* Four lights stand for wide caps: gloss that is sharper shows indirect light blurred. One irradiance and the
 * photons themselves are another matter. */
static void gloss_that_is_widened_is_warned_of(void **state) {
    sl_scene *scene = load_scene("scenes/cornell-glossy.json");
    for (int k = 0; k < 3; k++) {
        sl_settings settings = octree_settings(8);
        settings.light_octree.photons = 20000;
        settings.light_octree.lobes = k == 1 ? SL_LOBES_NONE : SL_LOBES_PERPENDICULAR;
        settings.light_octree.photons_at_pixels = k == 2;
        sl_image *image = render(scene, &settings, NULL);
        const char *warning = sl_image_metadata(image, "softlux.warning");
        char *plan;
        assert_true((warning && strstr(warning, "above 6 reflect indirect light blurred")) == (k == 0));
        assert_int_equal(sl_method_plan(scene, &settings, &plan, NULL), SL_OK);
        assert_true((strstr(plan, "gloss sharper than that") != NULL) == (k == 0));
        free(plan);
        sl_image_destroy(image);
    }
    sl_scene_destroy(scene);
}

static char *plan_of(const sl_scene *scene, uint64_t photons) {
    sl_settings settings = octree_settings(8);
    char *plan;
    settings.light_octree.photons = photons;
    assert_int_equal(sl_method_plan(scene, &settings, &plan, NULL), SL_OK);
    return plan;
}

/* A floor of 16 at depth 5 meets 1,024 to 1,536 voxels. */
static void the_plan_tells_of_few_photons(void **state) {
    static const char json[] = "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\"}], \"lights\": "
                               "[{\"type\": \"point\", \"position\": [0, 1, 0], \"intensity\": 1}], "
                               "\"camera\": {\"eye\": [0, 3, 0.1], \"target\": [0, 0, 0], \"fov_deg\": 30}}";
    sl_scene *scene = scene_from_text(json, "v -2 0 -2\nv 2 0 -2\nv 2 0 2\nv -2 0 2\nf 1 4 3 2\n");
    char *enough = plan_of(scene, 30000), *few = plan_of(scene, 3000);
    assert_non_null(strstr(enough, "about 1.5e+03 voxels, 20 photons each\n"));
    assert_non_null(strstr(few, "less than a tenth of 60"));
    free(enough);
    free(few);
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lights_with_directions_shade_a_ball_that_colours_leave_flat),
        cmocka_unit_test(larger_voxels_close_the_holes_that_empty_ones_tear),
        cmocka_unit_test(a_frame_of_a_series_is_that_frame_alone),
        cmocka_unit_test(a_frame_in_motion_is_nearly_the_picture_at_rest),
        cmocka_unit_test(a_frame_that_is_drawn_in_strips_is_that_of_whole_steps),
        cmocka_unit_test(pictures_say_what_they_were_made_from),
        cmocka_unit_test(few_photons_and_wide_gathers_are_warned_of),
        cmocka_unit_test(gloss_that_is_widened_is_warned_of),
        cmocka_unit_test(the_plan_tells_of_few_photons),
    };
    return cmocka_run_group_tests_name("light octree: views", tests, NULL, NULL);
}
