/* The purpose of a picture's metadata: `softlux render` with the settings that they tell makes the same
 * picture again. */
#include <stdio.h>
#include <string.h>

#include "unit_test.h"
#include "app/bench/trials.h"
#include "app/manual.h"
#include "rendering.h"

enum { WORD = 64 };

static const char ours[] = "softlux.";

static bool tells_what_came_out(const char *key) {
    static const char *const results[] = {"version",   "scene_hash",    "batches",      "warning",
                                          "reduction", "flux_captured", "flux_received"};
    if (strncmp(key, "counter.", 8) == 0 || strncmp(key, "octree.", 7) == 0) return true;
    for (size_t i = 0; i < sizeof results / sizeof *results; i++) {
        if (strcmp(key, results[i]) == 0) return true;
    }
    return false;
}

/* NULL: the entry tells of no setting. */
static const sl_setting *setting_of(const sl_metadatum *m) {
    char name[WORD];
    if (strncmp(m->key, ours, sizeof ours - 1) != 0 || tells_what_came_out(m->key + sizeof ours - 1))
        return NULL;
    snprintf(name, sizeof name, "%s", m->key + sizeof ours - 1);
    for (char *c = name; *c; c++) *c = *c == '_' ? '-' : *c;
    const sl_setting *setting = sl_setting_named(name);
    if (!setting) fail_msg("%s is no option", m->key);
    return setting;
}

static bool is_told(const sl_image *image, const sl_setting *setting) {
    for (size_t i = 0; i < image->metadata_count; i++)
        if (setting_of(&image->metadata[i]) == setting) return true;
    return false;
}

static void set(sl_settings *settings, const char *name, const char *value) {
    sl_error error;
    if (sl_settings_set(settings, name, value, &error) != SL_OK) fail_msg("%s", error.message);
}

/* ---- the same again -------------------------------------------------------------------------- */

static sl_settings settings_of_line(const char *line) {
    sl_settings settings;
    if (!sl_trial_settings(line, &settings)) fail_msg("not taken: %s", line);
    return settings;
}

static sl_settings settings_of_picture(const sl_image *image) {
    sl_settings settings = sl_settings_default();
    for (size_t i = 0; i < image->metadata_count; i++) {
        const sl_setting *setting = setting_of(&image->metadata[i]);
        if (setting) set(&settings, setting->name, image->metadata[i].value);
    }
    return settings;
}

static sl_image *render_small(const sl_scene *scene, sl_settings settings) {
    settings.width = 17;
    settings.height = 13;
    settings.threads = 1;
    return render(scene, &settings, NULL);
}

static void the_settings_that_a_picture_tells_make_it_again(void **state) {
    static const char *const lines[] = {
        "-m splatting",
        "-m splatting -a 0.712345678901234 --set gather=trace --set splatting.hit-samples=2 --set "
        "metric=harmonic --set harmonics=3 --bounces 2 --seed 7",
        "-m direct-radiance",
        "-m direct-radiance -M 5 --set map=frustum --set map-fov=77.7 --set weight=15 --visibility rays",
        "-m light-octree",
        "-m light-octree --set acceptance=41.7 --stored-photons 3000 --set radius=70.123456789 "
        "--set atlas=1 --set lobes=surface --set whole-voxels=1",
        "-m multi-mesh",
        "-m multi-mesh --set gather-fov=133.3 --set light-rays=3 --set light-size=16 --set gather-size=16 "
        "--threshold 1.23456789012 --set multi-mesh.selection=chain",
        "-m shading-cache",
        "-m shading-cache --set area-samples=9 --set indirect-samples=5 --set random-share=0.0123456789012 "
        "--set no-flood=1 --updates 5 --set stop-size=3.3 --caustics",
        "-m path --spp 3 --set filter=centre --transport one-bounce",
        "-m path --spp 2 --transport matched:splatting --bounces 3",
        "-m bidirectional --spp 2 --transport matched:splatting",
    };
    sl_scene *scene = load_scene("scenes/cornell-glossy.json");
    for (size_t l = 0; l < sizeof lines / sizeof *lines; l++) {
        char line[400];
        snprintf(line, sizeof line, "-q draft %s", lines[l]);
        sl_image *image = render_small(scene, settings_of_line(line));
        sl_image *same = render_small(scene, settings_of_picture(image));
        if (!same_picture(image, same)) fail_msg("%s: another picture", lines[l]);
        assert_int_equal(image->metadata_count, same->metadata_count);
        destroy_pictures(image, same);
    }
    sl_scene_destroy(scene);
}

/* ---- all of them ----------------------------------------------------------------------------- */

/* Some value that is not the default, as text. */
static void other_value(const sl_setting *s, char text[WORD]) {
    const char *last = strrchr(s->unit, '|');
    if (last) snprintf(text, WORD, "%s", last + 1);
    else if (strcmp(s->unit, "PATHS") == 0) snprintf(text, WORD, "direct");
    else if (strcmp(s->unit, "BYTES") == 0) snprintf(text, WORD, "64M");
    else if (strcmp(s->unit, "WxH") == 0) snprintf(text, WORD, "7x5");
    else if (!*s->unit) snprintf(text, WORD, "true");
    else if (s->minimum < s->maximum)
        snprintf(text, WORD, "%.0f", s->minimum > 1.0 || s->maximum > 2.0 ? s->minimum + 1.0 : 1.0);
    else snprintf(text, WORD, "3");
}

static void assert_set_and_told(const sl_setting *setting, const char *method) {
    sl_settings settings = sl_settings_default();
    char value[WORD], back[WORD];
    set(&settings, "method", method);
    set(&settings, "transport", "full");
    other_value(setting, value);
    set(&settings, setting->name, value);
    assert_int_equal(sl_settings_get(&settings, setting->name, back, sizeof back, NULL), SL_OK);
    assert_string_equal(back, value);
    sl_image *image = blank_image(1, 1, 3);
    assert_int_equal(sl_settings_stamp(&settings, image, NULL), SL_OK);
    if (!is_told(image, setting)) fail_msg("%s: %s is not told", method, setting->name);
    sl_image_destroy(image);
}

/* Size, threads and memory do not decide a picture's values. */
static bool is_apart(const sl_setting *s) {
    return strcmp(s->name, "size") == 0 || strcmp(s->name, "threads") == 0 ||
           strcmp(s->name, "memory") == 0 || strcmp(s->name, "method") == 0;
}

static void every_option_is_set_by_name_and_told_by_the_pictures_of_its_methods(void **state) {
    const sl_setting *s;
    int count = 0;
    for (size_t i = 0; (s = sl_setting_at(i)) != NULL; i++) {
        for (size_t m = 0; sl_method_name(m); m++) {
            if (is_apart(s) || (*s->methods && !strstr(s->methods, sl_method_name(m)))) continue;
            assert_set_and_told(s, sl_method_name(m));
            count++;
        }
    }
    assert_true(count > 80);
}

static void every_option_has_a_name_of_its_own_and_a_line_of_help(void **state) {
    const sl_setting *s;
    for (size_t i = 0; (s = sl_setting_at(i)) != NULL; i++) {
        assert_ptr_equal(sl_setting_named(s->name), s);
        assert_ptr_equal(sl_setting_named(sl_setting_flag(s)), s);
        assert_true(strlen(s->help) > 3);
        assert_null(strchr(s->help, '\n'));
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_settings_that_a_picture_tells_make_it_again),
        cmocka_unit_test(every_option_is_set_by_name_and_told_by_the_pictures_of_its_methods),
        cmocka_unit_test(every_option_has_a_name_of_its_own_and_a_line_of_help),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
