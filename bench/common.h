/* What the experiments on the methods share. Read in this order:
 *
 *   common_pixels.c  which pixels are compared: one of each block of a picture, and random points for gathers
 *   common_store.c   their reference values by the path tracer, in two independent halves, kept on disk
 *   common_error.c   errors, with the reference's own noise taken off
 *   common_curve.c   speed against error: envelopes, and drawings
 *   common_report.c  options, tables as Markdown and CSV, pictures
 *
 * A picture's error needs a reference with far less noise than the picture has error. For every pixel that is
 * hours of path tracing; for one pixel in sixty-four it is minutes, and tells the mean square error of the
 * whole as well. */
#ifndef SL_BENCH_COMMON_H
#define SL_BENCH_COMMON_H

#include <stdio.h>

#include "cache/hemisphere/gather.h"
#include "cache/frame/method.h"

/* ---- options and output (bench_report.c) ---- */

typedef struct bench_options {
    bool brief;            /* small pictures, few samples: does everything work? Its figures say little */
    bool once;             /* everything is measured once, with one thread: for a busy machine */
    bool pictures;         /* writes pictures too */
    const char *only;      /* scenes whose name holds this text, or, after a '=', is this; NULL: all */
    const char *rows;      /* the same for settings */
    uint32_t samples;      /* of references; 0: as many as the experiment has */
    size_t points;         /* of table 1; 0: as many as the paper */
    int size;              /* of pictures of whole scenes, pixels a side; 0: as the experiment has it */
    char folder[512];      /* for tables and pictures */
} bench_options;

/* folder: where tables go unless --out names another. */
bench_options bench_options_parse(int argc, char **argv, const char *folder);
bool bench_wants(const bench_options *o, const char *scene);
bool bench_wants_row(const bench_options *o, const char *setting);
/* Ends the program. */
_Noreturn void bench_fail(const char *what, const sl_error *error);

typedef struct bench_report {
    FILE *text, *table;    /* NAME.md; NAME-TABLE.csv, or NULL */
    char folder[512], name[64];
    int widths[32];
    const char *error_axis; /* what drawings call their errors; NULL: relMSE */
} bench_report;

void bench_report_open(bench_report *r, const bench_options *o, const char *name);
void bench_report_close(bench_report *r);
__attribute__((format(printf, 2, 3))) void bench_say(bench_report *r, const char *format, ...);
/* Cells are separated by '|'. A table ends with the next, or the report. */
void bench_table(bench_report *r, const char *table, const char *header);
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
/* Leaves those whose surface is glossy. */
void bench_pixels_keep_glossy(const sl_scene *scene, const sl_tracer *tracer, bench_pixels *pixels);
/* What a pixel's centre shows, as a point for a gather; false where that is nothing. */
bool bench_pixel_surface(const sl_scene *scene, const sl_tracer *tracer, const bench_pixels *pixels, size_t i,
                         sl_surface *surface, uint32_t *triangle);
void bench_pixels_free(bench_pixels *pixels);
/* The ray through a pixel's centre. */
void bench_camera_ray(const sl_scene *scene, int width, int height, uint32_t pixel, sl_ray16 *rays,
                      unsigned lane);
/* Up to `count` points that the camera sees in random places of the film, on surfaces that reflect. Returns
 * how many. */
size_t bench_visible_points(const sl_scene *scene, const sl_tracer *tracer, size_t count,
                            sl_gather_point *points);

/* ---- references (common_store.c) ---- */

/* The mean radiance of two independent halves of `samples` paths in all: 3 values a pixel. */
typedef struct bench_reference {
    size_t count;
    uint32_t samples;
    float *half[2];
} bench_reference;

/* From build/references/, by what it depends on: scene, transport, pixels, samples; made where it is not
 * there. */
void bench_reference_get(const sl_scene *scene, const sl_tracer *tracer, const sl_transport *transport,
                         const bench_pixels *pixels, uint32_t samples, bench_reference *reference);
/* a + b, of the same pixels. */
void bench_reference_sum(const bench_reference *a, const bench_reference *b, bench_reference *sum);
void bench_reference_free(bench_reference *reference);
/* For whatever else is worth keeping: floats under a name made of a word and a hash. False where there is
 * nothing. */
bool bench_store_load(const char *word, uint64_t hash, size_t count, float *values);
void bench_store_save(const char *word, uint64_t hash, size_t count, const float *values);
uint64_t bench_hash(uint64_t hash, const void *bytes, size_t size);

/* ---- errors (bench_error.c) ---- */

/* x = picture; A, B = halves of the reference; r = (A + B) / 2; s = what errors are relative to. The halves
 * are independent, so mean (x-A)(x-B) is the squared error without their noise. */
typedef struct bench_error {
    double rel_mse;        /* mean((x-A)(x-B) / (s^2 + 0.01 mean(s)^2)) */
    double rel_mse_spread; /* its standard error, over the pixels */
    double noise;          /* the reference's share of a plain relMSE: mean((A-B)^2 / 4 / (s^2 + ...)) */
    double trimmed;        /* rel_mse without the pixels of the largest 0.1 % */
    double rel_rmse;       /* sqrt(mean (x-A)(x-B)) / mean(s); 0 where noise outweighs it */
    double bias;           /* sum(x-r) / sum(s) */
    bool noisy;            /* noise > rel_mse / 10: too noisy a reference to be relied on */
} bench_error;

/* x: 3 values a pixel. scale: the reference that errors are relative to, NULL for the same. */
bench_error bench_compare(const float *x, const bench_reference *reference, const bench_reference *scale);
/* "1.23e-05", or "(1.23e-05)" where it is not to be relied on. */
const char *bench_mse_text(const bench_error *e, char text[32]);

/* ---- speed against error (common_curve.c) ---- */

enum { BENCH_POINTS = 128 };
typedef struct bench_point {
    double seconds, rel_mse;
    char what[64];
} bench_point;
typedef struct bench_series {
    const char *name, *color; /* name: NULL is left out of the drawing's legend */
    bool line;                /* points are joined */
    size_t count;
    bench_point point[BENCH_POINTS];
} bench_series;

/* Those than which none is both faster and better, in order of their seconds. */
bench_series bench_envelope(const bench_series *all);
/* Seconds at an error, or error at seconds: log-log between neighbours, never beyond the ends (then 0). */
double bench_between(const bench_series *series, double at, bool seconds_wanted);
/* NAME-SCENE.svg, NAME the report's. */
void bench_draw_curves(const bench_report *r, const char *scene, const bench_series *series, size_t count);

/* ---- pictures ---- */

/* A PNG in the report's folder: SCENE-WHAT.png. */
void bench_write_picture(const bench_report *r, const char *scene, const char *what, const sl_image *image);
/* The chosen pixels' values of the layers PREFIX.R, PREFIX.G, PREFIX.B (NULL: R, G, B); false where the image
 * has none. */
bool bench_pick(const sl_image *image, const char *prefix, const bench_pixels *pixels, float *values);

#endif
