/* Points spread over area lights by Halton's sequence (bases 2 and 3), its digits shifted by fixed numbers.
 */
#include "base/error.h"
#include "base/memory.h"
#include "base/random.h"
#include "cache/shading_cache/renderer_parts.h"

sl_halton sl_halton_make(uint64_t key) {
    sl_halton h = {.shift_2 = sl_random_bits(sl_random_key(key, 2), 0)};
    uint64_t key_3 = sl_random_key(key, 3);
    double place[SL_HALTON_DIGITS], size = 1.0;
    for (int k = 0; k < SL_HALTON_DIGITS; k++) {
        h.shift_3[k] = (uint8_t)(sl_random_bits(key_3, (uint64_t)k) % 3);
        place[k] = size /= 3.0;
    }
    for (int k = SL_HALTON_DIGITS - 1; k >= 0; k--)
        h.rest_3[k] = h.rest_3[k + 1] + place[k] * (double)h.shift_3[k];
    return h;
}

void sl_halton_point(const sl_halton *h, uint32_t index, double point[2]) {
    point[0] = (double)(sl_van_der_corput(index) ^ h->shift_2) * 0x1p-32;
    double x = 0.0, place = 1.0;
    int k = 0;
    for (; k < SL_HALTON_DIGITS && index > 0; k++, index /= 3) {
        place /= 3.0;
        x += place * (double)((index + h->shift_3[k]) % 3);
    }
    x += h->rest_3[k];
    point[1] = x < 1.0 ? x : 0x1.fffffffffffffp-1;
}

static sl_vec3d normal_of(const sl_sampled_light *light, size_t t) {
    sl_vec3d a = sl_to_double(light->corner[3 * t]), b = sl_to_double(light->corner[3 * t + 1]);
    sl_vec3d cross = sl_crossd(sl_subd(b, a), sl_subd(sl_to_double(light->corner[3 * t + 2]), a));
    double length = sl_lengthd(cross);
    return length > 0.0 ? sl_scaled(cross, 1.0 / length) : sl_v3d(0.0, 0.0, 0.0);
}

sl_status sl_area_light_make(const sl_scene *scene, const sl_sampled_light *light, uint64_t key,
                             sl_area_light *area, sl_error *error) {
    *area = (sl_area_light){.light = light, .halton = sl_halton_make(key)};
    sl_status status = sl_light_surface_make(light, &area->surface, error);
    if (status != SL_OK) return status;
    area->normal = sl_allocate(light->triangles, sizeof *area->normal);
    if (!area->normal) return sl_fail_memory(error, "an area light");
    for (size_t t = 0; t < light->triangles; t++) {
        area->normal[t] = normal_of(light, t);
        /* masks are looked up by triangle */
        if (sl_scene_has_alpha(scene, light->triangle[t])) area->surface.parallelogram = false;
    }
    return SL_OK;
}

void sl_area_light_release(sl_area_light *area) {
    sl_light_surface_release(&area->surface);
    sl_free(area->normal);
    *area = (sl_area_light){.light = NULL};
}

sl_area_point sl_area_light_point(const sl_scene *scene, const sl_area_light *area, uint32_t index) {
    const sl_light_surface *surface = &area->surface;
    double u[2], w[2];
    size_t t;
    sl_halton_point(&area->halton, index, u);
    if (surface->parallelogram) {
        sl_vec3d p =
            sl_addd(surface->corner, sl_addd(sl_scaled(surface->e1, u[0]), sl_scaled(surface->e2, u[1])));
        t = u[0] + u[1] < 1.0 ? 0u : 1u;
        return (sl_area_point){p, area->normal[t], area->light->triangle[t], true};
    }
    sl_vec3d p = sl_light_surface_point(area->light, surface, u, &t, w);
    uint32_t triangle = area->light->triangle[t];
    bool shines =
        !sl_scene_has_alpha(scene, triangle) || sl_scene_is_opaque(scene, triangle, (float)w[0], (float)w[1]);
    return (sl_area_point){p, area->normal[t], triangle, shines};
}
