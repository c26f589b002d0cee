/* Records for many points at once, of both levels: of pixels that no record covers (traversal.c), and of
 * points that gathers see (../bounces/cover.c).
 *
 * A record's content does not depend on the cache, and coverage only grows; so a batch of candidates can be
 * gathered in parallel and committed in order, setting aside those that an earlier one of the batch has
 * covered: the records are those of the sequential algorithm, whatever the batch and the number of threads.
 */
#pragma once

#include "cache/splatting/record.h"

enum { SL_BATCH_MIN = 4, SL_BATCH_MAX = 128 };

typedef struct sl_record_batch {
    const sl_scene *scene;
    const sl_tracer *tracer; /* or NULL: the guard alone keeps records from reaching through walls */
    const sl_gathers *gathers;
    sl_radius_rules radii;
    size_t coefficient_count; /* floats of one record's coefficients; 0: irradiance records */
    size_t count;
    sl_gather_point point[SL_BATCH_MAX];
    float footprint[SL_BATCH_MAX]; /* of a pixel there, m */
    sl_record record[SL_BATCH_MAX];
    float *coefficients;
} sl_record_batch;

/* Makes a record for each point. */
void sl_record_batch_gather(sl_record_batch *batch, sl_counters *counters);

/* Returns the number of candidates to take next, after `committed` of `count` have become records: it follows
 * the waste and never changes which records there are. */
static inline size_t sl_record_batch_size(size_t size, size_t count, size_t committed) {
    const size_t wasted = count - committed;
    if (wasted * 32 <= count) return 2 * size < SL_BATCH_MAX ? 2 * size : SL_BATCH_MAX;
    return wasted * 8 > count && size > SL_BATCH_MIN ? size / 2 : size;
}
