/* The rays with which walks begin: through the pixels of a film. */
#include "trace/path_walk.h"

#include <math.h>

#include "base/counters.h"
#include "base/math.h"

sl_path_lens sl_path_lens_of(const sl_scene *scene, int width, int height) {
    double tangent = sl_tan(0.5 * (double)scene->camera.vertical_fov),
           aspect = (double)width / (double)height;
    return (sl_path_lens){width, height, (float)(tangent * aspect), (float)tangent};
}

sl_path_tangents sl_path_lens_tangents(const sl_path_lens *lens, sl_path_place place) {
    return (sl_path_tangents){(2.0f * place.x / (float)lens->width - 1.0f) * lens->tan_x,
                              (1.0f - 2.0f * place.y / (float)lens->height) * lens->tan_y};
}

sl_vec3 sl_path_lens_direction(const sl_scene *scene, sl_path_tangents t) {
    const sl_camera *c = &scene->camera;
    return sl_normalize_or(sl_sub(sl_mad(sl_scale(c->right, t.x), t.y, c->up), c->back), sl_neg(c->back));
}

void sl_path_lens_ray(const sl_scene *scene, const sl_path_lens *lens, sl_path_place place, sl_ray16 *rays,
                      unsigned i) {
    sl_vec3 direction = sl_path_lens_direction(scene, sl_path_lens_tangents(lens, place));
    sl_ray16_set(rays, i, scene->camera.eye, direction, 0.0f, INFINITY, SL_NO_INDEX);
}

sl_path_place sl_path_place_in(const sl_path_walk *walk, int x, int y, uint64_t key, uint32_t index) {
    float point[3] = {0.5f, 0.5f, 0.0f};
    if (walk->transport.filter != SL_FILTER_CENTRE)
        sl_sequence_point(walk->sequence, key, SL_SET_PIXEL, index, point);
    sl_pixel_shape_place(&walk->shape, point);
    return (sl_path_place){(float)x + point[0], (float)y + point[1]};
}

sl_rgb sl_path_finite_or_black(sl_rgb radiance, sl_counters *counters) {
    if (sl_rgb_is_finite(radiance)) return radiance;
    sl_count(counters, SL_COUNT_NONFINITE, 1);
    return sl_grey(0.0f);
}
