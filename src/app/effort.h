/* The cost of a picture, by counts, which are the same on every machine, in units of one ray of a path
 * tracer. */
#ifndef SL_APP_EFFORT_H
#define SL_APP_EFFORT_H

#include "softlux.h"

double sl_effort_in_rays(const sl_counters *counters);

#endif
