/* Probe pixels: where they lie, and the path tracing of two independent estimates of each.
 *
 * A group of sixteen probes takes sixteen successive points of a Sobol' sequence, scrambled for this group alone: one in each of 4 x 4
 * cells of the picture. So a group sees the whole picture, groups are independent, and more of them can always be added. */
#include "base/counters.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/random.h"
#include "cache/audit/audit.h"
#include "cache/method.h"
#include "image/metrics.h"
#include "trace/halves.h"
#include "trace/path_walk.h"

#include <math.h>

enum { GROUP = SL_PACKET };
static const uint64_t probe_salt = 0x70726f6265u; /* probes must not repeat the random numbers of the picture that they judge */
static const uint64_t most_probes = (uint64_t)1 << 26;

struct sl_error_probe {
    const sl_scene *scene;
    sl_tracer *tracer;
    sl_light_sampler *lights;
    sl_sequence sequence;
    sl_path_walk walk;
    sl_path_lens lens;
    unsigned threads;
    uint64_t seed;
    bool blind;
    size_t probes;   /* a whole number of groups */
    uint32_t samples; /* of each half */
    sl_halves halves; /* one "pixel" for each probe */
    sl_counters counters, *worker_counters;
};

/* Light of a point, spot or directional light that a mirror throws on a surface (L S D): no ray from there can hit such a light. */
static bool is_blind(const sl_scene *scene, const sl_transport *transport) {
    if (!(transport->bounce_lobes & SL_LOBE_MIRROR) || transport->bounces == 0 || !scene->light_count) return false;
    for (size_t i = 0; i < scene->material_count; i++) {
        if (sl_material_is_mirror(&scene->materials[i])) return true;
    }
    return false;
}

sl_status sl_error_probe_create(const sl_scene *scene, const sl_settings *settings, sl_error_probe **out, sl_error *error) {
    *out = NULL;
    sl_transport transport;
    int width = settings->width, height = settings->height;
    sl_status status = sl_method_transport(settings, &transport, error);
    if (status != SL_OK) return status;
    if (width == 0 && height == 0) sl_scene_film(scene, &width, &height);
    if (width < 1 || height < 1 || width > 32768 || height > 32768)
        return sl_fail(error, SL_ERROR_USAGE, "expected a size of 1 to 32768 pixels each way, got %dx%d", width, height);
    sl_error_probe *p = sl_allocate(1, sizeof *p);
    if (!p) return sl_fail_memory(error, "error probes");
    p->scene = scene;
    p->threads = sl_thread_count(settings->threads);
    p->seed = sl_hash64(settings->seed ^ probe_salt);
    p->lens = sl_path_lens_of(scene, width, height);
    p->blind = is_blind(scene, &transport);
    p->worker_counters = sl_allocate(p->threads, sizeof *p->worker_counters);
    if (!p->worker_counters) status = sl_fail_memory(error, "error probes");
    if (status == SL_OK) status = sl_tracer_create(scene, p->threads, NULL, &p->tracer, error);
    if (status == SL_OK) status = sl_light_sampler_create(scene, &p->lights, error);
    if (status != SL_OK) {
        sl_error_probe_destroy(p);
        return status;
    }
    sl_sequence_make(&p->sequence);
    p->walk = (sl_path_walk){scene, p->tracer, p->lights, &p->sequence, transport};
    *out = p;
    return SL_OK;
}

void sl_error_probe_destroy(sl_error_probe *p) {
    if (!p) return;
    sl_halves_release(&p->halves);
    sl_light_sampler_destroy(p->lights);
    sl_tracer_destroy(p->tracer);
    sl_free(p->worker_counters);
    sl_free(p);
}

const sl_counters *sl_error_probe_counters(const sl_error_probe *p) { return &p->counters; }

/* ---- tracing ------------------------------------------------------------------------------------------------------------- */

static void pixel_of(const sl_error_probe *p, size_t probe, int *x, int *y) {
    float point[3];
    sl_sequence_point(&p->sequence, sl_random_key(p->seed, 2 * (probe / GROUP) + 1), SL_SET_PIXEL, (uint32_t)(probe % GROUP), point);
    *x = (int)((double)point[0] * p->lens.width);
    *y = (int)((double)point[1] * p->lens.height);
}

typedef struct stretch { /* samples [first, end) of each half, for groups from first_group on */
    sl_error_probe *p;
    size_t first_group;
    uint32_t first, end;
} stretch;

static void trace_sample(const sl_error_probe *p, size_t group, unsigned half, uint32_t index, sl_counters *counters) {
    sl_ray16 rays;
    uint64_t keys[GROUP];
    sl_rgb radiance[GROUP];
    for (unsigned i = 0; i < GROUP; i++) {
        size_t probe = GROUP * group + i;
        int x, y;
        pixel_of(p, probe, &x, &y);
        keys[i] = sl_random_key(sl_hash64(p->seed), SL_HALVES * probe + half);
        sl_path_camera_ray(&p->walk, &p->lens, x, y, keys[i], index, &rays, i);
    }
    sl_path_walk_radiance(&p->walk, &rays, GROUP, false, keys, index, radiance, counters);
    sl_count(counters, SL_COUNT_SAMPLES, GROUP);
    for (unsigned i = 0; i < GROUP; i++)
        sl_halves_add(&p->halves, half, GROUP * group + i, sl_path_finite_or_black(radiance[i], counters));
}

static void trace_group(void *context, size_t task, unsigned worker) {
    const stretch *s = context;
    sl_counters counters = {{0}};
    for (unsigned half = 0; half < SL_HALVES; half++) {
        for (uint32_t index = s->first; index < s->end; index++) trace_sample(s->p, s->first_group + task, half, index, &counters);
    }
    sl_counters_add(&s->p->worker_counters[worker], &counters);
}

static void trace_stretch(sl_error_probe *p, size_t first_probe, uint32_t first, uint32_t end) {
    stretch s = {p, first_probe / GROUP, first, end};
    if (first >= end || first_probe >= p->probes) return;
    for (unsigned i = 0; i < p->threads; i++) p->worker_counters[i] = (sl_counters){{0}};
    sl_parallel_for(p->threads, (p->probes - first_probe) / GROUP, trace_group, &s);
    for (unsigned i = 0; i < p->threads; i++) sl_counters_add(&p->counters, &p->worker_counters[i]);
}

/* Room for more probes; what the others hold is kept. */
static sl_status grow(sl_error_probe *p, size_t probes, sl_error *error) {
    sl_halves larger;
    sl_status status = sl_halves_create(&larger, probes, error);
    if (status != SL_OK) {
        sl_halves_release(&larger);
        return status;
    }
    for (unsigned half = 0; half < SL_HALVES; half++) {
        for (size_t i = 0; i < p->probes; i++) {
            for (size_t c = 0; c < 3; c++) larger.sums[half][c * probes + i] = p->halves.sums[half][c * p->probes + i];
        }
    }
    sl_halves_release(&p->halves);
    p->halves = larger;
    p->probes = probes;
    return SL_OK;
}

sl_status sl_error_probe_trace(sl_error_probe *p, uint64_t probes, uint32_t samples, sl_error *error) {
    if (probes > most_probes) return sl_fail(error, SL_ERROR_USAGE, "at most %llu probes", (unsigned long long)most_probes);
    size_t before = p->probes, wanted = ((size_t)probes + GROUP - 1) / GROUP * GROUP;
    if (wanted > before) {
        sl_status status = grow(p, wanted, error);
        if (status != SL_OK) return status;
        trace_stretch(p, before, 0, p->samples);
    }
    if (samples > p->samples) {
        trace_stretch(p, 0, p->samples, samples);
        p->samples = samples;
    }
    return SL_OK;
}

/* ---- judging a picture --------------------------------------------------------------------------------------------------- */

static sl_audit_group audit_group(const sl_error_probe *p, size_t group, const float *const planes[3]) {
    sl_audit_group g = {0};
    double scale = 1.0 / (double)p->samples;
    for (size_t probe = GROUP * group; probe < GROUP * (group + 1); probe++) {
        int x, y;
        pixel_of(p, probe, &x, &y);
        size_t pixel = (size_t)y * (size_t)p->lens.width + (size_t)x;
        if (!isfinite(planes[0][pixel]) || !isfinite(planes[1][pixel]) || !isfinite(planes[2][pixel])) continue;
        double squares = 0.0;
        for (size_t c = 0; c < 3; c++) {
            double value = (double)planes[c][pixel], a = scale * p->halves.sums[0][c * p->probes + probe],
                   b = scale * p->halves.sums[1][c * p->probes + probe];
            squares += sl_audit_square(value, a, b);
            g.differences += value - 0.5 * (a + b);
            g.noise += 0.5 * (a - b) * (a - b);
        }
        g.squares += squares;
        if (squares / 3.0 > g.largest) g.largest = squares / 3.0;
        g.values += 3;
    }
    return g;
}

sl_status sl_error_probe_estimate(const sl_error_probe *p, const sl_image *image, sl_error_estimate *estimate, sl_error *error) {
    const float *planes[3];
    *estimate = (sl_error_estimate){.blind = p->blind};
    if (image->width != p->lens.width || image->height != p->lens.height)
        return sl_fail(error, SL_ERROR_INPUT, "the image has %d x %d pixels, the probes are of one with %d x %d", image->width, image->height,
                       p->lens.width, p->lens.height);
    sl_status status = sl_image_colour_planes(image, "image", planes, error);
    if (status != SL_OK) return status;
    if (!p->probes || !p->samples) return sl_fail(error, SL_ERROR_USAGE, "no probes have been traced yet");
    size_t groups = p->probes / GROUP;
    sl_audit_group *group = sl_allocate(groups, sizeof *group);
    if (!group) return sl_fail_memory(error, "an estimate of an error");
    for (size_t i = 0; i < groups; i++) group[i] = audit_group(p, i, planes);
    double mean = sl_audit_mean(planes, (size_t)image->width * (size_t)image->height, &estimate->nonfinite);
    estimate->probes = p->probes;
    estimate->samples = (uint64_t)p->probes * SL_HALVES * p->samples;
    sl_audit_conclude(group, groups, mean, estimate);
    sl_free(group);
    return SL_OK;
}

/* ---- until it is clear --------------------------------------------------------------------------------------------------- */

enum { FIRST_PROBES = 256, FIRST_SAMPLES = 16 };

static double larger_of(double a, double b) { return a > b ? a : b; }

/* Noise of the probes' own values adds its square, over the root of their number, to what the squared error is uncertain by: while it
 * is above the error asked for, twice the samples lower that fourfold for the same price as twice the probes. */
sl_status sl_error_probe_judge(sl_error_probe *p, const sl_image *image, double rel_rmse, sl_error_estimate *e, sl_error *error) {
    if (!(rel_rmse > 0.0)) return sl_fail(error, SL_ERROR_USAGE, "expected an error above 0 to judge by, got %g", rel_rmse);
    double most = 4e6 + 4e3 / (rel_rmse * rel_rmse);
    sl_status status = sl_error_probe_trace(p, FIRST_PROBES, FIRST_SAMPLES, error);
    if (status == SL_OK) status = sl_error_probe_estimate(p, image, e, error);
    while (status == SL_OK && !(e->bound <= rel_rmse) && !(e->least > rel_rmse) && !e->nonfinite && 2.0 * (double)e->samples <= most &&
           p->probes < most_probes && p->samples <= UINT32_MAX / 2) {
        bool noisy = e->noise > larger_of(e->rmse, rel_rmse * fabs(e->mean));
        status = sl_error_probe_trace(p, noisy ? p->probes : 2 * p->probes, noisy ? 2 * p->samples : p->samples, error);
        if (status == SL_OK) status = sl_error_probe_estimate(p, image, e, error);
    }
    return status;
}
