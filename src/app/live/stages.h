/* How long each pass of the updates takes, by an observer that looks at the clock of the updating thread:
 * time in which that thread had no processor, as others had it, does not count. */
#ifndef SL_APP_LIVE_STAGES_H
#define SL_APP_LIVE_STAGES_H

#include "softlux.h"

enum { SL_STAGES_MAX = 32 };

typedef struct sl_stage {
    char name[64];
    uint64_t times;
    double seconds;
} sl_stage;

typedef struct sl_stages {
    sl_observer observer; /* to be given to the method */
    sl_stage stage[SL_STAGES_MAX];
    int count;
    double last;
} sl_stages;

void sl_stages_begin(sl_stages *stages); /* which must stay where it is */
double sl_stages_seconds(const sl_stages *stages);

#endif
