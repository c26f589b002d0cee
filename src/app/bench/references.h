/* Reference pictures by the path tracer, kept from run to run and made better when they have to be. A
 * reference is one picture of so many samples; a better one has more, and takes its place. Even and odd
 * samples are two independent halves (layers even.* and odd.*), whose difference tells the noise. Its name
 * holds what it depends on: the scene's content, the size, the light paths, the pixel filter and this
 * program's version. */
#pragma once

#include "app/bench/schedule.h"

/* $XDG_CACHE_HOME/softlux/references, or ~/.cache/softlux/references. */
void sl_reference_default_folder(char path[SL_BENCH_PATH]);
/* Tells whether two sets of light paths are one in this scene: without mirrors and glossy surfaces one bounce
 * is what splatting declares, for example. */
bool sl_reference_is_same(const sl_bench_scene *scene, const char *transport, const char *other);
/* Light paths that are the same in this scene share a file. */
void sl_reference_path(const char *folder, const sl_bench_scene *scene, const char *transport,
                       char path[SL_BENCH_PATH]);
/* Makes the reference, where there is none, or takes its place with one of so many samples a pixel. What goes
 * wrong is told in reference->trouble. */
sl_status sl_reference_make(const sl_bench_options *options, const sl_bench_scene *scene, uint64_t samples,
                            sl_bench_reference *reference, sl_error *error);
/* Fills in the errors of the rows that are there and the scene's references, which are made as good as the
 * smallest error that is told with them asks for, as far as the budget goes. What goes wrong with a reference
 * is told there, and is no failure here. */
sl_status sl_evaluate(const sl_bench_options *options, sl_bench_scene *scene, sl_error *error);
