/* The report's part about a scene, as Markdown; and about all scenes, as lines for a terminal. */
#include "app/bench/results.h"
#include "app/bench/plot.h"
#include "app/bench/report.h"

#include <string.h>

static const double wanted_errors[] = {0.2, 0.1, 0.05, 0.02, 0.01, 0.005};
enum { WANTED = sizeof wanted_errors / sizeof *wanted_errors };

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
    char text[32];
    fprintf(out, "| %s | %s |", r->trial->curve, r->trial->name);
    if (r->end != SL_CHILD_DONE) {
        fprintf(out, " %s: %s | | | | | | | `%s` |\n", sl_bench_end_name(r->end), r->why,
                r->trial->arguments);
        return;
    }
    put_spread(out, &r->cpu);
    put_spread(out, &r->wall);
    sl_seconds_text(sl_bench_number(r->look, "first_picture"), text);
    fprintf(out, " %s | %.0f |", text, sl_bench_number(r->result, "peak_bytes") / 1048576.0);
    sl_error_text(&r->error[SL_BENCH_MATCHED], text);
    fprintf(out, " %s |", text);
    sl_error_text(&r->error[SL_BENCH_FULL], text);
    fprintf(out, " %s |", text);
    if (sl_bench_promises(r))
        fprintf(out, " %.3g %%, at most %.3g %% |", 100.0 * sl_bench_number(r->result, "estimate"),
                100.0 * sl_bench_number(r->result, "bound"));
    else fputs(" - |", out);
    fprintf(out, " `%s` |\n", r->trial->arguments);
}

static void put_times(FILE *out, const sl_bench_scene *s, sl_bench_truth truth, const char *title) {
    sl_curve curves[SL_CURVES];
    size_t count = sl_curves_of(s, truth, curves);
    if (!count) return;
    fprintf(out, "\n%s: processor seconds until the relative RMSE is at most\n\n", title);
    sl_report_head(out, "|>20 %|>10 %|>5 %|>2 %|>1 %|>0.5 %");
    for (size_t k = 0; k < count; k++) {
        fprintf(out, "| %s |", curves[k].name);
        for (int i = 0; i < WANTED; i++) {
            char text[32];
            sl_seconds_text(sl_curve_time_to(&curves[k], truth, wanted_errors[i]), text);
            fprintf(out, " %s |", text);
        }
        fputc('\n', out);
    }
}

static void put_reference(FILE *out, const sl_bench_reference *r) {
    char missing[32];
    if (!r->samples) {
        fprintf(out, "| %s | none: %s | | | | |\n", r->transport,
                r->trouble[0] ? r->trouble : "there was no time for it");
        return;
    }
    fprintf(out, "| %s | %llu | %.3g %% |", r->transport, (unsigned long long)r->samples, 100.0 * r->noise);
    if (r->wanted > 0.0)
        fprintf(out, " %.2g ± %.1g %%%s |", 1000.0 * r->wanted, 1000.0 * r->wanted * r->doubt,
                r->noise <= r->wanted ? "" : ", noise above a tenth");
    else fputs(" |", out);
    sl_missing_text(r, 2, missing);
    if (r->missing_known) fprintf(out, " %.1f %% | %s |\n", 100.0 * r->energy, missing);
    else fputs(strcmp(r->transport, "full") == 0 ? " 100 % | |\n" : " | |\n", out);
}

void sl_report_scene(FILE *out, const void *what) {
    const sl_bench_scene *s = what;
    fprintf(out, "\n## %s\n\n", s->name);
    if (s->trouble[0]) {
        fprintf(out, "Nothing was measured: %s\n", s->trouble);
        return;
    }
    fprintf(out, "`%s`, %d x %d, %llu triangles.\n\n", s->path, s->width, s->height,
            (unsigned long long)s->triangles);
    sl_report_head(out, "method|setting|>cpu s|>wall s|>first picture, cpu s|>peak MB|>matched|>all light|>"
                        ">told without a reference|options");
    for (size_t i = 0; i < s->row_count; i++) put_row(out, &s->rows[i]);
    fputc('\n', out);
    for (int i = 0; i < SL_PLOTS; i++)
        if (sl_plot_is_there(&(sl_plot){s, i}))
            fprintf(out, "![%s, %s](%s-%s.svg)\n", s->name, sl_plot_name(i), s->name, sl_plot_name(i));
    put_times(out, s, SL_BENCH_FULL, "Against all light");
    fputc('\n', out);
    sl_report_head(out,
                   "reference|>samples a pixel|>its noise|>smallest error told with it|>light in it|>what "
                   "it leaves out of full");
    for (size_t i = 0; i < s->reference_count; i++) put_reference(out, &s->references[i]);
}

/* ---- the terminal ---- */

static void print_lead(FILE *out, const sl_bench_scene *s, double error) {
    sl_lead lead = sl_lead_at(s, SL_BENCH_FULL, error);
    if (!lead.method) return;
    fprintf(out, "  %g %% of all light: %s after %.3g s", 100.0 * error, lead.method, lead.seconds);
    if (lead.path_seconds > 0.0)
        fprintf(out, ", the path tracer %s %.3g s (%s%.1f times)", lead.path_later ? "not within" : "after",
                lead.path_seconds, lead.path_later ? "more than " : "", lead.path_seconds / lead.seconds);
    fputc('\n', out);
}

static void print_row(FILE *out, const sl_bench_row *r) {
    char seconds[32], matched[32], full[32];
    fprintf(out, "  %-26s %-34s ", r->trial->curve, r->trial->name);
    if (r->end != SL_CHILD_DONE) {
        fprintf(out, "%s: %s\n", sl_bench_end_name(r->end), r->why);
        return;
    }
    sl_seconds_text(r->cpu.median, seconds);
    sl_error_text(&r->error[SL_BENCH_MATCHED], matched);
    sl_error_text(&r->error[SL_BENCH_FULL], full);
    fprintf(out, "%9s %9s %9s\n", seconds, matched, full);
}

void sl_report_terminal(const sl_bench_results *results, FILE *out) {
    for (size_t k = 0; k < results->scene_count; k++) {
        const sl_bench_scene *s = &results->scenes[k];
        if (s->trouble[0]) {
            fprintf(out, "%s: %s\n", s->name, s->trouble);
            continue;
        }
        fprintf(out, "%s, %d x %d\n  %-26s %-34s %9s %9s %9s\n", s->name, s->width, s->height, "method",
                "setting", "cpu s", "matched", "all light");
        for (size_t i = 0; i < s->row_count; i++) print_row(out, &s->rows[i]);
        print_lead(out, s, 0.05);
        print_lead(out, s, 0.01);
    }
    if (results->noisy)
        fprintf(
            out,
            "the machine was noisy: by the clock runs of the same trial differed by %.0f %%, and they had a "
            "processor for %.0f %% of the time\n",
            100.0 * results->unrest, 100.0 * results->share_of_processor);
    if (results->interrupted) fputs("interrupted: the same command goes on from here\n", out);
}
