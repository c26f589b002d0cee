/* softlux steps: a method pass by pass, as one page. */
#include "app/commands.h"
#include "app/memory_limit.h"
#include "app/same_file.h"
#include "app/options.h"
#include "app/page.h"
#include "app/steps/run.h"

#include <stdio.h>
#include <string.h>

typedef struct steps_command {
    const char *scene, *folder;
    sl_steps_options options;
    uint64_t reference_samples;
    double at_seconds;
    sl_reading reading;
} steps_command;

static bool parse(int argc, char **argv, steps_command *s, int *status) {
    *s = (steps_command){
        .folder = "steps", .reference_samples = 64, .options.settings = sl_settings_of_papers()};
    const sl_option options[] = {
        SL_TEXT("output", 'o', &s->folder, "DIR", "folder for the page, index.html [steps]"),
        SL_TEXT("beside", 0, &s->options.beside, "METHOD", "another method on the same scene, side by side"),
        SL_NUMBER("reference-spp", 0, &s->reference_samples, "N", 0, 1e6,
                  "samples a pixel of the path-traced reference; 0: no errors are told [64]"),
        SL_REAL("at", &s->at_seconds, NULL, "SECONDS", -1e9, 1e9, "time of an animated scene [0]"),
        SL_FLAG("quiet", &s->options.quiet, "no progress bar, no warnings"),
        {.name = NULL}};
    const sl_command_line line = {
        "softlux steps SCENE [-m METHOD] [-o DIR] [options]",
        "Runs a method step by step: every pass as a picture, explained, in a page that needs nothing else.",
        "On the page a slider plays the refinement, and a click on a pixel tells what made it: which "
        "records, photons, voxels or\n"
        "vertices, with weights and values that add up to the pixel's exact value.\n\n"
        "example: softlux steps scenes/cornell.json -m splatting -o cornell-steps",
        options, 1, 1, &s->reading, &s->options.settings, NULL};
    int operands;
    return sl_options_parse(&line, argc, argv, &s->scene, &operands, status);
}

static sl_status make_page(steps_command *s, const sl_scene *scene, sl_error *error) {
    char path[4096];
    int width, height;
    sl_scene_film(scene, &width, &height);
    if (!s->options.settings.width) sl_steps_size(width, height, &s->options.settings);
    s->options.reference_samples = (uint32_t)s->reference_samples;
    snprintf(path, sizeof path, "%s/index.html", s->folder);
    return sl_steps_write(scene, s->scene, &s->options, path, error);
}

int sl_command_steps(int argc, char **argv) {
    steps_command s;
    int exit_status;
    if (!parse(argc, argv, &s, &exit_status)) return exit_status;
    sl_error error;
    sl_scene *scene = NULL;
    sl_status status = sl_load_within_memory(s.scene, &s.reading.load, &s.options.settings, &scene, &error);
    if (status == SL_OK) status = sl_spare_scene_in(scene, "output", s.folder, "index.html", &error);
    if (status == SL_OK && s.at_seconds != 0.0) status = sl_scene_set_time(scene, s.at_seconds, NULL, &error);
    if (status == SL_OK) sl_tell_warnings(scene, s.options.quiet);
    if (status == SL_OK) status = sl_make_folder(s.folder, "index.html", &error);
    if (status == SL_OK) status = make_page(&s, scene, &error);
    sl_scene_destroy(scene);
    return status == SL_OK ? 0 : sl_complain(&error);
}
