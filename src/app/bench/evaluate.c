#include "app/bench/evaluate.h"

#include "app/bench/judge.h"
#include "app/bench/references.h"
#include "app/html.h"
#include "app/clock.h"

#include "base/error.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* A reference's noise is to be below this share of the smallest error told with it. */
static const double wanted_share = 0.1;

static void show(const sl_bench_options *o, const sl_bench_scene *s, const sl_bench_reference *r) {
    if (o->quiet || !isatty(STDERR_FILENO)) return;
    fprintf(stderr, "\r\033[K%s, reference %s: %llu samples, noise %.2g %%, wanted %.2g %%", s->name,
            r->transport, (unsigned long long)r->samples, 100.0 * r->noise, 100.0 * r->wanted);
    fflush(stderr);
}

/* ---- which references ---- */

static sl_bench_reference *add_reference(sl_bench_scene *s, const char *transport) {
    for (size_t i = 0; i < s->reference_count; i++) {
        if (strcmp(s->references[i].transport, transport) == 0) return &s->references[i];
    }
    sl_bench_reference *r = &s->references[s->reference_count++];
    snprintf(r->transport, sizeof r->transport, "%s", transport);
    return r;
}

static bool list_references(const sl_bench_options *o, sl_bench_scene *s) {
    s->reference_count = 0;
    s->references = calloc(s->row_count + 3, sizeof *s->references);
    if (!s->references) return false;
    if (o->trials->truth[SL_BENCH_FULL]) add_reference(s, "full");
    if (o->trials->truth[SL_BENCH_ONE_BOUNCE]) add_reference(s, "one-bounce");
    for (size_t i = 0; i < s->row_count; i++) {
        if (o->trials->truth[SL_BENCH_MATCHED] && (s->rows[i].end == SL_BENCH_RAN || o->references_only))
            add_reference(s, s->rows[i].transport);
    }
    if (o->trials->truth[SL_BENCH_FULL]) add_reference(s, "direct");
    return true;
}

static bool is_judged_by(const sl_bench_options *o, const sl_bench_row *row, const char *transport,
                         sl_bench_truth truth) {
    if (row->end != SL_BENCH_RAN || !o->trials->truth[truth]) return false;
    return strcmp(transport, truth == SL_BENCH_MATCHED ? row->transport : sl_bench_truth_name(truth)) == 0;
}

static bool is_used_by(const sl_bench_options *o, const sl_bench_row *row, const char *transport) {
    for (int t = 0; t < SL_BENCH_TRUTHS; t++) {
        if (is_judged_by(o, row, transport, (sl_bench_truth)t)) return true;
    }
    return false;
}

/* ---- as good as they have to be ---- */

/* Returns the smallest error that would be told with this reference, and what share of it is in doubt; 0:
 * none. */
static double smallest_error(const sl_bench_options *o, const sl_bench_scene *s, const sl_bench_reference *r,
                             const sl_image *reference, const sl_image *mask, double *doubt) {
    double smallest = *doubt = 0.0;
    for (size_t i = 0; i < s->row_count; i++) {
        sl_image *picture = NULL;
        sl_bench_error e;
        sl_error error;
        if (!is_used_by(o, &s->rows[i], r->transport) ||
            sl_image_read(s->rows[i].picture, &picture, NULL) != SL_OK)
            continue;
        if (sl_judge_quickly(picture, reference, mask, &e, &error) == SL_OK && e.known && e.rel_rmse > 0.0 &&
            (smallest == 0.0 || e.rel_rmse < smallest)) {
            smallest = e.rel_rmse;
            *doubt = e.doubt / e.rel_rmse;
        }
        sl_image_destroy(picture);
    }
    return smallest;
}

/* Reads the reference as it stands, and sees how good it is and should be. */
static void look_at(const sl_bench_options *o, const sl_bench_scene *s, sl_bench_reference *r,
                    const sl_image *mask) {
    sl_image *image = NULL;
    double mean;
    sl_error error;
    r->samples = 0;
    if (sl_image_read(r->file, &image, NULL) != SL_OK) return;
    if (sl_reference_read(image, &r->pairs, &r->seconds) &&
        sl_judge_noise(image, mask, &r->noise, &mean, &error) == SL_OK) {
        r->samples = sl_reference_samples(r->pairs);
        r->wanted = wanted_share * smallest_error(o, s, r, image, mask, &r->doubt);
    }
    sl_image_destroy(image);
}

/* Foretells by what the ones before took. */
static double next_pair_seconds(const sl_bench_reference *r) {
    double samples = (double)(sl_reference_samples(r->pairs + 1) - sl_reference_samples(r->pairs));
    return r->samples ? r->seconds * samples / (double)r->samples : 0.0;
}

static bool is_good_enough(const sl_bench_options *o, const sl_bench_reference *r) {
    if (!r->samples) return false;
    if (o->reference_budget > 0.0 && r->seconds + next_pair_seconds(r) > o->reference_budget) return true;
    return r->wanted > 0.0 ? r->noise <= r->wanted : !o->references_only;
}

/* Adds a pair at a time: each is as long as all before it. */
static sl_status refine(const sl_bench_options *o, const sl_bench_scene *s, sl_bench_reference *r,
                        const sl_image *mask, sl_error *error) {
    sl_status status = SL_OK;
    sl_reference_path(o->references, s, r->transport, r->file);
    look_at(o, s, r, mask);
    while (status == SL_OK && !r->trouble[0] && !sl_interrupted() && !is_good_enough(o, r)) {
        status = sl_reference_extend(o, s, 1, r, error);
        if (status == SL_OK && !r->trouble[0]) look_at(o, s, r, mask);
        show(o, s, r);
    }
    return status;
}

/* ---- the answers ---- */

/* Compares over the pixels that estimates judge. What is lost in the reference's noise can check none. */
static void check_promise(sl_bench_row *row, const sl_image *picture, const sl_image *reference,
                          const sl_image *mask) {
    sl_bench_error e;
    sl_error error;
    if (!row->promise.known || sl_judge_quickly(picture, reference, mask, &e, &error) != SL_OK || !e.known ||
        e.lost)
        return;
    row->promise.measured_known = true;
    row->promise.measured = e.rel_rmse;
}

static void judge_row(const sl_bench_options *o, sl_bench_row *row, const sl_bench_reference *r,
                      const sl_image *reference, const sl_image *mask) {
    sl_image *picture = NULL;
    if (!is_used_by(o, row, r->transport) || sl_image_read(row->picture, &picture, NULL) != SL_OK) return;
    for (int t = 0; t < SL_BENCH_TRUTHS; t++) {
        if (!is_judged_by(o, row, r->transport, (sl_bench_truth)t)) continue;
        if (t == SL_BENCH_MATCHED) check_promise(row, picture, reference, mask);
        sl_image *difference = NULL;
        sl_error error;
        bool wanted = t == SL_BENCH_MATCHED && row->quality != SL_BENCH_CURVE && !row->difference;
        if (sl_judge(picture, reference, mask, &row->error[t], wanted ? &difference : NULL, &error) != SL_OK)
            snprintf(row->why, sizeof row->why, "%.200s", error.message);
        if (difference) row->difference = sl_picture_text(difference, false);
        sl_image_destroy(difference);
    }
    sl_image_destroy(picture);
}

/* Finds what the paths of a reference leave out of full global illumination. */
static void compare_with_full(sl_bench_reference *r, const sl_image *reference, const sl_image *full,
                              const sl_image *mask) {
    const sl_compare_options options = {.mask = mask};
    sl_bench_error e;
    sl_comparison c;
    sl_error error;
    sl_image *difference = NULL;
    double noise, mean, all;
    if (!full || sl_judge_quickly(reference, full, mask, &e, &error) != SL_OK || !e.known) return;
    if (sl_judge_noise(reference, mask, &noise, &mean, &error) != SL_OK ||
        sl_judge_noise(full, mask, &noise, &all, &error) != SL_OK)
        return;
    r->energy = all > 0.0 ? mean / all : 0.0;
    r->missing = e.rel_rmse;
    r->missing_known = true;
    if (sl_image_compare(reference, full, &options, &c, &difference, NULL) == SL_OK)
        r->difference = sl_picture_text(difference, false);
    sl_image_destroy(difference);
}

static void judge_all(const sl_bench_options *o, sl_bench_scene *s, const sl_image *mask) {
    sl_image *full = NULL;
    for (size_t i = 0; i < s->reference_count; i++) {
        sl_bench_reference *r = &s->references[i];
        sl_image *reference = NULL;
        if (!r->samples || sl_image_read(r->file, &reference, NULL) != SL_OK) continue;
        for (size_t k = 0; k < s->row_count; k++) judge_row(o, &s->rows[k], r, reference, mask);
        if (strcmp(r->transport, "full") == 0) {
            full = reference;
            continue;
        }
        compare_with_full(r, reference, full, mask);
        sl_image_destroy(reference);
    }
    if (full) s->picture = sl_picture_text(full, true);
    sl_image_destroy(full);
}

sl_status sl_evaluate(const sl_bench_options *o, sl_bench_scene *s, sl_error *error) {
    sl_image *mask = sl_reference_mask(o, s, error);
    if (!mask) return error->status;
    sl_status status = list_references(o, s) ? SL_OK : SL_ERROR_RESOURCES;
    if (status != SL_OK) sl_fail_memory(error, "a list of references");
    s->pixels_compared = 0;
    for (size_t i = 0; i < (size_t)s->width * (size_t)s->height; i++)
        s->pixels_compared += mask->planes[i] > 0.5f;
    for (size_t i = 0; i < s->reference_count && status == SL_OK; i++)
        status = refine(o, s, &s->references[i], mask, error);
    if (status == SL_OK && !o->references_only) judge_all(o, s, mask);
    if (!o->quiet && isatty(STDERR_FILENO)) fputs("\r\033[K", stderr);
    sl_image_destroy(mask);
    return status;
}
