/* What is computed beside the shows, at its own pace, on one thread: an exact picture, a path traced
 * reference that grows, and how wrong what is shown is. It has a copy of the scene of its own. */
#pragma once

#include "app/serve/world.h"

typedef struct sl_worker sl_worker;

enum { SL_WORKER_SIDES = 2 };

/* An exact picture: what `softlux render` makes of this file; or a page, what `softlux steps` does. */
typedef struct sl_exact_job {
    char scene_path[4096];
    sl_load_options load;
    sl_settings settings;
    double at_seconds;
    char exr[4096], png[4096]; /* to be written */
    char page[4096];           /* or this; "": none */
} sl_exact_job;

/* What there is to be told; pictures are the caller's. */
typedef struct sl_work_done {
    bool exact_news, exact_done;
    double fraction;
    sl_image *exact;
    sl_error exact_error; /* .status: not SL_OK, it has failed */
    sl_image *reference;
    uint64_t samples;
    bool reference_done;
    struct sl_work_side {
        sl_image *difference, *map;
        bool judged;
        double error; /* relative RMSE */
    } side[SL_WORKER_SIDES];
} sl_work_done;

/* The world must outlive it. */
sl_status sl_worker_start(const sl_world *world, sl_worker **worker, sl_error *error);
void sl_worker_stop(sl_worker *worker); /* NULL is allowed */
/* The world's newest event. */
void sl_worker_follow(sl_worker *worker, const sl_event *event);
/* What shall be known; settings: of the pictures that are judged, as shown. */
void sl_worker_want(sl_worker *worker, bool reference, bool error, const sl_settings *settings);
/* A picture that a side shows, of the world as it stands; copied if it is of use. settings: of its method. */
void sl_worker_see(sl_worker *worker, int side, const sl_image *picture, const sl_settings *settings);
/* One at a time; NULL: none. */
void sl_worker_exact(sl_worker *worker, const sl_exact_job *job);
/* Takes what is new; false: nothing. */
bool sl_worker_take(sl_worker *worker, sl_work_done *done);
void sl_work_forget(sl_work_done *done); /* its pictures */
