#include "base/counters.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/direct_radiance/direct_radiance.h"
#include "trace/bsdf.h"

#include <float.h>
#include <math.h>
#include <string.h>

static bool has_mirror_material(const sl_scene *scene) {
    for (size_t m = 0; m < scene->material_count; m++) {
        if (sl_material_is_mirror(&scene->materials[m])) return true;
    }
    return false;
}

bool sl_has_curved_mirrors(const sl_scene *scene, const sl_mirrors *planar) {
    if (!has_mirror_material(scene)) return false;
    for (uint32_t t = 0; t < scene->triangle_count; t++) {
        if (sl_is_curved_mirror(scene, planar, t)) return true;
    }
    return false;
}

/* ---- in sight ---- */

static void mark_seen(const sl_scene *scene, const sl_mirrors *planar, const sl_receivers *seen,
                      bool *wanted) {
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

static void find_boxes(const sl_scene *scene, const sl_mirrors *planar, const bool *wanted,
                       sl_mirror_objects *objects) {
    for (uint32_t o = 0; o < scene->object_count; o++) objects->cube_of[o] = SL_NO_INDEX;
    for (uint32_t t = 0; t < scene->triangle_count; t++) {
        const uint32_t o = scene->object_index[t];
        if ((wanted && !wanted[o]) || !sl_is_curved_mirror(scene, planar, t)) continue;
        objects->cube_of[o] = 0;
    }
    for (uint32_t o = 0; o < scene->object_count; o++) {
        if (objects->cube_of[o] == SL_NO_INDEX) continue;
        objects->cube_of[o] = (uint32_t)objects->count;
        objects->object[objects->count++] = (sl_mirror_object){
            .object = o, .low = {FLT_MAX, FLT_MAX, FLT_MAX}, .high = {-FLT_MAX, -FLT_MAX, -FLT_MAX}};
    }
    for (uint32_t t = 0; objects->count && t < scene->triangle_count; t++) {
        const uint32_t cube = objects->cube_of[scene->object_index[t]];
        if (cube == SL_NO_INDEX || !sl_is_curved_mirror(scene, planar, t)) continue;
        for (int k = 0; k < 3; k++)
            enclose(&objects->object[cube], sl_scene_position(scene, scene->vertex[k][t]));
    }
    for (size_t n = 0; n < objects->count; n++) objects->object[n].centre = middle_of(&objects->object[n]);
}

sl_status sl_mirror_objects_find(const sl_scene *scene, const sl_mirrors *planar, const sl_receivers *seen,
                                 sl_mirror_objects *objects, sl_error *error) {
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
        bool inside = p.x >= o->low.x && p.x <= o->high.x && p.y >= o->low.y && p.y <= o->high.y &&
                      p.z >= o->low.z && p.z <= o->high.z;
        if (!inside) return false;
    }
    return true;
}

void sl_mirror_object_mark(const sl_scene *scene, const sl_mirror_object *object, uint8_t *left_out) {
    for (uint32_t t = 0; t < scene->triangle_count; t++) {
        left_out[t] = scene->object_index[t] == object->object &&
                      sl_material_is_mirror(&scene->materials[scene->material_index[t]]) &&
                      lies_within(scene, t, object);
    }
}

/* ---- the picture in a curved mirror ---- */

/* Pixels of curved mirrors look up the environment cubes with the reflected eye vector. */

/* ---- look-up ---- */

typedef struct {
    const sl_curved_mirrors *mirrors;
    const sl_receivers *receivers;
    float *const *plane[SL_CUBE_PARTS];
} reflecting;

/* Neighbours that show the same mirror, looked up together. */
typedef struct {
    uint32_t cube;
    size_t count, pixel[SL_TEXTURE_BLOCK];
    float x[SL_TEXTURE_BLOCK], y[SL_TEXTURE_BLOCK], z[SL_TEXTURE_BLOCK];
} look_ups;

/* Returns the cube of the curved mirror that the pixel shows, or SL_NO_INDEX. */
static uint32_t cube_at(const reflecting *r, size_t pixel) {
    const sl_curved_mirrors *m = r->mirrors;
    const sl_gbuffer *g = r->receivers->gbuffer;
    const uint32_t material = g->material[pixel], id = g->id[pixel];
    if (material == SL_NO_INDEX || !sl_material_is_mirror(&m->scene->materials[material])) return SL_NO_INDEX;
    if (!sl_is_curved_mirror(m->scene, m->planar, id)) return SL_NO_INDEX;
    return m->objects.cube_of[m->scene->object_index[id]];
}

static void append(const reflecting *r, size_t pixel, look_ups *l) {
    const sl_gbuffer *g = r->receivers->gbuffer;
    sl_vec3 x = sl_v3(g->position_x[pixel], g->position_y[pixel], g->position_z[pixel]);
    sl_vec3 n = sl_v3(g->normal_x[pixel], g->normal_y[pixel], g->normal_z[pixel]);
    sl_vec3 to_eye = sl_normalize_or(sl_sub(sl_receiver_eye(r->receivers, pixel), x), n);
    sl_vec3 along = sl_reflect(to_eye, n);
    l->pixel[l->count] = pixel;
    l->x[l->count] = along.x;
    l->y[l->count] = along.y;
    l->z[l->count] = along.z;
    l->count++;
}

static void look_up(const reflecting *r, look_ups *l) {
    const sl_scene *scene = r->mirrors->scene;
    float seen[4][SL_TEXTURE_BLOCK];
    for (int p = 0; l->count && p < SL_CUBE_PARTS; p++) {
        const sl_cube_map *map = r->mirrors->cube[l->cube].part[p];
        if (!map) continue;
        sl_cube_map_sample_many(map, l->count, l->x, l->y, l->z, NULL,
                                (float *const[4]){seen[0], seen[1], seen[2], NULL});
        for (size_t i = 0; i < l->count; i++) {
            const sl_rgb ks = scene->materials[r->receivers->gbuffer->material[l->pixel[i]]].mirror;
            r->plane[p][0][l->pixel[i]] += ks.r * seen[0][i];
            r->plane[p][1][l->pixel[i]] += ks.g * seen[1][i];
            r->plane[p][2][l->pixel[i]] += ks.b * seen[2][i];
        }
    }
    l->count = 0;
}

void sl_curved_mirrors_reflect(const sl_curved_mirrors *mirrors, const sl_receivers *receivers,
                               float *const emission[3], float *const direct[3], float *const indirect[3],
                               sl_counters *counters) {
    if (!mirrors) return;
    const reflecting r = {mirrors, receivers, {emission, direct, indirect}};
    const size_t pixels = (size_t)receivers->width * (size_t)receivers->height;
    uint64_t parts = 0, count = 0;
    look_ups l = {.cube = SL_NO_INDEX, .count = 0};
    for (int p = 0; p < SL_CUBE_PARTS; p++) parts += mirrors->cube[0].part[p] != NULL;
    for (size_t i = 0; i < pixels; i++) {
        const uint32_t cube = cube_at(&r, i);
        if (cube == SL_NO_INDEX) continue;
        if (cube != l.cube || l.count == SL_TEXTURE_BLOCK) look_up(&r, &l);
        l.cube = cube;
        append(&r, i, &l);
        count++;
    }
    look_up(&r, &l);
    sl_count(counters, SL_COUNT_FRAGMENTS_SHADED, count);
    sl_count(counters, SL_COUNT_TEXTURE_FETCHES, count * parts);
}
