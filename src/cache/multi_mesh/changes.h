/* Samples that still hold when lights and objects have moved (the paper leaves dynamic scenes open). A sample
 * of a light at a vertex holds as long as neither the light nor the vertex has moved, and nothing that has
 * moved was, or is, between them: the cone from the vertex around the light against the boxes of what moved,
 * before and after. Gathers see everything, so indirect light starts again. */
#ifndef SL_MULTI_MESH_CHANGES_H
#define SL_MULTI_MESH_CHANGES_H

#include "cache/light/lights.h"
#include "cache/patches/topology.h"
#include "scene/object_places.h"

typedef struct sl_irradiance_changes {
    size_t light_count;
    bool *light_changed;       /* all samples of that light go */
    uint8_t *triangle_moved;   /* samples on it go */
    size_t box_count;
    sl_box *box;         /* of what has moved, before and after: samples of lights seen through one go */
} sl_irradiance_changes;
/* From two states of one scene. Lights are told apart by their numbers: the same count of them before and
 * after is wanted. */
sl_status sl_irradiance_changes_find(const sl_scene *scene, const sl_object_places *before,
                                     const sl_object_places *after, const sl_sampled_lights *lights_before,
                                     const sl_sampled_lights *lights_after, sl_irradiance_changes **changes,
                                     sl_error *error);
void sl_irradiance_changes_destroy(sl_irradiance_changes *changes);
/* May something that has moved lie between the point and the light? */
bool sl_light_is_crossed(const sl_irradiance_changes *changes, const sl_sampled_light *light, sl_vec3 point);

/* Do both share the same corners and edges, so that vertices of meshes over the one are vertices over the
 * other? */
bool sl_topology_same_structure(const sl_topology *a, const sl_topology *b);

#endif
