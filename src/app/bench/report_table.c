/* The results as tables: Markdown for the documentation, lines for the terminal. */
#include "app/bench/curves.h"
#include "app/bench/report.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- Markdown ---- */

static const double wanted_errors[] = {0.2, 0.1, 0.05, 0.02, 0.01, 0.005};
enum { WANTED = sizeof wanted_errors / sizeof *wanted_errors };

static void put_head(FILE *out, const sl_bench_results *r) {
    fprintf(
        out,
        "softlux %s, %s, %d thread%s%s, %d run%s of a setting that takes less than a second, medians%s.\n\n",
        r->version, r->machine, r->threads, r->threads == 1 ? "" : "s", r->date[0] ? r->date : "", r->repeats,
        r->repeats == 1 ? "" : "s", r->interrupted ? "; **interrupted: what was measured until then**" : "");
    fprintf(out,
            "The machine was %s: a fixed amount of arithmetic between the trials took %.1f ms by the clock, "
            "%.1f to %.1f; half the distance of its quartiles is "
            "%.1f %% of that (by the processor's own time %.1f %%), and %.0f %% of the clock's time went to "
            "it. Times below are the processor's, of all threads together.\n\n",
            r->noisy ? "**noisy**" : "quiet", 1e3 * r->calibration.median, 1e3 * r->calibration.least,
            1e3 * r->calibration.most, 100.0 * r->unrest, 100.0 * r->unrest_cpu,
            100.0 * r->share_of_processor);
    fprintf(out, "Errors are relative RMSE: the root of the mean squared difference over the reference's "
                 "mean, over the pixels that look at neither lamp nor sky; the "
                 "reference's own noise is subtracted. What that noise leaves in doubt is below a tenth of "
                 "the error (95 %% confidence), or stands behind it as ±; `<`: at most, and "
                 "perhaps nothing; `≥`: lost in the noise, and no less than the energy that is missing. "
                 "*matched*: against the light paths that the method itself declares; "
                 "*one bounce*: direct light and one diffuse bounce; *full*: all of global illumination.\n");
}

static void put_spread(FILE *out, const sl_bench_spread *s) {
    char median[32], least[32], most[32];
    sl_seconds_text(s->median, median);
    sl_seconds_text(s->least, least);
    sl_seconds_text(s->most, most);
    if (s->count == 0) fprintf(out, " - |");
    else if (s->count == 1) fprintf(out, " %s |", median);
    else fprintf(out, " %s (%s..%s) |", median, least, most);
}

static void put_row(FILE *out, const sl_bench_row *r) {
    char text[64];
    fprintf(out, "| %s | %s |", r->curve, r->name);
    if (r->end != SL_BENCH_RAN) {
        fprintf(out, " %s: %s | | | | | | | | `%s` |\n", sl_bench_end_name(r->end), r->why, r->arguments);
        return;
    }
    put_spread(out, &r->cpu);
    put_spread(out, &r->wall);
    if (r->first_picture > 0.0) sl_seconds_text(r->first_picture, text);
    fprintf(out, " %s | %.0f |", r->first_picture > 0.0 ? text : "", (double)r->peak_bytes / 1048576.0);
    for (int t = 0; t < SL_BENCH_TRUTHS; t++) {
        sl_error_text(&r->error[t], text);
        fprintf(out, " %s |", text);
    }
    sl_promise_text(&r->promise, text);
    fprintf(out, " %s | `%s` |\n", text, r->arguments);
}

static void put_times(FILE *out, const sl_bench_scene *s, sl_bench_truth truth, const char *title) {
    sl_curve curves[SL_CURVES];
    size_t count = sl_curves_of(s, truth, curves);
    if (!count) return;
    fprintf(out, "\n%s: processor seconds until the relative RMSE is at most\n\n| |", title);
    for (int i = 0; i < WANTED; i++) fprintf(out, " %g %% |", 100.0 * wanted_errors[i]);
    fputs("\n| --- |", out);
    for (int i = 0; i < WANTED; i++) fputs(" ---: |", out);
    fputc('\n', out);
    for (size_t k = 0; k < count; k++) {
        fprintf(out, "| %s |", curves[k].name);
        for (int i = 0; i < WANTED; i++) {
            char text[32] = "";
            double seconds = sl_curve_time_to(&curves[k], truth, wanted_errors[i]);
            if (seconds > 0.0) sl_seconds_text(seconds, text);
            fprintf(out, " %s |", text);
        }
        fputc('\n', out);
    }
}

static void put_references(FILE *out, const sl_bench_scene *s) {
    fputs("\n| reference | samples a pixel | its noise | smallest error told with it | light in it | what it "
          "leaves out of full |\n| --- | ---: | ---: | ---: | ---: | ---: |\n",
          out);
    for (size_t i = 0; i < s->reference_count; i++) {
        const sl_bench_reference *r = &s->references[i];
        if (!r->samples) {
            fprintf(out, "| %s | none: %s | | | | |\n", r->transport,
                    r->trouble[0] ? r->trouble : "there was no time for it");
            continue;
        }
        char smallest[96], missing[32];
        sl_reference_text(r, smallest);
        sl_missing_text(r, 2, missing);
        fprintf(out, "| %s | %llu | %.3g %% | %s |", r->transport, (unsigned long long)r->samples,
                100.0 * r->noise, smallest);
        if (r->missing_known) fprintf(out, " %.1f %% | %s |\n", 100.0 * r->energy, missing);
        else fputs(strcmp(r->transport, "full") == 0 ? " 100 % | |\n" : " | |\n", out);
    }
}

/* Puts the whole report in a table: the best of the methods against the path tracer. */
static void put_leads(FILE *out, const sl_bench_results *r, double error) {
    fprintf(out,
            "\n| %g %% of one bounce | best method | cpu s | path tracer, cpu s | times as soon |\n| --- | "
            "--- | ---: | ---: | ---: |\n",
            100.0 * error);
    for (size_t i = 0; i < r->scene_count; i++) {
        sl_bench_lead lead = sl_bench_lead_at(&r->scenes[i], SL_BENCH_ONE_BOUNCE, error);
        char seconds[32] = "", path[32] = "", times[32] = "";
        if (r->scenes[i].trouble[0]) continue;
        if (lead.method) sl_seconds_text(lead.seconds, seconds);
        if (lead.path_seconds > 0.0) sl_seconds_text(lead.path_seconds, path);
        if (lead.method && lead.path_seconds > 0.0)
            snprintf(times, sizeof times, "%.1f", lead.path_seconds / lead.seconds);
        fprintf(out, "| [%s](#%s) | %s | %s | %s%s | %s%s |\n", r->scenes[i].name, r->scenes[i].name,
                lead.method ? lead.method : "none gets there", seconds, lead.path_later ? "more than " : "",
                path, lead.path_later && lead.method ? "more than " : "", times);
    }
}

void sl_report_promises(FILE *out, const sl_bench_results *r) {
    fputs("| method | pictures judged | within the bound | bound over measured, median |\n| --- | ---: | "
          "---: | ---: |\n",
          out);
    for (size_t m = 0;; m++) {
        const char *name = sl_method_name(m);
        sl_bench_kept k = sl_bench_promises(r, name);
        if (k.made)
            fprintf(out, "| %s | %d | %.0f %% | %.2f |\n", name ? name : "all", k.made,
                    100.0 * k.kept / k.made, k.slack);
        if (!name) break;
    }
}

void sl_report_scene(FILE *out, const sl_bench_scene *s) {
    fprintf(out, "\n## %s\n\n", s->name);
    if (s->trouble[0]) {
        fprintf(out, "Nothing was measured: %s\n", s->trouble);
        return;
    }
    fprintf(out, "`%s`, %d x %d, %llu triangles, %llu pixels compared.\n\n", s->path, s->width, s->height,
            (unsigned long long)s->triangles, (unsigned long long)s->pixels_compared);
    fputs("| method | setting | cpu s | wall s | first picture, cpu s | peak MB | matched | one bounce | "
          "full | whole picture, told without a reference | options |\n"
          "| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | --- |\n",
          out);
    for (size_t i = 0; i < s->row_count; i++) put_row(out, &s->rows[i]);
    static const char *const plots[] = {"one-bounce", "full", "matched", "parts"};
    bool looked = false;
    for (size_t i = 0; i < s->row_count; i++)
        looked = looked || (s->rows[i].part_count > 0 && strcmp(s->rows[i].method, "path") != 0 &&
                            strcmp(s->rows[i].method, "bidirectional") != 0);
    fputc('\n', out);
    for (int i = 0; i < 3 + looked; i++)
        fprintf(out, "![%s, %s](%s-%s.svg)\n", s->name, plots[i], s->name, plots[i]);
    put_times(out, s, SL_BENCH_ONE_BOUNCE, "Against one bounce");
    put_times(out, s, SL_BENCH_FULL, "Against full global illumination");
    put_references(out, s);
}

void sl_report_overview(FILE *out, const sl_bench_results *results) {
    fputs("# Speed against error\n\n", out);
    put_head(out, results);
    put_leads(out, results, 0.05);
    put_leads(out, results, 0.02);
    put_leads(out, results, 0.01);
    fputs("\nErrors told without a reference (`softlux render --error`): how often the measured one is "
          "within the bound, which is to hold in "
          "95 %.\n\n",
          out);
    sl_report_promises(out, results);
}

static void put_report(FILE *out, const sl_bench_results *results) {
    sl_report_overview(out, results);
    for (size_t s = 0; s < results->scene_count; s++) sl_report_scene(out, &results->scenes[s]);
}

sl_status sl_report_markdown(const sl_bench_results *results, const char *folder, sl_error *error) {
    return sl_report_compose(results, folder, "report.md", put_report, error);
}

/* ---- the terminal ---- */

static void print_lead(FILE *out, const sl_bench_scene *s, double error) {
    sl_bench_lead lead = sl_bench_lead_at(s, SL_BENCH_ONE_BOUNCE, error);
    if (!lead.method) return;
    fprintf(out, "  %g %% of one bounce: %s after %.3g s", 100.0 * error, lead.method, lead.seconds);
    double times = lead.path_seconds / lead.seconds;
    if (lead.path_seconds > 0.0)
        fprintf(out, ", the path tracer %s %.3g s (%s%.1f times)\n", lead.path_later ? "not within" : "after",
                lead.path_seconds, lead.path_later ? "more than " : "", times);
    else fputc('\n', out);
}

void sl_report_terminal(const sl_bench_results *results, FILE *out) {
    for (size_t k = 0; k < results->scene_count; k++) {
        const sl_bench_scene *s = &results->scenes[k];
        if (s->trouble[0]) {
            fprintf(out, "%s: %s\n", s->name, s->trouble);
            continue;
        }
        fprintf(out, "%s, %d x %d\n  %-26s %-34s %9s %9s %9s %9s\n", s->name, s->width, s->height, "method",
                "setting", "cpu s", "matched", "1 bounce", "full");
        for (size_t i = 0; i < s->row_count; i++) {
            const sl_bench_row *r = &s->rows[i];
            char seconds[32], errors[SL_BENCH_TRUTHS][32];
            fprintf(out, "  %-26s %-34s ", r->curve, r->name);
            if (r->end != SL_BENCH_RAN) {
                fprintf(out, "%s: %s\n", sl_bench_end_name(r->end), r->why);
                continue;
            }
            sl_seconds_text(r->cpu.median, seconds);
            for (int t = 0; t < SL_BENCH_TRUTHS; t++) sl_error_text(&r->error[t], errors[t]);
            fprintf(out, "%9s %9s %9s %9s\n", seconds, errors[0], errors[1], errors[2]);
        }
        print_lead(out, s, 0.05);
        print_lead(out, s, 0.01);
    }
    if (results->noisy)
        fprintf(out,
                "the machine was noisy: the clock varied by %.0f %% on the same work, of which the processor "
                "had %.0f %% of the time\n",
                100.0 * results->unrest, 100.0 * results->share_of_processor);
    if (results->interrupted) fputs("interrupted: the same command goes on from here\n", out);
}
