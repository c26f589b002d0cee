/* Direct light of the coarse mesh's vertices. A gather sees hundreds of them at once, so a few rays a light
 * are enough, noise and all; and of many lights those that could give most are asked, in that order (Ward
 * 1994), until the others together could add but little: these are taken to be as visible as the former were.
 * Nothing is kept for the picture's own meshes, nor are these refined for it. */
#ifndef SL_MULTI_MESH_COARSE_LIGHT_H
#define SL_MULTI_MESH_COARSE_LIGHT_H

#include "cache/light/light_sample.h"
#include "cache/multi_mesh/gather.h"

typedef struct sl_coarse_light_settings {
    const sl_scene *scene;     /* all of these must outlive it */
    const sl_topology *topology;
    const sl_tracer *tracer;
    const sl_sampled_lights *lights;
    const sl_light_sampling *sampling;
    unsigned threads;
} sl_coarse_light_settings;

typedef struct sl_coarse_light sl_coarse_light;
sl_status sl_coarse_light_create(const sl_coarse_light_settings *settings, sl_coarse_light **light,
                                 sl_error *error);
void sl_coarse_light_destroy(sl_coarse_light *light);
size_t sl_coarse_light_memory_bytes(const sl_coarse_light *light);
/* U_dd of each vertex; NaN where it lies inside other geometry. A pure function of the vertex and the scene.
 * Counts SL_COUNT_LIGHT_SAMPLES. */
void sl_coarse_light_take(sl_coarse_light *light, size_t count, const sl_coarse_vertex *vertex,
                          sl_rgb *radiance, sl_counters *counters);

#endif
