/* Which pixels get samples: hit-and-test over the id map, flood fill from the hits (sections on priority-based selection and on flood fill).
 *
 *   selection.c    hit-and-test
 *   systematic.c   instead: equal steps through the sums of priorities; or the highest priorities first
 *   flood.c        from hits to the pixels beside them */
#ifndef SL_SHADING_CACHE_SELECTION_H
#define SL_SHADING_CACHE_SELECTION_H

#include "cache/shading_cache/priority.h"

typedef enum sl_choice_kind { SL_CHOICE_HIT, SL_CHOICE_RANDOM, SL_CHOICE_FLOOD } sl_choice_kind;

typedef struct sl_choice {
    uint32_t pixel;            /* index into the id plane */
    uint32_t leaf;             /* index into the leaves */
    sl_choice_kind kind;
} sl_choice;

typedef struct sl_selection_settings {
    sl_pixel_selection how;
    int points;                /* M: so many choices by tests, and at most as many by floods */
    float random_share;        /* epsilon; 0: none */
    float flood_threshold;     /* tau_f; above 1: no floods */
    int per_patch;             /* choices in one patch at most: 16 */
    uint64_t seed, update;     /* what draws are a function of */
} sl_selection_settings;

/* leaf: by pixel, index into leaves, or SL_NO_INDEX. Each pixel is chosen at most once, and of leaves whose `pixels` are 0 none. At most 8 points / epsilon tests (epsilon 0: as if it were
 * 0.03). choice has room for 2 * points. */
sl_status sl_select_pixels(const sl_selection_settings *settings, int width, int height, const uint32_t *leaf, size_t leaf_count,
                           const sl_leaf_priority *leaves, sl_choice *choice, size_t *choice_count, sl_counters *counters, sl_error *error);

#endif
