/* Where the time goes: a bar for each quality of each method, as long as a whole, cut at its passes. And what
 * all plots share. */
#include "app/bench/plot.h"

#include "app/page.h"

#include <math.h>
#include <string.h>

/* ---- every plot ---- */

const char *sl_plot_name(int plot) {
    return plot == SL_PLOT_PARTS ? "parts" : sl_bench_truth_name((sl_bench_truth)plot);
}

static void put_colours(FILE *out, const sl_plot_colours *c, const char *const *values) {
    for (int i = 0; i < c->count; i++) {
        for (const char *at = c->rule; *at; at++) {
            bool number = strncmp(at, "%1$d", 4) == 0, colour = strncmp(at, "%2$s", 4) == 0;
            if (number) fprintf(out, "%d", i);
            else if (colour) fputs(values[i], out);
            else fputc(*at, out);
            if (number || colour) at += 3;
        }
    }
}

void sl_plot_begin(FILE *out, const char *style, const sl_plot_colours *colours, int width, int height,
                   const char *scene, const char *title) {
    fprintf(out,
            "<svg class=\"plot\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %d %d\" width=\"%d\" "
            "height=\"%d\" role=\"img\">\n<style>.plot text{font:12px system-ui,sans-serif;fill:#222}.plot "
            ".paper{fill:#fff}.plot .grid{stroke:#ddd}.plot .title{font-weight:600;font-size:14px}%s",
            width, height, width, height, style);
    put_colours(out, colours, colours->light);
    fputs("@media(prefers-color-scheme:dark){.plot text{fill:#ddd}.plot .paper{fill:#15171a}.plot "
          ".grid{stroke:#33373d}",
          out);
    put_colours(out, colours, colours->dark);
    fprintf(out,
            "}</style>\n<rect class=\"paper\" width=\"%d\" height=\"%d\"/>\n<text class=\"title\" x=\"8\" "
            "y=\"20\">",
            width, height);
    sl_put_escaped(out, scene);
    fprintf(out, "%s</text>\n", title);
}

/* ---- parts ---- */

enum { BAR_LEFT = 190, BAR_WIDTH = 640, BAR_HEIGHT = 20, BAR_STEP = 26, HEAD = 34 };
/* of a picture's time: what takes less has no part of its own */
static const double least_share = 0.004;

static const char *const light[] = {"#a9cdea", "#f3c9a8", "#aedcc9", "#e3bfd9", "#e6d79b", "#ccc"};
static const char *const dark[] = {"#2c5d85", "#8a5226", "#2b6b54", "#7a4468", "#6b5b1c", "#555"};
static const sl_plot_colours colours = {".plot .p%1$d{fill:%2$s}", 6, light, dark};

/* Leaves out the tracers, which have one pass, and nothing to show. */
static bool is_shown(const sl_bench_row *r) {
    return r->end == SL_BENCH_RAN && r->look && !sl_bench_is_tracer(r->trial);
}

static int bars_of(const sl_bench_scene *s) {
    int bars = 0;
    for (size_t i = 0; i < s->row_count; i++) bars += is_shown(&s->rows[i]);
    return bars;
}

/* Draws a part, and its name, or as much of it as there is room for: a letter takes some six pixels. Returns
 * where the next one begins. */
static double put_part(FILE *out, const char *name, double share, int number, double x, int y) {
    double width = BAR_WIDTH * share;
    int room = (int)((width - 8.0) / 6.3), length = (int)strlen(name);
    if (!(width > 0.0)) return x;
    fprintf(out, "<rect class=\"p%d\" x=\"%.1f\" y=\"%d\" width=\"%.1f\" height=\"%d\"><title>", number % 6,
            x, y, fmax(width - 1.0, 0.3), BAR_HEIGHT);
    sl_put_escaped(out, name);
    fprintf(out, ": %.1f %%</title></rect>", 100.0 * share);
    if (room >= 4) {
        fprintf(out, "<text class=\"in\" x=\"%.1f\" y=\"%d\">", x + 4.0, y + 14);
        sl_put_escaped_part(out, name, (size_t)(length <= room ? length : room - 1));
        fputs(length <= room ? "</text>" : ".</text>", out);
    }
    return x + width;
}

static void put_bar(FILE *out, const sl_bench_row *row, int y) {
    double x = BAR_LEFT, others = 0.0;
    int number = 0;
    const cJSON *part;
    fprintf(out, "<text x=\"%d\" y=\"%d\" text-anchor=\"end\">", BAR_LEFT - 8, y + 14);
    sl_put_escaped(out, row->trial->curve);
    fprintf(out, ", %s</text>", sl_bench_quality_name(row->trial->quality));
    cJSON_ArrayForEach(part, cJSON_GetObjectItem(row->look, "parts")) {
        if (part->valuedouble < least_share) others += part->valuedouble;
        else x = put_part(out, part->string, part->valuedouble, number++, x, y);
    }
    put_part(out, "others", others, number, x, y);
    fputc('\n', out);
}

static void plot_parts(FILE *out, const sl_bench_scene *s) {
    int y = HEAD;
    sl_plot_begin(out, ".plot .in{font-size:11px}", &colours, BAR_LEFT + BAR_WIDTH + 16,
                  HEAD + bars_of(s) * BAR_STEP + 8, s->name, ": parts of a picture's processor time");
    for (size_t i = 0; i < s->row_count; i++) {
        if (!is_shown(&s->rows[i])) continue;
        put_bar(out, &s->rows[i], y);
        y += BAR_STEP;
    }
    fputs("</svg>\n", out);
}

bool sl_plot_is_there(const sl_bench_scene *s, int plot) {
    return plot == SL_PLOT_PARTS ? bars_of(s) > 0 : sl_plot_has_curves(s, (sl_bench_truth)plot);
}

bool sl_plot(FILE *out, const sl_bench_scene *s, int plot) {
    if (!sl_plot_is_there(s, plot)) return false;
    if (plot == SL_PLOT_PARTS) plot_parts(out, s);
    else sl_plot_curves(out, s, (sl_bench_truth)plot);
    return true;
}
