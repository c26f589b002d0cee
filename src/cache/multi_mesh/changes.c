#include "cache/multi_mesh/changes.h"

#include "base/error.h"
#include "base/memory.h"
#include "raster/views/cone.h"

#include <string.h>

static bool same_vector(sl_vec3 a, sl_vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

static bool same_light(const sl_sampled_light *a, const sl_sampled_light *b) {
    if (a->kind != b->kind || a->two_sided != b->two_sided || a->triangles != b->triangles) return false;
    if (!same_vector(a->position, b->position) || !same_vector(a->direction, b->direction)) return false;
    if (a->cos_inner != b->cos_inner || a->cos_outer != b->cos_outer) return false;
    for (size_t k = 0; k < 3 * a->triangles; k++)
        if (!same_vector(a->corner[k], b->corner[k])) return false;
    return true; /* samples do not know the light's colour */
}

sl_status sl_irradiance_changes_find(const sl_scene *scene, const sl_object_places *before,
                                     const sl_object_places *after, const sl_sampled_lights *lights_before,
                                     const sl_sampled_lights *lights_after, sl_irradiance_changes **changes,
                                     sl_error *error) {
    *changes = NULL;
    sl_irradiance_changes *c = sl_allocate(1, sizeof *c);
    if (c) {
        c->light_count = lights_after->count;
        c->light_changed = sl_allocate(c->light_count, sizeof *c->light_changed);
        c->triangle_moved = sl_allocate(scene->triangle_count, sizeof *c->triangle_moved);
        c->box = sl_allocate(2 * scene->object_count, sizeof *c->box);
    }
    if (!c || !c->light_changed || !c->triangle_moved || !c->box) {
        sl_irradiance_changes_destroy(c);
        return sl_fail_memory(error, "what has changed");
    }
    for (size_t i = 0; i < c->light_count; i++)
        c->light_changed[i] =
            i >= lights_before->count || !same_light(&lights_before->light[i], &lights_after->light[i]);
    for (size_t i = 0; i < scene->object_count; i++) {
        if (!sl_object_has_moved(before, after, i)) continue;
        c->box[c->box_count++] = before->box[i];
        c->box[c->box_count++] = after->box[i];
    }
    for (size_t t = 0; t < scene->triangle_count; t++) {
        uint32_t object = scene->object_index[t];
        c->triangle_moved[t] = sl_object_has_moved(before, after, object);
    }
    *changes = c;
    return SL_OK;
}

void sl_irradiance_changes_destroy(sl_irradiance_changes *c) {
    if (!c) return;
    sl_free(c->light_changed);
    sl_free(c->triangle_moved);
    sl_free(c->box);
    sl_free(c);
}

static sl_cone cone_to(const sl_sampled_light *light, sl_vec3 point) {
    if (light->kind == SL_SAMPLED_DIRECTIONAL)
        return (sl_cone){.apex = point, .axis = sl_neg(light->direction), .cosine = 1.0f, .length = INFINITY};
    if (light->triangles == 0) return sl_cone_around(point, &light->position, 1);
    return sl_cone_around(point, light->corner, 3 * light->triangles);
}

bool sl_light_is_crossed(const sl_irradiance_changes *changes, const sl_sampled_light *light, sl_vec3 point) {
    if (changes->box_count == 0) return false;
    sl_cone cone = cone_to(light, point);
    sl_cone_test test = sl_cone_test_make(&cone);
    for (size_t i = 0; i < changes->box_count; i++) {
        sl_vec3d low = sl_to_double(changes->box[i].low), high = sl_to_double(changes->box[i].high);
        sl_vec3d half = sl_scaled(sl_subd(high, low), 0.5);
        /* a line has no width, and objects have roundings */
        double slack = 1e-5 * (sl_lengthd(high) + sl_lengthd(half));
        half = sl_addd(half, sl_v3d(slack, slack, slack));
        if (!(high.x >= low.x) || sl_cone_meets_box(&test, sl_scaled(sl_addd(high, low), 0.5), half))
            return true;
    }
    return false;
}

bool sl_topology_same_structure(const sl_topology *a, const sl_topology *b) {
    if (a->face_count != b->face_count || a->site_count != b->site_count || a->edge_count != b->edge_count)
        return false;
    for (int i = 0; i < 3; i++) {
        if (memcmp(a->site[i], b->site[i], a->face_count * sizeof *a->site[i]) != 0) return false;
        if (memcmp(a->edge[i], b->edge[i], a->face_count * sizeof *a->edge[i]) != 0) return false;
    }
    return memcmp(a->degenerate, b->degenerate, a->face_count / 2 * sizeof *a->degenerate) == 0;
}
