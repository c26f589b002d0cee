/* Irradiance meshes: one for each light, over the same faces, refined only where radiance asks for it. So the
 * shadow of one light is not sampled again for every other (the paper's central point), and a light without
 * discontinuities in a place stays coarse there.
 *
 * fetch(x, l), from the root of x's face in the mesh of light l:
 *   x is a corner, or the middle of a leaf's edge   its sample
 *   a leaf larger than whoever asks wants it to be  cut, and on
 *   a leaf whose three edges are closed             interpolated
 *   another leaf                                    its edges are tested, then it is closed or cut, and on
 *
 * Samples that are not there yet are put on a list; once they are taken the fetch is made again: a round. */
#pragma once

#include "cache/light/light_sample.h"
#include "cache/light/moves.h"
#include "cache/patches/mesh.h"
#include "cache/patches/perception.h"

/* A vertex of any mesh for which irradiance is asked. */
typedef struct sl_face_point {
    sl_root_place at;
    int wanted_depth;          /* leaves above this are cut whatever their edges say */
} sl_face_point;

typedef struct sl_irradiance_settings {
    const sl_scene *scene;     /* all of these must outlive the meshes */
    const sl_primitives *primitives;
    const sl_tracer *tracer;
    const sl_sampled_lights *lights;
    const sl_light_sampling *sampling;
    sl_perception perception;
    sl_rgb ambient;            /* irradiance beside which a light's own is judged */
    /* lights that matter little beside the others are sampled by a few rays, whatever `sampling` says */
    bool few_rays;
    int max_depth;
    unsigned threads;
} sl_irradiance_settings;

typedef struct sl_irradiance_meshes sl_irradiance_meshes;
sl_status sl_irradiance_meshes_create(const sl_irradiance_settings *settings, sl_irradiance_meshes **meshes,
                                      sl_error *error);
void sl_irradiance_meshes_destroy(sl_irradiance_meshes *meshes);
size_t sl_irradiance_meshes_bytes(const sl_irradiance_meshes *meshes);
/* Returns a light's mesh. Values are F (light_sample.h). */
const sl_patches *sl_irradiance_mesh(const sl_irradiance_meshes *meshes, size_t light);

/* F of every light at each point, share[i * lights + l]; valid[i] false: the point lies inside other
 * geometry. As many rounds as it takes. */
sl_status sl_irradiance_at(sl_irradiance_meshes *meshes, size_t count, const sl_face_point *points,
                           float *share, bool *valid, sl_counters *counters, sl_error *error);

/* Gives the sample at a place of a light's mesh, or what is interpolated there, however coarsely. False:
 * there is neither. */
bool sl_irradiance_known(const sl_patches *mesh, sl_root_place at, float *share);
/* Lights whose samples are asked whether they hold. */
typedef struct sl_changed_lights {
    const sl_light_moves *moves;
    size_t first, end;
    double reach;              /* how far off a point its samples are taken */
} sl_changed_lights;
bool sl_lights_may_differ(const sl_changed_lights *lights, sl_vec3 point, double reach);
/* An sl_mesh_check. Asks again for vertices inside other geometry: solids and their lights have moved. */
bool sl_mesh_value_holds(const void *context, const sl_patches *mesh, uint32_t vertex);

/* Takes the world as it is now: settings with as many lights of the same kinds, over the same primitives.
 * Keeps samples that still hold; moves NULL: none does. After a failure the meshes can be destroyed, no
 * more. */
sl_status sl_irradiance_meshes_follow(sl_irradiance_meshes *meshes, const sl_irradiance_settings *settings,
                                      const sl_light_moves *moves, sl_error *error);
/* Sets whether what is known will do, whatever depth is wanted: samples are taken then only where there is
 * nothing to interpolate. */
void sl_irradiance_meshes_spare(sl_irradiance_meshes *meshes, bool sparing);
