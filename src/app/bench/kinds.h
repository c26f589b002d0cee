/* What kinds of scenes the measured ones are: where their light comes from, as --method auto sees it. */
#ifndef SL_APP_BENCH_KINDS_H
#define SL_APP_BENCH_KINDS_H

#include "app/bench/schedule.h"

/* Fills in the scene's kind, from the journal if it is there already. */
sl_status sl_kinds_look(const sl_bench_options *options, sl_bench_scene *scene, sl_journal *journal,
                        sl_error *error);
/* scenes.csv: one line a scene. */
sl_status sl_kinds_write(const sl_bench_results *results, const char *folder, sl_error *error);

#endif
