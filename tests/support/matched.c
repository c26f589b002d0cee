#include "unit_test.h"
#include "matched.h"

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

sl_comparison against_path_tracer(const sl_scene *scene, const sl_settings *settings, uint32_t spp,
                                  sl_counters *counters) {
    char transport[64];
    sl_settings reference = *settings;
    sl_comparison c;
    snprintf(transport, sizeof transport, "matched:%s", settings->method);
    reference.method = "path";
    reference.transport = transport;
    reference.spp = spp;
    sl_image *ours = render(scene, settings, counters), *theirs = render(scene, &reference, NULL);
    assert_sound_picture(ours, settings->method);
    assert_int_equal(sl_image_compare(ours, theirs, NULL, &c, NULL, NULL), SL_OK);
    assert_int_equal(c.nonfinite, 0);
    print_message("bias %.3f %%, relRMSE %.2f %%, relMSE less noise %.2e\n", 100.0 * c.bias,
                  100.0 * c.rel_rmse, c.rel_mse - c.rel_mse_noise);
    sl_image_destroy(ours);
    sl_image_destroy(theirs);
    return c;
}

matched matched_with_path_tracer(const sl_scene *scene, const sl_settings *settings, uint32_t spp) {
    sl_counters counters;
    const sl_comparison c = against_path_tracer(scene, settings, spp, &counters);
    return (matched){sqrt(fmax(0.0, c.rel_mse - c.rel_mse_noise)), c.bias, sqrt(c.rel_mse_noise),
                     (double)counters.value[SL_COUNT_RECORDS]};
}
