/* One workload on ours and on OSMesa, in turn, and a line of the table about it. */
#pragma once

#include "raster_osmesa.h"

typedef struct workload {
    char name[128];
    double wanted;       /* OSMesa's time over ours on one thread; 0: nothing is */
    double renders;      /* in one run; times are told of one */
    /* what one render gets through (pixels, triangles), told in millions a second; 0: not told */
    double units;
    const char *unit;
    bool alone;          /* too small for two threads */
    void *context;
    void (*ours)(void *context, unsigned threads, sl_counters *counters);
    peer_pass *peer;     /* NULL: OSMesa is not here */
    /* share of the words in which the two pictures differ; NULL: not told */
    double (*differing)(void *context, peer_pass *peer);
} workload;

typedef struct figures {
    double ours, ours_spread;       /* ms a render; see raster_measure.c */
    double ours_one_thread;         /* where more were asked for */
    double peer, peer_spread, peer_drawing; /* with reading back, and without */
    double differing;
    sl_counters counters;           /* of one run of ours */
} figures;

typedef struct measurer {
    unsigned threads;
    const char *only;               /* rows whose name contains it, or NULL */
    int rows, missed;
} measurer;

bool measure_wants(const measurer *m, const char *name);
void measure_head(const measurer *m, const char *title);
/* Measures, prints the line and destroys the peer's pass. */
figures measure_row(measurer *m, workload *w);
