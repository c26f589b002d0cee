#include "app/blank_picture.h"

#include "scene/features.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Of all pixels, how many black ones make a picture blank; and of those that are not black, how many white
 * ones. */
static const double nearly_all = 0.98, most = 0.9;

static bool is_black(const sl_image *image) {
    static const char *const names[3] = {"R", "G", "B"};
    const size_t pixels = (size_t)image->width * (size_t)image->height;
    for (int c = 0; c < 3; c++) {
        const float *plane = sl_image_channel(image, names[c]);
        for (size_t i = 0; plane && i < pixels; i++) {
            if (plane[i] != 0.0f) return false;
        }
    }
    return true;
}

static const char *reason(const sl_render_options *o, const sl_scene *scene) {
    const sl_features f = sl_scene_features(scene);
    if (!f.light) return "the scene has no light";
    if (!sl_scene_is_in_view(scene))
        return "the camera sees nothing of the scene: --eye and --target place it";
    bool sky_alone = f.environment && !f.emitters && !scene->light_count;
    if (sky_alone && strcmp(o->settings.method, "direct-radiance") == 0)
        return "the environment is the only light, and direct-radiance takes none from it";
    return "no light reaches what the camera sees: lamps may be behind walls, or shine the other way "
           "(softlux info tells where it stands, --eye and --target place it)";
}

/* The shares of pixels that are 0 as a PNG shows them, and of 255 among the others. */
static bool measure(const sl_render_options *o, const sl_image *image, double *black, double *white) {
    const size_t pixels = (size_t)image->width * (size_t)image->height;
    uint8_t *bytes = malloc(3 * pixels);
    sl_tone tone = sl_picture_tone(o);
    bool good = bytes && sl_image_srgb(image, &tone, bytes, NULL) == SL_OK;
    size_t count[2] = {0, 0};
    for (size_t i = 0; good && i < pixels; i++) {
        const uint8_t *p = bytes + 3 * i;
        count[0] += (p[0] | p[1] | p[2]) == 0;
        count[1] += (p[0] & p[1] & p[2]) == 255;
    }
    *black = (double)count[0] / (double)pixels;
    *white = count[1] ? (double)count[1] / (double)(pixels - count[0]) : 0.0;
    free(bytes);
    return good;
}

void sl_tell_blank_picture(const sl_render_options *o, const sl_scene *scene, const sl_image *image) {
    double black, white;
    if (is_black(image)) {
        fprintf(stderr, "softlux: warning: the picture is black: %s\n", reason(o, scene));
        return;
    }
    if (!sl_picture_is_png(o->output) || !measure(o, image, &black, &white)) return;
    if (white >= most)
        fprintf(stderr, "softlux: warning: %.3g %% of the pixels are white: a lower --exposure shows more\n",
                100.0 * white * (1.0 - black));
    if (black >= nearly_all && o->exposure_given)
        fprintf(stderr, "softlux: warning: %.3g %% of the pixels are black: a higher --exposure shows more\n",
                100.0 * black);
}
