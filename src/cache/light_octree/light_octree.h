/* The light octree (Vivanloc, Hoelt, Hong, Paulin 2007): a photon map condensed, voxel by voxel, into a few
 * directional lights, which shaders then use like any others.
 *
 *   light_octree.c    the paper: one picture, step by step
 *   method.c          what a method holds of that, what edits leave, direct light
 *   plan.c            which passes a scene needs; picture.c: a picture's layers, and what is said of it
 *   ../photons/       photon tracing, the kd-tree, and the k nearest photons
 *   octree.c          the voxels, on geometry; triangle_cells.c
 *   voxel_gather.c    a voxel's photons, and the area that they were strewn over
 *   photon_area.c     that area, of all triangles around; photon_hull.c: of what photons met alone
 *   cluster.c         K-means on their directions; voxel_lobes.c: from clusters to lights
 *   voxel_lights.c    the lights of every voxel; voxel_sets.c, normal_groups.c: several sets in a voxel
 *   voxel_texture.c   all of it in textures, as the hardware holds it
 *   shade.c           surface points lit from the octree; pixels.c: which pixels go which way
 *   atlas/            the same by way of a texture atlas
 *   ../reflect/       what mirrors show
 *   explanation.c     what made a pixel; what can be seen of photons and lights
 *   photon_pixels.c   the photon map shown as it is: what the octree is compared with
 */
#ifndef SL_CACHE_LIGHT_OCTREE_H
#define SL_CACHE_LIGHT_OCTREE_H

#include "cache/frame/announce.h"
#include "cache/light/direct.h"
#include "cache/light_octree/pixels.h"
#include "cache/light_octree/plan.h"
#include "cache/light_octree/shade.h"
#include "cache/light_octree/voxel_lights.h"
#include "cache/reflect/reflect.h"

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
    sl_lit_atlas *atlas;        /* as long as the geometry stays; NULL where it is not asked for */

    sl_gbuffer *gbuffer;
    sl_reflections *reflections;
    float *planes;
    float *direct_light[3], *indirect_light[3];

    sl_octree_phase phase;
    bool lit;                   /* the picture's indirect light is that of `shown` */
    int depth;                  /* of the octree under way */
    int direct_row;
    size_t leaf;
    double radius;
    sl_counters counters;
    sl_announcer announcer;
} sl_octree_state;

static inline size_t sl_octree_state_pixels(const sl_octree_state *s) {
    return (size_t)s->settings.width * (size_t)s->settings.height;
}

void sl_octree_forget_level(sl_octree_level *level);
void sl_octree_announce_picture(sl_octree_state *s, const char *name, const char *source,
                                const float *planes);
/* The G-buffer, with what mirrors show; and the next rows of direct light (method.c). */
sl_status sl_octree_draw_gbuffer(sl_octree_state *s, sl_error *error);
sl_status sl_octree_light_rows(sl_octree_state *s, sl_error *error);
sl_octree_shading sl_octree_state_shading(const sl_octree_state *s);

/* The next step of the pass that is under way (light_octree.c). */
sl_status sl_octree_step(sl_octree_state *s, sl_error *error);
/* Of completed settings; radius: theirs, or that of the octree's density. */
sl_voxel_light_options sl_octree_light_options(const sl_light_octree_settings *settings, double radius);
/* R, G, B = emission + direct + indirect, and each of the three alone, mirrors' reflectances included; top
 * row first (picture.c). */
sl_status sl_octree_compose(const sl_octree_state *s, sl_image **image, sl_error *error);
/* Into a picture's metadata: softlux.octree.*, what it was made from, and softlux.warning, what is to be said
 * against that (picture.c). */
sl_status sl_octree_write_report(const sl_octree_state *s, sl_image *image, sl_error *error);
size_t sl_octree_state_bytes(const sl_octree_state *s);

#endif
