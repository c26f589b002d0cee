/* What a picture's error is told to be without a reference (sl_error_probe), beside what it is found to be
 * with one: how well such promises hold. */
#ifndef SL_APP_BENCH_AUDITS_H
#define SL_APP_BENCH_AUDITS_H

#include "app/bench/schedule.h"

/* Judges the pictures of all rows that ran, each in a child, as far as the journal does not hold it yet;
 * fills in the rows' promises. What cannot be judged has none. */
sl_status sl_audits_run(const sl_bench_options *options, sl_bench_scene *scene, sl_journal *journal,
                        sl_error *error);

#endif
