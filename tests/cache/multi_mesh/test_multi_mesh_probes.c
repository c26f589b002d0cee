/* Small shadows and small spots of light, at the defaults of quality normal: leaves are larger than they are,
 * and probes find them. */
#include <math.h>
#include <stdio.h>

#include "unit_test.h"
#include "rendering.h"

enum { WIDTH = 160, HEIGHT = 120, POSITIONS = 12, SEGMENTS = 16 };
static const double pi = 3.14159265358979323846;

/* A floor from ten units above, a tenth of a unit a pixel; the light stands beside the view, and so does what
 * is before it. */
static sl_scene *floor_before(const char *floor, const char *light, const char *occluder) {
    char json[1024], obj[8192];
    snprintf(obj, sizeof obj,
             "v -50 0 -40\nv -52 0 38\nv 49 0 41\nv 51 0 -39\nusemtl floor\nf 1 2 3 4\nusemtl black\n%s",
             *occluder ? occluder : "v 0 -1 0\nv 1 -1 0\nv 1 -1 1\nf 5 6 7\n");
    snprintf(json, sizeof json,
             "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\"}], \"materials\": {\"floor\": {%s}, "
             "\"black\": {\"diffuse\": 0}}, \"lights\": [%s], \"camera\": {\"eye\": [0, 10, 0], \"target\": "
             "[0, 0, 0], \"up\": [0, 0, -1], \"fov_deg\": %.9g}}",
             floor, light, 2.0 * atan(0.6) * 180.0 / pi);
    return scene_from_text(json, obj);
}

static const char matt[] = "\"diffuse\": 0.6",
                  glossy[] = "\"diffuse\": 0, \"specular\": 0.6, \"exponent\": 2";
static const char point_light[] = "{\"type\": \"point\", \"position\": [20, 16, 0], \"intensity\": 900}";
static const char area_light[] = "{\"type\": \"quad\", \"corner\": [19.9, 16, -0.1], \"edge1\": [0.2, 0, 0], "
                                 "\"edge2\": [0, 0, 0.2], \"power\": 3000}";

/* The point's light, and a tenth of it from the other side: with several lights each one's mesh is coarser.
 */
static const char two_lights[] = "{\"type\": \"point\", \"position\": [20, 16, 0], \"intensity\": 900}, "
                                 "{\"type\": \"point\", \"position\": [-20, 16, 3], "
                                 "\"intensity\": 90}";

/* Vertices of a level circle from number 5 on. */
static int circle(char *obj, size_t room, double x, double y, double z, double radius) {
    int n = 0;
    for (int i = 0; i < SEGMENTS; i++)
        n += snprintf(obj + n, room - (size_t)n, "v %.9g %.9g %.9g\n",
                      x + radius * cos(2 * pi * i / SEGMENTS), y, z + radius * sin(2 * pi * i / SEGMENTS));
    return n;
}

/* Its shadow is the disc of that radius around (x, 0, z). */
static void disc(char *obj, size_t room, double x, double z, double radius) {
    int n = circle(obj, room, (x + 20.0) / 2.0, 8.0, z / 2.0, radius / 2.0);
    n += snprintf(obj + n, room - (size_t)n, "f");
    for (int i = 0; i < SEGMENTS; i++) n += snprintf(obj + n, room - (size_t)n, " %d", 5 + i);
    snprintf(obj + n, room - (size_t)n, "\n");
}

/* All is dark but for the disc. */
static void hole(char *obj, size_t room, double x, double z, double radius) {
    double at_x = 20.0 + (x - 20.0) / 4.0, at_z = z / 4.0;
    int n = circle(obj, room, at_x, 12.0, at_z, radius / 4.0);
    n += circle(obj + n, room - (size_t)n, at_x, 12.0, at_z, 5.0);
    for (int i = 0; i < SEGMENTS; i++) {
        int j = (i + 1) % SEGMENTS;
        n += snprintf(obj + n, room - (size_t)n, "f %d %d %d %d\n", 5 + i, 5 + j, 5 + SEGMENTS + j,
                      5 + SEGMENTS + i);
    }
}

static sl_settings normal_settings(void) {
    sl_settings settings = small_settings("multi-mesh", WIDTH, HEIGHT);
    settings.quality = SL_QUALITY_NORMAL;
    settings.multi_mesh.coarse_depth = 1; /* there is nothing to gather */
    settings.multi_mesh.coarse_edge = 1e6;
    settings.gather_size = 16;
    return settings;
}

static double fraction(double x) { return x - floor(x); }

/* Of what is seen within so many pixels of a place, the least and the most to that of another picture of the
 * floor. */
static void range_within(const sl_image *image, const sl_image *lit, double x, double z, double reach,
                         double *least, double *most) {
    const float *mine = sl_image_channel(image, "G"), *all = sl_image_channel(lit, "G");
    *least = INFINITY;
    *most = 0.0;
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        double dx = i % WIDTH + 0.5 - (80.0 + 10.0 * x), dz = i / WIDTH + 0.5 - (60.0 + 10.0 * z);
        if (dx * dx + dz * dz > reach * reach) continue;
        assert_true(all[i] > 0.0f);
        *least = fmin(*least, (double)(mine[i] / all[i]));
        *most = fmax(*most, (double)(mine[i] / all[i]));
    }
}

/* Counts the positions, from `left` on to the right, that show nothing of what is there; `shadow`: it is dark
 * within, else lit. */
static int not_found(const char *floor, double left, const char *light,
                     void (*occluder)(char *, size_t, double, double, double), bool shadow) {
    sl_settings settings = normal_settings();
    sl_scene *empty = floor_before(floor, light, "");
    sl_image *lit = render(empty, &settings, NULL);
    int missed = 0;
    uint64_t samples = 0, rays = 0;
    for (int k = 0; k < POSITIONS; k++) {
        char obj[4096];
        double x = left + (6.0 - left) * fraction(0.618034 * k), z = -4.5 + 9.0 * fraction(0.414214 * k),
               least, most;
        occluder(obj, sizeof obj, x, z, 0.3);
        sl_scene *scene = floor_before(floor, light, obj);
        sl_counters counters;
        sl_image *image = render(scene, &settings, &counters);
        range_within(image, lit, x, z, 1.5, &least, &most);
        missed += shadow ? most > 0.5 : least < 0.5;
        samples += counters.value[SL_COUNT_LIGHT_SAMPLES];
        rays += counters.value[SL_COUNT_SHADOW_RAYS];
        destroy_picture(image, scene);
    }
    print_message("%d of %d missed; on average %llu samples of light, %llu shadow rays\n", missed, POSITIONS,
                  (unsigned long long)(samples / POSITIONS), (unsigned long long)(rays / POSITIONS));
    destroy_picture(lit, empty);
    return missed;
}

static void a_round_shadow_of_six_pixels_is_found_wherever_it_is(void **state) {
    assert_int_equal(not_found(matt, -6.0, point_light, disc, true), 0);
    assert_int_equal(not_found(matt, -6.0, area_light, disc, true), 0);
    assert_int_equal(not_found(matt, -6.0, two_lights, disc, true), 0);
}

/* The lobe is so wide that all of the floor but its left end is in its highlight. */
static void a_round_shadow_of_six_pixels_in_a_highlight_is_found_wherever_it_is(void **state) {
    assert_int_equal(not_found(glossy, -3.0, point_light, disc, true), 0);
}

static void a_round_spot_of_light_of_six_pixels_is_found_wherever_it_is(void **state) {
    assert_int_equal(not_found(matt, -6.0, point_light, hole, false), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_round_shadow_of_six_pixels_is_found_wherever_it_is),
        cmocka_unit_test(a_round_shadow_of_six_pixels_in_a_highlight_is_found_wherever_it_is),
        cmocka_unit_test(a_round_spot_of_light_of_six_pixels_is_found_wherever_it_is),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
