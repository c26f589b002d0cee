/* What curved mirrors show: their pixels look up the environment cubes with the reflected eye vector. And the trick, which
 * does without indirect light in the cubes. */
#include <math.h>
#include <string.h>

#include "base/counters.h"
#include "base/parallel.h"
#include "cache/direct_radiance/mirror_objects.h"
#include "trace/bsdf.h"

/* ---- look-up ---- */

typedef struct {
    const sl_curved_mirrors *mirrors;
    const sl_receivers *receivers;
    float *const *plane[SL_CUBE_PARTS];
    _Atomic uint64_t looked_up;
} reflecting;

/* Neighbours that show the same mirror, looked up together. */
typedef struct {
    uint32_t cube;
    size_t count, pixel[SL_TEXTURE_BLOCK];
    float x[SL_TEXTURE_BLOCK], y[SL_TEXTURE_BLOCK], z[SL_TEXTURE_BLOCK];
} look_ups;

/* The cube of the curved mirror that the pixel shows, or SL_NO_INDEX. */
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
        sl_cube_map_sample_many(map, l->count, l->x, l->y, l->z, NULL, (float *const[4]){seen[0], seen[1], seen[2], NULL});
        for (size_t i = 0; i < l->count; i++) {
            const sl_rgb ks = scene->materials[r->receivers->gbuffer->material[l->pixel[i]]].mirror;
            r->plane[p][0][l->pixel[i]] += ks.r * seen[0][i];
            r->plane[p][1][l->pixel[i]] += ks.g * seen[1][i];
            r->plane[p][2][l->pixel[i]] += ks.b * seen[2][i];
        }
    }
    l->count = 0;
}

static void reflect_row(void *context, size_t y, unsigned worker) {
    (void)worker;
    reflecting *r = context;
    const size_t width = (size_t)r->receivers->width;
    uint64_t count = 0;
    look_ups l = {.cube = SL_NO_INDEX, .count = 0};
    for (size_t i = y * width; i < (y + 1) * width; i++) {
        const uint32_t cube = cube_at(r, i);
        if (cube == SL_NO_INDEX) continue;
        if (cube != l.cube || l.count == SL_TEXTURE_BLOCK) look_up(r, &l);
        l.cube = cube;
        append(r, i, &l);
        count++;
    }
    look_up(r, &l);
    if (count) r->looked_up += count;
}

void sl_curved_mirrors_reflect(const sl_curved_mirrors *mirrors, const sl_receivers *receivers, unsigned threads, float *const emission[3],
                               float *const direct[3], float *const indirect[3], sl_counters *counters) {
    if (!mirrors) return;
    reflecting r = {.mirrors = mirrors, .receivers = receivers, .plane = {emission, direct, indirect}};
    uint64_t parts = 0;
    for (int p = 0; p < SL_CUBE_PARTS; p++) parts += mirrors->cube[0].part[p] != NULL;
    sl_parallel_for(sl_thread_count(threads), (size_t)receivers->height, reflect_row, &r);
    sl_count(counters, SL_COUNT_FRAGMENTS_SHADED, r.looked_up);
    sl_count(counters, SL_COUNT_TEXTURE_FETCHES, r.looked_up * parts);
}

/* ---- the trick ---- */

/* The mean over the triangle: exact where the colour is quadratic in the weights. */
static sl_rgb albedo_of(const sl_scene *scene, uint32_t t) {
    const sl_material *m = &scene->materials[scene->material_index[t]];
    if (m->texture == SL_NO_INDEX) return m->diffuse;
    const float far = 2.0f / 3.0f, near = 1.0f / 6.0f;
    sl_rgb sum = sl_rgb_add(sl_scene_diffuse(scene, t, near, near), sl_scene_diffuse(scene, t, far, near));
    return sl_rgb_scale(sl_rgb_add(sum, sl_scene_diffuse(scene, t, near, far)), 1.0f / 3.0f);
}

sl_rgb sl_trick_albedo(const sl_scene *scene) {
    double sum[3] = {0.0, 0.0, 0.0}, whole = 0.0;
    for (uint32_t t = 0; t < scene->triangle_count; t++) {
        if (sl_material_is_mirror(&scene->materials[scene->material_index[t]])) continue;
        sl_vec3d a = sl_to_double(sl_scene_position(scene, scene->vertex[0][t]));
        sl_vec3d b = sl_subd(sl_to_double(sl_scene_position(scene, scene->vertex[1][t])), a);
        sl_vec3d c = sl_subd(sl_to_double(sl_scene_position(scene, scene->vertex[2][t])), a);
        const double area = 0.5 * sl_lengthd(sl_crossd(b, c));
        const sl_rgb albedo = albedo_of(scene, t);
        if (!isfinite(area)) continue;
        sum[0] += area * (double)albedo.r;
        sum[1] += area * (double)albedo.g;
        sum[2] += area * (double)albedo.b;
        whole += area;
    }
    const double over = whole > 0.0 ? 1.0 / whole : 0.0;
    return (sl_rgb){(float)(sum[0] * over), (float)(sum[1] * over), (float)(sum[2] * over)};
}
