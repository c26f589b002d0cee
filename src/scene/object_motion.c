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

/* Of the normal map, which is the transposed inverse but for the determinant's size. */
static sl_affine inverse(const sl_affine *a, double determinant) {
    const sl_affine cofactors = sl_affine_normal_map(a);
    const sl_vec3d shift = sl_v3d(a->m[0][3], a->m[1][3], a->m[2][3]);
    sl_affine b = {{{0}}};
    for (int i = 0; i < 9; i++) b.m[i / 3][i % 3] = cofactors.m[i % 3][i / 3] / fabs(determinant);
    const sl_vec3d back = sl_affine_vector(&b, shift);
    b.m[0][3] = -back.x, b.m[1][3] = -back.y, b.m[2][3] = -back.z;
    return b;
}

sl_object_motion sl_object_motion_between(const sl_affine *before, const sl_affine *now) {
    sl_object_motion none = {.moves = false};
    const double determinant = sl_affine_determinant(before);
    if (memcmp(before, now, sizeof *now) == 0 || !(fabs(determinant) > 1e-300)) return none;
    const sl_affine back = inverse(before, determinant), places = sl_affine_after(now, &back);
    return (sl_object_motion){true, places, sl_affine_normal_map(&places)};
}
