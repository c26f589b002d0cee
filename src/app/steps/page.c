#include "app/steps/page.h"

#include "app/html.h"
#include "base/error.h"
#include "image/output_file.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* page.css and page.js, as the linker has put them in. */
extern const char _binary_src_app_steps_page_css_start[], _binary_src_app_steps_page_css_end[];
extern const char _binary_src_app_steps_page_js_start[], _binary_src_app_steps_page_js_end[];

static void put_file(FILE *out, const char *begin, const char *end) {
    fwrite(begin, 1, (size_t)(end - begin), out);
}

static void percent_text(double rel_rmse, char text[32]) {
    if (rel_rmse < 0.0) snprintf(text, 32, "-");
    else snprintf(text, 32, "%.3g %%", 100.0 * rel_rmse);
}

/* ---- one pass ---- */

/* "4,096 fragments shaded": what a pass has cost, without what stayed 0. */
static void put_counters(FILE *out, const sl_counters *cost, const char *class) {
    bool any = false;
    for (int i = 0; i < SL_COUNTERS; i++) {
        if (!cost->value[i]) continue;
        fprintf(out, "%s", any ? "" : "<table class=\"");
        if (!any) fprintf(out, "%s\"><caption>what it cost</caption>", class);
        any = true;
        char name[64];
        snprintf(name, sizeof name, "%s", sl_counter_name((sl_counter)i));
        for (char *c = name; *c; c++) *c = *c == '_' ? ' ' : *c;
        fprintf(out, "<tr><th scope=\"row\">%s</th><td>%" PRIu64 "</td></tr>", name, cost->value[i]);
    }
    if (any) fputs("</table>\n", out);
}

static const char *last_picture(const sl_step *s, size_t snapshots) {
    for (size_t i = snapshots; i-- > 0;)
        if (s->frames[i].picture) return s->frames[i].picture;
    return NULL;
}

static bool has_marks(const sl_step *s, size_t snapshots) {
    for (size_t i = 0; i < snapshots; i++)
        if (s->frames[i].marks) return true;
    return false;
}

static const char *title_of(const sl_step *s) { return s->told ? s->told->title : s->name; }

static void put_figure(FILE *out, const sl_steps_run *run, const sl_step *s, size_t number) {
    const char *picture = last_picture(s, run->snapshot_count);
    bool marks = has_marks(s, run->snapshot_count);
    if (!picture && !marks) return;
    fprintf(out, "<figure class=\"pass%s\" data-step=\"%zu\"><div class=\"frame\">",
            s->height > 2 * s->width ? " tall" : "", number);
    const char *under = picture ? picture : run->snapshots[run->snapshot_count - 1].picture;
    fputs("<img alt=\"", out);
    sl_put_escaped(out, title_of(s));
    fprintf(out, "%s\" width=\"%d\" height=\"%d\" src=\"data:image/png;base64,%s\">",
            picture ? "" : ", drawn over the picture", picture ? s->width : run->width,
            picture ? s->height : run->height, under);
    if (marks)
        fprintf(out, "<svg class=\"marks\" viewBox=\"0 0 %d %d\" aria-hidden=\"true\"></svg>", run->width,
                run->height);
    fputs("</div><figcaption>", out);
    if (s->width) fprintf(out, "%d &times; %d", s->width, s->height);
    fputs("</figcaption></figure>\n", out);
}

static void put_worth(FILE *out, const sl_steps_run *run, const sl_step *s) {
    if (!s->told || !s->told->layer) return;
    for (size_t i = 0; i < run->layer_count; i++) {
        if (strcmp(run->layers[i].layer, s->told->layer) != 0 || run->layers[i].rel_rmse < 0.0) continue;
        char without[32], with[32];
        percent_text(run->layers[i].rel_rmse, without);
        percent_text(run->snapshots[run->snapshot_count - 1].rel_rmse, with);
        fprintf(out,
                "<p class=\"worth\">Without what this pass adds the picture would be off by %s; with it, it "
                "is off by %s.</p>\n",
                without, with);
    }
}

static void put_step(FILE *out, const sl_steps_run *run, const sl_step *s, size_t number) {
    fprintf(out, "<section class=\"step\"><h3>%zu. ", number + 1);
    sl_put_escaped(out, title_of(s));
    fputs("</h3>\n<p class=\"source\">", out);
    sl_put_escaped(out, s->source);
    fprintf(out, " &middot; pass <q>");
    sl_put_escaped(out, s->name);
    fprintf(out, "</q>, %" PRIu64 " %s</p>\n", s->times, s->times == 1 ? "time" : "times");
    put_figure(out, run, s, number);
    if (s->told) {
        fprintf(out, "<p>%s</p>\n", s->told->text);
        if (s->told->equation) fprintf(out, "<math display=\"block\">%s</math>\n", s->told->equation);
        fputs("<p class=\"code\"><code>", out);
        sl_put_escaped(out, s->told->code);
        fputs("</code></p>\n", out);
    }
    put_worth(out, run, s);
    put_counters(out, &s->cost, "cost");
    fputs("</section>\n", out);
}

/* ---- one method ---- */

/* Error over batches, both logarithmic. */
static void put_errors(FILE *out, const sl_steps_run *run) {
    enum { WIDTH = 400, HEIGHT = 120, LEFT = 46, BOTTOM = 18 };
    double least = INFINITY, greatest = 0.0;
    for (size_t i = 0; i < run->snapshot_count; i++) {
        double e = run->snapshots[i].rel_rmse;
        if (!(e > 0.0) || !isfinite(e)) return;
        least = fmin(least, e), greatest = fmax(greatest, e);
    }
    if (run->snapshot_count < 3) return;
    least = log(least / 1.2), greatest = log(greatest * 1.2);
    double last = log((double)run->snapshots[run->snapshot_count - 1].batches + 1.0);
    fprintf(out,
            "<svg class=\"errors\" viewBox=\"0 0 %d %d\" role=\"img\" aria-label=\"error over batches\"><g "
            "font-size=\"10\" fill=\"currentColor\">"
            "<text x=\"0\" y=\"10\">%.3g %%</text><text x=\"0\" y=\"%d\">%.3g %%</text><text x=\"%d\" "
            "y=\"%d\" text-anchor=\"end\">batches</text></g>"
            "<polyline fill=\"none\" stroke=\"var(--accent)\" stroke-width=\"1.5\" points=\"",
            WIDTH, HEIGHT, 100.0 * exp(greatest), HEIGHT - BOTTOM, 100.0 * exp(least), WIDTH, HEIGHT - 4);
    for (size_t i = 0; i < run->snapshot_count; i++) {
        const sl_snapshot *s = &run->snapshots[i];
        fprintf(out, "%.1f,%.1f ", LEFT + (WIDTH - LEFT) * log((double)s->batches + 1.0) / last,
                (HEIGHT - BOTTOM) * (greatest - log(s->rel_rmse)) / (greatest - least));
    }
    fputs("\"/></svg>\n", out);
}

static void put_player(FILE *out, const sl_steps_run *run, size_t article) {
    size_t last = run->snapshot_count - 1;
    fprintf(out,
            "<div class=\"stage\"><div class=\"picture frame\" tabindex=\"0\" role=\"application\" "
            "aria-label=\"The picture: arrow keys move to a pixel, whose explanation stands below\">"
            "<img alt=\"the picture\" width=\"%d\" height=\"%d\" src=\"data:image/png;base64,%s\">"
            "<svg class=\"marks\" viewBox=\"0 0 %d %d\" aria-hidden=\"true\"></svg></div>\n",
            run->width, run->height, run->snapshots[last].picture, run->width, run->height);
    fprintf(out,
            "<p class=\"slider\"><label for=\"slider%zu\">refinement</label> <input type=\"range\" "
            "id=\"slider%zu\" min=\"0\" max=\"%zu\" value=\"%zu\"> "
            "<output for=\"slider%zu\"></output></p></div>\n",
            article, article, last, last, article);
    put_errors(out, run);
    fputs("<div class=\"explanation\" aria-live=\"polite\"><h3>The explanation of a pixel</h3><p "
          "class=\"hint\">Click on the picture, or move with the arrow keys on it.</p></div>\n",
          out);
}

static void put_reference(FILE *out, const sl_steps_run *run) {
    if (!run->reference) return;
    char noise[32], error[32];
    percent_text(run->reference_noise, noise);
    percent_text(run->snapshots[run->snapshot_count - 1].rel_rmse, error);
    fprintf(out,
            "<section class=\"reference\"><h3>How far it is from the truth</h3><p>The same light paths, path "
            "traced with %" PRIu32
            " samples a pixel (their own noise: %s). Without that noise the picture is off by %s, relative "
            "RMSE. Blue is too dark, red too bright, full colour at 50 %%.</p>\n",
            run->reference_samples, noise, error);
    const struct {
        const char *name, *data;
    } pictures[] = {{"the reference", run->reference}, {"the difference", run->difference}};
    for (size_t i = 0; i < 2; i++) {
        if (!pictures[i].data) continue;
        fprintf(out,
                "<figure><div class=\"frame\"><img alt=\"%s\" width=\"%d\" height=\"%d\" "
                "src=\"data:image/png;base64,%s\"></div><figcaption>%s</figcaption></figure>\n",
                pictures[i].name, run->width, run->height, pictures[i].data, pictures[i].name);
    }
    fputs("</section>\n", out);
}

static void put_plan(FILE *out, const sl_steps_run *run) {
    fputs("<details><summary>The plan: what this scene needs, and what it does not</summary><pre>", out);
    for (const char *line = run->plan; line && *line;) { /* escaping takes a newline for a blank */
        size_t length = strcspn(line, "\n");
        char text[512];
        snprintf(text, sizeof text, "%.*s", (int)length, line);
        sl_put_escaped(out, text);
        fputc('\n', out);
        line += length + (line[length] == '\n');
    }
    fputs("</pre></details>\n", out);
}

static void put_article(FILE *out, const sl_steps_run *run, size_t article) {
    fprintf(out, "<article data-article=\"%zu\"><h2>%s</h2>\n<p class=\"paper\">%s</p>\n<p>%s</p>\n", article,
            run->narrative->method, run->narrative->paper, run->narrative->introduction);
    put_player(out, run, article);
    for (size_t i = 0; i < run->recording.count; i++) put_step(out, run, &run->recording.steps[i], i);
    put_reference(out, run);
    put_plan(out, run);
    fputs("</article>\n", out);
}

/* ---- what the script reads ---- */

static void put_json_text(FILE *out, const char *text) {
    fputc('"', out);
    for (; *text; text++) {
        if (*text == '"' || *text == '\\') fputc('\\', out);
        if (*text == '<') fputs("\\u003c", out); /* no tag may begin within the script element */
        else fputc((unsigned char)*text < 32 ? ' ' : *text, out);
    }
    fputc('"', out);
}

static void put_frames(FILE *out, const sl_steps_run *run, const sl_step *s) {
    fputc('[', out);
    for (size_t i = 0; i < run->snapshot_count; i++) {
        fprintf(out, "%s[", i ? "," : "");
        if (s->frames[i].picture) put_json_text(out, s->frames[i].picture);
        else fputs("null", out);
        fputc(',', out);
        if (s->frames[i].marks) put_json_text(out, s->frames[i].marks);
        else fputs("null", out);
        fputc(']', out);
    }
    fputc(']', out);
}

static void put_data(FILE *out, const sl_steps_run *run) {
    fprintf(out, "{\"width\":%d,\"height\":%d,\"snapshots\":[", run->width, run->height);
    for (size_t i = 0; i < run->snapshot_count; i++) {
        const sl_snapshot *s = &run->snapshots[i];
        fprintf(out, "%s{\"batches\":%" PRIu64 ",\"error\":%.6g,\"picture\":\"%s\"}", i ? "," : "",
                s->batches, isfinite(s->rel_rmse) ? s->rel_rmse : -1.0, s->picture);
    }
    fputs("],\n\"steps\":[", out);
    for (size_t i = 0; i < run->recording.count; i++) {
        if (i) fputc(',', out);
        put_frames(out, run, &run->recording.steps[i]);
    }
    fputs("],\n\"explanations\":", out);
    sl_explanations_put(run->explanations, &run->recording.view, out);
    fputs("}", out);
}

static void put_page(FILE *out, const char *scene, const sl_steps_run *runs, size_t count) {
    fputs("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
          "content=\"width=device-width, initial-scale=1\">\n"
          "<meta name=\"color-scheme\" content=\"light dark\">\n<link rel=\"icon\" href=\"data:,\">\n<title>",
          out);
    for (size_t i = 0; i < count; i++) fprintf(out, "%s%s", i ? " beside " : "", runs[i].narrative->method);
    fputs(", step by step: ", out);
    sl_put_escaped(out, scene);
    fputs("</title>\n<style>\n", out);
    put_file(out, _binary_src_app_steps_page_css_start, _binary_src_app_steps_page_css_end);
    fputs("</style>\n</head>\n<body>\n<header><h1>", out);
    sl_put_escaped(out, scene);
    fputs(", step by step</h1></header>\n<main", out);
    fprintf(out, "%s>\n", count > 1 ? " class=\"beside\"" : "");
    for (size_t i = 0; i < count; i++) put_article(out, &runs[i], i);
    fputs("</main>\n<script type=\"application/json\" id=\"data\">[", out);
    for (size_t i = 0; i < count; i++) {
        if (i) fputs(",\n", out);
        put_data(out, &runs[i]);
    }
    fputs("]</script>\n<script>\n", out);
    put_file(out, _binary_src_app_steps_page_js_start, _binary_src_app_steps_page_js_end);
    fputs("</script>\n</body>\n</html>\n", out);
}

sl_status sl_page_write(const char *folder, const char *scene, const sl_steps_run *runs, size_t count,
                        sl_error *error) {
    char path[4096], *text = NULL;
    size_t size = 0;
    snprintf(path, sizeof path, "%s/index.html", folder);
    FILE *out = open_memstream(&text, &size);
    if (out) put_page(out, scene, runs, count);
    bool failed = !out || ferror(out);
    if (out && fclose(out) != 0) failed = true;
    sl_status status = SL_OK;
    if (failed) {
        status = sl_fail(error, SL_ERROR_RESOURCES, "not enough memory for the page");
    }
    sl_output_file file;
    if (status == SL_OK) status = sl_output_open(&file, path, error);
    if (status == SL_OK) {
        status = sl_output_write(&file, text, size, error);
        if (status == SL_OK) status = sl_output_commit(&file, error);
        else sl_output_discard(&file);
    }
    free(text);
    return status;
}
