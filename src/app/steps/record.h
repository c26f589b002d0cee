/* The observer behind a page: keeps what every pass of a method looked like at each snapshot. */
#pragma once

#include "app/steps/marks.h"
#include "app/steps/watched.h"

typedef struct sl_recording {
    sl_mark_view view;
    sl_watched watched; /* whose pictures and marks are those since the last snapshot */
    /* of each pass and snapshot [picture, marks], PNG in base 64 and SVG: null where there is none or nothing
     * new */
    cJSON *frames[SL_WATCHED_MAX];
    int snapshots;
    sl_counters told; /* all costs that passes have announced */
    /* added to the next pass's cost, modulo 2^64, and to that of the first behind a snapshot: the snapshot's
     * first pass announces also the cost so far of an unfinished one, which gets it back */
    sl_counters next, later;
} sl_recording;

sl_observer sl_recording_observer(sl_recording *recording);
/* A snapshot is about to be resolved; counters: the method's. */
void sl_recording_interrupt(sl_recording *recording, const sl_counters *counters);
/* Keeps what is new since the last snapshot. */
void sl_recording_snapshot(sl_recording *recording);
/* Takes the steps, in the paper's order, those that it does not know last, as a JSON array. */
cJSON *sl_recording_json(sl_recording *recording);
void sl_recording_clear(sl_recording *recording);
