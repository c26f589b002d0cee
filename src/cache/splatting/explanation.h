/* What made a pixel, and records as marks: for those who look on. */
#ifndef SL_CACHE_SPLATTING_EXPLANATION_H
#define SL_CACHE_SPLATTING_EXPLANATION_H

#include "cache/frame/method.h"
#include "cache/splatting/state.h"

/* See sl_method_explanation(). */
sl_status sl_splat_explanation(void *state, int x, int y, sl_explanation_writer *writer, sl_error *error);
/* Tells how many second-level records and bounces there are. */
void sl_splat_announce_second_level(sl_splat_state *state);
/* The picture that the record nearest to the middle of the view made of its hemisphere, gathered once more;
 * nothing without an observer. */
void sl_splat_announce_gather(sl_splat_state *state, sl_record_cache *cache);
/* All records, as discs as wide as they reach; nothing without an observer. */
void sl_splat_announce_records(sl_splat_state *state);

#endif
