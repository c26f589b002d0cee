/* Shared by the parts of a gather, whose steps are
 *
 *     see      gather_see.c: which triangle, where, in every cell
 *     shade    hit_shading.c: outgoing radiance of what is seen, lit directly, and by more bounces
 *     sum      gather_kernels.c and gather.c: irradiance, gradients, mean distance
 *     project  projection.c: coefficients of radiance, where asked for
 */
#pragma once

#include "cache/hemisphere/gather_kernels.h"
#include "cache/hemisphere/gather_tables.h"
#include "cache/hemisphere/known_colours.h"
#include "cache/hemisphere/projection.h"
#include "cache/light/shadow_maps.h"

/* One worker's buffers for light samples (hit_samples.c): what is expected of every hit, samples as drawn,
 * and in order of their sources: the sides of emitters, then the sky. */
typedef struct sl_hit_sample {
    uint32_t slot, source;
    float share; /* 1 over the expected number of such samples */
} sl_hit_sample;

typedef struct sl_light_scratch {
    size_t slots, capacity;        /* of hits, and of samples */
    float *reflects;               /* by slot: albedo; 0 where nothing is seen */
    float *from;                   /* [source][slot]: irradiance that it may bring, in the gather's units */
    float *expected;               /* that of all */
    float *samples_at;             /* expected number of samples */
    size_t samples;
    sl_hit_sample *drawn, *sorted;
    uint32_t *of_source;
    void *block;                   /* of the planes of floats */
} sl_light_scratch;

struct sl_gather {
    const sl_scene *scene;
    const sl_raster *raster;
    const sl_tracer *tracer;
    sl_gather_settings settings;
    sl_gather_tables *tables;
    float half_tangent;
    /* eps: of the eye along the geometric normal; hits nearer than twice that do not count */
    float offset;
    sl_projection *projection;   /* onto hemispherical harmonics, or NULL */
    sl_isa isa;
    sl_lattice_colours colours;  /* known colours, in place of all that follows, or NULL */
    sl_texture_image *sky;       /* beside them: an environment that is a picture, or NULL */

    /* the scene without its lights without extent: what samples are drawn from */
    sl_scene extended;
    sl_light_sides sides;        /* emitters, where they are few: hits are weighed by what each gives */
    size_t sources;              /* these, and the environment behind them; 0: none, or the sampler's */
    float *strength;             /* by source: of emitters luminance in units, of the environment 1 */
    float unit;
    float sky_irradiance[6];     /* in units, on planes that face +x, -x, +y, -y, +z, -z */
    sl_light_sampler *sampler;   /* all that samples are drawn from, where they are many */
    bool glossy, mirrors;        /* settings.all_lobes, where the scene has any */
    bool every_light;            /* lights without extent are few: each lights every hit */
};

/* The end of a slot's ray behind mirrors (hit_mirrors.c). */
typedef struct sl_mirrored_hit {
    bool any;           /* the ray met a mirror */
    float cosine, back; /* of the first one, as in sl_gather_hits */
    sl_rgb share;       /* product of the mirrors' reflectances */
    sl_vec3 position;   /* of what is seen */
} sl_mirrored_hit;

/* Rays that go on from what is seen (hit_onward.c). */
typedef struct sl_onward {
    bool *missed;    /* by slot: no record of further light reaches it; NULL: nothing goes on */
    /* by slot: where rays are asked instead of records, what is reflected of the light that these tell, all
     * channels together, else 0 */
    float *told;
    size_t first;    /* slot that they end in; SIZE_MAX: none yet */
    size_t count;    /* slots that are marked, then those behind `first` */
    uint32_t *from;  /* by these: the slot that a ray goes on from, */
    sl_rgb *carried; /* and what is reflected there to the gather of what arrives by it */
} sl_onward;

struct sl_gather_scratch {
    const sl_gather *gather;
    void *block;             /* of the planes of floats, */
    uint32_t *ids;           /* and of whole numbers */
    size_t slots, slots_max;
    uint32_t *slot_cell;
    float *slot_share;       /* 1 over the rays of the slot's cell */
    /* slots beyond the cells: as slot_a, slot_b of the tables; and the jitter, 16 bits each */
    float *more_a, *more_b;
    uint32_t *more_bits;
    sl_gather_hits hits;
    sl_mirrored_hit *mirrored; /* by slot; NULL: mirrors are black */
    sl_onward onward;
    sl_gather_planes planes;
    sl_light_scratch *light; /* or NULL */
    sl_raster_scratch *raster;
    uint32_t *target_id;
    float *target_depth, *target_w1, *target_w2;
    uint32_t *pixels; /* 0, 1, 2, ... */
    const uint8_t **texel; /* by slot: of the surface's texture, or NULL */
    uint32_t *cell_id;
    float *cell_depth, *cell_w1, *cell_w2;
    float *weighted, *halved; /* known colours: three planes times weights, and halves of one */
};

/* The gather under way. */
typedef struct sl_gather_view {
    const sl_gather *gather;
    const sl_gather_point *point;
    sl_gather_scratch *scratch;
    sl_frame frame;
    sl_vec3 eye;
    bool second_alone; /* of light, what sl_gather_settings.second has to say */
} sl_gather_view;

/* The raster's near plane: what stands before the eye is seen however near it is, or light would come through
 * a sheet that the point touches. */
static inline float sl_gather_near(const sl_gather *gather) { return 1e-3f * gather->offset; }

sl_gather_view sl_gather_view_of(const sl_gather *gather, const sl_gather_point *point,
                                 sl_gather_scratch *scratch);
void sl_gather_see_raster(const sl_gather_view *view, sl_counters *counters);
/* Draws the plane: ids and weights of the cells; and 1 / depth, or NULL. */
void sl_gather_draw_plane(const sl_gather_view *view, float *depth, sl_counters *counters);
void sl_gather_see_rays(const sl_gather_view *view, sl_counters *counters);
/* Notes in slots from `first` on what up to sixteen rays meet. */
void sl_gather_trace_packet(const sl_gather_view *view, size_t first, unsigned count, const sl_ray16 *rays,
                            bool coherent, sl_counters *counters);
/* More rays where radiance varies; the first ones are there, lit by all that needs no samples (more_rays.c).
 */
void sl_gather_add_rays(const sl_gather_view *view, sl_counters *counters);
void sl_gather_see_more_rays(const sl_gather_view *view, sl_counters *counters);

/* Gives those of slots first to first + count that show a mirror what is seen in it. Directions become those
 * of the last part of the way, depths stay. */
void sl_gather_follow_mirrors(const sl_gather_view *view, size_t first, size_t count, sl_counters *counters);
/* Returns NULL where slot k shows no mirror. */
static inline const sl_mirrored_hit *sl_gather_mirrored(const sl_gather_view *view, size_t k) {
    const sl_mirrored_hit *m = view->scratch->mirrored;
    return m && m[k].any ? &m[k] : NULL;
}
static inline bool sl_gather_is_onward(const sl_gather_view *view, size_t k) {
    return k >= view->scratch->onward.first;
}
/* Returns what mirrors, and what its ray goes on from, leave of the light of slot k: 1 where neither is. */
static inline sl_rgb sl_gather_throughput(const sl_gather_view *view, size_t k) {
    const sl_onward *o = &view->scratch->onward;
    const sl_mirrored_hit *m = sl_gather_mirrored(view, k);
    const sl_rgb mirrored = m ? m->share : sl_grey(1.0f);
    return sl_gather_is_onward(view, k) ? sl_rgb_mul(mirrored, o->carried[k - o->first]) : mirrored;
}

/* Of so many slots, how many there may be besides that rays go on into; and room for them. False: no
 * memory. */
size_t sl_onward_most(size_t slots);
bool sl_onward_allocate(size_t slots, sl_onward *onward);
void sl_onward_free(sl_onward *onward);
/* Marks those of slots first to first + count whose further light rays are to ask for, and takes away what
 * they have. */
void sl_gather_mark_onward(const sl_gather_view *view, size_t first, size_t count);
/* Adds slots for those that are marked, and traces their rays; then places what these meet. */
void sl_gather_go_on(const sl_gather_view *view, sl_counters *counters);
void sl_gather_put_onward(const sl_gather_view *view, size_t first, size_t count);

/* Returns about what the lobe at slot k reflects to the gather of light that is the same from everywhere: all
 * of ks where the lobe is as wide as the hemisphere, and ks times the cosine where it is narrow. */
sl_rgb sl_gather_lobe(const sl_gather_view *view, size_t k);
/* Returns the emission of what slot k sees. */
sl_rgb sl_gather_emission(const sl_gather_view *view, size_t k);
/* Irradiance at every hit, then radiance, nearness and distance of every cell; *nearest and *back_weight as
 * in sl_irradiance. */
void sl_gather_shade(const sl_gather_view *view, float *nearest, double *back_weight, sl_counters *counters);
