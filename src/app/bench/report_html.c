/* One page with everything in it: the Markdown report as HTML, its plots, and pictures. Nothing is fetched
 * from anywhere, so that it can be sent, kept and opened by itself. */
#include "app/bench/plot.h"
#include "app/bench/report.h"
#include "app/html.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

static const char style[] =
    ":root{color-scheme:light dark;--ink:#222;--paper:#fff;--soft:#666;--line:#ddd}"
    "@media(prefers-color-scheme:dark){:root{--ink:#ddd;--paper:#15171a;--soft:#999;--line:#33373d}}"
    "body{font:15px/1.45 "
    "system-ui,sans-serif;color:var(--ink);background:var(--paper);max-width:1100px;margin:2em "
    "auto;padding:0 1em}"
    "table{border-collapse:collapse;font-size:13px;margin:1em 0}td,th{padding:2px 9px;border-bottom:1px "
    "solid var(--line);text-align:right;white-space:nowrap}"
    "a{color:inherit}td:first-child,th:first-child,td.t,th.t{text-align:left}.soft{color:var(--soft)}.wide{"
    "overflow-x:auto}svg{max-width:100%;height:auto}"
    ".grid{display:flex;flex-wrap:wrap;gap:14px}figure{margin:0;font-size:12px}figure "
    "img{display:block;width:192px;image-rendering:pixelated}"
    "code{font-size:12px}"
    "@media(max-width:700px){.wide svg{max-width:none;width:640px}figure,figure img{width:42vw}}"
    "@media "
    "print{:root{--ink:#000;--paper:#fff;--soft:#444;--line:#bbb}body{max-width:none;margin:0}h2{break-"
    "before:page}svg,figure,tr{break-inside:avoid}"
    ".wide{overflow:visible}.wide table{font-size:8px}.wide td,.wide th{padding:1px 3px}}";

/* ---- Markdown as HTML, as far as reports go ---- */

/* Ends or begins what a mark stands around. */
static void put_mark(FILE *out, const char *tag, bool *open) {
    fprintf(out, "<%s%s>", *open ? "/" : "", tag);
    *open = !*open;
}

/* `code`, **bold**, *emphasis*, [text](#place). */
static void put_words(FILE *out, const char *text, size_t length) {
    bool code = false, bold = false, emphasis = false;
    for (const char *at = text; at < text + length; at++) {
        const char *middle = *at == '[' ? strstr(at, "](#") : NULL,
                   *end = middle ? strchr(middle, ')') : NULL;
        if (*at == '`') put_mark(out, "code", &code);
        else if (!code && strncmp(at, "**", 2) == 0) put_mark(out, "b", &bold), at++;
        else if (!code && *at == '*') put_mark(out, "em", &emphasis);
        else if (end && end < text + length) {
            fputs("<a href=\"", out);
            sl_put_escaped_part(out, middle + 2, (size_t)(end - middle - 2));
            fputs("\">", out);
            sl_put_escaped_part(out, at + 1, (size_t)(middle - at - 1));
            fputs("</a>", out);
            at = end;
        } else sl_put_escaped_part(out, at, 1);
    }
}

/* | a | b |: words stand at the left, figures at the right. */
static void put_table_row(FILE *out, const char *line, size_t length, const char *tag) {
    fputs("<tr>", out);
    for (const char *at = line + 1, *end; (end = memchr(at, '|', length - (size_t)(at - line)));
         at = end + 1) {
        const char *word = at + strspn(at, " ");
        size_t count = (size_t)(end - word);
        while (count && word[count - 1] == ' ') count--;
        fprintf(out, "<%s%s>", tag, isalpha((unsigned char)*word) || *word == '`' ? " class=\"t\"" : "");
        put_words(out, word, count);
        fprintf(out, "</%s>", tag);
    }
    fputs("</tr>\n", out);
}

/* ![scene, full](scene-full.svg): the plot itself. */
static void put_plot(FILE *out, const char *line, const sl_bench_scene *scene) {
    const char *which = strstr(line, ", ") + 2;
    fputs("<div class=\"wide\">", out);
    if (strncmp(which, "parts", 5) == 0) sl_plot_parts(out, scene);
    for (int t = 0; t < SL_BENCH_TRUTHS; t++) {
        const char *name = sl_bench_truth_name((sl_bench_truth)t);
        if (strncmp(which, name, strlen(name)) == 0) sl_plot_curves(out, scene, (sl_bench_truth)t);
    }
    fputs("</div>\n", out);
}

static void put_text_line(FILE *out, const char *line, size_t length) {
    size_t level = strspn(line, "#");
    const char *words = line + level + (level > 0);
    size_t count = length - (size_t)(words - line);
    if (level) {
        fprintf(out, "<h%zu id=\"", level);
        sl_put_escaped_part(out, words, count);
        fputs("\">", out);
    } else fputs("<p>", out);
    put_words(out, words, count);
    if (level) fprintf(out, "</h%zu>\n", level);
    else fputs("</p>\n", out);
}

static void put_markdown(FILE *out, const char *text, const sl_bench_scene *scene) {
    bool table = false;
    for (const char *line = text; *line;) {
        size_t length = strcspn(line, "\n");
        bool row = *line == '|';
        if (row && !table) fputs("<div class=\"wide\"><table>\n", out);
        if (!row && table) fputs("</table></div>\n", out);
        if (row && strncmp(line, "| ---", 5) != 0) put_table_row(out, line, length, table ? "td" : "th");
        else if (!row && *line == '!') put_plot(out, line, scene);
        else if (!row && length) put_text_line(out, line, length);
        table = row;
        line += length + (line[length] == '\n');
    }
    if (table) fputs("</table></div>\n", out);
}

/* ---- pictures ---- */

static void put_figure(FILE *out, const char *png, const char *title, const char *note) {
    fprintf(out, "<figure><img alt=\"");
    sl_put_escaped(out, title);
    fprintf(out, "\" src=\"data:image/png;base64,%s\"><figcaption>", png);
    sl_put_escaped(out, title);
    fputs("<br><span class=\"soft\">", out);
    sl_put_escaped(out, note);
    fputs("</span></figcaption></figure>\n", out);
}

static void put_differences(FILE *out, const sl_bench_scene *s) {
    fputs("<h3>Where the error sits</h3>\n<p>Each picture against its own light paths: blue is too dark, red "
          "too bright, full colour at 50 %; grey is not compared.</p>\n"
          "<div class=\"grid\">\n",
          out);
    for (size_t i = 0; i < s->row_count; i++) {
        const sl_bench_row *r = &s->rows[i];
        char title[2 * SL_BENCH_NAME + 8], note[64], error[32];
        if (!r->difference) continue;
        snprintf(title, sizeof title, "%s, %s", r->curve, sl_bench_quality_name(r->quality));
        sl_error_text(&r->error[SL_BENCH_MATCHED], error);
        snprintf(note, sizeof note, "%s, bias %+.2f %%", error, 100.0 * r->error[SL_BENCH_MATCHED].bias);
        put_figure(out, r->difference, title, note);
    }
    fputs("</div>\n", out);
}

static void put_references(FILE *out, const sl_bench_scene *s) {
    fputs("<h3>What the methods cannot see</h3>\n<div class=\"grid\">\n", out);
    if (s->picture) put_figure(out, s->picture, "full global illumination", "the reference");
    for (size_t i = 0; i < s->reference_count; i++) {
        const sl_bench_reference *r = &s->references[i];
        char note[64];
        if (!r->difference) continue;
        snprintf(note, sizeof note, "%.1f %% of the light", 100.0 * r->energy);
        put_figure(out, r->difference, r->transport, note);
    }
    fputs("</div>\n", out);
}

/* ---- the page ---- */

/* Puts the overview, or one scene of the report. */
static void put_part(FILE *out, const sl_bench_results *r, const sl_bench_scene *scene) {
    char *text = NULL;
    size_t size;
    FILE *markdown = open_memstream(&text, &size);
    if (!markdown) return;
    if (scene) sl_report_scene(markdown, scene);
    else sl_report_overview(markdown, r);
    if (fclose(markdown) == 0) put_markdown(out, text, scene);
    free(text);
    if (!scene || scene->trouble[0]) return;
    put_differences(out, scene);
    put_references(out, scene);
}

static void put_page(FILE *out, const sl_bench_results *results) {
    fprintf(out,
            "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
            "content=\"width=device-width\">\n<title>softlux: speed against error</title><style>%s</style>"
            "</head><body>\n",
            style);
    put_part(out, results, NULL);
    for (size_t s = 0; s < results->scene_count; s++) put_part(out, results, &results->scenes[s]);
    fputs("</body></html>\n", out);
}

sl_status sl_report_html(const sl_bench_results *results, const char *folder, sl_error *error) {
    return sl_report_compose(results, folder, "report.html", put_page, error);
}

/* ---- the same plots as files ---- */

static sl_status write_plot(const sl_bench_scene *s, int which, const char *folder, sl_error *error) {
    char name[SL_BENCH_NAME + 32], *text = NULL;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    bool parts = which == SL_BENCH_TRUTHS;
    bool drawn = out && (parts ? sl_plot_parts(out, s) : sl_plot_curves(out, s, (sl_bench_truth)which));
    if (out) fclose(out);
    snprintf(name, sizeof name, "%s-%s.svg", s->name,
             parts ? "parts" : sl_bench_truth_name((sl_bench_truth)which));
    sl_status status = drawn ? sl_report_write(folder, name, text, error) : SL_OK;
    free(text);
    return status;
}

sl_status sl_report_plots(const sl_bench_results *results, const char *folder, sl_error *error) {
    sl_status status = SL_OK;
    for (size_t s = 0; s < results->scene_count; s++) {
        for (int which = 0; which <= SL_BENCH_TRUTHS && status == SL_OK; which++)
            status = write_plot(&results->scenes[s], which, folder, error);
    }
    return status;
}
