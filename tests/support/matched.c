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

matched matched_with_path_tracer(const sl_scene *scene, const sl_settings *settings, uint32_t spp) {
    sl_settings reference = *settings;
    sl_counters counters;
    sl_comparison c;
    reference.method = "path";
    reference.transport = "matched:splatting";
    reference.spp = spp;
    sl_image *ours = render(scene, settings, &counters), *theirs = render(scene, &reference, NULL);
    assert_sound_picture(ours, "splatting");
    assert_int_equal(sl_image_compare(ours, theirs, NULL, &c, NULL, NULL), SL_OK);
    assert_int_equal(c.nonfinite, 0);
    matched m = {sqrt(fmax(0.0, c.rel_mse - c.rel_mse_noise)), c.bias, sqrt(c.rel_mse_noise),
                 (double)counters.value[SL_COUNT_RECORDS]};
    sl_image_destroy(ours);
    sl_image_destroy(theirs);
    return m;
}
