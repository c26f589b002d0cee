#include "app/bench/report.h"

#include "app/page.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- CSV ---- */

static const char csv_columns[] =
    "file, hash, width, height, method, curve, trial, quality, transport, arguments, end, why, runs, cpu, "
    "cpu.least, cpu.most, wall, wall.least, wall.most, first, peak, memory, counter.rays, "
    "counter.shadow_rays, counter.records, counter.samples, counter.fragments_shaded, matched, matched.lost, "
    "matched.doubt, matched.noise, matched.mse, matched.bias, matched.flip, matched.nonfinite, one-bounce, "
    "one-bounce.lost, one-bounce.doubt, full, full.lost, full.doubt, full.noise, full.mse, full.bias, "
    "full.flip, estimate, bound";

static void put_quoted(FILE *out, const char *text) {
    fputc('"', out);
    for (; *text; text++) fprintf(out, *text == '"' ? "\"%c" : "%c", *text);
    fputc('"', out);
}

/* Puts the columns' names where there is no row. */
static void put_csv_row(FILE *out, const sl_bench_scene *s, const sl_bench_row *r) {
    const char *at = csv_columns;
    char column[SL_CELL], cell[SL_CELL];
    for (bool first = true; sl_next_column(&at, column); first = false) {
        if (r) sl_cell(s, r, column, true, cell);
        if (!first) fputc(',', out);
        put_quoted(out, r ? cell : column);
    }
    fputc('\n', out);
}

static void put_csv(FILE *out, const void *what) {
    const sl_bench_results *results = what;
    put_csv_row(out, NULL, NULL);
    for (size_t s = 0; s < results->scene_count; s++) {
        for (size_t i = 0; i < results->scenes[s].row_count; i++)
            put_csv_row(out, &results->scenes[s], &results->scenes[s].rows[i]);
    }
}

/* ---- report.html: the Markdown, its plots, and pictures, of which a script makes the page ---- */

/* page.css and page.js, as the linker has put them in. */
extern const char _binary_src_app_bench_page_css_start[], _binary_src_app_bench_page_css_end[];
extern const char _binary_src_app_bench_page_js_start[], _binary_src_app_bench_page_js_end[];

static void add_printed(cJSON *to, const char *name, sl_printer *print, const void *what) {
    char *text = sl_printed(print, what);
    if (text) cJSON_AddStringToObject(to, name, text);
    free(text);
}

static void add_figure(cJSON *to, const char *picture, const char *title, const char *note) {
    cJSON *figure = cJSON_CreateObject();
    cJSON_AddStringToObject(figure, "picture", picture);
    cJSON_AddStringToObject(figure, "title", title);
    cJSON_AddStringToObject(figure, "note", note);
    cJSON_AddItemToArray(to, figure);
}

static void add_differences(cJSON *to, const sl_bench_scene *s) {
    for (size_t i = 0; i < s->row_count; i++) {
        const sl_bench_row *r = &s->rows[i];
        char title[2 * SL_BENCH_NAME + 8], note[64], error[32];
        if (!r->difference) continue;
        snprintf(title, sizeof title, "%s, %s", r->trial->curve, r->trial->quality);
        sl_error_text(&r->error[SL_BENCH_MATCHED], error);
        snprintf(note, sizeof note, "%s, bias %+.2f %%", error, 100.0 * r->error[SL_BENCH_MATCHED].bias);
        add_figure(to, r->difference, title, note);
    }
}

static void add_references(cJSON *to, const sl_bench_scene *s) {
    if (s->picture) add_figure(to, s->picture, "full global illumination", "the reference");
    for (size_t i = 0; i < s->reference_count; i++) {
        char note[64];
        snprintf(note, sizeof note, "%.1f %% of the light", 100.0 * s->references[i].energy);
        if (s->references[i].difference)
            add_figure(to, s->references[i].difference, s->references[i].transport, note);
    }
}

static cJSON *scene_json(const sl_bench_scene *s) {
    cJSON *json = cJSON_CreateObject(), *plots = cJSON_AddObjectToObject(json, "plots");
    add_printed(json, "text", sl_report_scene, s);
    for (int t = 0; t < SL_BENCH_TRUTHS; t++) {
        const sl_plot plot = {s, (sl_bench_truth)t};
        if (sl_plot_is_there(&plot))
            add_printed(plots, sl_bench_truth_name(plot.truth), sl_put_plot, &plot);
    }
    add_differences(cJSON_AddArrayToObject(json, "differences"), s);
    add_references(cJSON_AddArrayToObject(json, "references"), s);
    return json;
}

static sl_status write_page(const sl_bench_results *r, const char *path, sl_error *error) {
    const sl_page_files files = {
        .css = _binary_src_app_bench_page_css_start, .css_end = _binary_src_app_bench_page_css_end,
        .js = _binary_src_app_bench_page_js_start, .js_end = _binary_src_app_bench_page_js_end};
    cJSON *data = cJSON_CreateObject(), *scenes = cJSON_AddArrayToObject(data, "scenes");
    add_printed(data, "overview", sl_report_overview, r);
    for (size_t s = 0; s < r->scene_count; s++) cJSON_AddItemToArray(scenes, scene_json(&r->scenes[s]));
    sl_status status = sl_page_write(path, "softlux: speed against error", "", &files, data, error);
    cJSON_Delete(data);
    return status;
}

/* ---- files ---- */

static void put_markdown(FILE *out, const void *what) {
    const sl_bench_results *results = what;
    sl_report_overview(out, results);
    for (size_t s = 0; s < results->scene_count; s++) sl_report_scene(out, &results->scenes[s]);
}

static sl_status write_plots(const sl_bench_scene *s, const char *folder, sl_error *error) {
    sl_status status = SL_OK;
    for (int t = 0; t < SL_BENCH_TRUTHS && status == SL_OK; t++) {
        const sl_plot plot = {s, (sl_bench_truth)t};
        char path[SL_BENCH_PATH];
        snprintf(path, sizeof path, "%.800s/%s-%s.svg", folder, s->name, sl_bench_truth_name(plot.truth));
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
    return status == SL_OK ? write_page(r, path, error) : status;
}

/* ---- texts ---- */

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
void sl_missing_text(const sl_bench_reference *r, char text[32]) {
    const double slack = 0.98; /* of two figures that are noisy, too */
    double least = fabs(1.0 - r->energy);
    bool lost = r->energy > 0.0 && r->missing < slack * least && least >= 0.005;
    if (lost) snprintf(text, 32, "≥ %.0f %%", 100.0 * least);
    else snprintf(text, 32, "%.1f %%", 100.0 * r->missing);
}

void sl_seconds_text(double seconds, char text[32]) {
    int digits = seconds >= 99.5 ? 0 : seconds >= 9.95 ? 1 : seconds >= 0.995 ? 2 : 3;
    text[0] = '\0';
    if (seconds > 0.0) snprintf(text, 32, "%.*f", digits, seconds);
}
