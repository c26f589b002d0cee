/* Plots as SVG, for light and for dark paper: they stand alone as files, and inside a page. */
#ifndef SL_APP_BENCH_PLOT_H
#define SL_APP_BENCH_PLOT_H

#include "app/bench/results.h"

#include <stdio.h>

/* A plot for each truth: error over time, both logarithmic, a curve a method. The last one: parts of the
 * processor time of a picture, a bar a setting. */
enum { SL_PLOT_PARTS = SL_BENCH_TRUTHS, SL_PLOTS };

const char *sl_plot_name(int plot);
/* Tells whether there is anything to be drawn: two settings with a known error, or one that was looked at. */
bool sl_plot_is_there(const sl_bench_scene *scene, int plot);
/* Draws it; false: there is nothing. */
bool sl_plot(FILE *out, const sl_bench_scene *scene, int plot);
/* What sl_plot() draws. */
void sl_plot_curves(FILE *out, const sl_bench_scene *scene, sl_bench_truth truth);
bool sl_plot_has_curves(const sl_bench_scene *scene, sl_bench_truth truth);
/* Begins a plot: its style (that every drawing brings, colours of its classes in light and in dark), its
 * paper and its title, which is the scene's name and this. */
typedef struct sl_plot_colours {
    const char *rule; /* of class number %1$d and its colour %2$s */
    int count;
    const char *const *light, *const *dark;
} sl_plot_colours;
void sl_plot_begin(FILE *out, const char *style, const sl_plot_colours *colours, int width, int height,
                   const char *scene, const char *title);

#endif
