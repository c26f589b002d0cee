/* Shared by the parts of direct light. Read in this order:
 *
 *     direct.c          what is made once; what each pixel is
 *     direct_rays.c     the passes over a strip
 *     direct_exact.c    emitters: closed forms for all of their light, rays for the visible share
 *     direct_sampled.c  lights without extent; what is too much for closed forms
 *     direct_mapped.c   all lights by shadow maps, where there are any: none of the passes above
 *     direct_glossy.c   glossy lobes
 *     direct_lamps.c    emitters as a glossy lobe sees them
 *     direct_filter.c   the visible share, smoothed where it is noise
 *     light_kernels.c   the loops over a block of points
 */
#pragma once

#include "cache/light/light_kernels.h"
#include "cache/light/direct.h"
#include "cache/light/near_light.h"
#include "trace/bsdf.h"
#include "trace/sequence.h"

/* beyond, the closed form of all costs more than the noise that it saves */
enum { SL_EXACT_EMITTERS_MAX = 256 };

struct sl_direct {
    const sl_scene *scene;
    const sl_tracer *tracer;
    sl_direct_settings settings;
    sl_shadow_maps *own_maps;       /* those of the settings, or NULL */
    sl_isa isa;
    float offset;                   /* how far along the geometric normal rays start */
    /* the scene without its lights without extent, its environment the sun alone */
    sl_scene extended;
    sl_light_sampler *sampler;      /* of that; NULL where there is nothing to sample */
    /* of emitters that are lit by the closed form; none: emitters are sampled */
    sl_light_sides sides;
    sl_sequence sequence;           /* of a film's pixels */
    bool glossy;                    /* the scene has glossy materials */
    bool interleaves;
};

/* Pixels that reflect light, one after the other: at most SL_LIGHT_BLOCK. */
typedef struct sl_lit_block {
    size_t count;
    uint32_t pixel[SL_LIGHT_BLOCK];  /* in the G-buffer */
    uint32_t triangle[SL_LIGHT_BLOCK];
    float x[SL_LIGHT_BLOCK], y[SL_LIGHT_BLOCK], z[SL_LIGHT_BLOCK];
    float geometric_x[SL_LIGHT_BLOCK], geometric_y[SL_LIGHT_BLOCK], geometric_z[SL_LIGHT_BLOCK];
    float normal_x[SL_LIGHT_BLOCK], normal_y[SL_LIGHT_BLOCK], normal_z[SL_LIGHT_BLOCK];
    uint32_t rank[SL_LIGHT_BLOCK];   /* of the pixel in its tile of SL_SAMPLE_TILE pixels */
    uint64_t tile_key[SL_LIGHT_BLOCK];
} sl_lit_block;

enum { SL_SAMPLE_TILE = 8 };

/* Light samples of a pixel in the scene's sub-frame. */
uint32_t sl_direct_samples(const sl_direct *direct);
sl_light_points sl_lit_points(const sl_lit_block *block);
void sl_lit_block_add(const sl_direct *direct, const sl_gbuffer *gbuffer, size_t pixel, sl_lit_block *block);

/* Sums for the pixels of a strip and the rows around it. Irradiance, but for glossy. */
typedef struct sl_direct_sums {
    size_t first, count;    /* pixels [first, first + count) of the G-buffer */
    float *exact[3];        /* emitters, unoccluded, in units: their samples are of the next two */
    float *seen[3], *all[3]; /* in units */
    float *plain[3];        /* of which nothing is known but samples */
    float *glossy[3];       /* radiance */
    /* of every other sample, the three channels together: one half of the samples, which against the */
    float *odd_seen;
    float *odd_all;         /* other half shows how much they scatter */
    float *samples;         /* how many of `all`, and */
    /* 1: some, but not all, of the first samples were seen, or none lies where light comes from */
    float *partly;
    float *scatter;         /* variance of the visible share, as the two halves of the samples tell it */
    float *light[3];        /* the visible share, then radiance */
    float *block;           /* holds all of the above */
} sl_direct_sums;

/* Samples of a pixel: numbers [first, end). The first pass begins at 0, refinement goes on from there. */
typedef struct sl_sample_range {
    uint32_t first, end;
} sl_sample_range;

/* Streams of random numbers: for emitters' visible shares, which may be smoothed; the sun; emitters that are
 * sampled; lamps in a glossy lobe; its directions. */
enum { SL_STREAM_SHARES, SL_STREAM_SUN, SL_STREAM_EMITTERS, SL_STREAM_LAMPS, SL_STREAM_LOBE };

/* Three numbers in [0,1) for each sample of each point: those of a sample stride after those of the one
 * before. */
void sl_direct_points(const sl_direct *direct, const sl_lit_block *block, sl_sample_range range,
                      uint64_t stream, size_t stride, float *u0, float *u1, float *u2);

/* Two for a sample of point i; better spread, where two do. */
void sl_direct_point_2d(const sl_direct *direct, const sl_lit_block *block, size_t i, uint32_t sample,
                        uint64_t stream, float u[2]);

/* Aims of shadow rays: from the point to the light itself, or a direction. */
typedef struct sl_aims {
    const float *x, *y, *z;
    bool far_away;
} sl_aims;

/* Shadow rays of some lanes, in an order of neighbours; lane i belongs to point i modulo SL_LIGHT_BLOCK.
 * visible: 1 or 0. */
void sl_direct_trace(const sl_direct *direct, const sl_lit_block *block, size_t count, const uint32_t *lanes,
                     sl_aims aims, float *visible, sl_counters *counters);
/* The same for the points of a block, where wanted is > 0; 0 where not. */
void sl_direct_visible(const sl_direct *direct, const sl_lit_block *block, sl_aims aims, const float *wanted,
                       float *visible, sl_counters *counters);

/* ---- emitters as a glossy lobe sees them (direct_lamps.c) ---- */

/* A side of an emitter, above the horizon. */
typedef struct sl_lamp {
    uint32_t side;
    sl_seen_triangle seen;          /* without parts where it is sampled by its area */
    /* the sum of the importances up to and with this one; this one's share of all */
    float sum, chance;
} sl_lamp;

typedef struct sl_lamps {
    const sl_direct *direct;
    sl_vec3 position;
    size_t count;
    double solid_angle;             /* of all lamps */
    float closest;                  /* the lobe's largest value on any of them, 1 at its axis */
    sl_lamp lamp[SL_EXACT_EMITTERS_MAX];
} sl_lamps;

/* All that the lobe of a surface may see. False: none. */
bool sl_lamps_look(const sl_direct *direct, const sl_bsdf *lobe, sl_vec3 position, sl_lamps *lamps);
/* A sample from two numbers in [0,1); as of sl_light_sampler_sample_2d(). */
bool sl_lamps_draw(const sl_lamps *lamps, const float u[2], sl_light_sample *sample);
/* The density with which that would have drawn the direction that hit this triangle of an emitter. */
float sl_lamps_pdf(const sl_lamps *lamps, sl_vec3 direction, uint32_t triangle, float distance);

/* ---- a worker's memory ---- */

/* Sides that light some pixel of a block. */
typedef struct sl_weighed_sides {
    size_t sides;
    uint32_t side[SL_EXACT_EMITTERS_MAX];
    float share[SL_EXACT_EMITTERS_MAX * SL_LIGHT_BLOCK]; /* irradiance for radiance 1 */
    float sums[SL_EXACT_EMITTERS_MAX * SL_LIGHT_BLOCK];  /* cumulative, in luminance */
} sl_weighed_sides;

enum { SL_LIGHT_CHUNK = 8, SL_SAMPLE_LANES = SL_LIGHT_CHUNK * SL_LIGHT_BLOCK };

/* Some samples of every pixel of the block, sample by sample: SL_LIGHT_BLOCK lanes each. */
typedef struct sl_block_samples {
    uint32_t samples;
    float u0[SL_SAMPLE_LANES], u1[SL_SAMPLE_LANES], u2[SL_SAMPLE_LANES];
    int32_t chosen[SL_SAMPLE_LANES];
    float x[SL_SAMPLE_LANES], y[SL_SAMPLE_LANES], z[SL_SAMPLE_LANES];
    float r[SL_SAMPLE_LANES], g[SL_SAMPLE_LANES], b[SL_SAMPLE_LANES];
    float weight[SL_SAMPLE_LANES], wanted[SL_SAMPLE_LANES], visible[SL_SAMPLE_LANES];
} sl_block_samples;

/* For a block; too large for a thread's stack: a third of a megabyte. Not set. */
typedef struct sl_direct_scratch {
    sl_weighed_sides weighed;
    sl_block_samples samples;
    uint32_t order[SL_SAMPLE_LANES];
    sl_lamps lamps;
} sl_direct_scratch;

/* ---- the parts ---- */

void sl_direct_exact(const sl_direct *direct, const sl_lit_block *block, sl_sample_range range,
                     sl_direct_scratch *scratch, sl_direct_sums *sums, sl_counters *counters);
void sl_direct_delta(const sl_direct *direct, const sl_gbuffer *gbuffer, const sl_lit_block *block,
                     sl_direct_sums *sums, sl_counters *counters);
/* Rows [row, end), all light. */
sl_status sl_direct_mapped_rows(const sl_direct *direct, const sl_gbuffer *gbuffer, int row, int end,
                                float *const radiance[3], sl_counters *counters, sl_error *error);
/* Adds what a pixel's glossy lobe reflects, if it has one, to glossy[c][p]. */
void sl_direct_add_lobe(const sl_direct *direct, const sl_gbuffer *gbuffer, size_t pixel, sl_vec3 to_light,
                        sl_rgb irradiance, float *const glossy[3], size_t p);
/* Of the sun, or of emitters. */
void sl_direct_sampled(const sl_direct *direct, const sl_lit_block *block, bool sun, sl_direct_sums *sums,
                       sl_counters *counters);
/* One pixel's glossy lobe and lights with extent; exact: luminance of their unoccluded irradiance, 0: not
 * known. */
sl_rgb sl_direct_lobe(const sl_direct *direct, const sl_gbuffer *gbuffer, size_t pixel, float exact,
                      uint32_t samples, sl_direct_scratch *scratch, sl_counters *counters);
/* Scatter of sums [first, first + count). */
void sl_direct_find_scatter(const sl_direct_sums *sums, size_t first, size_t count);
/* The visible share of pixels of one row, smoothed or as it is: into the planes of light. */
void sl_direct_filter_run(const sl_direct_sums *sums, const sl_gbuffer *gbuffer, int row, sl_pixel_run run,
                          bool smoothed);

/* Tells whether a plane of the sums is > 0 within `radius` columns and rows of a pixel. */
bool sl_direct_is_near(const sl_direct_sums *sums, const float *plane, const sl_gbuffer *gbuffer,
                       size_t pixel, int radius);

/* The lobe of a pixel that reflects light, towards whom it is seen by. */
sl_bsdf sl_pixel_lobe(const sl_direct *direct, const sl_gbuffer *gbuffer, size_t pixel);
bool sl_pixel_reflects(const sl_gbuffer *gbuffer, const sl_scene *scene, size_t pixel);
bool sl_pixel_is_glossy(const sl_gbuffer *gbuffer, const sl_scene *scene, size_t pixel);
