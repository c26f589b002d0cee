/* Whether anything in a scene can throw a shadow on something else. */
#include "cache/direct_radiance/plan.h"

/* Where the vertices of a scene lie relative to a triangle's plane. */
enum { IN_FRONT = 1, BEHIND = 2 };

static unsigned sides_of(const sl_scene *scene, size_t triangle, double tolerance) {
    sl_vec3d n = sl_to_double(sl_scene_geometric_normal(scene, (uint32_t)triangle));
    sl_vec3d a = sl_to_double(sl_scene_position(scene, scene->vertex[0][triangle]));
    unsigned sides = 0;
    for (uint32_t v = 0; v < scene->vertex_count && sides != (IN_FRONT | BEHIND); v++) {
        double height = sl_dotd(n, sl_subd(sl_to_double(sl_scene_position(scene, v)), a));
        if (height > tolerance) sides |= IN_FRONT;
        if (height < -tolerance) sides |= BEHIND;
    }
    return sides;
}

/* Every plane has all vertices on one side of it, so no straight line between two points of the surface meets it in between. A single pair of
 * lamp and wall fails the test, and rightly so: a lamp has a back. */
bool sl_scene_is_convex(const sl_scene *scene) {
    enum { TESTS_AT_MOST = 1 << 24 };
    double tolerance = 1e-6 * (double)scene->scale;
    if (scene->triangle_count * scene->vertex_count > TESTS_AT_MOST) return false;
    for (size_t t = 0; t < scene->triangle_count; t++) {
        if (sides_of(scene, t, tolerance) == (IN_FRONT | BEHIND)) return false;
    }
    return true;
}
