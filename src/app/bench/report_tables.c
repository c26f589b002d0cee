/* Tables over all scenes together: the beginning of the report, and tables for the page that
 * says it in words (docs/speed-against-error.md), each between two marks, which bench/fill_tables.sh puts
 * into the page. */
#include "app/bench/results.h"
#include "app/bench/report.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char *surfaces_of(const sl_bench_scene *s) {
    return s->mirrors ? "mirrors" : s->glossy ? "glossy" : "diffuse";
}

static bool is_measured(const sl_bench_scene *s) { return !s->trouble[0] && s->row_count > 0; }

static double error_of(const sl_bench_row *row, sl_bench_truth truth) { return row->error[truth].rel_rmse; }

/* ---- how it was measured ---- */

static void put_machine(FILE *out, const sl_bench_results *r) {
    size_t scenes = 0, rows = 0, references = 0, below = 0, sure = 0;
    for (size_t i = 0; i < r->scene_count; i++) {
        const sl_bench_scene *s = &r->scenes[i];
        scenes += is_measured(s);
        for (size_t k = 0; k < s->row_count; k++) rows += s->rows[k].end == SL_CHILD_DONE;
        for (size_t k = 0; k < s->reference_count; k++) {
            const sl_bench_reference *reference = &s->references[k];
            if (!(reference->wanted > 0.0)) continue;
            references++;
            below += reference->noise <= reference->wanted;
            sure += reference->doubt <= 0.1;
        }
    }
    fprintf(out, "%zu scenes, %zu pictures", scenes, rows);
    if (scenes) fprintf(out, " of %d x %d pixels", r->scenes[0].width, r->scenes[0].height);
    fprintf(
        out,
        ", softlux %s on %s, %d thread%s, medians of up to %d runs. The machine was %s: runs of the same "
        "trial were within %.1f %% of their middle by the processor's time and had %.0f %% of the clock's. "
        "Of %zu references %zu are less noisy than a tenth of the smallest error told with them; of %zu "
        "what their noise leaves in doubt, once it is subtracted, is below a tenth of that error (95 %% "
        "confidence), and where it is not, the report says so behind the figure.%s\n",
        r->version, r->machine, r->threads, r->threads == 1 ? "" : "s", r->repeats,
        r->noisy ? "busy" : "quiet", 100.0 * r->unrest_cpu, 100.0 * r->share_of_processor, references, below,
        sure, r->interrupted ? " **Interrupted: what was measured until then.**" : "");
}

/* ---- the goal ---- */

static void put_lead(FILE *out, const sl_bench_scene *s, double error, bool named) {
    sl_lead lead = sl_lead_at(s, SL_BENCH_FULL, error);
    char seconds[32], path[32];
    if (!lead.method) {
        fprintf(out, "%s not reached | | |", named ? " |" : "");
        return;
    }
    sl_seconds_text(lead.seconds, seconds);
    sl_seconds_text(lead.path_seconds, path);
    if (named) fprintf(out, " %s |", lead.method);
    fprintf(out, " %s | %s%s |", seconds, lead.path_later && *path ? "> " : "", path);
    if (*path) fprintf(out, " %s%.1f |", lead.path_later ? "> " : "", lead.path_seconds / lead.seconds);
    else fputs(" |", out);
}

/* Counts how many of the scenes with diffuse surfaces alone are `times` sooner at an error, for sure. */
static size_t count_leads(const sl_bench_results *r, double error, double times, size_t *scenes) {
    size_t reached = *scenes = 0;
    for (size_t i = 0; i < r->scene_count; i++) {
        const sl_bench_scene *s = &r->scenes[i];
        if (!is_measured(s) || s->glossy || s->mirrors) continue;
        sl_lead lead = sl_lead_at(s, SL_BENCH_FULL, error);
        ++*scenes;
        reached += lead.method && lead.path_seconds >= times * lead.seconds;
    }
    return reached;
}

static void put_goal(FILE *out, const sl_bench_results *r) {
    size_t scenes, five = count_leads(r, 0.05, 10.0, &scenes), ahead = count_leads(r, 0.01, 1.0, &scenes);
    fprintf(out,
            "Of %zu scenes with diffuse surfaces alone, the best method reaches 5 %% at least ten times "
            "sooner than the path tracer in **%zu**, and 1 %% sooner in **%zu**. Processor seconds; `>`: the "
            "path tracer was not there after its longest run.\n\n",
            scenes, five, ahead);
    sl_report_head(out, "scene|surfaces|best at 5 %|>5 %|>path|>times|>2 %|>path|>times|>1 %|>path|>times");
    for (size_t i = 0; i < r->scene_count; i++) {
        const sl_bench_scene *s = &r->scenes[i];
        if (!is_measured(s)) continue;
        fprintf(out, "| %s | %s |", s->name, surfaces_of(s));
        put_lead(out, s, 0.05, true);
        put_lead(out, s, 0.02, false);
        put_lead(out, s, 0.01, false);
        fputc('\n', out);
    }
}

/* ---- which method for which scene ---- */

/* Prints the first to reach an error, tracers among them, and by what factor it is sooner than the second. */
static void put_first(FILE *out, const sl_bench_scene *s, sl_bench_truth truth, double error) {
    sl_curve curves[SL_CURVES];
    const char *first = NULL;
    double best = HUGE_VAL, second = HUGE_VAL;
    size_t count = sl_curves_of(s, truth, curves);
    for (size_t i = 0; i < count; i++) {
        double seconds = sl_curve_time_to(&curves[i], truth, error);
        if (!(seconds > 0.0)) continue;
        if (seconds < best) second = best, best = seconds, first = curves[i].name;
        else if (seconds < second) second = seconds;
    }
    char text[32];
    sl_seconds_text(first ? best : 0.0, text);
    if (first) fprintf(out, " %s, %s s", first, text);
    else fputs(" none", out);
    if (second < HUGE_VAL) fprintf(out, " (%.1f x)", second / best);
    fputs(" |", out);
}

static void put_best(FILE *out, const sl_bench_results *r) {
    static const double errors[] = {0.2, 0.1, 0.05, 0.02, 0.01};
    sl_report_head(out,
                   "scene|surfaces|first at 20 %|at 10 %|at 5 %|at 2 %|at 1 %");
    for (size_t i = 0; i < r->scene_count; i++) {
        const sl_bench_scene *s = &r->scenes[i];
        if (!is_measured(s)) continue;
        fprintf(out, "| %s | %s |", s->name, surfaces_of(s));
        for (size_t k = 0; k < sizeof errors / sizeof *errors; k++)
            put_first(out, s, SL_BENCH_FULL, errors[k]);
        fputc('\n', out);
    }
}

/* ---- where each fails ---- */

typedef struct least_error {
    const char *scene;
    double error;
} least_error;

static int by_error(const void *a, const void *b) {
    const least_error *x = a, *y = b;
    if (x->error != y->error) return x->error > y->error ? -1 : 1;
    return strcmp(x->scene, y->scene);
}

/* Finds the smallest error of a curve in each scene, the largest of these first. */
static size_t least_errors(const sl_bench_results *r, const char *curve, sl_bench_truth truth,
                           least_error *to) {
    size_t count = 0;
    for (size_t i = 0; i < r->scene_count; i++) {
        const sl_bench_scene *s = &r->scenes[i];
        double least = HUGE_VAL;
        for (size_t k = 0; k < s->row_count; k++) {
            const sl_bench_row *row = &s->rows[k];
            if (row->end == SL_CHILD_DONE && strcmp(row->trial->curve, curve) == 0 && row->error[truth].known)
                least = fmin(least, error_of(row, truth));
        }
        if (least < HUGE_VAL) to[count++] = (least_error){s->name, least};
    }
    qsort(to, count, sizeof *to, by_error);
    return count;
}

static void put_failures(FILE *out, const sl_bench_results *r) {
    enum { SHOWN = 4 };
    static const struct {
        const char *curve, *against;
        sl_bench_truth truth;
    } curves[] = {{"splatting", "all light", SL_BENCH_FULL},
                  {"direct-radiance", "its own paths", SL_BENCH_MATCHED},
                  {"light-octree", "its own paths", SL_BENCH_MATCHED},
                  {"multi-mesh", "its own paths", SL_BENCH_MATCHED},
                  {"shading-cache", "its own paths", SL_BENCH_MATCHED},
                  {"photons at pixels", "all light", SL_BENCH_FULL}};
    least_error *least = calloc(r->scene_count + 1, sizeof *least);
    sl_report_head(out,
                   "method|against|>smallest error of all settings, median scene|the scenes where that is "
                   "largest");
    for (size_t c = 0; least && c < sizeof curves / sizeof *curves; c++) {
        size_t count = least_errors(r, curves[c].curve, curves[c].truth, least);
        if (!count) continue;
        fprintf(out, "| %s | %s | %.2g %% |", curves[c].curve, curves[c].against,
                50.0 * (least[(count - 1) / 2].error + least[count / 2].error));
        for (size_t i = 0; i < count && i < SHOWN; i++)
            fprintf(out, "%s%s %.*f %%", i ? ", " : " ", least[i].scene, least[i].error < 0.0995,
                    100.0 * least[i].error);
        fputs(" |\n", out);
    }
    free(least);
}

/* ---- qualities ---- */

static const sl_bench_row *row_of(const sl_bench_scene *s, const char *curve, int quality) {
    for (size_t i = 0; i < s->row_count; i++) {
        const sl_bench_row *row = &s->rows[i];
        if ((int)row->trial->quality == quality && strcmp(row->trial->curve, curve) == 0)
            return row->end == SL_CHILD_DONE && row->error[SL_BENCH_MATCHED].known ? row : NULL;
    }
    return NULL;
}

static double middle_of(double *values, size_t count) {
    return sl_bench_spread_of(values, (int)count).median;
}

/* Puts, of the scenes where both ran, how many times the seconds of the quality below, what share of its
 * error, and in how many scenes no smaller an error. work: room for four numbers a scene. */
static void put_quality(FILE *out, const sl_bench_results *r, const char *curve, int quality, double *work) {
    double *errors = work, *times = work + r->scene_count, *shares = work + 2 * r->scene_count,
           *seconds = work + 3 * r->scene_count;
    size_t all = 0, pairs = 0, beaten = 0;
    for (size_t i = 0; i < r->scene_count; i++) {
        const sl_bench_row *row = row_of(&r->scenes[i], curve, quality),
                           *below = row_of(&r->scenes[i], curve, quality - 1);
        if (!row) continue;
        double error = error_of(row, SL_BENCH_MATCHED),
               before = below ? error_of(below, SL_BENCH_MATCHED) : 0.0;
        seconds[all] = row->cpu.median;
        errors[all++] = error;
        if (!(before > 0.0) || !(below->cpu.median > 0.0)) continue;
        times[pairs] = row->cpu.median / below->cpu.median;
        shares[pairs++] = error / before;
        beaten += error >= before;
    }
    if (!all) return;
    char text[32];
    sl_seconds_text(middle_of(seconds, all), text);
    fprintf(out, "| %s | %s | %zu | %s | %.2g %% |", curve, sl_bench_quality_name((sl_bench_quality)quality),
            all, text, 100.0 * middle_of(errors, all));
    double time = middle_of(times, pairs), share = middle_of(shares, pairs);
    if (!pairs) fputs(" | | | |\n", out);
    else
        fprintf(out, " %.1f | %.2f | %.2f | %zu of %zu |\n", time, share,
                time > 1.0 ? -log(share) / log(time) : 0.0, beaten, pairs);
}

static void put_qualities(FILE *out, const sl_bench_results *r) {
    static const char *const curves[] = {"splatting",     "direct-radiance",
                                         "light-octree",  "photons at pixels",    "multi-mesh",
                                         "shading-cache", "path",           "bidirectional"};
    double *work = calloc(4 * r->scene_count + 1, sizeof *work);
    sl_report_head(out,
                   "method|quality|>scenes|>cpu s|>error of its own paths|>times the seconds|>error left|>"
                   "exponent|>no better");
    for (size_t c = 0; work && c < sizeof curves / sizeof *curves; c++) {
        for (int q = SL_BENCH_DRAFT; q <= SL_BENCH_HIGH; q++) put_quality(out, r, curves[c], q, work);
    }
    free(work);
}

/* ---- what is left out ---- */

static const sl_bench_reference *reference_of(const sl_bench_scene *s, const char *transport) {
    for (size_t k = 0; k < s->reference_count; k++) {
        const sl_bench_reference *r = &s->references[k];
        if (r->missing_known && strcmp(r->transport, transport) == 0) return r;
    }
    return NULL;
}

static void put_left_out(FILE *out, const sl_bench_results *r) {
    sl_report_head(out, "scene|>direct light|>its error against all light");
    for (size_t i = 0; i < r->scene_count; i++) {
        const sl_bench_reference *direct = reference_of(&r->scenes[i], "direct");
        char missing[32];
        if (!direct) continue;
        sl_missing_text(direct, 0, missing);
        fprintf(out, "| %s | %.0f %% | %s |\n", r->scenes[i].name, 100.0 * direct->energy, missing);
    }
}

/* ---- errors told without a reference ---- */

/* Of a method, or with NULL of all: how many bounds could be checked, what is lost in the reference's noise
 * can check none; how many of those hold; how far above the measured error they are, in the middle. */
static void put_promises_of(FILE *out, const sl_bench_results *r, const char *method) {
    enum { MOST = 4096 };
    static double slack[MOST];
    int made = 0, kept = 0;
    for (size_t i = 0; i < r->scene_count; i++) {
        for (size_t k = 0; k < r->scenes[i].row_count && made < MOST; k++) {
            const sl_bench_row *row = &r->scenes[i].rows[k];
            const sl_bench_error *e = &row->error[SL_BENCH_MATCHED];
            if (!sl_bench_promises(row) || !e->known || e->lost || !(e->rel_rmse > 0.0) ||
                (method && strcmp(row->trial->method, method) != 0))
                continue;
            slack[made] = sl_bench_number(row->result, "bound") / e->rel_rmse;
            kept += slack[made++] >= 1.0;
        }
    }
    if (made)
        fprintf(out, "| %s | %d | %.0f %% | %.2f |\n", method ? method : "all", made, 100.0 * kept / made,
                middle_of(slack, (size_t)made));
}

static void put_promises(FILE *out, const sl_bench_results *r) {
    sl_report_head(out, "method|>pictures judged|>within the bound|>bound over measured, median");
    for (size_t m = 0; sl_method_name(m); m++) put_promises_of(out, r, sl_method_name(m));
    put_promises_of(out, r, NULL);
}

/* ---- all together ---- */

void sl_report_tables(FILE *out, const void *what) {
    const sl_bench_results *results = what;
    static const struct {
        const char *name;
        void (*put)(FILE *out, const sl_bench_results *results);
    } tables[] = {{"machine", put_machine},     {"goal", put_goal},         {"best", put_best},
                  {"failures", put_failures},   {"qualities", put_qualities}, {"left-out", put_left_out},
                  {"promises", put_promises}};
    if (results->trials->table_count) {
        sl_report_trials(out, results);
        return;
    }
    for (size_t i = 0; i < sizeof tables / sizeof *tables; i++) {
        fprintf(out, "<!-- table %s -->\n", tables[i].name);
        tables[i].put(out, results);
        fputs("<!-- end -->\n", out);
    }
}

void sl_report_overview(FILE *out, const void *results) {
    const sl_bench_results *r = results;
    fputs("# Speed against error\n\n", out);
    put_machine(out, r);
    fputs(
        "\nErrors are relative RMSE: the root of the mean squared difference over the reference's mean, of "
        "all pixels, each the mean over its square, lamps that are seen included; the reference's own noise "
        "is subtracted. What that noise leaves in doubt is below a tenth of the error (95 % confidence), or "
        "stands behind it as ±; "
        "`<`: at most, and perhaps nothing; `≥`: lost in the noise, and no less than the energy that is "
        "missing. *matched*: against the light paths that the method itself declares; *all "
        "light*: against all of global illumination. Times are the processor's, of all "
        "threads together.\n\nScenes:",
        out);
    for (size_t i = 0; i < r->scene_count; i++)
        fprintf(out, "%s [%s](#%s)", i ? "," : "", r->scenes[i].name, r->scenes[i].name);
    fputs("\n\nAll light, the best of the methods beside the path tracer. ", out);
    put_goal(out, r);
    fputs(
        "\nErrors told without a reference (`softlux render --error`): how often the measured one is within "
        "the bound, which is to hold in 95 %.\n\n",
        out);
    put_promises(out, r);
}
