/* softlux live: a scene that moves, shown as it comes, while a thread of its own works on the light. */
#include "app/auto_method.h"
#include "app/clock.h"
#include "app/commands.h"
#include "app/show_files.h"
#include "app/memory_limit.h"
#include "app/options.h"
#include "app/page.h"
#include "app/rate.h"
#include "app/same_file.h"
#include "base/error.h"
#include "cache/frame/method.h"
#include "scene/features.h"

#include <stdio.h>
#include <string.h>

typedef struct show_options {
    const char *scene_path, *output;
    double seconds, at, frames_per_second, exposure;
    uint64_t frames;
    bool exposure_given, json, quiet;
    int tone;
    sl_settings settings;
    sl_reading reading;
} show_options;

static bool parse(int argc, char **argv, show_options *o, int *status) {
    *o = (show_options){.tone = SL_TONE_REINHARD,
                        .seconds = 5.0,
                        .frames_per_second = 25.0,
                        .settings = sl_settings_of_papers()};
    o->settings.method = "shading-cache";
    const sl_option options[] = {
        SL_TEXT("output", 'o', &o->output, "FILES",
                "frame-%04d.png, or show.y4m, or - for such a stream [nothing is written]"),
        SL_REAL("seconds", &o->seconds, NULL, "S", 1e-3, 1e9, "how long [5]"),
        SL_NUMBER("frames", 0, &o->frames, "N", 1, 1e12, "or how many frames, however long they take"),
        SL_REAL("at", &o->at, NULL, "SECONDS", -1e9, 1e9, "time of the scene to begin with [0]"),
        SL_REAL("fps", &o->frames_per_second, NULL, "F", 0, 1e4,
                "frames a second; 0: as many as can be [25]"),
        SL_REAL("exposure", &o->exposure, &o->exposure_given, "STOPS", -64, 64,
                "times 2^STOPS [that of the first picture with light]"),
        SL_CHOICE("tone", &o->tone, "CURVE", "clip|reinhard", "clip or reinhard [reinhard]"),
        SL_FLAG("json", &o->json, "print what was done as one JSON object"),
        SL_FLAG("quiet", &o->quiet, "no report, no warnings"),
        {.name = NULL}};
    const sl_command_line line = {
        "softlux live SCENE [-o FILES] [options]",
        "Plays a scene's keyframes in real time: frames never wait for light, which comes from a thread of "
        "its own.",
        "The method is the shading cache where --method names no other: it alone shows what moves at once.\n"
        "What frames show depends on the clock; for the same pictures twice: softlux render --frames.\n"
        "Ctrl-C ends the show as its --seconds do: what was shown is whole, and the exit status 0.\n\n"
        "example: softlux live scenes/moving-light.json --seconds 10 -o - | ffplay -",
        options, 1, 1, &o->reading, &o->settings, NULL};
    int operands;
    return sl_options_parse(&line, argc, argv, &o->scene_path, &operands, status);
}

/* Frames stand in slots of 1/fps; one that comes late for its slot stands in the one that it comes in. */
typedef struct show {
    const show_options *o;
    int width, height;
    sl_live *live;
    sl_show_files files;
    sl_tone tone;
    double begin, seconds;
    uint64_t slot, frames, missed;
    double drawing, longest; /* seconds of the drawing thread, and by the clock */
    /* seconds from moves to frames that show what they have changed: their sum over last.changes_shown, and
     * the longest */
    double lag, longest_lag;
    sl_rate rate;
    sl_live_state last;
    sl_counters counters;
    sl_pass_times *stages;
} show;

/* ---- the account of a show: frames, updates, where the time of an update goes ---------------- */

static double a_second(uint64_t count, double seconds) {
    return seconds > 0.0 ? (double)count / seconds : 0.0;
}
static double each(double seconds, uint64_t count) { return count ? 1e3 * seconds / (double)count : 0.0; }

static cJSON *json_of(const show *r) {
    cJSON *root = cJSON_CreateObject();
    cJSON_AddItemToObject(root, "size", cJSON_CreateIntArray((const int[]){r->width, r->height}, 2));
    cJSON_AddStringToObject(root, "scene", r->o->scene_path);
    cJSON_AddStringToObject(root, "method", r->o->settings.method);
    cJSON_AddNumberToObject(root, "seconds", r->seconds);
    cJSON_AddNumberToObject(root, "frames", (double)r->frames);
    cJSON_AddNumberToObject(root, "missed", (double)r->missed);
    cJSON_AddNumberToObject(root, "frames_a_second", a_second(r->frames, r->seconds));
    cJSON_AddNumberToObject(root, "drawing_ms", each(r->drawing, r->frames));
    cJSON_AddNumberToObject(root, "longest_ms", 1e3 * r->longest);
    cJSON_AddNumberToObject(root, "updates", (double)r->last.updates);
    cJSON_AddNumberToObject(root, "updates_a_second", a_second(r->last.updates, r->seconds));
    cJSON_AddNumberToObject(root, "points_a_second",
                            a_second(r->counters.value[SL_COUNT_POINTS_SHADED], r->seconds));
    cJSON_AddNumberToObject(root, "samples_a_second", r->rate.told);
    cJSON_AddNumberToObject(root, "versions", (double)r->last.versions);
    cJSON_AddNumberToObject(root, "error_levels", r->last.error_levels);
    cJSON_AddNumberToObject(root, "changes_shown", (double)r->last.changes_shown);
    cJSON_AddNumberToObject(root, "lag_ms", each(r->lag, r->last.changes_shown));
    cJSON_AddNumberToObject(root, "longest_lag_ms", 1e3 * r->longest_lag);
    cJSON *stages = cJSON_AddObjectToObject(root, "stages_ms");
    for (int i = 0; i < r->stages->count; i++) {
        const sl_pass_time *s = &r->stages->pass[i];
        cJSON_AddNumberToObject(stages, s->name, each(s->seconds, s->times));
    }
    sl_json_add_counters(root, "counters", &r->counters, false);
    return root;
}

/* ---- the display loop ------------------------------------------------------------------------ */

static uint64_t slot_at(const show *s, double now) {
    return (uint64_t)((now - s->begin) * s->o->frames_per_second);
}

/* Waits for the next slot; returns how many there have been since the last one. */
static uint64_t next_slot(show *s) {
    double fps = s->o->frames_per_second;
    if (!(fps > 0.0) || s->frames == 0) return 1;
    sl_sleep_until(s->begin + (double)(s->slot + 1) / fps);
    uint64_t slot = slot_at(s, sl_seconds_now()), steps = slot > s->slot ? slot - s->slot : 1;
    s->slot += steps;
    s->missed += steps - 1;
    return steps;
}

static bool goes_on(const show *s) {
    if (sl_interrupted()) return false;
    return s->o->frames ? s->frames < s->o->frames : sl_seconds_now() - s->begin < s->o->seconds;
}

/* Notes how long a change of light took from its move to the frame that shows it, which is drawn by now.
 * Moves are made at the scene's time that the clock says. */
static void note_lag(show *s, uint64_t shown_before) {
    uint64_t more = s->last.changes_shown - shown_before;
    double lag = sl_seconds_now() - s->begin - (s->last.change_seconds - s->o->at);
    if (!more || !(lag > 0.0)) return;
    s->lag += lag * (double)more;
    s->longest_lag = lag > s->longest_lag ? lag : s->longest_lag;
}

static sl_status draw(show *s, const sl_image **frame, sl_error *error) {
    double start = sl_seconds_now(), cpu = sl_thread_seconds();
    uint64_t changes = s->last.changes_shown;
    sl_status status = sl_live_frame(s->live, frame, &s->last, error);
    double took = sl_seconds_now() - start;
    s->drawing += sl_thread_seconds() - cpu;
    s->longest = took > s->longest ? took : s->longest;
    s->frames += status == SL_OK;
    if (status == SL_OK) note_lag(s, changes);
    return status;
}

/* The clock starts with the first picture that has light; a display has frames at once. */
static sl_status await_light(show *s, sl_error *error) {
    const sl_image *frame;
    sl_live_state state = {0};
    sl_status status = SL_OK;
    while (status == SL_OK && !sl_interrupted() && !state.versions && !state.done) {
        status = sl_live_frame(s->live, &frame, &state, error);
        sl_sleep_until(sl_seconds_now() + 0.005);
    }
    return status;
}

static sl_status one_frame(show *s, sl_error *error) {
    const sl_image *frame;
    uint64_t steps = next_slot(s);
    double fps = s->o->frames_per_second,
           elapsed = fps > 0.0 ? (double)s->slot / fps : sl_seconds_now() - s->begin;
    sl_status status = sl_live_move(s->live, s->o->at + elapsed, error);
    if (status == SL_OK) status = draw(s, &frame, error);
    if (status == SL_OK)
        status = sl_rate_tell(&s->rate, s->live, &s->o->settings, &s->last, error);
    return status == SL_OK
               ? sl_show_files_write(&s->files, frame, &s->tone, s->last.versions > 0, steps, error)
               : status;
}

/* Tells whether passes are shown: their pictures are made then, and those are not in a method's account of
 * its memory. */
static bool are_stages_told(const show_options *o) {
    return !o->settings.memory_bytes && (o->json || !o->quiet);
}

static sl_status play(show *s, sl_scene *scene, sl_error *error) {
    sl_settings settings = s->o->settings;
    if (are_stages_told(s->o)) settings.observer = &s->stages->observer;
    sl_status status = sl_live_start(scene, &settings, &s->live, error);
    if (status == SL_OK && !s->o->quiet && *sl_live_reduction(s->live))
        fprintf(stderr, "softlux: to keep within --memory: %s\n", sl_live_reduction(s->live));
    if (status == SL_OK) status = await_light(s, error);
    s->begin = sl_seconds_now();
    while (status == SL_OK && goes_on(s)) status = one_frame(s, error);
    s->seconds = sl_seconds_now() - s->begin;
    sl_live_stop(s->live, &s->counters);
    return status;
}

/* ---- the command ----------------------------------------------------------------------------- */

static sl_status choose_method(show_options *o, const sl_scene *scene, sl_error *error) {
    const sl_auto_budget budget = {.quality = o->settings.quality,
                                   .things_move = sl_scene_features(scene).animated};
    return sl_auto_settle(scene, &budget, o->quiet, &o->settings, error);
}

static sl_status show_scene(const show_options *o, sl_scene *scene, sl_error *error) {
    static sl_pass_times stages;
    sl_pass_times_begin(&stages, sl_thread_seconds);
    show s = {.o = o,
              .width = o->settings.width,
              .height = o->settings.height,
              .tone = {(sl_tone_curve)o->tone, (float)o->exposure, !o->exposure_given},
              .stages = &stages};
    if (!s.width) sl_scene_film(scene, &s.width, &s.height);
    sl_status status = sl_scene_set_time(scene, o->at, NULL, error);
    if (status == SL_OK)
        status = sl_show_files_open(&s.files, o->output, s.width, s.height, o->frames_per_second, error);
    if (status == SL_OK) status = play(&s, scene, error);
    sl_status closed = sl_show_files_close(&s.files, status == SL_OK, error);
    if (status == SL_OK) status = closed;
    if (status == SL_OK && o->json) sl_json_print(json_of(&s), false);
    else if (status == SL_OK && !o->quiet) sl_json_lines(stderr, json_of(&s)); /* not into a stream */
    return status;
}

int sl_command_live(int argc, char **argv) {
    show_options o;
    int exit_status;
    if (!parse(argc, argv, &o, &exit_status)) return exit_status;
    sl_error error;
    sl_scene *scene = NULL;
    sl_keep_freed_memory(&o.settings);
    sl_status status = sl_show_files_check(o.output, o.frames_per_second, &error);
    if (status == SL_OK && o.json && o.output && strcmp(o.output, "-") == 0)
        status = sl_fail(&error, SL_ERROR_USAGE, "--json and --output -: both would go to standard output");
    if (status == SL_OK)
        status = sl_load_within_memory(o.scene_path, &o.reading.load, &o.settings, &scene, &error);
    if (status == SL_OK) status = sl_spare_scene(scene, "output", o.output, &error);
    if (status == SL_OK) {
        sl_tell_warnings(scene, o.quiet);
        sl_watch_for_interrupt();
        status = choose_method(&o, scene, &error);
        if (status == SL_OK) status = show_scene(&o, scene, &error);
    }
    sl_scene_destroy(scene);
    return status == SL_OK ? 0 : sl_complain(&error);
}
