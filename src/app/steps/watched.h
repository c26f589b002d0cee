/* Keeps the passes that a method announces, each once: its cost, and the newest picture and marks that it
 * left. */
#pragma once

#include "app/steps/narrative.h"

enum { SL_WATCHED_MAX = 64 };

typedef struct sl_watched_pass {
    char name[96], source[160];
    const cJSON *told; /* of the narrative; NULL: nothing */
    size_t place;      /* in the paper's order; SL_WATCHED_MAX: it has none */
    uint64_t times;    /* announced */
    sl_counters cost;  /* of all of them */
    uint64_t pictures; /* that it left */
    sl_image *latest;  /* the newest, until somebody takes it; or NULL */
    int width, height; /* of its picture; 0: none */
    sl_mark *marks;    /* the newest, evenly chosen of all_marks */
    size_t mark_count, all_marks;
} sl_watched_pass;

typedef struct sl_watched {
    const cJSON *narrative;
    sl_watched_pass pass[SL_WATCHED_MAX]; /* in the order of their first announcement */
    size_t count;
    bool failed; /* for want of memory or room */
} sl_watched;

/* Keeps a pass as it is announced: sl_observer.pass, of which the context is an sl_watched. */
void sl_watched_keep(void *watched, const sl_pass *told);
/* Frees what was kept. */
void sl_watched_clear(sl_watched *watched);
