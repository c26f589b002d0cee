/* softlux render: a picture of a scene, or a series of an animated one. */
#include "app/commands.h"
#include "app/options.h"
#include "app/picture.h"

#include <stdio.h>

static const char *const quality_names[] = {"draft", "normal", "high", NULL};
static const char *const gather_names[] = {"auto", "raster", "hemicube", "trace", NULL}; /* as sl_gather_kind */
static const char *const direct_names[] = {"auto", "rays", "shadow-maps", NULL};         /* as sl_direct_kind */
static const char *const filter_names[] = {"method", "box", "centre", NULL};             /* as sl_pixel_filter */
static const char *const order_names[] = {"coarse-to-fine", "linear", NULL};             /* as sl_traversal_order */
static const char *const metric_names[] = {"auto", "harmonic", "minimum", "hessian", "adaptive", NULL}; /* as sl_radius_metric */
static const char *const tone_names[] = {"clip", "reinhard", NULL};                      /* as sl_tone_curve */

/* Values as the command line gives them. */
typedef struct {
    int size[2], quality, gather, direct, filter, order, metric;
    uint64_t threads, spp, gather_size, harmonics_order, bounces, hit_samples, records_per_frame;
    bool at_given;
} raw_settings;

static void take_settings(const raw_settings *r, sl_settings *s) {
    s->width = r->size[0];
    s->height = r->size[1];
    s->quality = (sl_quality)r->quality;
    s->gather = (sl_gather_kind)r->gather;
    s->direct = (sl_direct_kind)r->direct;
    s->filter = (sl_pixel_filter)r->filter;
    s->order = (sl_traversal_order)r->order;
    s->metric = (sl_radius_metric)r->metric;
    s->harmonics_order = (int)r->harmonics_order;
    s->bounces = (uint32_t)r->bounces;
    s->hit_samples = (uint32_t)r->hit_samples;
    s->records_per_frame = (uint32_t)r->records_per_frame;
    s->spp = (uint32_t)r->spp;
    s->gather_size = (int)r->gather_size;
    s->threads = (unsigned)r->threads;
}

static bool parse(int argc, char **argv, sl_render_options *o, bool *at_given, int *status) {
    raw_settings r = {.quality = SL_QUALITY_NORMAL};
    *o = (sl_render_options){.settings = sl_settings_default(), .tone = SL_TONE_REINHARD, .output = "out.exr",
                             .frames_per_second = 25.0};
    sl_settings *s = &o->settings;
    const sl_option options[] = {
        {"output", 'o', SL_OPTION_TEXT, &o->output, NULL, "FILE", "picture to write: .exr, .png or .pfm [out.exr]", 0, 0, NULL},
        {"method", 'm', SL_OPTION_TEXT, &s->method, NULL, "NAME", "splatting or path [splatting]", 0, 0, NULL},
        {"transport", 0, SL_OPTION_TEXT, &s->transport, NULL, "PATHS",
         "path: direct, one-bounce, full or matched:METHOD [full]", 0, 0, NULL},
        {"size", 's', SL_OPTION_SIZE, r.size, NULL, "WxH", "pixels [as the scene says]", 0, 0, NULL},
        {"quality", 'q', SL_OPTION_CHOICE, &r.quality, NULL, "Q", "draft, normal or high [normal]", 0, 0, quality_names},
        {"spp", 0, SL_OPTION_COUNT, &r.spp, NULL, "N", "samples a pixel; splatting: light samples [by quality]", 1, 1e8, NULL},
        {"accuracy", 'a', SL_OPTION_REAL, &s->accuracy, NULL, "A", "splatting: the records' a [by quality]", 1e-3, 2.0, NULL},
        {"gather", 0, SL_OPTION_CHOICE, &r.gather, NULL, "HOW", "auto, raster, hemicube or trace [auto]", 0, 0, gather_names},
        {"gather-size", 0, SL_OPTION_COUNT, &r.gather_size, NULL, "N", "N x N samples a gather, N even [by quality]", 4, 1024, NULL},
        {"direct", 0, SL_OPTION_CHOICE, &r.direct, NULL, "HOW", "auto, rays or shadow-maps [auto]", 0, 0, direct_names},
        {"filter", 0, SL_OPTION_CHOICE, &r.filter, NULL, "F", "path: box or centre of the pixel [method]", 0, 0, filter_names},
        {"order", 0, SL_OPTION_CHOICE, &r.order, NULL, "ORDER",
         "splatting: pixels coarse-to-fine or linear [coarse-to-fine]", 0, 0, order_names},
        {"metric", 0, SL_OPTION_CHOICE, &r.metric, NULL, "METRIC",
         "splatting: what decides how far records reach: auto, harmonic, minimum, hessian or adaptive [auto]", 0, 0, metric_names},
        {"glossy-accuracy", 0, SL_OPTION_REAL, &s->glossy_accuracy, NULL, "A", "splatting: a of the radiance records [by quality]",
         1e-3, 2.0, NULL},
        {"harmonics", 0, SL_OPTION_COUNT, &r.harmonics_order, NULL, "N",
         "splatting: order of the radiance records' harmonics [by the lobes]", 1, 12, NULL},
        {"bounces", 0, SL_OPTION_COUNT, &r.bounces, NULL, "N", "splatting: diffuse bounces; also of matched:splatting [1]", 1, 64,
         NULL},
        {"glossy-hits", 0, SL_OPTION_FLAG, &s->glossy_hits, NULL, NULL, "splatting: gathers see glossy lobes too", 0, 0, NULL},
        {"hit-samples", 0, SL_OPTION_COUNT, &r.hit_samples, NULL, "N",
         "splatting: light samples for what a gather sees [by quality]", 1, 256, NULL},
        {"load-cache", 0, SL_OPTION_TEXT, &o->load_cache, NULL, "FILE", "splatting: start with the records of another run", 0, 0, NULL},
        {"save-cache", 0, SL_OPTION_TEXT, &o->save_cache, NULL, "FILE", "splatting: keep the records for another run", 0, 0, NULL},
        {"seed", 0, SL_OPTION_COUNT, &s->seed, NULL, "N", "another number, other noise [0]", 0, 0, NULL},
        {"threads", 't', SL_OPTION_COUNT, &r.threads, NULL, "N", "workers; the bits do not depend on it [all processors]", 1,
         256, NULL},
        {"time", 0, SL_OPTION_REAL, &o->time_seconds, NULL, "SECONDS", "stop at the first batch that ends later", 1e-3, 1e9,
         NULL},
        {"batches", 0, SL_OPTION_COUNT, &o->batches, NULL, "N", "stop after N batches", 1, 1e15, NULL},
        {"at", 0, SL_OPTION_REAL, &o->at_seconds, at_given, "SECONDS", "time of an animated scene [0]", -1e9, 1e9, NULL},
        {"frames", 0, SL_OPTION_COUNT, &o->frames, NULL, "N",
         "a series of N pictures of an animated scene; --output names the number, as frame-%04d.png", 1, 1e9, NULL},
        {"fps", 0, SL_OPTION_REAL, &o->frames_per_second, NULL, "F", "frames for each second of the scene's time [25]", 1e-3, 1e6, NULL},
        {"records-per-frame", 0, SL_OPTION_COUNT, &r.records_per_frame, NULL, "N",
         "splatting: a walk-through, at most N new records a frame [no limit]", 1, 1e9, NULL},
        {"exposure", 0, SL_OPTION_REAL, &o->exposure, &o->exposure_given, "STOPS", "PNG: times 2^STOPS [automatic]", -64, 64,
         NULL},
        {"tone", 0, SL_OPTION_CHOICE, &o->tone, NULL, "CURVE", "PNG: clip or reinhard [reinhard]", 0, 0, tone_names},
        {"json", 0, SL_OPTION_FLAG, &o->json, NULL, NULL, "print what was done as one JSON object", 0, 0, NULL},
        {"quiet", 0, SL_OPTION_FLAG, &o->quiet, NULL, NULL, "no progress bar, no warnings", 0, 0, NULL},
        {0},
    };
    const sl_command_line line = {
        "softlux render SCENE [-o FILE] [options]",
        "Renders a scene: a JSON scene file, or a mesh file (OBJ, glTF, PLY, ...).",
        "Ctrl-C writes what is done so far. A picture stopped by --time can be had again, bit for bit, with\n"
        "--batches and the number that its metadata (softlux.batches) tells.\n\n"
        "example: softlux render scenes/cornell.json -q high -o cornell.exr",
        options, 1, 1};
    int operands;
    *at_given = false;
    if (!sl_options_parse(&line, argc, argv, &o->scene_path, &operands, status)) return false;
    take_settings(&r, s);
    return true;
}

static int report(const sl_error *error) {
    fprintf(stderr, "softlux: %s\n", error->message);
    return (int)error->status;
}

static void print_warnings(const sl_scene *scene) {
    for (size_t i = 0; i < sl_scene_warning_count(scene); i++)
        fprintf(stderr, "softlux: warning: %s\n", sl_scene_warning(scene, i));
}

int sl_command_render(int argc, char **argv) {
    sl_render_options o;
    int exit_status;
    bool at_given;
    if (!parse(argc, argv, &o, &at_given, &exit_status)) return exit_status;
    sl_error error;
    sl_scene *scene = NULL;
    if (!sl_output_is_known(&o, &error)) return report(&error); /* before the work, not after */
    sl_status status = sl_scene_load(o.scene_path, &scene, &error);
    if (status == SL_OK && at_given) status = sl_scene_set_time(scene, o.at_seconds, NULL, &error);
    if (status == SL_OK) {
        if (!o.quiet) print_warnings(scene);
        status = o.frames ? sl_render_frames(&o, scene, &error) : sl_render_picture(&o, scene, &error);
    }
    sl_scene_destroy(scene);
    return status == SL_OK ? 0 : report(&error);
}
