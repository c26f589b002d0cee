/* The light octree (Vivanloc, Hoelt, Hong, Paulin 2007): a photon map condensed, voxel by voxel, into a few
 * directional lights, which shaders then use like any others.
 *
 *   light_octree.c    the paper: one picture, step by step
 *   method.c          what a method holds of that, what edits leave, direct light
 *   motion.c          frames while things move: photons in slices, direct light by shadow maps
 *   plan.c            which passes a scene needs; picture.c: a picture's layers, and what is said of it
 *   ../photons/       photon tracing, the kd-tree, and the k nearest photons
 *   octree.c          the voxels, on geometry
 *   leaf.c            a set of lights, step by step: photons, area, clusters, lights
 *   photon_area.c     the area of the triangles around, less what no photon met
 *   cluster_kernels.c K-means on photons' directions; voxel_lobes.c: from clusters to lights
 *   voxel_lights.c    the lights of every voxel; voxel_sets.c: what lies in a voxel, by normals
 *   voxel_texture.c   all of it in textures, as the hardware holds it
 *   shade.c           surface points lit from the octree
 *   pixels.c          which pixels go which way; the photon map shown as it is
 *   atlas/            the same by way of a texture atlas
 *   ../reflect/       what mirrors show
 *   explanation.c     what made a pixel; what can be seen of photons and lights
 */
#pragma once

#include "cache/frame/announce.h"
#include "cache/frame/method.h"
#include "cache/light/direct.h"
#include "cache/light_octree/pixels.h"

/* ---- what runs for a scene, and its settings completed (plan.c) ---- */

typedef struct sl_octree_plan {
    bool photons;      /* something shines and something reflects */
    /* some surface is: view vectors, lobes by direction even where the colour octree would do */
    bool glossy;
    bool mirrors;
    bool direct;       /* direct light of pixels */
    bool environment;
    /* what is smooth of the environment is in the octree; off where pixels are to have all direct light, or
     * none */
    bool sky;
    int first_depth;   /* the shallowest octree that is shown */
} sl_octree_plan;

/* Replaces what is 0 in settings->light_octree, or left to quality. The radius stays 0: it follows from the
 * photons. */
void sl_octree_complete(sl_settings *settings);
sl_octree_plan sl_octree_plan_make(const sl_scene *scene, const sl_settings *settings);
void sl_octree_transport(const sl_settings *settings, sl_transport *transport);
/* Where fewer photons than that share of k come to a voxel, and where gathers reach farther than so many
 * voxels, something is to be said. (Gathers of high quality reach 2.0 voxels in the Cornell box and 2.3 in
 * the room, of normal 1.1 and 1.3, and depth 6 errs less all the same: to warn of 2 would be to warn of every
 * picture of high quality. From 4 on a shallower octree shows as much.) */
static const double SL_OCTREE_FEW_PHOTONS = 0.1, SL_OCTREE_WIDE_GATHERS = 4.0;
/* Tells whether directional lights show some of the scene's gloss blurred. */
bool sl_octree_widens_gloss(const sl_scene *scene, const sl_light_octree_settings *settings);
void sl_octree_plan_write(const sl_scene *scene, const sl_settings *settings, sl_plan_writer *writer);

/* Returns how many chunks of photon paths one update traces. */
size_t sl_octree_photon_chunks(const sl_settings *settings);
sl_memory_need sl_octree_need(const sl_scene *scene, const sl_settings *settings);

/* ---- what a method holds ---- */

enum { SL_OCTREE_PLANES = 6 }; /* direct, indirect */

typedef enum sl_octree_phase {
    SL_OCTREE_PHASE_GBUFFER,
    SL_OCTREE_PHASE_DIRECT,
    SL_OCTREE_PHASE_PHOTONS,
    SL_OCTREE_PHASE_OCTREE,
    SL_OCTREE_PHASE_LIGHTS,
    SL_OCTREE_PHASE_SHADE,
    SL_OCTREE_PHASE_DONE
} sl_octree_phase;

/* A finished octree: what pixels are lit from. */
typedef struct sl_octree_level {
    /* made anew for each depth: a cut of the deepest rounds in another order than that depth alone */
    sl_octree *octree;
    sl_voxel_lights *lights;
    sl_voxel_texture *texture;
} sl_octree_level;

enum { SL_OCTREE_SLICES = 4 };

/* Holds the light of frames in motion. */
typedef struct sl_octree_motion {
    bool asked;                 /* an edit came: the next update draws a whole frame */
    bool shown;                 /* the octree that is shown is one of slices */
    sl_photon_list *slice[SL_OCTREE_SLICES]; /* each a photon map of all light; all or none are there */
    unsigned age[SL_OCTREE_SLICES];          /* edits of light since it was traced */
    sl_photon_tree *tree;       /* of all slices */
    sl_direct *direct;
} sl_octree_motion;

typedef struct sl_octree_state {
    const sl_scene *scene;
    sl_settings settings;
    sl_octree_plan plan;

    sl_raster *raster;
    sl_tracer *tracer;
    sl_environment sky, sun;    /* of the scene's environment: in the octree, and direct light of pixels */
    sl_direct *direct;

    sl_photon_list *photons;    /* until the tree takes them */
    sl_photon_tree *tree;
    sl_octree_level shown, next;
    /* of the atlas, as long as the geometry stays; NULL where it is not asked for */
    sl_atlas_canvas *canvas;

    sl_gbuffer *gbuffer;
    sl_reflections *reflections;
    float *planes;
    float *direct_light[3], *indirect_light[3];

    sl_octree_phase phase;
    bool lit;                   /* the picture's indirect light is that of `shown` */
    bool fresh;                 /* the last update made a whole picture that there was not before */
    sl_octree_motion motion;
    int depth;                  /* of the octree under way */
    int direct_row;
    size_t leaf;
    sl_counters counters;
    sl_announcer announcer;
} sl_octree_state;

void sl_octree_forget_level(sl_octree_level *level);
void sl_octree_announce_picture(sl_octree_state *s, const char *name, const char *source,
                                const float *planes);
/* The G-buffer, with what mirrors show; and the next rows of direct light (method.c). */
sl_status sl_octree_draw_gbuffer(sl_octree_state *s, sl_error *error);
sl_status sl_octree_light_rows(sl_octree_state *s, sl_error *error);
/* Begins the light of a new G-buffer; announces direct light that is done. */
void sl_octree_begin_light(sl_octree_state *s);
void sl_octree_announce_direct(sl_octree_state *s);
sl_octree_shading sl_octree_state_shading(const sl_octree_state *s);

/* The next step of the pass that is under way (light_octree.c). */
sl_status sl_octree_step(sl_octree_state *s, sl_error *error);
sl_photon_options sl_octree_photon_options(const sl_octree_state *s);
/* An octree of that depth and the lights of its voxels; and the pixels' light from what is shown, at once.
 * moves: others follow soon. */
sl_status sl_octree_show_level_of(sl_octree_state *s, const sl_photon_tree *tree, int depth, sl_error *error);
sl_status sl_octree_light_picture(sl_octree_state *s, bool moves, sl_error *error);
sl_octree_pixels sl_octree_pixels_of(const sl_octree_state *s, const sl_octree_shading *shading, bool moves);
/* Announces indirect light that is done; lit: each pixel has its own. */
void sl_octree_show_light(sl_octree_state *s, bool lit);

/* A whole frame: G-buffer, direct light, octree where light has changed, pixels (motion.c). */
sl_status sl_octree_draw_frame(sl_octree_state *s, sl_error *error);
void sl_octree_age_light(sl_octree_motion *motion);
/* The octree that is shown is none of slices any more. */
void sl_octree_forget_slices(sl_octree_motion *motion);
void sl_octree_forget_motion(sl_octree_motion *motion);
size_t sl_octree_motion_bytes(const sl_octree_motion *motion);
/* R, G, B = emission + direct + indirect, and each of the three alone, mirrors' reflectances included; top
 * row first (picture.c). */
sl_status sl_octree_create_image(const sl_octree_state *s, sl_image **image, sl_error *error);
void sl_octree_compose(const sl_octree_state *s, sl_image *image); /* that, or one of R, G and B alone */
/* Into a picture's metadata: softlux.octree.*, what it was made from, and softlux.warning, what is to be said
 * against that (picture.c). */
sl_status sl_octree_write_report(const sl_octree_state *s, sl_image *image, sl_error *error);
/* Returns the environment that direct light samples: all, what was split off as a sun, or none. */
const sl_environment *sl_octree_sampled_sky(const sl_octree_state *s);
size_t sl_octree_state_bytes(const void *state);

/* ---- what made a pixel, and what can be seen of photons and voxels (explanation.c) ---- */

/* The class's explanation. */
sl_status sl_octree_explanation(void *state, int x, int y, sl_explanation_writer *writer, sl_error *error);

/* These do nothing without an observer. */

/* Photons where they hit, some thousands of them. */
void sl_octree_announce_photons(sl_announcer *announcer, const sl_photon_list *photons);
/* Voxels' lights as arrows from their centroids towards where the light comes from, some thousands of them.
 */
void sl_octree_announce_lights(sl_announcer *announcer, const sl_octree *octree,
                               const sl_voxel_lights *lights);
