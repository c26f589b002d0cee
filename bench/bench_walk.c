/* A walk-through: at most 100 new records a frame along a fixed path of the camera, then a still camera while
 * the picture fills. What a frame costs, how far it is from the truth, and whether it is calm: with a still
 * camera the mean change of a pixel from one frame to the next must fall steadily, or records would be seen
 * to pop up. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/math.h"
#include "cache/splatting/plan.h"
#include "splat_bench.h"
#include "timing.h"

typedef struct walk {
    const char *name;
    const char *path;          /* of the scene */
    sl_direct_kind direct;
    double turn_deg;           /* how far the camera goes around its target, and back up to half of that */
    double distance;           /* of the target, m */
} walk;

typedef struct frame {
    uint64_t new_records, all_records;
    double wall, cpu;          /* milliseconds */
    double error, noise;       /* relMSE; negative: not measured */
    double rel_rmse;
    /* mean and largest absolute change of a pixel since the frame before, in shares of the mean; negative:
     * camera moved */
    double change, largest;
    bool moved, done;
} frame;

typedef struct world {
    sl_scene *scene;
    sl_tracer *tracer;
    sl_method *method;
    sl_camera start;
    int size, moving, still, every; /* frames, and how many of the moving ones have an error */
    uint32_t samples;
    bench_pixels pixels;
    bench_reference reference;
    float *previous;
    frame *frames;
} world;

enum { RECORDS_A_FRAME = 100 };

/* ---- the camera's path ---- */

/* Around a point in front of the first view, there and half of the way back, evenly eased. */
static void place_camera(world *w, const walk *k, int number) {
    sl_camera c = w->start;
    sl_vec3 target = sl_mad(c.eye, (float)-k->distance, c.back);
    double t = (double)number / (double)w->moving, eased = t * t * (3.0 - 2.0 * t);
    double angle = k->turn_deg * SL_PI / 180.0 * sl_sin(0.75 * SL_PI * eased);
    float cosine = (float)sl_cos(angle), sine = (float)sl_sin(angle);
    sl_vec3 arm = sl_sub(c.eye, target);
    float eye[3] = {target.x + cosine * arm.x + sine * arm.z, target.y + arm.y * (1.0f - 0.2f * (float)t),
                    target.z - sine * arm.x + cosine * arm.z};
    const float at[3] = {target.x, target.y, target.z}, up[3] = {0.0f, 1.0f, 0.0f};
    sl_error error;
    if (sl_scene_set_camera(w->scene, eye, at, up, c.vertical_fov, &error) != SL_OK)
        bench_fail("camera", &error);
}

/* ---- frames ---- */

static sl_image *next_frame(world *w, bool moved, frame *f) {
    sl_progress progress = {0};
    sl_error error;
    sl_image *image;
    uint64_t before = sl_method_counters(w->method)->value[SL_COUNT_RECORDS];
    double wall = wall_ms(), cpu = process_ms();
    if (moved && sl_method_edit(w->method, SL_CHANGED_CAMERA, &error) != SL_OK) bench_fail("edit", &error);
    do {
        if (sl_method_update(w->method, &progress, &error) != SL_OK) bench_fail("update", &error);
    } while (!progress.frame_done && !progress.done);
    if (sl_method_resolve(w->method, &image, &error) != SL_OK) bench_fail("resolve", &error);
    f->wall = wall_ms() - wall;
    f->cpu = process_ms() - cpu;
    f->all_records = sl_method_counters(w->method)->value[SL_COUNT_RECORDS];
    f->new_records = f->all_records - before;
    f->done = progress.done;
    f->moved = moved;
    f->error = f->change = f->largest = -1.0;
    return image;
}

static void find_reference(world *w) {
    sl_settings settings = sl_settings_default();
    sl_transport transport;
    sl_splat_transport(&settings, &transport);
    bench_pixels_free(&w->pixels);
    bench_reference_free(&w->reference);
    bench_pixels_make(w->scene, w->tracer, w->size, w->size, 16, &w->pixels);
    bench_reference_get(w->scene, w->tracer, &transport, &w->pixels, w->samples, &w->reference);
}

static void judge(world *w, const sl_image *image, frame *f) {
    float *values = calloc(3 * w->pixels.count + 1, sizeof *values);
    if (!values) bench_fail("frame", NULL);
    bench_pick(image, NULL, &w->pixels, values);
    bench_error e = bench_compare(values, &w->reference, NULL);
    f->error = e.rel_mse;
    f->noise = e.noise;
    f->rel_rmse = e.rel_rmse;
    free(values);
}

static void compare_with_previous(world *w, const sl_image *image, frame *f) {
    size_t values = 3 * (size_t)w->size * (size_t)w->size;
    double sum = 0.0, mean = 0.0, largest = 0.0;
    for (size_t i = 0; i < values; i++) {
        double change = fabs((double)image->planes[i] - (double)w->previous[i]);
        sum += change;
        largest = fmax(largest, change);
        mean += (double)image->planes[i];
    }
    f->change = mean > 0.0 ? sum / mean : 0.0;
    f->largest = mean > 0.0 ? largest * (double)values / mean : 0.0;
}

static int run_frames(bench_report *r, const bench_options *o, const walk *k, world *w) {
    int count = 0;
    for (; count < w->moving + w->still; count++) {
        frame *f = &w->frames[count];
        bool moved = count < w->moving;
        if (moved && count) place_camera(w, k, count);
        sl_image *image = next_frame(w, moved && count, f);
        if (moved ? count % w->every == w->every - 1 : count == w->moving) find_reference(w);
        if (!moved || count % w->every == w->every - 1) judge(w, image, f);
        if (!moved) compare_with_previous(w, image, f);
        memcpy(w->previous, image->planes, 3 * (size_t)w->size * (size_t)w->size * sizeof *w->previous);
        if (o->pictures && (count == w->moving / 2 || count == w->moving || f->done)) {
            char what[64];
            snprintf(what, sizeof what, "frame-%03d", count);
            bench_write_picture(r, k->name, what, image);
        }
        sl_image_destroy(image);
        if (!moved && f->done) return count + 1;
    }
    return count;
}

/* ---- tables ---- */

static double mean_of(const frame *frames, int from, int to, bool cpu) {
    double sum = 0.0;
    for (int i = from; i < to; i++) sum += cpu ? frames[i].cpu : frames[i].wall;
    return to > from ? sum / (double)(to - from) : 0.0;
}

static const char *number(double value, const char *format, char text[24]) {
    text[0] = '\0';
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wformat-nonliteral"
    if (value >= 0.0) snprintf(text, 24, format, value);
#pragma GCC diagnostic pop
    return text;
}

static void frame_rows(bench_report *r, const world *w, const char *name, int count) {
    char file_name[700], a[24], b[24], c[24], d[24];
    snprintf(file_name, sizeof file_name, "%s/walk-%s-frames.csv", r->folder, name);
    FILE *file = fopen(file_name, "w");
    if (file)
        fprintf(file, "frame,camera,new records,records,wall ms,cpu ms,relMSE,noise,relRMSE,mean "
                      "change,largest change\n");
    bench_table(r, name,
                "walk|frame|camera|new|records|wall ms|CPU ms|frames/s|relRMSE %|relMSE|mean change "
                "%|largest / mean");
    for (int i = 0; i < count; i++) {
        const frame *f = &w->frames[i];
        const char *camera = i == 0 ? "first" : f->moved ? "moves" : "still";
        if (file)
            fprintf(file, "%d,%s,%llu,%llu,%.2f,%.2f,%.4e,%.2e,%.5f,%.4e,%.4e\n", i, camera,
                    (unsigned long long)f->new_records, (unsigned long long)f->all_records, f->wall, f->cpu,
                    f->error, f->noise, f->rel_rmse, f->change, f->largest);
        bool shown = f->moved ? f->error >= 0.0 || i == 0
                              : i < w->moving + 5 || (i - w->moving) % 20 == 0 || i == count - 1;
        if (!shown) continue;
        bench_row(r, "%s|%d|%s|%llu|%llu|%.0f|%.0f|%.1f|%s|%s|%s|%s", name, i, camera,
                  (unsigned long long)f->new_records, (unsigned long long)f->all_records, f->wall, f->cpu,
                  1e3 / f->wall, number(f->error < 0.0 ? -1.0 : 100.0 * f->rel_rmse, "%.2f", a),
                  number(f->error, "%.2e", b), number(f->change < 0.0 ? -1.0 : 100.0 * f->change, "%.4f", c),
                  number(f->largest, "%.3f", d));
    }
    if (file) fclose(file);
}

/* Over windows of five frames: one frame's records may lie where little is seen. The last one alone may hold
 * what neighbour clamping, at the end of the visit, uncovers. */
static void say_whether_calm(bench_report *r, const world *w, const char *name, int count) {
    enum { WINDOW = 5 };
    int rises = 0, windows = 0;
    double before = INFINITY, worst = 0.0, all_largest = 0.0;
    for (int i = w->moving; i < count; i++) all_largest = fmax(all_largest, w->frames[i].largest);
    for (int i = w->moving + 1; i + WINDOW <= count; i += WINDOW, windows++) {
        double sum = 0.0;
        for (int k = 0; k < WINDOW; k++) sum += w->frames[i + k].change;
        if (sum > before) {
            rises++;
            worst = fmax(worst, sum / before);
        }
        before = sum;
    }
    bench_say(r, "\n%s, still camera: mean change over windows of %d frames %s", name, WINDOW,
              rises ? "RISES" : "falls throughout");
    if (rises) bench_say(r, " %d times of %d, at most %.2f times", rises, windows, worst);
    bench_say(r, "; largest change of a pixel %.2f of the mean; picture complete %s\n", all_largest,
              w->frames[count - 1].done ? "at the last frame shown" : "NOT within the frames given");
}

static void experiment(bench_report *r, const bench_options *o, const walk *k) {
    world w = {.size = o->brief ? 128 : 512,
               .moving = o->brief ? 12 : 60,
               .still = o->brief ? 40 : 240,
               .every = o->brief ? 6 : 10,
               .samples = o->brief ? 512 : 4096};
    sl_settings settings = sl_settings_default();
    sl_error error;
    if (!bench_wants(o, k->name) || !bench_open_scene(r, k->path, &w.scene)) return;
    w.start = w.scene->camera;
    if (sl_tracer_create(w.scene, 2, NULL, &w.tracer, &error) != SL_OK) bench_fail("tracer", &error);
    settings.method = "splatting";
    settings.width = settings.height = w.size;
    settings.quality = SL_QUALITY_DRAFT;
    settings.accuracy = 0.5; /* the paper's */
    settings.direct = k->direct;
    settings.records_per_frame = RECORDS_A_FRAME;
    settings.threads = o->once ? 1 : 0;
    if (sl_method_create(w.scene, &settings, &w.method, &error) != SL_OK) bench_fail("method", &error);
    w.previous = calloc(3 * (size_t)w.size * (size_t)w.size, sizeof *w.previous);
    w.frames = calloc((size_t)(w.moving + w.still), sizeof *w.frames);
    if (!w.previous || !w.frames) bench_fail("frames", NULL);
    int count = run_frames(r, o, k, &w);
    bench_say(r,
              "\n%s: %s, %d x %d, draft, a 0.5, at most %d new records a frame; %d frames along the path, "
              "then a still camera\n",
              k->name, k->path, w.size, w.size, RECORDS_A_FRAME, w.moving);
    frame_rows(r, &w, k->name, count);
    double moving = mean_of(w.frames, 1, w.moving, false), still = mean_of(w.frames, w.moving, count, false);
    bench_say(r,
              "\n%s: %.1f frames a second while the camera moves, %.1f while it stands and fills (processor "
              "time %.0f and %.0f ms a frame)\n",
              k->name, 1e3 / moving, 1e3 / still, mean_of(w.frames, 1, w.moving, true),
              mean_of(w.frames, w.moving, count, true));
    say_whether_calm(r, &w, k->name, count);
    free(w.previous);
    free(w.frames);
    bench_pixels_free(&w.pixels);
    bench_reference_free(&w.reference);
    sl_method_destroy(w.method);
    sl_tracer_destroy(w.tracer);
    sl_scene_destroy(w.scene);
}

int main(int argc, char **argv) {
    static const walk walks[] = {
        {"figure", "scenes/generated/figure.json", SL_DIRECT_RAYS, -40.0, 3.5},
        {"figure-maps", "scenes/generated/figure.json", SL_DIRECT_SHADOW_MAPS, -40.0, 3.5},
        {"cathedral", "scenes/generated/cathedral.json", SL_DIRECT_RAYS, 10.0, 12.0},
    };
    bench_options o = bench_options_parse(argc, argv, "build/splatting");
    bench_report r;
    bench_report_open(&r, &o, "walk");
    for (size_t i = 0; i < sizeof walks / sizeof *walks; i++) experiment(&r, &o, &walks[i]);
    bench_report_close(&r);
    return 0;
}
