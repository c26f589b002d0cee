/* The stage of `softlux serve`, led by messages without a network: what viewers are told and shown, what
 * edits do and undo, that logs give the live picture's bits and exact pictures those of `render`. */
#include "unit_test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "app/clock.h"
#include "app/serve/stage_parts.h"
#include "base/memory.h"
#include "image/formats.h"
#include "rendering.h"
#include "scene_files.h"

static const char scene_path[] = "scenes/cornell-glossy.json", moving_path[] = "scenes/moving-ball.json";
enum { SIZE = 48, VIEWER = 7, BALL = 6 };

typedef struct house {
    sl_mail mail;
    sl_stage *stage;
    sl_reading reading;
    char folder[4096];
    sl_packet *packets; /* not looked at yet */
} house;

static int open_house_of(void **state, const char *path) {
    static house h;
    memset(&h, 0, sizeof h);
    sl_error error;
    snprintf(h.folder, sizeof h.folder, "%s", scene_file_path("kept"));
    sl_stage_options o = {.scene_path = path,
                          .reading = &h.reading,
                          .settings = sl_settings_default(),
                          .folder = h.folder,
                          .token = "token"};
    o.settings.method = "direct-radiance";
    o.settings.quality = SL_QUALITY_DRAFT;
    o.settings.width = o.settings.height = SIZE;
    if (!sl_mail_open(&h.mail) || sl_stage_open(&o, &h.mail, &h.stage, &error) != SL_OK) return 1;
    sl_stage_take(h.stage, (sl_letter){VIEWER, SL_LETTER_JOINED, NULL});
    *state = &h;
    return 0;
}

static int open_house(void **state) { return open_house_of(state, scene_path); }
static int open_moving_house(void **state) { return open_house_of(state, moving_path); }

static int close_house(void **state) {
    house *h = *state;
    sl_stage_close(h->stage);
    for (sl_packet *p = h->packets, *next; p; p = next) {
        next = p->next;
        free(p);
    }
    sl_mail_close(&h->mail);
    return scene_files_remove();
}

static void say(house *h, const char *text) {
    cJSON *message = cJSON_Parse(text);
    assert_non_null(message);
    sl_stage_take(h->stage, (sl_letter){VIEWER, SL_LETTER_MESSAGE, message});
}

/* The next packet, which the caller frees; NULL: there was none for so long. */
static sl_packet *next_packet(house *h, double seconds) {
    for (const double end = sl_seconds_now() + seconds; !h->packets;) {
        h->packets = sl_mail_collect(&h->mail);
        if (h->packets) break;
        if (sl_seconds_now() > end) return NULL;
        sl_sleep_until(sl_seconds_now() + fmin(sl_stage_step(h->stage), 0.02));
    }
    sl_packet *p = h->packets;
    h->packets = p->next;
    return p;
}

static cJSON *message_in(const sl_packet *p) {
    if (p->slot >= 0 || p->ends) return NULL;
    return cJSON_ParseWithLength((const char *)p->bytes + SL_PACKET_ROOM, p->size);
}

static bool is(const cJSON *message, const char *what) {
    const char *text = cJSON_GetStringValue(cJSON_GetObjectItem(message, "is"));
    return text && strcmp(text, what) == 0;
}

/* The next message of that kind, which the caller deletes. */
static cJSON *await(house *h, const char *what) {
    for (sl_packet *p; (p = next_packet(h, 60.0)) != NULL;) {
        cJSON *message = message_in(p);
        free(p);
        if (is(message, "refused") && strcmp(what, "refused") != 0)
            fail_msg("refused: %s", cJSON_GetStringValue(cJSON_GetObjectItem(message, "reason")));
        if (is(message, what)) return message;
        cJSON_Delete(message);
    }
    fail_msg("no %s", what);
    return NULL;
}

static cJSON *answer_to(house *h, const char *text, const char *what) {
    say(h, text);
    return await(h, what);
}

static uint64_t value_at(const sl_packet *p, int place, int bytes) {
    uint64_t value = 0;
    for (int i = 0; i < bytes; i++) value |= (uint64_t)p->bytes[SL_PACKET_ROOM + place + i] << (8 * i);
    return value;
}

/* Waits for a picture of that kind that shows the event. */
static void await_picture(house *h, sl_frame_kind kind, uint64_t event) {
    for (sl_packet *p; (p = next_packet(h, 60.0)) != NULL;) {
        const bool right = p->slot >= 0 && value_at(p, 4, 1) == (uint64_t)kind && value_at(p, 16, 8) >= event;
        if (right) assert_memory_equal(p->bytes + SL_PACKET_ROOM, "SLFR", 4);
        if (right && kind != SL_FRAME_PASS) { /* maps are as large as they are */
            assert_int_equal(value_at(p, 12, 2), SIZE);
            assert_int_equal(value_at(p, 14, 2), SIZE);
        }
        free(p);
        if (right) return;
    }
    fail_msg("no picture of kind %d that shows event %d", (int)kind, (int)event);
}

static double number_in(const cJSON *o, const char *name) {
    const cJSON *item = cJSON_GetObjectItem(o, name);
    assert_true(cJSON_IsNumber(item));
    return item->valuedouble;
}

static void newcomers_are_told_of_the_scene_the_methods_and_all_settings(void **state) {
    cJSON *hello = await(*state, "hello");
    const cJSON *scene = cJSON_GetObjectItem(hello, "scene");
    int settings = 0;
    while (sl_setting_at((size_t)settings)) settings++;
    assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(hello, "settings")), settings);
    assert_true(cJSON_GetArraySize(cJSON_GetObjectItem(scene, "objects")) > 5);
    assert_true(cJSON_GetArraySize(cJSON_GetObjectItem(scene, "materials")) > 3);
    assert_true(cJSON_GetArraySize(cJSON_GetObjectItem(hello, "methods")) >= 7);
    cJSON_Delete(hello);
    await_picture(*state, SL_FRAME_A, 0);
}

static void every_method_shows_the_camera_that_stays_and_one_that_moves(void **state) {
    house *h = *state;
    for (size_t i = 0; sl_method_name(i); i++) {
        char text[200];
        if (strcmp(sl_method_name(i), "auto") == 0) continue;
        snprintf(text, sizeof text, "{\"do\":\"method\",\"name\":\"%s\"}", sl_method_name(i));
        cJSON *told = answer_to(h, text, "method");
        assert_string_equal(cJSON_GetStringValue(cJSON_GetObjectItem(told, "name")), sl_method_name(i));
        cJSON_Delete(told);
        await_picture(h, SL_FRAME_A, i);
        snprintf(text, sizeof text, "{\"do\":\"camera\",\"eye\":[%d,270,-790],\"target\":[278,273,280]}",
                 270 + (int)i);
        say(h, text);
        await_picture(h, SL_FRAME_A, i + 1);
    }
}

static void two_methods_stand_side_by_side_and_one_goes_again(void **state) {
    house *h = *state;
    say(h, "{\"do\":\"method\",\"side\":\"b\",\"name\":\"light-octree\",\"settings\":{\"depth\":4}}");
    await_picture(h, SL_FRAME_B, 0);
    cJSON_Delete(answer_to(h, "{\"do\":\"method\",\"side\":\"b\",\"name\":\"\"}", "method"));
    cJSON_Delete(answer_to(h, "{\"do\":\"story\",\"side\":\"b\",\"x\":1,\"y\":1}", "refused"));
}

static double red_of_material(const cJSON *scene, int material) {
    const cJSON *m = cJSON_GetArrayItem(cJSON_GetObjectItem(scene, "materials"), material - 1);
    return cJSON_GetArrayItem(cJSON_GetObjectItem(m, "diffuse"), 0)->valuedouble;
}

static void a_drag_is_undone_in_one_step_and_done_again(void **state) {
    house *h = *state;
    cJSON *scene;
    for (int i = 1; i <= 3; i++) {
        char text[200];
        snprintf(text, sizeof text,
                 "{\"do\":\"edit\",\"edits\":[{\"kind\":\"material\",\"material\":2,\"diffuse\":[0.%d,0.5,0."
                 "5]}]%s}",
                 i, i < 3 ? ",\"drag\":true" : "");
        say(h, text);
    }
    scene = await(h, "scene");
    assert_float_equal(red_of_material(scene, 2), 0.3, 1e-6);
    assert_int_equal(number_in(scene, "undo"), 1);
    cJSON_Delete(scene);
    scene = answer_to(h, "{\"do\":\"undo\"}", "scene");
    assert_float_equal(red_of_material(scene, 2), 0.73, 0.05);
    assert_int_equal(number_in(scene, "redo"), 1);
    cJSON_Delete(scene);
    scene = answer_to(h, "{\"do\":\"redo\"}", "scene");
    assert_float_equal(red_of_material(scene, 2), 0.3, 1e-6);
    cJSON_Delete(scene);
    cJSON_Delete(answer_to(h, "{\"do\":\"redo\"}", "refused"));
}

static void a_lamp_that_is_added_and_undone_is_dark_and_comes_back(void **state) {
    house *h = *state;
    const char *const steps[] = {"{\"do\":\"edit\",\"edits\":[{\"kind\":\"add-light\",\"position\":[278,400,"
                                 "250],\"power\":[9e4,9e4,9e4]}]}",
                                 "{\"do\":\"undo\"}", "{\"do\":\"redo\"}",
                                 "{\"do\":\"edit\",\"edits\":[{\"kind\":\"remove-light\",\"light\":1}]}"};
    const double powers[] = {9e4, 0.0, 9e4, 0.0};
    for (int i = 0; i < 4; i++) {
        cJSON *scene = answer_to(h, steps[i], "scene");
        const cJSON *lights = cJSON_GetObjectItem(scene, "lights");
        assert_int_equal(cJSON_GetArraySize(lights), 1);
        const cJSON *power = cJSON_GetObjectItem(cJSON_GetArrayItem(lights, 0), "power");
        assert_float_equal(cJSON_GetArrayItem(power, 0)->valuedouble, powers[i], 1.0);
        cJSON_Delete(scene);
    }
}

static void what_is_picked_is_the_object_there(void **state) {
    house *h = *state;
    cJSON *picked = answer_to(h, "{\"do\":\"pick\",\"x\":24,\"y\":46}", "picked");
    assert_string_equal(cJSON_GetStringValue(cJSON_GetObjectItem(picked, "name")), "floor");
    assert_float_equal(cJSON_GetArrayItem(cJSON_GetObjectItem(picked, "normal"), 1)->valuedouble, 1.0, 1e-6);
    cJSON_Delete(picked);
}

static void a_story_adds_up_to_its_pixel_and_shows_the_source(void **state) {
    house *h = *state;
    await_picture(h, SL_FRAME_A, 0);
    cJSON *story = answer_to(h, "{\"do\":\"story\",\"x\":20,\"y\":40}", "story"), *term;
    for (int c = 0; c < 3; c++) {
        double sum = cJSON_GetArrayItem(cJSON_GetObjectItem(story, "rounding"), c)->valuedouble;
        cJSON_ArrayForEach(term, cJSON_GetObjectItem(story, "terms")) sum +=
            cJSON_GetArrayItem(cJSON_GetObjectItem(term, "contribution"), c)->valuedouble;
        const double pixel = cJSON_GetArrayItem(cJSON_GetObjectItem(story, "pixel"), c)->valuedouble;
        assert_true(pixel > 0.0);
        assert_float_equal(sum, pixel, 1e-12);
    }
    const cJSON *pass = cJSON_GetArrayItem(cJSON_GetObjectItem(story, "passes"), 0);
    const cJSON *text = cJSON_GetObjectItem(cJSON_GetObjectItem(pass, "source"), "text");
    assert_non_null(strstr(cJSON_GetStringValue(text), "sl_"));
    cJSON_Delete(story);
}

static void passes_come_with_their_pictures_and_marks(void **state) {
    house *h = *state;
    say(h, "{\"do\":\"method\",\"name\":\"splatting\"}");
    cJSON *pass = answer_to(h, "{\"do\":\"passes\",\"on\":true}", "pass");
    while (number_in(pass, "marks") == 0.0) {
        cJSON_Delete(pass);
        pass = await(h, "pass");
    }
    cJSON_Delete(pass);
    cJSON *overlay = answer_to(h, "{\"do\":\"overlay\",\"kind\":\"records\"}", "overlay");
    assert_non_null(strstr(cJSON_GetStringValue(cJSON_GetObjectItem(overlay, "svg")), "<circle"));
    cJSON_Delete(overlay);
}

static void who_asks_for_passes_that_are_shown_gets_them_and_starts_nothing_anew(void **state) {
    house *h = *state;
    say(h, "{\"do\":\"passes\",\"on\":true}");
    await_picture(h, SL_FRAME_PASS, 0);
    for (bool done = false; !done;) {
        cJSON *told = await(h, "state");
        done = cJSON_IsTrue(cJSON_GetObjectItem(told, "done"));
        cJSON_Delete(told);
    }
    for (sl_packet *p; (p = next_packet(h, 1.0)) != NULL;) free(p);
    cJSON *pass = answer_to(h, "{\"do\":\"passes\",\"on\":true}", "pass");
    assert_true(number_in(pass, "times") >= 1.0);
    cJSON_Delete(pass);
    await_picture(h, SL_FRAME_PASS, 0);
    assert_true(h->stage->side[0].last.done);
}

/* A method that takes a while to be made, and whose samples take a while, is switched to and away from. */
static void who_comes_is_greeted_at_once_whatever_method_is_being_made(void **state) {
    house *h = *state;
    sl_packet *picture;
    cJSON_Delete(await(h, "hello"));
    say(h, "{\"do\":\"size\",\"width\":512,\"height\":512}");
    const double begun = sl_seconds_now();
    say(h, "{\"do\":\"method\",\"name\":\"splatting\"}");
    say(h, "{\"do\":\"method\",\"name\":\"path\"}");
    say(h, "{\"do\":\"method\",\"name\":\"splatting\"}");
    sl_stage_take(h->stage, (sl_letter){VIEWER + 1, SL_LETTER_JOINED, NULL});
    cJSON_Delete(await(h, "hello"));
    const double greeted = sl_seconds_now() - begun;
    while ((picture = next_packet(h, 60.0)) != NULL && picture->slot < 0) free(picture);
    assert_non_null(picture);
    free(picture);
    const double shown = sl_seconds_now() - begun;
    if (greeted > 0.15 * shown) fail_msg("greeted after %.2f of %.2f s", greeted, shown);
}

static void an_edit_tells_what_was_kept(void **state) {
    house *h = *state;
    say(h, "{\"do\":\"method\",\"name\":\"multi-mesh\"}");
    await_picture(h, SL_FRAME_A, 0);
    say(h, "{\"do\":\"edit\",\"edits\":[{\"kind\":\"material\",\"material\":6,\"emission\":[9,9,9]}]}");
    for (bool kept = false; !kept;) {
        cJSON *told = await(h, "state");
        const cJSON *of = cJSON_GetObjectItem(told, "kept");
        kept = of && number_in(of, "event") == 1.0;
        if (kept) assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(of, "changes")), 1);
        cJSON_Delete(told);
    }
}

static void what_is_malformed_ends_its_connection_with_a_reason(void **state) {
    house *h = *state;
    const char *const bad[] = {"{\"do\":\"nothing\"}",
                               "{\"do\":\"camera\",\"eye\":[1,2],\"target\":[0,0,0]}",
                               "{\"do\":\"camera\",\"eye\":[1,2,\"x\"],\"target\":[0,0,0]}",
                               "{\"do\":\"edit\",\"edits\":{}}",
                               "{\"do\":\"edit\",\"edits\":[{\"kind\":\"planet\"}]}",
                               "{\"do\":\"edit\",\"edits\":[{\"kind\":\"object\",\"object\":1}]}",
                               "{\"do\":\"keep\",\"what\":\"/etc/passwd\"}",
                               "{\"do\":\"method\",\"side\":\"c\",\"name\":\"path\"}",
                               "{\"do\":\"story\",\"x\":true,\"y\":1}",
                               "{\"do\":\"method\",\"name\":\"path\",\"settings\":{\"spp\":[1]}}"};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        bool ended = false;
        say(h, bad[i]);
        for (sl_packet *p; !ended && (p = next_packet(h, 1.0)) != NULL;) {
            ended = p->ends && p->client == VIEWER && p->size > 5;
            free(p);
        }
        if (!ended) fail_msg("goes on after %s", bad[i]);
    }
}

static void what_cannot_be_is_refused_and_changes_nothing(void **state) {
    house *h = *state;
    const char *const bad[] = {
        "{\"do\":\"camera\",\"eye\":[1,2,3],\"target\":[1,2,3]}",
        "{\"do\":\"size\",\"width\":100000,\"height\":16}",
        "{\"do\":\"method\",\"name\":\"magic\"}",
        "{\"do\":\"method\",\"name\":\"path\",\"settings\":{\"threads\":64}}",
        "{\"do\":\"edit\",\"edits\":[{\"kind\":\"object\",\"object\":99,\"matrix\":[1,0,0,0,0,1,0,0,0,0,1,0]}"
        "]}",
        "{\"do\":\"edit\",\"edits\":[{\"kind\":\"object\",\"object\":1,\"matrix\":[0,0,0,0,0,0,0,0,0,0,0,0]}]"
        "}",
        "{\"do\":\"edit\",\"edits\":[{\"kind\":\"material\",\"material\":2,\"diffuse\":[2,0,0]}]}",
        "{\"do\":\"edit\",\"edits\":[{\"kind\":\"sun\",\"direction\":[0,-1,0]}]}",
        "{\"do\":\"play\",\"on\":true}",
        "{\"do\":\"undo\"}"};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        cJSON_Delete(answer_to(h, bad[i], "refused"));
    }
    cJSON *did = answer_to(h, "{\"do\":\"tone\",\"exposure\":1,\"auto\":false}", "did");
    assert_int_equal(number_in(did, "event"), 0);
    cJSON_Delete(did);
}

static void edit_at_random(house *h, int i) {
    char text[400];
    snprintf(
        text, sizeof text,
        "{\"do\":\"edit\",\"drag\":true,\"edits\":[{\"kind\":\"object\",\"object\":6,\"matrix\":"
        "[1,0,0,%d,0,1,0,0,0,0,1,%d]},{\"kind\":\"material\",\"material\":3,\"diffuse\":[0.%d,0.2,0.7]}]}",
        i, 2 * i, 1 + i % 9);
    say(h, text);
    snprintf(text, sizeof text, "{\"do\":\"camera\",\"eye\":[%d,270,-790],\"target\":[278,273,280]}",
             270 + i);
    say(h, text);
}

/* The kept log's path. */
static void keep_log(house *h, char path[4096]) {
    cJSON *kept = answer_to(h, "{\"do\":\"keep\",\"what\":\"log\"}", "kept");
    snprintf(path, 4096, "%.3800s/%s", h->folder, cJSON_GetStringValue(cJSON_GetObjectItem(kept, "name")));
    cJSON_Delete(kept);
}

static void assert_same_colours(const sl_image *a, const sl_image *b) {
    assert_true(comparison_of(a, b).identical);
}

/* Tells whether a log, replayed, gives the picture that was kept beside it. */
static bool gives_picture(house *h, const char *log, const char *path) {
    char picture[4096];
    sl_image *kept, *replayed;
    sl_error error;
    if (sl_log_replay(log, path, &h->reading, 0, &replayed, &error) != SL_OK) fail_msg("%s", error.message);
    snprintf(picture, sizeof picture, "%.*s-a.exr", (int)strlen(log) - 5, log);
    assert_int_equal(sl_image_read(picture, &kept, &error), SL_OK);
    const bool identical = comparison_of(kept, replayed).identical;
    destroy_pictures(kept, replayed);
    return identical;
}

static void assert_log_gives_the_picture(house *h, const char *path) {
    char log[4096];
    keep_log(h, log);
    assert_true(gives_picture(h, log, path));
}

static void a_log_gives_the_live_pictures_bits(void **state) {
    house *h = *state;
    static const char *const methods[] = {"shading-cache", "multi-mesh", "splatting", "light-octree"};
    for (int m = 0; m < 4; m++) {
        char text[200];
        snprintf(text, sizeof text, "{\"do\":\"method\",\"name\":\"%s\"}", methods[m]);
        say(h, text);
        await_picture(h, SL_FRAME_A, 0);
        for (int i = 0; i < 8; i++) {
            edit_at_random(h, i + 8 * m);
            sl_sleep_until(sl_seconds_now() + 0.02);
        }
        assert_log_gives_the_picture(h, scene_path);
    }
}

/* Rates come of the clock: only the log has them. */
static void a_log_has_the_rates_that_a_method_was_told_of(void **state) {
    house *h = *state;
    const sl_rate *rate = &h->stage->side[0].rate;
    say(h, "{\"do\":\"method\",\"name\":\"shading-cache\"}");
    await_picture(h, SL_FRAME_A, 0);
    for (int i = 0, more = 8; more > 0 && i < 400; i++) {
        edit_at_random(h, i % 50);
        sl_stage_step(h->stage);
        sl_sleep_until(sl_seconds_now() + 0.05);
        more -= rate->told > 0.0;
    }
    print_message("%.0f samples a second\n", rate->told);
    assert_true(rate->told > 0.0);
    char path[4096], *text;
    keep_log(h, path);
    assert_true(gives_picture(h, path, scene_path));

    /* a slow machine would have had coarser patches */
    sl_bytes bytes;
    assert_int_equal(sl_bytes_read(path, 1 << 24, &bytes, NULL), SL_OK);
    cJSON *log = cJSON_ParseWithLength((const char *)bytes.data, bytes.size),
          *show = cJSON_GetArrayItem(cJSON_GetObjectItem(log, "shows"), 0);
    assert_true(cJSON_GetArraySize(cJSON_GetObjectItem(show, "rates")) > 0);
    cJSON_ReplaceItemInObject(show, "rates", cJSON_Parse("[[0, 20]]"));
    text = cJSON_Print(log);
    assert_int_equal(sl_output_whole(path, text, strlen(text), NULL), SL_OK);
    assert_false(gives_picture(h, path, scene_path));
    cJSON_free(text);
    cJSON_Delete(log);
    sl_free(bytes.data);
}

/* Of the ball that keyframes move: its matrix, where the page is told that its middle is. */
static void await_ball(house *h, double rows[12], double centre[3]) {
    cJSON *scene = await(h, "scene"), *o;
    bool there = false;
    cJSON_ArrayForEach(o, cJSON_GetObjectItem(scene, "objects")) {
        if (strcmp(cJSON_GetStringValue(cJSON_GetObjectItem(o, "name")), "ball") != 0) continue;
        there = true;
        for (int k = 0; k < 12; k++)
            rows[k] = cJSON_GetArrayItem(cJSON_GetObjectItem(o, "matrix"), k)->valuedouble;
        for (int k = 0; k < 3; k++)
            centre[k] = cJSON_GetArrayItem(cJSON_GetObjectItem(o, "centre"), k)->valuedouble;
    }
    assert_true(there);
    cJSON_Delete(scene);
}

static void say_ball(house *h, const double m[12], const char *more) {
    char text[600];
    snprintf(text, sizeof text,
             "{\"do\":\"edit\",\"edits\":[{\"kind\":\"object\",\"object\":%d,\"matrix\":[%.17g,%.17g,%.17g,"
             "%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g]}]%s}",
             BALL, m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8], m[9], m[10], m[11], more);
    say(h, text);
}

static void what_keyframes_move_is_dragged_from_where_it_is_and_given_back_to_them(void **state) {
    house *h = *state;
    double matrix[12], before[3], now[3];
    say(h, "{\"do\":\"time\",\"at\":2}");
    await_ball(h, matrix, before);
    assert_float_equal(before[0], 420.0, 0.5);
    for (int i = 0; i < 3; i++) {
        matrix[3] += 5.0;
        say_ball(h, matrix, i < 2 ? ",\"drag\":true" : "");
    }
    await_ball(h, matrix, now);
    assert_true(fabs(now[0] - before[0] - 15.0) < 0.01);
    assert_float_equal(now[1], before[1], 0.01);
    say(h, "{\"do\":\"undo\"}");
    await_ball(h, matrix, now);
    for (int k = 0; k < 3; k++) assert_float_equal(now[k], before[k], 1e-9);
    say(h, "{\"do\":\"time\",\"at\":3}");
    await_ball(h, matrix, now);
    assert_float_equal(now[0], 150.0, 0.5);
    say(h, "{\"do\":\"redo\"}");
    await_ball(h, matrix, now);
    assert_true(fabs(now[0] - before[0] - 15.0) < 0.01);
    say(h, "{\"do\":\"edit\",\"edits\":[{\"kind\":\"object\",\"object\":6,\"matrix\":null}]}");
    await_ball(h, matrix, now);
    assert_float_equal(now[0], 150.0, 0.5);
    assert_log_gives_the_picture(h, moving_path);
}

/* The file behind an address. */
static void file_at(house *h, const cJSON *message, const char *name, char path[4096]) {
    const char *address = cJSON_GetStringValue(cJSON_GetObjectItem(message, name));
    assert_non_null(address);
    assert_true(sl_mail_offered(&h->mail, strtoul(strrchr(address, '/') + 1, NULL, 10), path, 4096));
}

static cJSON *await_exact(house *h) {
    cJSON *told = await(h, "exact");
    while (!cJSON_IsTrue(cJSON_GetObjectItem(told, "done"))) {
        cJSON_Delete(told);
        told = await(h, "exact");
    }
    return told;
}

static void an_exact_picture_that_is_asked_for_again_is_told_of_once_it_is_there(void **state) {
    house *h = *state;
    char first[4096], second[4096];
    snprintf(first, sizeof first, "%.3800s/exact-1.png", h->folder);
    say(h, "{\"do\":\"exact\"}");
    for (int i = 0; i < 2000 && access(first, F_OK) != 0; i++) sl_sleep_until(sl_seconds_now() + 0.01);
    sl_sleep_until(sl_seconds_now() + 0.2); /* it is done, and nobody has looked */
    say(h, "{\"do\":\"method\",\"name\":\"splatting\"}");
    say(h, "{\"do\":\"exact\"}");
    cJSON *told = await_exact(h);
    file_at(h, told, "png", second);
    assert_int_equal(access(second, F_OK), 0);
    cJSON_Delete(told);
}

static void an_exact_picture_has_the_bits_of_a_render_of_the_scene_that_is_kept(void **state) {
    house *h = *state;
    char exact[4096], scene_file[4096];
    edit_at_random(h, 5);
    say(h, "{\"do\":\"exact\"}");
    cJSON *told = await_exact(h);
    file_at(h, told, "exr", exact);
    const char *command = cJSON_GetStringValue(cJSON_GetObjectItem(told, "command"));
    assert_int_equal(sscanf(command, "softlux render %4000s", scene_file), 1);
    sl_settings settings = sl_settings_default();
    settings.method = "direct-radiance", settings.quality = SL_QUALITY_DRAFT;
    settings.width = settings.height = SIZE;
    sl_scene *scene = load_scene(scene_file);
    sl_image *picture = render(scene, &settings, NULL), *kept;
    assert_int_equal(sl_image_read(exact, &kept, NULL), SL_OK);
    assert_same_colours(kept, picture);
    sl_image_destroy(kept);
    destroy_picture(picture, scene);
    cJSON_Delete(told);
    await_picture(h, SL_FRAME_EXACT, 0);
}

static void a_reference_grows_and_tells_the_error(void **state) {
    house *h = *state;
    say(h, "{\"do\":\"reference\",\"on\":true}");
    say(h, "{\"do\":\"difference\",\"on\":true}");
    say(h, "{\"do\":\"error\",\"on\":true}");
    await_picture(h, SL_FRAME_REFERENCE, 0);
    await_picture(h, SL_FRAME_DIFFERENCE, 0);
    cJSON *error = await(h, "error");
    assert_in_range(number_in(error, "error") * 1e6, 1, 10e6);
    cJSON_Delete(error);
}

static void what_is_kept_is_offered_by_a_number(void **state) {
    house *h = *state;
    char path[4096];
    static const char *const kinds[] = {"scene", "page", "png"};
    for (int i = 0; i < 3; i++) {
        char text[100];
        snprintf(text, sizeof text, "{\"do\":\"keep\",\"what\":\"%s\"}", kinds[i]);
        cJSON *kept = answer_to(h, text, "kept");
        assert_true(number_in(kept, "bytes") > 100.0);
        file_at(h, kept, "href", path);
        assert_memory_equal(path, h->folder, strlen(h->folder));
        cJSON_Delete(kept);
    }
    assert_false(sl_mail_offered(&h->mail, 100, path, sizeof path));
}

static void nobody_is_drawn_for_when_all_have_left(void **state) {
    house *h = *state;
    await_picture(h, SL_FRAME_A, 0);
    sl_stage_take(h->stage, (sl_letter){VIEWER, SL_LETTER_LEFT, NULL});
    while (h->packets || (h->packets = sl_mail_collect(&h->mail)) != NULL) free(next_packet(h, 0.0));
    say(h, "{\"do\":\"camera\",\"eye\":[270,270,-790],\"target\":[278,273,280]}");
    free(next_packet(h, 0.0)); /* what was done */
    assert_null(next_packet(h, 0.2));
    sl_stage_take(h->stage, (sl_letter){VIEWER, SL_LETTER_JOINED, NULL});
    await_picture(h, SL_FRAME_A, 1);
}

#define HOUSE(test) cmocka_unit_test_setup_teardown(test, open_house, close_house)

int main(void) {
    const struct CMUnitTest tests[] = {
        HOUSE(newcomers_are_told_of_the_scene_the_methods_and_all_settings),
        HOUSE(every_method_shows_the_camera_that_stays_and_one_that_moves),
        HOUSE(two_methods_stand_side_by_side_and_one_goes_again),
        HOUSE(a_drag_is_undone_in_one_step_and_done_again),
        HOUSE(a_lamp_that_is_added_and_undone_is_dark_and_comes_back),
        HOUSE(what_is_picked_is_the_object_there),
        HOUSE(a_story_adds_up_to_its_pixel_and_shows_the_source),
        HOUSE(passes_come_with_their_pictures_and_marks),
        HOUSE(who_asks_for_passes_that_are_shown_gets_them_and_starts_nothing_anew),
        HOUSE(who_comes_is_greeted_at_once_whatever_method_is_being_made),
        HOUSE(an_edit_tells_what_was_kept),
        HOUSE(what_is_malformed_ends_its_connection_with_a_reason),
        HOUSE(what_cannot_be_is_refused_and_changes_nothing),
        HOUSE(a_log_gives_the_live_pictures_bits),
        HOUSE(a_log_has_the_rates_that_a_method_was_told_of),
        cmocka_unit_test_setup_teardown(
            what_keyframes_move_is_dragged_from_where_it_is_and_given_back_to_them, open_moving_house,
            close_house),
        HOUSE(an_exact_picture_that_is_asked_for_again_is_told_of_once_it_is_there),
        HOUSE(an_exact_picture_has_the_bits_of_a_render_of_the_scene_that_is_kept),
        HOUSE(a_reference_grows_and_tells_the_error),
        HOUSE(what_is_kept_is_offered_by_a_number),
        HOUSE(nobody_is_drawn_for_when_all_have_left),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
