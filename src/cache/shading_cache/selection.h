/* Which pixels get samples: hit-and-test over the id map, flood fill from the hits (sections on priority-
 * based selection and on flood fill). Both are in shading_cache.c. */
#pragma once

#include "base/counters.h"
#include "cache/shading_cache/priority.h"

typedef enum sl_choice_kind { SL_CHOICE_HIT, SL_CHOICE_RANDOM, SL_CHOICE_FLOOD } sl_choice_kind;

typedef struct sl_choice {
    uint32_t pixel;            /* index into the id plane */
    uint32_t leaf;             /* index into the leaves */
    sl_choice_kind kind;
} sl_choice;

/* One update's choices. */
typedef struct sl_selection {
    sl_pixel_selection how;
    int points;                /* M: so many choices by tests, and at most as many by floods */
    float random_share;        /* epsilon; 0: none */
    float flood_threshold;     /* tau_f; above 1: no floods */
    uint32_t per_patch;        /* choices in one patch at most: 16 */
    uint64_t seed, update;     /* what draws are a function of */
    int width, height;
    const uint32_t *leaf;      /* by pixel: index into leaves, or SL_NO_INDEX */
    const sl_leaf_priority *leaves;
    size_t leaf_count;
    sl_counters *counters;
    sl_choice *choice;         /* room for 2 * points */
    size_t count;              /* of choices; from here on as they are made */
    size_t pixel_count;
    uint8_t *visited;          /* one bit a pixel: chosen, or a flood has come by */
    uint16_t *taken;           /* by leaf: choices in it */
    size_t open;               /* leaves that may still be chosen */
} sl_selection;

/* Each pixel is chosen at most once, and of leaves whose `pixels` are 0 none. At most 8 points / epsilon
 * tests (epsilon 0: as if it were 0.03). After a failure there are no choices. */
sl_status sl_select_pixels(sl_selection *selection, sl_error *error);

static inline bool sl_selection_visited(const sl_selection *s, uint32_t pixel) {
    return s->visited[pixel / 8] >> pixel % 8 & 1;
}
static inline void sl_selection_visit(sl_selection *s, uint32_t pixel) {
    s->visited[pixel / 8] |= (uint8_t)(1u << pixel % 8);
}

/* Chooses a pixel of a leaf, unless it has been chosen, or its patch has enough. */
bool sl_selection_take(sl_selection *s, uint32_t pixel, sl_choice_kind kind);

/* shading_cache.c */
void sl_hit_and_test(sl_selection *s);
/* From the hits among the choices made so far. */
sl_status sl_flood_fill(sl_selection *s, sl_error *error);
