/* Whether anything in a scene can throw a shadow on something else. */
#include "cache/direct_radiance/plan.h"

/* Where the vertices of a scene, or its lights, lie relative to a triangle's plane. */
enum { IN_FRONT = 1, BEHIND = 2, BOTH = IN_FRONT | BEHIND };

typedef struct {
    sl_vec3d point, normal;
    double tolerance;
} plane;

static plane plane_of(const sl_scene *scene, size_t triangle) {
    return (plane){.point = sl_to_double(sl_scene_position(scene, scene->vertex[0][triangle])),
                   .normal = sl_to_double(sl_scene_geometric_normal(scene, (uint32_t)triangle)),
                   .tolerance = 1e-6 * (double)scene->scale};
}

static unsigned side_of(double height, double tolerance) { return height > tolerance ? IN_FRONT : height < -tolerance ? BEHIND : 0; }

static unsigned sides_of_vertices(const sl_scene *scene, const plane *p) {
    unsigned sides = 0;
    for (uint32_t v = 0; v < scene->vertex_count && sides != BOTH; v++)
        sides |= side_of(sl_dotd(p->normal, sl_subd(sl_to_double(sl_scene_position(scene, v)), p->point)), p->tolerance);
    return sides;
}

/* A directional light stands as far away as can be, on the side from which it comes. */
static unsigned side_of_light(const sl_light *light, const plane *p) {
    if (light->type == SL_LIGHT_DIRECTIONAL) return side_of(-sl_dotd(p->normal, sl_to_double(light->direction)), 1e-6);
    return side_of(sl_dotd(p->normal, sl_subd(sl_to_double(light->position), p->point)), p->tolerance);
}

/* Every plane has all vertices and all lights on one side of it, so no straight line from a light, or from one point of the surface to another, meets it in
 * between. A single pair of lamp and wall fails the test, and rightly so: a lamp has a back. */
sl_shadow_casters sl_scene_shadow_casters(const sl_scene *scene) {
    enum { TESTS_AT_MOST = 1 << 24 };
    bool outside = false;
    if (scene->triangle_count * (scene->vertex_count + scene->light_count) > TESTS_AT_MOST) return SL_SHADOWS_OF_SURFACES;
    for (size_t t = 0; t < scene->triangle_count; t++) {
        const plane p = plane_of(scene, t);
        const unsigned sides = sides_of_vertices(scene, &p);
        if (sides == BOTH) return SL_SHADOWS_OF_SURFACES;
        for (size_t i = 0; i < scene->light_count && !outside; i++) outside = (sides | side_of_light(&scene->lights[i], &p)) == BOTH;
    }
    return outside ? SL_SHADOWS_OF_WALLS : SL_NO_SHADOWS;
}
