/* Golden images, pass by pass: every pass that a method announces on a small Cornell box must have the bits
 * of the picture in tests/golden/. A missing golden fails. `make golden` writes them anew; look at them
 * before committing. A failure leaves what came out in build/golden-failed/. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "unit_test.h"
#include "rendering.h"

typedef struct {
    const char *scene;
    int passes, wrong;
} golden_run;

static void file_name(char *name, size_t size, const char *folder, const golden_run *run,
                      const sl_pass *pass) {
    int used = snprintf(name, size, "%s/%s-%02d-", folder, run->scene, run->passes);
    for (const char *c = pass->name; *c && (size_t)used + 6 < size; c++)
        name[used++] = (*c >= 'a' && *c <= 'z') || (*c >= 'A' && *c <= 'Z') ? *c : '-';
    snprintf(name + used, size - (size_t)used, ".exr");
}

static bool same_bits(const sl_image *a, const sl_image *b) {
    size_t pixels = (size_t)a->width * (size_t)a->height;
    if (a->width != b->width || a->height != b->height) return false;
    for (int c = 0; c < a->channels; c++) {
        /* a lone Y is read back as R = G = B */
        const float *other = sl_image_channel(b, a->channels == 1 ? "R" : a->channel_name[c]);
        if (!other || memcmp(a->planes + (size_t)c * pixels, other, pixels * sizeof(float)) != 0)
            return false;
    }
    return true;
}

static void report_worst(const sl_image *a, const sl_image *b, const char *golden) {
    size_t values = (size_t)a->width * (size_t)a->height * (size_t)a->channels, worst = 0, differing = 0;
    for (size_t i = 0; i < values; i++) {
        float d = a->planes[i] - b->planes[i], w = a->planes[worst] - b->planes[worst];
        if (d * d > w * w) worst = i;
        differing += d != 0.0f;
    }
    size_t pixel = worst % ((size_t)a->width * (size_t)a->height);
    print_error("%s: %zu values differ, most at x %zu y %zu: %.9g instead of %.9g\n", golden, differing,
                pixel % (size_t)a->width, pixel / (size_t)a->width, (double)a->planes[worst],
                (double)b->planes[worst]);
}

static void check_pass(void *context, const sl_pass *pass) {
    golden_run *run = context;
    char golden[256], actual[256];
    if (!pass->buffer) return;
    file_name(golden, sizeof golden, "tests/golden", run, pass);
    file_name(actual, sizeof actual, "build/golden-failed", run, pass);
    run->passes++;
    sl_error error;
    if (getenv("SOFTLUX_UPDATE_GOLDEN")) {
        if (sl_image_write(pass->buffer, golden, &error) != SL_OK)
            run->wrong++, print_error("%s\n", error.message);
        return;
    }
    sl_image *wanted;
    bool same = false;
    if (sl_image_read(golden, &wanted, &error) != SL_OK) {
        print_error("%s\n", error.message);
    } else {
        same = same_bits(pass->buffer, wanted);
        if (!same && pass->buffer->channels == wanted->channels && pass->buffer->width == wanted->width)
            report_worst(pass->buffer, wanted, golden);
        sl_image_destroy(wanted);
    }
    if (same) return;
    run->wrong++;
    mkdir("build", 0777);
    mkdir("build/golden-failed", 0777);
    sl_image_write(pass->buffer, actual, NULL);
}

static void expect_golden(const char *name, const char *path, sl_settings settings, int passes) {
    golden_run run = {name, 0, 0};
    sl_observer observer = {&run, check_pass};
    settings.width = 64;
    settings.height = 48;
    settings.quality = SL_QUALITY_DRAFT;
    settings.observer = &observer;
    sl_scene *scene = load_scene(path);
    destroy_picture(render(scene, &settings, NULL), scene);
    assert_true(run.passes >= passes);
    assert_int_equal(run.wrong, 0);
}

static sl_settings gathered(sl_gather_kind gather) {
    sl_settings settings = sl_settings_of_papers();
    settings.gather = gather;
    return settings;
}

static void every_pass_of_the_cornell_box_gathered_by_rays_is_golden(void **state) {
    expect_golden("cornell-rays", "scenes/cornell.json", gathered(SL_GATHER_RAYS), 9);
}

static void every_pass_of_the_cornell_box_gathered_by_the_plane_is_golden(void **state) {
    expect_golden("cornell-plane", "scenes/cornell.json", gathered(SL_GATHER_PLANE), 9);
}

static void every_pass_of_the_glossy_box_gathered_by_the_hemicube_is_golden(void **state) {
    expect_golden("glossy-hemicube", "scenes/cornell-glossy.json", gathered(SL_GATHER_HEMICUBE), 9);
}

static void every_pass_of_direct_radiance_mapping_is_golden(void **state) {
    sl_settings settings = sl_settings_of_papers();
    settings.method = "direct-radiance";
    expect_golden("balls", "scenes/mirror-balls.json", settings, 6);
}

static void every_pass_of_the_light_octree_is_golden(void **state) {
    sl_settings settings = sl_settings_of_papers();
    settings.method = "light-octree";
    settings.light_octree.photons = 20000;
    settings.light_octree.neighbours = 60;
    expect_golden("octree", "scenes/cornell-mirror.json", settings, 4);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_pass_of_the_cornell_box_gathered_by_rays_is_golden),
        cmocka_unit_test(every_pass_of_the_cornell_box_gathered_by_the_plane_is_golden),
        cmocka_unit_test(every_pass_of_the_glossy_box_gathered_by_the_hemicube_is_golden),
        cmocka_unit_test(every_pass_of_direct_radiance_mapping_is_golden),
        cmocka_unit_test(every_pass_of_the_light_octree_is_golden),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
