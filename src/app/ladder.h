/* Each method's settings in one order, from coarse to fine: what --error and --time climb. */
#pragma once

#include "cache/frame/settings.h"

/* Returns how many steps; 0: the method refines one picture for as long as it is let
 * (path, bidirectional). */
unsigned sl_ladder_steps(const char *method);
/* Returns where a quality stands on it. */
unsigned sl_ladder_step_of(const char *method, sl_quality quality);
/* Returns what was asked for, and for what was left open this step's settings. */
sl_settings sl_ladder_settings(const sl_settings *asked, unsigned step);
/* Returns the step from which on each next one is finer in all that limits the error, or as fine there as it
 * gets. */
unsigned sl_ladder_refines_all_from(const char *method);
/* Returns its time, as a multiple of the first step's, on a large picture: rather too long than too short. */
double sl_ladder_cost(const char *method, unsigned step);

/* Returns the cost of a picture, by counts, which are the same on every machine, in units of one ray of a
 * path tracer. */
double sl_effort_in_rays(const sl_counters *counters);
