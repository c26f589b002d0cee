/* softlux compare: how far a picture is from a reference, and whether that is near enough. */
#include "app/clock.h"
#include "app/commands.h"
#include "app/options.h"
#include "app/page.h"
#include "app/same_file.h"
#include "base/error.h"
#include "image/output_file.h"
#include "image/tone.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- the tone of 8-bit pictures ---- */

typedef struct shown {
    const char *curve; /* of an 8-bit picture; NULL: radiance, and the other fields mean nothing */
    bool known;        /* it tells its tone; else those below mean nothing */
    double stops;
    bool automatic;    /* the exposure was made for that picture: its brightness cannot be seen */
} shown;

static shown shown_of(const sl_image *image) {
    const char *stops = sl_image_metadata(image, SL_TONE_EXPOSURE_KEY);
    shown s = {.curve = sl_image_metadata(image, SL_TONE_KEY),
               .automatic = sl_image_metadata(image, SL_TONE_AUTOMATIC_KEY) != NULL};
    char *end = NULL;
    if (!s.curve || !stops) return s;
    s.stops = strtod(stops, &end);
    s.known = end != stops && !*end && isfinite(s.stops);
    return s;
}

/* Refuses light beside what a screen shows of it. */
static sl_status check_alike(const shown tones[2], const char *const paths[2], sl_error *error) {
    const int radiance = tones[0].curve ? 1 : 0;
    if (tones[radiance].curve || !tones[1 - radiance].curve) return SL_OK;
    return sl_fail(error, SL_ERROR_INPUT,
                   "%.400s is radiance, %.400s is not: compare EXR with EXR, PNG with PNG", paths[radiance],
                   paths[1 - radiance]);
}

/* Warns where both tell their tones and a difference in brightness may be hidden. */
static void warn_of_tones(const shown *a, const char *a_path, const shown *b, const char *b_path) {
    if (!a->known || !b->known) return;
    const bool differ = strcmp(a->curve, b->curve) != 0 || a->stops != b->stops,
               automatic = a->automatic || b->automatic;
    if (!differ && !automatic) return;
    fprintf(stderr,
            "softlux: warning: %s (%s %.4g stops, %s %.4g stops)%s: brightness is not compared; EXR files, "
            "or a fixed --exposure, show it\n",
            differ ? "the exposures differ" : "the exposure was automatic", a_path, a->stops, b_path,
            b->stops, differ && automatic ? ", being automatic" : "");
}

/* Adds a tone; for programs also of radiance, as null. */
static void add_tone(cJSON *to, const char *name, const shown *s, bool json) {
    if (!s->curve) {
        if (json) cJSON_AddNullToObject(to, name);
        return;
    }
    cJSON *tone = cJSON_AddObjectToObject(to, name);
    if (!s->known) {
        cJSON_AddNullToObject(tone, "curve");
        return;
    }
    cJSON_AddStringToObject(tone, "curve", s->curve);
    cJSON_AddNumberToObject(tone, "exposure", s->stops);
    cJSON_AddBoolToObject(tone, "automatic", s->automatic);
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
    "Radiance (EXR, PFM, HDR) beside a picture of 8 bits is refused. For golden images take EXR, or PNG by\n"
    "a fixed render --exposure.\n"
    "\n"
    "Exit status: 0 if all bounds hold or there are none, 1 if one does not (said on stderr), 2 usage, 3 "
    "input (also: no\n"
    "pixel to compare), 4 output, 5 not enough memory. A NaN or infinite value under the mask fails any "
    "bound. Against a\n"
    "black B rel_rmse, rel_mse and bias are infinite and fail theirs; where A is black too they are 0.";

/* ---- the command line ------------------------------------------------------------------------ */

/* Metrics that an option bounds; bias either way. */
static const struct {
    const char *metric, *option, *help;
    bool at_least;
} bounds[] = {
    {"rmse", "max-rmse", "rmse must be at most X", false},
    {"rel_rmse", "max-rel-rmse", "rel_rmse must be at most X", false},
    {"rel_mse", "max-rel-mse", "rel_mse must be at most X", false},
    {"max_abs", "max-abs", "max_abs must be at most X", false},
    {"bias", "max-bias", "|bias| must be at most X", false},
    {"ssim", "min-ssim", "ssim must be at least X", true},
    {"flip", "max-flip", "flip must be at most X", false},
};
enum { BOUNDS = sizeof bounds / sizeof bounds[0], OWN_OPTIONS = 5 };

typedef struct compare_request {
    const char *paths[2];
    const char *mask, *difference;
    double exposure;
    bool identical, json;
    double bound[BOUNDS];
    bool bounded[BOUNDS];
} compare_request;

static bool parse(int argc, char **argv, compare_request *q, int *status) {
    sl_option options[OWN_OPTIONS + BOUNDS + 1] = {
        SL_TEXT("mask", 0, &q->mask, "FILE", "compare only where the first channel of this picture is > 0.5"),
        SL_TEXT(
            "difference", 0, &q->difference, "FILE",
            "write (x-r)/(|r| + 0.01 |mean r|) in false colour: blue too dark, red too bright, full at 50 %"),
        SL_REAL("exposure", &q->exposure, NULL, "STOPS", -100, 100,
                "both pictures times 2^STOPS for ssim, flip, rel_rmse_shown [0]"),
        SL_FLAG("json", &q->json, "print the metrics as one JSON object"),
        SL_FLAG("identical", &q->identical, "every bit of R, G, B must be equal")};
    for (int b = 0; b < BOUNDS; b++)
        options[OWN_OPTIONS + b] =
            (sl_option)SL_REAL(bounds[b].option, &q->bound[b], &q->bounded[b], "X",
                               bounds[b].at_least ? -1 : 0, bounds[b].at_least ? 1 : HUGE_VAL,
                               bounds[b].help);
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

static sl_status read_pictures(const compare_request *q, compare_pictures *p, sl_error *error) {
    const char *const *path = q->paths;
    sl_status status = sl_image_read(path[0], &p->image, error);
    if (status == SL_OK) status = sl_image_read(path[1], &p->reference, error);
    if (status == SL_OK && q->mask) status = sl_image_read(q->mask, &p->mask, error);
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
    sl_picture_planes(p->image, x);
    sl_picture_planes(p->reference, r);
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

/* surfaces: NaN where the pictures do not tell. */
static void add_metrics(cJSON *to, const sl_comparison *r, double surfaces) {
    const struct {
        const char *name;
        double value;
    } all[] = {{"rmse", r->rmse},
               {"rel_rmse", r->rel_rmse},
               {"rel_rmse_surfaces", surfaces},
               {"rel_rmse_shown", r->rel_rmse_shown},
               {"rel_mse", r->rel_mse},
               {"rel_mse_trimmed", r->rel_mse_trimmed},
               {"rel_mse_noise", r->rel_mse_noise},
               {"rel_mse_less_noise", r->rel_mse - r->rel_mse_noise},
               {"max_abs", r->max_abs},
               {"bias", r->bias},
               {"ssim", r->ssim},
               {"flip", r->flip},
               {"mean_image", r->mean_image},
               {"mean_reference", r->mean_reference},
               {"nonfinite", (double)r->nonfinite},
               {"negative", (double)r->negative},
               {"values", (double)r->values}};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        if (!isnan(all[i].value)) cJSON_AddNumberToObject(to, all[i].name, all[i].value);
    cJSON_AddBoolToObject(to, "identical", r->identical);
}

/* Prints one line on stderr for all that failed, so that a test's log says it at a glance. */
static int check_bounds(const compare_request *q, const sl_comparison *r, const cJSON *told) {
    char failures[1024] = "";
    size_t used;
    bool any = q->identical;
    for (int b = 0; b < BOUNDS; b++) any = any || q->bounded[b];
    if (any && r->nonfinite)
        snprintf(failures, sizeof failures, "; NaN or infinite values: %llu",
                 (unsigned long long)r->nonfinite);
    used = strlen(failures);
    if (q->identical && !r->identical) snprintf(failures + used, sizeof failures - used, "; not identical");
    for (int b = 0; b < BOUNDS; b++) {
        const bool signless = strcmp(bounds[b].metric, "bias") == 0;
        const double told_value = cJSON_GetNumberValue(cJSON_GetObjectItem(told, bounds[b].metric)),
                     value = signless ? fabs(told_value) : told_value, bound = q->bound[b];
        if (!q->bounded[b] || (bounds[b].at_least ? value >= bound : value <= bound)) continue; /* not NaN */
        used = strlen(failures);
        snprintf(failures + used, sizeof failures - used, "; %s is %.9g, not at %s %.9g",
                 signless ? "|bias|" : bounds[b].metric, value, bounds[b].at_least ? "least" : "most", bound);
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
    sl_status status = check_alike(tones, q->paths, &error);
    if (status == SL_OK)
        status = sl_image_compare(p->image, p->reference, &options, &result,
                                  q->difference ? &p->difference : NULL, &error);
    sl_watch_for_interrupt(); /* a picture that is being written is written to its end */
    if (status == SL_OK && q->difference) status = sl_image_write(p->difference, q->difference, &error);
    if (status != SL_OK) return sl_complain(&error);
    warn_of_tones(&tones[0], q->paths[0], &tones[1], q->paths[1]);
    cJSON *told = cJSON_CreateObject();
    add_tone(told, "tone_image", &tones[0], q->json);
    add_tone(told, "tone_reference", &tones[1], q->json);
    add_metrics(told, &result, rel_rmse_of_surfaces(p));
    int verdict = check_bounds(q, &result, told);
    if (q->json) sl_json_print(told, true);
    else sl_json_lines(stdout, told);
    return verdict;
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
