/* The state of one cache, which the parts of the shading cache share. */
#pragma once

#include "cache/frame/announce.h"
#include "cache/light/moves.h"
#include "cache/shading_cache/change.h"
#include "cache/patches/display/display.h"
#include "cache/patches/layers.h"
#include "cache/shading_cache/plan.h"
#include "cache/shading_cache/priority.h"
#include "cache/shading_cache/renderers.h"
#include "cache/shading_cache/work.h"

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
    const sl_raster *raster; /* the display's */
    sl_changes changes;
    sl_object_places *places;
    sl_sampled_lights *lights;     /* where they are, and of what colour */

    sl_display_ids ids;            /* id map */
    float *id_memory;
    uint32_t *leaf_of_pixel;       /* index into leaves */
    sl_leaf_priority *leaf;        /* priority map: visible leaves, in the order of their first pixels */
    size_t leaf_count, leaf_room;
    sl_choice *choice;             /* hit-and-test, flood fill */
    sl_view view;                  /* lazy evaluation */
    sl_work_settings work;
    sl_chosen_place *place;
    uint32_t *vertex;              /* to be shaded */
    size_t vertex_room;
    sl_sample_request *request;    /* sample renderer */
    sl_sample *sample, *part;
    sl_fades fades;                /* values that are blended in */
    bool *stale;                   /* by object */
    sl_layers layers;              /* light apart by what it costs */
    sl_sample (*layer)[2];         /* by request: the cheap layer, the dear one */
    bool may_be_stale;             /* something that is seen is from before an edit, or was lately */
    size_t stale_left;             /* vertices that are stale after this update */
    size_t dear_left;              /* of these, whose dear layer is older than the scene */

    uint32_t now;                  /* the update under way: 1, 2, ... */
    double samples;                /* so far: parts of one count as what they cost */
    /* after which a picture is done: an edit allows as many again, and no more than so many updates of a
     * picture from its beginning take */
    uint64_t last_update;
    double last_sample;
    double samples_an_update;      /* until the first edit; 0: there was none */
    sl_vec3 eye;                   /* as the last edit left it */
    uint32_t edits;                /* ... of a series: frames */
    uint32_t lit;                  /* the update before the last edit of light or of objects; 0: none */
    bool moves;                    /* one such edit follows another: direct light is sampled quickly */
    bool few_paths;                /* so is indirect light, until it has caught up with the last edit */
    uint32_t same_paths;           /* the version of layers since which it is by as many paths */
    uint32_t edited;               /* the first update after an edit whose change is not found yet; 0: none */
    bool shows_only;               /* the next frame of a series waits for no update */
    double error_levels;           /* of what was seen when the last update began */
    /* half of the choices were finished leaves: these are left out from then on */
    bool late;
    bool drawn;                    /* the display knows the view */
    bool done;
    sl_counters counters;
    sl_announcer announcer;
} sl_shading_state;

/* shading_cache.c: one update; the commit of the samples of s->vertex[0 .. count). */
sl_status sl_shading_update(sl_shading_state *s, sl_error *error);
void sl_shading_commit(sl_shading_state *s, size_t count);

/* selection.c. The id map's leaves with their pixels; a visit to each of them, on all threads. */
typedef void sl_leaf_visit(sl_shading_state *s, sl_leaf_priority *leaf);
sl_status sl_shading_find_leaves(sl_shading_state *s, sl_error *error);
void sl_shading_each_leaf(sl_shading_state *s, sl_leaf_visit *visit);
/* Finished leaves are not chosen, once half of the choices were theirs. */
void sl_shading_leave_out_finished(sl_shading_state *s);
void sl_shading_note_idle(sl_shading_state *s, size_t choices);
bool sl_shading_is_done(const sl_shading_state *s);

/* renewal.c. Appends vertices that are stale to s->vertex[0 .. *count), and tells which layers each of
 * them is asked for. */
sl_status sl_shading_renew(sl_shading_state *s, size_t *count, sl_error *error);
/* Returns how many cheap samples take half the time of one of all layers. */
double sl_shading_cheap_samples(const sl_shading_state *s);
/* Adds the requests made to the samples so far. */
void sl_shading_count_samples(sl_shading_state *s, size_t requests);
/* untouched.c. Before an edit is noted: scales all light where its power alone is another, and marks as new
 * direct light that is as it was. Returns what is left of the changes, with SL_CHANGED_LIGHTS where no light
 * was kept. */
unsigned sl_shading_keep(sl_shading_state *s, unsigned what, const sl_light_moves *moves,
                         const sl_sampled_lights *before);

/* samples.c. The samples of s->vertex[0 .. count), into s->sample: the sample renderer is asked for E of
 * diffuse surfaces, and for L_o towards the eye of others. */
void sl_shading_sample(sl_shading_state *s, size_t count);
/* Makes room for so many vertices to be shaded. */
sl_status sl_shading_reserve(sl_shading_state *s, size_t room, sl_error *error);
void sl_shading_commit_sample(sl_shading_state *s, size_t request);
/* Objects of which visible leaves still show values from before their change. */
void sl_shading_find_stale(sl_shading_state *s);
void sl_shading_drop_resolution(sl_shading_state *s);
void sl_shading_note_latency(sl_shading_state *s);
/* Pixels squared below which quads of changing objects are not split, triangles below half of it; 0: no
 * limit.
 */
float sl_shading_coarsest(const sl_shading_state *s);

/* explanation.c: the terms of a pixel; and patches, samples and chosen pixels as marks, for those who look
 * on. */
/* See sl_method_explanation(). */
sl_status sl_shading_explanation(void *state, int x, int y, sl_explanation_writer *writer, sl_error *error);

/* Nothing without an observer. Chosen pixels: hits green, random ones blue, floods red. */
void sl_shading_announce_choices(sl_shading_state *state, size_t choices);
void sl_shading_announce_priorities(sl_shading_state *state);
/* Leaves that were seen in the last update, by their edges; vertices with samples, in the colour of their
 * irradiance. */
void sl_shading_announce_patches(sl_shading_state *state);
