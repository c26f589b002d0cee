/* As little work as every method can be asked for: where what matters is that a picture is made, not which.
 */
#pragma once

#include "cache/frame/settings.h"

static inline sl_settings least_settings(const char *method, int width, int height) {
    sl_settings s = sl_settings_of_papers();
    s.method = method;
    s.width = width;
    s.height = height;
    s.quality = SL_QUALITY_DRAFT;
    s.threads = 1;
    s.spp = 1;
    s.accuracy = s.glossy_accuracy = 2.0;
    s.hit_samples = 1;
    s.gather_size = 8;
    s.radiance_map.samples = 2;
    s.radiance_map.map_size = 4;
    s.radiance_map.shadow_size = 16;
    s.light_octree.depth = 3;
    s.light_octree.photons = 400;
    s.light_octree.neighbours = 20;
    s.multi_mesh.light_size = 16; /* the least there is */
    s.multi_mesh.max_depth = 3;
    s.multi_mesh.coarse_depth = 1;
    s.shading_cache.points = 30;
    s.shading_cache.updates = 4;
    s.shading_cache.indirect_samples = 2;
    s.shading_cache.area_samples = 4;
    return s;
}
