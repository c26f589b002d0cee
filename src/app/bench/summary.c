/* What the measurements say, as tables for the page that says it in words (docs/speed-against-error.md): one
 * file of them, each between two marks, which bench/fill_tables.sh puts into the page. */
#include "app/bench/curves.h"
#include "app/bench/report.h"
#include "app/bench/trials.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static void begin(FILE *out, const char *name) { fprintf(out, "<!-- table %s -->\n", name); }
static void end(FILE *out) { fputs("<!-- end -->\n", out); }

static const char *surfaces_of(const sl_bench_scene *s) {
    return s->mirrors ? "mirrors" : s->glossy ? "glossy" : "diffuse";
}

static bool is_measured(const sl_bench_scene *s) { return !s->trouble[0] && s->row_count > 0; }

/* ---- how it was measured ---- */

static void put_machine(FILE *out, const sl_bench_results *r) {
    size_t scenes = 0, rows = 0, references = 0, below = 0, sure = 0;
    for (size_t i = 0; i < r->scene_count; i++) {
        const sl_bench_scene *s = &r->scenes[i];
        scenes += is_measured(s);
        for (size_t k = 0; k < s->row_count; k++) rows += s->rows[k].end == SL_BENCH_RAN;
        for (size_t k = 0; k < s->reference_count; k++) {
            const sl_bench_reference *reference = &s->references[k];
            if (!(reference->wanted > 0.0)) continue;
            references++;
            below += reference->noise <= reference->wanted;
            sure += reference->doubt <= 0.1;
        }
    }
    begin(out, "machine");
    fprintf(out, "%zu scenes, %zu pictures", scenes, rows);
    if (scenes) fprintf(out, " of %d x %d pixels", r->scenes[0].width, r->scenes[0].height);
    fprintf(out,
            ", softlux %s on %s, %d thread%s, medians of up to %d runs. The machine was %s: between the "
            "trials the same arithmetic varied by %.1f %% by the "
            "processor's time (half the distance of the quartiles), and had %.0f %% of the clock's. Of %zu "
            "references %zu are less noisy than a tenth of the smallest "
            "error told with them; of %zu what their noise leaves in doubt, once it is subtracted, is below "
            "a tenth of that error (95 %% confidence), and where it is "
            "not, the report says so behind the figure.\n",
            r->version, r->machine, r->threads, r->threads == 1 ? "" : "s", r->repeats,
            r->noisy ? "busy" : "quiet", 100.0 * r->unrest_cpu, 100.0 * r->share_of_processor, references,
            below, sure);
    end(out);
}

/* ---- the goal ---- */

static void put_times_as_soon(FILE *out, const sl_bench_scene *s, double error, bool named) {
    sl_bench_lead lead = sl_bench_lead_at(s, SL_BENCH_ONE_BOUNCE, error);
    char seconds[32], path[32];
    if (!lead.method) {
        fprintf(out, "%s not reached | | |", named ? " |" : "");
        return;
    }
    sl_seconds_text(lead.seconds, seconds);
    sl_seconds_text(lead.path_seconds, path);
    if (named) fprintf(out, " %s |", lead.method);
    fprintf(out, " %s | %s%s |", seconds, lead.path_later && lead.path_seconds > 0.0 ? "> " : "",
            lead.path_seconds > 0.0 ? path : "");
    if (lead.path_seconds > 0.0)
        fprintf(out, " %s%.1f |", lead.path_later ? "> " : "", lead.path_seconds / lead.seconds);
    else fputs(" |", out);
}

/* Counts how many of the scenes with diffuse surfaces alone are `times` sooner at an error, how many may be
 * (the path tracer's time is only bounded), and how many there are. */
static void count_leads(const sl_bench_results *r, double error, double times, size_t *scenes,
                        size_t *reached) {
    *scenes = *reached = 0;
    for (size_t i = 0; i < r->scene_count; i++) {
        const sl_bench_scene *s = &r->scenes[i];
        if (!is_measured(s) || s->glossy || s->mirrors) continue;
        sl_bench_lead lead = sl_bench_lead_at(s, SL_BENCH_ONE_BOUNCE, error);
        ++*scenes;
        *reached += lead.method && lead.path_seconds >= times * lead.seconds;
    }
}

static void put_goal(FILE *out, const sl_bench_results *r) {
    size_t scenes, five, ahead;
    count_leads(r, 0.05, 10.0, &scenes, &five);
    count_leads(r, 0.01, 1.0, &scenes, &ahead);
    begin(out, "goal");
    fprintf(out,
            "Of %zu scenes with diffuse surfaces alone, the best method reaches 5 %% at least ten times "
            "sooner than the path tracer in **%zu**, and 1 %% sooner in **%zu**. "
            "Processor seconds; `>`: the path tracer was not there after its longest run.\n\n",
            scenes, five, ahead);
    fputs(
        "| scene | surfaces | best at 5 % | 5 % | path | times | 2 % | path | times | 1 % | path | times |\n"
        "| --- | --- | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n",
        out);
    for (size_t i = 0; i < r->scene_count; i++) {
        const sl_bench_scene *s = &r->scenes[i];
        if (!is_measured(s)) continue;
        fprintf(out, "| %s | %s |", s->name, surfaces_of(s));
        put_times_as_soon(out, s, 0.05, true);
        put_times_as_soon(out, s, 0.02, false);
        put_times_as_soon(out, s, 0.01, false);
        fputc('\n', out);
    }
    end(out);
}

/* ---- which method for which scene ---- */

/* Puts the first to reach an error, tracers among them; and how much sooner than the second. */
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
    if (!first) {
        fputs(" none |", out);
        return;
    }
    sl_seconds_text(best, text);
    fprintf(out, " %s, %s s", first, text);
    if (second < HUGE_VAL) fprintf(out, " (%.1f x)", second / best);
    fputs(" |", out);
}

static void put_best(FILE *out, const sl_bench_results *r) {
    begin(out, "best");
    fputs("| scene | surfaces | first at 5 % of one bounce | first at 20 % of all light | at 10 % | at 5 % | "
          "at 2 % |\n| --- | --- | --- | --- | --- | --- | --- |\n",
          out);
    for (size_t i = 0; i < r->scene_count; i++) {
        const sl_bench_scene *s = &r->scenes[i];
        if (!is_measured(s)) continue;
        fprintf(out, "| %s | %s |", s->name, surfaces_of(s));
        put_first(out, s, SL_BENCH_ONE_BOUNCE, 0.05);
        put_first(out, s, SL_BENCH_FULL, 0.2);
        put_first(out, s, SL_BENCH_FULL, 0.1);
        put_first(out, s, SL_BENCH_FULL, 0.05);
        put_first(out, s, SL_BENCH_FULL, 0.02);
        fputc('\n', out);
    }
    end(out);
}

/* ---- where each fails ---- */

typedef struct floor_of {
    const char *scene;
    double error;
} floor_of;

static int by_error(const void *a, const void *b) {
    const floor_of *x = a, *y = b;
    if (x->error != y->error) return x->error > y->error ? -1 : 1;
    return strcmp(x->scene, y->scene);
}

/* Finds the smallest error of a curve in each scene, the largest of these first. */
static size_t floors_of(const sl_bench_results *r, const char *curve, sl_bench_truth truth,
                        floor_of *floors) {
    size_t count = 0;
    for (size_t i = 0; i < r->scene_count; i++) {
        const sl_bench_scene *s = &r->scenes[i];
        double least = HUGE_VAL;
        for (size_t k = 0; k < s->row_count; k++) {
            const sl_bench_row *row = &s->rows[k];
            if (row->end == SL_BENCH_RAN && strcmp(row->curve, curve) == 0 && row->error[truth].known)
                least = fmin(least, row->error[truth].rel_rmse);
        }
        if (least < HUGE_VAL) floors[count++] = (floor_of){s->name, least};
    }
    qsort(floors, count, sizeof *floors, by_error);
    return count;
}

static void put_floors(FILE *out, const floor_of *floors, size_t count) {
    enum { SHOWN = 4 };
    double middle = count ? 50.0 * (floors[(count - 1) / 2].error + floors[count / 2].error) : 0.0;
    fprintf(out, " %.2g %% |", middle);
    for (size_t i = 0; i < count && i < SHOWN; i++)
        fprintf(out, "%s%s %.*f %%", i ? ", " : " ", floors[i].scene, floors[i].error < 0.0995,
                100.0 * floors[i].error);
    fputs(" |", out);
}

static void put_failures(FILE *out, const sl_bench_results *r) {
    static const struct { const char *curve, *what;
    } curves[] = {{"splatting", "one bounce"},          {"splatting, 6 bounces", "all light"},
                  {"direct-radiance", "its own paths"}, {"light-octree", "its own paths"},
                  {"multi-mesh", "its own paths"},      {"shading-cache", "its own paths"},
                  {"photons at pixels", "all light"}};
    floor_of *floors = calloc(r->scene_count + 1, sizeof *floors);
    begin(out, "failures");
    fputs("| method | against | smallest error of all settings, median scene | the scenes where that is "
          "largest |\n| --- | --- | ---: | --- |\n",
          out);
    for (size_t c = 0; floors && c < sizeof curves / sizeof *curves; c++) {
        sl_bench_truth truth = strcmp(curves[c].what, "all light") == 0    ? SL_BENCH_FULL
                               : strcmp(curves[c].what, "one bounce") == 0 ? SL_BENCH_ONE_BOUNCE
                                                                           : SL_BENCH_MATCHED;
        size_t count = floors_of(r, curves[c].curve, truth, floors);
        if (!count) continue;
        fprintf(out, "| %s | %s |", curves[c].curve, curves[c].what);
        put_floors(out, floors, count);
        fputc('\n', out);
    }
    end(out);
    free(floors);
}

/* ---- qualities ---- */

static const sl_bench_row *row_of(const sl_bench_scene *s, const char *curve, sl_bench_quality quality) {
    for (size_t i = 0; i < s->row_count; i++) {
        const sl_bench_row *row = &s->rows[i];
        if (row->quality == quality && strcmp(row->curve, curve) == 0)
            return row->end == SL_BENCH_RAN && row->error[SL_BENCH_MATCHED].known ? row : NULL;
    }
    return NULL;
}

static double middle_of(double *values, size_t count) {
    return sl_bench_spread_of(values, (int)count).median;
}

/* Puts, of the scenes where both ran, how many times the seconds of the quality below, what share of its
 * error, and in how many scenes no smaller an error. */
static void put_step(FILE *out, const sl_bench_results *r, const char *curve, sl_bench_quality quality,
                     double *work) {
    double *errors = work, *times = work + r->scene_count, *shares = work + 2 * r->scene_count,
           *seconds = work + 3 * r->scene_count;
    size_t all = 0, pairs = 0, beaten = 0;
    for (size_t i = 0; i < r->scene_count; i++) {
        const sl_bench_row *row = row_of(&r->scenes[i], curve, quality);
        const sl_bench_row *below =
            quality > SL_BENCH_DRAFT ? row_of(&r->scenes[i], curve, (sl_bench_quality)(quality - 1)) : NULL;
        if (!row) continue;
        double error = row->error[SL_BENCH_MATCHED].rel_rmse;
        seconds[all] = row->cpu.median;
        errors[all++] = error;
        if (!below || !(below->error[SL_BENCH_MATCHED].rel_rmse > 0.0) || !(below->cpu.median > 0.0))
            continue;
        times[pairs] = row->cpu.median / below->cpu.median;
        shares[pairs++] = error / below->error[SL_BENCH_MATCHED].rel_rmse;
        beaten += error >= below->error[SL_BENCH_MATCHED].rel_rmse;
    }
    if (!all) return;
    char text[32];
    sl_seconds_text(middle_of(seconds, all), text);
    fprintf(out, "| %s | %s | %zu | %s | %.2g %% |", curve, sl_bench_quality_name(quality), all, text,
            100.0 * middle_of(errors, all));
    if (!pairs) {
        fputs(" | | | |\n", out);
        return;
    }
    double time = middle_of(times, pairs), share = middle_of(shares, pairs);
    fprintf(out, " %.1f | %.2f | %.2f | %zu of %zu |\n", time, share,
            time > 1.0 ? -log(share) / log(time) : 0.0, beaten, pairs);
}

static void put_qualities(FILE *out, const sl_bench_results *r) {
    static const char *const curves[] = {"splatting",     "splatting, 6 bounces", "direct-radiance",
                                         "light-octree",  "photons at pixels",    "multi-mesh",
                                         "shading-cache", "path, full",           "bidirectional, full"};
    double *work = calloc(4 * r->scene_count + 1, sizeof *work);
    begin(out, "qualities");
    fputs("| method | quality | scenes | cpu s | error of its own paths | times the seconds | error left | "
          "exponent | no better |\n"
          "| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n",
          out);
    for (size_t c = 0; work && c < sizeof curves / sizeof *curves; c++) {
        for (int q = SL_BENCH_DRAFT; q <= SL_BENCH_HIGH; q++)
            put_step(out, r, curves[c], (sl_bench_quality)q, work);
    }
    end(out);
    free(work);
}

/* ---- what is left out ---- */

static void put_left_out(FILE *out, const sl_bench_results *r) {
    begin(out, "left-out");
    fputs(
        "| scene | direct light | one bounce | its error against all light |\n| --- | ---: | ---: | ---: |\n",
        out);
    for (size_t i = 0; i < r->scene_count; i++) {
        const sl_bench_scene *s = &r->scenes[i];
        const sl_bench_reference *direct = NULL, *one = NULL;
        for (size_t k = 0; k < s->reference_count; k++) {
            if (!s->references[k].missing_known) continue;
            if (strcmp(s->references[k].transport, "direct") == 0) direct = &s->references[k];
            if (strcmp(s->references[k].transport, "one-bounce") == 0) one = &s->references[k];
        }
        if (!direct || !one) continue;
        char missing[32];
        sl_missing_text(one, 0, missing);
        fprintf(out, "| %s | %.0f %% | %.0f %% | %s |\n", s->name, 100.0 * direct->energy,
                100.0 * one->energy, missing);
    }
    end(out);
}

static void put_tables(FILE *out, const sl_bench_results *results) {
    if (results->trials->table_count) {
        sl_report_trials(out, results);
        return;
    }
    put_machine(out, results);
    put_goal(out, results);
    put_best(out, results);
    put_failures(out, results);
    put_qualities(out, results);
    put_left_out(out, results);
    begin(out, "promises");
    sl_report_promises(out, results);
    end(out);
}

sl_status sl_report_summary(const sl_bench_results *results, const char *folder, sl_error *error) {
    return sl_report_compose(results, folder, "tables.md", put_tables, error);
}
