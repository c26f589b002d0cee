/* Facts about a scene that are found before anything is measured of it. */
#ifndef SL_APP_BENCH_SCENE_H
#define SL_APP_BENCH_SCENE_H

#include "app/bench/schedule.h"

/* Reads the scene, in a child since that may start threads, and finds what is in it. What cannot be
 * read says so in its `trouble`; a usage error where the report would take the place of one of its files. */
sl_status sl_bench_scene_read(const sl_bench_options *options, const char *path, sl_bench_scene *scene,
                              sl_error *error);
#endif
