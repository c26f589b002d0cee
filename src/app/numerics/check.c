/* softlux check-numerics: every method on rooms that break careless code, as a table. */
#include "app/commands.h"
#include "app/numerics/cases.h"
#include "app/options.h"
#include "app/page.h"
#include "app/picture.h"
#include "base/error.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum { REFERENCE_SAMPLES = 256, TRACER_SAMPLES = 64 };
/* Noise is told by halves of few samples, and not to be told exactly: what of a noisy picture's difference
 * cannot be put down to noise. */
static const double noise_of_noise = 0.3;

typedef struct checking {
    const char *only, *method; /* or NULL */
    double seconds;            /* that a picture may take */
    bool list;
    /* of the method at hand */
    const char *name;
    sl_image *plain; /* the picture of the plain room */
    double noise;    /* relative RMSE between two seeds of it */
    double error;    /* and between it and the same light paths, path traced */
} checking;

typedef struct verdict {
    bool good;
    double difference; /* relative RMSE; negative: nothing to compare with */
    double bound;      /* of it */
    char text[112];     /* what is wrong */
} verdict;

__attribute__((format(printf, 1, 2))) static verdict bad(const char *format, ...) {
    verdict v = {.difference = -1.0};
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(v.text, sizeof v.text, format, arguments);
    va_end(arguments);
    return v;
}

/* ---- one picture ---- */

/* By the method; or its light paths, path traced. */
static sl_status render(const checking *c, const sl_scene *scene, bool traced, unsigned threads,
                        uint64_t seed, sl_image **image, sl_error *error) {
    char transport[64];
    sl_settings settings = sl_settings_of_papers();
    snprintf(transport, sizeof transport, "matched:%s", c->name);
    settings.method = traced ? "path" : c->name;
    settings.transport = traced ? transport : NULL;
    settings.spp = traced ? REFERENCE_SAMPLES : sl_is_tracer(c->name) ? TRACER_SAMPLES : 0;
    settings.quality = SL_QUALITY_DRAFT;
    settings.threads = threads;
    settings.seed = seed;
    /* the paper lets light through walls, which is not rounding's affair */
    settings.radiance_map.visibility = SL_VISIBILITY_RAYS;
    return sl_picture_make(scene, &settings, c->seconds, image, error);
}

/* Finite, and nowhere below 0. */
static verdict sound(const sl_image *image) {
    size_t values = 3 * (size_t)image->width * (size_t)image->height;
    for (size_t i = 0; i < values; i++) {
        if (!isfinite(image->planes[i])) return bad("value %zu is not finite", i);
        if (image->planes[i] < 0.0f) return bad("value %zu is %g", i, (double)image->planes[i]);
    }
    return (verdict){.good = true, .difference = -1.0};
}

static bool same_bits(const sl_image *a, const sl_image *b) {
    size_t bytes = (size_t)a->width * (size_t)a->height * (size_t)a->channels * sizeof(float);
    return a->channels == b->channels && memcmp(a->planes, b->planes, bytes) == 0;
}

/* ---- one case ---- */

static void exchange_sides(sl_image *image) {
    for (int row = 0; row < image->channels * image->height; row++) {
        float *p = image->planes + (size_t)row * (size_t)image->width;
        for (int i = 0, k = image->width - 1; i < k; i++, k--) {
            float left = p[i];
            p[i] = p[k], p[k] = left;
        }
    }
}

static const sl_known_limit *known_limit(const char *method, const char *name) {
    const sl_known_limit *k = sl_known_limits;
    while (k->method && (strcmp(k->method, method) != 0 || strcmp(k->name, name) != 0)) k++;
    return k->method ? k : NULL;
}

static verdict judged(const checking *c, const sl_hard_case *hard, double difference, double bound) {
    const sl_known_limit *known = known_limit(c->name, hard->name);
    if (known) bound = known->bound;
    verdict v = {.good = difference <= bound || (known && known->bound == 0.0),
                 .difference = difference,
                 .bound = bound};
    snprintf(v.text, sizeof v.text, "%s", known ? known->why : v.good ? "" : "too far off");
    return v;
}

/* Returns the picture's own noise, relative to the mean of what it is compared with, where its layers tell.
 */
static double own_noise(const sl_image *image, const sl_comparison *result) {
    sl_error error;
    sl_error_estimate own;
    bool told = sl_image_channel(image, "even.R") &&
                sl_error_estimate_from_halves(image, NULL, &own, &error) == SL_OK;
    return told && result->mean_reference > 0.0 ? own.rmse / result->mean_reference : 0.0;
}

/* Relative RMSE; of pictures by independent samples without their noise. */
static double apart(const sl_image *image, const sl_image *reference, const sl_comparison *result,
                    bool independent) {
    double a = independent ? own_noise(image, result) : 0.0,
           b = independent ? own_noise(reference, result) : 0.0;
    return sqrt(fmax(0.0, result->rel_rmse * result->rel_rmse - a * a - b * b));
}

/* independent: by samples of their own. */
static verdict compare(const checking *c, const sl_hard_case *hard, const sl_image *image,
                       const sl_image *against, bool independent, double bound) {
    sl_comparison result;
    sl_error error;
    if (sl_image_compare(image, against, NULL, &result, NULL, &error) != SL_OK)
        return bad("%.90s", error.message);
    /* no light, or hardly any */
    if (!(result.mean_reference > 1e-9) && hard->expectation == SL_EXPECT_TRUE)
        return judged(c, hard, result.rmse, 1e-6);
    return judged(c, hard, apart(image, against, &result, independent), bound);
}

static bool tells_noise(const sl_image *image) { return sl_image_channel(image, "even.R") != NULL; }

/* Pixel centres lie the other way round in a mirrored room, so nothing but the picture's own grid differs. */
static verdict compare_with_plain(const checking *c, const sl_hard_case *hard, sl_image *image) {
    if (hard->expectation == SL_EXPECT_SOUND) return sound(image);
    if (hard->expectation == SL_EXPECT_MIRRORED) exchange_sides(image);
    size_t values = 3 * (size_t)image->width * (size_t)image->height;
    for (size_t i = 0; hard->expectation == SL_EXPECT_SCALED && i < values; i++)
        image->planes[i] = (float)((double)image->planes[i] / hard->emission);
    const bool tells = tells_noise(image), other = hard->expectation == SL_EXPECT_MIRRORED ||
                                                   hard->expectation == SL_EXPECT_RESAMPLED;
    double bound = fmax(hard->most, tells ? 0.0 : fmax(hard->noises * c->noise, hard->errors * c->error));
    if (tells && other) bound = fmax(bound, noise_of_noise);
    return compare(c, hard, image, c->plain, tells && other, bound);
}

/* Compares with the same room and light paths, path traced. */
static verdict compare_with_truth(const checking *c, const sl_hard_case *hard, const sl_scene *scene,
                                  const sl_image *image) {
    sl_error error;
    sl_image *truth = NULL;
    if (render(c, scene, true, 0, 2, &truth, &error) != SL_OK)
        return bad("path traced: %.70s", error.message);
    verdict v = sound(truth);
    const double noise = tells_noise(image) ? noise_of_noise : hard->errors * c->error;
    if (v.good) v = compare(c, hard, image, truth, true, fmax(hard->most, noise));
    sl_image_destroy(truth);
    return v;
}

static verdict check_case(const checking *c, const sl_hard_case *hard) {
    sl_error error;
    sl_scene *scene = NULL;
    sl_image *one = NULL, *three = NULL;
    verdict v;
    if (sl_hard_case_load(hard, &scene, &error) != SL_OK ||
        render(c, scene, false, 1, 0, &one, &error) != SL_OK ||
        render(c, scene, false, 3, 0, &three, &error) != SL_OK)
        v = bad("%.90s", error.message);
    else if (!same_bits(one, three)) v = bad("other bits with three threads");
    else v = sound(one);
    if (v.good)
        v = hard->expectation == SL_EXPECT_TRUE ? compare_with_truth(c, hard, scene, one)
                                                : compare_with_plain(c, hard, one);
    sl_image_destroy(one);
    sl_image_destroy(three);
    sl_scene_destroy(scene);
    return v;
}

/* Renders the plain room, and finds how much of its picture is noise, and how far it is from the truth. */
static sl_status prepare(checking *c, sl_error *error) {
    sl_scene *scene = NULL;
    sl_image *other = NULL, *truth = NULL;
    sl_comparison seeds, errors;
    sl_status status = sl_hard_case_load(NULL, &scene, error);
    if (status == SL_OK) status = render(c, scene, false, 1, 0, &c->plain, error);
    if (status == SL_OK) status = render(c, scene, false, 1, 1, &other, error);
    if (status == SL_OK) status = render(c, scene, true, 0, 2, &truth, error);
    if (status == SL_OK) status = sl_image_compare(other, c->plain, NULL, &seeds, NULL, error);
    if (status == SL_OK) status = sl_image_compare(c->plain, truth, NULL, &errors, NULL, error);
    if (status == SL_OK) c->noise = seeds.rel_rmse, c->error = apart(c->plain, truth, &errors, true);
    sl_image_destroy(other);
    sl_image_destroy(truth);
    sl_scene_destroy(scene);
    return status;
}

/* ---- the table ---- */

static bool is_wanted(const checking *c, const sl_hard_case *hard) {
    return !c->only || strstr(hard->name, c->only);
}

static void print_row(const char *name, const verdict *v) {
    char difference[32] = "", bound[32] = "";
    if (v->difference >= 0.0) snprintf(difference, sizeof difference, "%.2g %%", 100.0 * v->difference);
    if (v->difference >= 0.0) snprintf(bound, sizeof bound, "%.2g %%", 100.0 * v->bound);
    printf("| %-24s | %-6s | %10s | %8s | %s |\n", name, v->good ? "ok" : "FAILED", difference, bound,
           v->text);
    fflush(stdout);
}

static sl_status check_method(checking *c, size_t *failures, sl_error *error) {
    sl_status status = prepare(c, error);
    if (status == SL_OK) {
        printf("\n### %s\n\nNoise (another seed): %.2g %%. Error (against %d samples a pixel of the same "
               "light paths): "
               "%.2g %%.\n\n| case | | off by | bound | |\n|:---|:---|---:|---:|:---|\n",
               c->name, 100.0 * c->noise, REFERENCE_SAMPLES, 100.0 * c->error);
        for (size_t i = 0; i < sl_hard_case_count; i++) {
            if (!is_wanted(c, &sl_hard_cases[i])) continue;
            verdict v = check_case(c, &sl_hard_cases[i]);
            *failures += !v.good;
            print_row(sl_hard_cases[i].name, &v);
        }
    }
    sl_image_destroy(c->plain);
    c->plain = NULL;
    return status;
}

static sl_status check_all(checking *c, size_t *failures, sl_error *error) {
    sl_status status = SL_OK;
    bool any = false;
    for (size_t m = 0; sl_method_name(m) && status == SL_OK; m++) {
        if (c->method && strcmp(c->method, sl_method_name(m)) != 0) continue;
        c->name = sl_method_name(m);
        any = true;
        status = check_method(c, failures, error);
    }
    if (status == SL_OK && !any)
        return sl_fail(error, SL_ERROR_USAGE, "unknown method '%s'", c->method);
    return status;
}

int sl_command_check_numerics(int argc, char **argv) {
    checking c = {.seconds = 120.0};
    const sl_option options[] = {
        SL_TEXT("method", 'm', &c.method, "NAME", "this method alone [all]"),
        SL_TEXT("only", 0, &c.only, "TEXT", "cases whose names hold the text"),
        SL_REAL("limit", &c.seconds, NULL, "SECONDS", 1e-3, 1e6, "that a picture may take [120]"),
        SL_FLAG("list", &c.list, "print the cases, and run none"),
        {.name = NULL}};
    const sl_command_line line = {
        "softlux check-numerics [options]",
        "Runs the methods on rooms that are hard to compute: tiny, huge, far away, badly cut, oddly lit.",
        "Every picture must be finite, nowhere negative, and have the same bits with one thread and with "
        "three. Where a change ought to make no\n"
        "difference (the room scaled, moved, mirrored, cut in other triangles) the picture must be the plain "
        "room's; elsewhere it must be as near to\n"
        "the same light paths, path traced, as in the plain room. Each row tells how far off it is, and its "
        "bound: a part of the picture's mean, or\n"
        "some times what another seed changes, or what the plain room is off by. Exit status 1 if anything "
        "fails.",
        options, 0, 0, NULL, NULL, NULL};
    int operands, exit_status;
    if (!sl_options_parse(&line, argc, argv, NULL, &operands, &exit_status)) return exit_status;
    for (size_t i = 0; c.list && i < sl_hard_case_count; i++) puts(sl_hard_cases[i].name);
    if (c.list) return 0;
    sl_error error;
    size_t failures = 0;
    sl_status status = check_all(&c, &failures, &error);
    if (status != SL_OK) return sl_complain(&error);
    printf("%zu failed\n", failures);
    return failures ? SL_EXIT_COMPARISON_FAILED : 0;
}
