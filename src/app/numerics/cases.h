/* What is done to a room to make it hard, and what must come out of it. */
#ifndef SL_APP_NUMERICS_CASES_H
#define SL_APP_NUMERICS_CASES_H

#include "app/numerics/room.h"

typedef enum sl_expectation {
    SL_EXPECT_SAME,     /* the picture of the plain room, within `bound` */
    SL_EXPECT_MIRRORED, /* the same, left and right exchanged */
    SL_EXPECT_SCALED,   /* the same, times `factor` */
    SL_EXPECT_SOUND     /* finite, nowhere negative, the same bits with other threads: what every picture must be */
} sl_expectation;

typedef struct sl_hard_case {
    const char *name;
    void (*make)(sl_room *room); /* begins the room */
    sl_expectation expectation;
    double bound;                /* how many times the greater of the method's noise and of its error in the plain room; at least 2 % of the picture's mean */
    double factor;
} sl_hard_case;

extern const sl_hard_case sl_hard_cases[];
extern const size_t sl_hard_case_count;

#endif
