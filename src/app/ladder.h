/* Each method's settings in one order, from coarse to fine: what --error and --time climb. */
#pragma once

#include "cache/frame/settings.h"

typedef struct sl_ladder_step {
    const char *method;
    sl_quality quality;
    bool own;    /* the quality stands here */
    double cost; /* time, in those of the first step, on a large picture: rather too long than too short */
    const char *settings; /* for what was left open */
} sl_ladder_step;
/* A method's steps; none: it refines one picture for as long as it is let (path, bidirectional). */
typedef struct sl_ladder {
    const sl_ladder_step *step;
    unsigned count;
} sl_ladder;

sl_ladder sl_ladder_of(const char *method);
/* Returns what was asked for, and for what was left open this step's settings. */
sl_settings sl_ladder_settings(const sl_settings *asked, const sl_ladder_step *step);
/* Returns the step from which on each next one is finer in all that limits the error, or as fine there as it
 * gets. */
unsigned sl_ladder_refines_all_from(const char *method);
/* Returns the cost of a picture, by counts, which are the same on every machine, in units of one ray of a
 * path tracer. */
double sl_effort_in_rays(const sl_counters *counters);
