/* Parts of the experiments that no trial of softlux bench can measure: pixels that are compared, random
 * points for gathers, options, scenes, and tables as Markdown on stdout. */
#pragma once

#include <stdio.h>

#include "cache/hemisphere/gather.h"
#include "cache/frame/method.h"

/* ---- options and output (common_report.c) ---- */

typedef struct bench_options {
    bool brief;            /* small pictures, few samples: does everything work? Its figures say little */
    const char *only;      /* scenes whose name holds this text, or, after a '=', is this; NULL: all */
    size_t points;         /* of table 1; 0: as many as the paper */
} bench_options;

bench_options bench_options_parse(int argc, char **argv);
bool bench_wants(const bench_options *o, const char *scene);
/* Ends the program; so does a check unless all went well. */
_Noreturn void bench_fail(const char *what);
void bench_check(sl_status status, const sl_error *error);
void *bench_allocate(size_t count, size_t size);

/* Prints the head of a table, as sl_report_head(). */
void bench_table(const char *columns);
/* Prints a row; cells stand between bars. */
__attribute__((format(printf, 1, 2))) void bench_row(const char *format, ...);

/* ---- scenes ---- */

/* Loads, and makes the generated ones if they are not there yet. False, having said so, where files are
 * missing. */
bool bench_open_scene(const char *path, sl_scene **scene);
/* "atrium" of "scenes/generated/atrium.json". */
void bench_scene_name(const char *path, char name[64]);

/* ---- pixels and points (common_pixels.c) ---- */

typedef struct bench_pixels {
    int width, height, block;
    size_t count;
    uint32_t *index;       /* row 0 at the top */
} bench_pixels;

/* One pixel of each block x block, chosen at random and always alike, unless it shows no geometry, a lamp or
 * an edge. */
void bench_pixels_make(const sl_scene *scene, const sl_tracer *tracer, int width, int height, int block,
                       bench_pixels *pixels);
void bench_pixels_free(bench_pixels *pixels);
/* Up to `count` points that the camera sees in random places of the film, on surfaces that reflect. Returns
 * how many. */
size_t bench_visible_points(const sl_scene *scene, const sl_tracer *tracer, size_t count,
                            sl_gather_point *points);
