/* Plots as SVG, for light and for dark paper: they stand alone as files, and inside a page. */
#ifndef SL_APP_BENCH_PLOT_H
#define SL_APP_BENCH_PLOT_H

#include "app/bench/results.h"

#include <stdio.h>

/* A plot for each truth: error over time, both logarithmic, a curve a method. The last one: parts of the
 * processor time of a picture, a bar a setting. */
enum { SL_PLOT_PARTS = SL_BENCH_TRUTHS, SL_PLOTS };

typedef struct sl_plot {
    const sl_bench_scene *scene;
    int plot;
} sl_plot;

const char *sl_plot_name(int plot);
/* Tells whether there is anything to be drawn: two settings with a known error, or one that was looked at. */
bool sl_plot_is_there(const sl_plot *plot);
/* Draws an sl_plot. */
void sl_put_plot(FILE *out, const void *plot);

#endif
