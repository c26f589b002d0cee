#include "scene/features.h"

#include "scene/sight.h"

static void count_triangles(sl_features *features, const sl_material *material, size_t count) {
    if (sl_material_is_diffuse(material)) features->diffuse_triangles += count;
    if (sl_material_is_glossy(material)) features->glossy_triangles += count;
    if (sl_material_is_mirror(material)) features->mirror_triangles += count;
    if (sl_material_is_emitter(material)) features->emissive_triangles += count;
    if (material->texture != SL_NO_INDEX) features->textured_triangles += count;
    if (material->alpha_texture != SL_NO_INDEX) features->masked_triangles += count;
}

/* Neighbours in the list mostly have one material. */
sl_features sl_scene_features(const sl_scene *scene) {
    sl_features features = {.emitters = scene->emitter_count,
                            .environment = scene->environment.present,
                            .animated = scene->animation != NULL};
    for (size_t t = 0, end; t < scene->triangle_count; t = end) {
        const uint32_t material = scene->material_index[t];
        for (end = t + 1; end < scene->triangle_count && scene->material_index[end] == material;) end++;
        count_triangles(&features, &scene->materials[material], end - t);
    }
    for (size_t i = 0; i < scene->light_count; i++) {
        if (!sl_light_is_lit(&scene->lights[i])) continue;
        features.light = true;
        features.point_lights += scene->lights[i].type == SL_LIGHT_POINT;
        features.spot_lights += scene->lights[i].type == SL_LIGHT_SPOT;
        features.directional_lights += scene->lights[i].type == SL_LIGHT_DIRECTIONAL;
    }
    features.light = features.light || features.emitters > 0 || features.environment ||
                     (features.animated && features.emissive_triangles > 0);
    return features;
}

bool sl_scene_is_in_view(const sl_scene *scene) {
    sl_sight sight;
    sl_sight_view(&sight, scene, &scene->camera);
    return sl_sight_counted(&sight, scene).hit > 0;
}
