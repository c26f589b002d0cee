/* Climbing a method's ladder of settings from its first step until a picture's error is within what was asked
 * for, or the next would not be done in time. Methods that refine one picture are looked at on the way, too,
 * after numbers of batches that grow geometrically. Without --time nothing here knows a clock: the same bits
 * at any number of threads. */
#include "app/picture.h"

#include "app/clock.h"
#include "app/ladder.h"
#include "app/page.h"
#include "scene/features.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* A step's time is foretold from the one before; what is foretold to take more than that share of the time
 * left is not begun. */
static const double trusted_share = 0.8;
/* A step has about 1.4 times less error than the one below; jumps reckon with more, so as not to jump too
 * far: all steps below one together take about as long as it, and one too far up takes several times that. */
static const double error_a_step = 1.7, cost_of_a_jump = 4.5;
/* Probes may take as many rays as a picture, and about a second's in any case. */
static const double probe_rays_at_least = 3e6;
/* A picture with more than this of E can hardly be promised to be within it, a perfect one not by probes that
 * alone leave more than that. */
static const double too_near = 0.75, hardly_promised = 0.8;
/* Settings that are finer in all that limits the error, and leave more of it than this: the method's own
 * limit. */
static const double worthwhile = 0.9;

typedef struct candidate {
    sl_image *image;
    cJSON *json;
    sl_error_estimate estimate; /* with --error */
    sl_progress progress;
    unsigned step;
    double seconds, effort;
} candidate;

typedef struct climb {
    const sl_render_options *o;
    const sl_scene *scene;
    sl_settings asked;     /* o's, with the film's size */
    sl_ladder ladder;
    unsigned steps;        /* of it; 0: one picture, refined for as long as it takes */
    sl_error_probe *probe; /* NULL without --error */
    double start;
    candidate best;
    sl_image *last;           /* the colours of the last step's picture, */
    unsigned last_step;
    sl_error_estimate judged; /* what this step's came to, */
    /* and how much of the error is left at least; 0 where settings did not differ in all that limits it */
    double left;
    double effort_before, effort; /* of all steps before, and of this one, in rays */
    char why[160];         /* it was not within the error */
    double step_seconds[2], step_cost[2]; /* of the last two finished */
    unsigned finished;
    bool reached, out_of_time;
} climb;

static bool is_tracer(const climb *c) { return c->steps == 0; }
static double cost_of(const climb *c, unsigned step) { return c->steps ? c->ladder.step[step].cost : 1.0; }

/* ---- what a picture's error is --------------------------------------------------------------- */

/* The path tracer's own halves cannot know of light that no path from the eye finds. */
static bool path_is_blind(const climb *c) {
    sl_features f = sl_scene_features(c->scene);
    bool full = !c->asked.transport || strcmp(c->asked.transport, "full") == 0;
    return strcmp(c->asked.method, "path") == 0 && full && f.mirror_triangles &&
           f.point_lights + f.spot_lights + f.directional_lights > 0;
}

/* Probes shall take no longer than this step's picture. */
static uint64_t affordable_rays(const climb *c) { return (uint64_t)fmax(c->effort, probe_rays_at_least); }

static sl_status judge(climb *c, const sl_image *image, sl_error_estimate *e, sl_error *error) {
    if (!is_tracer(c))
        return sl_error_probe_judge(c->probe, image, c->o->error, affordable_rays(c), e, error);
    sl_status status = sl_error_estimate_from_halves(image, sl_error_probe_surfaces(c->probe), e, error);
    e->blind = path_is_blind(c);
    return status;
}

/* Tells of an estimate for --json, where what is infinite is null. */
static void add_json(const climb *c, cJSON *root, const sl_error_estimate *e) {
    cJSON *object = cJSON_AddObjectToObject(root, "error");
    cJSON_AddNumberToObject(object, "asked", c->o->error);
    cJSON_AddNumberToObject(object, "estimate", e->rel_rmse);
    cJSON_AddNumberToObject(object, "bound", e->bound);
    cJSON_AddNumberToObject(object, "least", e->least);
    cJSON_AddNumberToObject(object, "probes", (double)e->probes);
    cJSON_AddNumberToObject(object, "samples", (double)e->samples);
    cJSON_AddBoolToObject(object, "within", e->bound <= c->o->error);
    cJSON_AddBoolToObject(object, "blind", e->blind);
}

/* Tells the same numbers in the picture's metadata. */
static sl_status stamp(sl_image *image, const cJSON *told, sl_error *error) {
    sl_status status = SL_OK;
    const cJSON *item;
    cJSON_ArrayForEach(item, told) {
        char key[48], text[32];
        snprintf(key, sizeof key, "softlux.error.%s", item->string);
        snprintf(text, sizeof text, "%.9g", item->valuedouble);
        if (status == SL_OK && cJSON_IsNumber(item)) status = sl_image_set_metadata(image, key, text, error);
    }
    if (status == SL_OK && cJSON_IsTrue(cJSON_GetObjectItem(told, "blind")))
        status = sl_image_set_metadata(image, "softlux.error.blind", "true", error);
    return status;
}

/* ---- one step -------------------------------------------------------------------------------- */

static void release(candidate *p) {
    sl_image_destroy(p->image);
    cJSON_Delete(p->json);
    *p = (candidate){0};
}

static bool is_better(const climb *c, const candidate *p) {
    /* finer settings, more samples */
    if (!c->best.image || !(c->o->error > 0.0) || is_tracer(c)) return true;
    /* mostly the same probes: bounds share their noise */
    return p->estimate.rel_rmse < c->best.estimate.rel_rmse || p->estimate.bound <= c->o->error;
}

static void tell(const climb *c, const candidate *p) {
    if (c->o->quiet || !isatty(STDERR_FILENO)) return;
    if (c->steps) fprintf(stderr, "step %u of %u", p->step + 1, c->steps);
    else fprintf(stderr, "%llu samples a pixel", (unsigned long long)p->progress.batches);
    if (c->o->error > 0.0)
        fprintf(stderr, ": error about %.3g %%, at most %.3g %%", 100.0 * p->estimate.rel_rmse,
                100.0 * p->estimate.bound);
    fprintf(stderr, "\n");
}

/* If every step that is left leaves as much of the error as this one, the last does not do either. */
static bool ends_above(const climb *c, unsigned step) {
    double error = c->judged.rel_rmse;
    for (unsigned i = step + 1; i < c->steps; i++) error *= c->left;
    return c->left > worthwhile && error > too_near * c->o->error;
}

/* Finds how much of the last picture's error is left in this one. Where that is so much that the climb would
 * end, both are judged by many probes: few may be off all the same way. */
static sl_status compare_with_last(climb *c, const sl_image *image, unsigned step, sl_error *error) {
    enum { MANY_PROBES = 4096, MANY_SAMPLES = 64 };
    sl_status status = sl_error_probe_left(c->probe, c->last, image, &c->left, error);
    if (status != SL_OK || step + 1 >= c->steps || !ends_above(c, step) ||
        c->judged.probes >= MANY_PROBES / 2)
        return status;
    status = sl_error_probe_estimate(c->probe, image, MANY_PROBES, MANY_SAMPLES, &c->judged, error);
    return status == SL_OK ? sl_error_probe_left(c->probe, c->last, image, &c->left, error) : status;
}

/* Holds a step's picture against the last one's, and keeps it for the next. */
static sl_status hold_against_last(climb *c, const sl_image *image, unsigned step, sl_error *error) {
    static const char *const names[] = {"R", "G", "B"};
    const size_t pixels = (size_t)image->width * (size_t)image->height;
    sl_status status = SL_OK;
    c->left = 0.0;
    if (c->last && c->last_step >= sl_ladder_refines_all_from(c->asked.method))
        status = compare_with_last(c, image, step, error);
    if (status == SL_OK && !c->last)
        status = sl_image_create(image->width, image->height, 3, names, &c->last, error);
    for (size_t i = 0; status == SL_OK && i < 3; i++)
        memcpy(c->last->planes + i * pixels, sl_image_channel(image, names[i]), pixels * sizeof(float));
    c->last_step = step;
    return status;
}

/* The picture as it is now: its error, and whether it is the best so far. */
static sl_status consider(climb *c, const sl_render_options *o, sl_method *method,
                          const sl_progress *progress, unsigned step, sl_error *error) {
    candidate p = {.progress = *progress, .step = step};
    sl_status status = sl_method_resolve(method, &p.image, error);
    if (status != SL_OK) return status;
    p.seconds = sl_seconds_now() - c->start;
    p.effort = c->effort = sl_effort_in_rays(sl_method_counters(method));
    p.json = sl_picture_json(o, c->scene, method, p.image, progress, p.seconds);
    if (c->o->error > 0.0) {
        status = judge(c, p.image, &c->judged, error);
        if (status == SL_OK && c->steps && progress->done && !(c->judged.bound <= c->o->error))
            status = hold_against_last(c, p.image, step, error);
        p.estimate = c->judged;
        add_json(c, p.json, &p.estimate);
        if (status == SL_OK) status = stamp(p.image, cJSON_GetObjectItem(p.json, "error"), error);
        c->reached = status == SL_OK && p.estimate.bound <= c->o->error;
    }
    if (status == SL_OK) tell(c, &p);
    if (status == SL_OK && is_better(c, &p)) {
        release(&c->best);
        c->best = p;
    } else {
        release(&p);
    }
    return status;
}

/* Returns after how many batches to look next. The tracers' error falls as the root of the samples. */
static uint64_t next_look(const climb *c, uint64_t batches) {
    enum { FIRST = 16, FIRST_SAMPLES = 4 };
    if (!batches) return is_tracer(c) ? FIRST_SAMPLES : FIRST;
    if (!is_tracer(c)) return 2 * batches;
    double ratio = c->judged.bound / c->o->error, needed = 1.05 * (double)batches * ratio * ratio,
           most = 2.0 * (double)batches;
    return needed < most ? (needed > (double)batches ? (uint64_t)needed + 1 : batches + 1) : (uint64_t)most;
}

static bool refines(const climb *c) {
    return is_tracer(c) || strcmp(c->asked.method, "multi-mesh") == 0 ||
           strcmp(c->asked.method, "shading-cache") == 0;
}

static sl_status climb_step(climb *c, unsigned step, sl_error *error) {
    sl_render_options o = *c->o;
    sl_method *method = NULL;
    sl_progress progress = {0};
    double begun = sl_seconds_now();
    o.settings = c->steps ? sl_ladder_settings(&c->asked, &c->ladder.step[step]) : c->asked;
    sl_status status = sl_method_create(c->scene, &o.settings, &method, error);
    while (status == SL_OK && !c->reached) {
        o.batches = o.error > 0.0 && refines(c) ? next_look(c, progress.batches) : 0;
        status = sl_picture_run(&o, method, &progress, c->start, 0.0, error);
        c->out_of_time = o.time_seconds > 0.0 && sl_seconds_now() - c->start >= o.time_seconds;
        bool cut_short = !progress.done && (c->out_of_time || sl_interrupted());
        if (status != SL_OK || (cut_short && c->best.image && !is_tracer(c))) break;
        status = consider(c, &o, method, &progress, step, error);
        if (progress.done || cut_short) break;
    }
    sl_method_destroy(method);
    if (!progress.done || status != SL_OK) return status;
    c->step_seconds[0] = c->step_seconds[1];
    c->step_cost[0] = c->step_cost[1];
    c->step_seconds[1] = sl_seconds_now() - begun;
    c->step_cost[1] = cost_of(c, step);
    c->finished++;
    return SL_OK;
}

/* ---- which one next -------------------------------------------------------------------------- */

/* From one step: as the ladder's costs grow, which is too much, since part of a picture's time is the same on
 * every step. From two: the line through them. */
static double foretold_seconds(const climb *c, unsigned step) {
    double cost = cost_of(c, step), last = c->step_seconds[1],
           by_cost = last * cost / c->step_cost[1];
    if (c->finished < 2 || c->step_cost[1] <= c->step_cost[0]) return by_cost;
    double slope = (last - c->step_seconds[0]) / (c->step_cost[1] - c->step_cost[0]);
    double foretold = last + (slope > 0.0 ? slope : 0.0) * (cost - c->step_cost[1]);
    return foretold < by_cost ? (foretold > 1.1 * last ? foretold : 1.1 * last) : by_cost;
}

/* The step to try after this one; c->steps: none. */
static unsigned next_step(const climb *c, unsigned step) {
    unsigned next = step + 1;
    if (c->o->error > 0.0) {
        const double most = cost_of_a_jump * cost_of(c, step);
        double ratio = c->judged.rel_rmse / c->o->error;
        for (; ratio > error_a_step * error_a_step && next + 1 < c->steps &&
               cost_of(c, next + 1) <= most;
             next++)
            ratio /= error_a_step;
    } else {
        next = c->steps - 1;
    }
    if (c->o->time_seconds > 0.0) {
        double left = trusted_share * (c->o->time_seconds - (sl_seconds_now() - c->start));
        while (next > step && foretold_seconds(c, next) > left) next--;
    }
    return next > step ? next : c->steps;
}

/* ---- whether there is any use in it ---------------------------------------------------------- */

static double probe_rays(const climb *c) {
    const sl_counters *probes = sl_error_probe_counters(c->probe);
    return (double)(probes->value[SL_COUNT_RAYS] + probes->value[SL_COUNT_SHADOW_RAYS]);
}

/* The picture may do, but even of a perfect one the next step's probes would not tell: their noise falls with
 * the root of their number. Pictures that take less than the probes go on all the same. */
static bool bound_cannot_follow(const climb *c, unsigned step) {
    double next =
        c->effort * cost_of(c, step + 1) / cost_of(c, step);
    double pictures = c->effort_before + c->effort, probes = probe_rays(c),
           ratio = c->judged.resolution / (hardly_promised * c->o->error);
    bool may_do = c->judged.least <= too_near * c->o->error, cheap = pictures + next < probes;
    return may_do && !cheap && probes * ratio * ratio > fmax(next, probe_rays_at_least);
}

/* Notes why; false where another step may do. */
static bool is_in_vain(climb *c, unsigned step) {
    if (!(c->o->error > 0.0)) return false;
    if (c->judged.nonfinite)
        snprintf(c->why, sizeof c->why, "with values that are no numbers, for which nothing is promised");
    else if (step + 1 < c->steps && bound_cannot_follow(c, step))
        snprintf(c->why, sizeof c->why,
                 "and probes that take no longer than the pictures can promise no more");
    else if (step + 1 < c->steps && ends_above(c, step))
        snprintf(c->why, sizeof c->why, "and with finer settings at least %d %% of the error was left",
                 (int)(100.0 * c->left));
    else
        return false;
    return true;
}

/* ---- all together ---------------------------------------------------------------------------- */

static sl_status prepare(climb *c, sl_error *error) {
    enum { NO_END = 100000000 };
    if (!c->asked.width) sl_scene_film(c->scene, &c->asked.width, &c->asked.height);
    c->ladder = sl_ladder_of(c->asked.method);
    c->steps = c->ladder.count;
    if (!c->steps && !c->asked.spp) c->asked.spp = NO_END;
    return c->o->error > 0.0 ? sl_error_probe_create(c->scene, &c->asked, &c->probe, error) : SL_OK;
}

/* Begins where a quality stands that was asked for. */
static unsigned first_step(const climb *c) {
    for (unsigned i = 0; i < c->steps && c->o->quality_given; i++)
        if (c->ladder.step[i].own && c->ladder.step[i].quality == c->asked.quality) return i;
    return 0;
}

static sl_status climb_all(climb *c, sl_error *error) {
    unsigned step = first_step(c);
    sl_status status;
    do {
        status = climb_step(c, step, error);
        if (status != SL_OK || !c->steps || c->reached || c->out_of_time || sl_interrupted() ||
            is_in_vain(c, step))
            break;
        c->effort_before += c->effort;
        c->effort = 0.0;
        snprintf(c->why, sizeof c->why,
                 step + 1 == c->steps ? "by its finest settings"
                                      : "and finer settings would not be done in time");
        step = next_step(c, step);
    } while (step < c->steps);
    return status;
}

/* By counts, so that it is the same on every machine: of the picture written, of all steps together, and of
 * the probes. */
static void add_effort(const climb *c) {
    cJSON *object = cJSON_AddObjectToObject(cJSON_GetObjectItem(c->best.json, "error"), "effort_in_rays");
    cJSON_AddNumberToObject(object, "picture", c->best.effort);
    cJSON_AddNumberToObject(object, "all_pictures", c->effort_before + c->effort);
    cJSON_AddNumberToObject(object, "probes", probe_rays(c));
}

static void say_how_it_ended(const climb *c) {
    const sl_render_options *o = c->o;
    const candidate *p = &c->best;
    if (o->error > 0.0 && p->estimate.blind && !o->quiet)
        fprintf(stderr, "softlux: warning: what mirrors throw of lights without extent is not judged: no "
                        "path from the eye finds it\n");
    if (o->error > 0.0 && !c->reached)
        fprintf(stderr,
                "softlux: not within %.3g %%: %s came to about %.3g %%, at most %.3g %%, %s; %s holds that\n",
                100.0 * o->error, o->settings.method, 100.0 * p->estimate.rel_rmse, 100.0 * p->estimate.bound,
                sl_interrupted() ? "when it was stopped"
                : c->out_of_time ? "when time was up"
                                 : c->why,
                o->output);
    else if (!(o->error > 0.0)) sl_picture_stopped(o, &p->progress);
}

sl_status sl_render_to_target(const sl_render_options *o, const sl_scene *scene, sl_render_end *end,
                              sl_error *error) {
    climb c = {.o = o, .scene = scene, .asked = o->settings, .start = sl_seconds_now()};
    double stops = 0.0;
    sl_watch_for_interrupt();
    sl_status status = prepare(&c, error);
    if (status == SL_OK) status = climb_all(&c, error);
    if (status == SL_OK) {
        sl_picture_warn(o, scene, &c.best.progress, c.best.image);
        status = sl_picture_write(o, c.best.image, o->output, &stops, error);
    }
    if (status == SL_OK) {
        say_how_it_ended(&c);
        if (o->json) {
            sl_picture_add_tone(o, stops, c.best.json);
            if (c.probe) add_effort(&c);
            sl_json_print(c.best.json, false);
            c.best.json = NULL;
        }
    }
    if (!c.reached && o->error > 0.0) *end = SL_RENDER_MISSED;
    if (!c.reached && sl_interrupted()) *end = SL_RENDER_STOPPED;
    release(&c.best);
    sl_image_destroy(c.last);
    sl_error_probe_destroy(c.probe);
    return status;
}
