#include "matched.h"

#include <setjmp.h>
#include <stdarg.h>

#include <cmocka.h>

#include <math.h>
#include <stdio.h>

#include "rendering.h"

void assert_sound_picture(const sl_image *image, const char *what) {
    size_t values = (size_t)image->width * (size_t)image->height * (size_t)image->channels;
    for (size_t i = 0; i < values; i++) {
        if (!(image->planes[i] >= 0.0f && isfinite(image->planes[i])))
            fail_msg("%s: value %zu is %g", what, i, (double)image->planes[i]);
    }
}

static void take_away(sl_image *image, const char *prefix, const sl_image *direct) {
    static const char *const names[] = {"R", "G", "B"};
    size_t pixels = (size_t)image->width * (size_t)image->height;
    for (int c = 0; c < 3; c++) {
        char from[32], less[32];
        snprintf(from, sizeof from, "%s%s", prefix, names[c]);
        snprintf(less, sizeof less, "direct.%s", names[c]);
        float *plane = sl_image_channel(image, from);
        const float *light = sl_image_channel(direct, less);
        assert_non_null(plane);
        assert_non_null(light);
        for (size_t i = 0; i < pixels; i++) plane[i] -= light[i];
    }
}

matched matched_with_path_tracer(const sl_scene *scene, const sl_settings *settings, uint32_t spp,
                                 bool without_direct) {
    sl_settings reference = *settings;
    sl_counters counters;
    sl_comparison c;
    reference.method = "path";
    reference.transport = "matched:splatting";
    reference.spp = spp;
    sl_image *ours = render(scene, settings, &counters), *theirs = render(scene, &reference, NULL);
    assert_sound_picture(ours, "splatting");
    if (without_direct) {
        take_away(theirs, "", ours);
        take_away(theirs, "even.", ours);
        take_away(theirs, "odd.", ours);
        take_away(ours, "", ours);
    }
    assert_int_equal(sl_image_compare(ours, theirs, NULL, &c, NULL, NULL), SL_OK);
    assert_int_equal(c.nonfinite, 0);
    matched m = {sqrt(fmax(0.0, c.rel_mse - c.rel_mse_noise)), c.bias, sqrt(c.rel_mse_noise),
                 (double)counters.value[SL_COUNT_RECORDS]};
    sl_image_destroy(ours);
    sl_image_destroy(theirs);
    return m;
}
