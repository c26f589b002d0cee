#include "cache/light/light_kernels.h"

size_t sl_emitter_sides(const sl_scene *scene) {
    size_t sides = 0;
    for (size_t i = 0; i < scene->emitter_count; i++) sides += scene->emitters[i].two_sided ? 2 : 1;
    return sides;
}

sl_light_source sl_light_source_of(const sl_light *light) {
    static const sl_source_kind kinds[] = {[SL_LIGHT_POINT] = SL_SOURCE_POINT,
                                           [SL_LIGHT_SPOT] = SL_SOURCE_SPOT,
                                           [SL_LIGHT_DIRECTIONAL] = SL_SOURCE_DIRECTIONAL};
    return (sl_light_source){.kind = kinds[light->type],
                             .position = light->position,
                             .direction = light->direction,
                             .cos_inner = light->cos_inner,
                             .cos_outer = light->cos_outer,
                             .colour = light->intensity};
}

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
