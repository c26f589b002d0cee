/* One page with everything in it: nothing is fetched from anywhere, so that it can be sent, kept and opened
 * by itself. */
#include "app/bench/curves.h"
#include "app/bench/plot.h"
#include "app/bench/report.h"
#include "app/html.h"

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
    "a{color:inherit}td:first-child,th:first-child,td.t,th.t{text-align:left}tr.q "
    "td{font-weight:600}.soft{color:var(--soft)}.wide{overflow-x:auto}svg{max-width:100%;height:auto}"
    ".grid{display:flex;flex-wrap:wrap;gap:14px}figure{margin:0;font-size:12px}figure "
    "img{display:block;width:192px;image-rendering:pixelated}"
    "code{font-size:12px}.noisy{border-left:4px solid #c24e00;padding-left:10px}"
    "@media(max-width:700px){.wide svg{max-width:none;width:640px}figure,figure img{width:42vw}}"
    "@media "
    "print{:root{--ink:#000;--paper:#fff;--soft:#444;--line:#bbb}body{max-width:none;margin:0}h2.scene{break-"
    "before:page}svg,figure,tr{break-inside:avoid}"
    ".wide{overflow:visible}.wide table{font-size:8px}.wide td,.wide th{padding:1px 3px}}";

static void put(FILE *out, const char *before, const char *text, const char *after) {
    fputs(before, out);
    sl_put_escaped(out, text);
    fputs(after, out);
}

static void put_seconds(FILE *out, double seconds) {
    char text[32] = "";
    if (seconds > 0.0) sl_seconds_text(seconds, text);
    fprintf(out, "<td>%s</td>", text);
}

static void put_spread(FILE *out, const sl_bench_spread *s) {
    char median[32], least[32], most[32];
    sl_seconds_text(s->median, median);
    sl_seconds_text(s->least, least);
    sl_seconds_text(s->most, most);
    if (s->count < 2) fprintf(out, "<td>%s</td>", s->count ? median : "");
    else fprintf(out, "<td>%s <span class=\"soft\">%s..%s</span></td>", median, least, most);
}

/* ---- what it says, first ---- */

static void put_lead(FILE *out, const sl_bench_scene *s, sl_bench_truth truth, const char *words,
                     double error) {
    sl_bench_lead lead = sl_bench_lead_at(s, truth, error);
    char seconds[32], path[32];
    fprintf(out, "<li>%g %% of %s: ", 100.0 * error, words);
    if (!lead.method) {
        fputs("none of the methods reaches it with the settings tried", out);
        if (lead.path_seconds > 0.0 && !lead.path_later)
            sl_seconds_text(lead.path_seconds, path), fprintf(out, "; the path tracer does in %s s", path);
    } else {
        sl_seconds_text(lead.seconds, seconds);
        put(out, "<b>", lead.method, "</b>");
        fprintf(out, " after %s s", seconds);
        if (lead.path_seconds > 0.0) {
            sl_seconds_text(lead.path_seconds, path);
            fprintf(out, ", the path tracer %s %s s: %s%.1f times", lead.path_later ? "not within" : "after",
                    path, lead.path_later ? "more than " : "", lead.path_seconds / lead.seconds);
        }
    }
    fputs(".</li>\n", out);
}

/* ---- tables ---- */

static void put_row(FILE *out, const sl_bench_row *r) {
    char text[64];
    fprintf(out, "<tr%s>", r->quality == SL_BENCH_CURVE ? "" : " class=\"q\"");
    put(out, "<td>", r->curve, "</td>");
    put(out, "<td class=\"t\" title=\"", r->arguments, "\">");
    put(out, "", r->name, "</td>");
    if (r->end != SL_BENCH_RAN) {
        fprintf(out, "<td class=\"t\" colspan=\"10\">%s: ", sl_bench_end_name(r->end));
        put(out, "", r->why, "</td></tr>\n");
        return;
    }
    put_spread(out, &r->cpu);
    put_spread(out, &r->wall);
    put_seconds(out, r->first_picture);
    fprintf(out, "<td>%.0f</td><td>%llu</td>", (double)r->peak_bytes / 1048576.0,
            (unsigned long long)(r->rays + r->shadow_rays));
    for (int t = 0; t < SL_BENCH_TRUTHS; t++) {
        sl_error_text(&r->error[t], text);
        put(out, "<td>", text, "</td>");
    }
    fprintf(out, "<td>%.3f</td>", r->error[SL_BENCH_FULL].flip);
    sl_promise_text(&r->promise, text);
    put(out, "<td>", text, "</td></tr>\n");
}

static void put_rows(FILE *out, const sl_bench_scene *s) {
    fputs("<h3>All settings</h3>\n<div class=\"wide\"><table><tr><th>method</th><th "
          "class=\"t\">setting</th><th>cpu s</th><th>wall s</th><th>first picture, cpu s</th>"
          "<th>peak MB</th><th>rays</th><th>matched</th><th>one bounce</th><th>full</th><th>FLIP of "
          "full</th><th>whole picture, told without a reference</th></tr>\n",
          out);
    for (size_t i = 0; i < s->row_count; i++) put_row(out, &s->rows[i]);
    fputs("</table></div>\n<p class=\"soft\">The three qualities are bold. Point at a setting for the "
          "arguments of <code>softlux render</code> that make its picture.</p>\n",
          out);
}

static void put_times(FILE *out, const sl_bench_scene *s, sl_bench_truth truth, const char *title) {
    static const double wanted[] = {0.2, 0.1, 0.05, 0.02, 0.01, 0.005};
    sl_curve curves[SL_CURVES];
    size_t count = sl_curves_of(s, truth, curves);
    if (!count) return;
    fprintf(out, "<div class=\"wide\"><table><tr><th>seconds until, against %s,</th>", title);
    for (size_t i = 0; i < sizeof wanted / sizeof *wanted; i++)
        fprintf(out, "<th>%g %%</th>", 100.0 * wanted[i]);
    fputs("</tr>\n", out);
    for (size_t k = 0; k < count; k++) {
        put(out, "<tr><td>", curves[k].name, "</td>");
        for (size_t i = 0; i < sizeof wanted / sizeof *wanted; i++)
            put_seconds(out, sl_curve_time_to(&curves[k], truth, wanted[i]));
        fputs("</tr>\n", out);
    }
    fputs("</table></div>\n", out);
}

/* ---- pictures ---- */

static void put_figure(FILE *out, const char *png, const char *title, const char *note) {
    fprintf(out, "<figure><img alt=\"");
    sl_put_escaped(out, title);
    fprintf(out, "\" src=\"data:image/png;base64,%s\"><figcaption>", png);
    sl_put_escaped(out, title);
    put(out, "<br><span class=\"soft\">", note, "</span></figcaption></figure>\n");
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
    fputs("<h3>What the methods cannot see</h3>\n<p>References by the path tracer: what each set of light "
          "paths holds of full global illumination. ≥: the error is lost in their noise, and is no less than "
          "the missing energy.</p>\n"
          "<div class=\"wide\"><table><tr><th>light paths</th><th>samples a pixel</th><th>cpu s</th><th>its "
          "noise</th><th class=\"t\">smallest error told with it</th><th>light in it</th><th>relative RMSE "
          "against full</th></tr>\n",
          out);
    for (size_t i = 0; i < s->reference_count; i++) {
        const sl_bench_reference *r = &s->references[i];
        put(out, "<tr><td>", r->transport, "</td>");
        if (!r->samples) {
            put(out, "<td class=\"t\" colspan=\"6\">none: ",
                r->trouble[0] ? r->trouble : "there was no time for it", "</td></tr>\n");
            continue;
        }
        char smallest[96], missing[32];
        sl_reference_text(r, smallest);
        sl_missing_text(r, 2, missing);
        fprintf(out, "<td>%llu</td><td>%.0f</td><td>%.3g %%</td>", (unsigned long long)r->samples, r->seconds,
                100.0 * r->noise);
        put(out, "<td class=\"t\">", smallest, "</td>");
        if (r->missing_known) fprintf(out, "<td>%.1f %%</td><td>%s</td></tr>\n", 100.0 * r->energy, missing);
        else fputs("<td></td><td></td></tr>\n", out);
    }
    fputs("</table></div>\n<div class=\"grid\">\n", out);
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

static void put_overview_cell(FILE *out, const sl_bench_scene *s, sl_bench_truth truth, double error) {
    sl_bench_lead lead = sl_bench_lead_at(s, truth, error);
    char seconds[32];
    if (!lead.method) {
        fputs("<td class=\"t\">none</td><td></td>", out);
        return;
    }
    sl_seconds_text(lead.seconds, seconds);
    put(out, "<td class=\"t\">", lead.method, "");
    fprintf(out, ", %s s</td>", seconds);
    if (lead.path_seconds > 0.0)
        fprintf(out, "<td>%s%.1f</td>", lead.path_later ? "&gt; " : "", lead.path_seconds / lead.seconds);
    else fputs("<td></td>", out);
}

/* A line a scene: which method is first, and how many times sooner than the path tracer. */
static void put_overview(FILE *out, const sl_bench_results *r) {
    fputs("<div class=\"wide\"><table><tr><th>scene</th><th class=\"t\">first at 5 % of one "
          "bounce</th><th>times as soon as paths</th><th class=\"t\">at 1 %</th><th>times</th>"
          "<th class=\"t\">at 5 % of all light</th><th>times</th></tr>\n",
          out);
    for (size_t i = 0; i < r->scene_count; i++) {
        const sl_bench_scene *s = &r->scenes[i];
        put(out, "<tr><td><a href=\"#", s->name, "\">");
        put(out, "", s->name, "</a></td>");
        if (s->trouble[0]) {
            fputs("<td class=\"t\" colspan=\"6\">nothing was measured</td></tr>\n", out);
            continue;
        }
        put_overview_cell(out, s, SL_BENCH_ONE_BOUNCE, 0.05);
        put_overview_cell(out, s, SL_BENCH_ONE_BOUNCE, 0.01);
        put_overview_cell(out, s, SL_BENCH_FULL, 0.05);
        fputs("</tr>\n", out);
    }
    fputs("</table></div>\n", out);
}

static void put_promises(FILE *out, const sl_bench_results *r) {
    fputs("<h2>Errors told without a reference</h2>\n<p>Against the method's own light paths: how often the "
          "measured error is within the bound that "
          "<code>softlux render --error</code> stops by, which is to hold in 95 %.</p>\n<div "
          "class=\"wide\"><table><tr><th>method</th><th>pictures judged</th><th>within the "
          "bound</th><th>bound over measured, median</th></tr>\n",
          out);
    for (size_t m = 0;; m++) {
        const char *name = sl_method_name(m);
        sl_bench_kept k = sl_bench_promises(r, name);
        if (k.made)
            fprintf(out, "<tr><td>%s</td><td>%d</td><td>%.0f %%</td><td>%.2f</td></tr>\n",
                    name ? name : "all", k.made, 100.0 * k.kept / k.made, k.slack);
        if (!name) break;
    }
    fputs("</table></div>\n", out);
}

static void put_scene(FILE *out, const sl_bench_scene *s) {
    put(out, "<h2 class=\"scene\" id=\"", s->name, "\">");
    put(out, "", s->name, "</h2>\n");
    if (s->trouble[0]) {
        put(out, "<p>Nothing was measured: ", s->trouble, "</p>\n");
        return;
    }
    put(out, "<p><code>", s->path, "</code>");
    fprintf(out, ", %d x %d, %llu triangles, %llu pixels compared.</p>\n<ul>\n", s->width, s->height,
            (unsigned long long)s->triangles, (unsigned long long)s->pixels_compared);
    put_lead(out, s, SL_BENCH_ONE_BOUNCE, "one bounce", 0.05);
    put_lead(out, s, SL_BENCH_ONE_BOUNCE, "one bounce", 0.01);
    put_lead(out, s, SL_BENCH_FULL, "full global illumination", 0.05);
    fputs("</ul>\n", out);
    for (int t = SL_BENCH_TRUTHS; t-- > 0;) {
        fputs("<div class=\"wide\">", out);
        sl_plot_curves(out, s, (sl_bench_truth)((t + 2) % SL_BENCH_TRUTHS));
        fputs("</div>\n", out);
    }
    put_times(out, s, SL_BENCH_ONE_BOUNCE, "one bounce");
    put_times(out, s, SL_BENCH_FULL, "full global illumination");
    put_differences(out, s);
    put_references(out, s);
    fputs("<h3>Where the time goes</h3>\n<p>A part ends where its pass announces itself: what was done for "
          "it beforehand is in it.</p>\n",
          out);
    fputs("<div class=\"wide\">", out);
    if (!sl_plot_parts(out, s)) fputs("<p>No trial was looked at.</p>", out);
    fputs("</div>\n", out);
    put_rows(out, s);
}

static void put_head(FILE *out, const sl_bench_results *r) {
    fprintf(out,
            "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
            "content=\"width=device-width\">\n"
            "<title>softlux: speed against error</title><style>%s</style></head><body>\n<h1>Speed against "
            "error</h1>\n<p>softlux %s, ",
            style, r->version);
    sl_put_escaped(out, r->machine);
    fprintf(out, ", %d thread%s; medians of up to %d runs.%s</p>\n", r->threads, r->threads == 1 ? "" : "s",
            r->repeats, r->interrupted ? " <b>Interrupted: this is what was measured until then.</b>" : "");
    fprintf(out,
            "<p%s>The machine was %s: the same arithmetic between the trials took %.1f ms by the clock, %.1f "
            "to %.1f, half the distance of the quartiles %.1f %% of that; "
            "by the processor's time %.1f %%; %.0f %% of the clock's time went to it.</p>\n",
            r->noisy ? " class=\"noisy\"" : "", r->noisy ? "<b>noisy</b>" : "quiet",
            1e3 * r->calibration.median, 1e3 * r->calibration.least, 1e3 * r->calibration.most,
            100.0 * r->unrest, 100.0 * r->unrest_cpu, 100.0 * r->share_of_processor);
    fputs("<p>Time is the processor's, of all threads together, until the picture is there; reading the "
          "scene is not in it. Errors are relative RMSE over the pixels that look at "
          "neither lamp nor sky, the reference's own noise subtracted. What that noise leaves in doubt is "
          "below a tenth of the error, with 95 % confidence, or stands behind it "
          "as ±; &lt; and a triangle: at most, and perhaps nothing. Large points are the three qualities, "
          "small ones other settings, hollow ones what another setting of the same method beats.</p>\n",
          out);
}

static void put_page(FILE *out, const sl_bench_results *results) {
    put_head(out, results);
    put_overview(out, results);
    for (size_t s = 0; s < results->scene_count; s++) put_scene(out, &results->scenes[s]);
    put_promises(out, results);
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
