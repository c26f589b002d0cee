/* Radiance cache splatting (Gautron, Krivanek, Bouatouch, Pattanaik 2005). Read in this order:
 *
 *   splatting.c      Algorithm 2: the passes of one picture
 *   plan.c           which passes a scene needs, and the qualities
 *   create.c         what it needs, made when it is needed
 *   edges.c          step 1: pixels at edges, looked at again by rays; which pixels ask for which records
 *   ../light/        step 1b: direct light of every pixel
 *   traversal.c      step 4: which pixels get new records, in which order, in parallel and yet as if alone
 *   record.c         a record and how far it reaches
 *   record_weight.h  its weight and what it says: equations (2), (3) and (8)
 *   record_walls.c   walls that stand within its reach
 *   record_batch.c   records for many points at once
 *   ages.c           records while objects and lights move
 *   ../bounces/      more than one bounce: the light that falls on what gathers see
 *   splat.c          steps 4 and 5: records onto the screen, and onto what is seen in mirrors (../reflect/)
 *   splat_kernels.c  Algorithm 1: one record's contribution to a pixel, its weight and irradiance
 *   glossy.c         the same for what a glossy lobe reflects of a radiance record
 *   compose.c        step 6: the picture and its layers
 *   keep.c           records on disk, for another run
 *   fill.c           step 6: pixels that have no record yet in an unfinished picture
 *   explanation.c    what made a pixel
 */
#pragma once

#include "cache/light/direct.h"
#include "cache/hemisphere/gather.h"
#include "cache/frame/method.h"
#include "cache/splatting/glossy.h"
#include "cache/reflect/reflect.h"
#include "cache/splatting/record_batch.h"

/* ---- step 1 ---- */

/* Pixels beside another surface than their own show what a ray through their middle finds. Depth stays. */
sl_status sl_look_at_edges(const sl_scene *scene, const sl_tracer *tracer, unsigned threads,
                           sl_gbuffer *gbuffer, sl_counters *counters, sl_error *error);

/* ---- pixels that show something by way of mirrors ---- */

/* Things seen in a mirror lie elsewhere than where the picture shows them, so the rectangle about a record's
 * sphere on the screen (step 1 of Algorithm 1) misses those pixels. All of them are looked at where the
 * sphere reaches the box of what they show. */
typedef struct sl_mirror_pixels {
    sl_splat_rect rect; /* of all such pixels; empty: no mirror is in sight */
    sl_box box;         /* about what they show */
} sl_mirror_pixels;

sl_mirror_pixels sl_mirror_pixels_find(const sl_gbuffer *gbuffer, const sl_reflections *reflections);
/* Returns a rectangle that holds `seen` and all pixels that show what the sphere reaches. */
sl_splat_rect sl_mirror_bounds(const sl_mirror_pixels *mirrors, sl_vec3 centre, float reach,
                               sl_splat_rect seen);

/* ---- which pixels get records ---- */

/* A pixel that is partly glossy is served by radiance records, of which the diffuse part takes the
 * irradiance. */
typedef enum sl_receiver_class {
    SL_RECEIVES_IRRADIANCE,
    SL_RECEIVES_RADIANCE,
    SL_RECEIVER_CLASSES
} sl_receiver_class;

typedef struct sl_record_list {
    sl_record *records;
    sl_reach_tree reaches;    /* of the same records */
    float *coefficients;      /* coefficient_count of the pass for each; NULL: irradiance records */
    size_t count, capacity;
} sl_record_list;

/* coefficients: coefficient_count of them, or NULL. */
sl_status sl_record_list_append(sl_record_list *list, const sl_record *record, const float *coefficients,
                                size_t coefficient_count, sl_error *error);
/* Rule 5 of record.h for all records: none grows; *shrunk: some are smaller. */
sl_status sl_record_list_clamp(sl_record_list *list, unsigned threads, bool *shrunk, sl_error *error);
void sl_record_list_clear(sl_record_list *list);
void sl_record_list_free(sl_record_list *list);

typedef struct sl_traversal {
    sl_traversal_order order;
    int width, height;
    int stride;               /* of the level being visited; 0: all visited */
    uint64_t columns, cells;  /* of the level's grid */
    uint64_t next, step;      /* cells visited; from one to the next, around the grid */
    uint64_t visited, total;  /* pixels */
    size_t batch;             /* candidates taken at once, adapted to how many turned out covered */
} sl_traversal;

/* Input of a traversal. */
typedef struct sl_record_pass {
    const sl_scene *scene;
    const sl_tracer *tracer;  /* or NULL: the guard alone keeps records from reaching through walls */
    const sl_gathers *gathers;
    const sl_gbuffer *gbuffer;
    sl_splat_receivers receivers;
    sl_weight_rules weights;
    sl_radius_rules radii;
    size_t coefficient_count; /* floats of one record's coefficients; 0: irradiance records */
    sl_glossy_view glossy;    /* used where coefficient_count > 0 */
    sl_isa isa;
    const sl_camera *camera;
    const sl_mirror_pixels *mirrors; /* or NULL */
    float near_distance, footprint_per_depth;
    float covered_weight;     /* w_min: a pixel whose sum of weights reaches it is covered */
    float *coverage;          /* sum of w, bottom row first */
    uint8_t *owned;           /* pixels that have a record of their own count as covered */
    uint64_t seed;
    unsigned threads;
} sl_record_pass;

void sl_traversal_start(sl_traversal *traversal, sl_traversal_order order, int width, int height);
/* The next batch of uncovered pixels, at most traversal->batch of them; returns how many. Done where
 * traversal->stride becomes 0. */
size_t sl_traversal_next(sl_traversal *traversal, const sl_record_pass *pass, size_t pixels[SL_BATCH_MAX]);
/* They get records, exactly as if they were visited one by one. */
sl_status sl_traversal_gather(sl_traversal *traversal, const sl_record_pass *pass, const size_t *pixels,
                              size_t count, sl_record_list *list, sl_counters *counters, sl_error *error);
/* Adds the records' weights to the coverage. */
sl_status sl_cover(const sl_record_pass *pass, const sl_record *records, size_t count, sl_error *error);
/* Step 5: records [first, count) of the list add (w E', w, 1), and radiance records what the glossy lobe
 * reflects. */
sl_status sl_splat_records(const sl_record_pass *pass, const sl_record_list *list, size_t first,
                           const sl_splat_buffer *buffer, sl_counters *counters, sl_error *error);
/* The record's weight at a pixel. */
float sl_record_weight(const sl_record_pass *pass, const sl_record *record, size_t pixel);

/* ---- the picture ---- */

/* R, G, B and the layers that they are the sum of; weight and number of records. The glossy layers come last,
 * and only where something can be glossy. */
enum { SL_LAYERS = 14, SL_LAYERS_GLOSSY = 17 };
extern const char *const sl_layer_names[SL_LAYERS_GLOSSY];

/* ---- fallback of an unfinished picture ---- */

/* Push-pull: where weight is 0 and the pixel receives, the mean of those around it that receive. The three
 * planes hold means, not sums. */
sl_status sl_fill_uncovered(int width, int height, const float *weight, const uint32_t *receives,
                            unsigned threads, float *const mean[3], sl_error *error);
