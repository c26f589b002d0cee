/* Plots as SVG, for light and for dark paper: they stand alone as files, and inside a page. */
#pragma once

#include "app/bench/results.h"

#include <stdio.h>

/* Error over time, both logarithmic, a curve a method. */
typedef struct sl_plot {
    const sl_bench_scene *scene;
    sl_bench_truth truth;
} sl_plot;

/* Tells whether there is anything to be drawn: two settings with a known error. */
bool sl_plot_is_there(const sl_plot *plot);
/* Draws an sl_plot. */
void sl_put_plot(FILE *out, const void *plot);
