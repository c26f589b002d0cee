/* softlux steps: a method pass by pass, as one page. */
#include "app/clock.h"
#include "app/commands.h"
#include "app/memory_limit.h"
#include "app/same_file.h"
#include "app/options.h"
#include "app/page.h"
#include "app/steps/run.h"

#include <stdio.h>
#include <string.h>

typedef struct steps_command {
    const char *scene, *folder, *beside;
    sl_settings settings;
    uint64_t reference_samples;
    double at_seconds;
    bool quiet;
    sl_reading reading;
} steps_command;

static bool parse(int argc, char **argv, steps_command *s, int *status) {
    *s = (steps_command){.folder = "steps", .reference_samples = 64, .settings = sl_settings_of_papers()};
    const sl_option options[] = {
        SL_TEXT("output", 'o', &s->folder, "DIR", "folder for the page, index.html [steps]"),
        SL_TEXT("beside", 0, &s->beside, "METHOD", "another method on the same scene, side by side"),
        SL_NUMBER("reference-spp", 0, &s->reference_samples, "N", 0, 1e6,
                  "samples a pixel of the path-traced reference; 0: no errors are told [64]"),
        SL_REAL("at", &s->at_seconds, NULL, "SECONDS", -1e9, 1e9, "time of an animated scene [0]"),
        SL_FLAG("quiet", &s->quiet, "no progress bar, no warnings"),
        {.name = NULL}};
    const sl_command_line line = {
        "softlux steps SCENE [-m METHOD] [-o DIR] [options]",
        "Runs a method step by step: every pass as a picture, explained, in a page that needs nothing else.",
        "On the page a slider plays the refinement, and a click on a pixel tells what made it: which "
        "records, photons, voxels or\n"
        "vertices, with weights and values that add up to the pixel's exact value.\n\n"
        "example: softlux steps scenes/cornell.json -m splatting -o cornell-steps",
        options, 1, 1, &s->reading, &s->settings, NULL};
    int operands;
    return sl_options_parse(&line, argc, argv, &s->scene, &operands, status);
}

/* 160 pixels wide, in the shape of the scene's film, where nobody asks for another: every pixel has an
 * explanation to be told. */
static void choose_size(const sl_scene *scene, sl_settings *settings) {
    enum { WIDTH = 160 };
    if (settings->width) return;
    int width, height;
    sl_scene_film(scene, &width, &height);
    settings->width = WIDTH;
    settings->height = (WIDTH * height + width / 2) / width;
    if (settings->height < 1) settings->height = 1;
    if (settings->height > 2 * WIDTH) settings->height = 2 * WIDTH;
}

/* Writes index.html: one method, or two beside each other. */
static sl_status write_page(const steps_command *s, const cJSON *runs, sl_error *error) {
    char path[4096], methods[160];
    snprintf(path, sizeof path, "%s/index.html", s->folder);
    snprintf(methods, sizeof methods, "%.60s%s%.60s", s->settings.method, s->beside ? " beside " : "",
             s->beside ? s->beside : "");
    return sl_steps_page(path, methods, s->scene, runs, error);
}

static sl_status make_page(const steps_command *s, const sl_scene *scene, sl_error *error) {
    sl_steps_options o = {.settings = s->settings, .reference_samples = (uint32_t)s->reference_samples,
                          .quiet = s->quiet};
    choose_size(scene, &o.settings);
    cJSON *runs = cJSON_CreateArray();
    sl_status status = SL_OK;
    for (int i = 0; i < (s->beside ? 2 : 1) && status == SL_OK; i++) {
        cJSON *run;
        if (i == 1) o.settings.method = s->beside;
        status = sl_steps_run(scene, &o, &run, error);
        cJSON_AddItemToArray(runs, run);
    }
    sl_progress_clear(s->quiet);
    sl_watch_for_interrupt(); /* a page that is being written is written to its end */
    if (status == SL_OK) status = write_page(s, runs, error);
    cJSON_Delete(runs);
    return status;
}

int sl_command_steps(int argc, char **argv) {
    steps_command s;
    int exit_status;
    if (!parse(argc, argv, &s, &exit_status)) return exit_status;
    sl_error error;
    sl_scene *scene = NULL;
    sl_status status = sl_load_within_memory(s.scene, &s.reading.load, &s.settings, &scene, &error);
    if (status == SL_OK) status = sl_spare_scene_in(scene, "output", s.folder, "index.html", &error);
    if (status == SL_OK && s.at_seconds != 0.0) status = sl_scene_set_time(scene, s.at_seconds, NULL, &error);
    if (status == SL_OK) sl_tell_warnings(scene, s.quiet);
    if (status == SL_OK) status = sl_make_folder(s.folder, "index.html", &error);
    if (status == SL_OK) status = make_page(&s, scene, &error);
    sl_scene_destroy(scene);
    return status == SL_OK ? 0 : sl_complain(&error);
}
