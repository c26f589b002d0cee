/* What the five experiments on radiance cache splatting share. Read in this order:
 *
 *   splat_pixels.c   which pixels are compared: one of each block of a picture, and random points for gathers
 *   splat_store.c    their reference values by the path tracer, in two independent halves, kept on disk
 *   splat_error.c    errors, with the reference's own noise taken off
 *   splat_render.c   a picture, with the seconds of each of its parts
 *   splat_report.c   tables as Markdown and CSV
 *
 * A picture's error needs a reference with far less noise than the picture has error. For every pixel that is hours of path tracing;
 * for one pixel in sixty-four it is minutes, and tells the mean square error of the whole as well. */
#ifndef SL_BENCH_SPLAT_H
#define SL_BENCH_SPLAT_H

#include <stdio.h>

#include "cache/gather/gather.h"
#include "cache/method.h"
#include "cache/splatting/splatting.h"

/* ---- options and output (splat_report.c) ---- */

typedef struct splat_options {
    bool brief;            /* small pictures, few samples: does everything work? Its figures say little */
    bool once;             /* everything is measured once, with one thread: for a busy machine */
    bool pictures;         /* writes pictures too */
    const char *only;      /* scenes whose name holds this text; NULL: all */
    char folder[512];      /* for tables and pictures */
} splat_options;

splat_options splat_options_parse(int argc, char **argv);
bool splat_wants(const splat_options *o, const char *scene);
/* Ends the program. */
void splat_stop(const char *what, const sl_error *error);

typedef struct splat_report {
    FILE *text, *table;    /* NAME.md; NAME-TABLE.csv, or NULL */
    char folder[512], name[64];
    int widths[32];
} splat_report;

void splat_report_open(splat_report *r, const splat_options *o, const char *name);
void splat_report_close(splat_report *r);
__attribute__((format(printf, 2, 3))) void splat_say(splat_report *r, const char *format, ...);
/* Cells are separated by '|'. A table ends with the next, or the report. */
void splat_table(splat_report *r, const char *table, const char *header);
__attribute__((format(printf, 2, 3))) void splat_row(splat_report *r, const char *format, ...);

/* ---- scenes ---- */

/* Loads, and makes the generated ones if they are not there yet. False, having said so, where files are missing. */
bool splat_open_scene(splat_report *r, const char *path, sl_scene **scene);
/* "atrium" of "scenes/generated/atrium.json". */
void splat_scene_name(const char *path, char name[64]);

/* ---- pixels and points (splat_pixels.c) ---- */

typedef struct splat_pixels {
    int width, height, block;
    size_t count, empty;   /* empty: blocks whose pixel shows no geometry, a lamp or an edge; left out */
    uint32_t *index;       /* row 0 at the top */
} splat_pixels;

/* One pixel of each block x block, chosen at random and always alike. */
void splat_pixels_make(const sl_scene *scene, const sl_tracer *tracer, int width, int height, int block, splat_pixels *pixels);
/* Leaves those whose surface is glossy. */
void splat_pixels_keep_glossy(const sl_scene *scene, const sl_tracer *tracer, splat_pixels *pixels);
/* What a pixel's centre shows, as a point for a gather; false where that is nothing. */
bool splat_pixel_surface(const sl_scene *scene, const sl_tracer *tracer, const splat_pixels *pixels, size_t i, sl_surface *surface,
                         uint32_t *triangle);
void splat_pixels_free(splat_pixels *pixels);
/* The ray through a pixel's centre. */
void splat_camera_ray(const sl_scene *scene, int width, int height, uint32_t pixel, sl_ray16 *rays, unsigned lane);
/* Up to `count` points that the camera sees in random places of the film, on surfaces that reflect. Returns how many. */
size_t splat_visible_points(const sl_scene *scene, const sl_tracer *tracer, size_t count, sl_gather_point *points);

/* ---- references (splat_store.c) ---- */

/* The mean radiance of two independent halves of `samples` paths in all: 3 values a pixel. */
typedef struct splat_reference {
    size_t count;
    uint32_t samples;
    float *half[2];
} splat_reference;

/* From build/references/, by what it depends on: scene, transport, pixels, samples; made where it is not there. */
void splat_reference_get(const sl_scene *scene, const sl_tracer *tracer, const sl_transport *transport, const splat_pixels *pixels,
                         uint32_t samples, splat_reference *reference);
/* a + b, of the same pixels. */
void splat_reference_sum(const splat_reference *a, const splat_reference *b, splat_reference *sum);
void splat_reference_free(splat_reference *reference);
/* For whatever else is worth keeping: floats under a name made of a word and a hash. False where there is nothing. */
bool splat_store_load(const char *word, uint64_t hash, size_t count, float *values);
void splat_store_save(const char *word, uint64_t hash, size_t count, const float *values);
uint64_t splat_hash(uint64_t hash, const void *bytes, size_t size);

/* ---- errors (splat_error.c) ---- */

/* x = picture; A, B = halves of the reference; r = (A + B) / 2; s = what errors are relative to. The halves are independent, so
 * mean (x-A)(x-B) is the squared error without their noise. */
typedef struct splat_error {
    double rel_mse;        /* mean((x-A)(x-B) / (s^2 + 0.01 mean(s)^2)) */
    double rel_mse_spread; /* its standard error, over the pixels */
    double noise;          /* the reference's share of a plain relMSE: mean((A-B)^2 / 4 / (s^2 + ...)) */
    double trimmed;        /* rel_mse without the pixels of the largest 0.1 % */
    double rel_rmse;       /* sqrt(mean (x-A)(x-B)) / mean(s); 0 where noise outweighs it */
    double bias;           /* sum(x-r) / sum(s) */
    bool noisy;            /* noise > rel_mse / 10: too noisy a reference to be relied on */
} splat_error;

/* x: 3 values a pixel. scale: the reference that errors are relative to, NULL for the same. */
splat_error splat_compare(const float *x, const splat_reference *reference, const splat_reference *scale);
/* "1.23e-05", or "(1.23e-05)" where it is not to be relied on. */
const char *splat_mse_text(const splat_error *e, char text[32]);

/* ---- pictures with the seconds of their parts (splat_render.c) ---- */

/* Records and splats stand for each class of receivers: + SL_RECEIVES_IRRADIANCE, + SL_RECEIVES_RADIANCE. */
enum {
    SPLAT_SETUP,
    SPLAT_GBUFFER,
    SPLAT_DIRECT,
    SPLAT_RECORDS,
    SPLAT_SPLATS = SPLAT_RECORDS + SL_RECEIVER_CLASSES,
    SPLAT_COMPOSE = SPLAT_SPLATS + SL_RECEIVER_CLASSES,
    SPLAT_PARTS
};

typedef struct splat_run {
    double cpu[SPLAT_PARTS], cpu_all; /* processor seconds of one thread */
    double wall_one, wall_two;        /* seconds by a clock with one thread and with two (0: not measured) */
    size_t records[SL_RECEIVER_CLASSES];
    sl_counters counters;
    sl_image *image;
} splat_run;

/* Splatting. Processor time is that of one thread: two would be charged for waiting for each other too. The run of the median of three,
 * or fewer where they take long; the clock's seconds likewise. once: one run with one thread. */
void splat_render(const sl_scene *scene, const sl_settings *settings, bool once, splat_run *run);
void splat_run_free(splat_run *run);
/* settings with nothing left to quality, scene or machine, as sl_method_create() makes them. */
sl_settings splat_settings_complete(const sl_scene *scene, const sl_settings *settings);
void splat_write_picture(const splat_report *r, const char *scene, const char *what, const sl_image *image);
/* The chosen pixels' values of the layers PREFIX.R, PREFIX.G, PREFIX.B (NULL: R, G, B); false where the image has none. */
bool splat_pick(const sl_image *image, const char *prefix, const splat_pixels *pixels, float *values);

#endif
