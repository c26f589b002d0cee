#include "cache/light/light_kernels.h"

sl_polygon_light sl_polygon_light_of(const sl_scene *scene, const sl_emitter *e, bool back) {
    sl_polygon_light p = {.normal = sl_scene_geometric_normal(scene, e->triangle), .area = e->area};
    for (int c = 0; c < 3; c++) p.corner[c] = sl_scene_position(scene, scene->vertex[c][e->triangle]);
    if (back) {
        sl_vec3 first = p.corner[1];
        p.corner[1] = p.corner[2];
        p.corner[2] = first;
        p.normal = sl_neg(p.normal);
    }
    sl_vec3 centre = sl_scale(sl_add(sl_add(p.corner[0], p.corner[1]), p.corner[2]), 1.0f / 3.0f);
    for (int c = 0; c < 3; c++) {
        sl_vec3 d = sl_sub(p.corner[c], centre);
        p.extent_squared = fmaxf(p.extent_squared, sl_dot(d, d));
    }
    return p;
}
