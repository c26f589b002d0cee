/* Where objects are, to find out which have moved between two states of a scene. */
#pragma once

#include "scene/scene.h"

/* All vertices of each object in one number, and the box around them. */
typedef struct sl_object_places {
    size_t count;
    uint64_t *hash;
    sl_box *box;
} sl_object_places;
sl_status sl_object_places_take(const sl_scene *scene, sl_object_places **places, sl_error *error);
void sl_object_places_destroy(sl_object_places *places);
/* Lists the boxes of objects that have moved, where they were and where they are: room for two an object.
 * Returns how many; moved: by object, or NULL. */
size_t sl_object_moves(const sl_object_places *before, const sl_object_places *now, bool *moved, sl_box *box);
/* The same scene, before and after. */
static inline bool sl_object_has_moved(const sl_object_places *before, const sl_object_places *after,
                                       size_t object) {
    return before->hash[object] != after->hash[object];
}
