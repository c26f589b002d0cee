/* softlux compare: how far a picture is from a reference, and whether that is near enough. */
#include "app/clock.h"
#include "app/commands.h"
#include "app/compare_tone.h"
#include "app/options.h"
#include "app/same_file.h"
#include "image/output_file.h"
#include "softlux.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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
                "both pictures times 2^STOPS for ssim and flip [0]"),
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

static int complain(const char *message, sl_status status) {
    fprintf(stderr, "softlux: %s\n", message);
    return (int)status;
}

static int check_picture(const sl_image *image, const char *path) {
    if (sl_image_channel(image, "R") && sl_image_channel(image, "G") && sl_image_channel(image, "B"))
        return SL_OK;
    fprintf(stderr, "softlux: %s: no R, G, B channels to compare\n", path);
    return SL_ERROR_INPUT;
}

static int check_size(const sl_image *image, const char *path, const sl_image *other,
                      const char *other_path) {
    if (image->width == other->width && image->height == other->height) return SL_OK;
    fprintf(stderr, "softlux: pictures of different sizes: %s has %d x %d pixels, %s %d x %d\n", path,
            image->width, image->height, other_path, other->width, other->height);
    return SL_ERROR_INPUT;
}

static int read_pictures(const compare_request *q, compare_pictures *p) {
    sl_error error;
    sl_status read = sl_image_read(q->paths[0], &p->image, &error);
    if (read == SL_OK) read = sl_image_read(q->paths[1], &p->reference, &error);
    if (read == SL_OK && q->mask) read = sl_image_read(q->mask, &p->mask, &error);
    if (read != SL_OK) return complain(error.message, read);
    int status = check_picture(p->image, q->paths[0]);
    if (status == SL_OK) status = check_picture(p->reference, q->paths[1]);
    if (status == SL_OK) status = check_size(p->image, q->paths[0], p->reference, q->paths[1]);
    if (status == SL_OK && p->mask) status = check_size(p->image, q->paths[0], p->mask, q->mask);
    return status;
}

/* ---- surfaces alone -------------------------------------------------------------------------- */

static bool has_emission(const sl_image *image) {
    return sl_image_channel(image, "emission.R") && sl_image_channel(image, "emission.G") &&
           sl_image_channel(image, "emission.B");
}

static bool shows_light(const sl_image *image, size_t i) {
    return has_emission(image) && (sl_image_channel(image, "emission.R")[i] != 0.0f ||
                                   sl_image_channel(image, "emission.G")[i] != 0.0f ||
                                   sl_image_channel(image, "emission.B")[i] != 0.0f);
}

/* NaN where neither picture tells what shines, or nothing is left. */
static double rel_rmse_of_surfaces(const compare_pictures *p) {
    static const char *const names[3] = {"R", "G", "B"};
    const float *x[3], *r[3];
    size_t pixels = (size_t)p->image->width * (size_t)p->image->height, count = 0;
    double squares = 0.0, sum = 0.0;
    if (!has_emission(p->image) && !has_emission(p->reference)) return (double)NAN;
    for (int k = 0; k < 3; k++)
        x[k] = sl_image_channel(p->image, names[k]), r[k] = sl_image_channel(p->reference, names[k]);
    for (size_t i = 0; i < pixels; i++) {
        bool finite = true;
        for (int k = 0; k < 3; k++) finite = finite && isfinite(x[k][i]) && isfinite(r[k][i]);
        if (!finite || (p->mask && !(p->mask->planes[i] > 0.5f)) || shows_light(p->image, i) ||
            shows_light(p->reference, i))
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

static void print_real(bool json, const char *name, double value) {
    if (!json) printf("%-19s %.9g\n", name, value);
    else if (isfinite(value)) printf("\"%s\": %.17g, ", name, value);
    else printf("\"%s\": null, ", name); /* JSON has no word for them */
}

static void print_count(bool json, const char *name, uint64_t value) {
    printf(json ? "\"%s\": %llu, " : "%-19s %llu\n", name, (unsigned long long)value);
}

static void print_comparison(const sl_comparison *r, const sl_shown shown[2], double surfaces, bool json) {
    if (json) putchar('{');
    for (int i = 0; i < 2 && (json || shown[0].is_shown || shown[1].is_shown); i++)
        sl_shown_print(i ? "tone_reference" : "tone_image", &shown[i], json);
    print_real(json, "rmse", r->rmse);
    print_real(json, "rel_rmse", r->rel_rmse);
    if (!isnan(surfaces)) print_real(json, "rel_rmse_surfaces", surfaces);
    print_real(json, "rel_mse", r->rel_mse);
    print_real(json, "rel_mse_trimmed", r->rel_mse_trimmed);
    print_real(json, "rel_mse_noise", r->rel_mse_noise);
    print_real(json, "rel_mse_less_noise", r->rel_mse - r->rel_mse_noise);
    print_real(json, "max_abs", r->max_abs);
    print_real(json, "bias", r->bias);
    print_real(json, "ssim", r->ssim);
    print_real(json, "flip", r->flip);
    print_real(json, "mean_image", r->mean_image);
    print_real(json, "mean_reference", r->mean_reference);
    print_count(json, "nonfinite", r->nonfinite);
    print_count(json, "negative", r->negative);
    print_count(json, "values", r->values);
    if (json) printf("\"identical\": %s}\n", r->identical ? "true" : "false");
    else printf("%-19s %s\n", "identical", r->identical ? "yes" : "no");
}

/* Prints one line on stderr for all that failed, so that a test's log says it at a glance. */
static int check_bounds(const compare_request *q, const sl_comparison *r) {
    static const char *const names[BOUNDS] = {"rmse",   "rel_rmse", "rel_mse", "max_abs",
                                              "|bias|", "ssim",     "flip"};
    const double values[BOUNDS] = {r->rmse,       r->rel_rmse, r->rel_mse, r->max_abs,
                                   fabs(r->bias), r->ssim,     r->flip};
    char failures[1024] = "";
    bool any = q->identical;
    for (int i = 0; i < BOUNDS; i++) any = any || q->bounded[i];
    if (any && r->nonfinite) {
        snprintf(failures, sizeof failures, "; NaN or infinite values: %llu",
                 (unsigned long long)r->nonfinite);
    }
    if (q->identical && !r->identical) {
        size_t used = strlen(failures);
        snprintf(failures + used, sizeof failures - used, "; not identical");
    }
    for (int i = 0; i < BOUNDS; i++) {
        bool holds = i == MIN_SSIM ? values[i] >= q->bound[i] : values[i] <= q->bound[i]; /* false for NaN */
        if (!q->bounded[i] || holds) continue;
        size_t used = strlen(failures);
        snprintf(failures + used, sizeof failures - used, "; %s is %.9g, not at %s %.9g", names[i], values[i],
                 i == MIN_SSIM ? "least" : "most", q->bound[i]);
    }
    if (!failures[0]) return SL_OK;
    fprintf(stderr, "softlux: %s differs from %s: %s\n", q->paths[0], q->paths[1], failures + 2);
    return SL_EXIT_COMPARISON_FAILED;
}

static int compare(const compare_request *q, compare_pictures *p) {
    sl_error error;
    sl_comparison result;
    const sl_shown shown[2] = {sl_shown_of(p->image), sl_shown_of(p->reference)};
    sl_compare_options options = {.mask = p->mask, .exposure_stops = (float)q->exposure};
    sl_status status = sl_shown_alike(&p->image, q->paths[0], &p->reference, q->paths[1], &error);
    if (status == SL_OK)
        status = sl_image_compare(p->image, p->reference, &options, &result,
                                  q->difference ? &p->difference : NULL, &error);
    sl_watch_for_interrupt(); /* a picture that is being written is written to its end */
    if (status == SL_OK && q->difference) status = sl_image_write(p->difference, q->difference, &error);
    if (status != SL_OK) return complain(error.message, status);
    sl_shown_warn(&shown[0], q->paths[0], &shown[1], q->paths[1]);
    print_comparison(&result, shown, rel_rmse_of_surfaces(p), q->json);
    return check_bounds(q, &result);
}

int sl_command_compare(int argc, char **argv) {
    compare_request request = {0};
    compare_pictures pictures = {0};
    int status;
    if (!parse(argc, argv, &request, &status)) return status;
    const char *const read[] = {request.paths[0], request.paths[1], request.mask};
    if (!sl_is_file_of_its_own("difference", request.difference, read, 3)) return SL_ERROR_USAGE;
    sl_error error;
    status = request.difference ? (int)sl_output_check(request.difference, &error) : SL_OK;
    if (status != SL_OK) return complain(error.message, (sl_status)status);
    status = read_pictures(&request, &pictures);
    if (status == SL_OK) status = compare(&request, &pictures);
    sl_image_destroy(pictures.image);
    sl_image_destroy(pictures.reference);
    sl_image_destroy(pictures.mask);
    sl_image_destroy(pictures.difference);
    return status;
}
