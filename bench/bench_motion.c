/* Continuous motion: what is shown while things move without rest, of every method at equal budget.
 *
 *     build/bench/bench_motion [--method NAME] [--budget TIMES] [--only SCENE] [--csv FOLDER] [--film FOLDER]
 *                              [--brief]
 *
 * Thirty seconds at 25 frames a second of the scene's time: eight of motion, three of rest, eight, three,
 * five, three. A frame's budget is counted work, by one table of costs a counter, so that the same frames are
 * shown on every machine; one times the budget is what two cores do in 40 ms. Methods are driven as a live
 * show drives them: a method that is drawn beside updates follows each move at once, others move on when they
 * have shown where things were, and what was shown last stays.
 *
 * Errors are those of pixels over their whole squares, on surfaces (pixels that show a lamp or the sky are
 * left out), against all light, path traced twice over: the mean of (x - p)(x - q) is the squared error
 * without the noise of either half. They are relative to the mean of the thirty seconds, since a room is dark
 * while its door is closed. Beside the methods runs the RenderCache (render_cache.h), whose samples
 * are few points on lamps and few paths. Flicker is the root mean square of what a pixel shown changes by
 * from a frame to the next, over that of the truth. --film: 24 frames of those that move are path traced as
 * whole pictures; FLIP is the mean against them, and what each method showed is written as PNGs. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "app/bench/trials.h"
#include "app/picture.h"
#include "base/memory.h"
#include "base/random.h"
#include "cache/audit/trace_probes.h"
#include "cache/frame/antialias.h"
#include "common.h"
#include "scene/copy.h"
#include "shading_bench.h"

enum { RATE = 25, FRAMES = 30 * RATE, STEP = 5, SIZE = 512, PROBES = 4096, SAMPLES = 24, CONTESTANTS = 24 };
enum { FILM_BEGIN = 6 * RATE, FILM_FRAMES = 24, FILM_SAMPLES = 128 };

typedef struct options {
    bench_options common;
    const char *method, *csv, *film;
    double budget; /* 0: half, one and two */
} options;

/* ---- what work costs ------------------------------------------------------------------------- */

/* Nanoseconds of one core, from still pictures of all methods in these scenes; what a picture takes is within
 * a factor of two of what this table says, mostly within 1.3. A sample is a path besides its rays. */
static const struct {
    sl_counter counter;
    double nanoseconds;
} costs[] = {
    {SL_COUNT_RAYS, 700},
    {SL_COUNT_SHADOW_RAYS, 400},
    {SL_COUNT_SAMPLES, 1500},
    {SL_COUNT_RASTER_PASSES, 8000},
    {SL_COUNT_TRIANGLES_RASTERIZED, 150},
    {SL_COUNT_FRAGMENTS_SHADED, 12},
    {SL_COUNT_FRAGMENTS_BLENDED, 10},
    {SL_COUNT_SHADOW_LOOKUPS, 10},
    {SL_COUNT_PHOTON_LOOK_UPS, 2.4},
    {SL_COUNT_PHOTONS_GATHERED, 120},
    {SL_COUNT_TEXTURE_FETCHES, 8},
};

static double nanoseconds(const sl_counters *counters) {
    double sum = 0.0;
    for (size_t i = 0; i < sizeof costs / sizeof *costs; i++)
        sum += costs[i].nanoseconds * (double)counters->value[costs[i].counter];
    return sum;
}

/* Of both cores, for a picture of SIZE x SIZE; smaller ones get as much a pixel. */
static double frame_nanoseconds(int size) { return 2.0 * 1e9 / RATE * size * size / (SIZE * SIZE); }

/* What the RenderCache projects, before its samples and with them: no counter tells. */
static double projecting(int size) { return 2.0 * 10.0 * 1.5 * size * size; }

/* ---- a method in motion ---------------------------------------------------------------------- */

/* The RenderCache, on the Shading Cache's sample renderers. */
typedef struct rival {
    shading_world world;
    render_cache *cache;
    sl_counters counters;
} rival;

typedef struct contestant {
    char name[32];
    double times, budget; /* of a frame: in times, in nanoseconds */
    sl_scene *scene;      /* a copy: where the method's updates are */
    sl_method *method;
    void *window;         /* NULL: pictures are resolved between updates */
    sl_antialias *edges;
    sl_counters drawing;  /* by the window, and of edges */
    rival *rival;         /* NULL: a method */
    sl_image *shown, *before;
    double balance, spent;
    bool may_move;        /* what was last told of has been shown */
    uint64_t shows, dark; /* frames that show another picture than the last, that show no light */
    double error[FRAMES]; /* relative RMSE of judged frames; NAN: not judged */
    double flip;          /* the mean of the film's frames */
    double change, truth; /* sums of squares from a frame to the next, while things move */
} contestant;

static void set_up(const char *method, int size, sl_settings *settings) {
    char text[128];
    const sl_error error = {SL_ERROR_USAGE, "options that mean nothing"};
    snprintf(text, sizeof text, "--method %s --filter centre --quality draft --threads 2", method);
    bench_check(sl_trial_settings(text, settings) ? SL_OK : SL_ERROR_USAGE, &error);
    settings->width = settings->height = size;
    settings->shading_cache.frames_per_update = 1;
    settings->shading_cache.updates = 1000000000;
    settings->records_per_frame = 256;
}

/* A frame projects all points, one and a half a pixel; samples are as many as the rest is enough for. */
static void open_rival(contestant *c, const char *path, int size) {
    enum { TRIED = 1024, LAMP_POINTS = 4, PATHS = 1 };
    rival *r = c->rival = bench_allocate(1, sizeof *r);
    if (!shading_open(&(bench_options){0}, path, size, LAMP_POINTS, PATHS, &r->world)) abort();
    c->scene = r->world.scene;
    render_cache *tried = shading_rival(&r->world, TRIED);
    render_cache_frame(tried, &r->counters);
    const double each = nanoseconds(&r->counters) / (double)render_cache_samples(tried);
    render_cache_destroy(tried);
    r->counters = (sl_counters){{0}};
    const double samples = (c->budget - projecting(size)) / each;
    r->cache = shading_rival(&r->world, samples > 1.0 ? (int)samples : 1);
}

static void open_method(contestant *c, const sl_scene *scene, const char *method, int size) {
    sl_settings settings;
    sl_error error;
    set_up(method, size, &settings);
    bench_check(sl_scene_copy(scene, &c->scene, &error), &error);
    bench_check(sl_method_create(c->scene, &settings, &c->method, &error), &error);
    const sl_window_class *window = c->method->class->window;
    if (window) bench_check(window->create(c->method->state, c->scene, 1, &c->window, &error), &error);
}

static void open_contestant(contestant *c, const sl_scene *scene, const char *path, const char *method,
                            double times, int size) {
    *c = (contestant){.times = times, .budget = times * frame_nanoseconds(size), .may_move = true};
    snprintf(c->name, sizeof c->name, "%s", method);
    if (strcmp(method, "render-cache") == 0) open_rival(c, path, size);
    else open_method(c, scene, method, size);
    for (int i = 0; i < FRAMES; i++) c->error[i] = NAN;
}

static void close_rival(rival *r) {
    render_cache_destroy(r->cache);
    shading_close(&r->world);
    sl_free(r);
}

static void close_contestant(contestant *c) {
    sl_antialias_destroy(c->edges);
    if (c->window) c->method->class->window->destroy(c->window);
    sl_method_destroy(c->method);
    if (c->rival) close_rival(c->rival);
    else sl_scene_copy_destroy(c->scene);
    if (c->shown != c->before) sl_image_destroy(c->before);
    sl_image_destroy(c->shown);
}

static const sl_counters *counters_of(const contestant *c) {
    return c->rival ? &c->rival->counters : sl_method_counters(c->method);
}

static void pay(contestant *c) {
    double now = nanoseconds(counters_of(c)) + nanoseconds(&c->drawing);
    c->balance -= now - c->spent;
    c->spent = now;
}

static void draw_window(contestant *c, sl_image **image) {
    const sl_settings *settings = &c->method->settings;
    uint64_t versions;
    sl_error error;
    bench_check(sl_image_create(settings->width, settings->height, 3, NULL, image, &error), &error);
    bench_check(c->method->class->window->draw(c->window, *image, &versions, &c->drawing, &error), &error);
}

static void draw_rival(const contestant *c, int size, sl_image **image) {
    sl_error error;
    bench_check(sl_image_create(size, size, 3, NULL, image, &error), &error);
    memcpy((*image)->planes, render_cache_picture(c->rival->cache),
           3 * (size_t)size * (size_t)size * sizeof(float));
}

/* As live shows do. */
static void smooth(contestant *c, sl_image *image) {
    const sl_method_class *class = c->method ? c->method->class : NULL;
    sl_error error;
    if (!class || class->any_transport) return;
    const uint32_t *id = c->window ? class->window->ids(c->window) : NULL;
    if (!c->edges) bench_check(sl_antialias_create(image->width, image->height, &c->edges, &error), &error);
    bench_check(sl_antialias_edges(c->edges, c->scene, sl_method_raster(c->method), id, 1, image, &c->drawing,
                             &error),
          &error);
}

static void show(contestant *c, int size) {
    sl_error error;
    sl_image *image;
    if (c->rival) draw_rival(c, size, &image);
    else if (c->window) draw_window(c, &image);
    else bench_check(sl_method_resolve(c->method, &image, &error), &error);
    smooth(c, image);
    if (c->shown != c->before) sl_image_destroy(c->shown);
    c->shown = image;
    c->shows++;
    pay(c);
}

static void follow(contestant *c, double time) {
    unsigned changes = 0;
    sl_error error;
    if (c->rival) {
        render_cache_edit(c->rival->cache, shading_move(&c->rival->world, time));
        return;
    }
    bench_check(sl_scene_set_time(c->scene, time, &changes, &error), &error);
    if (changes) bench_check(sl_method_edit(c->method, changes, &error), &error);
    if (c->window && (changes & SL_CHANGED_OBJECTS))
        bench_check(c->method->class->window->move(c->window, &error), &error);
    c->may_move = c->window != NULL;
}

static bool shows(const contestant *c, const sl_progress *progress) {
    if (progress->frame_done || progress->done) return true;
    return c->method->class->shows && c->method->class->shows(c->method->state);
}

/* One frame: updates while the budget lasts; what is left over or owed is the next frame's. */
static void play(contestant *c, double time, int size) {
    sl_progress progress = {0};
    sl_error error;
    if (c->shown != c->before) sl_image_destroy(c->before);
    c->before = c->shown;
    if (c->may_move) follow(c, time);
    c->balance += c->budget;
    if (c->rival) {
        render_cache_frame(c->rival->cache, &c->rival->counters);
        render_cache_show(c->rival->cache, true);
        show(c, size);
        return;
    }
    while (c->balance > 0.0 && !progress.done) {
        bench_check(sl_method_update(c->method, &progress, &error), &error);
        pay(c);
        if (c->window || !shows(c, &progress)) continue;
        show(c, size);
        if (c->balance > 0.0 && !c->may_move) follow(c, time);
        c->may_move = true;
    }
    if (c->window) show(c, size);
    if (c->balance > 0.0) c->balance = 0.0;
}

/* ---- truth ----------------------------------------------------------------------------------- */

typedef struct truth {
    sl_probe_tracer tracer;
    uint32_t pixel[PROBES]; /* on surfaces */
    size_t count;
    double p[PROBES][3], q[PROBES][3];
} truth;

/* Five times the run's mean is a screen's white: a lamp that is shown where it is no more counts as white
 * does, not a hundredfold. */
static double shown(double value, double white) { return value < white ? value : white; }

/* Returns the mean of all light on surfaces. */
static double mean_of(const truth *t) {
    double sum = 0.0;
    for (size_t i = 0; i < t->count; i++) {
        for (int c = 0; c < 3; c++) sum += 0.5 * (t->p[i][c] + t->q[i][c]);
    }
    return t->count ? sum / (3.0 * (double)t->count) : 0.0;
}

/* Makes the halves what a screen shows of them. */
static void show_truth(truth *t, double white) {
    for (size_t i = 0; i < t->count; i++) {
        for (int c = 0; c < 3; c++) {
            t->p[i][c] = shown(t->p[i][c], white);
            t->q[i][c] = shown(t->q[i][c], white);
        }
    }
}

/* Traces pixels in random places, the same in each frame, of the scene as it stands. */
static void trace_truth(truth *t, const sl_scene *scene, int size, uint32_t samples) {
    sl_settings settings, asked;
    sl_transport transport;
    sl_error error = {SL_ERROR_USAGE, "options that mean nothing"};
    uint32_t pixel[PROBES];
    bench_check(sl_trial_settings("--method path --transport full", &asked) ? SL_OK : SL_ERROR_USAGE, &error);
    asked.width = asked.height = size;
    bench_check(sl_method_choose(scene, &asked, &settings, &transport, NULL, &error), &error);
    bench_check(sl_probe_tracer_create(&t->tracer, scene, &transport, size, size, 2, 1, &error), &error);
    t->count = 0;
    for (uint32_t i = 0; i < PROBES; i++) {
        uint32_t stratum = (uint32_t)(size * size / PROBES);
        pixel[i] = i * stratum + sl_random_bits(sl_random_key(7, 0), i) % stratum;
        if (t->tracer.surfaces->planes[pixel[i]] > 0.5f) t->pixel[t->count++] = pixel[i];
    }
    bench_check(sl_probe_tracer_trace(&t->tracer, t->pixel, t->count, samples, &error), &error);
    for (size_t i = 0; i < t->count; i++)
        sl_probe_tracer_means(&t->tracer, t->pixel[i], t->p[i], t->q[i]);
    sl_probe_tracer_release(&t->tracer);
}

/* Returns the mean of the whole run; the scene is left at its end. */
static double mean_of_run(sl_scene *scene, int size) {
    static truth some;
    double sum = 0.0;
    sl_error error;
    for (int k = 0; k < FRAMES; k += RATE) {
        bench_check(sl_scene_set_time(scene, (double)k / RATE, NULL, &error), &error);
        trace_truth(&some, scene, size, 2);
        sum += mean_of(&some);
    }
    return sum / (FRAMES / RATE);
}

static double shown_value(const sl_image *image, double white, uint32_t pixel, int channel) {
    size_t plane = (size_t)image->width * (size_t)image->height;
    return shown((double)image->planes[(size_t)channel * plane + pixel], white);
}

static double error_of(const sl_image *image, const truth *t, double white) {
    double square = 0.0;
    for (size_t i = 0; i < t->count; i++) {
        for (int c = 0; c < 3; c++) {
            double x = image ? shown_value(image, white, t->pixel[i], c) : 0.0;
            square += (x - t->p[i][c]) * (x - t->q[i][c]);
        }
    }
    return t->count ? sqrt(fmax(square / (3.0 * (double)t->count), 0.0)) : 0.0;
}

/* Adds to the sums of squares of changes since the frame before, of pixels that show surfaces in both. */
static void add_changes(contestant *c, const truth *before, const truth *now, double white) {
    for (size_t i = 0, k = 0; c->before && i < now->count; i++) {
        while (k < before->count && before->pixel[k] < now->pixel[i]) k++;
        if (k == before->count || before->pixel[k] != now->pixel[i]) continue;
        for (int ch = 0; ch < 3; ch++) {
            double x = shown_value(c->shown, white, now->pixel[i], ch) -
                       shown_value(c->before, white, now->pixel[i], ch);
            c->change += x * x;
            c->truth += (now->p[i][ch] - before->p[k][ch]) * (now->q[i][ch] - before->q[k][ch]);
        }
    }
}

/* ---- a film ---------------------------------------------------------------------------------- */

static void write_frame(const options *o, const char *scene, const char *name, int frame,
                        const sl_image *image, double white) {
    char path[512];
    sl_error error = {SL_ERROR_OUTPUT, "the film's folder has too long a name"};
    const sl_tone tone = {SL_TONE_CLIP, (float)-log2(white), false};
    const int used = snprintf(path, sizeof path, "%s/%s-%s-%02d.png", o->film, scene, name, frame);
    bench_check(used < (int)sizeof path ? SL_OK : SL_ERROR_OUTPUT, &error);
    bench_check(sl_image_write_png(image, path, tone, &error), &error);
}

static void trace_whole(const sl_scene *scene, int size, sl_image **image) {
    sl_settings settings = sl_settings_default();
    sl_error error;
    settings.method = "path";
    settings.transport = "full";
    settings.width = settings.height = size;
    settings.spp = FILM_SAMPLES;
    settings.threads = 2;
    bench_check(sl_picture_make(scene, &settings, HUGE_VAL, image, &error), &error);
}

/* Judges a frame of the film as a whole, and writes it. */
static void film_frame(const options *o, const char *name, const sl_scene *scene, int size, int frame,
                       contestant *contestants, int count, double white) {
    const sl_compare_options screen = {.exposure_stops = (float)-log2(white)};
    sl_image *whole;
    sl_error error;
    trace_whole(scene, size, &whole);
    write_frame(o, name, "truth", frame, whole, white);
    for (int i = 0; i < count; i++) {
        contestant *c = &contestants[i];
        sl_comparison found = {.flip = 1.0};
        if (!c->shown) continue;
        bench_check(sl_image_compare(c->shown, whole, &screen, &found, NULL, &error), &error);
        c->flip += found.flip / FILM_FRAMES;
        write_frame(o, name, c->name, frame, c->shown, white);
    }
    sl_image_destroy(whole);
}

/* ---- figures --------------------------------------------------------------------------------- */

enum { RESTS = 3 };
static const double rest_begins[RESTS] = {8.0, 19.0, 27.0}, rest_ends[RESTS] = {11.0, 22.0, 30.0};

static bool is_moving(int frame) {
    double time = (double)frame / RATE;
    for (int i = 0; i < RESTS; i++) {
        if (time > rest_begins[i] && time <= rest_ends[i]) return false;
    }
    return frame > 0;
}

/* Returns the seconds after the stop at which no more than `left` of what was wrong remains: of the error at
 * the stop above the least of the rest. The mean of all rests. */
static double seconds_until(const contestant *c, double left) {
    double sum = 0.0;
    for (int r = 0; r < RESTS; r++) {
        int from = (int)(rest_begins[r] * RATE), end = (int)(rest_ends[r] * RATE);
        double least = c->error[from], limit;
        for (int k = from; k < end; k++) least = fmin(least, c->error[k]);
        limit = least + left * (c->error[from] - least);
        for (int k = from; k < end; k++) {
            if (!(c->error[k] <= limit)) continue;
            sum += (double)(k - from) / RATE;
            break;
        }
    }
    return sum / RESTS;
}

static double least_at_rest(const contestant *c) {
    double least = INFINITY;
    for (int k = 0; k < FRAMES; k++) {
        if (!is_moving(k)) least = fmin(least, c->error[k]);
    }
    return least;
}

/* Of the frames in which things move, but for the first second: every method begins with nothing. */
static void put_row(const char *scene, const contestant *c) {
    double sum = 0.0, worst = 0.0;
    int judged = 0;
    for (int k = RATE; k < FRAMES; k++) {
        if (!is_moving(k) || isnan(c->error[k])) continue;
        sum += c->error[k];
        worst = fmax(worst, c->error[k]);
        judged++;
    }
    const sl_counters *n = counters_of(c);
    bench_row("%s|%s|%.1f|%.1f|%.1f|%.1f|%.2f|%.2f|%.2f|%.3f|%.1f|%llu|%llu|%llu", scene, c->name, c->times,
              100.0 * sum / judged, 100.0 * worst, 100.0 * least_at_rest(c), seconds_until(c, 0.5),
              seconds_until(c, 0.1), sqrt(c->change / fmax(c->truth, 1e-300)), c->flip,
              (double)c->shows / (FRAMES / RATE), (unsigned long long)c->dark,
              (unsigned long long)n->value[SL_COUNT_SPLITS],
              (unsigned long long)(n->value[SL_COUNT_RAYS] + n->value[SL_COUNT_SHADOW_RAYS]) / 1000);
}

static void put_curves(const options *o, const char *scene, const contestant *contestants, int count) {
    char path[512];
    if (!o->csv) return;
    snprintf(path, sizeof path, "%s/%s.csv", o->csv, scene);
    FILE *file = fopen(path, "w");
    if (!file) return;
    fputs("seconds", file);
    for (int i = 0; i < count; i++) fprintf(file, ",%s %.1f", contestants[i].name, contestants[i].times);
    for (int k = 0; k < FRAMES; k++) {
        if (isnan(contestants[0].error[k])) continue;
        fprintf(file, "\n%.2f", (double)k / RATE);
        for (int i = 0; i < count; i++) fprintf(file, ",%.5f", contestants[i].error[k]);
    }
    fputs("\n", file);
    fclose(file);
}

/* ---- a scene --------------------------------------------------------------------------------- */

static const char *const methods[] = {"splatting",  "direct-radiance", "light-octree",
                                      "multi-mesh", "shading-cache",   "path", "render-cache"};

static int open_all(const options *o, const sl_scene *scene, const char *path, int size,
                    contestant *contestants) {
    static const double budgets[] = {0.5, 1.0, 2.0};
    int count = 0;
    for (size_t m = 0; m < sizeof methods / sizeof *methods; m++) {
        if (o->method && strcmp(o->method, methods[m]) != 0) continue;
        for (int b = 0; b < 3; b++) {
            if (o->budget > 0.0 ? b == 0 : true)
                open_contestant(&contestants[count++], scene, path, methods[m],
                                o->budget > 0.0 ? o->budget : budgets[b], size);
        }
    }
    return count;
}

static bool has_light(const sl_image *image) {
    size_t values = 3 * (size_t)image->width * (size_t)image->height;
    for (size_t i = 0; i < values; i++) {
        if (image->planes[i] > 0.0f) return true;
    }
    return false;
}

static void run_scene(const options *o, const char *path) {
    static contestant contestants[CONTESTANTS];
    static truth now, before;
    char name[64];
    sl_scene *scene;
    sl_error error;
    const int size = o->common.brief ? 128 : SIZE, step = o->common.brief ? 5 * STEP : STEP;
    bench_scene_name(path, name);
    if (!bench_wants(&o->common, name) || !bench_open_scene(path, &scene)) return;
    const double white = 5.0 * mean_of_run(scene, size);
    double mean = 0.0;
    int frames = 0;
    bench_check(sl_scene_set_time(scene, 0.0, NULL, &error), &error);
    int count = open_all(o, scene, path, size, contestants);
    for (int k = 0; k < FRAMES; k++) {
        double time = (double)k / RATE;
        bool judged = k % step == 0, pair = k % RATE == 1 && is_moving(k) && k > RATE;
        bench_check(sl_scene_set_time(scene, time, NULL, &error), &error);
        if (pair) before = now;
        if (judged || pair) {
            trace_truth(&now, scene, size, o->common.brief ? 4 : SAMPLES);
            show_truth(&now, white);
        }
        mean += judged ? mean_of(&now) : 0.0;
        frames += judged;
        for (int i = 0; i < count; i++) {
            contestant *c = &contestants[i];
            play(c, time, size);
            c->dark += !c->shown || !has_light(c->shown);
            if (judged) c->error[k] = error_of(c->shown, &now, white);
            if (pair) add_changes(c, &before, &now, white);
        }
        if (o->film && k >= FILM_BEGIN && k < FILM_BEGIN + FILM_FRAMES)
            film_frame(o, name, scene, size, k - FILM_BEGIN, contestants, count, white);
    }
    for (int i = 0; i < count; i++) {
        for (int k = 0; k < FRAMES && mean > 0.0; k++) contestants[i].error[k] *= frames / mean;
        put_row(name, &contestants[i]);
    }
    put_curves(o, name, contestants, count);
    for (int i = 0; i < count; i++) close_contestant(&contestants[i]);
    sl_scene_destroy(scene);
}

static options parse(int argc, char **argv) {
    options o = {0};
    int rest = 1;
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--method") == 0 && i + 1 < argc) o.method = argv[++i];
        else if (strcmp(argv[i], "--csv") == 0 && i + 1 < argc) o.csv = argv[++i];
        else if (strcmp(argv[i], "--film") == 0 && i + 1 < argc) o.film = argv[++i];
        else if (strcmp(argv[i], "--budget") == 0 && i + 1 < argc) o.budget = strtod(argv[++i], NULL);
        else argv[rest++] = argv[i];
    }
    o.common = bench_options_parse(rest, argv);
    return o;
}

int main(int argc, char **argv) {
    static const char *const scenes[] = {"bench/scenes/motion-ball.json", "bench/scenes/motion-lamp.json",
                                         "bench/scenes/motion-door.json", "bench/scenes/motion-walk.json",
                                         "bench/scenes/motion-room-lamp.json",
                                         "bench/scenes/motion-all.json"};
    options o = parse(argc, argv);
    const char *const folders[] = {o.csv, o.film};
    for (int i = 0; i < 2; i++) {
        if (!folders[i] || access(folders[i], W_OK) == 0) continue;
        fprintf(stderr, "bench_motion: %s: expected a folder that can be written to\n", folders[i]);
        return SL_ERROR_OUTPUT;
    }
    bench_table("scene|method|>budget|>in motion %|>worst %|>at rest %|>s to half|>s to a tenth|>flicker|"
                ">FLIP|>pictures/s|>dark|>splits|>krays");
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++) run_scene(&o, scenes[i]);
    return 0;
}
