/* How many samples a second the updates of a show take on this machine, as the method is told of it: by that
 * it decides how fine things may be while they move. */
#ifndef SL_APP_RATE_H
#define SL_APP_RATE_H

#include "softlux.h"

typedef struct sl_rate {
    double told;           /* to the method last, samples a second; 0: nothing yet */
    bool begun;
    double begin, samples; /* of the span in which they are counted */
    uint64_t updates;      /* of the last frame */
} sl_rate;

/* Tells a rate that is another one by a quarter. last: with each frame, what it told. */
sl_status sl_rate_tell(sl_rate *rate, sl_live *live, const sl_live_state *last, sl_error *error);

#endif
