/* Multi-mesh caching with hardware sampling: progressive global illumination from several meshes over the
 * same triangles, each refined on its own. Read in this order:
 *
 *   plan.c             which passes a scene needs
 *   multi_mesh.c       the paper: the passes of a picture, update by update
 *   world.c, method.c  what a picture is made from; made, measured; a step of the picture; edits
 *   follow.c           lights and objects that move: what still holds, what is old, and is renewed
 *   window.c           frames beside updates
 *   displayed.h        a mesh as the eye uses it: priorities, tests, drawing (progressive sampling, pass 3)
 *   direct.c           direct diffuse and specular radiance from them
 *   coarse.h           the coarse mesh of the whole scene, which indirect gathers see; coarse_roll.c: while
 *                      things move
 *   merge.c            materials, and the five pictures into one (passes 2 and 4)
 *   explanation.c      a pixel told backwards; what can be seen of the meshes while they are made
 *
 * Faces, their shared corners and the quadtrees on them are those of cache/patches, and so are visible sizes
 * (image pass 1, display/pixels.c) and a mesh for each light, refined only where radiance asks for it
 * (irradiance.c); gathers are those of cache/hemisphere; single lights are sampled in cache/light. Here are
 * the method's state, and the functions of its parts. */
#pragma once

#include "cache/frame/announce.h"
#include "cache/frame/method.h"
#include "cache/multi_mesh/coarse.h"
#include "cache/multi_mesh/displayed.h"
#include "cache/patches/irradiance.h"

typedef enum sl_mesh_phase { SL_PHASE_VIEW, SL_PHASE_FIRST, SL_PHASE_REFINE, SL_PHASE_DONE } sl_mesh_phase;

enum {
    SL_DONE_VIEWS = 32,
    SL_COARSE_VERTICES = 1024, /* of the coarse mesh, an update, beside refinement */
    SL_WORLDS_AN_EDIT = 2 /* worlds of a mesh by edit: values that were taken quickly are in between */
};

/* Which passes a scene needs: those that it does not need are not run. */
typedef struct sl_multi_mesh_plan {
    bool lights;             /* any light with a place or a direction */
    bool direct_diffuse;     /* some surface has k_d > 0, and there are lights */
    bool direct_specular;    /* some surface has k_s > 0, and there are lights */
    bool indirect;           /* some surface has k_d > 0, and there are lights or an environment */
    bool emission;           /* lamps or an environment can be in view */
    bool specular_seen;      /* k_s anywhere: the second render target */
} sl_multi_mesh_plan;

/* Pixels a side of a gather: half while things move, a quarter where hundreds are seen at once. */
typedef enum sl_gather_detail {
    SL_GATHER_ALL,
    SL_GATHER_HALF,
    SL_GATHER_A_QUARTER,
    SL_GATHER_DETAILS
} sl_gather_detail;

/* Copies of the meshes, for a window: frames beside updates (window.c). */
typedef struct sl_mesh_frames sl_mesh_frames;

/* A coarse mesh with those who look at it, and how far its light has come. */
typedef struct sl_coarse_rounds {
    sl_coarse *coarse;          /* NULL: there is none */
    uint32_t world, lit;        /* in which it was begun */
    sl_coarse_share *shares;    /* F by vertex and light; NULL: few_rays, hasty, or all are there */
    bool hasty;                 /* the first of all, while things move: few vertices, by few rays */
    bool rolls;                 /* its vertices are lit anew, some an update: coarse_roll.c */
    float *area;                /* ... by vertex: what it stands for */
    uint32_t *lit_in;           /* ... by vertex: the update that lit it; 0: none did */
    uint32_t updates;           /* ... so far */
    uint32_t old;               /* ... what was lit before this one is from before an edit, ... */
    uint32_t rolls_to;          /* ... which made this world */
    size_t done;                /* vertices of the round under way */
    sl_rgb *direct;             /* U_dd of lamps at its vertices, and ... */
    sl_rgb *indirect;           /* ... E_i of the environment or of later bounces; NULL: not yet, or none */
    uint32_t gathers;           /* rounds of these that are left */
    sl_gathers eye[SL_GATHER_DETAILS]; /* none: to be made */
} sl_coarse_rounds;

/* The view's materials, whatever the light: planes of the picture's size, bottom row first. */
typedef struct sl_materials_seen {
    float *planes;             /* behind all of these; NULL: nothing is seen yet */
    float *diffuse[3];         /* k_d with its texture */
    float *specular[3];        /* k_s; NULL where nothing in view has any */
    /* L_e of lamps seen from where they shine, the environment behind everything; NULL: none */
    float *emission[3];
} sl_materials_seen;

/* Lights and rays to them, made anew where lights or objects have moved. */
typedef struct sl_mesh_world {
    sl_tracer *tracer;
    sl_sampled_lights *lights;
    sl_light_sampling *sampling;
    sl_object_places *places;       /* where objects are in it */
} sl_mesh_world;

typedef struct sl_multi_mesh_state {
    const sl_scene *scene;
    sl_settings settings;
    sl_multi_mesh_plan plan;
    sl_perception perception;
    sl_rgb ambient;                 /* indirect irradiance before anything of it is known; and ... */
    sl_rgb ambient_in_motion;       /* ... where frames do not wait for it: of all bounces that count */

    /* what depends on geometry and lights */
    sl_raster *raster;
    sl_primitives *primitives;      /* triangles, each by itself */
    sl_mesh_world now;
    sl_irradiance_settings light;   /* of these and of the coarse mesh */
    sl_irradiance_meshes *irradiance;
    sl_displayed *part[SL_COMPONENTS]; /* NULL: the scene does not need it */
    sl_coarse_rounds whole, next;   /* coarse meshes: that which gathers see, and one that is being made */
    sl_coarse_kept kept;            /* light samples of the last that was whole */
    bool gathers_wait;              /* for a coarse mesh of now: an edit came to one that was */
    bool hastens;                   /* something has changed before there was a coarse mesh */
    float scale;                    /* the scene's: tolerances follow it */
    uint32_t world;                 /* 1, and one more with each edit of what is lit or lights it */
    uint32_t lit;                   /* the last of them that was not of colours and powers alone */
    uint32_t made;                  /* how often the world has been made anew */
    sl_mesh_frames *frames;         /* NULL: nobody looks */
    bool has_light;                 /* frames may show it */
    bool change_waits;              /* a change of direct light is yet to be shown: that of ... */
    uint32_t change_world;
    bool moves, settled;            /* the last edit came before the picture of the one before was done */
    bool is_edited;                 /* since the method began, the view included: updates are shared out */
    size_t old_left;                /* values in view that an edit has left to be taken again */
    uint32_t oldest_left;           /* the world of the oldest of direct light */
    uint32_t updates;               /* since the last edit of what is lit or lights it */
    bool mixed;                     /* nothing has moved since: gathers cut nothing until all are of now */
    bool judged;                    /* all edges, since the last edit */

    /* what depends on the view */
    uint32_t *id;
    sl_visible_pixels *visible;
    sl_materials_seen materials;
    float *planes[SL_COMPONENTS][3];
    float *plane_memory;

    /* the last views that were refined to their end since lights and objects have been where they are: */
    sl_camera done[SL_DONE_VIEWS];
    size_t done_count;              /* ... in turn, at done_count % SL_DONE_VIEWS */
    bool seen_before; /* the view is one of them: only specular radiance, which starts again, is refined, from
                         what is known of irradiance */

    sl_mesh_phase phase;
    bool full;                      /* settings.memory_bytes is taken: no more splits */
    size_t bytes_of_roots;          /* of the meshes before refinement */
    char filled[48];
    bool priorities_stale;          /* values have come since the view was seen */
    double highest, fraction;       /* of all priorities of this view; how much seems to be done */
    sl_counters counters;
    sl_announcer announcer;
} sl_multi_mesh_state;

/* ---- plan.c ---- */

/* Replaces what is 0 in the settings, or left to quality. The exposure stays 0 until the scene is known. */
void sl_multi_mesh_complete(sl_settings *settings);
/* Returns the coarse mesh's longest edge, in scene units. */
double sl_multi_mesh_coarse_edge(const sl_scene *scene, const sl_settings *settings);
sl_multi_mesh_plan sl_multi_mesh_plan_make(const sl_scene *scene);
void sl_multi_mesh_transport(const sl_settings *settings, sl_transport *transport);
void sl_multi_mesh_plan_write(const sl_scene *scene, const sl_settings *settings, sl_plan_writer *writer);

/* ---- multi_mesh.c ---- */

/* Image passes 1 and 2, of the view as it is. */
sl_status sl_multi_mesh_draw_view(sl_multi_mesh_state *s, sl_error *error);
/* Some of the vertices that visible leaves lack; once none does refinement begins. */
sl_status sl_multi_mesh_first_vertices(sl_multi_mesh_state *s, sl_error *error);
/* Returns the mesh whose leaf is to be served next; -1: none is worth it. */
int sl_multi_mesh_most_urgent(const sl_multi_mesh_state *s);
/* Serves a batch of leaves. */
sl_status sl_multi_mesh_refine(sl_multi_mesh_state *s, size_t *served, sl_error *error);
/* Image passes 3 and 4. */
sl_status sl_multi_mesh_resolve(void *state, sl_image **image, sl_error *error);

/* Tells whether some updates have seen no edit of what is lit or lights it: what was sampled quickly is
 * sampled again. */
static inline bool sl_multi_mesh_rests(const sl_multi_mesh_state *s) {
    enum { REST = 2 };
    return !s->moves || s->updates > REST;
}

static inline bool sl_is_in_view(const sl_displayed *part) { return part && part->root_count > 0; }

/* ---- merge.c ---- */

/* Makes the materials of a view from its id plane: two render targets in one pass. None is there yet. */
sl_status sl_multi_mesh_see_materials(sl_multi_mesh_state *s, const sl_view *view, sl_error *error);
void sl_multi_mesh_forget_materials(sl_multi_mesh_state *s);
/* Makes the picture: R, G, B, which are the sums of the layers direct, specular, indirect and emission; kd
 * and ks beside them. */
sl_status sl_multi_mesh_merge(const sl_multi_mesh_state *s, sl_image **image, sl_error *error);

/* ---- direct.c: direct radiance at points of unit reflectance, from the shares of a point's lights ---- */

/* Returns U_ds = (n + 2) / (2 pi) sum cos^n alpha E_d (equation 6 without k_s) towards the eye. Equation (6)
 * shrinks an area light to a point inside the lobe, which outshines the lamp itself where the lobe is
 * narrower than it, and is black where the mirror direction meets the lamp beside its middle. So cos^n alpha
 * is its mean over the light, by the irradiance that each part of it gives where nothing hides it: as dense a
 * grid of points as the lobe is narrow, 16 to an edge at most. */
sl_rgb sl_direct_specular(const sl_sampled_lights *lights, const float *share, const sl_lit_point *point,
                          float exponent, sl_vec3 eye);

/* ---- method.c ---- */

/* Tells whether a mesh is refined: not one that was in the same view before, nor indirect light without a
 * coarse mesh. */
bool sl_multi_mesh_takes_part(const sl_multi_mesh_state *s, int part);
/* Returns the depth to which a light's mesh is cut whatever its edges say. A leaf's edges have their middles
 * sampled, so its samples are as close to each other as corners of leaves a level deeper: several lights'
 * meshes are left that much coarser (the table joint of bench/multi-mesh.trials). */
int sl_multi_mesh_light_depth(const sl_multi_mesh_state *s, int wanted);
/* Hands the view to the meshes and clears their planes. */
sl_status sl_multi_mesh_see(sl_multi_mesh_state *s, sl_error *error);
/* A picture that was done once is done. */
bool sl_multi_mesh_was_done(const sl_multi_mesh_state *s);

/* ---- world.c ---- */

sl_status sl_multi_mesh_make_world(sl_multi_mesh_state *s, sl_error *error);
void sl_multi_mesh_forget_world(sl_multi_mesh_state *s);
void sl_mesh_world_forget(sl_mesh_world *world);
/* Parts of it that follow.c makes again: lights and their sampling; what irradiance meshes are made from; the
 * levels of the display. */
sl_status sl_multi_mesh_make_sampling(sl_multi_mesh_state *s, sl_error *error);
sl_irradiance_settings sl_multi_mesh_irradiance_settings(const sl_multi_mesh_state *s);
void sl_multi_mesh_set_perception(sl_multi_mesh_state *s);

/* A vertex of a displayed mesh that is to be sampled. */
typedef struct sl_wanted_vertex {
    uint32_t vertex;
    int wanted_depth;
} sl_wanted_vertex;
/* Returns radiance at a point from its lights' shares: equations (4) and (6), by direct.c. */
sl_rgb sl_multi_mesh_direct(const sl_multi_mesh_state *s, sl_component part, const sl_sampled_lights *lights,
                            const float *share, const sl_mesh_point *point);
/* Takes samples and puts them. */
sl_status sl_multi_mesh_sample(sl_multi_mesh_state *s, sl_component part, size_t count,
                               const sl_wanted_vertex *wanted, sl_error *error);

/* ---- probes.c ---- */

/* A leaf that is served. */
typedef struct sl_taken_leaf {
    sl_component part;
    sl_patch_place place;
    bool probed, contradicted; /* it is to be probed (displayed.h), and what came of that */
} sl_taken_leaf;
void sl_multi_mesh_probe(sl_multi_mesh_state *s, size_t count, sl_taken_leaf *leaves);

/* Returns an update's share of what it is at 512 x 512 pixels, once lights or objects have changed: as much a
 * pixel in smaller pictures, as long as that is a sixteenth of it. */
static inline size_t sl_multi_mesh_share(const sl_multi_mesh_state *s, size_t of_large) {
    size_t share = of_large * sl_settings_pixels(&s->settings) / (512 * 512);
    return share >= of_large ? of_large : share > of_large / 16 ? share : of_large / 16;
}

/* ---- follow.c ---- */

/* Lights or objects have changed. What cannot have changed stays as it is; the rest is old, and seen until it
 * is taken again. *followed false: nothing holds, the world is to be made anew. After a failure it can be
 * forgotten, no more. */
sl_status sl_multi_mesh_follow(sl_multi_mesh_state *s, unsigned changes, bool *followed, sl_error *error);
/* An update's share for what an edit has made old: direct light first, as far as so many samples go, then
 * what is gathered. */
sl_status sl_multi_mesh_renew(sl_multi_mesh_state *s, sl_error *error);

/* ---- window.c ---- */

/* Leaves copies of the meshes for a window, if there is one. */
sl_status sl_multi_mesh_show(sl_multi_mesh_state *s, sl_error *error);
void sl_mesh_frames_destroy(sl_mesh_frames *frames);
/* Returns bytes of the copies. To be asked by the method's thread. NULL: 0. */
size_t sl_mesh_frames_bytes(const sl_mesh_frames *frames);
extern const sl_window_class sl_multi_mesh_window;

/* ---- coarse_rounds.c ---- */

void sl_multi_mesh_forget_coarse(sl_coarse_rounds *rounds);
/* Gathers are made anew: the hardware's vertices have moved. */
void sl_multi_mesh_forget_eyes(sl_coarse_rounds *rounds);
/* Tells whether gathers of half or a quarter of the pixels a side have fewer. */
bool sl_multi_mesh_has_quick(const sl_multi_mesh_state *s);
/* Makes the gather of so many pixels where there is none. */
sl_status sl_multi_mesh_ready_eye(sl_multi_mesh_state *s, sl_coarse_rounds *rounds, sl_gather_detail detail,
                                  sl_error *error);
/* Irradiance that points gather from a coarse mesh. */
sl_status sl_multi_mesh_gather(sl_multi_mesh_state *s, sl_coarse_rounds *rounds, sl_gather_detail detail,
                               size_t count, const sl_mesh_point *points, sl_rgb *irradiance,
                               sl_error *error);
/* Makes a coarse mesh, its light not yet asked for. */
sl_status sl_multi_mesh_begin_coarse(sl_multi_mesh_state *s, sl_error *error);
/* Something has changed before there was a coarse mesh: unless it is half done, one that is soon made takes
 * its place. */
void sl_multi_mesh_hasten_coarse(sl_multi_mesh_state *s);
/* One round. Its last makes the coarse mesh whole: the displayed mesh of indirect light begins, or is old. */
sl_status sl_multi_mesh_extend_coarse(sl_multi_mesh_state *s, sl_error *error);
/* Makes a coarse mesh whose faces are cut so many times less often than for a still picture. */
sl_status sl_multi_mesh_make_coarse(const sl_multi_mesh_state *s, int halvings, sl_coarse **coarse,
                                    sl_error *error);
/* Makes what gathers see of what its vertices have. */
void sl_multi_mesh_colour_coarse(const sl_multi_mesh_state *s, const sl_coarse_rounds *rounds);
/* Tells whether gathers see the world as it is now. */
static inline bool sl_coarse_is_of_now(const sl_multi_mesh_state *s) {
    return s->whole.coarse && s->whole.world == s->world && !s->whole.rolls && !s->whole.hasty;
}

/* ---- coarse_roll.c ---- */

/* Lights some vertices of the coarse mesh anew, in turns. Once all are of light as it is now its world is. */
sl_status sl_multi_mesh_roll(sl_multi_mesh_state *s, sl_error *error);
/* Indirect light that was gathered while the coarse mesh's vertices had `before` is old, and is scaled as the
 * irradiance around it has changed. */
void sl_multi_mesh_carry(sl_multi_mesh_state *s, const sl_coarse_rounds *before, const sl_coarse_rounds *now);

/* ---- explanation.c: what made a pixel, and what can be seen of the meshes, for those who look on ---- */

/* See sl_method_explanation(). */
sl_status sl_multi_mesh_explanation(void *state, int x, int y, sl_explanation_writer *writer,
                                    sl_error *error);

/* All of these do nothing without an observer. */

/* Announces how much the roots matter, of the first mesh that there is, at the pixels that show them. */
void sl_multi_mesh_announce_priorities(sl_multi_mesh_state *s);
/* Announces what one point in view gathers: the picture that is weighted and added up. */
void sl_multi_mesh_announce_gather(sl_multi_mesh_state *s);
/* Announces what the vertex that sees about half of the first light sees of it: the picture that is added up,
 * and what is read back. */
void sl_multi_mesh_announce_light_sample(sl_multi_mesh_state *s);
/* The edges of a mesh's leaves in view, in the colours of what it holds there. */
void sl_multi_mesh_announce_edges(sl_multi_mesh_state *s, sl_component part);
/* Those of the first lights' meshes. */
void sl_multi_mesh_announce_lights(sl_multi_mesh_state *s);
