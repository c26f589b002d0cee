/* What experiments share that no trial of softlux bench can measure:
 *
 *   common_pixels.c  which pixels are compared: one of each block of a picture, and random points for gathers
 *   common_store.c   what was dear to compute, kept on disk
 *   common_report.c  options, tables as Markdown, curves of speed against error
 */
#ifndef SL_BENCH_COMMON_H
#define SL_BENCH_COMMON_H

#include <stdio.h>

#include "cache/hemisphere/gather.h"
#include "cache/frame/method.h"

/* ---- options and output (bench_report.c) ---- */

typedef struct bench_options {
    bool brief;            /* small pictures, few samples: does everything work? Its figures say little */
    const char *only;      /* scenes whose name holds this text, or, after a '=', is this; NULL: all */
    size_t points;         /* of table 1; 0: as many as the paper */
    char folder[512];      /* for tables and pictures */
} bench_options;

/* folder: where tables go unless --out names another. */
bench_options bench_options_parse(int argc, char **argv, const char *folder);
bool bench_wants(const bench_options *o, const char *scene);
/* Ends the program. */
_Noreturn void bench_fail(const char *what, const sl_error *error);

typedef struct bench_report {
    FILE *text; /* NAME.md */
    int widths[32];
} bench_report;

void bench_report_open(bench_report *r, const bench_options *o, const char *name);
void bench_report_close(bench_report *r);
__attribute__((format(printf, 2, 3))) void bench_say(bench_report *r, const char *format, ...);
/* Cells are separated by '|'. */
void bench_table(bench_report *r, const char *header);
__attribute__((format(printf, 2, 3))) void bench_row(bench_report *r, const char *format, ...);

/* ---- scenes ---- */

/* Loads, and makes the generated ones if they are not there yet. False, having said so, where files are
 * missing. */
bool bench_open_scene(bench_report *r, const char *path, sl_scene **scene);
/* "atrium" of "scenes/generated/atrium.json". */
void bench_scene_name(const char *path, char name[64]);

/* ---- pixels and points (bench_pixels.c) ---- */

typedef struct bench_pixels {
    int width, height, block;
    size_t count, empty;   /* empty: blocks whose pixel shows no geometry, a lamp or an edge; left out */
    uint32_t *index;       /* row 0 at the top */
} bench_pixels;

/* One pixel of each block x block, chosen at random and always alike. */
void bench_pixels_make(const sl_scene *scene, const sl_tracer *tracer, int width, int height, int block,
                       bench_pixels *pixels);
void bench_pixels_free(bench_pixels *pixels);
/* The ray through a pixel's centre. */
void bench_camera_ray(const sl_scene *scene, int width, int height, uint32_t pixel, sl_ray16 *rays,
                      unsigned lane);
/* Up to `count` points that the camera sees in random places of the film, on surfaces that reflect. Returns
 * how many. */
size_t bench_visible_points(const sl_scene *scene, const sl_tracer *tracer, size_t count,
                            sl_gather_point *points);

/* ---- what is kept (common_store.c) ---- */

/* Floats in build/references/ under a name made of a word and a hash. False where there is
 * nothing. */
bool bench_store_load(const char *word, uint64_t hash, size_t count, float *values);
void bench_store_save(const char *word, uint64_t hash, size_t count, const float *values);
uint64_t bench_hash(uint64_t hash, const void *bytes, size_t size);

/* ---- speed against error (common_report.c) ---- */

enum { BENCH_POINTS = 128 };
typedef struct bench_point {
    double seconds, rel_mse;
} bench_point;
typedef struct bench_series {
    size_t count;
    bench_point point[BENCH_POINTS];
} bench_series;

/* Seconds at an error, or error at seconds: log-log between neighbours, never beyond the ends (then 0). */
double bench_between(const bench_series *series, double at, bool seconds_wanted);
#endif
