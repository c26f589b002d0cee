/* The plan: settings completed, the paths, and which passes a scene needs (those that it does not need
 * are not run). */
#ifndef SL_MULTI_MESH_PLAN_H
#define SL_MULTI_MESH_PLAN_H

#include "cache/frame/method.h"

typedef struct sl_multi_mesh_plan {
    bool lights;             /* any light with a place or a direction */
    bool direct_diffuse;     /* some surface has k_d > 0, and there are lights */
    bool direct_specular;    /* some surface has k_s > 0, and there are lights */
    bool indirect;           /* some surface has k_d > 0, and there are lights or an environment */
    bool emission;           /* lamps or an environment can be in view */
    bool specular_seen;      /* k_s anywhere: the second render target */
} sl_multi_mesh_plan;

/* Replaces what is 0 in the settings, or left to quality. The exposure stays 0 until the scene is known. */
void sl_multi_mesh_complete(sl_settings *settings);
/* Returns the coarse mesh's longest edge, in scene units. */
double sl_multi_mesh_coarse_edge(const sl_scene *scene, const sl_settings *settings);
sl_multi_mesh_plan sl_multi_mesh_plan_make(const sl_scene *scene);
void sl_multi_mesh_transport(const sl_settings *settings, sl_transport *transport);
void sl_multi_mesh_plan_write(const sl_scene *scene, const sl_settings *settings, sl_plan_writer *writer);

#endif
