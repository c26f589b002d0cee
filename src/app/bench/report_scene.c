/* The report's part about a scene, as Markdown. */
#include "app/bench/report.h"

#include <string.h>

static const double wanted_errors[] = {0.2, 0.1, 0.05, 0.02, 0.01, 0.005};
enum { WANTED = sizeof wanted_errors / sizeof *wanted_errors };

/* Puts the processor seconds along each curve until an error against all light. */
static void put_times(FILE *out, const sl_bench_scene *s) {
    sl_curve curves[SL_CURVES];
    size_t count = sl_curves_of(s, SL_BENCH_FULL, curves);
    if (!count) return;
    fputs("\nAgainst all light: processor seconds until the relative RMSE is at most\n\n", out);
    sl_report_head(out, "|>20 %|>10 %|>5 %|>2 %|>1 %|>0.5 %");
    for (size_t k = 0; k < count; k++) {
        fprintf(out, "| %s |", curves[k].name);
        for (int i = 0; i < WANTED; i++) {
            char text[32];
            sl_seconds_text(sl_curve_time_to(&curves[k], SL_BENCH_FULL, wanted_errors[i]), text);
            fprintf(out, " %s |", text);
        }
        fputc('\n', out);
    }
}

/* Puts which passes take the time. The tracers have one, and nothing to tell. */
static void put_parts(FILE *out, const sl_bench_row *r) {
    const double least = 0.01;
    const cJSON *part;
    if (r->end != SL_CHILD_DONE || !r->look || sl_is_tracer(r->trial->method)) return;
    fprintf(out, "| %s | %s |", r->trial->curve, r->trial->name);
    cJSON_ArrayForEach(part, cJSON_GetObjectItem(r->look, "parts"))
        if (part->valuedouble >= least) fprintf(out, " %s %.0f %%;", part->string, 100.0 * part->valuedouble);
    fputs(" |\n", out);
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
    sl_missing_text(r, missing);
    if (r->missing_known) fprintf(out, " %.1f %% | %s |\n", 100.0 * r->energy, missing);
    else fputs(strcmp(r->transport, "full") == 0 ? " 100 % | |\n" : " | |\n", out);
}

void sl_report_scene(FILE *out, const void *what) {
    static const char columns[] =
        "curve, trial, cpu, wall, first, peak, matched, full, estimate, bound, arguments";
    const sl_bench_scene *s = what;
    fprintf(out, "\n## %s\n\n", s->name);
    if (s->trouble[0]) {
        fprintf(out, "Nothing was measured: %s\n", s->trouble);
        return;
    }
    fprintf(out, "`%s`, %d x %d, %llu triangles.\n\n", s->path, s->width, s->height,
            (unsigned long long)s->triangles);
    sl_report_columns(out, columns);
    sl_report_rows(out, s, -1, columns);
    fputc('\n', out);
    for (int t = 0; t < SL_BENCH_TRUTHS; t++) {
        const char *truth = sl_bench_truth_name((sl_bench_truth)t);
        if (sl_plot_is_there(&(sl_plot){s, (sl_bench_truth)t}))
            fprintf(out, "![%s, %s](%s-%s.svg)\n", s->name, truth, s->name, truth);
    }
    put_times(out, s);
    fputc('\n', out);
    sl_report_head(out, "curve|trial|passes that take the time");
    for (size_t i = 0; i < s->row_count; i++) put_parts(out, &s->rows[i]);
    fputc('\n', out);
    sl_report_head(out, "reference|>samples a pixel|>its noise|>smallest error told with it|>light in it|>"
                        "what it leaves out of full");
    for (size_t i = 0; i < s->reference_count; i++) put_reference(out, &s->references[i]);
}
