#include "app/bench/references.h"

#include "app/bench/judge.h"
#include "app/page.h"
#include "app/clock.h"
#include "base/error.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A reference's noise is to be below this share of the smallest error told with it. */
static const double wanted_share = 0.1;

/* ---- which references ---- */

/* Returns the number of a reference, which is listed from now on. */
static int reference_of(sl_bench_scene *s, const char *transport) {
    for (size_t i = 0; i < s->reference_count; i++)
        if (strcmp(s->references[i].transport, transport) == 0) return (int)i;
    snprintf(s->references[s->reference_count].transport, SL_BENCH_PATHS, "%s", transport);
    return (int)s->reference_count++;
}

static bool list_references(const sl_bench_options *o, sl_bench_scene *s) {
    const bool *truth = o->trials->truth;
    s->reference_count = 0;
    s->references = calloc(s->row_count + 3, sizeof *s->references);
    if (!s->references) return false;
    if (truth[SL_BENCH_FULL]) reference_of(s, "full"); /* first: the others are compared with it */
    for (size_t i = 0; i < s->row_count; i++) {
        sl_bench_row *row = &s->rows[i];
        for (int t = 0; t < SL_BENCH_TRUTHS; t++) {
            const char *paths =
                t == SL_BENCH_MATCHED ? row->trial->transport : sl_bench_truth_name((sl_bench_truth)t);
            row->reference[t] = truth[t] && row->end == SL_CHILD_DONE ? reference_of(s, paths) : -1;
        }
    }
    if (truth[SL_BENCH_FULL]) reference_of(s, "direct");
    return true;
}

static bool is_used_by(const sl_bench_row *row, int reference) {
    for (int t = 0; t < SL_BENCH_TRUTHS; t++)
        if (row->reference[t] == reference) return true;
    return false;
}

/* ---- as good as they have to be ---- */

/* Returns the smallest error that would be told with this reference, and what share of it is in doubt; 0:
 * none. */
static double smallest_error(const sl_bench_scene *s, const sl_bench_reference *r, const sl_image *reference,
                             double *doubt) {
    double smallest = *doubt = 0.0;
    for (size_t i = 0; i < s->row_count; i++) {
        sl_image *picture = NULL;
        sl_bench_error e;
        sl_error error;
        if (!is_used_by(&s->rows[i], (int)(r - s->references)) ||
            sl_image_read(s->rows[i].picture, &picture, NULL) != SL_OK)
            continue;
        if (sl_judge_quickly(picture, reference, &e, &error) == SL_OK && e.known && e.rel_rmse > 0.0 &&
            (smallest == 0.0 || e.rel_rmse < smallest)) {
            smallest = e.rel_rmse;
            *doubt = e.doubt / e.rel_rmse;
        }
        sl_image_destroy(picture);
    }
    return smallest;
}

static double metadata(const sl_image *image, const char *key) {
    const char *value = sl_image_metadata(image, key);
    return value ? strtod(value, NULL) : 0.0;
}

/* Reads the reference as it stands, and sees how good it is and should be. */
static void look_at(const sl_bench_scene *s, sl_bench_reference *r) {
    sl_image *image = NULL;
    double mean;
    sl_error error;
    r->samples = 0;
    if (sl_image_read(r->file, &image, NULL) != SL_OK) return;
    if (sl_judge_noise(image, &r->noise, &mean, &error) == SL_OK) {
        r->samples = (uint64_t)metadata(image, "softlux.spp");
        r->seconds = metadata(image, SL_TRIAL_SECONDS);
        r->wanted = wanted_share * smallest_error(s, r, image, &r->doubt);
    }
    sl_image_destroy(image);
}

/* Returns how many samples the next picture shall have; 0: this one is good enough, or a better one would
 * take more than its budget. Noise falls with their number to the power of -0.65 or so. */
static uint64_t next_samples(const sl_bench_options *o, const sl_bench_reference *r) {
    const double first = 64.0, growth = 16.0, least = 1.5, most = 1e8;
    if (!r->samples) return (uint64_t)first;
    if (!(r->wanted > 0.0) || r->noise <= r->wanted) return 0;
    double times = 1.1 * pow(r->noise / r->wanted, 1.0 / 0.65);
    times = fmin(fmax(times, least), fmin(growth, most / (double)r->samples));
    if (o->reference_budget > 0.0 && r->seconds > 0.0) times = fmin(times, o->reference_budget / r->seconds);
    return times < least ? 0 : (uint64_t)(times * (double)r->samples);
}

static sl_status refine(const sl_bench_options *o, const sl_bench_scene *s, sl_bench_reference *r,
                        sl_error *error) {
    sl_status status = SL_OK;
    uint64_t samples;
    sl_reference_path(o->references, s, r->transport, r->file);
    look_at(s, r);
    while (status == SL_OK && !r->trouble[0] && !sl_interrupted() && (samples = next_samples(o, r)) > 0) {
        sl_progress_show(o->quiet, -1.0, "%s, reference %s: %llu samples, noise %.2g %%, wanted %.2g %%",
                         s->name, r->transport, (unsigned long long)samples, 100.0 * r->noise,
                         100.0 * r->wanted);
        status = sl_reference_make(o, s, samples, r, error);
        if (status == SL_OK) look_at(s, r);
    }
    return status;
}

/* ---- the answers ---- */

static void judge_row(sl_bench_row *row, int number, const sl_image *reference) {
    sl_image *picture = NULL;
    if (!is_used_by(row, number) || sl_image_read(row->picture, &picture, NULL) != SL_OK) return;
    for (int t = 0; t < SL_BENCH_TRUTHS; t++) {
        if (row->reference[t] != number) continue;
        sl_image *difference = NULL;
        sl_error error;
        bool wanted = t == SL_BENCH_MATCHED && strcmp(row->trial->quality, "curve") != 0 && !row->difference;
        if (sl_judge(picture, reference, &row->error[t], wanted ? &difference : NULL, &error) != SL_OK)
            snprintf(row->why, sizeof row->why, "%.200s", error.message);
        if (difference) row->difference = sl_picture_text(difference, false);
        sl_image_destroy(difference);
    }
    sl_image_destroy(picture);
}

/* Finds what the paths of a reference leave out of full global illumination. */
static void compare_with_full(sl_bench_reference *r, const sl_image *reference, const sl_image *full) {
    sl_bench_error e;
    sl_comparison c;
    sl_error error;
    sl_image *difference = NULL;
    double noise, mean, all;
    if (!full || sl_judge_quickly(reference, full, &e, &error) != SL_OK || !e.known) return;
    if (sl_judge_noise(reference, &noise, &mean, &error) != SL_OK ||
        sl_judge_noise(full, &noise, &all, &error) != SL_OK)
        return;
    r->energy = all > 0.0 ? mean / all : 0.0;
    r->missing = e.rel_rmse;
    r->missing_known = true;
    if (sl_image_compare(reference, full, NULL, &c, &difference, NULL) == SL_OK)
        r->difference = sl_picture_text(difference, false);
    sl_image_destroy(difference);
}

static void judge_all(sl_bench_scene *s) {
    sl_image *full = NULL;
    for (size_t i = 0; i < s->reference_count; i++) {
        sl_bench_reference *r = &s->references[i];
        sl_image *reference = NULL;
        if (!r->samples || sl_image_read(r->file, &reference, NULL) != SL_OK) continue;
        for (size_t k = 0; k < s->row_count; k++) judge_row(&s->rows[k], (int)i, reference);
        if (strcmp(r->transport, "full") == 0) {
            full = reference;
            continue;
        }
        compare_with_full(r, reference, full);
        sl_image_destroy(reference);
    }
    if (full) s->picture = sl_picture_text(full, true);
    sl_image_destroy(full);
}

sl_status sl_evaluate(const sl_bench_options *o, sl_bench_scene *s, sl_error *error) {
    sl_status status = list_references(o, s) ? SL_OK : sl_fail_memory(error, "a list of references");
    for (size_t i = 0; i < s->reference_count && status == SL_OK; i++)
        status = refine(o, s, &s->references[i], error);
    if (status == SL_OK) judge_all(s);
    sl_progress_clear(o->quiet);
    return status;
}
