/* Things that move: error against time since, of the shading cache, of a RenderCache on the same sample
 * renderers with the same points an update, and of the path tracer with the time of an update. The eye walks,
 * a chair is moved, the lamp is; then all stays, and the caches catch up. Last, the lamp jumps: updates until
 * half and nine tenths of the error that this made are gone (the paper: feedback within seconds, quality in
 * tens of them).
 *
 * Errors are those of displayed grey levels (RMS) against what the renderers say of each pixel as things then
 * stand. */
#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "shading_bench.h"
#include "timing.h"

enum { JUDGED = 16, PATHS = 100 };

typedef struct film {
    double duration;        /* of the motion, in the scene's seconds */
    int warm, moving, rest; /* updates before, during and after it */
} film;

/* Either of the two caches: told of changes, brought on by a batch of points, judged. */
typedef struct rival {
    shading_run *run;
    render_cache *cache;
    double seconds;
} rival;

static void step(rival *v) {
    sl_counters counters = {{0}};
    double from = process_ms();
    if (v->run) shading_run_update(v->run);
    else render_cache_frame(v->cache, &counters);
    v->seconds += 1e-3 * (process_ms() - from);
}

static void tell(rival *v, unsigned changes) {
    if (v->run) shading_run_edit(v->run, changes);
    else render_cache_edit(v->cache, changes);
}

static double judge(rival *v, shading_world *w) {
    return v->run ? shading_run_error(v->run) : shading_rival_error(w, v->cache, true);
}

static double points_of(const rival *v) {
    return v->run ? (double)shading_run_points(v->run) : (double)render_cache_samples(v->cache);
}

static bool is_judged(const film *f, int update) {
    int after = update - f->warm - f->moving;
    if (after < 0)
        return update == f->warm - 1 ||
               (update >= f->warm && (update - f->warm + 1) % ((f->moving + 3) / 4) == 0);
    return ((after + 1) & after) == 0 || after == f->rest - 1; /* 1, 2, 4, 8, ... updates after it */
}

typedef struct judgement {
    int update;
    bench_pixels pixels;
    float *limit;
    double error[2], seconds[2], points[2];
} judgement;

/* Runs the film once; the first run finds the limits, for both. Returns how often it was judged. */
static int play(shading_world *w, const film *f, int block, rival *v, int which, judgement *judged) {
    int count = 0;
    for (int update = 0; update < f->warm + f->moving + f->rest; update++) {
        if (update >= f->warm && update < f->warm + f->moving)
            tell(v, shading_move(w, f->duration * (update - f->warm + 1) / f->moving));
        step(v);
        if (!is_judged(f, update) || count == JUDGED) continue;
        judgement *j = &judged[count++];
        if (which == 0) shading_judge(w, block);
        else w->pixels = j->pixels, w->limit = j->limit;
        j->update = update;
        j->error[which] = judge(v, w);
        j->seconds[which] = v->seconds;
        j->points[which] = points_of(v);
        j->pixels = w->pixels, j->limit = w->limit;
        w->pixels.index = NULL, w->limit = NULL;
    }
    return count;
}

/* The RenderCache gets as many samples a frame as the cache needed points an update. */
static void motion(const bench_options *o, const char *path, film f) {
    shading_world w;
    shading_run run;
    rival rivals[2] = {{0}};
    static judgement judged[JUDGED];
    int block = o->brief ? 16 : 8;
    if (!shading_open(o, path, o->brief ? 256 : 512, 0, o->brief ? 25 : PATHS, &w)) return;
    shading_move(&w, 0.0);
    shading_run_open(&run, &w, NULL);
    rivals[0] = (rival){.run = &run};
    int count = play(&w, &f, block / (o->brief ? 2 : 1), &rivals[0], 0, judged);
    double per_update = points_of(&rivals[0]) / (f.warm + f.moving + f.rest);
    shading_move(&w, 0.0);
    rivals[1] = (rival){.cache = shading_rival(&w, (int)(per_update + 0.5))};
    play(&w, &f, block / (o->brief ? 2 : 1), &rivals[1], 1, judged);
    double path_seconds;
    w.pixels = judged[count - 1].pixels, w.limit = judged[count - 1].limit;
    double path_error = shading_path_error(&w, 1, &path_seconds);
    w.pixels.index = NULL, w.limit = NULL; /* freed with the others */
    for (int i = 0; i < count; i++) {
        judgement *j = &judged[i];
        const char *state = j->update < f.warm              ? "before"
                            : j->update < f.warm + f.moving ? "moving"
                                                            : "after";
        bench_row("%s|%s|%d|%.0f|%.2f|%.1f|%.2f|%.2f", w.name, state,
                  j->update - f.warm - (j->update < f.warm + f.moving ? -1 : f.moving - 1), j->points[0],
                  j->seconds[0], j->error[0], j->seconds[1], j->error[1]);
        bench_pixels_free(&j->pixels);
        sl_free(j->limit);
    }
    printf("| %s | path tracer, 1 sample a pixel | | | %.2f | %.1f | | |\n", w.name, path_seconds,
              path_error);
    shading_run_close(&run);
    render_cache_destroy(rivals[1].cache);
    shading_close(&w);
}

/* ---- the jump ---- */

/* Updates, seconds and points until that share of what the jump added to the error is gone, and the error at
 * the end. */
typedef struct recovery {
    double before, jumped, last, updates[2], seconds[2], points[2];
} recovery;

static recovery recover(shading_world *w, rival *v, int warm, int most, int block) {
    static const double shares[2] = {0.5, 0.9};
    recovery c = {0};
    shading_judge(w, block);
    for (int i = 0; i < warm; i++) step(v);
    c.before = judge(v, w);
    tell(v, shading_move(w, 1.0));
    shading_judge(w, block);
    c.jumped = c.last = judge(v, w);
    double seconds = v->seconds, points = points_of(v);
    for (int i = 1; i <= most && !(c.updates[1] > 0.0); i++) {
        step(v);
        c.last = judge(v, w);
        for (int k = 0; k < 2; k++) {
            if (c.updates[k] > 0.0 || c.last > c.jumped - shares[k] * (c.jumped - c.before)) continue;
            c.updates[k] = i, c.seconds[k] = v->seconds - seconds, c.points[k] = points_of(v) - points;
        }
    }
    return c;
}

static void recovery_row(const shading_world *w, const char *what, const recovery *c) {
    char text[2][64];
    for (int k = 0; k < 2; k++) {
        if (c->updates[k] > 0.0)
            snprintf(text[k], sizeof text[k], "%.0f|%.0f|%.2f", c->updates[k], c->points[k], c->seconds[k]);
        else snprintf(text[k], sizeof text[k], "-|-|-");
    }
    bench_row("%s|%s|%.1f|%.1f|%s|%s|%.1f", w->name, what, c->before, c->jumped, text[0], text[1],
              c->last);
}

/* The cache, and the cache without one of its parts. Where no flood adds to what is hit, twice as many are
 * hit. */
enum { JUMPS = 6 };
static const char *jump_variant(int i, sl_shading_cache_settings *c) {
    static const char *const names[JUMPS] = {"shading cache", "no resolution drop", "no ageing",
                                             "no flood fill", "no random share",    "neither: hits alone"};
    c->no_resolution_drop = i == 1;
    c->no_ageing = i == 2;
    c->no_flood = i == 3 || i == 5;
    c->no_random = i >= 4;
    c->points *= c->no_flood ? 2 : 1;
    return names[i];
}

static void jump(const bench_options *o, const char *path) {
    int warm = 100, most = o->brief ? 120 : 200, block = o->brief ? 8 : 4;
    double per_update = 64.0;
    for (int i = 0; i <= JUMPS; i++) {
        shading_world w;
        shading_run run;
        if (!shading_open(o, path, 256, 0, 25, &w)) return;
        shading_move(&w, 0.0);
        sl_settings s = w.settings;
        const char *name = "RenderCache, wide fill";
        rival v = {0};
        if (i < JUMPS) {
            name = jump_variant(i, &s.shading_cache);
            shading_run_open(&run, &w, &s);
            v.run = &run;
        } else {
            v.cache = shading_rival(&w, (int)per_update);
        }
        recovery c = recover(&w, &v, warm, most, block);
        if (i == 0) per_update = points_of(&v) / (double)run.updates;
        recovery_row(&w, name, &c);
        if (v.run) shading_run_close(&run);
        else render_cache_destroy(v.cache);
        shading_close(&w);
    }
}

int main(int argc, char **argv) {
    bench_options o = bench_options_parse(argc, argv);
    film f = o.brief ? (film){0.0, 100, 16, 64} : (film){0.0, 300, 32, 256};
    printf(
        "\n%d x %d, %d paths a point. Error while things move and after they have, by updates. The "
              "RenderCache, its gaps filled widely, gets the same points an update.\n",
              o.brief ? 256 : 512, o.brief ? 256 : 512, o.brief ? 25 : PATHS);
    bench_table(
        "scene|>when|>updates|>points|>cache s|>cache RMS levels|>RenderCache s|>RenderCache RMS levels");
    f.duration = 1.0;
    motion(&o, "scenes/generated/study-walk.json", f);
    motion(&o, "scenes/generated/study-chair.json", f);
    motion(&o, "scenes/generated/study-lamp.json", f);
    motion(&o, "scenes/generated/pool-walk.json", f);
    printf("\n256 x 256, 25 paths a point. The lamp (the chair) jumps after 100 updates: what it "
                  "takes until half, and nine tenths, of what that added to the error are gone.\n");
    bench_table(
        "scene|cache|>RMS before|>after the jump|>updates to 50 %|>points|>s|>updates to 90 %|>points|>s|>RMS "
        "then");
    jump(&o, "scenes/generated/study-lamp.json");
    jump(&o, "scenes/generated/study-chair.json");
    jump(&o, "scenes/moving-light.json");
    return 0;
}
