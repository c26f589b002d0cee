/* Plots as SVG, for light and for dark paper: they stand alone as files, and inside a page. */
#ifndef SL_APP_BENCH_PLOT_H
#define SL_APP_BENCH_PLOT_H

#include "app/bench/results.h"

#include <stdio.h>

/* Error over time, both logarithmic, a curve a method; false, and nothing is drawn, where fewer than two
 * settings have a known error. */
bool sl_plot_curves(FILE *out, const sl_bench_scene *scene, sl_bench_truth truth);
/* Parts of the processor time of a picture, a bar a setting; false where no setting was looked at. */
bool sl_plot_parts(FILE *out, const sl_bench_scene *scene);

#endif
