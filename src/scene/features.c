#include "scene/features.h"

sl_features sl_scene_features(const sl_scene *scene) {
    sl_features features = {.emitters = scene->emitter_count,
                            .environment = scene->environment.present,
                            .animated = scene->animation != NULL};
    for (size_t t = 0; t < scene->triangle_count; t++) {
        const sl_material *material = &scene->materials[scene->material_index[t]];
        features.diffuse_triangles += sl_material_is_diffuse(material);
        features.glossy_triangles += sl_material_is_glossy(material);
        features.mirror_triangles += sl_material_is_mirror(material);
        features.emissive_triangles += sl_material_is_emitter(material);
        features.textured_triangles += material->texture != SL_NO_INDEX;
        features.masked_triangles += material->alpha_texture != SL_NO_INDEX;
    }
    for (size_t i = 0; i < scene->light_count; i++) {
        features.point_lights += scene->lights[i].type == SL_LIGHT_POINT;
        features.spot_lights += scene->lights[i].type == SL_LIGHT_SPOT;
        features.directional_lights += scene->lights[i].type == SL_LIGHT_DIRECTIONAL;
    }
    return features;
}
