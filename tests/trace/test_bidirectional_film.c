/* The bidirectional path tracer's film: the path tracer's pictures, and what the path tracer cannot find. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "unit_test.h"
#include "base/math.h"
#include "rendering.h"
#include "trace/trace.h"
#include "trace_scenes.h"

#if defined __SANITIZE_ADDRESS__ || defined __SANITIZE_THREAD__ || defined SL_THREADS_WITHOUT_OPENMP
enum { SAMPLES = 16 };
#else
enum { SAMPLES = 64 };
#endif
enum { WIDTH = 24, HEIGHT = 20, PIXELS = WIDTH * HEIGHT };

/* ---- whole pictures -------------------------------------------------------------------------- */

static trace_picture render_path(const sl_scene *scene, const sl_transport *transport, unsigned samples) {
    return trace_picture_of(scene, &(sl_path_settings){WIDTH, HEIGHT, 2, 11, *transport, false}, samples,
                            false);
}

static trace_picture render_both_ways(const sl_scene *scene, const sl_transport *transport,
                                      unsigned samples) {
    return trace_picture_of(scene, &(sl_path_settings){WIDTH, HEIGHT, 2, 5, *transport, true}, samples,
                            false);
}

/* Two pictures of the same: how far the means of blocks of 4 x 4 pixels are apart, over what the pictures'
 * halves say of their noise, and the difference of the whole means in standard errors. One block's noise is
 * known badly, so all are pooled. */
typedef struct agreement {
    double blocks; /* mean squared difference over mean squared noise: about 1 */
    double means;  /* in standard errors */
} agreement;

static agreement compare(const trace_picture *first, const trace_picture *second) {
    float *a[3], *b[3]; /* of all, even and odd samples */
    for (int h = 0; h < 3; h++) a[h] = first->plane[h][0], b[h] = second->plane[h][0];
    double difference = 0.0, noise = 0.0, sum = 0.0, variance = 0.0, whole = 0.0;
    for (int i = 0; i < 3 * PIXELS; i++) whole += (double)a[0][i] / (3.0 * PIXELS);
    for (int c = 0; c < 3; c++) {
        for (int y = 0; y < HEIGHT; y += 4) {
            for (int x = 0; x < WIDTH; x += 4) {
                double d = 0.0, na = 0.0, nb = 0.0, level = 0.0;
                for (int k = 0; k < 16; k++) {
                    int i = c * PIXELS + (y + k / 4) * WIDTH + x + k % 4;
                    d += (double)a[0][i] - (double)b[0][i];
                    na += 0.5 * ((double)a[1][i] - (double)a[2][i]);
                    nb += 0.5 * ((double)b[1][i] - (double)b[2][i]);
                    level += (double)a[0][i];
                }
                level = 0.0625 * level + 0.3 * whole; /* a block that is all but black tells nothing */
                double scale = 1.0 / (level * level);
                difference += d * d * scale;
                noise += (na * na + nb * nb) * scale;
                sum += d;
                variance += na * na + nb * nb;
            }
        }
    }
    /* The three channels go together. */
    return (agreement){difference / fmax(noise, 1e-12), fabs(sum) / sqrt(3.0 * variance + 1e-12)};
}

static void check_equal(const char *what, const trace_picture *a, const trace_picture *b) {
    agreement found = compare(a, b);
    print_message("%-34s squared difference over noise %.2f, means %.1f standard errors apart\n", what,
                  found.blocks, found.means);
    if (!(found.blocks < 3.5 && found.means < 4.0)) fail_msg("%s: %g, %g", what, found.blocks, found.means);
}

static void check_transport(const char *what, const sl_scene *scene, const sl_transport *transport) {
    trace_picture a = render_path(scene, transport, 2 * SAMPLES),
                  b = render_both_ways(scene, transport, SAMPLES);
    check_equal(what, &b, &a);
    trace_picture_free(&a);
    trace_picture_free(&b);
}

static void check_named(const char *what, const sl_scene *scene) {
    static const char *const names[] = {"direct", "one-bounce", "full"};
    for (int i = 0; i < 3; i++) {
        char line[96];
        snprintf(line, sizeof line, "%s, %s", what, names[i]);
        const sl_transport transport = transport_of(names[i]);
        check_transport(line, scene, &transport);
    }
}

static void rooms_with_lamps_and_point_lights_are_those_of_the_path_tracer(void **unused) {
    static const char *const files[] = {"scenes/cornell.json", "scenes/cornell-point.json"};
    for (int i = 0; i < 2; i++) {
        sl_scene *scene = load_scene(files[i]);
        check_named(files[i], scene);
        sl_scene_destroy(scene);
    }
}

/* Mirrors seen and mirrors that throw caustics of a lamp, glossy and two-sided things, slanted shading
 * normals, a sky. */
static sl_scene *rich_scene(bool sky_light, bool lamp_light) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t wall = trace_mesh_diffuse(&mesh, 0.6f),
             glossy = trace_mesh_material(&mesh, 0.2f, 0.6f, 12, 0, 0);
    uint32_t mirror = trace_mesh_material(&mesh, 0, 0, 0, 0.9f, 0),
             lamp = trace_mesh_material(&mesh, 0.3f, 0, 0, 0, 9.0f);
    mesh.materials[wall].diffuse = (sl_rgb){0.7f, 0.5f, 0.4f};
    mesh.materials[lamp].emission_two_sided = true;
    trace_mesh_quad(&mesh, sl_v3(-3, -1, -3), sl_v3(0, 0, 6), sl_v3(6, 0, 0), wall);
    trace_mesh_quad(&mesh, sl_v3(-3, -1, -3), sl_v3(6, 0, 0), sl_v3(0, 4, 0), glossy);
    trace_mesh_quad(&mesh, sl_v3(-3, -1, -3), sl_v3(0, 4, 0), sl_v3(0, 0, 6), mirror);
    trace_mesh_sphere(&mesh, sl_v3(0.9f, -0.3f, 0.2f), 0.7f, 8, 0.3f, false, wall);
    if (lamp_light)
        trace_mesh_quad(&mesh, sl_v3(-1.5f, 1.2f, 0.5f), sl_v3(0.8f, 0.2f, 0), sl_v3(0, 0, 0.8f), lamp);
    static float texels[3 * 8 * 4];
    for (int i = 0; i < 3 * 8 * 4; i++) texels[i] = 0.05f + (i >= 3 * 9 && i < 3 * 10 ? 6.0f : 0.0f);
    static sl_environment sky;
    sky = (sl_environment){.present = true, .width = 8, .height = 4, .texels = texels};
    if (sky_light) mesh.environment = &sky;
    mesh.has_camera = true;
    assert_true(sl_camera_look_at(&mesh.camera, sl_v3(1.5f, 1, 4), sl_v3(0, 0.2f, 0), sl_v3(0, 1, 0), 0.9f));
    return trace_mesh_build(&mesh);
}

static void mirrors_caustics_and_two_sided_lamps_are_those_of_the_path_tracer(void **unused) {
    sl_scene *scene = rich_scene(false, true);
    check_named("mirrors and a lamp", scene);
    sl_scene_destroy(scene);
}

static void skies_are_those_of_the_path_tracer(void **unused) {
    sl_scene *sky = rich_scene(true, false), *both = rich_scene(true, true);
    check_named("sky", sky);
    sl_transport full = transport_of("full");
    check_transport("sky and lamp", both, &full);
    sl_scene_destroy(sky);
    sl_scene_destroy(both);
}

static void spots_and_distant_lights_are_those_of_the_path_tracer(void **unused) {
    for (int kind = 0; kind < 2; kind++) {
        trace_mesh mesh = trace_mesh_begin();
        uint32_t wall = trace_mesh_diffuse(&mesh, 0.8f);
        trace_mesh_box(&mesh, sl_v3(-2, -1, -2), sl_v3(2, 2.5f, 2), true, wall);
        if (kind == 1) mesh.triangle_count -= 2; /* a window, from which the light shines into the room */
        trace_mesh_sphere(&mesh, sl_v3(0.4f, -0.5f, 0), 0.5f, 10, 0.0f, false, wall);
        mesh.lights[0] = (sl_light){.type = SL_LIGHT_SPOT,
                                    .position = {1, 2, 1},
                                    .direction = {-0.36f, -0.8f, -0.48f},
                                    .intensity = {30, 20, 10},
                                    .cos_inner = 0.95f,
                                    .cos_outer = 0.8f};
        if (kind == 1) {
            mesh.lights[0] = (sl_light){
                .type = SL_LIGHT_DIRECTIONAL, .direction = {0.48f, -0.36f, -0.8f}, .intensity = {3, 4, 5}};
        }
        mesh.light_count = 1;
        mesh.has_camera = true;
        assert_true(sl_camera_look_at(&mesh.camera, sl_v3(-1.5f, 0.8f, 1.6f), sl_v3(0, -0.2f, 0),
                                      sl_v3(0, 1, 0), 1.2f));
        sl_scene *scene = trace_mesh_build(&mesh);
        sl_transport one = transport_of("one-bounce"), full = transport_of("full");
        check_transport(kind ? "distant light, one-bounce" : "spot, one-bounce", scene, &one);
        check_transport(kind ? "distant light, full" : "spot, full", scene, &full);
        sl_scene_destroy(scene);
    }
}

/* Paths that methods declare: legs without shadows, lobes left out, mirrors as black surfaces, pixel centres
 * alone. */
static void any_declared_transport_is_that_of_the_path_tracer(void **unused) {
    sl_scene *scene = rich_scene(true, true);
    sl_transport full = transport_of("full"), t = full;
    t.direct_visibility = false;
    check_transport("direct light without shadows", scene, &t);
    t = full;
    t.bounce_visibility = false;
    check_transport("indirect light without shadows", scene, &t);
    t.direct_visibility = false;
    t.bounces = 2;
    check_transport("neither, two bounces", scene, &t);
    t = full;
    t.emission = t.eye_mirrors = false;
    check_transport("no emission, no mirrors seen", scene, &t);
    t = full;
    t.direct_lobes = 0;
    check_transport("indirect light alone", scene, &t);
    t.receiver_lobes = SL_LOBE_GLOSSY;
    t.bounce_lobes = SL_LOBE_DIFFUSE | SL_LOBE_MIRROR;
    check_transport("glossy reflections of diffuse", scene, &t);
    t = full;
    t.bounces = 0;
    t.receiver_lobes = SL_LOBE_DIFFUSE;
    t.direct_lobes = SL_LOBE_GLOSSY;
    t.bounce_lobes = SL_LOBE_MIRROR;
    check_transport("caustics and highlights", scene, &t);
    t = full;
    t.sky_light = false;
    check_transport("a sky that lights nothing", scene, &t);
    t.bounce_visibility = false;
    check_transport("nor behind walls that are seen through", scene, &t);
    t = full;
    t.filter = SL_FILTER_CENTRE;
    check_transport("pixel centres", scene, &t);
    sl_scene_destroy(scene);
}

/* ---- what the path tracer cannot find -------------------------------------------------------- */

/* A point light above a floor, beside a flat mirror: the mirror's image of the light lights the floor too, in
 * closed form. */
static void a_point_light_throws_caustics(void **unused) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t floor = trace_mesh_diffuse(&mesh, 0.5f), mirror = trace_mesh_material(&mesh, 0, 0, 0, 0.8f, 0);
    trace_mesh_quad(&mesh, sl_v3(-4, -4, 0), sl_v3(8, 0, 0), sl_v3(0, 8, 0), floor);
    trace_mesh_quad(&mesh, sl_v3(-1, -40, 0), sl_v3(0, 80, 0), sl_v3(0, 0, 40), mirror);
    trace_mesh_point_light(&mesh, sl_v3(0.5f, 0, 1), sl_grey(2));
    mesh.has_camera = true;
    assert_true(sl_camera_look_at(&mesh.camera, sl_v3(1.0f, 0, 3), sl_v3(1.0f, 0, 0), sl_v3(0, 1, 0), 0.3f));
    sl_scene *scene = trace_mesh_build(&mesh);
    sl_transport full = transport_of("full");
    trace_picture p = render_both_ways(scene, &full, 20 * SAMPLES);
    double expected = 0.0, found = 0.0, half = 3.0 * tan(0.15);
    for (int y = 0; y < HEIGHT; y++) {
        for (int x = 0; x < WIDTH; x++) {
            double px = 1.0 + half * (2.0 * (x + 0.5) / WIDTH - 1.0) * WIDTH / HEIGHT,
                   py = half * (1.0 - 2.0 * (y + 0.5) / HEIGHT);
            double real = (px - 0.5) * (px - 0.5) + py * py + 1.0,
                   image = (px + 2.5) * (px + 2.5) + py * py + 1.0;
            expected +=
                0.5 / SL_PI * 2.0 * (1.0 / (real * sqrt(real)) + 0.8 / (image * sqrt(image))) / PIXELS;
            found += (double)p.plane[0][0][y * WIDTH + x] / PIXELS;
        }
    }
    print_message("mean radiance %.6f, expected %.6f\n", found, expected);
    assert_true(fabs(found / expected - 1.0) < 0.005);
    trace_picture direct = render_path(scene, &full, 16);
    double lost = 0.0;
    for (int i = 0; i < PIXELS; i++) lost += (double)direct.plane[0][0][i] / PIXELS;
    assert_true(lost < 0.99 * expected);
    trace_picture_free(&p);
    trace_picture_free(&direct);
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rooms_with_lamps_and_point_lights_are_those_of_the_path_tracer),
        cmocka_unit_test(mirrors_caustics_and_two_sided_lamps_are_those_of_the_path_tracer),
        cmocka_unit_test(skies_are_those_of_the_path_tracer),
        cmocka_unit_test(spots_and_distant_lights_are_those_of_the_path_tracer),
        cmocka_unit_test(any_declared_transport_is_that_of_the_path_tracer),
        cmocka_unit_test(a_point_light_throws_caustics),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
