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

void sl_path_lens_ray(const sl_scene *scene, const sl_path_lens *lens, float x, float y, sl_ray16 *rays,
                      unsigned i) {
    float u = (2.0f * x / (float)lens->width - 1.0f) * lens->tan_x;
    float v = (1.0f - 2.0f * y / (float)lens->height) * lens->tan_y;
    const sl_camera *c = &scene->camera;
    sl_vec3 direction =
        sl_normalize_or(sl_sub(sl_mad(sl_scale(c->right, u), v, c->up), c->back), sl_neg(c->back));
    sl_ray16_set(rays, i, c->eye, direction, 0.0f, INFINITY, SL_NO_INDEX);
}

void sl_path_camera_ray(const sl_path_walk *walk, const sl_path_lens *lens, int x, int y, uint64_t key,
                        uint32_t index, sl_ray16 *rays, unsigned i) {
    float point[3] = {0.5f, 0.5f, 0.0f};
    if (walk->transport.filter == SL_FILTER_BOX)
        sl_sequence_point(walk->sequence, key, SL_SET_PIXEL, index, point);
    sl_path_lens_ray(walk->scene, lens, (float)x + point[0], (float)y + point[1], rays, i);
}

sl_rgb sl_path_finite_or_black(sl_rgb radiance, sl_counters *counters) {
    if (sl_rgb_is_finite(radiance)) return radiance;
    sl_count(counters, SL_COUNT_NONFINITE, 1);
    return sl_grey(0.0f);
}
