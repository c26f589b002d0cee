/* Between selection.c, systematic.c and flood.c. */
#ifndef SL_SHADING_CACHE_SELECTION_PARTS_H
#define SL_SHADING_CACHE_SELECTION_PARTS_H

#include "base/counters.h"
#include "cache/shading_cache/selection.h"

/* One update's choices as they are made. */
typedef struct sl_selection {
    const sl_selection_settings *settings;
    int width, height;
    size_t pixel_count, leaf_count;
    const uint32_t *leaf;            /* by pixel */
    const sl_leaf_priority *leaves;
    uint8_t *visited;                /* one bit a pixel: chosen, or a flood has come by */
    uint16_t *taken;                 /* by leaf: choices in it */
    size_t open;                     /* leaves that may still be chosen */
    sl_choice *choice;
    size_t count;
    sl_counters *counters;
} sl_selection;

static inline bool sl_selection_visited(const sl_selection *s, uint32_t pixel) { return s->visited[pixel / 8] >> pixel % 8 & 1; }
static inline void sl_selection_visit(sl_selection *s, uint32_t pixel) { s->visited[pixel / 8] |= (uint8_t)(1u << pixel % 8); }

/* p_total = epsilon + (1 - epsilon) p_norm */
static inline float sl_selection_chance(const sl_selection *s, uint32_t leaf) {
    float e = s->settings->random_share;
    if (s->leaves[leaf].pixels == 0) return 0.0f;
    return e + (1.0f - e) * s->leaves[leaf].normal;
}

/* Chooses a pixel of a leaf, unless it has been chosen, or its patch has enough. */
bool sl_selection_take(sl_selection *s, uint32_t pixel, sl_choice_kind kind);

void sl_select_systematically(sl_selection *s);
sl_status sl_select_sorted(sl_selection *s, sl_error *error);
/* From the hits among the choices made so far. */
sl_status sl_select_flood(sl_selection *s, sl_error *error);

#endif
