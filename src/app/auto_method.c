/* Choosing a method. What a scene's picture is made of is measured, by path tracing small pictures of parts of its light:
 *
 *     direct      straight from the lights
 *     one bounce  and by one diffuse surface
 *     surfaces    and by any number of surfaces that are no mirrors
 *     all         and thrown on surfaces by mirrors (caustics)
 *
 * Their differences in the mean say which light a method may leave out, given the error that the picture may have. Of the methods that hold
 * the rest, a table of measurements names the one that reaches that error first. */
#include "app/auto_method.h"

#include "scene/features.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- what kind of scene -------------------------------------------------------------------------------------------------- */

typedef enum kind { NOTHING_LIT, DIRECT_LIGHT, ONE_BOUNCE, MANY_BOUNCES, HIDDEN_LIGHT, CAUSTICS, MOVING, KINDS } kind;
typedef enum budget_class { ROUGH, MIDDLE, FINE, BUDGETS } budget_class;

typedef struct light_shares {
    double direct, second, further, mirrored; /* of the mean radiance; they sum to 1 */
    bool lit;
} light_shares;

/* Which method, by kind of scene and budget. Figures: docs/error-estimates.md (relative RMSE against all light, and seconds),
 * docs/splatting-experiments.md and docs/bidirectional.md; `softlux bench` measures the same for any scene. Photons are 5 % off in mirror scenes after
 * 2 s, where bidirectional paths are 12 % off; these go on to get better, photons hardly. */
static const struct table_row {
    const char *method[BUDGETS];
    const char *because;
} table[KINDS] = {
    [NOTHING_LIT] = {{"path", "path", "path"}, "nothing in the picture is lit"},
    [DIRECT_LIGHT] = {{"path", "path", "path"}, "a few light samples a pixel are exact soon"},
    [ONE_BOUNCE] = {{"splatting", "splatting", "splatting"}, "records reach an error up to 45 times sooner than paths (Cornell box)"},
    [MANY_BOUNCES] = {{"splatting", "splatting", "splatting"}, "several bounces by records: 2 % off where paths are 5 % off in the same time (Cornell box)"},
    [HIDDEN_LIGHT] = {{"light-octree", "light-octree", "bidirectional"}, "lamps are hidden from what is seen; what starts at them finds it 3 to 15 times sooner"},
    [CAUSTICS] = {{"light-octree", "light-octree", "bidirectional"}, "what starts at the lights finds caustics 4 to 200 times sooner than paths from the eye"},
    [MOVING] = {{"direct-radiance", "direct-radiance", "direct-radiance"}, "every frame anew, whatever moves"},
};

/* What may be left out of a picture, where no error was asked for. */
static const double tolerance_of_quality[] = {[SL_QUALITY_DRAFT] = 0.15, [SL_QUALITY_NORMAL] = 0.1, [SL_QUALITY_HIGH] = 0.05};
/* Light that is missing is not missing evenly: in the Cornell box 9 % of it are 18 % of relative RMSE. */
static const double error_of_share = 2.0;
static const double hardly_direct = 0.1; /* less direct light than that: lamps are hidden from most of what is seen */

/* ---- where its light comes from ------------------------------------------------------------------------------------------ */

static double mean_of(const sl_image *image) {
    size_t values = (size_t)(3 * image->width * image->height), finite = 0;
    double sum = 0.0;
    for (size_t i = 0; i < values; i++) {
        if (!isfinite(image->planes[i])) continue;
        sum += (double)image->planes[i];
        finite++;
    }
    return finite ? sum / (double)finite : 0.0;
}

static sl_status mean_light(const sl_scene *scene, const sl_settings *base, const char *method, const char *transport, double *mean,
                            sl_error *error) {
    sl_settings s = sl_settings_default();
    sl_method *m = NULL;
    sl_image *image = NULL;
    sl_progress progress = {0};
    int width = base->width, height = base->height;
    if (!width || !height) sl_scene_film(scene, &width, &height);
    double shrink = sqrt(1024.0 / ((double)width * (double)height));
    s.width = width * shrink < 1.0 ? 1 : (int)(width * shrink + 0.5);
    s.height = height * shrink < 1.0 ? 1 : (int)(height * shrink + 0.5);
    s.method = method;
    s.transport = transport;
    s.seed = base->seed;
    s.threads = base->threads;
    s.spp = 16;
    s.bounces = 64;
    s.glossy_hits = true;
    sl_status status = sl_method_create(scene, &s, &m, error);
    while (status == SL_OK && !progress.done) status = sl_method_update(m, &progress, error);
    if (status == SL_OK) status = sl_method_resolve(m, &image, error);
    if (status == SL_OK) *mean = mean_of(image);
    sl_image_destroy(image);
    sl_method_destroy(m);
    return status;
}

static double at_least(double a, double b) { return a > b ? a : b; }

static sl_status measure_light(const sl_scene *scene, const sl_settings *base, bool mirrors, light_shares *l, sl_error *error) {
    double direct = 0.0, one = 0.0, surfaces = 0.0, all;
    sl_status status = mean_light(scene, base, "path", "direct", &direct, error);
    if (status == SL_OK) status = mean_light(scene, base, "path", "one-bounce", &one, error);
    if (status == SL_OK) status = mean_light(scene, base, "path", "matched:splatting", &surfaces, error);
    all = surfaces;
    if (status == SL_OK && mirrors) status = mean_light(scene, base, "bidirectional", "full", &all, error);
    one = at_least(one, direct); /* noise must not make shares negative */
    surfaces = at_least(surfaces, one);
    all = at_least(all, surfaces);
    *l = (light_shares){.lit = all > 0.0};
    if (!l->lit) return status;
    l->direct = direct / all;
    l->second = (one - direct) / all;
    l->further = (surfaces - one) / all;
    l->mirrored = (all - surfaces) / all;
    return status;
}

/* ---- the choice ---------------------------------------------------------------------------------------------------------- */

static budget_class class_of(const sl_auto_budget *b) {
    enum { ROUGH_SECONDS = 1 };
    if (b->error > 0.0) return b->error >= 0.1 ? ROUGH : b->error >= 0.03 ? MIDDLE : FINE;
    if (b->time_seconds > 0.0) return b->time_seconds < ROUGH_SECONDS ? ROUGH : MIDDLE;
    return b->quality == SL_QUALITY_DRAFT ? ROUGH : b->quality == SL_QUALITY_NORMAL ? MIDDLE : FINE;
}

static bool may_be_missing(double share, double tolerance) { return error_of_share * share <= tolerance; }

static kind kind_of(const light_shares *l, double tolerance, bool things_move) {
    if (!l->lit) return NOTHING_LIT;
    if (things_move) return MOVING;
    if (!may_be_missing(l->mirrored, tolerance)) return CAUSTICS;
    if (l->direct < hardly_direct) return HIDDEN_LIGHT;
    if (may_be_missing(l->second + l->further, tolerance)) return DIRECT_LIGHT;
    return may_be_missing(l->further, tolerance) ? ONE_BOUNCE : MANY_BOUNCES;
}

sl_status sl_auto_method(const sl_scene *scene, const sl_settings *settings, const sl_auto_budget *budget, sl_auto_choice *choice,
                         sl_error *error) {
    enum { BOUNCES = 8 };
    sl_features f = sl_scene_features(scene);
    light_shares l;
    *choice = (sl_auto_choice){0};
    sl_status status = measure_light(scene, settings, f.mirror_triangles > 0, &l, error);
    if (status != SL_OK) return status;
    double tolerance = budget->error > 0.0 ? budget->error : tolerance_of_quality[budget->quality];
    kind k = kind_of(&l, tolerance, budget->things_move);
    choice->method = table[k].method[class_of(budget)];
    bool several = k == MANY_BOUNCES && strcmp(choice->method, "splatting") == 0;
    choice->bounces = several ? BOUNCES : 0;
    int used = snprintf(choice->why, sizeof choice->why, "%s%s", choice->method, several ? ", 8 bounces" : "");
    if (l.lit)
        snprintf(choice->why + used, sizeof choice->why - (size_t)used,
                 ": of the light %.0f %% is direct, %.0f %% comes by one diffuse surface, %.0f %% by more, %.0f %% by mirrors; %s", 100.0 * l.direct,
                 100.0 * l.second, 100.0 * l.further, 100.0 * l.mirrored, table[k].because);
    else
        snprintf(choice->why + used, sizeof choice->why - (size_t)used, ": %s", table[k].because);
    return SL_OK;
}

sl_status sl_auto_settle(const sl_scene *scene, const sl_auto_budget *budget, bool quiet, sl_settings *settings, sl_error *error) {
    sl_auto_choice choice;
    if (!settings->method || strcmp(settings->method, "auto") != 0) return SL_OK;
    sl_status status = sl_auto_method(scene, settings, budget, &choice, error);
    if (status != SL_OK) return status;
    settings->method = choice.method;
    if (choice.bounces && !settings->bounces) settings->bounces = choice.bounces;
    if (!quiet) fprintf(stderr, "softlux: method %s\n", choice.why);
    return SL_OK;
}
