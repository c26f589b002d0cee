/* Reference pictures by the path tracer, kept from run to run and made better when they have to be.
 *
 * A reference is the mean of chunks of samples, each with a seed of its own; even and odd chunks are kept
 * apart as two independent halves (layers even.* and odd.*), whose difference tells the noise. The first
 * pairs are short, so that there is something soon; each later one is as long as all before it, since the
 * path tracer's points are the better spread the more of them belong together. Its name holds what it depends
 * on: the scene's content, the size, the light paths, the pixel filter and this program's version. The same
 * number of pairs gives the same bits. */
#ifndef SL_APP_BENCH_REFERENCES_H
#define SL_APP_BENCH_REFERENCES_H

#include "app/bench/schedule.h"

/* $XDG_CACHE_HOME/softlux/references, or ~/.cache/softlux/references. */
void sl_reference_default_folder(char path[SL_BENCH_PATH]);
/* Makes it, and those above it, where they are not there; fails where nothing can be written in it. */
sl_status sl_reference_make_folder(const char *path, sl_error *error);
/* Tells whether two sets of light paths are one in this scene: without mirrors and glossy surfaces one bounce
 * is what splatting declares, for example. */
bool sl_reference_is_same(const sl_bench_scene *scene, const char *transport, const char *other);
/* Light paths that are the same in this scene share a file. */
void sl_reference_path(const char *folder, const sl_bench_scene *scene, const char *transport,
                       char path[SL_BENCH_PATH]);
/* Samples a pixel in the reference's first pairs of chunks. */
uint64_t sl_reference_samples(uint64_t pairs);
/* Reads what its metadata tell; false where it is none. */
bool sl_reference_read(const sl_image *image, uint64_t *pairs, double *seconds);
/* `pairs` more pairs of chunks for the scene's reference, which is made where there is none. Fills in samples
 * and seconds; what goes wrong is told in reference->trouble. */
sl_status sl_reference_extend(const sl_bench_options *options, const sl_bench_scene *scene, uint64_t pairs,
                              sl_bench_reference *reference, sl_error *error);
/* Finds which pixels are compared: 1 where the centre looks at neither lamp nor sky, as one channel;
 * everywhere where all do. NULL: it could not be found out. */
sl_image *sl_reference_mask(const sl_bench_options *options, const sl_bench_scene *scene, sl_error *error);

#endif
