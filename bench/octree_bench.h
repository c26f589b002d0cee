/* What the experiments on the light octree share beside common.h: its passes one by one, each with its
 * seconds; pictures made of them; and what these are compared with. */
#ifndef SL_BENCH_OCTREE_H
#define SL_BENCH_OCTREE_H

#include "cache/light_octree/light_octree.h"
#include "common.h"

/* Of one thread processor time, of more the clock's. */
double octree_seconds(unsigned threads);
/* The defaults of normal quality, but for depth 6. */
sl_light_octree_settings octree_settings(void);

/* ---- passes (octree_run.c) ---- */

/* The first two parts of the preprocessing: seconds of tracing and of the tree. */
sl_photon_tree *octree_photons(const sl_scene *scene, const sl_tracer *tracer,
                               const sl_light_octree_settings *settings, uint64_t seed, unsigned threads,
                               double seconds[2], sl_counters *counters);
sl_octree *octree_voxels(const sl_scene *scene, int depth, unsigned threads, double *seconds);

typedef struct octree_light {
    sl_voxel_lights *lights;
    sl_voxel_texture *texture;
    double seconds[2];           /* gathers and clusters together; textures */
} octree_light;

void octree_light_voxels(const sl_scene *scene, const sl_octree *octree, const sl_photon_tree *tree,
                         const sl_light_octree_settings *settings, unsigned threads, octree_light *light);
void octree_light_free(octree_light *light);

/* ---- triangles (octree_cut.c) ---- */

/* A scene whose triangles, but for lamps, are cut into four so many times: the same surfaces. */
sl_scene *octree_cut_scene(const sl_scene *scene, int times);

/* ---- views ---- */

typedef struct octree_view {
    sl_scene *scene;
    sl_tracer *tracer;
    sl_raster *raster;
    sl_gbuffer *gbuffer;
    sl_view view;
    double embree, gbuffer_seconds; /* with one thread */
    float *planes[3];            /* of the last picture, row 0 at the bottom */
    sl_counters counters;        /* of the last picture alone */
} octree_view;

/* False where the scene is not there. */
bool octree_view_open(bench_report *r, const char *path, int width, int height, octree_view *view);
void octree_view_close(octree_view *view);
/* Indirect light of the whole picture; returns its seconds. */
double octree_shade_view(octree_view *view, const sl_octree_shading *shading, unsigned threads);
/* Those pixels of the last picture. */
void octree_view_pick(const octree_view *view, const bench_pixels *pixels, float *values);
/* The last picture as SCENE-WHAT.png: at the exposure of the first picture that was written of this scene and
 * size. */
void octree_view_write(const octree_view *view, const bench_report *r, const char *scene, const char *what);

/* ---- photons without an octree (octree_direct.c) ---- */

typedef enum octree_place {
    OCTREE_AT_PIXEL, /* the photon map shown directly */
    OCTREE_AT_VOXEL /* gathered about the voxel's centroid, as the octree does; but every photon keeps its own
                       direction */
} octree_place;

/* Radiance of chosen pixels from the k photons that are nearest; octree: for clipped areas, and for places.
 * Returns processor seconds. */
double octree_direct(const octree_view *view, const bench_pixels *pixels, const sl_octree *octree,
                     const sl_photon_tree *tree, const sl_light_octree_settings *settings, octree_place place,
                     float *values);

/* ---- worlds (octree_world.c): a view, the pixels that are judged, and their reference ---- */

enum { OCTREE_SEEDS = 2, OCTREE_MAPS = 16 };

/* Octrees and photon maps are made when they are first asked for, and kept. */
typedef struct octree_world {
    char name[64];
    octree_view view;
    bench_pixels pixels;
    bench_reference reference;   /* indirect light alone */
    float *values[OCTREE_SEEDS]; /* the last pictures at those pixels */
    sl_octree *octree[SL_OCTREE_DEPTH_MAX + 1];
    struct {
        uint64_t photons;
        sl_photon_tree *tree[OCTREE_SEEDS];
    } map[OCTREE_MAPS];
    int maps;
} octree_world;

/* False where the scene is not there, or not wanted. */
bool octree_world_open(bench_report *r, const bench_options *o, const char *path, octree_world *w);
void octree_world_close(octree_world *w);
sl_octree *octree_world_octree(octree_world *w, int depth);
const sl_photon_tree *octree_world_photons(octree_world *w, const sl_light_octree_settings *settings,
                                           int seed);

typedef struct octree_picture {
    double seconds;              /* of lights, textures and pixels */
    double mib;                  /* of the textures */
} octree_picture;

/* Lights the octree's voxels from those photons, and the view from them; its pixels go to `values`. */
octree_picture octree_world_picture(octree_world *w, const sl_octree *octree, const sl_photon_tree *tree,
                                    const sl_light_octree_settings *settings, unsigned threads,
                                    float *values);

#endif
