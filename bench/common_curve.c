/* Curves of speed against error: between their points, and as SVG, its axes logarithmic. */
#include <math.h>
#include <stdlib.h>

#include "common.h"

double bench_between(const bench_series *s, double at, bool seconds_wanted) {
    for (size_t i = 0; i + 1 < s->count; i++) {
        const bench_point *p = &s->point[i], *q = &s->point[i + 1];
        double x0 = seconds_wanted ? p->rel_mse : p->seconds, x1 = seconds_wanted ? q->rel_mse : q->seconds;
        double y0 = seconds_wanted ? p->seconds : p->rel_mse, y1 = seconds_wanted ? q->seconds : q->rel_mse;
        if ((at - x0) * (at - x1) > 0.0 || x0 == x1) continue;
        return exp(log(y0) + (log(y1) - log(y0)) * (log(at) - log(x0)) / (log(x1) - log(x0)));
    }
    return 0.0;
}

/* ---- the drawing ---- */

typedef struct drawing {
    FILE *file;
    double x0, x1, y0, y1; /* decades */
} drawing;

enum { LEFT = 80, RIGHT = 620, TOP = 40, BOTTOM = 420 };

static double place_x(const drawing *d, double seconds) {
    return LEFT + (log10(seconds) - d->x0) / (d->x1 - d->x0) * (RIGHT - LEFT);
}
static double place_y(const drawing *d, double error) {
    return BOTTOM - (log10(error) - d->y0) / (d->y1 - d->y0) * (BOTTOM - TOP);
}

static void include(drawing *d, const bench_series *s) {
    for (size_t i = 0; i < s->count; i++) {
        const bench_point *p = &s->point[i];
        if (!(p->rel_mse > 0.0)) continue;
        d->x0 = fmin(d->x0, floor(log10(p->seconds)));
        d->x1 = fmax(d->x1, ceil(log10(p->seconds)));
        d->y0 = fmin(d->y0, floor(log10(p->rel_mse)));
        d->y1 = fmax(d->y1, ceil(log10(p->rel_mse)));
    }
}

static void draw_axes(const drawing *d, const char *title, const char *error_axis) {
    fprintf(d->file, "<text x=\"%d\" y=\"24\" text-anchor=\"middle\" font-size=\"15\">%s</text>\n",
            (LEFT + RIGHT) / 2, title);
    for (double x = d->x0; x <= d->x1; x++) {
        double at = place_x(d, pow(10.0, x));
        fprintf(d->file,
                "<path d=\"M%.1f %dV%d\" stroke=\"#ccc\"/><text x=\"%.1f\" y=\"%d\" "
                "text-anchor=\"middle\">%g s</text>\n",
                at, TOP, BOTTOM, at, BOTTOM + 20, pow(10.0, x));
    }
    for (double y = d->y0; y <= d->y1; y++) {
        double at = place_y(d, pow(10.0, y));
        fprintf(d->file,
                "<path d=\"M%d %.1fH%d\" stroke=\"#ccc\"/><text x=\"%d\" y=\"%.1f\" "
                "text-anchor=\"end\">1e%g</text>\n",
                LEFT, at, RIGHT, LEFT - 6, at + 4.0, y);
    }
    fprintf(d->file, "<text x=\"%d\" y=\"%d\" text-anchor=\"middle\">processor seconds</text>\n",
            (LEFT + RIGHT) / 2, BOTTOM + 42);
    fprintf(d->file,
            "<text x=\"20\" y=\"%d\" text-anchor=\"middle\" transform=\"rotate(-90 20 %d)\">%s</text>\n",
            (TOP + BOTTOM) / 2, (TOP + BOTTOM) / 2, error_axis);
}

static void draw_series(const drawing *d, const bench_series *s) {
    char command = 'M';
    if (s->line) fprintf(d->file, "<path fill=\"none\" stroke=\"%s\" stroke-width=\"2\" d=\"", s->color);
    for (size_t i = 0; s->line && i < s->count; i++) {
        if (!(s->point[i].rel_mse > 0.0)) continue;
        fprintf(d->file, "%c%.1f %.1f", command, place_x(d, s->point[i].seconds),
                place_y(d, s->point[i].rel_mse));
        command = 'L';
    }
    if (s->line) fprintf(d->file, "\"/>\n");
    for (size_t i = 0; i < s->count; i++) {
        const bench_point *p = &s->point[i];
        if (p->rel_mse > 0.0)
            fprintf(d->file, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"2.5\" fill=\"%s\"/>\n",
                    place_x(d, p->seconds), place_y(d, p->rel_mse), s->color);
    }
}

void bench_draw_curves(const bench_report *r, const char *scene, const bench_series *series, size_t count) {
    char file_name[700];
    snprintf(file_name, sizeof file_name, "%s/%s-%s.svg", r->folder, r->name, scene);
    drawing d = {fopen(file_name, "w"), INFINITY, -INFINITY, INFINITY, -INFINITY};
    if (!d.file) return;
    for (size_t i = 0; i < count; i++) include(&d, &series[i]);
    fprintf(d.file, "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"660\" height=\"480\" "
                    "font-family=\"sans-serif\" font-size=\"12\">\n"
                    "<rect width=\"660\" height=\"480\" fill=\"white\"/>\n");
    draw_axes(&d, scene, r->error_axis ? r->error_axis : "relMSE");
    for (size_t i = 0; i < count; i++) draw_series(&d, &series[i]);
    int line = TOP;
    for (size_t i = 0; i < count; i++) {
        if (series[i].name)
            fprintf(d.file, "<text x=\"%d\" y=\"%d\" text-anchor=\"end\" fill=\"%s\">%s</text>\n", RIGHT - 8,
                    line += 18, series[i].color, series[i].name);
    }
    fprintf(d.file, "</svg>\n");
    fclose(d.file);
}
