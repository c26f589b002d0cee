/* The one interface that all methods and the reference tracers implement, so that the program, the step
 * pages, the benchmarks and the tests drive them all alike. */
#pragma once

#include "cache/frame/all_light.h"
#include "cache/frame/film.h"
#include "cache/frame/settings.h"
#include "scene/features.h"
#include "scene/scene.h"

typedef struct sl_plan_writer sl_plan_writer;
/* One line of the plan: a pass that runs or does not, and why. */
__attribute__((format(printf, 4, 5))) void sl_plan_pass(sl_plan_writer *writer, bool runs, const char *pass,
                                                        const char *why, ...);
/* One line of the plan: what of this scene's light the method will not get right, as far as that is known
 * beforehand. */
__attribute__((format(printf, 2, 3))) void sl_plan_limit(sl_plan_writer *writer, const char *limit, ...);

/* One more line to a picture's softlux.warning: a limit of the method that shows in it, and what helps. The
 * program prints each once, and --json has them. */
__attribute__((format(printf, 3, 4))) sl_status sl_warn(sl_image *image, sl_error *error, const char *limit,
                                                        ...);

typedef struct sl_explanation_writer sl_explanation_writer;
/* One more term; failures of memory are noticed at the end. */
void sl_explanation_add(sl_explanation_writer *writer, const sl_explanation_term *term);
/* Adds weight times value times factor of what lies at a position (NULL: nowhere); nothing where that is
 * black. */
void sl_explanation_add_light(sl_explanation_writer *writer, const char *layer, const char *kind,
                              uint64_t index, const sl_vec3 *position, double weight, const float value[3],
                              const double factor[3]);
/* Adds what a layer of the picture ("direct") has at this pixel as one term: for light that no cache holds.
 * Nothing where there is no such layer or it is black there. */
void sl_explanation_add_layer(sl_explanation_writer *writer, const char *layer, const char *kind);

/* Frames beside updates, by another thread: a window shows the newest state that updates have left, from
 * where its own copy of the scene stands (scene/copy.h). Nothing in it waits for an update. */
typedef struct sl_window_class {
    /* beside no update; threads: that draw */
    sl_status (*create)(void *state, const sl_scene *scene_copy, unsigned threads, void **window,
                        sl_error *error);
    void (*destroy)(void *window);                                                          /* likewise */
    /* the copy's objects have moved */
    sl_status (*move)(void *window, sl_error *error);
    /* triangles that the last picture's centres show, rows from the bottom */
    const uint32_t *(*ids)(const void *window);
    /* R, G, B of a picture of the method's size; *versions: how often what is shown has been brought up to
     * date. */
    sl_status (*draw)(void *window, sl_image *image, uint64_t *versions, sl_counters *counters,
                      sl_error *error);
} sl_window_class;

/* Bytes that a method takes beside the scene: an upper estimate by counts, before anything is there
 * (cache/frame/budget.h). */
typedef struct sl_memory_need {
    double hierarchies; /* clusters of the rasterizer, the rays' */
    double caches;      /* of which those that grow count with the least that is of use */
    double picture;     /* film, G-buffer and the picture that is given */
} sl_memory_need;

typedef struct sl_method_class {
    const char *name;
    /* Replaces what is 0, "by quality", by what will be used. */
    void (*complete)(sl_settings *settings);
    /* settings are complete: nothing is left to quality, scene or machine. */
    sl_status (*create)(const sl_scene *scene, const sl_settings *settings, const sl_transport *transport,
                        void **state, sl_error *error);
    void (*destroy)(void *state);
    sl_status (*update)(void *state, sl_progress *progress, sl_error *error);
    /* *image: NULL; or the picture of an earlier sub-frame, of which what this one does not show may stay.
     * What is given then is that one, or another. */
    sl_status (*resolve)(void *state, sl_image **image, sl_error *error);
    /* Writes all of the same picture's R, G and B into one of no other layers; NULL: resolve() does. */
    sl_status (*resolve_colours)(void *state, sl_image *image, sl_error *error);
    /* Triangles that its centres show, rows from the bottom; NULL, or gives NULL: nobody knows. */
    const uint32_t *(*ids)(const void *state);
    /* The scene has changed: SL_CHANGED_CAMERA, _OBJECTS, _LIGHTS, and of the others those in tells_apart;
     * what else changes light is told as SL_CHANGED_LIGHTS. */
    sl_status (*edit)(void *state, unsigned changes, sl_error *error);
    unsigned tells_apart;
    /* The method's cache on disk, for another run; NULL where it keeps none. A load that fails changes
     * nothing. */
    sl_status (*save)(const void *state, const char *path, sl_error *error);
    sl_status (*load)(void *state, const char *path, sl_error *error);
    size_t counters_at; /* the offset of an sl_counters in the state */
    size_t (*memory_bytes)(const void *state);
    /* settings are complete. Independent of the number of threads but for what each thread has of its own. */
    sl_memory_need (*need)(const sl_scene *scene, const sl_settings *settings);
    /* A cache that was to grow and found sl_settings.memory_bytes taken: a few words on it, or NULL; may
     * itself be NULL. In complete settings memory_bytes is what such caches may take; 0: no limit. */
    const char *(*filled)(const void *state);
    /* The paths that the method models with these settings (for the tracers: `full`). */
    void (*transport)(const sl_settings *settings, sl_transport *transport);
    void (*plan)(const sl_scene *scene, const sl_settings *settings, sl_plan_writer *writer);
    /* Explains what made a pixel, column x and row y of the target (bottom row first), from the state as it
     * was last resolved, which may keep what it wants for other explanations; NULL: no explanation. */
    sl_status (*explanation)(void *state, int x, int y, sl_explanation_writer *writer, sl_error *error);
    size_t raster_at; /* likewise, of an sl_raster * of the scene; 0: there is none */
    bool asks; /* the cache grows by what sub-frames see (scene/scene.h), and is asked before any is shown */
    bool any_transport; /* takes --transport: a reference tracer */
    bool draws_anew; /* a picture does not depend on those before it: ranks may draw one each */
    const sl_window_class *window; /* NULL: pictures are resolved between updates alone */
    /* True: all of the picture has light, though not what it will have; NULL: pictures are shown when they
     * are done. */
    bool (*shows)(const void *state);
    /* Estimates the error of what is seen, in displayed levels (0 to 255), as the last update found it; NULL:
     * nobody knows. */
    double (*error_levels)(const void *state);
    /* sl_live_state.samples of this state, and sl_method_rate(); NULL: no rate steers it. */
    double (*samples)(const void *state);
    void (*rate)(void *state, double samples_a_second);
} sl_method_class;

struct sl_method {
    const sl_method_class *class;
    void *state;
    unsigned states; /* made so far */
    const sl_scene *scene;
    sl_scene seen; /* with a film, what the class is given: the scene's arrays and the sub-frame to draw */
    sl_transport transport;
    sl_features planned; /* of the scene that the state was created for */
    sl_counters *before; /* of states that are gone; behind them all with this one's. NULL: there are none */
    sl_film *film; /* NULL: pixels are what their centres show */
    sl_image *sub_frame; /* the last one's picture; NULL: there is none */
    bool looks_elsewhere; /* seen has another sub-frame than the class has been told of */
    bool batch_by_batch;  /* somebody looks between updates: none stands for several */
    sl_settings settings; /* complete */
    char transport_name[64];
    uint64_t memory_bytes; /* as asked for */
    char reduced[512], reduction[640]; /* before the start; with what was found on the way */
    uint64_t light_hash; /* of the scene */
    bool light_hash_known;
    sl_progress progress; /* of the last update; not done once there was an edit */
    /* an edit failed: another may do better; an update failed: nothing can */
    enum { SL_METHOD_SOUND, SL_METHOD_WANTS_EDIT, SL_METHOD_FAILED } health;
    bool resolved; /* since the last update or edit */
    uint64_t scene_version; /* that the method knows of */
    float scale;            /* the scene's, and its central region, by which what the method holds was made */
    sl_vec3 central_min, central_max;
};

static inline const sl_counters *sl_method_own_counters(const sl_method *method) {
    return (const void *)((const char *)method->state + method->class->counters_at);
}

static inline const sl_raster *sl_method_raster(const sl_method *method) {
    return *(const sl_raster *const *)(const void *)((const char *)method->state + method->class->raster_at);
}

extern const sl_method_class sl_splatting_method; /* cache/splatting */
extern const sl_method_class sl_direct_radiance_method; /* cache/direct_radiance */
extern const sl_method_class sl_light_octree_method;    /* cache/light_octree */
extern const sl_method_class sl_multi_mesh_method;      /* cache/multi_mesh */
extern const sl_method_class sl_shading_cache_method;   /* cache/shading_cache */
extern const sl_method_class sl_path_method;      /* cache/reference */
extern const sl_method_class sl_bidirectional_method; /* cache/reference */

/* As sl_method_create(), for one that takes so many bytes itself, within settings->memory_bytes. */
sl_status sl_method_create_beside(const sl_scene *scene, const sl_settings *settings, double bytes,
                                  sl_method **method, sl_error *error);

/* Gives R, G and B of what sl_method_resolve() does. */
sl_status sl_method_resolve_colours(sl_method *method, sl_image **image, sl_error *error);

/* Refuses what sl_method_rate() does. */
sl_status sl_rate_check(double samples_a_second, sl_error *error);

/* Returns what a show's method does less than was asked for, so as to keep within settings->memory_bytes, as
 * far as that was known before its start; "": nothing. */
const char *sl_live_reduction(const sl_live *live);

/* Tells whether pictures are taken on a film: the tracers spread their samples over a pixel themselves. */
static inline bool sl_method_has_film(const sl_method_class *class, const sl_settings *settings) {
    return !class->any_transport && settings->filter != SL_FILTER_METHOD &&
           settings->filter != SL_FILTER_CENTRE;
}

/* The light paths that a picture with these settings counts, and its pixel filter: the method's own, or what
 * was asked for. */
sl_status sl_method_transport(const sl_settings *settings, sl_transport *transport, sl_error *error);
/* Checks what was asked for, whatever is to be done with it: a method and light paths that there are,
 * settings in their ranges. chosen has the scene's film where no size was asked for, and as many bounces as
 * matter where no number was: *measured (or NULL) tells how they were found, or is 0. */
sl_status sl_method_choose(const sl_scene *scene, const sl_settings *asked, sl_settings *chosen,
                           sl_transport *transport, sl_bounces_measured *measured, sl_error *error);

/* The explanation of a pixel of a picture that the state resolved last, rows from the top; see
 * sl_method_explanation(). */
sl_status sl_explanation_tell(const sl_method_class *method, void *state, const sl_image *picture, int x,
                              int y, sl_explanation **explanation, sl_error *error);

/* ---- exposure.c: a picture's sub-frames, one after the other, or shared out by ranks ---- */

/* Shows the class the first sub-frame, of which it is told nothing else. Without a film: the scene itself. */
void sl_expose_anew(sl_method *method, bool objects_moved);
/* Updates the class, and hands the sub-frames that are finished to the film. now->batches goes up by what
 * there was on top of one update; now->done: the picture is whole. */
sl_status sl_expose(sl_method *method, sl_progress *now, sl_error *error);
