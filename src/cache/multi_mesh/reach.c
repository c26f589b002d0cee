/* Whether light can fall on any surface that is diffuse at all, by planes alone: before a ray is traced (no coarse mesh is made
 * where no surface with k_d > 0 receives light). What is hidden from all lights is found when the coarse mesh is lit (coarse_rounds.c). */
#include <math.h>

#include "base/math.h"
#include "cache/multi_mesh/plan.h"

/* Pairs of a light and a triangle that are looked at; in ordinary scenes the first is one that reaches. */
static const size_t PAIRS_MAX = 20000000;

typedef struct plane {
    sl_vec3d at, normal;      /* unit, or 0 */
    double near;              /* what is no further from it lies in it */
} plane;

static sl_vec3d corner_of(const sl_scene *scene, uint32_t triangle, int c) { return sl_to_double(sl_scene_position(scene, scene->vertex[c][triangle])); }

static plane plane_of(const sl_scene *scene, uint32_t triangle) {
    return (plane){corner_of(scene, triangle, 0), sl_to_double(sl_scene_geometric_normal(scene, triangle)), 1e-6 * (double)scene->scale};
}

static double height_of(const plane *p, sl_vec3d x) { return sl_dotd(sl_subd(x, p->at), p->normal); }

/* Whether any corner of a triangle lies before a plane, or on either side of it, but not in it. */
static bool stands_before(const sl_scene *scene, uint32_t triangle, const plane *p, bool either_side) {
    for (int c = 0; c < 3; c++) {
        double height = height_of(p, corner_of(scene, triangle, c));
        if (height > p->near || (either_side && height < -p->near)) return true;
    }
    return false;
}

/* A lamp's triangle lights what stands before it, unless the lamp lies in that surface's plane. */
static bool emitter_reaches(const sl_scene *scene, const sl_emitter *emitter, uint32_t triangle) {
    plane lamp = plane_of(scene, emitter->triangle), surface = plane_of(scene, triangle);
    return stands_before(scene, triangle, &lamp, emitter->two_sided) && stands_before(scene, emitter->triangle, &surface, true);
}

static bool light_reaches(const sl_scene *scene, const sl_light *light, uint32_t triangle) {
    plane surface = plane_of(scene, triangle);
    if (light->type == SL_LIGHT_DIRECTIONAL) return fabs(sl_dotd(surface.normal, sl_to_double(light->direction))) > 1e-6;
    return fabs(height_of(&surface, sl_to_double(light->position))) > surface.near;
}

bool sl_multi_mesh_light_can_fall(const sl_scene *scene) {
    size_t lights = scene->light_count + scene->emitter_count, pairs = 0;
    for (uint32_t t = 0; t < scene->triangle_count; t++) {
        if (!sl_material_is_diffuse(&scene->materials[scene->material_index[t]])) continue;
        for (size_t l = 0; l < lights; l++) {
            bool reaches = l < scene->light_count ? light_reaches(scene, &scene->lights[l], t) : emitter_reaches(scene, &scene->emitters[l - scene->light_count], t);
            if (reaches || ++pairs > PAIRS_MAX) return true;
        }
    }
    return false;
}
