/* Scenes that break careless code, by every gather: tiny and huge ones, eyes in the surface, lights in walls.
 * Values must be finite, none below zero, and where the truth is known, that. Methods at their defaults are
 * held to more of the kind by check-numerics (app/numerics/cases.c). */
#include <math.h>
#include <stdio.h>

#include "unit_test.h"
#include "rendering.h"

/* ---- rendering with everything --------------------------------------------------------------- */

typedef struct variant {
    const char *name, *method;
    sl_gather_kind gather;
    sl_direct_kind direct;
} variant;

static const variant variants[] = {{"plane", "splatting", SL_GATHER_PLANE, SL_DIRECT_RAYS},
                                   {"hemicube", "splatting", SL_GATHER_HEMICUBE, SL_DIRECT_RAYS},
                                   {"rays", "splatting", SL_GATHER_RAYS, SL_DIRECT_RAYS},
                                   {"shadow maps", "splatting", SL_GATHER_PLANE, SL_DIRECT_SHADOW_MAPS},
                                   {"multi-mesh", "multi-mesh", SL_GATHER_AUTO, SL_DIRECT_RAYS},
                                   {"path", "path", SL_GATHER_AUTO, SL_DIRECT_AUTO},
                                   {"bidirectional", "bidirectional", SL_GATHER_AUTO, SL_DIRECT_AUTO}};
enum { VARIANTS = sizeof variants / sizeof *variants, PATH = VARIANTS - 2 };

static sl_image *render_variant(const sl_scene *scene, const variant *v, int width, int height) {
    sl_settings settings = small_settings(v->method, width, height);
    settings.gather = v->gather;
    settings.direct = v->direct;
    if (v >= &variants[PATH]) {
        settings.transport = "matched:splatting";
        settings.spp = 16;
    }
    sl_image *image = render(scene, &settings, NULL);
    size_t values = (size_t)width * (size_t)height * (size_t)image->channels;
    for (size_t i = 0; i < values; i++) {
        if (!isfinite(image->planes[i]))
            fail_msg("%s: value %zu is %g", v->name, i, (double)image->planes[i]);
    }
    for (size_t i = 0; i < 3 * (size_t)width * (size_t)height; i++) {
        if (image->planes[i] < 0.0f) fail_msg("%s: value %zu is %g", v->name, i, (double)image->planes[i]);
    }
    return image;
}

/* Renders by every variant; means[] receives their mean radiances. */
static void means_of_all(const sl_scene *scene, int width, int height, double means[VARIANTS]) {
    for (int i = 0; i < VARIANTS; i++) {
        sl_image *image = render_variant(scene, &variants[i], width, height);
        means[i] = 0.0;
        for (int c = 0; c < 3; c++) means[i] += channel_mean(image, (const char[2]){"RGB"[c], 0}) / 3.0;
        sl_image_destroy(image);
    }
}

static void render_all(const char *json, const char *obj, int width, int height, double means[VARIANTS]) {
    sl_scene *scene = scene_from_text(json, obj);
    means_of_all(scene, width, height, means);
    sl_scene_destroy(scene);
}

static void assert_near(const char *what, double value, double truth, double tolerance) {
    if (!(fabs(value - truth) <= tolerance * fabs(truth)))
        fail_msg("%s: %g, expected %g", what, value, truth);
}

/* ---- a room of any size ---------------------------------------------------------------------- */

static void room_means(double scale, double means[VARIANTS]) {
    static const char grey[] = "\"diffuse\": 0.6";
    sl_scene *scene = room_with_a_box(scale, 0.0, grey, grey, "\"emission\": 5, ", "");
    means_of_all(scene, 24, 24, means);
    sl_scene_destroy(scene);
}

static void a_room_looks_the_same_at_every_size(void **state) {
    double truth[VARIANTS], means[VARIANTS];
    room_means(1.0, truth);
    for (int i = 0; i < VARIANTS; i++) assert_true(truth[i] > 0.1);
    const double scales[] = {0x1p-20, 1e-6, 1e6, 0x1p20};
    for (int s = 0; s < 4; s++) {
        room_means(scales[s], means);
        for (int i = 0; i < VARIANTS; i++) assert_near(variants[i].name, means[i], truth[i], 0.01);
    }
}

/* ---- eyes where no eye should be ------------------------------------------------------------- */

static const char corner_obj[] =
    "v 0 0 0\nv 4 0 0\nv 4 0 -4\nv 0 0 -4\nv 0 4 -4\nv 4 4 -4\nf 1 2 3\nf 1 3 4\nf 4 3 6 5\n";

static void the_eye_may_be_anywhere(void **state) {
    static const char *const eyes[] = {
        "\"eye\": [1, 0, -2], \"target\": [2, 0, -4]",        /* in the floor, along it */
        "\"eye\": [1, 0, -2], \"target\": [1, 1, -4]",        /* in the floor */
        "\"eye\": [0, 0, -4], \"target\": [4, 2, -4]",        /* at a vertex, along a wall */
        "\"eye\": [2, 0, -4], \"target\": [2, 1, 0]",         /* on an edge */
        "\"eye\": [2, 1e-30, -2], \"target\": [2, 0, -4]",    /* above the floor by less than can be told */
        /* straight down, up nearly along the view */
        "\"eye\": [2, 3, -2], \"target\": [2, 0, -2], \"up\": [0, 1, -0.001]",
        "\"eye\": [2, 1, -1], \"target\": [2, 1, -1.000001]" /* at a target of no distance */
    };
    for (size_t i = 0; i < sizeof eyes / sizeof *eyes; i++) {
        char json[512];
        double means[VARIANTS];
        snprintf(
            json, sizeof json,
            "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\"}], \"camera\": {%s, \"fov_deg\": 60},\n"
            "\"lights\": [{\"type\": \"point\", \"position\": [2, 3, -2], \"intensity\": 10}]}",
            eyes[i]);
        render_all(json, corner_obj, 16, 16, means);
    }
}

/* Under a sky of radiance 1 a convex body of diffuse reflectance 0.5 sends 0.5 everywhere. */
static void one_triangle_under_an_even_sky_sends_its_reflectance(void **state) {
    double means[VARIANTS];
    render_all("{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\", \"material\": \"half\"}],\n"
               "\"materials\": {\"half\": {\"diffuse\": 0.5}}, \"environment\": {\"radiance\": 1},\n"
               "\"camera\": {\"eye\": [0, 0, 1], \"target\": [0, 0, 0], \"fov_deg\": 20}}",
               "v -2 -2 0\nv 2 -2 0\nv 0 4 0\nf 1 2 3\n", 16, 16, means);
    /* Maps play the sky by 32 directional lights. The tracers' means of 16 samples have a standard error of
     * 0.002. */
    for (int i = 0; i < VARIANTS; i++) {
        double tolerance = variants[i].direct == SL_DIRECT_SHADOW_MAPS ? 0.05 : i >= PATH ? 0.008 : 0.002;
        assert_near(variants[i].name, means[i], 0.5, tolerance);
    }
}

/* ---- lights where no light should be --------------------------------------------------------- */

static void lights_in_walls_give_finite_pictures(void **state) {
    static const char *const lights[] = {
        "{\"type\": \"point\", \"position\": [2, 2, -4], \"intensity\": 10}", /* in the wall */
        "{\"type\": \"point\", \"position\": [0, 0, -4], \"intensity\": 10}", /* at a vertex */
        "{\"type\": \"point\", \"position\": [2, 1, -1], \"intensity\": 10}", /* at the eye */
        "{\"type\": \"spot\", \"position\": [2, 0, -2], \"direction\": [0, 1, 0], \"intensity\": 10, "
        "\"inner_deg\": 30, \"outer_deg\": 30}",
        "{\"type\": \"directional\", \"direction\": [1, 0, 0], \"irradiance\": 1}", /* along floor and wall */
        /* in the floor */
        "{\"type\": \"quad\", \"corner\": [1, 0, -3], \"edge1\": [1, 0, 0], \"edge2\": [0, 0, 1], "
        "\"radiance\": 5}",
        "{\"type\": \"quad\", \"corner\": [1, -1, -3], \"edge1\": [1, 0, 0], \"edge2\": [0, 2, 0], "
        "\"radiance\": 5}" /* through it */
    };
    for (size_t i = 0; i < sizeof lights / sizeof *lights; i++) {
        char json[768];
        double means[VARIANTS];
        snprintf(json, sizeof json,
                 "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\"}], \"lights\": [%s],\n"
                 "\"camera\": {\"eye\": [2, 1, -1], \"target\": [2, 1, -4], \"fov_deg\": 60}}", lights[i]);
        render_all(json, corner_obj, 16, 16, means);
    }
}

/* A lamp 20 long behind a wall with a window of 1: the window's reveal is lit by the little of the lamp that
 * it sees, which is near. */
static void a_long_lamp_behind_a_small_window_lights_the_reveal(void **state) {
    double means[VARIANTS];
    render_all(
        "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\"}],\n"
        "\"materials\": {\"grey\": {\"diffuse\": 0.7}, \"lamp\": {\"diffuse\": 0, \"emission\": 5}},\n"
        "\"camera\": {\"eye\": [1.8, 0.5, 2.8], \"target\": [1.5, 0.5, 0], \"fov_deg\": 40}}",
        "v -10 0 -0.5\nv 10 0 -0.5\nv 10 1 -0.5\nv -10 1 -0.5\n"
        "v -2 0 0\nv -0.5 0 0\nv -0.5 1 0\nv -2 1 0\nv 0.5 0 0\nv 2 0 0\nv 2 1 0\nv 0.5 1 0\n"
        "v -2 0 3\nv 2 0 3\nv 2 1 3\nv -2 1 3\nv -0.5 0 -0.49\nv 0.5 0 -0.49\nv 0.5 1 -0.49\nv -0.5 1 -0.49\n"
        "usemtl lamp\nf 1 2 3 4\nusemtl grey\nf 5 6 7 8\nf 9 10 11 12\nf 5 10 14 13\nf 8 11 15 16\nf 13 14 "
        "15 16\n"
        "f 5 8 16 13\nf 10 11 15 14\nf 17 18 9 6\nf 20 19 12 7\nf 17 6 7 20\nf 18 9 12 19\n",
        32, 24, means);
    for (int i = 0; i < VARIANTS; i++) {
        if (variants[i].direct == SL_DIRECT_RAYS) assert_near(variants[i].name, means[i], means[PATH], 0.05);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_room_looks_the_same_at_every_size),
        cmocka_unit_test(the_eye_may_be_anywhere),
        cmocka_unit_test(one_triangle_under_an_even_sky_sends_its_reflectance),
        cmocka_unit_test(lights_in_walls_give_finite_pictures),
        cmocka_unit_test(a_long_lamp_behind_a_small_window_lights_the_reveal),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
