/* A picture by splatting, with the seconds of its parts. It drives the method by its own interface, where its
 * state can be seen: which update belongs to which part, and the splats of each class of records apart. */
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "cache/splatting/state.h"
#include "splat_bench.h"
#include "timing.h"

static void charge(splat_run *run, int part, double from) { run->cpu[part] += 1e-3 * (process_ms() - from); }

sl_settings splat_settings_complete(const sl_scene *scene, const sl_settings *settings) {
    sl_settings s = *settings;
    if (!s.width) s.width = scene->film_width;
    if (!s.height) s.height = scene->film_height;
    s.threads = sl_thread_count(s.threads);
    s.filter = SL_FILTER_CENTRE;
    sl_splatting_method.complete(&s);
    return s;
}

static int part_of(const sl_splat_state *s) {
    if (s->phase == SL_PHASE_GBUFFER) return SPLAT_GBUFFER;
    if (s->phase == SL_PHASE_DIRECT) return SPLAT_DIRECT;
    return SPLAT_RECORDS + (s->class < SL_RECEIVER_CLASSES ? s->class : 0);
}

/* Step 5 for one class, as resolve does it. */
static void splat_class(sl_splat_state *s, int class, splat_run *run) {
    sl_record_cache *cache = &s->cache[class];
    sl_error error;
    double from = process_ms();
    if (!cache->receivers || cache->splatted == cache->list.count) return;
    if (sl_splat_records(&cache->pass, &cache->list, cache->splatted, &s->splats, &s->counters, &error) !=
        SL_OK)
        bench_fail("splat", &error);
    cache->splatted = cache->list.count;
    charge(run, SPLAT_SPLATS + class, from);
}

static void render_once(const sl_scene *scene, const sl_settings *settings, splat_run *run) {
    sl_settings complete = splat_settings_complete(scene, settings);
    sl_transport transport;
    sl_error error;
    void *state;
    memset(run, 0, sizeof *run);
    sl_splatting_method.transport(&complete, &transport);
    double began = wall_ms(), from = process_ms();
    if (sl_splatting_method.create(scene, &complete, &transport, &state, &error) != SL_OK)
        bench_fail("splatting", &error);
    charge(run, SPLAT_SETUP, from);
    sl_splat_state *s = state;
    for (sl_progress progress = {0}; !progress.done;) {
        int part = part_of(s);
        from = process_ms();
        if (sl_splatting_method.update(state, &progress, &error) != SL_OK) bench_fail("update", &error);
        charge(run, part, from);
    }
    for (int class = 0; class < SL_RECEIVER_CLASSES; class++) {
        splat_class(s, class, run);
        run->records[class] = s->cache[class].list.count;
        run->receivers += s->cache[class].receivers;
    }
    from = process_ms();
    if (sl_splatting_method.resolve(state, &run->image, &error) != SL_OK) bench_fail("resolve", &error);
    charge(run, SPLAT_COMPOSE, from);
    run->counters = s->counters;
    run->wall_one = 1e-3 * (wall_ms() - began);
    sl_splatting_method.destroy(state);
    for (int part = 0; part < SPLAT_PARTS; part++) run->cpu_all += run->cpu[part];
}

static int by_cpu(const void *a, const void *b) {
    double x = ((const splat_run *)a)->cpu_all, y = ((const splat_run *)b)->cpu_all;
    return (x > y) - (x < y);
}

static const double long_enough = 15.0; /* seconds, after which nothing is measured again */
enum { RUNS_MAX = 3 };

static double seconds_of_two_threads(const sl_scene *scene, const sl_settings *settings) {
    sl_settings two = *settings;
    double seconds[RUNS_MAX], spent = 0.0;
    int count = 0;
    two.threads = 2;
    for (; count < RUNS_MAX && spent < long_enough; spent += seconds[count++]) {
        splat_run run;
        render_once(scene, &two, &run);
        seconds[count] = run.wall_one;
        splat_run_free(&run);
    }
    return median(seconds, count);
}

void splat_render(const sl_scene *scene, const sl_settings *settings, bool once, splat_run *run) {
    sl_settings one = *settings;
    splat_run all[RUNS_MAX];
    double spent = 0.0;
    int count = 0;
    one.threads = 1;
    for (; count < (once ? 1 : RUNS_MAX) && spent < long_enough; spent += all[count++].wall_one)
        render_once(scene, &one, &all[count]);
    qsort(all, (size_t)count, sizeof *all, by_cpu);
    for (int i = 0; i < count; i++) {
        if (i != count / 2) splat_run_free(&all[i]);
    }
    *run = all[count / 2];
    if (!once) run->wall_two = seconds_of_two_threads(scene, settings);
}

void splat_run_free(splat_run *run) {
    sl_image_destroy(run->image);
    run->image = NULL;
}
