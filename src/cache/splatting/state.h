/* The state of radiance cache splatting between updates. */
#pragma once

#include "cache/frame/announce.h"
#include "cache/bounces/bounces.h"
#include "cache/splatting/glossy.h"
#include "cache/splatting/splatting.h"
#include "scene/object_places.h"

/* ---- plan.c: what it will do with a scene ---- */

/* The environment is split: the sky, at most so many times as bright as its mean, is the gathers' background
 * and reaches the pixels through the records; the sun, which is what stands out of it, is sampled for every
 * pixel. Never both, never neither. */
#define SL_SKY_CONTRAST 10.0

typedef struct sl_splat_plan {
    /* aR_min in footprints of a pixel (of fewer and larger ones, beyond 400 rows): below, records cost more
     * than they tell */
    double minimum_pixels;
    double steep; /* sl_radius_rules */
    sl_gather_settings gather;
    sl_radius_metric metric; /* of irradiance records, decided */
    int harmonics_order;    /* n of radiance records */
    bool mirrors;           /* rays from the eye follow them */
    bool direct, irradiance, radiance; /* is there anything to compute? */
} sl_splat_plan;

/* settings are complete. */
sl_splat_plan sl_splat_plan_make(const sl_scene *scene, const sl_settings *settings);
/* The entries of sl_method_class of the same names. */
void sl_splat_complete(sl_settings *settings);
void sl_splat_transport(const sl_settings *settings, sl_transport *transport);
void sl_splat_plan_write(const sl_scene *scene, const sl_settings *settings, sl_plan_writer *writer);

/* The records of one class of receivers, and all that it takes to make and to splat them. Classes share the
 * planes of sums and of coverage, since a pixel belongs to one class alone: a record of the other never
 * reaches it. */
typedef struct sl_record_cache {
    sl_receiver_class class;
    sl_gathers gathers;  /* none until a pixel of this class has asked for a record */
    sl_glossy *glossy;          /* lobes and rotations; radiance records alone */
    uint32_t *receives;         /* pixels of this class */
    size_t receivers;           /* how many they are */
    sl_record_list list;
    size_t splatted;            /* records in the splat buffer */
    size_t known;               /* records that were there when this view's visit began */
    size_t clamped;             /* records whose radii are a fixed point of neighbour clamping */
    sl_record_pass pass;
    sl_traversal traversal;
} sl_record_cache;

/* Records are made for one class after the other. */
typedef enum sl_splat_phase {
    SL_PHASE_RENEW,
    SL_PHASE_GBUFFER,
    SL_PHASE_DIRECT,
    SL_PHASE_RECORDS,
    SL_PHASE_CLAMP,
    SL_PHASE_SECOND,
    SL_PHASE_DONE
} sl_splat_phase;

/* While objects and lights move (ages.c). */
typedef struct sl_splat_ages {
    bool aged;                  /* they have: records have the light of other times */
    bool anew;                  /* all are being made anew, behind the picture that is shown */
    uint32_t edits;             /* of objects and lights */
    sl_affine *placements;      /* of objects, as transport was made */
    sl_object_places *places;
    size_t moved_count;
    sl_box *moved;              /* what has moved by the last edit, where it was and is */
    /* aged ones, while others are made anew */
    sl_record_list kept[SL_RECEIVER_CLASSES];
    sl_second_cache *kept_second;
} sl_splat_ages;

enum { SL_SPLAT_PLANES = 12 };

typedef struct sl_splat_state {
    const sl_scene *scene;
    sl_settings settings;
    sl_splat_plan plan;

    sl_raster *raster;
    sl_tracer *tracer;
    sl_shadow_maps *maps;
    sl_direct *direct;
    /* more than one bounce: irradiance of what gathers see; made with the first of them */
    sl_second_cache *second;
    sl_environment sky, sun;    /* of the scene's environment; what is black is not present */
    sl_gbuffer *gbuffer;
    sl_reflections *reflections; /* pixels that show something by way of mirrors; NULL: none */
    sl_mirror_pixels mirrors;   /* where what they show lies */
    /* direct rgb, coverage, and the splat buffer: SL_SPLAT_PLANES planes, bottom row first */
    float *planes;
    float *direct_light[3], *coverage;
    sl_splat_buffer splats;
    uint8_t *owned;
    sl_record_cache cache[SL_RECEIVER_CLASSES];

    sl_splat_ages ages;
    sl_splat_phase phase;
    int class;                  /* whose records are being made */
    int direct_row;
    bool first_is_lit;          /* planes have direct light of the film's first sub-frame */
    bool interleaves;           /* direct light, which is to be had in full at the end */
    uint64_t frame_records;     /* new ones since the frame began */
    bool full;                  /* settings.memory_bytes is taken: no more records */
    char filled[48];
    sl_counters counters;
    sl_announcer announcer;
} sl_splat_state;

/* ---- edges.c ---- */

/* Marks and counts each class's receivers in the G-buffer. */
sl_status sl_splat_classify(sl_splat_state *state, sl_error *error);
/* Returns how much of a picture is done, for the progress bar alone. */
double sl_splat_fraction(const sl_splat_state *state);

/* ---- compose.c ---- */

/* Writes the layers of an image that has SL_LAYERS channels, SL_LAYERS_GLOSSY where the plan has radiance. */
sl_status sl_splat_compose(const sl_splat_state *state, sl_image *image, sl_error *error);

/* ---- create.c ---- */

sl_status sl_splat_create(const sl_scene *scene, const sl_settings *settings, const sl_transport *transport,
                          void **state, sl_error *error);
void sl_splat_destroy(void *state);
/* Everything that depends on geometry and lights, and not on the camera: made anew. Records are dropped. */
sl_status sl_splat_renew_transport(sl_splat_state *state, sl_error *error);
/* Leaves nothing of it, nor of second-level records. */
void sl_splat_destroy_transport(sl_splat_state *state);
/* The same, and records stay. */
sl_status sl_splat_renew_lights(sl_splat_state *state, sl_error *error);
/* Tells whether light is sampled sparsely, since things move. */
static inline bool sl_splat_is_quick(const sl_splat_state *s) { return s->ages.aged && !s->ages.anew; }
/* Makes what lights pixels anew. */
sl_status sl_splat_renew_direct(sl_splat_state *state, sl_error *error);
/* Returns a, of records of a class. */
double sl_splat_accuracy(const sl_splat_state *state, sl_receiver_class class);
void sl_splat_close_gathers(sl_splat_state *state);
/* Makes ready for this view what the records of a class need to be splatted. */
sl_status sl_splat_open_cache(sl_splat_state *state, sl_record_cache *cache, sl_error *error);
/* Makes what new records of the class take, if it is not there: not before a pixel asks for one. */
sl_status sl_splat_open_gathers(sl_splat_state *state, sl_record_cache *cache, sl_error *error);
size_t sl_splat_memory_bytes(const void *state);

/* ---- ages.c ---- */

/* Tells whether records outlive an edit of objects or lights. */
bool sl_splat_keeps_records(const sl_splat_state *state);
/* After such an edit: makes transport anew, and moves records along with what they lie on. */
sl_status sl_splat_age_records(sl_splat_state *state, sl_error *error);
/* Where things are, as transport is made. */
sl_status sl_splat_note_places(sl_splat_state *state, sl_error *error);
/* Some records gather anew: a frame's share. */
sl_status sl_splat_renew_records(sl_splat_state *state, sl_error *error);
/* A picture was shown and nothing has moved since: goes on with a further share, or makes all anew. */
sl_status sl_splat_rest(sl_splat_state *state, sl_error *error);
/* Something has changed: records that were not made to the end give way to those that are shown. */
void sl_splat_stir(sl_splat_state *state);
/* All records are as for a scene that has always been so. */
void sl_splat_settle(sl_splat_state *state);
void sl_splat_ages_free(sl_splat_ages *ages);

/* ---- splatting.c ---- */

/* Starts the picture again, as the camera sees the scene now. */
void sl_splat_begin_view(sl_splat_state *state);

/* ---- memory.c ---- */

sl_memory_need sl_splat_need(const sl_scene *scene, const sl_settings *settings);
/* Floats of a record's coefficients, of its class; 0 for irradiance records. */
size_t sl_splat_coefficients(const sl_splat_state *state, sl_receiver_class class);
/* Records have taken what memory they may: there will be no more. */
bool sl_splat_is_full(sl_splat_state *state);
const char *sl_splat_filled(const void *state);

/* ---- keep.c ---- */

sl_status sl_splat_save(const void *state, const char *path, sl_error *error);
/* Replaces records; where it fails nothing has changed. */
sl_status sl_splat_load(void *state, const char *path, sl_error *error);

/* ---- explanation.c: what made a pixel, and records as marks, for those who look on ---- */

/* See sl_method_explanation(). */
sl_status sl_splat_explanation(void *state, int x, int y, sl_explanation_writer *writer, sl_error *error);
/* Tells how many second-level records and bounces there are. */
void sl_splat_announce_second_level(sl_splat_state *state);
/* The picture that the record nearest to the middle of the view made of its hemisphere, gathered once more;
 * nothing without an observer. */
void sl_splat_announce_gather(sl_splat_state *state, sl_record_cache *cache);
/* All records, as discs as wide as they reach; nothing without an observer. */
void sl_splat_announce_records(sl_splat_state *state);

static inline size_t sl_splat_pixels(const sl_splat_state *s) {
    return (size_t)s->settings.width * (size_t)s->settings.height;
}
