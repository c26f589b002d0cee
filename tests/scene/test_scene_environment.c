/* Sky and sun: the two parts of an environment. */
#include <math.h>
#include <stdlib.h>

#include "unit_test.h"
#include "scene/scene.h"

enum { WIDTH = 32, HEIGHT = 16, TEXELS = WIDTH * HEIGHT };

/* Blue above, brown below, of contrast 3, and a sun of three texels. */
static sl_environment a_day(float texels[3 * TEXELS], float sun_radiance) {
    for (int i = 0; i < TEXELS; i++) {
        int row = i / WIDTH;
        texels[3 * i] = row < 8 ? 0.5f : 0.4f;
        texels[3 * i + 1] = row < 8 ? 0.8f : 0.3f;
        texels[3 * i + 2] = row < 8 ? 1.5f - 0.05f * (float)row : 0.2f;
    }
    for (int i = 0; i < 3; i++) {
        float *t = texels + 3 * (3 * WIDTH + 10 + i);
        t[0] = sun_radiance;
        t[1] = 0.9f * sun_radiance;
        t[2] = 0.6f * sun_radiance;
    }
    return (sl_environment){.present = true, .width = WIDTH, .height = HEIGHT, .texels = texels};
}

static double relative(float a, float b) {
    return fabs((double)a - (double)b) / fmax(fabs((double)b), 1e-30);
}

static void sky_and_sun_are_the_whole_and_share_no_light(void **state) {
    const float suns[] = {5.0f, 500.0f, 5e6f};
    for (int run = 0; run < 3; run++) {
        float texels[3 * TEXELS];
        sl_environment all = a_day(texels, suns[run]), sky, sun;
        assert_int_equal(sl_environment_split(&all, 4.0, &sky, &sun, NULL), SL_OK);
        assert_true(sky.present && sun.present);
        int in_the_sun = 0;
        for (int i = 0; i < 3 * TEXELS; i++) {
            assert_true(sky.texels[i] >= 0.0f && sun.texels[i] >= 0.0f);
            assert_true(relative(sky.texels[i] + sun.texels[i], texels[i]) < 1e-6);
            in_the_sun += sun.texels[i] > 0.0f;
        }
        /* the three texels alone: the rest reaches every part of the sky untouched */
        assert_int_equal(in_the_sun, 9);
        sl_environment_release(&sky);
        sl_environment_release(&sun);
    }
}

/* Largest over mean luminance, the mean by solid angle. */
static double contrast_of(const sl_environment *e) {
    double sum = 0.0, weights = 0.0, largest = 0.0;
    for (int i = 0; i < e->width * e->height; i++) {
        sl_rgb radiance;
        float solid_angle;
        sl_environment_texel(e, i / e->width, i % e->width, &radiance, &solid_angle);
        sum += (double)solid_angle * (double)sl_luminance(radiance);
        weights += (double)solid_angle;
        largest = fmax(largest, (double)sl_luminance(radiance));
    }
    return largest * weights / sum;
}

static void the_sky_is_as_even_as_asked_however_bright_the_sun(void **state) {
    float texels[3 * TEXELS];
    for (float radiance = 10.0f; radiance < 1e7f; radiance *= 10.0f) {
        sl_environment all = a_day(texels, radiance), sky, sun;
        assert_int_equal(sl_environment_split(&all, 4.0, &sky, &sun, NULL), SL_OK);
        double contrast = contrast_of(&sky);
        assert_true(contrast < 4.1);
        assert_true(contrast > 3.9 || !sun.present);
        sl_environment_release(&sky);
        sl_environment_release(&sun);
    }
}

static void even_black_and_constant_environments_have_no_sun(void **state) {
    float texels[3 * TEXELS];
    sl_environment sky, sun, even = a_day(texels, 1.0f);
    assert_int_equal(sl_environment_split(&even, 4.0, &sky, &sun, NULL), SL_OK);
    assert_true(sky.present && !sun.present && !sun.texels);
    sl_environment_release(&sky);

    sl_environment constant = {.present = true, .constant = {1.0f, 2.0f, 3.0f}};
    assert_int_equal(sl_environment_split(&constant, 4.0, &sky, &sun, NULL), SL_OK);
    assert_true(sky.present && !sun.present && sky.constant.b == 3.0f);

    sl_environment none = {0};
    assert_int_equal(sl_environment_split(&none, 4.0, &sky, &sun, NULL), SL_OK);
    assert_false(sky.present || sun.present);

    for (int i = 0; i < 3 * TEXELS; i++) texels[i] = 0.0f;
    sl_environment black = {.present = true, .width = WIDTH, .height = HEIGHT, .texels = texels};
    assert_int_equal(sl_environment_split(&black, 4.0, &sky, &sun, NULL), SL_OK);
    assert_false(sky.present || sun.present);

    texels[300] = 7.0f; /* one texel is all the light there is: nearly all of it is sun */
    assert_int_equal(sl_environment_split(&black, 4.0, &sky, &sun, NULL), SL_OK);
    assert_true(sun.present && sun.texels[300] > 6.9f);
    sl_environment_release(&sky);
    sl_environment_release(&sun);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sky_and_sun_are_the_whole_and_share_no_light),
        cmocka_unit_test(the_sky_is_as_even_as_asked_however_bright_the_sun),
        cmocka_unit_test(even_black_and_constant_environments_have_no_sun),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
