/* Probe pixels: which ones, and what they say of a picture.
 *
 * A picture's squared error may lie in a few pixels: where a lamp's image in a mirror is off by a pixel, one
 * pixel can hold more of it than all others. So every pixel (of large pictures, one of each block) is traced
 * once, the pilot, and pixels in which that differs much from the picture are probed with a higher
 * probability: half of the probes go by (x - pilot)^2, the other half anywhere. The pilot only chooses; the
 * values that judge are traced independently of it, and each chosen pixel counts by 1 over its probability,
 * which keeps the estimate unbiased.
 *
 * Each pixel has a random number of its own, and is chosen where that is below its probability (Poisson
 * sampling with permanent numbers): so that for another picture of the scene, or for more probes, mostly the
 * same pixels are chosen, whose values are there. */
#include "base/error.h"
#include "base/memory.h"
#include "base/random.h"
#include "cache/audit/audit.h"
#include "cache/audit/trace_probes.h"
#include "cache/frame/method.h"

#include <math.h>

/* probes must not repeat the random numbers of the picture that they judge */
static const uint64_t probe_salt = 0x70726f6265u;

struct sl_error_probe {
    sl_probe_tracer tracer;
    uint64_t probes;  /* that the last estimate asked for, */
    uint32_t samples; /* and samples of each */
    bool of_surfaces; /* ... which told of pixels that show no lamp alone */
    bool blind;
};

/* Light of a point, spot or directional light that a mirror throws on a surface (L S D): no ray from there
 * can hit such a light. */
static bool is_blind(const sl_scene *scene, const sl_transport *transport) {
    if (!(transport->bounce_lobes & SL_LOBE_MIRROR) || transport->bounces == 0 || !scene->light_count)
        return false;
    for (size_t i = 0; i < scene->material_count; i++) {
        if (sl_material_is_mirror(&scene->materials[i])) return true;
    }
    return false;
}

sl_status sl_error_probe_create(const sl_scene *scene, const sl_settings *settings, sl_error_probe **out,
                                sl_error *error) {
    if (!out) return sl_fail_null(error, "a place for error probes");
    *out = NULL;
    sl_transport transport;
    sl_settings asked;
    sl_status status = sl_method_choose(scene, settings, &asked, &transport, NULL, error);
    if (status != SL_OK) return status;
    sl_error_probe *p = sl_allocate(1, sizeof *p);
    if (!p) return sl_fail_memory(error, "error probes");
    p->blind = is_blind(scene, &transport);
    status = sl_probe_tracer_create(&p->tracer, scene, &transport, asked.width, asked.height, asked.threads,
                                    sl_hash64(asked.seed ^ probe_salt), error);
    if (status == SL_OK) *out = p;
    else sl_error_probe_destroy(p);
    return status;
}

void sl_error_probe_destroy(sl_error_probe *p) {
    if (!p) return;
    sl_probe_tracer_release(&p->tracer);
    sl_free(p);
}

const sl_image *sl_error_probe_surfaces(const sl_error_probe *p) { return p->tracer.surfaces; }

const sl_counters *sl_error_probe_counters(const sl_error_probe *p) { return &p->tracer.counters; }

/* ---- which pixels ---------------------------------------------------------------------------- */

typedef struct audit {
    sl_error_probe *p;
    sl_audit_view view;    /* of the picture */
    double *chance;        /* of each pixel, for one probe; they sum to 1 */
    uint32_t *chosen;
    sl_audit_pixel *pixel; /* of each chosen one */
    size_t count;
} audit;

/* Mean over the channels of (x - pilot)^2; 0 where x is not judged. */
static double score(const audit *a, size_t i) {
    const sl_probe_tracer *t = &a->p->tracer;
    double sum = 0.0;
    if (!sl_audit_is_judged(&a->view, i)) return 0.0;
    for (size_t c = 0; c < 3; c++) {
        double d =
            (double)a->view.planes[c][i] - (double)t->pilot[c * t->blocks + sl_probe_tracer_block(t, i)];
        sum += d * d;
    }
    return sum / 3.0;
}

/* Half of the probes are spread evenly; of the others half go by the squared difference anywhere, half by
 * that on surfaces, which lamps' edges may exceed a thousandfold. */
static void set_chances(audit *a) {
    size_t pixels = a->p->tracer.pixels;
    double sum = 0.0, on_surfaces = 0.0, judged = (double)a->view.judged.count;
    for (size_t i = 0; i < pixels; i++) {
        sum += a->chance[i] = score(a, i);
        if (sl_audit_is_masked(&a->view, i)) on_surfaces += a->chance[i];
    }
    for (size_t i = 0; i < pixels; i++) {
        double even = sl_audit_is_judged(&a->view, i) ? 1.0 / judged : 0.0,
               anywhere = sum > 0.0 ? a->chance[i] / sum : even, there = anywhere;
        if (on_surfaces > 0.0)
            there = sl_audit_is_masked(&a->view, i) ? a->chance[i] / on_surfaces : 0.0;
        a->chance[i] = 0.5 * even + 0.25 * (anywhere + there);
    }
}

/* All that are judged are looked at where as many are asked for as there are. */
static double probability(const audit *a, size_t i, uint64_t probes) {
    if (probes >= a->view.judged.count) return a->chance[i] > 0.0 ? 1.0 : 0.0;
    double p = (double)probes * a->chance[i];
    return p < 1.0 ? p : 1.0;
}

static void choose(audit *a, uint64_t probes) {
    uint64_t key = sl_random_key(a->p->tracer.seed, UINT64_MAX);
    a->count = 0;
    for (size_t i = 0; i < a->p->tracer.pixels; i++) {
        if ((double)sl_random_unit(key, i) < probability(a, i, probes)) a->chosen[a->count++] = (uint32_t)i;
    }
}

static sl_status audit_begin(audit *a, sl_error_probe *p, const sl_image *image, sl_error *error) {
    const sl_path_lens *lens = &p->tracer.lens;
    *a = (audit){.p = p};
    if (image->width != lens->width || image->height != lens->height)
        return sl_fail(error, SL_ERROR_INPUT,
                       "the image has %d x %d pixels, the probes are of one with %d x %d", image->width,
                       image->height, lens->width, lens->height);
    sl_status status = sl_audit_view_of(image, p->tracer.surfaces, &a->view, error);
    if (status == SL_OK) status = sl_probe_tracer_pilot(&p->tracer, error);
    if (status != SL_OK) return status;
    size_t pixels = p->tracer.pixels;
    a->chance = sl_allocate_unset(pixels, sizeof *a->chance);
    a->chosen = sl_allocate_unset(pixels, sizeof *a->chosen);
    a->pixel = sl_allocate_unset(pixels, sizeof *a->pixel);
    if (!a->chance || !a->chosen || !a->pixel) return sl_fail_memory(error, "an estimate of an error");
    set_chances(a);
    return SL_OK;
}

static void audit_end(audit *a) {
    SL_FREE_ALL(a->chance, a->chosen, a->pixel);
}

/* ---- what they say --------------------------------------------------------------------------- */

static void value_of(const sl_audit_view *view, uint32_t pixel, double x[3]) {
    for (int c = 0; c < 3; c++) x[c] = (double)view->planes[c][pixel];
}

/* By those that are chosen. */
static sl_status audit_estimate(audit *a, uint64_t probes, uint32_t samples, sl_error_estimate *e,
                                sl_error *error) {
    sl_status status = sl_probe_tracer_trace(&a->p->tracer, a->chosen, a->count, samples, error);
    if (status != SL_OK) return status;
    a->p->probes = probes;
    a->p->samples = samples;
    for (size_t i = 0; i < a->count; i++) {
        double x[3], p[3], q[3];
        uint32_t pixel = a->chosen[i];
        value_of(&a->view, pixel, x);
        sl_probe_tracer_means(&a->p->tracer, pixel, p, q);
        a->pixel[i] = sl_audit_pixel_of(x, p, q, 1.0 / probability(a, pixel, probes));
        a->pixel[i].masked = sl_audit_is_masked(&a->view, pixel);
    }
    *e = (sl_error_estimate){.blind = a->p->blind, .nonfinite = a->view.nonfinite, .probes = a->count,
                             .samples = a->p->tracer.counters.value[SL_COUNT_SAMPLES]};
    a->p->of_surfaces = sl_audit_conclude_worse(a->pixel, a->count, &a->view, e);
    return SL_OK;
}

sl_status sl_error_probe_estimate(sl_error_probe *p, const sl_image *image, uint64_t probes, uint32_t samples,
                                  sl_error_estimate *estimate, sl_error *error) {
    audit a;
    if (estimate) *estimate = (sl_error_estimate){0};
    if (!p || !image || !estimate)
        return sl_fail_null(error, "error probes, an image and a place for an estimate");
    if (!probes || !samples)
        return sl_fail(error, SL_ERROR_USAGE, "an estimate takes at least one probe and one sample of it");
    sl_status status = audit_begin(&a, p, image, error);
    if (status == SL_OK) choose(&a, probes);
    if (status == SL_OK) status = audit_estimate(&a, probes, samples, estimate, error);
    audit_end(&a);
    return status;
}

/* ---- until it is clear ----------------------------------------------------------------------- */

enum { FIRST_PROBES = 256, FIRST_SAMPLES = 16 };
/* Noise of the probes' own values adds its square, over the root of their number, to what the squared error
 * is uncertain by: while it is above the error asked for, twice the samples lower that fourfold for the same
 * price as twice the probes. So it is, too, when every pixel has become a probe. */
static bool wants_samples(const audit *a, const sl_error_estimate *e, double rel_rmse, uint64_t probes) {
    double wanted = rel_rmse * fabs(e->mean);
    return e->noise > (e->rmse > wanted ? e->rmse : wanted) || probes / 2 >= a->p->tracer.pixels;
}

static double rays_of(const sl_counters *c) {
    return (double)(c->value[SL_COUNT_RAYS] + c->value[SL_COUNT_SHADOW_RAYS]);
}

/* In rays: what is traced already for those that are chosen, and what so many samples of each would take
 * besides. */
static double price(const audit *a, uint32_t samples) {
    const sl_counters *c = &a->p->tracer.counters;
    double rays = rays_of(c), traced = (double)c->value[SL_COUNT_SAMPLES];
    return rays + rays / traced * sl_probe_tracer_missing(&a->p->tracer, a->chosen, a->count, samples);
}

/* As many samples as that precision is worth, where nobody says what the picture is. */
static double usual_price(const audit *a, double rel_rmse) {
    const sl_counters *c = &a->p->tracer.counters;
    return (5e5 + 5e2 / (rel_rmse * rel_rmse)) * rays_of(c) / (double)c->value[SL_COUNT_SAMPLES];
}

sl_status sl_error_probe_judge(sl_error_probe *p, const sl_image *image, double rel_rmse, uint64_t rays,
                               sl_error_estimate *e, sl_error *error) {
    audit a;
    if (e) *e = (sl_error_estimate){0};
    if (!p || !image || !e) return sl_fail_null(error, "error probes, an image and a place for an estimate");
    if (!(rel_rmse > 0.0))
        return sl_fail(error, SL_ERROR_USAGE, "expected an error above 0 to judge by, got %g", rel_rmse);
    uint64_t probes = FIRST_PROBES;
    uint32_t samples = FIRST_SAMPLES;
    sl_status status = audit_begin(&a, p, image, error);
    double most = status != SL_OK ? 0.0 : rays ? (double)rays : usual_price(&a, rel_rmse);
    if (status == SL_OK) choose(&a, probes);
    if (status == SL_OK) status = audit_estimate(&a, probes, samples, e, error);
    while (status == SL_OK && !(e->bound <= rel_rmse) && !(e->least > rel_rmse) && !e->nonfinite) {
        if (wants_samples(&a, e, rel_rmse, probes)) samples *= 2;
        else probes *= 2;
        choose(&a, probes);
        if (price(&a, samples) > most || samples > UINT32_MAX / 4) break;
        status = audit_estimate(&a, probes, samples, e, error);
    }
    audit_end(&a);
    if (status != SL_OK) *e = (sl_error_estimate){0}; /* not what fewer probes said */
    return status;
}

/* ---- two pictures ---------------------------------------------------------------------------- */

/* Tells whether more than `share` of the first error is left in the second picture, which chose the pixels.
 */
static bool leaves_more(audit *a, const sl_audit_view *first, double share) {
    const bool some = a->p->of_surfaces;
    size_t count = 0;
    for (size_t i = 0; i < a->count; i++) {
        double x[3], y[3], p[3], q[3];
        uint32_t pixel = a->chosen[i];
        if (some && !sl_audit_is_masked(&a->view, pixel)) continue;
        value_of(first, pixel, x);
        value_of(&a->view, pixel, y);
        sl_probe_tracer_means(&a->p->tracer, pixel, p, q);
        a->pixel[count++] =
            sl_audit_pixel_beyond(x, y, share * share, p, q, 1.0 / probability(a, pixel, a->p->probes));
    }
    return sl_audit_is_positive(a->pixel, count,
                                (double)(some ? a->view.masked.count : a->view.judged.count));
}

sl_status sl_error_probe_left(sl_error_probe *p, const sl_image *first, const sl_image *second, double *share,
                              sl_error *error) {
    enum { HALVINGS = 10 };
    audit a = {0};
    sl_audit_view view;
    if (share) *share = 0.0;
    if (!p || !first || !second || !share)
        return sl_fail_null(error, "error probes, two images and a place for a share");
    if (!p->probes)
        return sl_fail(error, SL_ERROR_USAGE, "expected probes that have judged the second image");
    sl_status status = audit_begin(&a, p, second, error);
    if (status == SL_OK) status = sl_audit_view_of(first, p->tracer.surfaces, &view, error);
    if (status == SL_OK) choose(&a, p->probes);
    if (status == SL_OK) status = sl_probe_tracer_trace(&p->tracer, a.chosen, a.count, p->samples, error);
    for (double step = 0.5; status == SL_OK && step > ldexp(1.0, -HALVINGS); step *= 0.5) {
        if (leaves_more(&a, &view, *share + step)) *share += step;
    }
    audit_end(&a);
    return status;
}
