/* What the parts of the shading cache share: the state of one cache. */
#ifndef SL_SHADING_CACHE_STATE_H
#define SL_SHADING_CACHE_STATE_H

#include "cache/frame/announce.h"
#include "cache/shading_cache/change.h"
#include "cache/shading_cache/display.h"
#include "cache/shading_cache/fade.h"
#include "cache/shading_cache/plan.h"
#include "cache/shading_cache/priority.h"
#include "cache/shading_cache/renderers.h"
#include "cache/shading_cache/work.h"
#include "scene/object_places.h"

enum { SL_SHADING_RENDERERS = 3 };

typedef struct sl_shading_state {
    const sl_scene *scene;
    sl_settings settings;
    sl_shading_plan plan;
    sl_display_curve curve;

    const sl_tracer *tracer;       /* the renderers hold the address of this */
    sl_tracer *own_tracer;
    sl_primitives *primitives;
    sl_patches *patches;
    sl_sample_renderer renderer[SL_SHADING_RENDERERS];
    int renderer_count;
    sl_display *display;
    sl_changes *changes;
    sl_object_places *places;

    sl_display_ids ids;            /* U1 */
    float *id_memory;
    uint32_t *leaf_of_pixel;       /* index into leaves */
    sl_leaf_priority *leaf;        /* U2, U3: visible leaves, in the order of their first pixels */
    size_t leaf_count, leaf_room;
    sl_choice *choice;             /* U4 */
    sl_work_settings work;         /* U5, U6 */
    sl_chosen_place *place;
    uint32_t *vertex;              /* U6: to be shaded */
    size_t vertex_room;
    sl_sample_request *request;    /* U7 */
    sl_sample *sample, *part;
    sl_fades fades;                /* U8 */
    bool *stale, *changing;        /* by object */
    uint32_t *stale_before;

    uint32_t now;                  /* the update under way: 1, 2, ... */
    uint64_t last_update;          /* after which a picture is done: an edit allows as many again */
    sl_vec3 eye;                   /* as the last edit left it */
    uint32_t edits;                /* ... of a series: frames */
    uint32_t edited;               /* the first update after an edit whose change no update has found yet; 0: there is none */
    bool shows_only;               /* the next frame of a series waits for no update */
    double error_levels;           /* of what was seen when the last update began */
    bool late;                     /* half of an update's choices had nothing left to do: leaves that are finished are left out, until the next edit */
    bool drawn;                    /* the display knows the view */
    bool done;
    sl_counters counters;
    sl_announcer announcer;
} sl_shading_state;

static inline size_t sl_shading_pixels(const sl_shading_state *s) { return (size_t)s->settings.width * (size_t)s->settings.height; }

/* live.c: frames beside updates. */
extern const sl_window_class sl_shading_window;

/* update.c: U1 to U10, once. */
sl_status sl_shading_update(sl_shading_state *s, sl_error *error);
/* samples.c: U7, the values of s->vertex[0 .. count), into s->sample; U8, into the patches. */
void sl_shading_sample(sl_shading_state *s, size_t count);
sl_status sl_shading_commit(sl_shading_state *s, size_t count, sl_error *error);
/* Pixels squared below which the patches of what changes are not split; 0: no limit. */
float sl_shading_coarsest(const sl_shading_state *s, bool triangles);

#endif
