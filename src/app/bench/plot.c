/* Error over time. The line joins the settings that pay; what does not is a hollow point beside it. Each
 * curve ends at its name. */
#include "app/bench/report.h"
#include "app/page.h"

#include <math.h>
#include <string.h>

/* ---- the paper ---- */

/* Classes 0, 1, ... of the five methods' and two tracers' colours; the last is the photon map's. On light and
 * on dark paper. */
enum { CLASSES = 8 };
static const char *const light[CLASSES] = {"#0065a8", "#c24e00", "#00805c", "#a63a86",
                                           "#8a6a00", "#333",    "#777",    "#7a4fd0"};
static const char *const dark[CLASSES] = {"#5db4f0", "#ff9650", "#3fd6a6", "#ee96cf",
                                          "#e6c34a", "#eee",    "#aaa",    "#b79bff"};

static void put_colours(FILE *out, const char *const colours[CLASSES]) {
    for (int i = 0; i < CLASSES; i++)
        fprintf(out, ".plot .m%d{stroke:%s}.plot .f%d{fill:%s;stroke:%s}.plot text.n%d{fill:%s}", i,
                colours[i], i, colours[i], colours[i], i, colours[i]);
}

enum { WIDTH = 780, HEIGHT = 470, LEFT = 64, RIGHT = 176, TOP = 34, BOTTOM = 48 };

/* Begins a plot: its style, for light and for dark paper, its paper and its title. */
static void begin(FILE *out, const char *scene, const char *title) {
    fprintf(out,
            "<svg class=\"plot\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %d %d\" width=\"%d\" "
            "height=\"%d\" role=\"img\">\n<style>.plot text{font:12px system-ui,sans-serif;fill:#222}.plot "
            ".paper{fill:#fff}.plot .grid{stroke:#ddd}.plot .title{font-weight:600;font-size:14px}.plot "
            ".goal{stroke:#888;stroke-dasharray:6 4}.plot .line{fill:none;stroke-width:2}.plot "
            ".lead{stroke-width:.6;stroke-dasharray:2 3}.plot .off{fill:none;opacity:.55}",
            WIDTH, HEIGHT, WIDTH, HEIGHT);
    put_colours(out, light);
    fputs("@media(prefers-color-scheme:dark){.plot text{fill:#ddd}.plot .paper{fill:#15171a}.plot "
          ".grid{stroke:#33373d}",
          out);
    put_colours(out, dark);
    fprintf(out,
            "}</style>\n<rect class=\"paper\" width=\"%d\" height=\"%d\"/>\n<text class=\"title\" x=\"8\" "
            "y=\"20\">",
            WIDTH, HEIGHT);
    sl_put_escaped(out, scene);
    fprintf(out, "%s</text>\n", title);
}

typedef struct axis {
    double least, most; /* powers of ten */
    double from, to;    /* pixels */
} axis;

typedef struct label {
    const char *text;
    int class;
    double x, y, at; /* where the curve ends, and how high the name stands */
} label;

static double place(const axis *a, double value) {
    return a->from + (log10(value) - a->least) / (a->most - a->least) * (a->to - a->from);
}

/* Returns the class of a curve. */
static int class_of(const char *curve) {
    static const char *const names[] = {"splatting",     "direct-radiance", "light-octree", "multi-mesh",
                                        "shading-cache", "path",            "bidirectional"};
    int i = 0, count = sizeof names / sizeof *names;
    while (i < count && strncmp(curve, names[i], strlen(names[i])) != 0) i++;
    return i;
}

/* ---- error over time ---- */

/* Keeps of the tracers those whose own truth this is. */
static bool belongs(const sl_curve *c, sl_bench_truth truth) {
    if (!sl_is_tracer(c->row[0]->trial->method) || truth == SL_BENCH_MATCHED) return true;
    return strstr(c->name, sl_bench_truth_name(truth)) != NULL;
}

static size_t choose_curves(const sl_bench_scene *s, sl_bench_truth truth, sl_curve curves[SL_CURVES]) {
    size_t count = sl_curves_of(s, truth, curves), kept = 0;
    for (size_t i = 0; i < count; i++) {
        if (belongs(&curves[i], truth)) curves[kept++] = curves[i];
    }
    return kept;
}

static size_t find_bounds(const sl_curve *curves, size_t count, sl_bench_truth truth, axis *x, axis *y) {
    size_t points = 0;
    x->least = y->least = HUGE_VAL;
    x->most = y->most = -HUGE_VAL;
    for (size_t k = 0; k < count; k++) {
        for (size_t i = 0; i < curves[k].count; i++) {
            double t = log10(curves[k].row[i]->cpu.median),
                   e = log10(curves[k].row[i]->error[truth].rel_rmse);
            if (!isfinite(t) || !isfinite(e)) continue;
            x->least = fmin(x->least, t), x->most = fmax(x->most, t);
            y->least = fmin(y->least, e), y->most = fmax(y->most, e);
            points++;
        }
    }
    x->least -= 0.1, x->most += 0.1, y->least -= 0.1, y->most += 0.1;
    return points;
}

static bool is_on_paper(const sl_bench_row *row, sl_bench_truth truth) {
    return row->cpu.median > 0.0 && row->error[truth].rel_rmse > 0.0;
}

/* Puts a line from one side of the field to the other, upright or level. */
static void put_line(FILE *out, const char *class, bool upright, double at) {
    fprintf(out, "<line class=\"%s\" x1=\"%.1f\" x2=\"%.1f\" y1=\"%.1f\" y2=\"%.1f\"/>", class,
            upright ? at : LEFT, upright ? at : WIDTH - RIGHT, upright ? TOP : at,
            upright ? HEIGHT - BOTTOM : at);
}

/* 1, 2, 5 of each power of ten, and their names: seconds across, shares upwards. */
static void put_axis(FILE *out, const axis *a, bool across) {
    static const double steps[] = {1.0, 2.0, 5.0};
    for (int power = (int)floor(a->least); power <= (int)ceil(a->most); power++) {
        for (int i = 0; i < 3; i++) {
            const double value = steps[i] * pow(10.0, power), at = log10(value), p = place(a, value);
            if (at < a->least || at > a->most) continue;
            put_line(out, "grid", across, p);
            if (i > 0 && a->most - a->least >= 3.5) continue;
            if (across)
                fprintf(out, "<text x=\"%.1f\" y=\"%d\" text-anchor=\"middle\">%.12g</text>", p,
                        HEIGHT - BOTTOM + 17, value);
            else
                fprintf(out, "<text x=\"%d\" y=\"%.1f\" text-anchor=\"end\">%.12g %%</text>", LEFT - 6,
                        p + 4.0, 100.0 * value);
        }
    }
    fputc('\n', out);
}

static void put_goals(FILE *out, const axis *y) {
    static const double goals[] = {0.05, 0.01};
    for (int i = 0; i < 2; i++)
        if (log10(goals[i]) >= y->least && log10(goals[i]) <= y->most)
            put_line(out, "goal", false, place(y, goals[i]));
}

/* Qualities are large, other settings small; what is only known to be less than that points down. */
static void put_point(FILE *out, const sl_bench_row *row, sl_bench_truth truth, bool best, int class,
                      double x, double y) {
    char error[32], seconds[32], title[2 * SL_BENCH_NAME + 80];
    double r = strcmp(row->trial->quality, "curve") == 0 ? 2.6 : 4.4;
    sl_error_text(&row->error[truth], error);
    sl_seconds_text(row->cpu.median, seconds);
    fprintf(out, "<g class=\"%s%d\">", best ? "f" : "off m", class);
    if (row->error[truth].lost)
        fprintf(out, "<path d=\"M%.1f %.1fh%.1fl%.1f %.1fz\">", x - r, y - r, 2.0 * r, -r, 2.0 * r);
    else fprintf(out, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"%.1f\">", x, y, r);
    snprintf(title, sizeof title, "%s, %s: %s s, %s", row->trial->curve, row->trial->name, seconds, error);
    fputs("<title>", out);
    sl_put_escaped(out, title);
    fprintf(out, "</title></%s></g>\n", row->error[truth].lost ? "path" : "circle");
}

static label put_curve(FILE *out, const sl_curve *c, sl_bench_truth truth, const axis *x, const axis *y) {
    label end = {c->name, class_of(c->name), 0.0, 0.0, 0.0};
    fprintf(out, "<polyline class=\"line m%d\" points=\"", end.class);
    for (size_t i = 0; i < c->count; i++) {
        if (!c->best[i] || !is_on_paper(c->row[i], truth)) continue;
        end.x = place(x, c->row[i]->cpu.median);
        end.y = end.at = place(y, c->row[i]->error[truth].rel_rmse);
        fprintf(out, "%.1f,%.1f ", end.x, end.y);
    }
    fputs("\"/>\n", out);
    for (size_t i = 0; i < c->count; i++) {
        if (is_on_paper(c->row[i], truth))
            put_point(out, c->row[i], truth, c->best[i], end.class, place(x, c->row[i]->cpu.median),
                      place(y, c->row[i]->error[truth].rel_rmse));
    }
    return end;
}

/* Names stand in a column at the right, in the order of the curves' ends, apart from each other. */
static void put_labels(FILE *out, label *labels, size_t count) {
    const double apart = 15.0;
    for (size_t i = 1; i < count; i++) {
        for (size_t k = i; k > 0 && labels[k].y < labels[k - 1].y; k--) {
            label swap = labels[k];
            labels[k] = labels[k - 1];
            labels[k - 1] = swap;
        }
    }
    for (size_t i = 1; i < count; i++) labels[i].at = fmax(labels[i].y, labels[i - 1].at + apart);
    double limit = HEIGHT - BOTTOM;
    for (size_t i = count; i-- > 0; limit -= apart) labels[i].at = fmin(labels[i].at, limit);
    for (size_t i = 0; i < count; i++) {
        const label *l = &labels[i];
        fprintf(out, "<line class=\"lead m%d\" x1=\"%.1f\" y1=\"%.1f\" x2=\"%d\" y2=\"%.1f\"/>", l->class,
                l->x + 5.0, l->y, WIDTH - RIGHT + 6, l->at);
        fprintf(out, "<text class=\"n%d\" x=\"%d\" y=\"%.1f\">", l->class, WIDTH - RIGHT + 9, l->at + 4.0);
        sl_put_escaped(out, l->text);
        fputs("</text>\n", out);
    }
}

bool sl_plot_is_there(const sl_plot *p) {
    sl_curve curves[SL_CURVES];
    axis x, y;
    return find_bounds(curves, choose_curves(p->scene, p->truth, curves), p->truth, &x, &y) >= 2;
}

void sl_put_plot(FILE *out, const void *plot) {
    static const char *const against[] = {
        ": relative RMSE against the method's own light paths",
        ": relative RMSE against direct light and one diffuse bounce",
        ": relative RMSE against full global illumination",
    };
    sl_curve curves[SL_CURVES];
    label labels[SL_CURVES];
    axis x = {.from = LEFT, .to = WIDTH - RIGHT}, y = {.from = HEIGHT - BOTTOM, .to = TOP};
    const sl_plot *p = plot;
    const sl_bench_truth truth = p->truth;
    size_t count = choose_curves(p->scene, truth, curves);
    find_bounds(curves, count, truth, &x, &y);
    begin(out, p->scene->name, against[truth]);
    put_axis(out, &x, true);
    put_axis(out, &y, false);
    put_goals(out, &y);
    fprintf(out, "<text x=\"%.1f\" y=\"%d\" text-anchor=\"middle\">processor seconds</text>\n",
            0.5 * (LEFT + WIDTH - RIGHT), HEIGHT - 10);
    for (size_t k = 0; k < count; k++) labels[k] = put_curve(out, &curves[k], truth, &x, &y);
    put_labels(out, labels, count);
    fputs("</svg>\n", out);
}
