/* Irradiance at a point: the sum over a picture of the hemisphere, by one of three instruments,
 *
 *   plane     one N x N raster render of the plane at unit distance above the point, 140 degrees, borders
 *             extended to the horizon
 *   hemicube  five raster renders, N x N and four halves
 *   rays      N x N rays in the cells of the concentric map, equal cosine weights
 *
 * each with harmonic mean distance, rotational and translational gradients (Ward et al. 1988, Ward and
 * Heckbert 1992). What is seen is shaded with direct light (one diffuse bounce), and with what
 * sl_gather_settings.second has to say of light that arrives there by more bounces. */
#pragma once

#include "raster/raster.h"
#include "cache/hemisphere/known_colours.h"
#include "cache/light/shadow_maps.h"
#include "trace/trace.h"

/* Radiance between the plane's picture and the horizon: the mean of the picture [LC04], or the outermost
 * pixels' along the meridians; or none, beside which table 1 of Gautron et al. 2005 sets the two. */
typedef enum sl_border { SL_BORDER_LC04, SL_BORDER_RADIAL, SL_BORDER_PLAIN } sl_border;

typedef struct sl_second_points {
    size_t count;
    const uint32_t *triangle;
    const float *position_x, *position_y, *position_z;
    const float *normal_x, *normal_y, *normal_z;
} sl_second_points;

/* Light that surfaces seen by gathers receive besides direct light: with more than one bounce, the irradiance
 * of the bounce before. Adds it to r, g, b at `count` points with unit shading normals; points whose triangle
 * is SL_NO_INDEX are nowhere. Thread-safe. What is added to a point that no record reaches is by the points
 * next to it in the order given; missed, if not NULL, tells which these are. */
typedef struct sl_second_light {
    const void *context;
    void (*irradiance)(const void *context, const sl_second_points *points, float *r, float *g, float *b,
                       bool *missed, sl_counters *counters);
} sl_second_light;

typedef struct sl_gather_settings {
    sl_gather_kind kind;      /* not AUTO */
    int size;                 /* N */
    float plane_fov;          /* radians; 140 degrees by default */
    sl_border border;         /* plane only; RADIAL by default */
    bool jitter;              /* rays: jittered inside their cells */
    /* rays, jittered: how many more of them, in N^2, go where radiance varies; 0: none, at most 4 */
    float more_rays;
    /* emitters and the environment are seen by the gather; off where the direct pass samples them */
    bool emission;
    const sl_environment *background; /* seen even where emission is off, the sky whose light the cache
                                         carries; or NULL. It must outlive the gather */
    uint32_t hit_samples;     /* shadow rays: light samples a hit; 0 counts as 1, the default */
    const sl_shadow_maps *maps; /* that light what is seen, and must outlive the gather; NULL: shadow rays */
    /* shadow rays: glossy lobes of what is seen reflect light, too, of `second` as if they were diffuse; and
     * mirrors show what they reflect, lamps in */
    bool all_lobes;
    const sl_second_light *second; /* more light on what is seen, or NULL; must outlive the gather */
    /* what is seen nearer than that, or is missed by `second`, is lit by a ray that goes on from there; 0:
     * nothing is */
    float onward_reach;
    uint64_t seed;
    /* plane, N a power of two from SL_GATHER_COLOURED_LEAST on: the colours of all surfaces, to be summed as
     * they are by sl_gather_known_colours(); or NULL. Both tables must outlive the gather */
    const sl_lattice_colours *colours;
    /* n: gathers also yield n^2 coefficients of incoming radiance; 0: irradiance alone */
    int harmonics_order;
} sl_gather_settings;

sl_gather_settings sl_gather_defaults(void);

typedef struct sl_irradiance {
    sl_rgb value;                   /* E, W/m^2 */
    /* grad_r E per channel, world frame, W/m^2/rad: E(n') = E + (n x n') . grad_r */
    sl_vec3 rotational[3];
    sl_vec3 translational[3];       /* grad_t E per channel, world frame, tangential, W/m^3 */
    /* The greatest second derivative of the channels' mean along the tangent plane, by its absolute value,
     * W/m^4, occlusion included. */
    float curvature;
    /* cosine-weighted harmonic mean distance, m; infinite where nothing is seen */
    float harmonic_mean;
    /* min over hits of r / cos theta' (the guard's rho_min); infinite where nothing is seen */
    float nearest;
    /* share of the cosine weight that saw surfaces from their clockwise side */
    float back_share;
} sl_irradiance;

/* Everything that many gathers share: weight tables, light sampler. Immutable after creation.
 */
typedef struct sl_gather sl_gather;
/* raster may be NULL for rays; tracer may be NULL for raster gathers by maps or of known colours. */
sl_status sl_gather_create(const sl_scene *scene, const sl_raster *raster, const sl_tracer *tracer,
                           const sl_gather_settings *settings, unsigned threads, sl_gather **gather,
                           sl_error *error);
void sl_gather_destroy(sl_gather *gather);
size_t sl_gather_memory_bytes(const sl_gather *gather);

/* One worker's buffers. */
typedef struct sl_gather_scratch sl_gather_scratch;
sl_status sl_gather_scratch_create(const sl_gather *gather, sl_gather_scratch **scratch, sl_error *error);
void sl_gather_scratch_destroy(sl_gather_scratch *scratch);

/* A gather with what each worker needs for it; {0}: none. Where it cannot be created there is none. */
typedef struct sl_gathers {
    sl_gather *gather;
    sl_gather_scratch **scratch;
    unsigned threads;
} sl_gathers;
sl_status sl_gathers_create(const sl_scene *scene, const sl_raster *raster, const sl_tracer *tracer,
                            const sl_gather_settings *settings, unsigned threads, sl_gathers *gathers,
                            sl_error *error);
void sl_gathers_destroy(sl_gathers *gathers);

/* point: position, geometric normal on the side that is lit, shading normal, own triangle (SL_NO_INDEX:
 * none); key: a hash of seed and pixel that jitter and light samples are drawn from. Thread-safe with a
 * scratch for each thread. */
typedef struct sl_gather_point {
    sl_vec3 position, geometric_normal, normal;
    uint32_t triangle;
    uint64_t key;
} sl_gather_point;
void sl_gather_irradiance(const sl_gather *gather, const sl_gather_point *point, sl_gather_scratch *scratch,
                          sl_irradiance *irradiance, sl_counters *counters);

/* As sl_gather_irradiance(), of sl_gather_settings.second's light alone, by one ray a cell: no light samples.
 */
void sl_gather_second_irradiance(const sl_gather *gather, const sl_gather_point *point,
                                 sl_gather_scratch *scratch, sl_irradiance *irradiance,
                                 sl_counters *counters);
/* The points that the cells of that gather see, and their reflectances; owned by the scratch. */
typedef struct sl_gather_hits_seen {
    sl_second_points points;
    const float *diffuse[3]; /* k_d */
} sl_gather_hits_seen;
sl_gather_hits_seen sl_gather_last_hits(const sl_gather_scratch *scratch);

/* As sl_gather_irradiance(), and besides the radiance that comes in, as coefficients over the hemispherical
 * harmonics (cache/hemisphere/harmonics.h has their order) in the frame sl_frame_from_normal(normal): lambda
 * of R, G, B, then d lambda/dx of R, G, B, then d lambda/dy of R, G, B, each sl_hsh_stride(order) floats.
 * lambda = integral of L H d omega. */
void sl_gather_radiance(const sl_gather *gather, const sl_gather_point *point, sl_gather_scratch *scratch,
                        sl_irradiance *irradiance, float *coefficients, sl_counters *counters);

/* Returns irradiance alone, by the colours that the gather was made with: a pure function of the point and
 * the colours. The picture's frame is that of sl_known_colours_frame(). */
enum { SL_GATHER_COLOURED_LEAST = 8 };
sl_rgb sl_gather_known_colours(const sl_gather *gather, const sl_gather_point *point,
                               sl_gather_scratch *scratch, sl_counters *counters);

/* The picture of the last gather: N x N (plane, rays) or 2N x 2N with the side faces around the top
 * (hemicube), for observers and tests; radiance and distance planes owned by the scratch, bottom row first.
 */
typedef struct sl_gather_picture {
    int width, height;
    const float *r, *g, *b, *distance;
} sl_gather_picture;
sl_gather_picture sl_gather_last_picture(const sl_gather_scratch *scratch);
