/* What the experiments on multi-mesh caching share beside common.h: the method run step by step, and how far
 * each part of its pictures is off. */
#ifndef SL_BENCH_MESH_H
#define SL_BENCH_MESH_H

#include "cache/multi_mesh/multi_mesh.h"
#include "common.h"

/* ---- what is compared ---- */

/* Parts of a picture; the whole is their sum. Lamps are not compared. */
typedef enum mesh_part { MESH_DIRECT, MESH_SPECULAR, MESH_INDIRECT, MESH_ALL, MESH_PARTS } mesh_part;
extern const char *const mesh_part_names[MESH_PARTS];

typedef struct mesh_world {
    char name[64];
    sl_scene *scene;
    sl_tracer *tracer;
    bench_pixels pixels;
    bool has[MESH_PARTS];
    bench_reference reference[MESH_PARTS];
    float *values;
} mesh_world;

/* Parts are traced apart: direct light on the diffuse lobe, on the glossy one, one diffuse bounce. False
 * where the scene is not there. */
bool mesh_world_open(bench_report *r, const char *path, int width, int height, int block, uint32_t samples,
                     mesh_world *w);
void mesh_world_close(mesh_world *w);
/* Of each part, relative to the whole picture: so they add up to its error, but for what cancels. */
void mesh_judge(const mesh_world *w, const sl_image *image, bench_error errors[MESH_PARTS]);
/* Values of one part (or the whole, less emission) at the chosen pixels. */
void mesh_pick(const mesh_world *w, const sl_image *image, mesh_part part, float *values);

/* ---- the method ---- */

sl_settings mesh_settings(const mesh_world *w, sl_quality quality);

typedef struct mesh_run {
    void *state;
    /* of creation and updates: processor time of one thread, of more threads the clock's */
    double seconds;
    unsigned threads;
    bool done;
} mesh_run;

/* The settings' gaps are filled. */
void mesh_run_open(mesh_run *run, const sl_scene *scene, sl_settings *settings);
/* One update. */
void mesh_run_step(mesh_run *run);
void mesh_run_edit(mesh_run *run, unsigned changes);
/* The picture so far; *seconds: what it took. */
sl_image *mesh_run_picture(mesh_run *run, double *seconds);
uint64_t mesh_run_count(const mesh_run *run, sl_counter counter);
/* Samples of direct light that needed a picture or a ray. */
uint64_t mesh_run_drawn(const mesh_run *run);
void mesh_run_close(mesh_run *run);
double mesh_seconds(unsigned threads);

#endif
