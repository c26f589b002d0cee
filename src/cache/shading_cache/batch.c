/* Batches of requests over threads: each is a function of itself, its answer goes to its own place. */
#include "base/counters.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/shading_cache/renderer_parts.h"

typedef struct batch {
    sl_render_point *render;
    const void *state;
    const sl_sample_request *requests;
    sl_sample *samples;
    sl_counters *counters; /* by worker */
} batch;

static void render_one(void *context, size_t i, unsigned worker) {
    const batch *b = context;
    b->samples[i] = (sl_sample){.valid = true};
    if (!sl_request_is_sound(&b->requests[i])) {
        b->samples[i] = (sl_sample){.broken = true};
        sl_count(&b->counters[worker], SL_COUNT_NONFINITE, 1);
        return;
    }
    b->render(b->state, &b->requests[i], worker, &b->samples[i], &b->counters[worker]);
    const sl_sample *s = &b->samples[i];
    if (sl_rgb_is_finite(s->irradiance) && sl_rgb_is_finite(s->radiance) && isfinite(s->variance)) return;
    b->samples[i] = (sl_sample){.broken = true};
    sl_count(&b->counters[worker], SL_COUNT_NONFINITE, 1);
}

void sl_render_each(sl_render_point *render, const void *state, size_t count, const sl_sample_request *requests, unsigned threads,
                    sl_sample *samples, sl_counters *counters) {
    sl_counters *by_worker = threads > 1 ? sl_allocate(threads, sizeof *by_worker) : NULL;
    batch b = {render, state, requests, samples, by_worker ? by_worker : counters};
    sl_parallel_for(by_worker ? threads : 1, count, render_one, &b);
    for (unsigned w = 0; by_worker && w < threads; w++) sl_counters_add(counters, &by_worker[w]);
    sl_free(by_worker);
}

bool sl_request_is_sound(const sl_sample_request *q) {
    const sl_root_point *p = &q->point;
    return sl_is_finite(p->position) && sl_is_finite(p->normal) && sl_is_finite(p->geometric_normal) && sl_dot(p->normal, p->normal) > 0.0f &&
           sl_dot(p->geometric_normal, p->geometric_normal) > 0.0f;
}

bool sl_request_wants_irradiance(const sl_sample_request *q) { return !q->material || sl_material_is_diffuse(q->material); }

bool sl_request_wants_lobe(const sl_sample_request *q) { return q->radiance && q->material && sl_material_is_glossy(q->material); }

bool sl_request_wants_mirror(const sl_sample_request *q) { return q->radiance && q->material && sl_material_is_mirror(q->material); }

bool sl_request_lobe(const sl_sample_request *q, sl_bsdf *lobe) {
    if (!sl_request_wants_lobe(q)) return false;
    sl_vec3 to_eye = sl_normalize_or(sl_sub(q->eye, q->point.position), sl_v3(0.0f, 0.0f, 0.0f));
    if (!(sl_dot(to_eye, q->point.geometric_normal) > 0.0f)) return false;
    *lobe = (sl_bsdf){.specular = sl_grey(1.0f),
                      .exponent = q->material->exponent,
                      .normal = q->point.normal,
                      .geometric_normal = q->point.geometric_normal};
    sl_bsdf_turn(lobe, to_eye, SL_LOBE_GLOSSY);
    return true;
}
