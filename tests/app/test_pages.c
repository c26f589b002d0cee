/* The pages of `softlux steps` and the report of `softlux bench`, in a browser: they show what they hold, on
 * paper of any width, and fetch nothing; the slider and the pixels' explanations work by mouse and by keys,
 * and an explanation adds up to the very value that a render has. */
#include "unit_test.h"
#include "webdriver.h"

#include <cjson/cJSON.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "rendering.h"
#include "scene_files.h"

enum { WIDTH = 48, HEIGHT = 40 };
static const char scene_path[] = "scenes/cornell-glossy.json";
static const char *const methods[] = {"splatting", "direct-radiance", "shading-cache", "multi-mesh",
                                      "light-octree"};
enum { METHODS = sizeof methods / sizeof methods[0] };
static const char *const pages[] = {"splatting/index.html",     "direct-radiance/index.html",
                                    "shading-cache/index.html", "multi-mesh/index.html",
                                    "light-octree/index.html",  "report/report.html"};
enum { PAGES = sizeof pages / sizeof pages[0] };

typedef struct {
    browser *browser;
} fixture;

static char program[4096];

static int open_pages(void **state) {
    static fixture f;
    *state = &f;
    if (access(program, X_OK) != 0) return 0;
    char command[9000];
    for (size_t i = 0; i < METHODS; i++) {
        snprintf(command, sizeof command,
                 "%s steps %s -m %s -s %dx%d -q draft --reference-spp 4 --quiet -o %s", program, scene_path,
                 methods[i], WIDTH, HEIGHT, scene_file_path(methods[i]));
        if (system(command) != 0) return 1;
    }
    snprintf(command, sizeof command,
             "%s bench scenes/cornell.json scenes/sphere.json -o %s -s 24x24 -m direct-radiance,path -q "
             "draft,normal --repeats 1 --references %s --reference-budget 0.1 --reference-threads 1 --quiet",
             program, scene_file_path("report"), scene_file_path("references"));
    if (system(command) != 0) return 1;
    f.browser = browser_open(1100, 900);
    return 0;
}

static int close_pages(void **state) {
    fixture *f = *state;
    browser_close(f->browser);
    return scene_files_remove();
}

static void need_browser(const fixture *f) {
    if (f->browser) return;
    print_message("skip: no softlux beside these tests, or no chromedriver\n");
    skip();
}

/* Clicks on a place of an element, in shares of its width and height. */
static void click_on(browser *b, const char *element, double x, double y) {
    char script[512];
    snprintf(script, sizeof script,
             "const e = document.querySelector('%s'); e.scrollIntoView({block: 'center'}); const r = "
             "e.getBoundingClientRect(); return [Math.round(r.left + %.6f * r.width), Math.round(r.top + "
             "%.6f * r.height)]",
             element, x, y);
    cJSON *place = browser_run(b, script);
    browser_click(b, cJSON_GetArrayItem(place, 0)->valueint, cJSON_GetArrayItem(place, 1)->valueint);
    cJSON_Delete(place);
}

static void open_page(const fixture *f, const char *name) {
    browser_go_to_file(f->browser, scene_file_path(name));
}

/* ---- */

static void every_picture_loads_has_a_text_and_nothing_is_fetched(void **state) {
    fixture *f = *state;
    need_browser(f);
    for (size_t i = 0; i < PAGES; i++) {
        open_page(f, pages[i]);
        assert_true(browser_number(f->browser, "return document.images.length") > 5);
        assert_holds(f->browser, "[...document.images].every(i => i.complete && i.naturalWidth > 0 && "
                                 "i.alt.length > 3)");
        assert_holds(f->browser, "performance.getEntriesByType('resource').every(r => "
                                 "r.name.startsWith('data:'))");
        assert_int_equal(browser_errors(f->browser), 0);
    }
}

static void every_pass_is_explained(void **state) {
    fixture *f = *state;
    need_browser(f);
    for (size_t i = 0; i < METHODS; i++) {
        open_page(f, pages[i]);
        assert_holds(f->browser, "document.querySelectorAll('section.step').length > 4");
        assert_holds(f->browser,
                     "[...document.querySelectorAll('section.step')].every(s => s.querySelector('.code'))");
        assert_holds(f->browser, "document.querySelectorAll('math').length > 2");
    }
}

static void the_slider_plays_the_refinement_by_keys_and_by_mouse(void **state) {
    fixture *f = *state;
    need_browser(f);
    open_page(f, pages[0]);
    char *last = browser_text(
        f->browser,
        "document.querySelector('input').focus(); return document.querySelector('.picture img').src");
    browser_press(f->browser, KEY_HOME);
    char *first = browser_text(f->browser, "return document.querySelector('.picture img').src");
    assert_string_not_equal(first, last);
    assert_holds(f->browser, "document.querySelector('input').value === '0'");
    browser_press(f->browser, KEY_RIGHT);
    assert_holds(f->browser, "document.querySelector('input').value === '1'");
    char *told = browser_text(f->browser, "return document.querySelector('output').textContent");
    assert_non_null(strstr(told, "batch 2 of"));
    assert_non_null(strstr(told, "off by"));
    click_on(f->browser, "input", 0.995, 0.5);
    char *again = browser_text(f->browser, "return document.querySelector('.picture img').src");
    assert_string_equal(again, last);
    free(last), free(first), free(told), free(again);
}

/* Renders with the same settings. */
static sl_image *render_with(const char *method) {
    const sl_settings settings = small_settings(method, WIDTH, HEIGHT);
    sl_scene *scene = load_scene(scene_path);
    sl_image *image = render(scene, &settings, NULL);
    sl_scene_destroy(scene);
    return image;
}

static void assert_explanation_is(browser *b, const sl_image *image, int x, int y) {
    char title[64];
    snprintf(title, sizeof title, "The explanation of pixel %d, %d", x, y);
    char *told = browser_text(b, "return document.querySelector('.explanation h3').textContent");
    assert_string_equal(told, title);
    free(told);
    /* Every line says what it holds. */
    assert_holds(b, "[...document.querySelectorAll('.explanation tr')].slice(1, -2).every(r => "
                    "r.cells[3].textContent.split(' ').length === 3)");
    cJSON *pixel = browser_run(b, "return JSON.parse(document.querySelector('article').dataset.explanation)");
    for (int c = 0; c < 3; c++) {
        float value = image->planes[(c * HEIGHT + y) * WIDTH + x];
        assert_true((float)cJSON_GetArrayItem(pixel, c)->valuedouble == value);
    }
    cJSON_Delete(pixel);
}

static void a_pixels_explanation_by_mouse_and_keys_adds_up_to_what_a_render_has(void **state) {
    fixture *f = *state;
    need_browser(f);
    for (size_t i = 0; i < METHODS; i++) {
        sl_image *image = render_with(methods[i]);
        open_page(f, pages[i]);
        for (int k = 0; k < 12; k++) {
            int x = (7 + 13 * k) % (WIDTH - 1), y = (5 + 11 * k) % (HEIGHT - 1);
            click_on(f->browser, ".picture img", (x + 0.5) / WIDTH, (y + 0.5) / HEIGHT);
            assert_explanation_is(f->browser, image, x, y);
            browser_press(f->browser, KEY_RIGHT);
            browser_press(f->browser, KEY_DOWN);
            assert_explanation_is(f->browser, image, x + 1, y + 1);
        }
        assert_int_equal(browser_errors(f->browser), 0);
        sl_image_destroy(image);
    }
}

static void the_overview_leads_to_every_scene(void **state) {
    fixture *f = *state;
    need_browser(f);
    open_page(f, "report/report.html");
    assert_holds(f->browser, "document.querySelectorAll('a[href]').length >= 2");
    assert_holds(f->browser, "[...document.querySelectorAll('a[href]')].every(a => "
                             "document.querySelector(a.getAttribute('href')).textContent == a.textContent)");
}

/* Names of curves stand beside each other, and nothing beyond the paper. */
static void plots_keep_their_names_apart_and_on_the_paper(void **state) {
    fixture *f = *state;
    need_browser(f);
    open_page(f, "report/report.html");
    assert_holds(f->browser, "document.querySelectorAll('svg.plot').length === 4");
    assert_holds(f->browser,
                 "[...document.querySelectorAll('svg.plot')].every(p => { const all = "
                 "p.getBoundingClientRect();"
                 "return [...p.querySelectorAll('text')].every(t => { const r = t.getBoundingClientRect();"
                 "return r.left >= all.left && r.right <= all.right && r.top >= all.top && r.bottom <= "
                 "all.bottom; }); })");
    assert_holds(f->browser, "[...document.querySelectorAll('svg.plot')].every(p => { const names = "
                             "[...p.querySelectorAll('text[class^=n]')]"
                             ".map(t => t.getBoundingClientRect().top).sort((a, b) => a - b);"
                             "return names.every((y, i) => i == 0 || y - names[i - 1] > 10); })");
}

static void a_phone_needs_no_sideways_scrolling(void **state) {
    fixture *f = *state;
    need_browser(f);
    browser_resize(f->browser, 500, 800); /* as narrow as the browser's window goes */
    for (size_t i = 0; i < PAGES; i++) {
        open_page(f, pages[i]);
        assert_true(browser_number(f->browser,
                                   "document.body.style.width = '360px'; return document.body.scrollWidth") <=
                    361.0);
    }
}

int main(int argc, char **argv) {
    const char *slash = strrchr(argv[0], '/');
    snprintf(program, sizeof program, "%.*s/../softlux", slash ? (int)(slash - argv[0]) : 1,
             slash ? argv[0] : ".");
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_picture_loads_has_a_text_and_nothing_is_fetched),
        cmocka_unit_test(every_pass_is_explained),
        cmocka_unit_test(the_slider_plays_the_refinement_by_keys_and_by_mouse),
        cmocka_unit_test(a_pixels_explanation_by_mouse_and_keys_adds_up_to_what_a_render_has),
        cmocka_unit_test(the_overview_leads_to_every_scene),
        cmocka_unit_test(plots_keep_their_names_apart_and_on_the_paper),
        cmocka_unit_test(a_phone_needs_no_sideways_scrolling),
    };
    return cmocka_run_group_tests(tests, open_pages, close_pages);
}
