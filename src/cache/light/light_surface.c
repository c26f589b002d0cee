/* Points spread over an area light (lights.h). */
#include <math.h>

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "cache/light/lights.h"

/* Two triangles with a common edge b c, and their other corners a and d opposite to each other: a + d = b +
 * c. */
static void find_parallelogram(const sl_sampled_light *light, sl_light_surface *surface) {
    const double room = 2e-5 * (double)light->extent;
    if (light->triangles != 2) return;
    for (size_t i = 0; i < 3; i++) {
        sl_vec3d a = sl_light_corner(light, i), b = sl_light_corner(light, (i + 1) % 3),
                 c = sl_light_corner(light, (i + 2) % 3);
        sl_vec3d opposite = sl_subd(sl_addd(b, c), a);
        for (size_t j = 0; j < 3; j++) {
            sl_vec3d d = sl_light_corner(light, 3 + j), after = sl_light_corner(light, 3 + (j + 1) % 3),
                     before = sl_light_corner(light, 3 + (j + 2) % 3);
            if (sl_lengthd(sl_subd(after, c)) > room || sl_lengthd(sl_subd(before, b)) > room) continue;
            if (sl_lengthd(sl_subd(d, opposite)) > room) continue;
            surface->parallelogram = true;
            surface->corner = a;
            surface->e1 = sl_subd(b, a);
            surface->e2 = sl_subd(c, a);
            return;
        }
    }
}

sl_status sl_light_surface_make(const sl_sampled_light *light, sl_light_surface *surface, sl_error *error) {
    *surface = (sl_light_surface){.area_before = sl_allocate(light->triangles, sizeof *surface->area_before)};
    if (!surface->area_before) return sl_fail_memory(error, "a lamp");
    for (size_t t = 0; t < light->triangles; t++)
        surface->area_before[t] = surface->area += 0.5 * sl_lengthd(sl_light_cross(light, t));
    find_parallelogram(light, surface);
    return SL_OK;
}

void sl_light_surface_release(sl_light_surface *surface) {
    sl_free(surface->area_before);
    surface->area_before = NULL;
}

sl_vec3d sl_light_surface_point(const sl_sampled_light *light, const sl_light_surface *surface,
                                const double u[2], size_t *triangle, double weight[2]) {
    const double at = u[0] * surface->area;
    const size_t low = sl_first_above(surface->area_before, light->triangles, at);
    double before = low > 0 ? surface->area_before[low - 1] : 0.0, own = surface->area_before[low] - before;
    double s = sqrt(own > 0.0 ? fmin(fmax((at - before) / own, 0.0), 1.0) : 0.5);
    weight[0] = s * (1.0 - u[1]);
    weight[1] = s * u[1];
    *triangle = low;
    sl_vec3d p = sl_scaled(sl_light_corner(light, 3 * low), 1.0 - s);
    p = sl_addd(p, sl_scaled(sl_light_corner(light, 3 * low + 1), weight[0]));
    return sl_addd(p, sl_scaled(sl_light_corner(light, 3 * low + 2), weight[1]));
}
