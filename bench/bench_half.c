/* Half floats in the splat buffer. Hardware of the paper's time blended nothing finer, and the paper does not say what that did to its sums: a half
 * has eleven bits, so that a sum stops growing once an addend is below 1/2048 of it, and is infinite beyond 65504. Here the records of a
 * picture are blended twice in the same order, in floats and in halves, which round after every blend. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/math.h"
#include "cache/splatting/record_weight.h"
#include "cache/splatting/state.h"
#include "splat_bench.h"

/* ---- halves ---- */

/* Nearest, ties to even; denormals included. */
static float to_half(float x) {
    float size = fabsf(x);
    if (!(size < 65520.0f)) return x * INFINITY;
    int exponent;
    (void)frexpf(size, &exponent);
    float step = ldexpf(1.0f, (exponent > -13 ? exponent : -13) - 11), over = size / step; /* step is a power of two: exact */
    float whole = floorf(over), rest = over - whole;
    if (rest > 0.5f || (rest == 0.5f && fmodf(whole, 2.0f) == 1.0f)) whole += 1.0f;
    return copysignf(whole * step, x);
}

/* ---- sums ---- */

enum { WEIGHT = 3, SUMS = 4 };

typedef struct sums {
    float *exact[SUMS], *half[SUMS];
    uint16_t *records;    /* how many a pixel has */
    uint64_t blends, lost; /* of weights: and how many of them changed nothing */
} sums;

static sums sums_new(size_t pixels) {
    sums s = {.records = calloc(pixels, sizeof *s.records)};
    bool good = s.records;
    for (int c = 0; c < SUMS; c++) {
        s.exact[c] = calloc(pixels, sizeof(float));
        s.half[c] = calloc(pixels, sizeof(float));
        good = good && s.exact[c] && s.half[c];
    }
    if (!good) bench_fail("sums", NULL);
    return s;
}

static void sums_free(sums *s) {
    for (int c = 0; c < SUMS; c++) {
        free(s->exact[c]);
        free(s->half[c]);
    }
    free(s->records);
}

/* (w E', w) of one record at one pixel. */
static void blend(sums *s, size_t i, const float addend[SUMS]) {
    s->blends++;
    s->records[i]++;
    for (int c = 0; c < SUMS; c++) {
        float before = s->half[c][i];
        s->exact[c][i] += addend[c];
        s->half[c][i] = to_half(before + to_half(addend[c]));
        s->lost += c == WEIGHT && s->half[c][i] == before;
    }
}

static void splat(const sl_record_cache *cache, const sl_record_pass *pass, const sl_record *record, sums *s) {
    const sl_splat_receivers *p = &pass->receivers;
    const sl_record_terms terms = sl_record_terms_of(record, &pass->weights);
    sl_splat_rect r = sl_record_bounds(pass, record);
    for (int y = r.y0; y < r.y1; y++) {
        for (int x = r.x0; x < r.x1; x++) {
            size_t i = (size_t)y * (size_t)p->width + (size_t)x;
            float w = cache->receives[i] ? sl_record_weight(pass, record, i) : 0.0f, addend[SUMS] = {0.0f, 0.0f, 0.0f, w};
            if (!(w > 0.0f)) continue;
            const sl_record_offsets o = sl_record_offsets_at(&terms, p->position_x[i], p->position_y[i], p->position_z[i],
                                                             p->normal_x[i], p->normal_y[i], p->normal_z[i]);
            for (int c = 0; c < 3; c++) addend[c] = w * sl_record_extrapolate(&terms, c, &o, sl_record_turn(&o));
            blend(s, i, addend);
        }
    }
}

/* ---- what halves do to the picture ---- */

static void write_row(bench_report *r, const char *scene, double accuracy, const char *weights, size_t records, size_t pixels, const sums *s) {
    double square = 0.0, mean = 0.0, bias = 0.0, most = 0.0, values = 0.0, lit = 0.0, many = 0.0, broken = 0.0, sum = 0.0;
    for (size_t i = 0; i < pixels; i++) {
        if (!(s->exact[WEIGHT][i] > 0.0f)) continue;
        lit++;
        many += s->records[i];
        for (int c = 0; c < 3; c++) {
            double e = (double)s->exact[c][i] / (double)s->exact[WEIGHT][i], h = (double)s->half[c][i] / (double)s->half[WEIGHT][i];
            if (!isfinite(h)) {
                broken += c == 0;
                continue;
            }
            sum = fmax(sum, (double)s->exact[c][i]);
            square += (h - e) * (h - e);
            bias += h - e;
            mean += e;
            values++;
            if (e > 0.0 && fabs(h / e - 1.0) > most) most = fabs(h / e - 1.0);
        }
    }
    mean /= values;
    bench_row(r, "%s|%g|%s|%zu|%.1f|%.3f|%.2f|%+.3f|%.2f|%.2g|%.0f", scene, accuracy, weights, records, many / lit, 100.0 * sqrt(square / values) / mean,
              100.0 * most, 100.0 * bias / values / mean, 100.0 * (double)s->lost / (double)s->blends, sum / 65504.0, broken);
}

static void compare(bench_report *r, const char *name, const sl_splat_state *s, double accuracy, bool smooth) {
    const sl_record_cache *cache = &s->cache[SL_RECEIVES_IRRADIANCE];
    sl_record_pass pass = cache->pass;
    sums sum = sums_new(sl_splat_pixels(s));
    if (!smooth) pass.weights.offset = 0.0f;
    for (size_t k = 0; k < cache->list.count; k++) splat(cache, &pass, &cache->list.records[k], &sum);
    write_row(r, name, accuracy, smooth ? "smooth" : "Ward's", cache->list.count, sl_splat_pixels(s), &sum);
    sums_free(&sum);
}

static void experiment(bench_report *r, const bench_options *o, const char *path) {
    static const double accuracies[] = {0.5, 0.25, 0.15, 0.1, 0.05};
    char name[64];
    sl_scene *scene;
    sl_error error;
    int size = o->size ? o->size : o->brief ? 128 : 512;
    bench_scene_name(path, name);
    if (!bench_wants(o, name) || !bench_open_scene(r, path, &scene)) return;
    for (size_t i = 0; i < (o->brief ? 2 : sizeof accuracies / sizeof *accuracies); i++) {
        sl_settings settings = sl_settings_default();
        sl_transport transport;
        void *state;
        settings.width = settings.height = size;
        settings.accuracy = accuracies[i];
        settings.gather_size = 16;
        settings.spp = 1;
        settings.metric = SL_METRIC_HARMONIC; /* the paper's */
        settings = splat_settings_complete(scene, &settings);
        sl_splatting_method.transport(&settings, &transport);
        if (sl_splatting_method.create(scene, &settings, &transport, &state, &error) != SL_OK) bench_fail("splatting", &error);
        for (sl_progress progress = {0}; !progress.done;) {
            if (sl_splatting_method.update(state, &progress, &error) != SL_OK) bench_fail("update", &error);
        }
        for (int smooth = 1; smooth >= 0; smooth--) compare(r, name, state, accuracies[i], smooth);
        sl_splatting_method.destroy(state);
    }
    sl_scene_destroy(scene);
}

int main(int argc, char **argv) {
    bench_options o = bench_options_parse(argc, argv, "build/splatting");
    bench_report r;
    bench_report_open(&r, &o, "half");
    bench_say(&r, "\nThe indirect picture by half floats against the one by floats, of the same records; *lost*: blends that did not change the sum of weights;\n"
                  "*greatest*: of all sums, in the greatest half, 65504; *broken*: pixels whose sums were infinite\n");
    bench_table(&r, "scenes", "scene|a|weights|records|records a pixel|relRMSE %|largest %|bias %|lost %|greatest|broken");
    experiment(&r, &o, "scenes/cornell.json");
    experiment(&r, &o, "scenes/generated/room.json");
    bench_report_close(&r);
    return 0;
}
