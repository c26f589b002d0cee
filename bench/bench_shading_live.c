/* Frames beside updates (the paper: 40 to 60 frames a second while samples are computed): one thread updates,
 * another one draws the newest shading from where camera and objects are by then, at 512 x 512. Where
 * something moves, each frame is asked for another time of the scene, as fast as frames come: its delay is
 * that from the question to the picture. Beside them: frames where no update is under way, and updates that
 * nobody looks at.
 *
 * By the clock: figures are worth something on a machine that has two processors for this alone. */
#include <math.h>
#include <stdlib.h>

#include "shading_bench.h"
#include "timing.h"

enum { DELAYS_MAX = 1 << 15, WARM_UPDATES = 40 };

/* What the loops did for some time. */
typedef struct pace {
    int frames;
    double seconds, updates;
    /* ms; of each frame by the clock, of all together by the processor */
    double delay[DELAYS_MAX], processor;
} pace;

static sl_live_state draw(sl_live *live) {
    const sl_image *frame;
    sl_live_state state;
    sl_error error;
    if (sl_live_frame(live, &frame, &state, &error) != SL_OK) bench_fail("frame", &error);
    return state;
}

static void move(sl_live *live, double time) {
    sl_error error;
    if (sl_live_move(live, time, &error) != SL_OK) bench_fail("move", &error);
}

/* There and back again in eight seconds, from one end of the keyframes to the other. */
static double time_of_show(double seconds) { return 1.0 - fabs(1.0 - fmod(seconds / 4.0, 2.0)); }

/* Draws for so long, after so many updates. */
static void watch(const shading_world *w, const sl_settings *settings, bool moves, uint64_t warm,
                  double seconds, pace *p) {
    sl_live *live;
    sl_error error;
    if (sl_live_start(w->scene, settings, &live, &error) != SL_OK) bench_fail("show", &error);
    sl_live_state state = {0};
    while (state.updates < warm) state = draw(live);
    uint64_t before = state.updates;
    double start = wall_ms(), end = start, spent = now_ms();
    for (p->frames = 0; end < start + 1e3 * seconds && p->frames < DELAYS_MAX; p->frames++) {
        double from = wall_ms();
        if (moves) move(live, time_of_show(1e-3 * (from - start)));
        state = draw(live);
        end = wall_ms();
        p->delay[p->frames] = end - from;
    }
    p->processor = now_ms() - spent;
    p->seconds = 1e-3 * (end - start);
    p->updates = (double)(state.updates - before);
    sl_live_stop(live, NULL);
}

/* Updates a second that nobody looks at, by one thread. */
static double updates_alone(shading_world *w, int warm, int count) {
    shading_run run;
    shading_run_open(&run, w, NULL, false);
    for (int i = 0; i < warm; i++) shading_run_update(&run);
    double before = run.wall;
    for (int i = 0; i < count; i++) shading_run_update(&run);
    double rate = count / (run.wall - before);
    shading_run_close(&run);
    return rate;
}

static void row(bench_report *r, const bench_options *o, const char *path, bool moves) {
    shading_world w;
    static pace shown, alone;
    double seconds = o->brief ? 2.0 : 10.0;
    int warm = o->brief ? 5 : WARM_UPDATES;
    if (!shading_open(r, o, path, 512, o->brief ? 25 : 400, &w)) return;
    shading_move(&w, 0.0);
    watch(&w, &w.settings, moves, (uint64_t)warm, seconds, &shown);
    shading_move(&w, 0.0);
    sl_settings resting = w.settings;
    resting.shading_cache.updates = 1;
    watch(&w, &resting, false, 1, seconds / 4.0, &alone);
    double rate = updates_alone(&w, warm, o->brief ? 5 : 20), frames = shown.frames,
           middle = median(shown.delay, shown.frames);
    bench_row(r, "%s|%s|%.0f|%.0f|%.1f|%.1f|%.1f|%.1f|%.2f|%.2f", w.name, moves ? "moves" : "rests",
              frames / shown.seconds, alone.frames / alone.seconds, shown.processor / frames, middle,
              shown.delay[(int)(0.99 * frames)], shown.delay[shown.frames - 1], shown.updates / shown.seconds,
              rate);
    shading_close(&w);
}

int main(int argc, char **argv) {
    bench_options o = bench_options_parse(argc, argv, "build/shading-cache");
    bench_report r;
    bench_report_open(&r, &o, "shading_live");
    bench_say(&r,
              "\nFrames of 512 x 512 drawn by one thread while another one computes samples, %d paths a "
              "point. *Delay*: from the question for a frame (of another time of the scene,\n"
              "where something moves) to the picture, by the clock; *frame ms*: of the processor. *Alone*: "
              "frames where no update is under way, updates that nobody looks at.\n",
              o.brief ? 25 : 400);
    bench_table(&r, "live", "scene|view|frames/s|alone|frame ms|delay, median|99 %|longest|updates/s|alone");
    row(&r, &o, "scenes/generated/study.json", false);
    row(&r, &o, "scenes/generated/loft.json", false);
    row(&r, &o, "scenes/generated/pool.json", false);
    row(&r, &o, "scenes/generated/study-walk.json", true);
    row(&r, &o, "scenes/generated/study-chair.json", true);
    row(&r, &o, "scenes/generated/study-lamp.json", true);
    row(&r, &o, "scenes/generated/pool-walk.json", true);
    bench_report_close(&r);
    return 0;
}
