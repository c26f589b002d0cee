/* softlux compare: how far a picture is from a reference, and whether that is near enough. */
#include "app/clock.h"
#include "app/commands.h"
#include "app/options.h"
#include "app/page.h"
#include "app/same_file.h"
#include "base/error.h"
#include "image/output_file.h"
#include "image/tone.h"
#include "softlux.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- the tone of 8-bit pictures ---- */

typedef struct shown {
    bool is_shown;   /* an 8-bit picture; else the other fields mean nothing */
    bool known;      /* it tells its tone; else those below mean nothing */
    sl_tone_curve curve;
    double stops;
    bool automatic;  /* the exposure was made for that picture: its brightness cannot be seen */
} shown;

static bool find_curve(const char *name, sl_tone_curve *curve) {
    for (size_t i = 0; sl_tone_curve_name(i); i++) {
        if (strcmp(sl_tone_curve_name(i), name) != 0) continue;
        *curve = (sl_tone_curve)i;
        return true;
    }
    return false;
}

static shown shown_of(const sl_image *image) {
    const char *curve = sl_image_metadata(image, SL_TONE_KEY),
               *stops = sl_image_metadata(image, SL_TONE_EXPOSURE_KEY);
    shown s = {.is_shown = curve != NULL,
                  .automatic = sl_image_metadata(image, SL_TONE_AUTOMATIC_KEY) != NULL};
    char *end = NULL;
    if (!curve || !stops) return s;
    s.stops = strtod(stops, &end);
    s.known = end != stops && !*end && isfinite(s.stops) && find_curve(curve, &s.curve);
    return s;
}

static sl_status show(sl_image **radiance, const char *path, const shown *other, const char *other_path,
                      sl_error *error) {
    sl_image *displayed;
    if (!other->known)
        return sl_fail(
            error, SL_ERROR_INPUT,
            "%.400s does not tell the tone that it was made with, so that it cannot be compared with the "
            "radiance of %.400s; expected two EXR files, or a PNG by softlux",
            other_path, path);
    sl_status status = sl_tone_display(*radiance, other->curve, other->stops, &displayed, error);
    if (status != SL_OK) return status;
    sl_image_destroy(*radiance);
    *radiance = displayed;
    return SL_OK;
}

/* Puts radiance through the tone of the other picture, if that is one of 8 bits. INPUT:
 * the tone is not known. */
static sl_status show_alike(sl_image **a, const char *a_path, sl_image **b, const char *b_path,
                         sl_error *error) {
    const shown of_a = shown_of(*a), of_b = shown_of(*b);
    if (of_a.is_shown == of_b.is_shown) return SL_OK;
    return of_a.is_shown ? show(b, b_path, &of_a, a_path, error) : show(a, a_path, &of_b, b_path, error);
}

/* Warns where both are shown and a difference in brightness may be hidden. */
static void warn_of_tones(const shown *a, const char *a_path, const shown *b, const char *b_path) {
    if (!a->is_shown || !b->is_shown || !a->known || !b->known) return;
    const bool differ = a->curve != b->curve || a->stops != b->stops,
               automatic = a->automatic || b->automatic;
    if (!differ && !automatic) return;
    fprintf(stderr,
            "softlux: warning: %s (%s %.4g stops, %s %.4g stops)%s: brightness is not compared; EXR files, "
            "or a fixed --exposure, show it\n",
            differ ? "the exposures differ" : "the exposure was automatic", a_path, a->stops, b_path,
            b->stops, differ && automatic ? ", being automatic" : "");
}

/* A line, or, for JSON, an object (null for radiance) and a comma. */
static void print_tone(const char *name, const shown *s, bool json) {
    const char *curve = s->known ? sl_tone_curve_name((size_t)s->curve) : "unknown",
               *automatic = s->automatic ? "true" : "false";
    if (!s->is_shown) printf(json ? "\"%s\": null, " : "%-19s radiance, shown by the other's\n", name);
    else if (!s->known) printf(json ? "\"%s\": {\"curve\": null}, " : "%-19s unknown\n", name);
    else if (json)
        printf("\"%s\": {\"curve\": \"%s\", \"exposure\": %.17g, \"automatic\": %s}, ", name, curve, s->stops,
               automatic);
    else printf("%-19s %s, %.9g stops%s\n", name, curve, s->stops, s->automatic ? ", automatic" : "");
}

static const char details[] =
    "A is the picture x, B the reference r: EXR, PFM, Radiance HDR, PNG or JPEG files of the same size. "
    "Every metric is\n"
    "over R, G, B of the pixels whose six values are finite and whose mask, if any, is > 0.5; sums are in "
    "double.\n"
    "\n"
    "  rmse              sqrt(mean (x-r)^2)\n"
    "  rel_rmse          rmse / |mean(r)|\n"
    "  rel_rmse_surfaces   the same without the pixels that show light sources or sky: where a layer "
    "emission.* of A or B is\n"
    "                    not 0; told where there is such a layer. Lamps that are seen are most of mean(r)\n"
    "  rel_rmse_shown    that of all pixels as a screen shows them: both pictures times 2^STOPS, clipped to "
    "[0,1]\n"
    "  rel_mse           mean((x-r)^2 / (r^2 + 0.01 mean(r)^2))\n"
    "  rel_mse_trimmed   the same without the largest 0.1 % of the terms\n"
    "  rel_mse_noise     what the noise of B adds to rel_mse, from its layers even.* and odd.*, if any\n"
    "  rel_mse_less_noise  rel_mse - rel_mse_noise: the error of A alone\n"
    "  max_abs           max |x-r|\n"
    "  bias              sum(x-r) / |sum(r)|\n"
    "  ssim              mean structural similarity of the luminance, 11x11 Gaussian window, of both "
    "pictures times\n"
    "                    2^STOPS, clipped to [0,1], in sRGB; 1 where they are alike\n"
    "  flip              mean LDR-FLIP of the same two, 67 pixels per degree; 0 where they are alike\n"
    "  nonfinite         NaN or infinite values under the mask, of both pictures together\n"
    "  negative          negative values, likewise\n"
    "  identical         every bit of every R, G, B value under the mask is equal\n"
    "  values            values compared\n"
    "  mean_image, mean_reference\n"
    "  tone_image, tone_reference  curve and exposure of 8-bit pictures, as a PNG by softlux tells them\n"
    "\n"
    "An 8-bit picture is compared with another as it is, in linear light. A PNG whose exposure was "
    "automatic, as render's\n"
    "is by default, shows a scene with its lamps doubled alike: a warning says so, and also where two "
    "exposures differ.\n"
    "Radiance (EXR, PFM, HDR) is put through the PNG's own tone before they are compared; a picture of 8 "
    "bits that does\n"
    "not tell its tone is refused then. For golden images take EXR, or PNG by a fixed render --exposure.\n"
    "\n"
    "Exit status: 0 if all bounds hold or there are none, 1 if one does not (said on stderr), 2 usage, 3 "
    "input (also: no\n"
    "pixel to compare), 4 output, 5 not enough memory. A NaN or infinite value under the mask fails any "
    "bound. Against a\n"
    "black B rel_rmse, rel_mse and bias are infinite and fail theirs; where A is black too they are 0.";

/* ---- the command line ------------------------------------------------------------------------ */

enum { MAX_RMSE, MAX_REL_RMSE, MAX_REL_MSE, MAX_ABS, MAX_BIAS, MIN_SSIM, MAX_FLIP, BOUNDS };

typedef struct compare_request {
    const char *paths[2];
    const char *mask, *difference;
    double exposure;
    bool identical, json;
    double bound[BOUNDS];
    bool bounded[BOUNDS];
} compare_request;

static bool parse(int argc, char **argv, compare_request *q, int *status) {
    double *bound = q->bound;
    bool *bounded = q->bounded;
    const sl_option options[] = {
        SL_TEXT("mask", 0, &q->mask, "FILE", "compare only where the first channel of this picture is > 0.5"),
        SL_TEXT(
            "difference", 0, &q->difference, "FILE",
            "write (x-r)/(|r| + 0.01 |mean r|) in false colour: blue too dark, red too bright, full at 50 %"),
        SL_REAL("exposure", &q->exposure, NULL, "STOPS", -100, 100,
                "both pictures times 2^STOPS for ssim, flip, rel_rmse_shown [0]"),
        SL_FLAG("identical", &q->identical, "every bit of R, G, B must be equal"),
        SL_REAL("max-rmse", &bound[MAX_RMSE], &bounded[MAX_RMSE], "X", 0, HUGE_VAL, "rmse must be at most X"),
        SL_REAL("max-rel-rmse", &bound[MAX_REL_RMSE], &bounded[MAX_REL_RMSE], "X", 0, HUGE_VAL,
                "rel_rmse must be at most X"),
        SL_REAL("max-rel-mse", &bound[MAX_REL_MSE], &bounded[MAX_REL_MSE], "X", 0, HUGE_VAL,
                "rel_mse must be at most X"),
        SL_REAL("max-abs", &bound[MAX_ABS], &bounded[MAX_ABS], "X", 0, HUGE_VAL, "max_abs must be at most X"),
        SL_REAL("max-bias", &bound[MAX_BIAS], &bounded[MAX_BIAS], "X", 0, HUGE_VAL,
                "|bias| must be at most X"),
        SL_REAL("min-ssim", &bound[MIN_SSIM], &bounded[MIN_SSIM], "X", -1, 1, "ssim must be at least X"),
        SL_REAL("max-flip", &bound[MAX_FLIP], &bounded[MAX_FLIP], "X", 0, HUGE_VAL, "flip must be at most X"),
        SL_FLAG("json", &q->json, "print the metrics as one JSON object"),
        {.name = NULL}};
    const sl_command_line line = {.usage = "softlux compare A B [options]",
                                  .summary = "Error metrics of picture A against reference B.",
                                  .details = details,
                                  .options = options,
                                  .operands_min = 2,
                                  .operands_max = 2};
    int count;
    return sl_options_parse(&line, argc, argv, q->paths, &count, status);
}

/* ---- the pictures ---------------------------------------------------------------------------- */

typedef struct compare_pictures {
    sl_image *image, *reference, *mask, *difference;
} compare_pictures;

static sl_status check_picture(const sl_image *image, const char *path, sl_error *error) {
    const float *planes[3];
    if (sl_layer_planes(image, NULL, planes)) return SL_OK;
    return sl_fail(error, SL_ERROR_INPUT, "%s: no R, G, B channels to compare", path);
}

static sl_status check_size(const sl_image *image, const char *path, const sl_image *other,
                            const char *other_path, sl_error *error) {
    if (image->width == other->width && image->height == other->height) return SL_OK;
    return sl_fail(error, SL_ERROR_INPUT, "pictures of different sizes: %s has %d x %d pixels, %s %d x %d",
                   path, image->width, image->height, other_path, other->width, other->height);
}

static sl_status read_pictures(const compare_request *q, compare_pictures *p, sl_error *error) {
    const char *const *path = q->paths;
    sl_status status = sl_image_read(path[0], &p->image, error);
    if (status == SL_OK) status = sl_image_read(path[1], &p->reference, error);
    if (status == SL_OK && q->mask) status = sl_image_read(q->mask, &p->mask, error);
    if (status == SL_OK) status = check_picture(p->image, path[0], error);
    if (status == SL_OK) status = check_picture(p->reference, path[1], error);
    if (status == SL_OK) status = check_size(p->image, path[0], p->reference, path[1], error);
    if (status == SL_OK && p->mask) status = check_size(p->image, path[0], p->mask, q->mask, error);
    return status;
}

/* ---- surfaces alone -------------------------------------------------------------------------- */

static bool shines(const float *const emission[3], size_t i) {
    return emission[0][i] != 0.0f || emission[1][i] != 0.0f || emission[2][i] != 0.0f;
}

/* NaN where neither picture tells what shines, or nothing is left. */
static double rel_rmse_of_surfaces(const compare_pictures *p) {
    const float *x[3], *r[3], *lamps[2][3];
    const bool told[2] = {sl_layer_planes(p->image, "emission", lamps[0]),
                          sl_layer_planes(p->reference, "emission", lamps[1])};
    size_t pixels = (size_t)p->image->width * (size_t)p->image->height, count = 0;
    double squares = 0.0, sum = 0.0;
    if (!told[0] && !told[1]) return (double)NAN;
    sl_layer_planes(p->image, NULL, x);
    sl_layer_planes(p->reference, NULL, r);
    for (size_t i = 0; i < pixels; i++) {
        bool finite = true;
        for (int k = 0; k < 3; k++) finite = finite && isfinite(x[k][i]) && isfinite(r[k][i]);
        if (!finite || (p->mask && !(p->mask->planes[i] > 0.5f)) || (told[0] && shines(lamps[0], i)) ||
            (told[1] && shines(lamps[1], i)))
            continue;
        for (int k = 0; k < 3; k++) {
            double d = (double)x[k][i] - (double)r[k][i];
            squares += d * d;
            sum += (double)r[k][i];
        }
        count++;
    }
    if (!count) return (double)NAN;
    return squares > 0.0 ? sqrt(squares * 3.0 * (double)count) / fabs(sum) : 0.0;
}

/* ---- the answer ------------------------------------------------------------------------------ */

/* A metric that is printed, and may be bounded. */
typedef struct metric {
    const char *name;
    double value;
    int bound; /* -1: none */
    bool count;
} metric;
enum { METRICS = 17 };

/* surfaces: NaN where the pictures do not tell. */
static void list_metrics(const sl_comparison *r, double surfaces, metric to[METRICS]) {
    const metric all[METRICS] = {{"rmse", r->rmse, MAX_RMSE, false},
                                 {"rel_rmse", r->rel_rmse, MAX_REL_RMSE, false},
                                 {"rel_rmse_surfaces", surfaces, -1, false},
                                 {"rel_rmse_shown", r->rel_rmse_shown, -1, false},
                                 {"rel_mse", r->rel_mse, MAX_REL_MSE, false},
                                 {"rel_mse_trimmed", r->rel_mse_trimmed, -1, false},
                                 {"rel_mse_noise", r->rel_mse_noise, -1, false},
                                 {"rel_mse_less_noise", r->rel_mse - r->rel_mse_noise, -1, false},
                                 {"max_abs", r->max_abs, MAX_ABS, false},
                                 {"bias", r->bias, MAX_BIAS, false},
                                 {"ssim", r->ssim, MIN_SSIM, false},
                                 {"flip", r->flip, MAX_FLIP, false},
                                 {"mean_image", r->mean_image, -1, false},
                                 {"mean_reference", r->mean_reference, -1, false},
                                 {"nonfinite", (double)r->nonfinite, -1, true},
                                 {"negative", (double)r->negative, -1, true},
                                 {"values", (double)r->values, -1, true}};
    memcpy(to, all, sizeof all);
}

/* JSON has no word for what is not finite. */
static void print_metric(const metric *m, bool json) {
    if (!json) printf(m->count ? "%-19s %.0f\n" : "%-19s %.9g\n", m->name, m->value);
    else if (isfinite(m->value)) printf(m->count ? "\"%s\": %.0f, " : "\"%s\": %.17g, ", m->name, m->value);
    else printf("\"%s\": null, ", m->name);
}

static void print_comparison(const sl_comparison *r, const shown tones[2], const metric metrics[METRICS],
                             bool json) {
    if (json) putchar('{');
    for (int i = 0; i < 2 && (json || tones[0].is_shown || tones[1].is_shown); i++)
        print_tone(i ? "tone_reference" : "tone_image", &tones[i], json);
    for (int i = 0; i < METRICS; i++)
        if (strcmp(metrics[i].name, "rel_rmse_surfaces") != 0 || !isnan(metrics[i].value))
            print_metric(&metrics[i], json);
    if (json) printf("\"identical\": %s}\n", r->identical ? "true" : "false");
    else printf("%-19s %s\n", "identical", r->identical ? "yes" : "no");
}

/* Prints one line on stderr for all that failed, so that a test's log says it at a glance. */
static int check_bounds(const compare_request *q, const sl_comparison *r, const metric metrics[METRICS]) {
    char failures[1024] = "";
    bool any = q->identical;
    for (int i = 0; i < BOUNDS; i++) any = any || q->bounded[i];
    if (any && r->nonfinite)
        snprintf(failures, sizeof failures, "; NaN or infinite values: %llu",
                 (unsigned long long)r->nonfinite);
    size_t used = strlen(failures);
    if (q->identical && !r->identical) snprintf(failures + used, sizeof failures - used, "; not identical");
    for (const metric *m = metrics; m < metrics + METRICS; m++) {
        if (m->bound < 0 || !q->bounded[m->bound]) continue;
        double bound = q->bound[m->bound], value = m->bound == MAX_BIAS ? fabs(m->value) : m->value;
        if (m->bound == MIN_SSIM ? value >= bound : value <= bound) continue; /* false for NaN */
        used = strlen(failures);
        snprintf(failures + used, sizeof failures - used, "; %s is %.9g, not at %s %.9g",
                 m->bound == MAX_BIAS ? "|bias|" : m->name, value, m->bound == MIN_SSIM ? "least" : "most",
                 bound);
    }
    if (!failures[0]) return SL_OK;
    fprintf(stderr, "softlux: %s differs from %s: %s\n", q->paths[0], q->paths[1], failures + 2);
    return SL_EXIT_COMPARISON_FAILED;
}

static int compare(const compare_request *q, compare_pictures *p) {
    sl_error error;
    sl_comparison result;
    const shown tones[2] = {shown_of(p->image), shown_of(p->reference)};
    sl_compare_options options = {.mask = p->mask, .exposure_stops = (float)q->exposure};
    sl_status status = show_alike(&p->image, q->paths[0], &p->reference, q->paths[1], &error);
    if (status == SL_OK)
        status = sl_image_compare(p->image, p->reference, &options, &result,
                                  q->difference ? &p->difference : NULL, &error);
    sl_watch_for_interrupt(); /* a picture that is being written is written to its end */
    if (status == SL_OK && q->difference) status = sl_image_write(p->difference, q->difference, &error);
    if (status != SL_OK) return sl_complain(&error);
    warn_of_tones(&tones[0], q->paths[0], &tones[1], q->paths[1]);
    metric metrics[METRICS];
    list_metrics(&result, rel_rmse_of_surfaces(p), metrics);
    print_comparison(&result, tones, metrics, q->json);
    return check_bounds(q, &result, metrics);
}

int sl_command_compare(int argc, char **argv) {
    compare_request request = {0};
    compare_pictures pictures = {0};
    int status;
    if (!parse(argc, argv, &request, &status)) return status;
    const char *const read[] = {request.paths[0], request.paths[1], request.mask};
    if (!sl_is_file_of_its_own("difference", request.difference, read, 3)) return SL_ERROR_USAGE;
    sl_error error;
    sl_status ready = request.difference ? sl_output_check(request.difference, &error) : SL_OK;
    if (ready == SL_OK) ready = read_pictures(&request, &pictures, &error);
    status = ready == SL_OK ? compare(&request, &pictures) : sl_complain(&error);
    sl_image_destroy(pictures.image);
    sl_image_destroy(pictures.reference);
    sl_image_destroy(pictures.mask);
    sl_image_destroy(pictures.difference);
    return status;
}
