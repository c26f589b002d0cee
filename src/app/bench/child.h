/* Work in a process of its own: it may crash, run out of memory or never end, and all that happens here is
 * that this is told. The memory that it took is its own, too, and its clock starts at zero. */
#pragma once

#include "softlux.h"

typedef enum sl_child_outcome {
    SL_CHILD_DONE,
    SL_CHILD_FAILED,  /* it said why: out of memory, a scene that it cannot do */
    SL_CHILD_CRASHED, /* by a signal, or by an exit of its own */
    SL_CHILD_STOPPED, /* the seconds were up */
    SL_CHILD_LEFT_OUT /* somebody wants this program to end; or it was not begun */
} sl_child_outcome;

typedef struct sl_child_limits {
    double seconds;        /* by the clock; 0: none */
    uint64_t memory_bytes; /* of addresses; 0: none */
    bool (*interrupted)(void); /* asked now and then; or NULL */
} sl_child_limits;

typedef struct sl_child_end {
    sl_child_outcome outcome;
    char *text;    /* what it reported; "" where it did not end well; the caller frees it */
    char why[256]; /* where it did not end well: one line */
} sl_child_end;

/* A report to the parent, and whether all went well; where not, the report is a line that says what did not.
 */
typedef bool sl_child_work(void *context, char **report);

/* Runs work in a child and waits for it. The calling process must not have run a parallel loop before: OpenMP
 * does not survive a fork. */
sl_status sl_child_run(sl_child_work *work, void *context, const sl_child_limits *limits, sl_child_end *end,
                       sl_error *error);

/* Writes all of it: a disk that fills up takes a part, and says why at the next try. */
bool sl_write_all(int file, const char *text, size_t bytes);
