/* Where the time goes: a bar for each quality of each method, as long as a whole, cut at its passes. */
#include "app/bench/plot.h"

#include "app/html.h"

#include <math.h>
#include <string.h>

enum { BAR_LEFT = 190, BAR_WIDTH = 640, BAR_HEIGHT = 20, BAR_STEP = 26, HEAD = 34 };

/* Leaves out the tracers, which have one pass, and nothing to show. */
static bool is_shown(const sl_bench_row *r) {
    bool tracer = strcmp(r->method, "path") == 0 || strcmp(r->method, "bidirectional") == 0;
    return r->end == SL_BENCH_RAN && r->part_count > 0 && !tracer;
}

/* Writes the name, or as much of it as there is room for: a letter takes some six pixels. */
static void put_name(FILE *out, const sl_bench_part *part, double x, double y, double width) {
    int room = (int)((width - 8.0) / 6.3), length = (int)strlen(part->name);
    char text[80];
    if (room < 4) return;
    if (length <= room) snprintf(text, sizeof text, "%s", part->name);
    else snprintf(text, sizeof text, "%.*s.", room - 1, part->name);
    fprintf(out, "<text class=\"in\" x=\"%.1f\" y=\"%.1f\">", x + 4.0, y + 14.0);
    sl_put_escaped(out, text);
    fputs("</text>", out);
}

static void put_bar(FILE *out, const sl_bench_row *row, int y) {
    double x = BAR_LEFT;
    fprintf(out, "<text x=\"%d\" y=\"%d\" text-anchor=\"end\">", BAR_LEFT - 8, y + 14);
    sl_put_escaped(out, row->curve);
    fprintf(out, ", %s</text>", sl_bench_quality_name(row->quality));
    for (size_t i = 0; i < row->part_count; i++) {
        double width = BAR_WIDTH * row->parts[i].share;
        if (!(width > 0.0)) continue;
        fprintf(out, "<rect class=\"p%zu\" x=\"%.1f\" y=\"%d\" width=\"%.1f\" height=\"%d\"><title>", i % 6,
                x, y, fmax(width - 1.0, 0.3), BAR_HEIGHT);
        sl_put_escaped(out, row->parts[i].name);
        fprintf(out, ": %.1f %%</title></rect>", 100.0 * row->parts[i].share);
        put_name(out, &row->parts[i], x, y, width);
        x += width;
    }
    fputc('\n', out);
}

static void put_style(FILE *out) {
    static const char *const light[] = {"#a9cdea", "#f3c9a8", "#aedcc9", "#e3bfd9", "#e6d79b", "#ccc"};
    static const char *const dark[] = {"#2c5d85", "#8a5226", "#2b6b54", "#7a4468", "#6b5b1c", "#555"};
    fputs("<style>.bars text{font:12px system-ui,sans-serif;fill:#222}.bars .paper{fill:#fff}.bars "
          ".title{font-weight:600;font-size:14px}.bars .in{font-size:11px}",
          out);
    for (int i = 0; i < 6; i++) fprintf(out, ".bars .p%d{fill:%s}", i, light[i]);
    fputs("@media(prefers-color-scheme:dark){.bars text{fill:#ddd}.bars .paper{fill:#15171a}", out);
    for (int i = 0; i < 6; i++) fprintf(out, ".bars .p%d{fill:%s}", i, dark[i]);
    fputs("}</style>\n", out);
}

bool sl_plot_parts(FILE *out, const sl_bench_scene *s) {
    int bars = 0, y = HEAD;
    for (size_t i = 0; i < s->row_count; i++) bars += is_shown(&s->rows[i]);
    if (!bars) return false;
    int width = BAR_LEFT + BAR_WIDTH + 16, height = HEAD + bars * BAR_STEP + 8;
    fprintf(out,
            "<svg class=\"bars\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %d %d\" width=\"%d\" "
            "height=\"%d\" role=\"img\">\n",
            width, height, width, height);
    put_style(out);
    fprintf(out,
            "<rect class=\"paper\" width=\"%d\" height=\"%d\"/>\n<text class=\"title\" x=\"8\" y=\"20\">",
            width, height);
    sl_put_escaped(out, s->name);
    fputs(": parts of a picture's processor time</text>\n", out);
    for (size_t i = 0; i < s->row_count; i++) {
        if (!is_shown(&s->rows[i])) continue;
        put_bar(out, &s->rows[i], y);
        y += BAR_STEP;
    }
    fputs("</svg>\n", out);
    return true;
}
