/* Full-screen passes: a fragment program for every pixel of a target, as drawn by one rectangle over the whole
 * screen. */
#ifndef SL_RASTER_FULLSCREEN_H
#define SL_RASTER_FULLSCREEN_H

#include "softlux.h"

/* Shades pixels [x0,x1) of row y. It may read any planes, at any pixel, and write any number of others at its own
 * pixels; what it writes must not be read in the same pass at other pixels. Returns how many fragments it shaded
 * (all, or those that it did not discard). */
typedef uint64_t sl_fullscreen_program(void *context, int x0, int x1, int y);

/* Runs the program for every pixel once. Tiles of 512 x 8 pixels, fixed by the target's size, each run by one thread,
 * rows upwards. Counts SL_COUNT_FRAGMENTS_SHADED. Sizes below 1: nothing. */
void sl_raster_fullscreen(int width, int height, unsigned threads, sl_fullscreen_program *program, void *context,
                          sl_counters *counters);

#endif
