/* Lamps that the eye sees. A lamp is hundreds of times as bright as what it lights, so at its rim nearly all
 * noise of a pixel is that of how much of the lamp is in it. There walks leave out what the eye itself sees
 * of lamps (L S* E), and sixteen rays for each of them look for nothing else. */
#ifndef SL_TRACE_PATH_LAMPS_H
#define SL_TRACE_PATH_LAMPS_H

#include "trace/path_walk.h"

typedef struct sl_path_lamps {
    sl_path_walk lamps, rest; /* what the eye sees of lamps; and all other light */
} sl_path_lamps;

typedef struct sl_path_lamp_view {
    sl_rgb mean;
    float low, high; /* luminance */
} sl_path_lamp_view;

sl_path_lamps sl_path_lamps_of(const sl_path_walk *walk);
/* Looks through sixteen places of the square of that side at (x, y), in pixels; with other points than the
 * walks of that key. walk: of an sl_path_lamps, for lamps. */
sl_path_lamp_view sl_path_see_lamps(const sl_path_walk *walk, const sl_path_lens *lens, int x, int y,
                                    float side, uint64_t key, uint32_t index, sl_counters *counters);

#endif
