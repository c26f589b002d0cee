/* The observer behind a page: keeps every pass that a method announces, and what it looked like at each
 * snapshot. */
#ifndef SL_APP_STEPS_RECORD_H
#define SL_APP_STEPS_RECORD_H

#include "app/steps/marks.h"
#include "app/steps/narrative.h"

/* ---- what passes announce ---- */

enum { SL_STEPS_MAX = 64 };

typedef struct sl_step {
    char name[96], source[160];
    const cJSON *told;   /* of the narrative; NULL: the page says only what the method announces */
    size_t place;        /* in the paper's order */
    uint64_t times;      /* announced */
    sl_counters cost;    /* of all of them */
    int width, height;   /* of its picture; 0: none */
    sl_image *latest;    /* since the last snapshot; NULL: nothing new */
    char *latest_marks;  /* SVG, likewise */
    cJSON *frames;       /* of each snapshot [picture, marks]: null where there is none or nothing new */
} sl_step;

typedef struct sl_recording {
    const cJSON *narrative;
    sl_mark_view view;
    sl_step steps[SL_STEPS_MAX]; /* in the order of their first announcement */
    size_t count;
    int snapshots;
    sl_counters told;     /* all costs that passes have announced */
    /* what an unfinished pass has cost when a snapshot comes in between: the snapshot's first pass announces
     * it ... */
    sl_counters early;
    sl_counters owed;     /* ... and the next one gets it back */
    bool resolving;       /* between the two functions below */
    bool failed;          /* for want of memory or room */
} sl_recording;

sl_observer sl_recording_observer(sl_recording *recording);
/* A snapshot is about to be resolved; counters: the method's. */
void sl_recording_interrupt(sl_recording *recording, const sl_counters *counters);
/* Keeps what is new since the last snapshot. */
void sl_recording_snapshot(sl_recording *recording);
/* Takes the steps, in the paper's order, those that it does not know last, as a JSON array. */
cJSON *sl_recording_json(sl_recording *recording);
void sl_recording_clear(sl_recording *recording);

#endif
