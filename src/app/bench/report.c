#include "app/bench/report.h"

#include "app/bench/plot.h"
#include "app/page.h"
#include "base/error.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- CSV ---- */

static void put_quoted(FILE *out, const char *text) {
    fputc('"', out);
    for (; *text; text++) fprintf(out, *text == '"' ? "\"%c" : "%c", *text);
    fputs("\",", out);
}

static void put_csv_row(FILE *out, const sl_bench_scene *s, const sl_bench_row *r) {
    static const sl_counter counters[] = {SL_COUNT_RAYS, SL_COUNT_SHADOW_RAYS, SL_COUNT_RECORDS,
                                          SL_COUNT_SAMPLES, SL_COUNT_FRAGMENTS_SHADED};
    static const char *const told[] = {"estimate", "bound", "estimate_seconds"};
    put_quoted(out, s->path);
    fprintf(out, "%s,%d,%d,", s->hash, s->width, s->height);
    put_quoted(out, r->trial->method);
    put_quoted(out, r->trial->curve);
    put_quoted(out, r->trial->name);
    fprintf(out, "%s,%s,", sl_bench_quality_name(r->trial->quality), r->trial->transport);
    put_quoted(out, r->trial->arguments);
    fprintf(out, "%s,", sl_bench_end_name(r->end));
    put_quoted(out, r->end == SL_CHILD_DONE ? "" : r->why);
    fprintf(out, "%d,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%.0f,%.0f", r->cpu.count, r->cpu.median,
            r->cpu.least, r->cpu.most, r->wall.median, r->wall.least, r->wall.most,
            sl_bench_number(r->look, "first_picture"), sl_bench_number(r->result, "peak_bytes"),
            sl_bench_number(r->result, "method_bytes"));
    for (size_t i = 0; i < sizeof counters / sizeof *counters; i++)
        fprintf(out, ",%.0f", sl_bench_counter(r, counters[i]));
    for (int t = 0; t < SL_BENCH_TRUTHS; t++) {
        const sl_bench_error *e = &r->error[t];
        if (!e->known) fputs(",,,,,,,,", out);
        else
            fprintf(out, ",%.6g,%s,%.6g,%.6g,%.6g,%.6g,%.6g,%llu", e->rel_rmse, e->lost ? "yes" : "no",
                    e->doubt, e->noise, e->rel_mse, e->bias, e->flip, (unsigned long long)e->nonfinite);
    }
    for (size_t i = 0; i < sizeof told / sizeof *told; i++) {
        fputc(',', out);
        if (sl_bench_promises(r)) fprintf(out, "%.6g", sl_bench_number(r->result, told[i]));
    }
    fputc('\n', out);
}

static void put_csv(FILE *out, const void *what) {
    const sl_bench_results *results = what;
    fputs("scene,hash,width,height,method,curve,setting,quality,transport,arguments,end,why,runs,"
          "cpu_seconds,cpu_least,cpu_most,wall_seconds,wall_least,wall_most,first_picture_cpu_seconds,"
          "peak_bytes,method_bytes,rays,shadow_rays,records,samples,fragments_shaded",
          out);
    for (int t = 0; t < SL_BENCH_TRUTHS; t++) {
        static const char *const names[] = {"rel_rmse", "is_bound", "doubt", "reference_noise",
                                            "rel_mse",  "bias",     "flip",  "nonfinite"};
        for (size_t i = 0; i < sizeof names / sizeof *names; i++)
            fprintf(out, ",%s_%s", sl_bench_truth_name((sl_bench_truth)t), names[i]);
    }
    fputs(",estimate_rel_rmse,estimate_bound,estimate_cpu_seconds\n", out);
    for (size_t s = 0; s < results->scene_count; s++) {
        for (size_t i = 0; i < results->scenes[s].row_count; i++)
            put_csv_row(out, &results->scenes[s], &results->scenes[s].rows[i]);
    }
}

/* ---- files ---- */

static void put_markdown(FILE *out, const void *what) {
    const sl_bench_results *results = what;
    sl_report_overview(out, results);
    for (size_t s = 0; s < results->scene_count; s++) sl_report_scene(out, &results->scenes[s]);
}

static sl_status write_plots(const sl_bench_scene *s, const char *folder, sl_error *error) {
    sl_status status = SL_OK;
    for (int i = 0; i < SL_PLOTS && status == SL_OK; i++) {
        const sl_plot plot = {s, i};
        char path[SL_BENCH_PATH];
        snprintf(path, sizeof path, "%.800s/%s-%s.svg", folder, s->name, sl_plot_name(i));
        if (sl_plot_is_there(&plot)) status = sl_print_file(path, sl_put_plot, &plot, error);
    }
    return status;
}

sl_status sl_report_write(const sl_bench_results *r, const char *folder, sl_error *error) {
    static const struct {
        const char *name;
        sl_printer *put;
    } files[] = {{"results.csv", put_csv}, {"report.md", put_markdown}, {"tables.md", sl_report_tables}};
    char path[SL_BENCH_PATH];
    sl_status status = SL_OK;
    for (size_t i = 0; i < sizeof files / sizeof *files && status == SL_OK; i++) {
        snprintf(path, sizeof path, "%.1000s/%s", folder, files[i].name);
        status = sl_print_file(path, files[i].put, r, error);
    }
    for (size_t i = 0; i < r->scene_count && status == SL_OK; i++)
        status = write_plots(&r->scenes[i], folder, error);
    snprintf(path, sizeof path, "%.1000s/report.html", folder);
    return status == SL_OK ? sl_report_page(r, path, error) : status;
}

/* ---- texts ---- */

void sl_report_head(FILE *out, const char *columns) {
    for (int line = 0; line < 2; line++) {
        for (const char *at = columns; at; at = strchr(at, '|') ? strchr(at, '|') + 1 : NULL) {
            bool right = *at == '>';
            if (line) fputs(right ? "| ---: " : "| --- ", out);
            else fprintf(out, "| %.*s ", (int)strcspn(at + right, "|"), at + right);
        }
        fputs("|\n", out);
    }
}

/* A doubt below this share of an error is not told. */
static const double silent_doubt = 0.1;

static int digits_of(double percent) {
    return percent >= 100.0 ? 0 : percent >= 9.95 ? 1 : percent >= 0.995 ? 2 : 3;
}

void sl_error_text(const sl_bench_error *e, char text[32]) {
    double percent = 100.0 * e->rel_rmse, doubt = 100.0 * e->doubt;
    if (!e->known) snprintf(text, 32, "-");
    else if (e->lost || !(e->doubt > silent_doubt * e->rel_rmse))
        snprintf(text, 32, "%s%.*f %%", e->lost ? "< " : "", digits_of(percent), percent);
    else snprintf(text, 32, "%.*f ± %.*f %%", digits_of(percent), percent, digits_of(percent), doubt);
}

/* No picture is nearer to another, by the root of the mean square, than their means are. */
void sl_missing_text(const sl_bench_reference *r, int digits, char text[32]) {
    const double slack = 0.98; /* of two figures that are noisy, too */
    int fewer = digits > 0 ? digits - 1 : 0;
    double least = fabs(1.0 - r->energy), step = pow(10.0, -fewer);
    bool lost = r->energy > 0.0 && r->missing < slack * least && 100.0 * least >= 0.5 * step;
    if (lost) snprintf(text, 32, "≥ %.*f %%", fewer, 100.0 * least);
    else snprintf(text, 32, "%.*f %%", digits, 100.0 * r->missing);
}

void sl_seconds_text(double seconds, char text[32]) {
    int digits = seconds >= 99.5 ? 0 : seconds >= 9.95 ? 1 : seconds >= 0.995 ? 2 : 3;
    text[0] = '\0';
    if (seconds > 0.0) snprintf(text, 32, "%.*f", digits, seconds);
}
