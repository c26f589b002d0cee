/* The contents of a scene, on which plans are made: one look over materials, lights and triangles. */
#pragma once

#include "scene/scene.h"

typedef struct sl_features {
    size_t diffuse_triangles, glossy_triangles, mirror_triangles, emissive_triangles, textured_triangles,
        masked_triangles;
    size_t point_lights, spot_lights, directional_lights, emitters;
    bool environment, animated;
    bool light; /* of any of these, or of a lamp that has no area now: keyframes may give it one */
} sl_features;

sl_features sl_scene_features(const sl_scene *scene);
/* Tells whether any of a few dozen rays through the camera's picture hits something. */
bool sl_scene_is_in_view(const sl_scene *scene);
