/* The report of softlux bench in a browser: it shows what it holds, on paper of any width, and fetches
 * nothing. */
#include "webdriver.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

typedef struct {
    char folder[64];
    browser *browser;
} fixture;

static char program[4096];

static int open_report(void **state) {
    static fixture f;
    char command[9000];
    *state = &f;
    snprintf(f.folder, sizeof f.folder, "/tmp/softlux-bench-page-XXXXXX");
    if (access(program, X_OK) != 0 || !mkdtemp(f.folder)) return 0;
    snprintf(command, sizeof command,
             "%s bench scenes/cornell.json scenes/sphere.json -o %s/report -s 24x24 -m direct-radiance,path "
             "-q draft,normal --repeats 1 "
             "--references %s/references --reference-budget 0.1 --reference-threads 1 --quiet",
             program, f.folder, f.folder);
    if (system(command) != 0) return 1;
    f.browser = browser_open(1100, 900);
    return 0;
}

static int close_report(void **state) {
    fixture *f = *state;
    char command[128];
    browser_close(f->browser);
    snprintf(command, sizeof command, "rm -rf %s", f->folder);
    return system(command);
}

static void open_page(const fixture *f) {
    char path[256];
    if (!f->browser) {
        print_message("skip: no softlux beside these tests, or no chromedriver\n");
        skip();
    }
    snprintf(path, sizeof path, "%s/report/report.html", f->folder);
    browser_go_to_file(f->browser, path);
}

static void every_picture_loads_and_nothing_is_fetched(void **state) {
    fixture *f = *state;
    open_page(f);
    assert_true(browser_number(f->browser, "return document.images.length") >= 8.0);
    assert_true(
        browser_number(
            f->browser,
            "return [...document.images].every(i => i.complete && i.naturalWidth > 0 && i.alt.length > 3)") ==
        1.0);
    assert_true(browser_number(f->browser, "return performance.getEntriesByType('resource').filter(r => "
                                           "!r.name.startsWith('data:')).length") == 0.0);
    assert_int_equal(browser_errors(f->browser), 0);
}

static void the_overview_leads_to_every_scene(void **state) {
    fixture *f = *state;
    open_page(f);
    assert_true(browser_number(f->browser, "return document.querySelectorAll('a[href]').length") >= 2.0);
    assert_true(browser_number(
                    f->browser,
                    "return [...document.querySelectorAll('a[href]')].every(a => "
                    "document.querySelector(a.getAttribute('href')).textContent == a.textContent)") == 1.0);
}

/* Names of curves stand beside each other, and nothing beyond the paper. */
static void plots_keep_their_names_apart_and_on_the_paper(void **state) {
    fixture *f = *state;
    open_page(f);
    assert_true(browser_number(f->browser, "return document.querySelectorAll('svg.plot').length") == 8.0);
    assert_true(browser_number(
                    f->browser,
                    "return [...document.querySelectorAll('svg.plot')].every(p => { const all = "
                    "p.getBoundingClientRect();"
                    "return [...p.querySelectorAll('text')].every(t => { const r = t.getBoundingClientRect();"
                    "return r.left >= all.left && r.right <= all.right && r.top >= all.top && r.bottom <= "
                    "all.bottom; }); })") == 1.0);
    assert_true(browser_number(f->browser,
                               "return [...document.querySelectorAll('svg.plot')].every(p => { const names = "
                               "[...p.querySelectorAll('text[class^=n]')]"
                               ".map(t => t.getBoundingClientRect().top).sort((a, b) => a - b);"
                               "return names.every((y, i) => i == 0 || y - names[i - 1] > 10); })") == 1.0);
}

static void a_phone_needs_no_sideways_scrolling(void **state) {
    fixture *f = *state;
    if (f->browser) browser_resize(f->browser, 500, 800); /* as narrow as the browser's window goes */
    open_page(f);
    assert_true(
        browser_number(f->browser,
                       "document.body.style.width = '330px'; return document.documentElement.scrollWidth") <=
        501.0);
    assert_true(
        browser_number(
            f->browser,
            "return Math.max(...[...document.body.children].map(e => e.getBoundingClientRect().width))") <=
        331.0);
}

int main(int argc, char **argv) {
    (void)argc;
    const char *slash = strrchr(argv[0], '/');
    snprintf(program, sizeof program, "%.*s/../softlux", slash ? (int)(slash - argv[0]) : 1,
             slash ? argv[0] : ".");
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_picture_loads_and_nothing_is_fetched),
        cmocka_unit_test(the_overview_leads_to_every_scene),
        cmocka_unit_test(plots_keep_their_names_apart_and_on_the_paper),
        cmocka_unit_test(a_phone_needs_no_sideways_scrolling),
    };
    return cmocka_run_group_tests(tests, open_report, close_report);
}
