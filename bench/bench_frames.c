/* Frames of scenes in motion, by the trials of a file (bench/frames.trials): what a frame costs, and how
 * calm its pixels are.
 *
 *     build/bench/bench_frames FILE [--table NAME] [--frames N] [--size N] [SCENE]
 *
 * Columns of a table name motions, each of which is run for every trial:
 *
 *   camera    the camera turns to one side, and half of the way back
 *   lights    the method is told that a light has changed, and the camera
 *   all       ... and that objects have
 *   time      the scene's keyframes, as fast as the scene says
 *   walk      as camera; then it stands still until the picture is complete
 *
 * A trial's truth is "none", or options of a method whose frames are taken for right. Then flicker is
 * |(v_t - v_(t-1)) - (r_t - r_(t-1))| and apart is |v - r|, in shares of r's mean. At rest the
 * mean change of the pixels is told, from a frame to the next, and how often it rises. Tables are Markdown
 * between marks, on stdout. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/bench/report.h"
#include "app/bench/schedule.h"
#include "app/page.h"
#include "base/math.h"
#include "common.h"
#include "cache/frame/settings.h"
#include "scene/scene.h"
#include "timing.h"

enum { MOST_FRAMES = 200, FRAMES_A_SECOND = 25, WINDOW = 5 };

typedef struct options {
    const char *file, *scene, *table; /* table: how the names of those that are wanted begin */
    int frames, size;
} options;

/* ---- a method, frame by frame ---- */

typedef struct runner {
    sl_method *method;
    sl_image *image, *before; /* of this frame and the last one */
    bool whole;               /* frames are complete, however many updates that takes */
    bool done;
} runner;

static void open_runner(runner *r, const sl_scene *scene, const char *arguments, int width, int height,
                        bool whole) {
    sl_settings settings;
    sl_error error = {SL_ERROR_USAGE, "options that mean nothing"};
    bench_check(sl_trial_settings(arguments, &settings) ? SL_OK : SL_ERROR_USAGE, &error);
    settings.width = width;
    settings.height = height;
    if (!settings.threads) settings.threads = 1;
    *r = (runner){.whole = whole};
    bench_check(sl_method_create(scene, &settings, &r->method, &error), &error);
}

static void close_runner(runner *r) {
    sl_method_destroy(r->method);
    sl_image_destroy(r->image);
    sl_image_destroy(r->before);
}

static void next_frame(runner *r, unsigned changes) {
    sl_progress progress = {0};
    sl_error error;
    sl_image_destroy(r->before);
    r->before = r->image;
    if (changes) bench_check(sl_method_edit(r->method, changes, &error), &error);
    do bench_check(sl_method_update(r->method, &progress, &error), &error);
    while (!progress.done && (r->whole || !progress.frame_done));
    r->done = progress.done;
    bench_check(sl_method_resolve(r->method, &r->image, &error), &error);
}

/* ---- what moves ---- */

typedef enum motion { CAMERA, LIGHTS, ALL, TIME, WALK, MOTIONS } motion;
static const char *const motion_names[MOTIONS] = {"camera", "lights", "all", "time", "walk"};

/* Turns to one side and half of the way back, evenly eased. */
static void turn_camera(sl_scene *scene, const sl_camera *start, double t) {
    const double most = SL_PI / 9.0;
    double angle = most * sl_sin(0.75 * SL_PI * t * t * (3.0 - 2.0 * t));
    sl_vec3 ahead = sl_mad(sl_scale(start->right, (float)sl_sin(angle)), -(float)sl_cos(angle), start->back);
    const float eye[3] = {start->eye.x, start->eye.y, start->eye.z},
                up[3] = {start->up.x, start->up.y, start->up.z};
    const float at[3] = {eye[0] + ahead.x, eye[1] + ahead.y, eye[2] + ahead.z};
    sl_error error;
    bench_check(sl_scene_set_camera(scene, eye, at, up, start->vertical_fov, &error), &error);
}

/* Returns SL_CHANGED_ bits. */
static unsigned move(sl_scene *scene, const sl_camera *start, motion m, int frame, int frames) {
    unsigned changes = 0;
    sl_error error;
    if (m == TIME) {
        bench_check(sl_scene_set_time(scene, (double)frame / FRAMES_A_SECOND, &changes, &error), &error);
        return changes;
    }
    turn_camera(scene, start, (double)frame / frames);
    changes = SL_CHANGED_CAMERA;
    if (m == LIGHTS || m == ALL) changes |= SL_CHANGED_LIGHTS;
    if (m == ALL) changes |= SL_CHANGED_OBJECTS;
    return changes;
}

/* ---- what is measured ---- */

typedef struct series {
    int frames;
    double ms[MOST_FRAMES];     /* of the processor */
    double change[MOST_FRAMES]; /* from the frame before, mean of the pixels */
    double flicker, worst_frame, largest_flicker, apart;
    uint64_t records;
} series;

static double mean_of(const sl_image *image) {
    size_t values = 3 * (size_t)image->width * (size_t)image->height;
    double sum = 0.0;
    for (size_t i = 0; i < values; i++) sum += (double)image->planes[i] / (double)values;
    return sum > 0.0 ? sum : 1.0;
}

/* The mean of |a - b - (c - d)|, where b, c and d may be missing; *largest: the largest. */
static double difference(const sl_image *a, const sl_image *b, const sl_image *c, const sl_image *d,
                         double *largest) {
    size_t values = 3 * (size_t)a->width * (size_t)a->height;
    double sum = 0.0;
    for (size_t i = 0; i < values; i++) {
        double value = (double)a->planes[i] - (b ? (double)b->planes[i] : 0.0);
        if (c) value -= (double)c->planes[i] - (d ? (double)d->planes[i] : 0.0);
        sum += fabs(value) / (double)values;
        *largest = fmax(*largest, fabs(value));
    }
    return sum;
}

static void judge(series *s, int frame, const runner *ours, const runner *right) {
    double mean = mean_of(right ? right->image : ours->image), largest = 0.0, unused = 0.0;
    if (right) s->apart += difference(ours->image, right->image, NULL, NULL, &unused) / mean;
    if (frame == 0) return;
    s->change[frame] = difference(ours->image, ours->before, NULL, NULL, &unused) / mean;
    if (!right) return;
    double flicker = difference(ours->image, ours->before, right->image, right->before, &largest) / mean;
    s->flicker += flicker;
    s->worst_frame = fmax(s->worst_frame, flicker);
    s->largest_flicker = fmax(s->largest_flicker, largest / mean);
}

/* Counts windows of five frames at rest that change more than the five before: records would be seen to pop
 * up. */
static int rises(const series *s, int from) {
    int count = 0;
    for (int i = from + WINDOW; i + WINDOW <= s->frames; i += WINDOW) {
        double now = 0.0, before = 0.0;
        for (int k = 0; k < WINDOW; k++) now += s->change[i + k], before += s->change[i + k - WINDOW];
        count += now > before;
    }
    return count;
}

static void put_row(const char *scene, const sl_trial *t, motion m, series *s, int moving) {
    double first = s->ms[0], middle = median(s->ms + 1, moving - 1), most = s->ms[moving - 1];
    printf("| %s | %s | %s | %.1f | %.2f | %.2f | %.1f | %.1f |", scene, t->name, motion_names[m], first,
           middle, most, 1e3 / middle, (double)s->records / s->frames);
    if (strcmp(t->transport, "none") == 0) fputs(" | | | |", stdout);
    else
        printf(" %.3f | %.3f | %.1f | %.2f |", 100.0 * s->flicker / (s->frames - 1), 100.0 * s->worst_frame,
               100.0 * s->largest_flicker, 100.0 * s->apart / s->frames);
    if (s->frames > moving)
        printf(" %d, %d rises, the last change %.4f %% |\n", s->frames - moving, rises(s, moving),
               100.0 * s->change[s->frames - 1]);
    else puts(" |");
    fflush(stdout);
}

static void run_trial(const options *o, const sl_trials *all, const sl_trial *t, const char *name,
                      sl_scene *scene, motion m) {
    static series s;
    int width = o->size ? o->size : all->width, height = o->size ? o->size : all->height;
    bool judged = strcmp(t->transport, "none") != 0;
    sl_camera start = scene->camera;
    runner ours, right;
    s = (series){0};
    move(scene, &start, m, 0, o->frames);
    open_runner(&ours, scene, t->arguments, width, height, false);
    if (judged) open_runner(&right, scene, t->transport, width, height, true);
    for (; s.frames < o->frames || (m == WALK && !ours.done && s.frames < MOST_FRAMES); s.frames++) {
        bool moves = s.frames > 0 && s.frames < o->frames;
        unsigned changes = moves ? move(scene, &start, m, s.frames, o->frames) : 0;
        double from = process_ms();
        next_frame(&ours, changes);
        s.ms[s.frames] = process_ms() - from;
        if (judged) next_frame(&right, changes);
        judge(&s, s.frames, &ours, judged ? &right : NULL);
    }
    s.records = sl_method_counters(ours.method)->value[SL_COUNT_RECORDS];
    put_row(name, t, m, &s, o->frames);
    if (judged) close_runner(&right);
    close_runner(&ours);
    scene->camera = start;
}

/* ---- a file of trials ---- */

static void run_scene(const options *o, const sl_trials *all, const sl_trial *t, const char *path) {
    sl_scene *scene;
    char name[64];
    bench_scene_name(path, name);
    if (!bench_open_scene(path, &scene)) return;
    for (motion m = CAMERA; m < MOTIONS; m++) {
        if (strstr(all->table[t->table].columns, motion_names[m])) run_trial(o, all, t, name, scene, m);
    }
    sl_scene_destroy(scene);
}

static void run_file(const options *o, const sl_trials *all) {
    int table = -1;
    for (size_t i = 0; i < all->count; i++) {
        const sl_trial *t = &all->trial[i];
        const char *at = o->scene ? o->scene : t->scenes, *scene;
        size_t length;
        if (t->table < 0 || strncmp(all->table[t->table].name, o->table, strlen(o->table)) != 0) continue;
        if (t->table != table) {
            printf("%s<!-- table %s -->\n", table < 0 ? "" : "<!-- end -->\n", all->table[t->table].name);
            sl_report_head(stdout, "scene|trial|motion|>first ms|>ms|>longest|>frames/s|>new records|>flicker "
                                   "%|>worst frame|>largest|>apart %|at rest");
        }
        table = t->table;
        while ((scene = sl_next_item(&at, " ", &length))) {
            char path[SL_BENCH_PATH];
            snprintf(path, sizeof path, "%.*s", (int)length, scene);
            run_scene(o, all, t, path);
        }
    }
    if (table >= 0) puts("<!-- end -->");
}

int main(int argc, char **argv) {
    options o = {.table = "", .frames = 40};
    sl_trials trials;
    sl_error error;
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--frames") == 0 && i + 1 < argc) o.frames = atoi(argv[++i]);
        else if (strcmp(argv[i], "--table") == 0 && i + 1 < argc) o.table = argv[++i];
        else if (strcmp(argv[i], "--size") == 0 && i + 1 < argc) o.size = atoi(argv[++i]);
        else if (!o.file) o.file = argv[i];
        else o.scene = argv[i];
    }
    if (!o.file || o.frames < 2 || o.frames > MOST_FRAMES) {
        fprintf(stderr, "usage: bench_frames FILE [--table NAME] [--frames N] [--size N] [SCENE]\n");
        return 2;
    }
    bench_check(sl_trials_read(o.file, &trials, &error), &error);
    run_file(&o, &trials);
    sl_trials_free(&trials);
    return 0;
}
