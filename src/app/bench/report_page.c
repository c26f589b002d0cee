/* report.html: the Markdown, its plots, and pictures, of which a script makes the page. */
#include "app/bench/plot.h"
#include "app/bench/report.h"
#include "app/page.h"
#include "base/error.h"

#include <stdlib.h>
#include <string.h>

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
        snprintf(title, sizeof title, "%s, %s", r->trial->curve, sl_bench_quality_name(r->trial->quality));
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

sl_status sl_report_page(const sl_bench_results *r, const char *path, sl_error *error) {
    const sl_page_files files = {
        _binary_src_app_bench_page_css_start, _binary_src_app_bench_page_css_end,
        _binary_src_app_bench_page_js_start, _binary_src_app_bench_page_js_end};
    cJSON *data = cJSON_CreateObject(), *scenes = cJSON_AddArrayToObject(data, "scenes");
    add_printed(data, "overview", sl_report_overview, r);
    for (size_t s = 0; s < r->scene_count; s++) cJSON_AddItemToArray(scenes, scene_json(&r->scenes[s]));
    sl_status status = sl_page_write(path, "softlux: speed against error", "", &files, data, error);
    cJSON_Delete(data);
    return status;
}
