/* One worker's buffers for light samples: what is expected of every hit, samples as drawn, samples in order
 * of their sources. */
#ifndef SL_CACHE_GATHER_LIGHT_SCRATCH_H
#define SL_CACHE_GATHER_LIGHT_SCRATCH_H

#include "cache/hemisphere/gather_internal.h"

typedef struct sl_chosen_source {
    uint32_t slot, source;
    float share; /* 1 over the expected number of such samples */
} sl_chosen_source;

struct sl_light_scratch {
    size_t capacity;               /* of samples */
    size_t lit;                    /* hits that sources may reach; by slot: */
    float *reflects;               /* albedo times the cell's weight; 0 where nothing is seen */
    /* [slot][SL_SOURCE_BLOCKS_MAX]: irradiance that a block of sources may bring */
    float *of_block;
    float *expected;               /* that of all */
    float *samples_at;             /* expected number of samples */

    size_t samples, of_emitters;
    sl_chosen_source *chosen;
    uint32_t *of_source;
    uint32_t *sample_slot, *sample_source; /* by source: */
    float *share, *u1, *u2;
    float *origin_x, *origin_y, *origin_z, *direction_x, *direction_y, *direction_z, *arriving, *near;
    void *block;
};

/* For up to `slots` hits. */
sl_status sl_light_scratch_create(const sl_gather *gather, size_t slots, sl_light_scratch **scratch,
                                  sl_error *error);
void sl_light_scratch_destroy(sl_light_scratch *scratch);

#endif
