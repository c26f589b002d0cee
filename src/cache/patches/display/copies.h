/* Two copies of what is shown: frames are drawn from one while an update writes to the other. A frame never
 * waits; an update that would write to what an unfinished frame reads does, or leaves it. */
#pragma once

#include <stdint.h>

#include "base/thread.h"

typedef struct sl_copies {
    sl_monitor swap;           /* guards what follows, and is held for as long as it takes to set it */
    int shown;                 /* 0 or 1 */
    int drawn_from[2];         /* by copy: frames under way */
    uint64_t builds;           /* so often has one been brought up to date */
} sl_copies;

/* Returns the shown copy, which stays as it is until it is given back. */
static inline int sl_copies_take(sl_copies *c, uint64_t *builds) {
    sl_monitor_enter(&c->swap);
    int shown = c->shown;
    c->drawn_from[shown]++;
    *builds = c->builds;
    sl_monitor_leave(&c->swap);
    return shown;
}
static inline void sl_copies_give_back(sl_copies *c, int copy) {
    sl_monitor_enter(&c->swap);
    c->drawn_from[copy]--;
    sl_monitor_signal(&c->swap);
    sl_monitor_leave(&c->swap);
}
/* Returns the hidden copy, once no frame is drawn from it any more; -1: one is, and it was not waited for.
 * Frames begun since the last swap are drawn from the other one. */
static inline int sl_copies_hidden(sl_copies *c, bool waits) {
    sl_monitor_enter(&c->swap);
    int hidden = 1 - c->shown;
    while (waits && c->drawn_from[hidden] > 0) sl_monitor_wait(&c->swap);
    if (c->drawn_from[hidden] > 0) hidden = -1;
    sl_monitor_leave(&c->swap);
    return hidden;
}
/* Shows the hidden copy. */
static inline void sl_copies_swap(sl_copies *c) {
    sl_monitor_enter(&c->swap);
    c->shown = 1 - c->shown;
    c->builds++;
    sl_monitor_leave(&c->swap);
}
