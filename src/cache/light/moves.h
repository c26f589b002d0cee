/* Tells what has moved between two states of a scene, and whose direct light may differ for it. A sample of
 * one light at one point stays what it is, bit by bit, while neither the light nor the point has moved and
 * nothing that has moved was, or is, between them: the cone from the point around the light against the
 * boxes of what moved, before and after. Colours and powers change no sample. */
#pragma once

#include "cache/light/lights.h"
#include "scene/object_places.h"

typedef struct sl_light_moves {
    const sl_scene *scene;
    const sl_sampled_lights *lights; /* as they are now */
    bool *light_moved;               /* by light */
    bool *object_moved;              /* by object of the scene */
    size_t box_count;
    sl_box *box;                     /* of objects that have moved, where they were and where they are */
    bool recoloured;                 /* some light has another colour */
} sl_light_moves;

/* Finds the lights as they are now, to be compared later: without the table of triangles. */
sl_status sl_light_places_take(const sl_scene *scene, sl_sampled_lights **lights, sl_error *error);
/* Compares two states of one scene. Scene and lights must outlive it. *moves is NULL where there are other
 * lights than before, or other objects. */
sl_status sl_light_moves_find(const sl_scene *scene, const sl_object_places *places_before,
                              const sl_object_places *places, const sl_sampled_lights *lights_before,
                              const sl_sampled_lights *lights, sl_light_moves **moves, sl_error *error);
void sl_light_moves_destroy(sl_light_moves *moves);

static inline bool sl_has_triangle_moved(const sl_light_moves *moves, uint32_t triangle) {
    return moves->object_moved[moves->scene->object_index[triangle]];
}
/* Tells whether a light may have another share (F) than before at any point within `reach` of a point that
 * has not moved. Never false where it has. */
bool sl_light_may_differ(const sl_light_moves *moves, size_t light, sl_vec3 point, double reach);
