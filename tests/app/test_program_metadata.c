/* What a picture's metadata are for: `softlux render` with the settings that they tell makes the same picture again. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdio.h>
#include <string.h>

#include "app/settings_options.h"
#include "cache/frame/settings.h"
#include "rendering.h"

enum { WORDS = 300, WORD = 64 };

typedef struct words {
    char text[WORDS][WORD];
    int count;
} words;

static void add_word(words *w, const char *text) {
    assert_true(w->count < WORDS && strlen(text) < WORD);
    strcpy(w->text[w->count++], text);
}

static sl_settings settings_of(words *w) {
    static sl_option options[SL_SETTINGS_OPTIONS];
    static sl_raw_settings raw;
    char *argv[WORDS];
    const char *operand;
    int operands, status = -1;
    sl_settings_options(&raw, options);
    const sl_command_line line = {"test", "test", NULL, options, 0, 0};
    for (int i = 0; i < w->count; i++) argv[i] = w->text[i];
    if (!sl_options_parse(&line, w->count, argv, &operand, &operands, &status)) fail_msg("not taken");
    return sl_settings_taken(&raw);
}

/* ---- from metadata back to options ---------------------------------------------------------------------------------------------------- */

static const sl_option *option_of(const sl_option *options, const char *key) {
    char name[WORD];
    snprintf(name, sizeof name, "%s", key);
    for (char *c = name; *c; c++) *c = *c == '_' ? '-' : *c;
    for (const sl_option *o = options; o->name; o++) {
        if (strcmp(o->name, name) == 0) return o;
    }
    return NULL;
}

static bool tells_what_came_out(const char *key) {
    static const char *const results[] = {"version", "scene_hash", "batches", "warning", "concession", "flux_captured", "flux_received"};
    if (strncmp(key, "counter.", 8) == 0 || strncmp(key, "octree.", 7) == 0) return true;
    for (size_t i = 0; i < sizeof results / sizeof *results; i++) {
        if (strcmp(key, results[i]) == 0) return true;
    }
    return false;
}

static void add_setting(words *w, const sl_option *options, const sl_metadatum *m) {
    static const char ours[] = "softlux.";
    if (strncmp(m->key, ours, sizeof ours - 1) != 0 || tells_what_came_out(m->key + sizeof ours - 1)) return;
    const sl_option *o = option_of(options, m->key + sizeof ours - 1);
    if (!o) fail_msg("%s is no option", m->key);
    if (strcmp(m->value, "0") == 0 && o->minimum > 0.0) return; /* nothing was said, and nothing chosen */
    char name[WORD];
    snprintf(name, sizeof name, "--%s", o->name);
    add_word(w, name);
    if (o->kind != SL_OPTION_FLAG) add_word(w, m->value);
    else assert_string_equal(m->value, "true");
}

static words told_by(const sl_image *image) {
    static sl_option options[SL_SETTINGS_OPTIONS];
    sl_raw_settings raw;
    words w = {.count = 0};
    sl_settings_options(&raw, options);
    for (size_t i = 0; i < image->metadata_count; i++) add_setting(&w, options, &image->metadata[i]);
    return w;
}

/* Also of settings that have not mattered. */
static void assert_all_are_told(const words *asked, const words *told) {
    for (int i = 0; i < asked->count; i++) {
        bool found = strncmp(asked->text[i], "--", 2) != 0;
        for (int k = 0; k < told->count; k++) found = found || strcmp(told->text[k], asked->text[i]) == 0;
        if (!found) fail_msg("%s is not told", asked->text[i]);
    }
}

/* ---- the same again ------------------------------------------------------------------------------------------------------------------- */

static sl_image *render_words(const sl_scene *scene, words *w) {
    sl_settings settings = settings_of(w);
    settings.width = 17;
    settings.height = 13;
    return render(scene, &settings, NULL);
}

static void the_settings_that_a_picture_tells_make_it_again(void **state) {
    (void)state;
    static const char *const lines[] = {
        "-m splatting", "-m splatting -a 0.712345678901234 --gather trace --hit-samples 2 --metric minimum --harmonics 3 --glossy-hits --bounces 2 --seed 7",
        "-m direct-radiance", "-m direct-radiance -M 5 --map frustum --map-fov 77.7 --weight 15 --visibility blocks --mirror-light trick --8-bit-positions",
        "-m light-octree", "-m light-octree --acceptance 41.7 --spread 3.3 --stored-photons 3000 --radius 70.123456789 --dilation 0.123456789 --atlas --lobes harmonics --whole-voxels",
        "-m multi-mesh", "-m multi-mesh --gather-fov 133.3 --light-rays 3 --light-size 16 --gather-size 16 --threshold 1.23456789012 --selection chain",
        "-m shading-cache", "-m shading-cache --area-samples 9 --indirect-samples 5 --random-share 0.0123456789012 --no-flood --updates 5 --stop-size 3.3 --caustics",
        "-m path --spp 3 --filter centre --transport one-bounce", "-m bidirectional --spp 2 --transport matched:splatting",
    };
    sl_scene *scene = load_scene("scenes/cornell-glossy.json");
    for (size_t l = 0; l < sizeof lines / sizeof *lines; l++) {
        words first = {.count = 0};
        char line[300], *rest = NULL;
        snprintf(line, sizeof line, "-q draft -t 1 %s", lines[l]);
        for (char *word = strtok_r(line, " ", &rest); word; word = strtok_r(NULL, " ", &rest)) add_word(&first, word);
        sl_image *image = render_words(scene, &first);
        words again = told_by(image);
        assert_all_are_told(&first, &again);
        sl_image *same = render_words(scene, &again);
        if (!same_picture(image, same)) fail_msg("%s: another picture", lines[l]);
        sl_image_destroy(image);
        sl_image_destroy(same);
    }
    sl_scene_destroy(scene);
}

/* ---- all of them -------------------------------------------------------------------------------------------------------------------------- */

/* How it is asked for with some value that is not the default. */
static void ask_for(words *w, const sl_option *o) {
    char text[WORD];
    snprintf(text, sizeof text, "--%s", o->name);
    add_word(w, text);
    if (o->kind == SL_OPTION_FLAG) return;
    if (o->kind == SL_OPTION_COUNT) snprintf(text, sizeof text, "%g", o->minimum + 1.0);
    if (o->kind == SL_OPTION_REAL) snprintf(text, sizeof text, "%g", 0.25 * o->maximum + 0.75 * o->minimum);
    if (o->kind == SL_OPTION_TEXT) snprintf(text, sizeof text, "direct");
    for (int i = 0; o->kind == SL_OPTION_CHOICE && o->choices[i]; i++) snprintf(text, sizeof text, "%s", o->choices[i]);
    add_word(w, text);
}

static void assert_told(const char *method, const sl_option *options, const sl_option *o) {
    words asked = {.count = 0};
    add_word(&asked, "--method");
    add_word(&asked, method);
    ask_for(&asked, o);
    sl_settings settings = settings_of(&asked);
    if (!settings.transport) settings.transport = "matched";
    sl_image *image;
    bool told = false;
    assert_int_equal(sl_image_create(1, 1, 3, NULL, &image, NULL), SL_OK);
    assert_int_equal(sl_settings_stamp(&settings, image, NULL), SL_OK);
    for (size_t i = 0; i < image->metadata_count; i++) told = told || option_of(options, image->metadata[i].key + strlen("softlux.")) == o;
    if (!told) fail_msg("%s: --%s is not told", method, o->name);
    sl_image_destroy(image);
}

/* Their headings name the methods. */
static void pictures_tell_every_option_of_their_method(void **state) {
    (void)state;
    static sl_option options[SL_SETTINGS_OPTIONS];
    sl_raw_settings raw;
    const char *heading = "";
    int count = 0;
    sl_settings_options(&raw, options);
    for (const sl_option *o = options; o->name; o++) {
        if (o->kind == SL_OPTION_HEADING) heading = o->help;
        for (size_t m = 0; o->kind != SL_OPTION_HEADING && sl_method_name(m); m++) {
            if (!strstr(heading, sl_method_name(m))) continue;
            assert_told(sl_method_name(m), options, o);
            count++;
        }
    }
    assert_true(count > 90);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_settings_that_a_picture_tells_make_it_again),
        cmocka_unit_test(pictures_tell_every_option_of_their_method),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
