#include "cache/frame/budget.h"

#include "base/error.h"
#include "base/print.h"

#include <stdio.h>
#include <string.h>

/* Code, libraries, stacks, Embree's and OpenMP's own: 17 MB measured with a scene of a thousand triangles. */
static const double program = 32.0 * 1048576.0;

static double all_of(const sl_memory_need *n, const sl_scene *scene) {
    return program + (double)sl_scene_memory_bytes(scene) + n->hierarchies + n->caches + n->picture;
}

static sl_memory_need parts_of(const sl_method_class *method, const sl_scene *scene,
                               const sl_settings *settings) {
    sl_memory_need need = method->need(scene, settings);
    if (sl_method_has_film(method, settings)) need.picture += sl_film_need(scene, settings);
    return need;
}

static double need_of(const sl_method_class *method, const sl_scene *scene, const sl_settings *settings) {
    const sl_memory_need need = parts_of(method, scene, settings);
    return all_of(&need, scene);
}

uint64_t sl_budget_need(const sl_method_class *method, const sl_scene *scene, const sl_settings *settings) {
    double need = need_of(method, scene, settings);
    return need < 9e18 ? (uint64_t)need : (uint64_t)9e18;
}

/* Of what one thread leaves, caches that grow may have that much, however many threads there are; the rest is
 * for more threads. */
static const double of_growth = 0.75;

/* ---- one setting ---- */

static double value_of(const sl_settings *settings, const sl_reduction *c) {
    const char *at = (const char *)settings + c->offset;
    switch (c->kind) {
    case SL_REDUCE_INT:
    case SL_REDUCE_LEVEL: return *(const int *)(const void *)at;
    case SL_REDUCE_COUNT: return (double)*(const uint64_t *)(const void *)at;
    case SL_REDUCE_REAL: return *(const double *)(const void *)at;
    case SL_REDUCE_FLAG: return *(const bool *)(const void *)at ? 1.0 : 0.0;
    }
    return 0.0;
}

/* False: it is as low as it may be. */
static bool lower(sl_settings *settings, const sl_reduction *c) {
    char *at = (char *)settings + c->offset;
    double value = value_of(settings, c), lowered = c->kind == SL_REDUCE_LEVEL ? value - 1.0 : 0.5 * value;
    if (c->kind == SL_REDUCE_FLAG) {
        *(bool *)(void *)at = true;
        return value == 0.0;
    }
    if (lowered < c->least) lowered = c->least;
    if (!(lowered < value)) return false;
    switch (c->kind) {
    case SL_REDUCE_INT:
    case SL_REDUCE_LEVEL: *(int *)(void *)at = (int)lowered; break;
    case SL_REDUCE_COUNT: *(uint64_t *)(void *)at = (uint64_t)lowered; break;
    case SL_REDUCE_REAL: *(double *)(void *)at = lowered; break;
    case SL_REDUCE_FLAG: break;
    }
    return true;
}

/* ---- all of them ---- */

/* The step that saves most; false where none saves anything. */
static bool take_best_step(const sl_method_class *method, const sl_scene *scene, sl_settings *settings,
                           double *need) {
    sl_settings best = *settings;
    double least = *need;
    for (const sl_reduction *c = method->reductions; c && c->what; c++) {
        sl_settings trial = *settings;
        if (!lower(&trial, c)) continue;
        method->complete(&trial); /* settings that hang together */
        double would_need = need_of(method, scene, &trial);
        if (!(would_need < least)) continue;
        least = would_need;
        best = trial;
    }
    if (!(least < *need)) return false;
    *settings = best;
    *need = least;
    return true;
}

static void tell(const sl_method_class *method, const sl_settings *before, const sl_settings *after,
                 char *text, size_t room) {
    size_t used = 0;
    for (const sl_reduction *c = method->reductions; c && c->what; c++) {
        double was = value_of(before, c), is = value_of(after, c);
        if (was == is || used >= room) continue;
        int written = c->kind == SL_REDUCE_FLAG
                          ? snprintf(text + used, room - used, "%s%s", used ? ", " : "", c->what)
                          : sl_print(text + used, room - used, "%s%.9g %s instead of %.9g", used ? ", " : "",
                                     is, c->what, was);
        if (written > 0) used += (size_t)written;
    }
    if (after->threads != before->threads && used < room)
        snprintf(text + used, room - used, "%s%u thread%s instead of %u", used ? ", " : "", after->threads,
                 after->threads > 1 ? "s" : "", before->threads);
}

static sl_status refuse(const sl_method_class *method, const sl_scene *scene, const sl_settings *least,
                        const sl_settings *asked, double beside, sl_error *error) {
    const double mega = 0x1p20;
    const sl_memory_need n = parts_of(method, scene, least);
    char besides[32] = "";
    if (beside > 0.0) snprintf(besides, sizeof besides, ", besides %.0f", beside / mega);
    return sl_fail(error, SL_ERROR_RESOURCES,
                   "%.0fM of memory are not enough: %s needs at least %.0fM for this (program %.0f, scene "
                   "%.0f, hierarchies %.0f, caches %.0f, picture "
                   "%.0f%s); give more memory, a smaller picture or another method",
                   (double)asked->memory_bytes / mega, method->name,
                   (all_of(&n, scene) + beside) / mega + 1.0, program / mega,
                   (double)sl_scene_memory_bytes(scene) / mega, n.hierarchies / mega, n.caches / mega,
                   n.picture / mega, besides);
}

sl_status sl_budget_keep(const sl_method_class *method, const sl_scene *scene, sl_settings *settings,
                         double beside, char *reduced, size_t room, sl_error *error) {
    if (room) reduced[0] = '\0';
    if (!settings->memory_bytes) return SL_OK;
    const sl_settings asked = *settings;
    const double budget = (double)asked.memory_bytes - beside;
    settings->threads = 1;
    double need = need_of(method, scene, settings);
    while (need > budget && take_best_step(method, scene, settings, &need)) {}
    if (need > budget) return refuse(method, scene, settings, &asked, beside, error);
    const double left = budget - need;
    settings->memory_bytes = left > 2.0 ? (uint64_t)(of_growth * left) : 1;
    for (sl_settings trial = *settings; trial.threads < asked.threads; settings->threads = trial.threads) {
        trial.threads++;
        if (need_of(method, scene, &trial) > need + (1.0 - of_growth) * left) break;
    }
    if (room) tell(method, &asked, settings, reduced, room);
    return SL_OK;
}
