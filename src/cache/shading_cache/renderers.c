/* Batches of requests on the workers (base/batch.h), and the parts that a request asks for. */
#include "base/batch.h"
#include "base/random.h"
#include "cache/shading_cache/renderers.h"

typedef struct point_batch {
    const sl_sample_renderer *renderer;
    const sl_sample_request *requests;
} point_batch;

static bool is_finite(const sl_sample *s) {
    return sl_rgb_is_finite(s->irradiance) && sl_rgb_is_finite(s->radiance) && isfinite(s->variance);
}

/* Tells whether position and normals are finite, and normals have a length. */
static bool is_sound(const sl_lit_point *p) {
    return sl_is_finite(p->position) && sl_is_finite(p->normal) && sl_is_finite(p->geometric_normal) &&
           sl_dot(p->normal, p->normal) > 0.0f && sl_dot(p->geometric_normal, p->geometric_normal) > 0.0f;
}

static void render_one(void *context, size_t index, unsigned worker, void *result, sl_counters *counters) {
    const point_batch *b = context;
    sl_sample *sample = result;
    *sample = (sl_sample){.valid = true};
    if (b->requests[index].passed_over) return;
    bool sound = is_sound(&b->requests[index].point);
    if (sound) b->renderer->render(b->renderer->state, &b->requests[index], worker, sample, counters);
    if (sound && is_finite(sample)) return;
    *sample = (sl_sample){.broken = true};
    sl_count(counters, SL_COUNT_NONFINITE, 1);
}

void sl_render(const sl_sample_renderer *renderer, size_t count, const sl_sample_request *requests,
               unsigned threads, sl_sample *samples, sl_counters *counters) {
    point_batch points = {renderer, requests};
    if (renderer->prepare) renderer->prepare(renderer->state, count, requests);
    sl_batch batch = {.count = count, .work = render_one, .context = &points, .results = samples,
                      .result_bytes = sizeof *samples, .shared = true};
    sl_batch_run(&batch, threads, counters);
}

bool sl_request_wants_irradiance(const sl_sample_request *q) {
    return !q->material || sl_material_is_diffuse(q->material);
}

bool sl_request_wants_lobe(const sl_sample_request *q) {
    return q->radiance && q->material && sl_material_is_glossy(q->material);
}

bool sl_request_wants_mirror(const sl_sample_request *q) {
    return q->radiance && q->material && sl_material_is_mirror(q->material);
}

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

void sl_request_sky_light(const sl_renderer_settings *settings, const sl_sequence *sequence,
                          const sl_sample_request *q, int samples, sl_sample *sample,
                          sl_counters *counters) {
    enum { SKY_STREAM = 0x736b79 };
    sl_bsdf lobe;
    bool has_lobe = sl_request_lobe(q, &lobe);
    uint32_t count = (uint32_t)samples;
    sl_light_numbers numbers = {sequence, sl_random_key(settings->seed, SKY_STREAM), q->set * count, count};
    sl_sky_light sky =
        sl_sky_light_at(settings->scene, *settings->tracer, &q->point, sl_request_wants_irradiance(q),
                        has_lobe ? &lobe : NULL, &numbers, counters);
    sample->irradiance = sl_rgb_add(sample->irradiance, sky.irradiance);
    if (has_lobe)
        sample->radiance = sl_rgb_add(sample->radiance, sl_rgb_mul(sky.lobe, q->material->specular));
    sample->variance += (float)sky.variance;
}
