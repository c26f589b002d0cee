/* Our path tracer against other renderers' pictures and figures of the Cornell box. The box is built here
 * from its published measurements; patch means are those of Radiance (exhaustive), Cycles and pbrt, which
 * agree within their noise. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <cmocka.h>

#include "base/counters.h"
#include "trace/trace.h"
#include "trace_scenes.h"

/* Sanitizers slow this down tenfold; a few samples keep the means and the patches checked. */
#if defined __SANITIZE_ADDRESS__ || defined __SANITIZE_THREAD__ || defined SL_THREADS_WITHOUT_OPENMP
enum { SAMPLES = 4 };
#else
enum { SAMPLES = 64 };
#endif
enum { SIZE = 512, PIXELS = SIZE * SIZE };

static const char mask_file[] = "../shared/refs/cornell512_mask.pfm";

/* Corners as published, each face a quadrilateral a b c d whose front is given by the order. */
static void add_face(trace_mesh *mesh, const float corners[12], uint32_t material) {
    uint32_t v[4];
    for (int k = 0; k < 4; k++)
        v[k] = trace_mesh_vertex(mesh, corners[3 * k], corners[3 * k + 1], corners[3 * k + 2]);
    trace_mesh_triangle(mesh, v[0], v[1], v[2], material);
    trace_mesh_triangle(mesh, v[0], v[2], v[3], material);
}

static sl_scene *cornell_box(void) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t white = trace_mesh_material(&mesh, 0.73f, 0, 0, 0, 0),
             red = trace_mesh_material(&mesh, 0, 0, 0, 0, 0);
    uint32_t green = trace_mesh_material(&mesh, 0, 0, 0, 0, 0),
             light = trace_mesh_material(&mesh, 0, 0, 0, 0, 0);
    mesh.materials[red].diffuse = (sl_rgb){0.63f, 0.065f, 0.05f};
    mesh.materials[green].diffuse = (sl_rgb){0.14f, 0.45f, 0.091f};
    mesh.materials[light].emission = (sl_rgb){17.0f, 12.0f, 4.0f};
    static const float floor[12] = {552.8f, 0, 0, 0, 0, 0, 0, 0, 559.2f, 549.6f, 0, 559.2f};
    static const float ceiling[12] = {556, 548.8f, 0, 556, 548.8f, 559.2f, 0, 548.8f, 559.2f, 0, 548.8f, 0};
    static const float back[12] = {549.6f, 0, 559.2f, 0, 0, 559.2f, 0, 548.8f, 559.2f, 556, 548.8f, 559.2f};
    static const float right[12] = {0, 0, 559.2f, 0, 0, 0, 0, 548.8f, 0, 0, 548.8f, 559.2f};
    static const float left[12] = {552.8f, 0, 0, 549.6f, 0, 559.2f, 556, 548.8f, 559.2f, 556, 548.8f, 0};
    static const float lamp[12] = {343, 548.3f, 227, 343, 548.3f, 332, 213, 548.3f, 332, 213, 548.3f, 227};
    static const float boxes[10][12] = {
        {130, 165, 65, 82, 165, 225, 240, 165, 272, 290, 165, 114},
        {290, 0, 114, 290, 165, 114, 240, 165, 272, 240, 0, 272},
        {130, 0, 65, 130, 165, 65, 290, 165, 114, 290, 0, 114},
        {82, 0, 225, 82, 165, 225, 130, 165, 65, 130, 0, 65},
        {240, 0, 272, 240, 165, 272, 82, 165, 225, 82, 0, 225},
        {423, 330, 247, 265, 330, 296, 314, 330, 456, 472, 330, 406},
        {423, 0, 247, 423, 330, 247, 472, 330, 406, 472, 0, 406},
        {472, 0, 406, 472, 330, 406, 314, 330, 456, 314, 0, 456},
        {314, 0, 456, 314, 330, 456, 265, 330, 296, 265, 0, 296},
        {265, 0, 296, 265, 330, 296, 423, 330, 247, 423, 0, 247}};
    add_face(&mesh, floor, white);
    add_face(&mesh, ceiling, white);
    add_face(&mesh, back, white);
    add_face(&mesh, right, green);
    add_face(&mesh, left, red);
    for (int i = 0; i < 10; i++) add_face(&mesh, boxes[i], white);
    add_face(&mesh, lamp, light);
    mesh.has_camera = true;
    assert_true(sl_camera_look_at(&mesh.camera, sl_v3(278, 273, -800), sl_v3(278, 273, 0), sl_v3(0, 1, 0),
                                  0.68591440f));
    return trace_mesh_build(&mesh);
}

typedef struct picture {
    float *plane[3], *half[2][3];
    sl_counters counters;
} picture;

static picture render_picture(const sl_scene *scene, const char *transport) {
    picture p = {.counters = {{0}}};
    for (int c = 0; c < 3; c++) {
        p.plane[c] = calloc(PIXELS, sizeof(float));
        for (int h = 0; h < 2; h++) p.half[h][c] = calloc(PIXELS, sizeof(float));
    }
    sl_tracer *tracer;
    sl_path_tracer *path;
    sl_path_settings settings = {.width = SIZE, .height = SIZE, .threads = 2, .seed = 1};
    assert_true(sl_transport_named(transport, &settings.transport));
    assert_int_equal(sl_tracer_create(scene, 2, NULL, &tracer, NULL), SL_OK);
    assert_int_equal(sl_path_tracer_create(scene, tracer, &settings, &path, NULL), SL_OK);
    for (uint64_t i = 0; i < SAMPLES; i++)
        assert_int_equal(sl_path_tracer_sample(path, i, &p.counters, NULL), SL_OK);
    sl_path_tracer_mean(path, -1, p.plane[0], p.plane[1], p.plane[2]);
    for (int h = 0; h < 2; h++) sl_path_tracer_mean(path, h, p.half[h][0], p.half[h][1], p.half[h][2]);
    sl_path_tracer_destroy(path);
    sl_tracer_destroy(tracer);
    return p;
}

static void free_picture(picture *p) {
    for (int c = 0; c < 3; c++) {
        free(p->plane[c]);
        for (int h = 0; h < 2; h++) free(p->half[h][c]);
    }
}

static void patch_mean(float *const plane[3], int x, int y, int half, double mean[3]) {
    for (int c = 0; c < 3; c++) {
        double sum = 0.0;
        for (int j = y - half; j <= y + half; j++) {
            for (int i = x - half; i <= x + half; i++) sum += (double)plane[c][j * SIZE + i];
        }
        mean[c] = sum / ((2 * half + 1) * (2 * half + 1));
    }
}

static const struct patch {
    const char *name;
    int x, y, half;
    double one_bounce[3], full[3];
} patches[] = {
    {"floor", 176, 468, 4, {.16011, .10417, .03455}, {.19257, .11804, .03824}},
    {"red", 72, 255, 4, {.16307, .01196, .00304}, {.21132, .01344, .00333}},
    {"green", 440, 255, 4, {.04173, .09101, .00613}, {.05042, .11021, .00699}},
    {"back", 323, 189, 4, {.19346, .14068, .04388}, {.23261, .17246, .05008}},
    {"ceiling", 256, 36, 4, {.05684, .03706, .01064}, {.07861, .04963, .01289}},
    {"short box, top", 324, 336, 2, {.28905, .20726, .06653}, {.32173, .23092, .07146}},
    {"tall box, front", 211, 328, 4, {.03910, .02769, .00823}, {.06314, .03971, .01122}},
    {"short box, front", 310, 409, 4, {.00879, .00486, .00160}, {.01363, .00645, .00195}},
};

/* A patch agrees within four of our standard errors, estimated from the two halves over all patches of its
 * size, and a part in a hundred and fifty for their own noise. */
static void check_patches(const picture *p, bool full) {
    for (size_t i = 0; i < sizeof patches / sizeof *patches; i++) {
        const struct patch *q = &patches[i];
        double mean[3], low[3], high[3];
        patch_mean(p->plane, q->x, q->y, q->half, mean);
        /* The noise of the patch mean, from the pixels' differences between the halves. */
        for (int c = 0; c < 3; c++) {
            double squares = 0.0;
            int count = (2 * q->half + 1) * (2 * q->half + 1);
            for (int j = q->y - q->half; j <= q->y + q->half; j++) {
                for (int k = q->x - q->half; k <= q->x + q->half; k++) {
                    double d = 0.5 * (double)(p->half[0][c][j * SIZE + k] - p->half[1][c][j * SIZE + k]);
                    squares += d * d;
                }
            }
            double error = sqrt(squares) / count, expected = full ? q->full[c] : q->one_bounce[c];
            low[c] = expected - 4.0 * error - expected / 150.0 - 1e-5;
            high[c] = expected + 4.0 * error + expected / 150.0 + 1e-5;
            if (!(mean[c] > low[c] && mean[c] < high[c])) {
                fail_msg("%s, channel %d: %.5f, expected %.5f +- %.5f", q->name, c, mean[c], expected,
                         high[c] - expected);
            }
        }
    }
}

/* A three-channel or one-channel PFM, top row first; NULL if there is no such file. */
static float *read_pfm(const char *name, int channels) {
    FILE *file = fopen(name, "rb");
    if (!file) return NULL;
    int width, height;
    double scale;
    char kind;
    assert_int_equal(fscanf(file, "P%c %d %d %lf", &kind, &width, &height, &scale), 4);
    assert_true(width == SIZE && height == SIZE && scale < 0.0);
    int stored = kind == 'F' ? 3 : 1;
    fgetc(file);
    float *values = calloc((size_t)(PIXELS * channels), sizeof(float)), row[3 * SIZE];
    for (int y = SIZE - 1; y >= 0; y--) {
        assert_int_equal(fread(row, sizeof(float) * (size_t)stored, SIZE, file), SIZE);
        for (int x = 0; x < SIZE; x++) {
            for (int c = 0; c < channels; c++)
                values[c * PIXELS + y * SIZE + x] = row[stored * x + (c < stored ? c : 0)];
        }
    }
    fclose(file);
    return values;
}

static void check_masked_means(const picture *p, const double expected[3]) {
    float *mask = read_pfm(mask_file, 1);
    if (!mask) {
        print_message("skipped: masked means, the reference pictures are not there\n");
        return;
    }
    for (int c = 0; c < 3; c++) {
        double sum = 0.0, weight = 0.0;
        for (int i = 0; i < PIXELS; i++) {
            sum += (double)mask[i] * (double)p->plane[c][i];
            weight += (double)mask[i];
        }
        print_message("masked mean, channel %d: %.6f, expected %.5f (%+.3f %%)\n", c, sum / weight,
                      expected[c], 100.0 * (sum / weight / expected[c] - 1.0));
        assert_true(fabs(sum / weight / expected[c] - 1.0) < 0.003);
    }
    free(mask);
}

/* mean((ours - R1)(ours - R2)) cancels the references' own noise; what is left is ours, which the halves tell
 * too. */
static void check_picture(const picture *p, const char *first, const char *second) {
    float *mask = read_pfm(mask_file, 1), *r1 = read_pfm(first, 3), *r2 = read_pfm(second, 3);
    if (mask && r1 && r2) {
        double error = 0.0, noise = 0.0, weight = 0.0;
        for (int c = 0; c < 3; c++) {
            for (int i = 0; i < PIXELS; i++) {
                if (mask[i] < 0.5f) continue;
                double b = 0.5 * (double)(r1[c * PIXELS + i] + r2[c * PIXELS + i]),
                       a = (double)p->plane[c][i];
                double d = 0.5 * (double)(p->half[0][c][i] - p->half[1][c][i]);
                error += (a - (double)r1[c * PIXELS + i]) * (a - (double)r2[c * PIXELS + i]) / (b * b + 0.01);
                noise += d * d / (b * b + 0.01);
                weight += 1.0;
            }
        }
        print_message("relMSE %.3e, of which our noise %.3e\n", error / weight, noise / weight);
        assert_true(fabs(error - noise) / weight < (SAMPLES < 64 ? 1e-3 : 3e-5));
    } else {
        print_message("skipped: the reference pictures are not there\n");
    }
    free(mask);
    free(r1);
    free(r2);
}

static void cornell_box_with_one_bounce_agrees_with_three_renderers(void **unused) {
    (void)unused;
    sl_scene *scene = cornell_box();
    picture p = render_picture(scene, "one-bounce");
    static const double expected[3] = {.0786, .0497, .01295};
    check_patches(&p, false);
    check_masked_means(&p, expected);
    check_picture(&p, "../shared/refs/cornell512_1b_pbrt2048.pfm",
                  "../shared/refs/cornell512_1b_cycles256.pfm");
    assert_int_equal(p.counters.value[SL_COUNT_SAMPLES], (uint64_t)PIXELS * SAMPLES);
    assert_int_equal(p.counters.value[SL_COUNT_NONFINITE], 0);
    free_picture(&p);
    sl_scene_destroy(scene);
}

static void cornell_box_with_all_bounces_agrees_with_three_renderers(void **unused) {
    (void)unused;
    sl_scene *scene = cornell_box();
    picture p = render_picture(scene, "full");
    static const double expected[3] = {.10605, .06456, .01559};
    check_patches(&p, true);
    check_masked_means(&p, expected);
    check_picture(&p, "../shared/refs/cornell512_full_pbrt256.pfm",
                  "../shared/refs/cornell512_full_cycles256.pfm");
    free_picture(&p);
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cornell_box_with_one_bounce_agrees_with_three_renderers),
        cmocka_unit_test(cornell_box_with_all_bounces_agrees_with_three_renderers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
