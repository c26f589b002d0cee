/* The errors of all rows of a scene: references are made as good as the smallest error that is told with them
 * asks for, as far as the budget goes. */
#ifndef SL_APP_BENCH_EVALUATE_H
#define SL_APP_BENCH_EVALUATE_H

#include "app/bench/schedule.h"

/* Fills in the errors of the rows that are there and the scene's references. What goes wrong with a reference
 * is told there, and is no failure here. */
sl_status sl_evaluate(const sl_bench_options *options, sl_bench_scene *scene, sl_error *error);

#endif
