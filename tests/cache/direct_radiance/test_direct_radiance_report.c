/* Reports of direct radiance mapping on its maps: flux that they hold, flux that arrives, and a warning where
 * (15) is lost. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "unit_test.h"
#include "base/math.h"
#include "cache/direct_radiance/lights.h"
#include "cache/frame/method.h"
#include "rendering.h"
#include "trace_scenes.h"

static sl_settings settings_with(sl_photon_weight weight, int samples) {
    sl_settings s = small_settings("direct-radiance", 24, 24);
    s.radiance_map.weight = weight;
    s.radiance_map.samples = samples;
    return s;
}

static double told(const sl_scene *scene, const sl_settings *settings, const char *key) {
    sl_image *image = render(scene, settings, NULL);
    const char *text = sl_image_metadata(image, key);
    double value = text ? strtod(text, NULL) : NAN;
    sl_image_destroy(image);
    return value;
}

static bool warns_of(const sl_scene *scene, const sl_settings *settings, const char *what) {
    sl_image *image = render(scene, settings, NULL);
    const char *text = sl_image_metadata(image, "softlux.warning");
    bool warned = text && strstr(text, what);
    sl_image_destroy(image);
    return warned;
}

/* A closed room of 4 x 3 x 5 with a point light; specular: of its walls. */
static trace_mesh room(float diffuse, float specular, sl_vec3 light) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_box(&mesh, sl_v3(0, 0, 0), sl_v3(4, 3, 5), true,
                   trace_mesh_material(&mesh, diffuse, specular, 5, 0, 0));
    mesh.lights[mesh.light_count++] = (sl_light){.type = SL_LIGHT_POINT,
                                                 .position = light,
                                                 .direction = sl_v3(0, -1, 0),
                                                 .intensity = {3, 3, 3},
                                                 .cos_inner = 0.9f,
                                                 .cos_outer = 0.8f};
    mesh.has_camera = true;
    mesh.camera = (sl_camera){.eye = sl_v3(2, 1.5f, 4.5f),
                              .right = sl_v3(1, 0, 0),
                              .up = sl_v3(0, 1, 0),
                              .back = sl_v3(0, 0, 1),
                              .vertical_fov = 1.2f};
    return mesh;
}

/* ---- warnings ---- */

static bool plan_says(const sl_scene *scene, const sl_settings *settings, const char *line) {
    char *plan;
    assert_int_equal(sl_method_plan(scene, settings, &plan, NULL), SL_OK);
    bool says = strstr(plan, line) != NULL;
    free(plan);
    return says;
}

static void a_plan_tells_of_light_through_walls(void **state) {
    const char *line = "\nlimit indirect light goes through walls";
    sl_settings s = settings_with(SL_WEIGHT_FLUX, 4);
    trace_mesh mesh = room(0.5f, 0, sl_v3(2, 1.6f, 2.3f));
    sl_scene *scene = trace_mesh_build(&mesh);
    assert_true(plan_says(scene, &s, line));
    s.radiance_map.visibility = SL_VISIBILITY_RAYS;
    assert_false(plan_says(scene, &s, line));
    sl_scene_destroy(scene);
}

/* ---- captured ---- */

static void a_picture_tells_how_much_of_the_flux_its_map_holds(void **state) {
    trace_mesh mesh = room(0.5f, 0, sl_v3(2, 1.6f, 2.3f));
    sl_scene *scene = trace_mesh_build(&mesh);
    sl_settings s = settings_with(SL_WEIGHT_FLUX, 4);
    assert_true(told(scene, &s, "softlux.flux_captured") == 1.0);
    s.radiance_map.shape = SL_MAP_FRUSTUM;
    assert_true(fabs(told(scene, &s, "softlux.flux_captured") - 1.0 / 6.0) < 1e-4);
    s.radiance_map.map_fov = 2.0 * SL_PI / 3.0;
    assert_true(fabs(told(scene, &s, "softlux.flux_captured") - 0.270) < 1e-3);
    assert_true(warns_of(scene, &s, "the maps hold 27 % of the lights' flux"));
    s.radiance_map.shape = SL_MAP_CUBE;
    assert_false(warns_of(scene, &s, "the maps hold"));
    s.radiance_map.direct_light_only = true; /* no map: nothing to tell */
    s.radiance_map.shape = SL_MAP_FRUSTUM;
    assert_true(isnan(told(scene, &s, "softlux.flux_captured")));
    sl_scene_destroy(scene);
}

/* ---- received ---- */

/* A closed convex room loses nothing, whatever the number of photons; where their light has the inverse
 * square alone. */
static void in_a_convex_room_all_reflected_flux_arrives_once(void **state) {
    static const float specular[] = {0.0f, 0.3f};
    for (int i = 0; i < 2; i++) {
        trace_mesh mesh = room(0.5f, specular[i], sl_v3(2, 1.6f, 2.3f));
        sl_scene *scene = trace_mesh_build(&mesh);
        for (int m = 4; m <= 16; m *= 2) {
            sl_settings plain = settings_with(SL_WEIGHT_PLAIN, m), flux = settings_with(SL_WEIGHT_FLUX, m);
            double all = told(scene, &plain, "softlux.flux_received"),
                   less = told(scene, &flux, "softlux.flux_received");
            print_message("specular %.1f, m = %d: plain %.3f, flux %.3f\n", (double)specular[i], m, all,
                          less);
            if (i == 0) assert_true(fabs(all - 1.0) < 0.1);
            else assert_true(all > 0.8 && all < 1.05); /* lobes lose what they send below the horizon */
            assert_true(less > 0.75 && less < 1.0);
        }
        sl_scene_destroy(scene);
    }
}

static void light_through_walls_is_warned_of(void **state) {
    sl_settings s = settings_with(SL_WEIGHT_FLUX, 4);
    for (int walls = 0; walls < 4; walls += 3) {
        trace_mesh mesh = room(0.5f, 0, sl_v3(2, 1.6f, 0.5f));
        for (int i = 0; i < walls; i++)
            trace_mesh_quad(&mesh, sl_v3(0, 0, 1.0f + (float)i), sl_v3(4, 0, 0), sl_v3(0, 3, 0), 0);
        sl_scene *scene = trace_mesh_build(&mesh);
        assert_true(warns_of(scene, &s, "passes through walls") == (walls > 0));
        s.radiance_map.visibility = SL_VISIBILITY_RAYS;
        assert_false(warns_of(scene, &s, "passes through walls"));
        s.radiance_map.visibility = SL_VISIBILITY_NONE;
        sl_scene_destroy(scene);
    }
}

static void a_sky_that_lights_nothing_is_warned_of(void **state) {
    sl_settings s = settings_with(SL_WEIGHT_FLUX, 4);
    sl_scene *sky = scene_from_text("{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\"}], "
                                    "\"environment\": {\"radiance\": [1, 1, 1]}}",
                                    "v 0 0 0\nv 1 0 0\nv 0 0 -1\nf 1 2 3\n");
    assert_true(warns_of(sky, &s, "the sky is seen, but lights nothing"));
    sl_scene_destroy(sky);
}

/* ---- (15) ---- */

static void weight_15_warns_where_the_scene_is_ten_times_the_lights_way(void **state) {
    for (int far = 0; far < 2; far++) {
        trace_mesh mesh = room(0.5f, 0, sl_v3(2, 1.6f, 2.3f));
        /* outside, and far away */
        if (far) trace_mesh_quad(&mesh, sl_v3(60, 0, 0), sl_v3(1, 0, 0), sl_v3(0, 1, 0), 0);
        sl_scene *scene = trace_mesh_build(&mesh);
        sl_settings box = settings_with(SL_WEIGHT_BOX, 4), disc = settings_with(SL_WEIGHT_DISC, 4);
        assert_true(warns_of(scene, &box, "weight 15") == (far == 1));
        assert_false(warns_of(scene, &disc, "weight 15"));
        sl_scene_destroy(scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_plan_tells_of_light_through_walls),
        cmocka_unit_test(a_picture_tells_how_much_of_the_flux_its_map_holds),
        cmocka_unit_test(in_a_convex_room_all_reflected_flux_arrives_once),
        cmocka_unit_test(light_through_walls_is_warned_of),
        cmocka_unit_test(a_sky_that_lights_nothing_is_warned_of),
        cmocka_unit_test(weight_15_warns_where_the_scene_is_ten_times_the_lights_way),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
