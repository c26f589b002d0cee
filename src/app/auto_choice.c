#include "app/auto_choice.h"

#include <math.h>

/* Time grows with the number of pixels to this power: samples belong to pixels, records and photons to the
 * scene (Cornell box, 64 x 64 to 256 x 256). */
static const struct candidate {
    const char *curve;
    double growth;
} candidates[SL_AUTO_CANDIDATES] = {
    [SL_AUTO_SPLATTING] = {"splatting", 0.5},
    [SL_AUTO_SPLATTING_ON] = {"splatting, 6 bounces", 0.25},
    [SL_AUTO_DIRECT_RADIANCE] = {"direct-radiance", 0.7},
    [SL_AUTO_LIGHT_OCTREE] = {"light-octree", 0.1},
    [SL_AUTO_MULTI_MESH] = {"multi-mesh", 0.4},
    [SL_AUTO_SHADING_CACHE] = {"shading-cache", 1.0},
    [SL_AUTO_PATH] = {"path, full", 1.0},
    [SL_AUTO_BIDIRECTIONAL] = {"bidirectional, full", 1.0},
};

double sl_auto_error_of(sl_auto_class class) {
    static const double errors[SL_AUTO_CLASSES] = {0.15, 0.05, 0.02};
    return errors[class];
}

const char *sl_auto_curve_of(sl_auto_candidate candidate) { return candidates[candidate].curve; }

/* ---- which scenes are alike ---- */

static double square(double x) { return x * x; }

/* Returns how unlike: a tenth of the light by another way, or ten times the triangles, or four times the
 * lights: one unit or so.
 */
double sl_auto_distance(const sl_auto_kind *a, const sl_auto_kind *b) {
    double d = square((a->direct - b->direct) / 0.2) + square((a->second - b->second) / 0.2) +
               square((a->further - b->further) / 0.1) + square((a->mirrored - b->mirrored) / 0.05);
    d += 0.5 * (a->glossy != b->glossy) + 1.0 * (a->mirrors != b->mirrors) + 0.5 * (a->open != b->open);
    d += square((log10(1.0 + a->triangles) - log10(1.0 + b->triangles)) / 1.5) +
         square((log10(1.0 + a->lights) - log10(1.0 + b->lights)) / 1.0);
    return sqrt(d);
}

/* ---- what leaves out too much ---- */

/* Light that is missing is not missing evenly: in the Cornell box 9 % of it are 18 % of relative RMSE. */
static const double error_of_share = 2.0;

static double share_left_out(const sl_auto_kind *kind, sl_auto_candidate c) {
    switch (c) {
    case SL_AUTO_DIRECT_RADIANCE:
        if (kind->open) return 1.0; /* how much light is the sky's is not known, and it might be all */
        return kind->further + kind->mirrored;
    case SL_AUTO_SPLATTING:
    case SL_AUTO_MULTI_MESH: return kind->further + kind->mirrored;
    case SL_AUTO_SPLATTING_ON: return kind->mirrored;
    default: return 0.0;
    }
}

/* ---- the verdict ---- */

/* Logarithms of seconds are averaged, each scene's against its own best, so that a slow scene says no more
 * than a quick one. */
static void add_scene(const sl_auto_scene *s, sl_auto_class class, double weight,
                      double sum[SL_AUTO_CANDIDATES]) {
    double least = HUGE_VAL;
    for (int c = 0; c < SL_AUTO_CANDIDATES; c++) least = fmin(least, s->seconds[class][c]);
    for (int c = 0; c < SL_AUTO_CANDIDATES; c++) sum[c] += weight * log(s->seconds[class][c] / least);
}

sl_auto_verdict sl_auto_judge(const sl_auto_scene *measured, size_t count, const sl_auto_scene *left_out,
                              const sl_auto_kind *kind, double pixels, sl_auto_class class, double error) {
    sl_auto_verdict v = {.best = SL_AUTO_PATH};
    double sum[SL_AUTO_CANDIDATES] = {0}, weights = 0.0, nearest = HUGE_VAL, size = 1.0, least = HUGE_VAL;
    for (size_t i = 0; i < count; i++) {
        const sl_auto_scene *s = &measured[i];
        if (s == left_out) continue;
        /* Inverse squares: more local weights followed single scenes too closely when each was left out in
         * turn. */
        double d = sl_auto_distance(kind, &s->kind), weight = 1.0 / (0.1 + square(d));
        add_scene(s, class, weight, sum);
        weights += weight;
        if (d < nearest) nearest = d, v.like = s, size = pixels / s->pixels;
    }
    for (int c = 0; c < SL_AUTO_CANDIDATES; c++) {
        bool blind = error_of_share * share_left_out(kind, (sl_auto_candidate)c) > error ||
                     (!v.like && c != SL_AUTO_PATH);
        v.cost[c] = blind ? HUGE_VAL
                          : exp((weights > 0.0 ? sum[c] / weights : 0.0) + candidates[c].growth * log(size));
        if (v.cost[c] < least) least = v.cost[c], v.best = (sl_auto_candidate)c;
    }
    for (int c = 0; c < SL_AUTO_CANDIDATES; c++) v.cost[c] /= least;
    return v;
}
