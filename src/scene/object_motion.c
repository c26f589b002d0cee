#include "scene/object_motion.h"

#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "scene/animation.h"

sl_status sl_object_placements_take(const sl_scene *scene, sl_affine **placements, sl_error *error) {
    bool keyed;
    sl_affine *p = sl_allocate(scene->object_count, sizeof *p);
    *placements = p;
    if (!p) return sl_fail_memory(error, "the objects' placements");
    for (size_t i = 0; i < scene->object_count; i++)
        p[i] = scene->animation ? sl_animation_placement(scene, (uint32_t)i, &keyed) : sl_affine_identity();
    return SL_OK;
}

sl_object_motion sl_object_motion_between(const sl_affine *before, const sl_affine *now) {
    sl_object_motion none = {.moves = false};
    if (memcmp(before, now, sizeof *now) == 0 || !(fabs(sl_affine_determinant(before)) > 1e-300)) return none;
    const sl_affine back = sl_affine_inverse(before), places = sl_affine_after(now, &back);
    return (sl_object_motion){true, places, sl_affine_normal_map(&places)};
}
