/* Points spread evenly over an area light: what is a parallelogram takes them as they are, so that they are as even on it as in the unit square; of
 * other lights the first number chooses the triangle by area, and what is left of it serves for the place. */
#include <math.h>

#include "base/error.h"
#include "base/memory.h"
#include "cache/shading_cache/renderer_parts.h"

static sl_vec3d corner_of(const sl_sampled_light *light, size_t k) { return sl_to_double(light->corner[k]); }

/* Two triangles with a common edge b c, and their other corners a and d opposite to each other: a + d = b + c. */
static void find_parallelogram(const sl_scene *scene, sl_area_light *area) {
    const sl_sampled_light *light = area->light;
    if (light->triangles != 2 || sl_scene_has_alpha(scene, light->triangle[0]) || sl_scene_has_alpha(scene, light->triangle[1])) return;
    for (size_t i = 0; i < 3; i++) {
        sl_vec3d a = corner_of(light, i), b = corner_of(light, (i + 1) % 3), c = corner_of(light, (i + 2) % 3);
        sl_vec3d d = sl_subd(sl_addd(b, c), a);
        for (size_t j = 3; j < 6; j++) {
            sl_vec3d before = corner_of(light, 3 + (j + 1) % 3), after = corner_of(light, 3 + (j + 2) % 3);
            double off = sl_lengthd(sl_subd(corner_of(light, j), d)) + sl_lengthd(sl_subd(before, c)) + sl_lengthd(sl_subd(after, b));
            if (!(off <= 1e-5 * (double)light->extent)) continue;
            area->parallelogram = true;
            area->a = a;
            area->e1 = sl_subd(b, a);
            area->e2 = sl_subd(c, a);
            return;
        }
    }
}

sl_status sl_area_light_make(const sl_scene *scene, const sl_sampled_light *light, uint64_t key, sl_area_light *area, sl_error *error) {
    *area = (sl_area_light){.light = light, .halton = sl_halton_make(key)};
    area->area_before = sl_allocate(light->triangles, sizeof *area->area_before);
    area->normal = sl_allocate(light->triangles, sizeof *area->normal);
    if (!area->area_before || !area->normal) return sl_fail_memory(error, "an area light");
    for (size_t t = 0; t < light->triangles; t++) {
        sl_vec3d a = corner_of(light, 3 * t);
        sl_vec3d cross = sl_crossd(sl_subd(corner_of(light, 3 * t + 1), a), sl_subd(corner_of(light, 3 * t + 2), a));
        double length = sl_lengthd(cross);
        if (length > 0.0) area->normal[t] = sl_scaled(cross, 1.0 / length);
        area->area_before[t] = area->area += 0.5 * length;
    }
    find_parallelogram(scene, area);
    return SL_OK;
}

void sl_area_light_release(sl_area_light *area) {
    sl_free(area->area_before);
    sl_free(area->normal);
    *area = (sl_area_light){.light = NULL};
}

static sl_area_point on_triangle(const sl_scene *scene, const sl_area_light *area, const double u[2]) {
    const sl_sampled_light *light = area->light;
    double at = u[0] * area->area;
    size_t low = 0, high = light->triangles - 1;
    while (low < high) {
        size_t middle = (low + high) / 2;
        if (at < area->area_before[middle]) high = middle;
        else low = middle + 1;
    }
    double before = low > 0 ? area->area_before[low - 1] : 0.0, own = area->area_before[low] - before;
    double s = sqrt(own > 0.0 ? fmin(fmax((at - before) / own, 0.0), 1.0) : 0.5), w1 = s * (1.0 - u[1]), w2 = s * u[1];
    sl_vec3d p = sl_scaled(corner_of(light, 3 * low), 1.0 - s);
    p = sl_addd(p, sl_scaled(corner_of(light, 3 * low + 1), w1));
    p = sl_addd(p, sl_scaled(corner_of(light, 3 * low + 2), w2));
    uint32_t triangle = light->triangle[low];
    bool shines = !sl_scene_has_alpha(scene, triangle) || sl_scene_is_opaque(scene, triangle, (float)w1, (float)w2);
    return (sl_area_point){p, area->normal[low], triangle, shines};
}

sl_area_point sl_area_light_point(const sl_scene *scene, const sl_area_light *area, uint32_t index) {
    double u[2];
    sl_halton_point(&area->halton, index, u);
    if (!area->parallelogram) return on_triangle(scene, area, u);
    sl_vec3d p = sl_addd(area->a, sl_addd(sl_scaled(area->e1, u[0]), sl_scaled(area->e2, u[1])));
    size_t half = u[0] + u[1] < 1.0 ? 0u : 1u;
    return (sl_area_point){p, area->normal[half], area->light->triangle[half], true};
}
