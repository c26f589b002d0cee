#include "scene/derive.h"

#include <float.h>
#include <math.h>

#include "base/error.h"
#include "base/memory.h"

bool sl_triangle_cross(sl_vec3 a, sl_vec3 b, sl_vec3 c, sl_vec3d *cross) {
    sl_vec3d origin = sl_to_double(a);
    *cross = sl_crossd(sl_subd(sl_to_double(b), origin), sl_subd(sl_to_double(c), origin));
    double length_squared = sl_dotd(*cross, *cross);
    return length_squared > 0.0 && isfinite(length_squared);
}

static void derive_bounds(sl_scene *scene) {
    sl_box box = sl_box_empty();
    for (size_t v = 0; v < scene->vertex_count; v++) sl_box_add(&box, sl_scene_position(scene, (uint32_t)v));
    scene->box_min = box.low;
    scene->box_max = box.high;
    double diagonal = sl_lengthd(sl_subd(sl_to_double(box.high), sl_to_double(box.low)));
    scene->diagonal = (float)fmin(fmax(diagonal, (double)FLT_MIN), (double)FLT_MAX);
    sl_scene_measure(scene);
}

size_t sl_scene_derive(sl_scene *scene) {
    size_t without_area = 0, emissive = 0;
    scene->emitter_count = 0;
    for (size_t t = 0; t < scene->triangle_count; t++) {
        sl_vec3d cross;
        bool has_area = sl_triangle_cross(sl_scene_position(scene, scene->vertex[0][t]),
                                          sl_scene_position(scene, scene->vertex[1][t]),
                                          sl_scene_position(scene, scene->vertex[2][t]), &cross);
        double length = has_area ? sl_lengthd(cross) : 0.0;
        sl_vec3 normal = has_area ? sl_to_float(sl_scaled(cross, 1.0 / length))
                                  : sl_scene_normal(scene, scene->vertex[0][t]);
        sl_put(scene->geometric_normal_x, scene->geometric_normal_y, scene->geometric_normal_z, t, normal);
        scene->emitter_of_triangle[t] = SL_NO_INDEX;
        const sl_material *material = sl_triangle_material(scene, t);
        if (!sl_material_is_emitter(material)) continue;
        float area = (float)(0.5 * length), opaque = scene->opaque_share[emissive++];
        if (!(area > 0.0f) || !isfinite(area)) {
            without_area++;
            continue;
        }
        scene->emitter_of_triangle[t] = (uint32_t)scene->emitter_count;
        scene->emitters[scene->emitter_count++] =
            (sl_emitter){(uint32_t)t, area, material->emission, material->emission_two_sided, opaque};
    }
    derive_bounds(scene);
    return without_area;
}

static void find_opaque_shares(sl_scene *scene) {
    size_t emissive = 0;
    for (size_t t = 0; t < scene->triangle_count; t++) {
        if (sl_material_is_emitter(sl_triangle_material(scene, t)))
            scene->opaque_share[emissive++] = sl_scene_opaque_share(scene, (uint32_t)t);
    }
}

sl_status sl_scene_make_emitters(sl_scene *scene, sl_error *error) {
    size_t emissive = 0;
    for (size_t t = 0; t < scene->triangle_count; t++)
        emissive += sl_material_is_emitter(sl_triangle_material(scene, t));
    scene->emitters = sl_allocate(emissive, sizeof *scene->emitters);
    scene->opaque_share = sl_allocate(emissive, sizeof *scene->opaque_share);
    scene->emissive_count = emissive;
    if (!scene->emitters || !scene->opaque_share) return sl_fail_memory(error, "the scene's emitters");
    find_opaque_shares(scene);
    size_t without_area = sl_scene_derive(scene);
    if (without_area)
        sl_scene_warn(scene,
                      "%zu emissive triangles are too small (or too large) to have an area and give no light",
                      without_area);
    return SL_OK;
}
