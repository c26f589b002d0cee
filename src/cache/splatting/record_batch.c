#include "cache/splatting/record_batch.h"

#include "base/batch.h"

/* ---- one record ---- */

static void gather_at(const sl_record_batch *b, unsigned worker, const sl_gather_point *point,
                      sl_irradiance *irradiance, float *coefficients, sl_counters *counters) {
    const sl_gathers *g = b->gathers;
    if (!coefficients) sl_gather_irradiance(g->gather, point, g->scratch[worker], irradiance, counters);
    else sl_gather_radiance(g->gather, point, g->scratch[worker], irradiance, coefficients, counters);
}

/* A point that sees mostly the insides of things lies within an intersection of surfaces. */
static bool is_inside(const sl_record_batch *b, const sl_irradiance *e) {
    return e->back_share > 0.5f && e->harmonic_mean < 1e-3f * b->scene->scale;
}

/* Inside of something it tries again a little further out, and if that does not help it reaches no further
 * than R_min. */
static void gather_one(void *context, size_t index, unsigned worker, void *result, sl_counters *counters) {
    const sl_record_batch *b = context;
    const sl_gather_point *point = &b->point[index];
    float *coefficients = b->coefficient_count ? b->coefficients + index * b->coefficient_count : NULL;
    sl_radius_rules rules = b->radii;
    sl_irradiance e;
    gather_at(b, worker, point, &e, coefficients, counters);
    if (is_inside(b, &e)) {
        sl_gather_point outer = *point;
        outer.position = sl_mad(point->position, 1e-4f * b->scene->scale, point->geometric_normal);
        gather_at(b, worker, &outer, &e, coefficients, counters);
        if (is_inside(b, &e)) e.harmonic_mean = e.nearest = 0.0f, e.curvature = INFINITY;
    }
    rules.guard = rules.guard && !(b->tracer && rules.metric == SL_METRIC_HESSIAN);
    sl_record *record = result;
    *record = sl_record_make(point, &e, &rules, b->footprint[index]);
    if (b->tracer)
        sl_record_find_walls(b->scene, b->tracer, point, rules.accuracy, sl_record_guard(&e, &b->radii),
                             record, counters);
}

void sl_record_batch_gather(sl_record_batch *b, sl_counters *counters) {
    const sl_batch_plane coefficients = {b->coefficients, b->coefficient_count * sizeof *b->coefficients};
    const sl_batch batch = {.count = b->count, .work = gather_one, .context = b, .results = b->record,
                            .result_bytes = sizeof *b->record, .shared = true, .planes = &coefficients,
                            .plane_count = b->coefficient_count > 0};
    sl_batch_run(&batch, b->gathers->threads, counters);
}
