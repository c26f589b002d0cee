/* Choosing a method. What a scene's picture is made of is measured, by path tracing small pictures of parts
 * of its light:
 *
 *     direct      straight from the lights
 *     one bounce  and by one diffuse surface
 *     surfaces    and by any number of surfaces that are no mirrors
 *     all         and thrown on surfaces by mirrors (caustics)
 *
 * Their differences in the mean say which light a method may leave out, given the error that the picture may
 * have, and which of the scenes of docs/report this one is like (auto_choice.h). Of the methods that hold the
 * rest that one is taken which reached the error first in those. */
#include "app/auto_method.h"

#include "app/auto_table.h"
#include "scene/features.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- where its light comes from -------------------------------------------------------------- */

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

static sl_settings small_picture(const sl_scene *scene, const sl_settings *base, const char *method,
                                 const char *transport) {
    sl_settings s = sl_settings_default();
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
    return s;
}

static sl_status mean_of_picture(const sl_scene *scene, const sl_settings *s, double *mean, sl_error *error) {
    sl_method *m = NULL;
    sl_image *image = NULL;
    sl_progress progress = {0};
    sl_status status = sl_method_create(scene, s, &m, error);
    while (status == SL_OK && !progress.done) status = sl_method_update(m, &progress, error);
    if (status == SL_OK) status = sl_method_resolve(m, &image, error);
    if (status == SL_OK) *mean = mean_of(image);
    sl_image_destroy(image);
    sl_method_destroy(m);
    return status;
}

static sl_status mean_light(const sl_scene *scene, const sl_settings *base, const char *method,
                            const char *transport, double *mean, sl_error *error) {
    const sl_settings s = small_picture(scene, base, method, transport);
    return mean_of_picture(scene, &s, mean, error);
}

static double at_least(double a, double b) { return a > b ? a : b; }

sl_status sl_auto_look(const sl_scene *scene, const sl_settings *base, sl_auto_kind *kind, sl_error *error) {
    sl_features f = sl_scene_features(scene);
    bool mirrors = f.mirror_triangles > 0;
    double direct = 0.0, one = 0.0, surfaces = 0.0, all;
    sl_status status = mean_light(scene, base, "path", "direct", &direct, error);
    if (status == SL_OK) status = mean_light(scene, base, "path", "one-bounce", &one, error);
    if (status == SL_OK) /* bounces off glossy surfaces count as mirrored where there are mirrors */
        status = mean_light(scene, base, "path", mirrors ? "matched:splatting" : "full", &surfaces, error);
    all = surfaces;
    if (status == SL_OK && mirrors) status = mean_light(scene, base, "bidirectional", "full", &all, error);
    one = at_least(one, direct); /* noise must not make shares negative */
    surfaces = at_least(surfaces, one);
    all = at_least(all, surfaces);
    *kind = (sl_auto_kind){
        .lit = all > 0.0, .glossy = f.glossy_triangles > 0, .mirrors = mirrors, .open = f.environment};
    kind->triangles = (double)(f.diffuse_triangles + f.glossy_triangles + f.mirror_triangles);
    kind->lights = (double)(f.emitters + f.point_lights + f.spot_lights + f.directional_lights);
    if (!kind->lit) return status;
    kind->direct = direct / all;
    kind->second = (one - direct) / all;
    kind->further = (surfaces - one) / all;
    kind->mirrored = (all - surfaces) / all;
    return status;
}

/* Measures light that the eye sees in mirrors, by one surface at most: multi-mesh caching declares the same
 * light paths, but for these. As a share of that light. */
static sl_status look_into_mirrors(const sl_scene *scene, const sl_settings *base, double *seen,
                                   sl_error *error) {
    sl_settings with = small_picture(scene, base, "path", "one-bounce"),
                without = small_picture(scene, base, "path", "matched:multi-mesh");
    double all = 0.0, plain = 0.0;
    with.filter = without.filter = SL_FILTER_CENTRE;
    without.bounces = 1;
    sl_status status = mean_of_picture(scene, &with, &all, error);
    if (status == SL_OK) status = mean_of_picture(scene, &without, &plain, error);
    *seen = all > plain ? (all - plain) / all : 0.0;
    return status;
}

/* ---- the choice ------------------------------------------------------------------------------ */

static sl_auto_class class_of(const sl_auto_budget *b) {
    enum { ROUGH_SECONDS = 1 };
    if (b->error > 0.0)
        return b->error >= 0.1 ? SL_AUTO_ROUGH : b->error >= 0.03 ? SL_AUTO_MIDDLE : SL_AUTO_FINE;
    if (b->time_seconds > 0.0) return b->time_seconds < ROUGH_SECONDS ? SL_AUTO_ROUGH : SL_AUTO_MIDDLE;
    return b->quality == SL_QUALITY_DRAFT    ? SL_AUTO_ROUGH
           : b->quality == SL_QUALITY_NORMAL ? SL_AUTO_MIDDLE
                                             : SL_AUTO_FINE;
}

/* Returns what may be left out of a picture, where no error was asked for. */
static double tolerance_of(const sl_auto_budget *b) {
    static const double of_quality[] = {
        [SL_QUALITY_DRAFT] = 0.15, [SL_QUALITY_NORMAL] = 0.1, [SL_QUALITY_HIGH] = 0.05};
    return b->error > 0.0 ? b->error : of_quality[b->quality];
}

static const char *const methods[SL_AUTO_CANDIDATES] = {
    [SL_AUTO_SPLATTING] = "splatting",
    [SL_AUTO_SPLATTING_ON] = "splatting",
    [SL_AUTO_DIRECT_RADIANCE] = "direct-radiance",
    [SL_AUTO_LIGHT_OCTREE] = "light-octree",
    [SL_AUTO_MULTI_MESH] = "multi-mesh",
    [SL_AUTO_SHADING_CACHE] = "shading-cache",
    [SL_AUTO_PATH] = "path",
    [SL_AUTO_BIDIRECTIONAL] = "bidirectional",
};

/* Why, from the measurements: where the choice is from, and what path tracing would take. */
static void explain(const sl_auto_verdict *v, sl_auto_class class, char text[160]) {
    if (!v->like) snprintf(text, 160, "nothing like it was measured");
    else if (v->best == SL_AUTO_PATH)
        snprintf(text, 160, "in measured scenes like it (%s) nothing is at %g %% sooner", v->like->name,
                 100.0 * sl_auto_error_of(class));
    else
        snprintf(text, 160,
                 "in measured scenes like it (%s) it is at %g %% first, %.2g times sooner than paths",
                 v->like->name, 100.0 * sl_auto_error_of(class), v->cost[SL_AUTO_PATH]);
}

/* seen: the share that is seen in mirrors. */
static void tell(const sl_auto_kind *kind, double seen, const char *because, sl_auto_choice *choice) {
    int used = snprintf(choice->why, sizeof choice->why, "%s", choice->method);
    if (choice->bounces)
        used +=
            snprintf(choice->why + used, sizeof choice->why - (size_t)used, ", %u bounces", choice->bounces);
    if (kind->lit)
        used += snprintf(choice->why + used, sizeof choice->why - (size_t)used,
                         ": of the light %.0f %% is direct, %.0f %% comes by one diffuse surface, %.0f %% by "
                         "more, %.0f %% by mirrors",
                         100.0 * kind->direct, 100.0 * kind->second, 100.0 * kind->further,
                         100.0 * kind->mirrored);
    if (kind->lit && kind->mirrors)
        used += snprintf(choice->why + used, sizeof choice->why - (size_t)used,
                         ", and %.0f %% is seen in them", 100.0 * seen);
    snprintf(choice->why + used, sizeof choice->why - (size_t)used, "%s %s", kind->lit ? ";" : ":", because);
}

sl_status sl_auto_method(const sl_scene *scene, const sl_settings *settings, const sl_auto_budget *budget,
                         sl_auto_choice *choice, sl_error *error) {
    enum { BOUNCES = 6 }; /* as measured */
    sl_auto_kind kind;
    char because[160];
    int width = settings->width, height = settings->height;
    *choice = (sl_auto_choice){.method = "path"};
    sl_status status = sl_auto_look(scene, settings, &kind, error);
    if (status != SL_OK) return status;
    if (!width || !height) sl_scene_film(scene, &width, &height);
    sl_auto_class class = class_of(budget);
    if (!kind.lit) {
        snprintf(because, sizeof because, "nothing in the picture is lit");
    } else if (budget->things_move) {
        choice->method = "direct-radiance";
        snprintf(because, sizeof because, "every frame anew, whatever moves");
    } else if (2.0 * (1.0 - kind.direct) <= tolerance_of(budget)) {
        snprintf(because, sizeof because, "a few light samples a pixel are exact soon");
    } else {
        sl_auto_verdict v = sl_auto_judge(measured, sizeof measured / sizeof *measured, NULL, &kind,
                                          (double)width * (double)height, class, tolerance_of(budget));
        choice->method = methods[v.best];
        choice->bounces = v.best == SL_AUTO_SPLATTING_ON ? BOUNCES : 0;
        explain(&v, class, because);
    }
    double seen = 0.0;
    if (kind.lit && kind.mirrors) status = look_into_mirrors(scene, settings, &seen, error);
    tell(&kind, seen, because, choice);
    return status;
}

sl_status sl_auto_settle(const sl_scene *scene, const sl_auto_budget *budget, bool quiet,
                         sl_settings *settings, sl_error *error) {
    sl_auto_choice choice;
    if (!settings->method || strcmp(settings->method, "auto") != 0) return SL_OK;
    sl_status status = sl_auto_method(scene, settings, budget, &choice, error);
    if (status != SL_OK) return status;
    settings->method = choice.method;
    if (choice.bounces && !settings->bounces) settings->bounces = choice.bounces;
    if (!quiet) fprintf(stderr, "softlux: method %s\n", choice.why);
    return SL_OK;
}
