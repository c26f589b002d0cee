/* How a rank begins, ends them all, and tells that it is still there. */
#pragma once

#include <stdint.h>

/* This process is a rank; others that it starts are by themselves. */
void sl_ranks_start(void);

/* A hash of the call: of all that results depend on but for the scene. */
extern uint64_t sl_ranks_call;

/* Where the reason is told; ranks behind the first say nothing else. */
extern int sl_ranks_voice;

/* Tells a line about a rank, and ends all. */
_Noreturn void sl_ranks_end(unsigned rank, const char *why);

/* A thread of each rank's own: a rank that computes for long beats, one that is stopped, or whose machine is
 * gone, does not. The rank behind it in a ring misses it, and ends all. */
void sl_heartbeat_start(void);
/* When all have come here: nobody is missed who has done his work. */
void sl_heartbeat_stop(void);
