/* Measures how many samples a second the updates of a show take on this machine, and tells the method: by
 * that it decides how fine patches may be while things move. */
#pragma once

#include "cache/frame/settings.h"

typedef struct sl_rate {
    double told;           /* to the method last, samples a second; 0: nothing yet */
    bool begun;
    double begin, samples; /* of the span in which they are counted */
    uint64_t updates;      /* of the last frame */
} sl_rate;

/* Tells a rate that is another one by a quarter, unless the settings name one. To be called with each frame's
 * state. */
sl_status sl_rate_tell(sl_rate *rate, sl_live *live, const sl_settings *settings, const sl_live_state *frame,
                       sl_error *error);
