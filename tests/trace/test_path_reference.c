/* Our path tracer against other renderers' pictures and figures of the Cornell box; patch means are those of
 * Radiance (exhaustive), Cycles and pbrt, which agree within their noise. */
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "unit_test.h"
#include "rendering.h"
#include "trace_scenes.h"

/* Sanitizers slow this down tenfold; a few samples keep the means and the patches checked. */
#if defined __SANITIZE_ADDRESS__ || defined __SANITIZE_THREAD__ || defined SL_THREADS_WITHOUT_OPENMP
enum { SAMPLES = 4 };
#else
enum { SAMPLES = 64 };
#endif
enum { SIZE = 512, PIXELS = SIZE * SIZE };

static const char mask_file[] = "../shared/refs/cornell512_mask.pfm";

static trace_picture picture_of(const char *transport) {
    sl_scene *scene = load_scene("scenes/cornell.json");
    const sl_path_settings settings = {
        .width = SIZE, .height = SIZE, .threads = 2, .seed = 1, .transport = transport_of(transport)};
    trace_picture p = trace_picture_of(scene, &settings, SAMPLES, false);
    assert_int_equal(p.counters.value[SL_COUNT_SAMPLES], (uint64_t)PIXELS * SAMPLES);
    sl_scene_destroy(scene);
    return p;
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
static void check_patches(const trace_picture *p, bool full) {
    for (size_t i = 0; i < sizeof patches / sizeof *patches; i++) {
        const struct patch *q = &patches[i];
        double mean[3], low[3], high[3];
        patch_mean(p->plane[0], q->x, q->y, q->half, mean);
        /* The noise of the patch mean, from the pixels' differences between the halves. */
        for (int c = 0; c < 3; c++) {
            double squares = 0.0;
            int count = (2 * q->half + 1) * (2 * q->half + 1);
            for (int j = q->y - q->half; j <= q->y + q->half; j++) {
                for (int k = q->x - q->half; k <= q->x + q->half; k++) {
                    double d = 0.5 * (double)(p->plane[1][c][j * SIZE + k] - p->plane[2][c][j * SIZE + k]);
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

/* NULL if there is no such file. */
static sl_image *picture_there(const char *name) {
    sl_image *image = NULL;
    if (access(name, R_OK) != 0) return NULL;
    assert_int_equal(sl_image_read(name, &image, NULL), SL_OK);
    assert_true(image->width == SIZE && image->height == SIZE);
    return image;
}

static void check_masked_means(const trace_picture *p, const double expected[3]) {
    sl_image *mask = picture_there(mask_file);
    if (!mask) {
        print_message("skipped: masked means, the reference pictures are not there\n");
        return;
    }
    for (int c = 0; c < 3; c++) {
        double sum = 0.0, weight = 0.0;
        for (int i = 0; i < PIXELS; i++) {
            sum += (double)mask->planes[i] * (double)p->plane[0][c][i];
            weight += (double)mask->planes[i];
        }
        print_message("masked mean, channel %d: %.6f, expected %.5f (%+.3f %%)\n", c, sum / weight,
                      expected[c], 100.0 * (sum / weight / expected[c] - 1.0));
        assert_true(fabs(sum / weight / expected[c] - 1.0) < 0.003);
    }
    sl_image_destroy(mask);
}

/* mean((ours - R1)(ours - R2)) cancels the references' own noise; what is left is ours, which the halves tell
 * too. */
static void check_picture(const trace_picture *p, const char *first, const char *second) {
    sl_image *mask = picture_there(mask_file), *r1 = picture_there(first), *r2 = picture_there(second);
    if (mask && r1 && r2) {
        double error = 0.0, noise = 0.0, weight = 0.0;
        for (int c = 0; c < 3; c++) {
            for (int i = 0; i < PIXELS; i++) {
                if (mask->planes[i] < 0.5f) continue;
                double b = 0.5 * (double)(r1->planes[c * PIXELS + i] + r2->planes[c * PIXELS + i]),
                       a = (double)p->plane[0][c][i];
                double d = 0.5 * (double)(p->plane[1][c][i] - p->plane[2][c][i]);
                error += (a - (double)r1->planes[c * PIXELS + i]) * (a - (double)r2->planes[c * PIXELS + i]) /
                         (b * b + 0.01);
                noise += d * d / (b * b + 0.01);
                weight += 1.0;
            }
        }
        print_message("relMSE %.3e, of which our noise %.3e\n", error / weight, noise / weight);
        assert_true(fabs(error - noise) / weight < (SAMPLES < 64 ? 1e-3 : 3e-5));
    } else {
        print_message("skipped: the reference pictures are not there\n");
    }
    destroy_pictures(mask, r1);
    sl_image_destroy(r2);
}

static void cornell_box_with_one_bounce_agrees_with_three_renderers(void **unused) {
    trace_picture p = picture_of("one-bounce");
    check_patches(&p, false);
    check_masked_means(&p, (const double[3]){.0786, .0497, .01295});
    check_picture(&p, "../shared/refs/cornell512_1b_pbrt2048.pfm",
                  "../shared/refs/cornell512_1b_cycles256.pfm");
    trace_picture_free(&p);
}

static void cornell_box_with_all_bounces_agrees_with_three_renderers(void **unused) {
    trace_picture p = picture_of("full");
    check_patches(&p, true);
    check_masked_means(&p, (const double[3]){.10605, .06456, .01559});
    check_picture(&p, "../shared/refs/cornell512_full_pbrt256.pfm",
                  "../shared/refs/cornell512_full_cycles256.pfm");
    trace_picture_free(&p);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cornell_box_with_one_bounce_agrees_with_three_renderers),
        cmocka_unit_test(cornell_box_with_all_bounces_agrees_with_three_renderers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
