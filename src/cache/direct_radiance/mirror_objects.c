#include "cache/direct_radiance/mirror_objects.h"

#include <float.h>

#include "base/error.h"
#include "base/memory.h"

static bool has_mirror_material(const sl_scene *scene) {
    for (size_t m = 0; m < scene->material_count; m++) {
        if (sl_material_is_mirror(&scene->materials[m])) return true;
    }
    return false;
}

/* ---- in sight ---- */

static void mark_seen(const sl_scene *scene, const sl_mirrors *planar, const sl_receivers *seen, bool *wanted) {
    const sl_gbuffer *g = seen->gbuffer;
    const size_t pixels = (size_t)seen->width * (size_t)seen->height;
    uint32_t before = SL_NO_INDEX; /* mostly a pixel shows what its neighbour shows */
    for (size_t i = 0; i < pixels; i++) {
        const uint32_t id = g->id[i];
        if (id == before || id == SL_NO_INDEX) continue;
        before = id;
        if (sl_is_curved_mirror(scene, planar, id)) wanted[scene->object_index[id]] = true;
    }
}

/* ---- boxes ---- */

static void enclose(sl_mirror_object *o, sl_vec3 p) {
    o->low = sl_v3(fminf(o->low.x, p.x), fminf(o->low.y, p.y), fminf(o->low.z, p.z));
    o->high = sl_v3(fmaxf(o->high.x, p.x), fmaxf(o->high.y, p.y), fmaxf(o->high.z, p.z));
}

static sl_vec3 middle_of(const sl_mirror_object *o) {
    sl_vec3d sum = sl_addd(sl_to_double(o->low), sl_to_double(o->high));
    return sl_to_float(sl_scaled(sum, 0.5));
}

static void find_boxes(const sl_scene *scene, const sl_mirrors *planar, const bool *wanted, sl_mirror_objects *objects) {
    for (uint32_t o = 0; o < scene->object_count; o++) objects->cube_of[o] = SL_NO_INDEX;
    for (uint32_t t = 0; t < scene->triangle_count; t++) {
        const uint32_t o = scene->object_index[t];
        if ((wanted && !wanted[o]) || !sl_is_curved_mirror(scene, planar, t)) continue;
        objects->cube_of[o] = 0;
    }
    for (uint32_t o = 0; o < scene->object_count; o++) {
        if (objects->cube_of[o] == SL_NO_INDEX) continue;
        objects->cube_of[o] = (uint32_t)objects->count;
        objects->object[objects->count++] = (sl_mirror_object){.object = o, .low = {FLT_MAX, FLT_MAX, FLT_MAX},
                                                               .high = {-FLT_MAX, -FLT_MAX, -FLT_MAX}};
    }
    for (uint32_t t = 0; objects->count && t < scene->triangle_count; t++) {
        const uint32_t cube = objects->cube_of[scene->object_index[t]];
        if (cube == SL_NO_INDEX || !sl_is_curved_mirror(scene, planar, t)) continue;
        for (int k = 0; k < 3; k++) enclose(&objects->object[cube], sl_scene_position(scene, scene->vertex[k][t]));
    }
    for (size_t n = 0; n < objects->count; n++) objects->object[n].centre = middle_of(&objects->object[n]);
}

sl_status sl_mirror_objects_find(const sl_scene *scene, const sl_mirrors *planar, const sl_receivers *seen, sl_mirror_objects *objects,
                                 sl_error *error) {
    *objects = (sl_mirror_objects){.count = 0};
    if (!has_mirror_material(scene)) return SL_OK;
    bool *wanted = sl_allocate(scene->object_count, sizeof *wanted), any = !seen;
    objects->object = sl_allocate(scene->object_count, sizeof *objects->object);
    objects->cube_of = sl_allocate(scene->object_count, sizeof *objects->cube_of);
    bool ok = wanted && objects->object && objects->cube_of;
    if (ok && seen) mark_seen(scene, planar, seen, wanted);
    for (size_t o = 0; ok && o < scene->object_count; o++) any |= wanted[o];
    if (ok && any) find_boxes(scene, planar, seen ? wanted : NULL, objects);
    sl_free(wanted);
    if (ok) return SL_OK;
    sl_mirror_objects_release(objects);
    return sl_fail_memory(error, "the curved mirrors");
}

void sl_mirror_objects_release(sl_mirror_objects *objects) {
    sl_free(objects->object);
    sl_free(objects->cube_of);
    *objects = (sl_mirror_objects){.count = 0};
}

/* ---- left out ---- */

static bool lies_within(const sl_scene *scene, uint32_t t, const sl_mirror_object *o) {
    for (int k = 0; k < 3; k++) {
        sl_vec3 p = sl_scene_position(scene, scene->vertex[k][t]);
        bool inside = p.x >= o->low.x && p.x <= o->high.x && p.y >= o->low.y && p.y <= o->high.y && p.z >= o->low.z && p.z <= o->high.z;
        if (!inside) return false;
    }
    return true;
}

void sl_mirror_object_mark(const sl_scene *scene, const sl_mirror_object *object, uint8_t *left_out) {
    for (uint32_t t = 0; t < scene->triangle_count; t++) {
        left_out[t] = scene->object_index[t] == object->object &&
                      sl_material_is_mirror(&scene->materials[scene->material_index[t]]) && lies_within(scene, t, object);
    }
}
