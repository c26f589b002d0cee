/* The page of `softlux serve`, in a browser, before a server of its own: what people do on it by mouse, touch
 * and keys is done in the scene and seen in the picture; it says nothing but the truth, asks nobody else. */
#include "unit_test.h"
#include "webdriver.h"

#include <cjson/cJSON.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "scene_files.h"

typedef struct {
    browser *browser;
    pid_t server;
    char address[256], folder[1024];
} fixture;

static char program[4096];

/* ---- a server and a browser ---- */

static int start_server(fixture *f) {
    int ends[2];
    char text[256] = "";
    snprintf(f->folder, sizeof f->folder, "%s", scene_file_path("kept"));
    if (pipe(ends) != 0) return 1;
    f->server = fork();
    if (f->server == 0) {
        prctl(PR_SET_PDEATHSIG, SIGINT); /* a test that aborts leaves no server */
        dup2(ends[1], STDOUT_FILENO);
        close(ends[0]);
        execl(program, program, "serve", "scenes/cornell-point.json", "-s", "48x48", "-m", "direct-radiance",
              "-q", "draft", "--threads", "1", "-o", f->folder, "--quiet", (char *)NULL);
        _exit(127);
    }
    close(ends[1]);
    FILE *said = fdopen(ends[0], "r");
    const bool has_said = fgets(text, sizeof text, said) != NULL;
    fclose(said);
    text[strcspn(text, "\n")] = '\0';
    snprintf(f->address, sizeof f->address, "%s", text);
    return has_said ? 0 : 1;
}

static int open_all(void **state) {
    static fixture f;
    *state = &f;
    if (access(program, X_OK) != 0 || start_server(&f) != 0 || !*f.address) return 0;
    f.browser = browser_open(1200, 800);
    return 0;
}

static int close_all(void **state) {
    fixture *f = *state;
    int status = 0;
    browser_close(f->browser);
    if (f->server > 0) {
        kill(f->server, SIGINT);
        waitpid(f->server, &status, 0);
    }
    scene_files_remove();
    return !f->browser || (WIFEXITED(status) && WEXITSTATUS(status) == 0) ? 0 : 1;
}

static void need_browser(const fixture *f) {
    if (f->browser) return;
    print_message("skip: no softlux that serves beside these tests, or no chromedriver\n");
    skip();
}

/* ---- what holds on the page ---- */

static void wait_until(browser *b, const char *expression) {
    const time_t begun = time(NULL);
    while (time(NULL) - begun < 90) {
        if (browser_holds(b, expression)) return;
        nanosleep(&(struct timespec){0, 50000000}, NULL);
    }
    fail_msg("waited in vain: %s", expression);
}

static void run(browser *b, const char *script) { cJSON_Delete(browser_run(b, script)); }

/* Pictures are compared by their bytes, kept in the page under a name. */
static const char tools[] =
    "window.seen = id => { const c = document.getElementById(id || 'left');"
    "  return c.getContext('2d').getImageData(0, 0, c.width, c.height).data.join(); };"
    "window.away = (a, b) => Math.hypot(...a.map((x, i) => x - b[i]));"
    "window.choose = (id, value) => { const e = document.getElementById(id); e.value = value;"
    "  e.dispatchEvent(new Event('input')); e.dispatchEvent(new Event('change', {bubbles: true})); };"
    "window.lies_over_the_picture = e => { const r = e.getBoundingClientRect(),"
    "  p = document.getElementById('left').getBoundingClientRect();"
    "  return r.right > p.left && r.left < p.right && r.bottom > p.top && r.top < p.bottom; };"
    "window.marks = s => [...document.querySelectorAll('#marks [data-layer=overlay] ' + s)];"
    "window.press = id => document.getElementById(id).click();";

static void open_page(fixture *f) {
    browser_go_to(f->browser, "about:blank");
    browser_go_to(f->browser, f->address);
    run(f->browser, tools);
    wait_until(f->browser, "document.querySelector('#frame.ready') && softlux.world.scene");
}

/* Skips the test where there is no browser. */
static fixture *opened_page(void **state) {
    fixture *f = *state;
    need_browser(f);
    open_page(f);
    return f;
}

/* Of an element: where in the window a share of its width and height is. */
static browser_place place_in(browser *b, const char *element, double x, double y) {
    char script[512];
    snprintf(script, sizeof script,
             "const r = document.querySelector('%s').getBoundingClientRect();"
             "return [Math.round(r.left + %.6f * r.width), Math.round(r.top + %.6f * r.height)]",
             element, x, y);
    cJSON *at = browser_run(b, script);
    const browser_place place = {cJSON_GetArrayItem(at, 0)->valueint, cJSON_GetArrayItem(at, 1)->valueint};
    cJSON_Delete(at);
    return place;
}

static void drag_from(browser *b, const char *pointer, browser_place from, int dx, int dy, bool held) {
    browser_place way[6];
    for (int i = 0; i < 6; i++) way[i] = (browser_place){from.x + dx * i / 5, from.y + dy * i / 5};
    browser_drag(b, pointer, way, 6, held);
}

static void remember(browser *b) {
    run(b, "window.picture = seen(); window.camera = softlux.world.camera;"
           "window.lamp = softlux.world.scene.lights[0].position");
}

static void wait_for_change(browser *b) { wait_until(b, "seen() !== picture"); }

static void assert_nothing_is_wrong(const fixture *f) {
    assert_int_equal(browser_errors(f->browser), 0);
    assert_holds(f->browser, "performance.getEntriesByType('resource').every(r => new URL(r.name).host === "
                             "location.host)");
}

/* ---- */

static void the_page_opens_with_a_picture_and_hides_its_token(void **state) {
    fixture *f = opened_page(state);
    assert_holds(f->browser, "location.hash === '' && !location.href.includes('#')");
    assert_holds(f->browser, "sessionStorage.getItem('token').length >= 32");
    assert_holds(f->browser, "document.title.includes('cornell-point.json')");
    assert_holds(f->browser, "new Set(seen().split(',')).size > 50");
    assert_holds(f->browser, "[...document.querySelectorAll('button, input, select, canvas')].every(e => "
                             "e.labels?.length || e.getAttribute('aria-label') || e.textContent.trim() || "
                             "e.closest('#frame'))");
    assert_nothing_is_wrong(f);
}

static void the_picture_follows_mouse_fingers_and_keys(void **state) {
    fixture *f = opened_page(state);
    const browser_place middle = place_in(f->browser, "#frame", 0.5, 0.6);
    remember(f->browser);
    drag_from(f->browser, "mouse", middle, 80, 20, false);
    wait_for_change(f->browser);
    assert_holds(f->browser, "away(softlux.world.camera.eye, camera.eye) > 10");
    assert_holds(f->browser, "away(softlux.world.camera.target, camera.target) < 1e-3"); /* an orbit */
    remember(f->browser);
    browser_pinch(f->browser, (browser_place[]){{middle.x - 20, middle.y}, {middle.x - 90, middle.y}},
                  (browser_place[]){{middle.x + 20, middle.y}, {middle.x + 90, middle.y}});
    wait_for_change(f->browser);
    assert_holds(f->browser, "away(softlux.world.camera.eye, softlux.world.camera.target) < "
                             "0.7 * away(camera.eye, camera.target)");
    remember(f->browser);
    run(f->browser, "document.getElementById('frame').focus()");
    browser_press(f->browser, "w");
    wait_for_change(f->browser);
    assert_holds(f->browser, "away(softlux.world.camera.target, camera.target) > 1"); /* a walk */
    browser_press(f->browser, KEY_HOME);
    wait_until(f->browser, "away(softlux.world.camera.eye, [278, 273, -800]) < 1");
    assert_nothing_is_wrong(f);
}

static void a_lamp_that_is_dragged_lights_from_where_it_is_then(void **state) {
    fixture *f = opened_page(state);
    remember(f->browser);
    drag_from(f->browser, "mouse", place_in(f->browser, ".handle.lamp", 0.5, 0.5), 60, 0, false);
    wait_for_change(f->browser);
    wait_until(f->browser, "away(softlux.world.scene.lights[0].position, lamp) > 20");
    assert_holds(f->browser, "softlux.world.selected.what === 'light'");
    wait_until(f->browser, "!document.getElementById('undo').disabled");
    run(f->browser, "press('undo')"); /* the whole drag is one step */
    wait_until(f->browser, "away(softlux.world.scene.lights[0].position, lamp) < 1e-3");
    assert_holds(f->browser, "document.getElementById('undo').disabled");
    assert_nothing_is_wrong(f);
}

static void what_is_picked_gets_another_colour_and_goes_elsewhere(void **state) {
    fixture *f = opened_page(state);
    remember(f->browser);
    const browser_place box = place_in(f->browser, "#frame", 0.62, 0.75);
    browser_click(f->browser, box.x, box.y);
    wait_until(f->browser, "softlux.world.selected && document.querySelector('#editor input[type=color]')");
    assert_holds(f->browser, "document.querySelector('#editor h3').textContent === 'short_box'");
    run(f->browser, "const c = document.querySelector('#editor input[type=color]'); c.value = '#0000ff';"
                    "c.dispatchEvent(new Event('change', {bubbles: true}))");
    wait_until(f->browser, "softlux.world.scene.materials.some(m => m.diffuse[2] > 0.9 && "
                           "m.diffuse[0] < 0.1)");
    wait_for_change(f->browser);
    remember(f->browser);
    run(f->browser, "const p = document.querySelector('#editor .triple input'); window.x = Number(p.value);"
                    "p.focus(); p.value = x + 60; p.dispatchEvent(new Event('change'))");
    wait_for_change(f->browser);
    wait_until(f->browser, "Math.abs(softlux.world.scene.objects.find(o => o.name === 'short_box').centre[0]"
                           " - x - 60) < 0.5");
    run(f->browser, "press('undo'); press('undo')");
    wait_until(f->browser, "document.getElementById('undo').disabled");
    assert_nothing_is_wrong(f);
}

static void a_lamp_is_added_and_taken_away(void **state) {
    fixture *f = opened_page(state);
    run(f->browser, "press('tab-scene'); press('add-lamp')");
    wait_until(f->browser, "softlux.world.scene.lights.length === 2 && softlux.world.selected?.number === 2");
    run(f->browser, "press('remove-lamp')");
    wait_until(f->browser, "softlux.world.scene.lights[1].power.every(p => p === 0)");
    run(f->browser, "press('undo'); press('undo')");
    wait_until(f->browser, "document.getElementById('undo').disabled");
    assert_nothing_is_wrong(f);
}

static const char *const methods[] = {"splatting",    "light-octree", "multi-mesh",     "shading-cache",
                                      "path", "bidirectional", "direct-radiance"};
enum { METHODS = sizeof methods / sizeof methods[0] };

static void use_method(browser *b, const char *name) {
    char text[200];
    snprintf(text, sizeof text, "window.picture = seen(); choose('method-a', '%s')", name);
    run(b, text);
    snprintf(text, sizeof text, "softlux.states.a?.method === '%s' && seen() !== picture", name);
    wait_until(b, text);
}

static void every_method_shows_a_picture_of_its_own(void **state) {
    fixture *f = opened_page(state);
    for (size_t i = 0; i < METHODS; i++) {
        use_method(f->browser, methods[i]);
        assert_holds(f->browser, "document.querySelector('#settings h3').textContent.length > 4");
        assert_nothing_is_wrong(f);
    }
}

static void two_methods_stand_under_one_line_that_moves(void **state) {
    fixture *f = opened_page(state);
    run(f->browser, "choose('method-b', 'path')");
    wait_until(f->browser, "document.querySelector('#frame.split') && "
                           "!document.querySelector('#right.empty') && seen('right') !== seen()");
    const browser_place line = place_in(f->browser, "#line", 0.5, 0.5);
    drag_from(f->browser, "mouse", line, -100, 0, false);
    assert_holds(f->browser, "Number(document.getElementById('line').getAttribute('aria-valuenow')) < 45");
    run(f->browser, "document.getElementById('line').focus()");
    browser_press(f->browser, KEY_HOME);
    assert_holds(f->browser, "document.getElementById('line').getAttribute('aria-valuenow') === '0'");
    run(f->browser, "choose('method-b', '')");
    wait_until(f->browser, "!document.querySelector('#frame.split') && softlux.world.methods.b === ''");
    assert_nothing_is_wrong(f);
}

static void reference_difference_and_error_stand_beside(void **state) {
    fixture *f = opened_page(state);
    run(f->browser, "choose('method-b', 'reference')");
    wait_until(f->browser, "!document.querySelector('#right.empty') && "
                           "document.getElementById('told-b').textContent.includes('samples')");
    run(f->browser, "window.before = seen('right'); choose('method-b', 'difference')");
    wait_until(f->browser, "!document.querySelector('#right.empty') && seen('right') !== before");
    run(f->browser, "window.before = seen('right'); choose('method-b', 'error'); press('estimate')");
    wait_until(f->browser, "!document.querySelector('#right.empty') && seen('right') !== before");
    wait_until(f->browser, "document.getElementById('told-a').textContent.includes('%')");
    run(f->browser, "window.state = softlux.states.a; choose('method-b', 'difference')");
    wait_until(f->browser, "softlux.states.a !== state"); /* the newest news of the side do not hide it */
    assert_holds(f->browser, "document.getElementById('told-a').textContent.includes('%')");
    run(f->browser, "press('estimate'); choose('method-b', '')");
    assert_nothing_is_wrong(f);
}

static void tell_pixel(browser *b, int x, int y) {
    char text[300];
    snprintf(text, sizeof text, "document.getElementById('story').dataset.place === '%d,%d'", x, y);
    const browser_place at = place_in(b, "#frame", (x + 0.5) / 48.0, (y + 0.5) / 48.0);
    browser_click(b, at.x, at.y);
    wait_until(b, text);
}

/* The sum is the page's own, of the terms that it shows; the pixel is what the server has. */
static const char adds_up[] = "(s => JSON.parse(s.sum).every((v, c) => Math.fround(v) === Math.fround("
                              "JSON.parse(s.pixel)[c])))(document.getElementById('story').dataset)";

static bool tells_terms(const char *method) {
    return strcmp(method, "path") != 0 && strcmp(method, "bidirectional") != 0;
}

static void the_story_of_a_pixel_adds_up_to_it(void **state) {
    fixture *f = opened_page(state);
    run(f->browser, "document.querySelector('#tools [value=pixel]').click()");
    for (size_t i = 0; i < METHODS; i++) {
        use_method(f->browser, methods[i]);
        wait_until(f->browser, "softlux.states.a.batches > 0");
        for (int k = 0; k < 2; k++) {
            tell_pixel(f->browser, 7 + 17 * k, 30 + 11 * k);
            assert_holds(f->browser, tells_terms(methods[i]) ?
                                         adds_up :
                                         "!document.getElementById('story').dataset.sum");
        }
        if (strcmp(methods[i], "splatting") != 0) continue;
        assert_holds(f->browser, "document.querySelectorAll('#story .terms tbody tr').length >= 3");
        assert_holds(f->browser, "document.querySelectorAll('#story .code').length > 0");
    }
    run(f->browser, "document.getElementById('frame').focus()");
    browser_press(f->browser, KEY_RIGHT);
    wait_until(f->browser, "document.getElementById('story').dataset.place === '25,41'");
    assert_holds(f->browser, adds_up);
    assert_nothing_is_wrong(f);
}

/* Loads what was kept of a kind, as whoever clicks on its link. */
static void load_kept(browser *b, const char *kind, const char *path) {
    char script[400];
    snprintf(script, sizeof script,
             "return fetch(document.querySelector('#kept [data-what=%s] a').href).then(r => r.arrayBuffer())"
             ".then(f => [...new Uint8Array(f)].map(v => v.toString(16).padStart(2, '0')).join(''))", kind);
    char *digits = browser_text(b, script);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    for (const char *d = digits; d[0] && d[1]; d += 2) {
        const char one[3] = {d[0], d[1], '\0'};
        fputc((int)strtol(one, NULL, 16), file);
    }
    fclose(file);
    free(digits);
}

/* Renders what the page's command line says into another file. */
static void render_as_told(browser *b, const char *path) {
    static const char words[] = "softlux render ";
    char line[16384];
    char *command = browser_text(b, "return document.querySelector('#command pre').textContent");
    assert_memory_equal(command, words, strlen(words));
    *strstr(command, " -o ") = '\0';
    snprintf(line, sizeof line, "%s render %s --quiet -o %s", program, command + strlen(words), path);
    free(command);
    assert_int_equal(system(line), 0);
}

static void the_exact_picture_is_that_of_the_command_which_the_page_tells(void **state) {
    static const char *const kinds[] = {"exr", "png"};
    fixture *f = opened_page(state);
    drag_from(f->browser, "mouse", place_in(f->browser, ".handle.lamp", 0.5, 0.5), 40, 0, false);
    wait_until(f->browser, "!document.getElementById('undo').disabled");
    for (int m = 0; m < 2; m++) {
        if (m) use_method(f->browser, "splatting");
        run(f->browser, "press('tab-keep'); press('exact')");
        wait_until(f->browser, "document.getElementById('exact').dataset.done === 'true'");
        for (int k = 0; k < 2; k++) {
            char kept[2048], made[2048], line[16384];
            snprintf(kept, sizeof kept, "%s/loaded.%s", f->folder, kinds[k]);
            snprintf(made, sizeof made, "%s/rendered.%s", f->folder, kinds[k]);
            load_kept(f->browser, kinds[k], kept);
            render_as_told(f->browser, made);
            snprintf(line, sizeof line, "%s compare --identical %s %s >%s/compared 2>&1", program, kept, made,
                     f->folder);
            assert_int_equal(system(line), 0);
        }
    }
    wait_until(f->browser, "!document.querySelector('#right.empty')");
    run(f->browser, "choose('method-b', ''); choose('method-a', 'direct-radiance'); press('undo')");
    assert_nothing_is_wrong(f);
}

static void choose_pass(browser *b, const char *title) {
    char text[300];
    snprintf(text, sizeof text, "window.card = [...document.querySelectorAll('#strip .card')].find(c => "
                                "c.textContent.includes('%s'))", title);
    wait_until(b, text);
    run(b, "card.click()");
}

static void draw_marks(browser *b, const char *title) {
    choose_pass(b, title);
    wait_until(b, "document.querySelector('#pass .chip')");
    run(b, "document.querySelector('#pass .chip').click()");
}

static void a_pass_draws_its_marks_over_the_picture(void **state) {
    static const struct {
        const char *method, *title, *marks;
    } passes[] = {{"splatting", "The records", "path.disc"},
                  {"multi-mesh", "The mesh of direct light", "path"},
                  {"direct-radiance", "Sample photons", "circle"}};
    fixture *f = *state;
    need_browser(f);
    for (size_t i = 0; i < sizeof passes / sizeof passes[0]; i++) {
        char text[400];
        open_page(f);
        use_method(f->browser, passes[i].method);
        run(f->browser, "press('passes')");
        draw_marks(f->browser, passes[i].title);
        snprintf(text, sizeof text, "marks('%s').length > 20", passes[i].marks);
        wait_until(f->browser, text);
        assert_holds(f->browser, "marks('*').filter(lies_over_the_picture).length > 0.9 * marks('*').length");
        run(f->browser, "window.drawn = marks('*').map(m => m.outerHTML).join();"
                        "document.getElementById('frame').focus()");
        browser_press(f->browser, KEY_RIGHT);
        wait_until(f->browser, "marks('*').length && marks('*').map(m => m.outerHTML).join() !== drawn");
        run(f->browser, "document.querySelector('#pass .chip').click()");
        assert_holds(f->browser, "!marks('*').length");
        assert_nothing_is_wrong(f);
    }
    open_page(f); /* where they are shown already, and nothing more is computed */
    run(f->browser, "press('passes')");
    draw_marks(f->browser, passes[2].title);
    run(f->browser, "press('passes'); press('reset')");
}

static void a_pass_steps_back_through_the_batches_so_far(void **state) {
    fixture *f = opened_page(state);
    use_method(f->browser, "multi-mesh");
    run(f->browser, "press('passes')");
    choose_pass(f->browser, "The picture");
    wait_until(f->browser, "document.getElementById('big-pass')");
    run(f->browser, "window.first = seen('big-pass'); document.getElementById('frame').focus()");
    for (int i = 0; i < 4; i++) browser_press(f->browser, KEY_RIGHT);
    wait_until(f->browser, "seen('big-pass') !== first && document.getElementById('past')?.value > 0");
    run(f->browser, "window.newest = seen('big-pass'); document.getElementById('past').focus();"
                    "choose('past', 0)");
    wait_until(f->browser, "seen('big-pass') !== newest");
    assert_holds(f->browser, "/after batch \\d+/.test(document.querySelector('#pass output').textContent)");
    run(f->browser, "window.oldest = seen('big-pass'); choose('past', document.getElementById('past').max)");
    wait_until(f->browser, "seen('big-pass') !== oldest");
    run(f->browser, "press('passes'); press('reset'); choose('method-a', 'direct-radiance')");
    assert_nothing_is_wrong(f);
}

static void a_reload_in_the_middle_of_a_drag_goes_on(void **state) {
    fixture *f = opened_page(state);
    remember(f->browser);
    drag_from(f->browser, "mouse", place_in(f->browser, ".handle.lamp", 0.5, 0.5), 50, 0, true);
    run(f->browser, "location.reload()");
    browser_release(f->browser);
    wait_until(f->browser, "document.querySelector('#frame.ready') && window.softlux?.world.scene");
    run(f->browser, tools);
    assert_holds(f->browser, "document.getElementById('connection').textContent === 'connected'");
    remember(f->browser);
    drag_from(f->browser, "mouse", place_in(f->browser, ".handle.lamp", 0.5, 0.5), -50, 0, false);
    wait_for_change(f->browser);
    run(f->browser, "press('undo'); press('undo')");
    wait_until(f->browser, "document.getElementById('undo').disabled");
    assert_nothing_is_wrong(f);
}

static void two_tabs_see_the_same(void **state) {
    fixture *f = opened_page(state);
    remember(f->browser);
    browser_open_tab(f->browser);
    open_page(f);
    wait_until(f->browser, "document.getElementById('viewers').textContent === '2 viewers'");
    drag_from(f->browser, "mouse", place_in(f->browser, "#frame", 0.5, 0.6), 60, 0, false);
    wait_until(f->browser, "softlux.world.scene");
    browser_turn_to_tab(f->browser, 0);
    wait_for_change(f->browser);
    wait_until(f->browser, "away(softlux.world.camera.eye, camera.eye) > 10");
    run(f->browser, "press('reset')");
    browser_turn_to_tab(f->browser, 1);
    wait_until(f->browser, "away(softlux.world.camera.eye, [278, 273, -800]) < 1");
    browser_go_to(f->browser, "about:blank"); /* leaves */
    browser_turn_to_tab(f->browser, 0);
    wait_until(f->browser, "document.getElementById('viewers').textContent === ''");
    assert_nothing_is_wrong(f);
}

/* Tab alone goes from control to control. */
static void tab_to(browser *b, const char *what) {
    char expression[300];
    snprintf(expression, sizeof expression, "document.activeElement.matches('%s')", what);
    for (int i = 0; i < 80 && !browser_holds(b, expression); i++) browser_press(b, KEY_TAB);
    assert_holds(b, expression);
    assert_holds(b, "getComputedStyle(document.activeElement).outlineStyle !== 'none' || "
                    "document.activeElement.matches('#tools input, #line')");
}

static void keys_alone_reach_everything(void **state) {
    fixture *f = opened_page(state);
    remember(f->browser);
    tab_to(f->browser, "#frame");
    browser_press(f->browser, KEY_RIGHT);
    wait_for_change(f->browser);
    tab_to(f->browser, ".handle.lamp");
    browser_press(f->browser, KEY_RIGHT);
    wait_until(f->browser, "away(softlux.world.scene.lights[0].position, lamp) > 1");
    tab_to(f->browser, "#reset");
    browser_press(f->browser, KEY_ENTER);
    tab_to(f->browser, "#tab-method, #tab-scene");
    browser_press(f->browser, KEY_RIGHT);
    tab_to(f->browser, "#things [role=option], #ask-pixel");
    run(f->browser, "press('undo')");
    wait_until(f->browser, "document.getElementById('undo').disabled");
    assert_nothing_is_wrong(f);
}

static void a_screen_of_360_pixels_needs_no_sideways_scrolling(void **state) {
    fixture *f = *state;
    need_browser(f);
    browser_screen(f->browser, 360, 740);
    open_page(f);
    run(f->browser, "choose('method-b', 'splatting')");
    wait_until(f->browser, "document.querySelector('#frame.split')");
    assert_holds(f->browser, "document.getElementById('frame').getBoundingClientRect().width > 250");
    static const char *const tabs[] = {"method", "scene", "pixel", "keep", "log"};
    for (size_t i = 0; i < sizeof tabs / sizeof tabs[0]; i++) {
        char script[100];
        snprintf(script, sizeof script, "press('tab-%s')", tabs[i]);
        run(f->browser, script);
        assert_holds(f->browser, "document.documentElement.scrollWidth <= 360");
    }
    run(f->browser, "choose('method-b', '')");
    browser_screen(f->browser, 0, 0);
    assert_nothing_is_wrong(f);
}

static void it_is_dark_where_the_desk_is_and_light_elsewhere(void **state) {
    fixture *f = *state;
    need_browser(f);
    const char brightness[] = "return getComputedStyle(document.body).backgroundColor.match(/\\d+/g)"
                              ".slice(0, 3).reduce((s, v) => s + Number(v), 0) / 3";
    browser_colours(f->browser, true);
    open_page(f);
    assert_true(browser_number(f->browser, brightness) < 60.0);
    browser_colours(f->browser, false);
    assert_true(browser_number(f->browser, brightness) > 200.0);
    assert_nothing_is_wrong(f);
}

int main(int argc, char **argv) {
    const char *slash = strrchr(argv[0], '/');
    snprintf(program, sizeof program, "%.*s/../softlux", slash ? (int)(slash - argv[0]) : 1,
             slash ? argv[0] : ".");
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_page_opens_with_a_picture_and_hides_its_token),
        cmocka_unit_test(the_picture_follows_mouse_fingers_and_keys),
        cmocka_unit_test(a_lamp_that_is_dragged_lights_from_where_it_is_then),
        cmocka_unit_test(what_is_picked_gets_another_colour_and_goes_elsewhere),
        cmocka_unit_test(a_lamp_is_added_and_taken_away),
        cmocka_unit_test(every_method_shows_a_picture_of_its_own),
        cmocka_unit_test(two_methods_stand_under_one_line_that_moves),
        cmocka_unit_test(reference_difference_and_error_stand_beside),
        cmocka_unit_test(the_story_of_a_pixel_adds_up_to_it),
        cmocka_unit_test(the_exact_picture_is_that_of_the_command_which_the_page_tells),
        cmocka_unit_test(a_pass_draws_its_marks_over_the_picture),
        cmocka_unit_test(a_pass_steps_back_through_the_batches_so_far),
        cmocka_unit_test(a_reload_in_the_middle_of_a_drag_goes_on),
        cmocka_unit_test(two_tabs_see_the_same),
        cmocka_unit_test(keys_alone_reach_everything),
        cmocka_unit_test(a_screen_of_360_pixels_needs_no_sideways_scrolling),
        cmocka_unit_test(it_is_dark_where_the_desk_is_and_light_elsewhere),
    };
    return cmocka_run_group_tests(tests, open_all, close_all);
}
