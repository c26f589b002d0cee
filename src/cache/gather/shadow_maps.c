#include "cache/gather/shadow_maps.h"

#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/random.h"

enum { EMITTERS_MAX = 32, AREA_CUBES = 32, AREA_GRID_MAX = 4, SKY_LIGHTS = 32 };

/* A directional light's view of the scene: three rows that take p - centre to [-1,1]^2 and window depth. */
typedef struct depth_map {
    sl_frame frame;
    sl_vec3 centre;
    float reach_x, reach_y, reach_z; /* half extents of the scene's box along the frame's axes */
    float *depth;
} depth_map;

typedef struct shadow_light {
    sl_light light;      /* what lights without extent give; a sky light is a directional one */
    sl_depth_cube *cube; /* or, for directional lights, */
    depth_map map;
    bool area;           /* a sample of an emitter instead: */
    sl_vec3 normal;
    sl_rgb power;        /* radiance x area */
    float extent;        /* area / pi, which keeps 1 / distance^2 finite: the sample stands for a disc */
} shadow_light;

struct sl_shadow_maps {
    const sl_scene *scene;
    const sl_raster *raster;
    int size;
    float offset;
    size_t count, capacity;
    shadow_light *lights;
};

/* ---- making --------------------------------------------------------------------------------------------------------- */

static float absolute_dot(sl_vec3 a, sl_vec3 b) {
    return fabsf(a.x * b.x) + fabsf(a.y * b.y) + fabsf(a.z * b.z);
}

static sl_status make_depth_map(const sl_shadow_maps *maps, sl_vec3 direction, unsigned threads, depth_map *map,
                                sl_counters *counters, sl_error *error) {
    const sl_scene *s = maps->scene;
    sl_vec3 half = sl_scale(sl_sub(s->box_max, s->box_min), 0.5f);
    float margin = 1e-3f * s->diagonal;
    map->frame = sl_frame_from_normal(direction);
    map->centre = sl_mad(s->box_min, 1.0f, half);
    map->reach_x = absolute_dot(map->frame.x, half) + margin;
    map->reach_y = absolute_dot(map->frame.y, half) + margin;
    map->reach_z = absolute_dot(map->frame.z, half) + margin;
    map->depth = sl_allocate((size_t)maps->size * (size_t)maps->size, sizeof(float));
    if (!map->depth) return sl_fail_memory(error, "a shadow map");

    sl_view view = {.origin = map->centre, .width = maps->size, .height = maps->size, .depth = SL_DEPTH_WINDOW,
                    .skip_triangle = SL_NO_INDEX};
    sl_vec3 rows[3] = {sl_scale(map->frame.x, 1.0f / map->reach_x), sl_scale(map->frame.y, 1.0f / map->reach_y),
                       sl_scale(map->frame.z, 1.0f / map->reach_z)};
    for (int i = 0; i < 3; i++) {
        view.clip[i][0] = rows[i].x;
        view.clip[i][1] = rows[i].y;
        view.clip[i][2] = rows[i].z;
        view.clip[i][3] = 0.0f;
    }
    view.clip[3][3] = 1.0f;
    sl_target target = {.width = maps->size, .height = maps->size, .id = NULL, .depth = map->depth};
    return sl_raster_id(maps->raster, &view, threads, &target, counters, error);
}

static sl_status add_light(sl_shadow_maps *maps, const sl_light *light, unsigned threads, sl_counters *counters,
                           sl_error *error) {
    shadow_light *s = &maps->lights[maps->count++];
    s->light = *light;
    if (light->type == SL_LIGHT_DIRECTIONAL) {
        return make_depth_map(maps, light->direction, threads, &s->map, counters, error);
    }
    return sl_raster_depth_cube(maps->raster, light->position, maps->size, 2.0f * maps->offset, threads, &s->cube, counters, error);
}

static sl_status add_area_sample(sl_shadow_maps *maps, sl_vec3 p, sl_vec3 normal, sl_rgb radiance, float area,
                                 unsigned threads, sl_counters *counters, sl_error *error) {
    shadow_light *s = &maps->lights[maps->count++];
    int size = maps->size > 16 ? maps->size / 2 : maps->size;
    s->area = true;
    s->normal = normal;
    s->light.position = sl_mad(p, 2.0f * maps->offset, normal); /* before the emitter, which must not hide its own light */
    s->power = sl_rgb_scale(radiance, area);
    s->extent = area * (float)(1.0 / SL_PI);
    return sl_raster_depth_cube(maps->raster, s->light.position, size, maps->offset, threads, &s->cube, counters, error);
}

/* The centroids of grid^2 equal parts of the triangle: those that stand like it, and those that stand on their heads. */
static sl_status add_emitter(sl_shadow_maps *maps, const sl_emitter *e, int grid, unsigned threads, sl_counters *counters,
                             sl_error *error) {
    const sl_scene *scene = maps->scene;
    sl_vec3 a = sl_scene_position(scene, scene->vertex[0][e->triangle]), b = sl_scene_position(scene, scene->vertex[1][e->triangle]),
            c = sl_scene_position(scene, scene->vertex[2][e->triangle]);
    sl_vec3 normal = sl_scene_geometric_normal(scene, e->triangle);
    float area = e->area / (float)(grid * grid);
    sl_status status = SL_OK;
    for (int i = 0; i < grid; i++) {
        for (int j = 0; j < 2 * (grid - i) - 1; j++) { /* row i holds 2 (grid - i) - 1 parts */
            float third = j % 2 ? 2.0f / 3.0f : 1.0f / 3.0f;
            float u = ((float)(j / 2) + third) / (float)grid, v = ((float)i + third) / (float)grid;
            sl_vec3 p = sl_mad(sl_mad(a, u, sl_sub(b, a)), v, sl_sub(c, a));
            if (status == SL_OK) status = add_area_sample(maps, p, normal, e->radiance, area, threads, counters, error);
            if (status == SL_OK && e->two_sided) {
                status = add_area_sample(maps, p, sl_neg(normal), e->radiance, area, threads, counters, error);
            }
        }
    }
    return status;
}

/* The sky as directional lights: drawn in proportion to luminance by a Hammersley set, so all of equal power. */
static sl_status add_sky(sl_shadow_maps *maps, unsigned threads, sl_counters *counters, sl_error *error) {
    for (uint32_t i = 0; i < SKY_LIGHTS; i++) {
        sl_rgb radiance;
        float pdf, u = ((float)i + 0.5f) / SKY_LIGHTS, v = ((float)(sl_van_der_corput(i) >> 8) + 0.5f) * 0x1p-24f;
        sl_vec3 direction = sl_environment_sample(&maps->scene->environment, u, v, &radiance, &pdf);
        if (!(pdf > 0.0f)) continue;
        sl_light light = {.type = SL_LIGHT_DIRECTIONAL, .direction = sl_neg(direction),
                          .intensity = sl_rgb_scale(radiance, 1.0f / (pdf * SKY_LIGHTS))};
        sl_status status = add_light(maps, &light, threads, counters, error);
        if (status != SL_OK) return status;
    }
    return SL_OK;
}

static sl_status add_all(sl_shadow_maps *maps, int grid, unsigned threads, sl_counters *counters, sl_error *error) {
    const sl_scene *scene = maps->scene;
    sl_status status = SL_OK;
    for (size_t i = 0; i < scene->light_count && status == SL_OK; i++) {
        status = add_light(maps, &scene->lights[i], threads, counters, error);
    }
    for (size_t i = 0; i < scene->emitter_count && status == SL_OK; i++) {
        status = add_emitter(maps, &scene->emitters[i], grid, threads, counters, error);
    }
    if (scene->environment.present && status == SL_OK) status = add_sky(maps, threads, counters, error);
    return status;
}

sl_status sl_shadow_maps_create(const sl_scene *scene, const sl_raster *raster, int size, unsigned threads,
                                sl_shadow_maps **out, sl_counters *counters, sl_error *error) {
    *out = NULL;
    if (size < 8 || size > 8192) return sl_fail(error, SL_ERROR_USAGE, "shadow maps have 8 to 8192 texels a side, not %d", size);
    if (scene->emitter_count > EMITTERS_MAX) {
        return sl_fail(error, SL_ERROR_USAGE, "shadow maps for %zu emissive triangles are too many (at most %d): use shadow rays",
                       scene->emitter_count, (int)EMITTERS_MAX);
    }
    int grid = 1;
    while (grid < AREA_GRID_MAX && (size_t)(grid + 1) * (size_t)(grid + 1) * scene->emitter_count <= AREA_CUBES) grid++;
    sl_shadow_maps *maps = sl_allocate(1, sizeof *maps);
    if (!maps) return sl_fail_memory(error, "shadow maps");
    *maps = (sl_shadow_maps){.scene = scene, .raster = raster, .size = size, .offset = 1e-5f * scene->diagonal};
    maps->capacity = scene->light_count + 2 * (size_t)(grid * grid) * scene->emitter_count + SKY_LIGHTS;
    maps->lights = sl_allocate(maps->capacity, sizeof *maps->lights);
    sl_status status = maps->lights ? add_all(maps, grid, threads, counters, error) : sl_fail_memory(error, "shadow maps");
    if (status != SL_OK) {
        sl_shadow_maps_destroy(maps);
        return status;
    }
    *out = maps;
    return SL_OK;
}

void sl_shadow_maps_destroy(sl_shadow_maps *maps) {
    if (!maps) return;
    for (size_t i = 0; i < maps->count && maps->lights; i++) {
        sl_depth_cube_destroy(maps->lights[i].cube);
        sl_free(maps->lights[i].map.depth);
    }
    sl_free(maps->lights);
    sl_free(maps);
}

size_t sl_shadow_maps_bytes(const sl_shadow_maps *maps) {
    size_t bytes = sizeof *maps + maps->capacity * sizeof *maps->lights;
    for (size_t i = 0; i < maps->count; i++) {
        const shadow_light *s = &maps->lights[i];
        if (s->cube) bytes += 6 * sizeof(float) * (size_t)s->cube->size * (size_t)s->cube->size;
        if (s->map.depth) bytes += sizeof(float) * (size_t)maps->size * (size_t)maps->size;
    }
    return bytes;
}

/* ---- looking up ------------------------------------------------------------------------------------------------------- */

static float map_texel(const sl_shadow_maps *maps, const depth_map *map, int x, int y, float depth) {
    int last = maps->size - 1;
    x = x < 0 ? 0 : x > last ? last : x;
    y = y < 0 ? 0 : y > last ? last : y;
    return map->depth[(size_t)y * (size_t)maps->size + (size_t)x] >= depth ? 1.0f : 0.0f;
}

/* Percentage-closer filtering of 2 x 2 texels. A texel's plane can lie nearer than its centre by half its side times the slope;
 * the filter reaches one texel further. */
static float map_lit(const sl_shadow_maps *maps, const depth_map *map, sl_vec3 p, sl_vec3 n) {
    sl_vec3 q = sl_sub(p, map->centre);
    float x = sl_dot(map->frame.x, q) / map->reach_x, y = sl_dot(map->frame.y, q) / map->reach_y;
    if (!(fabsf(x) <= 1.0f) || !(fabsf(y) <= 1.0f)) return 1.0f; /* beside the scene */
    float cosine = fabsf(sl_dot(map->frame.z, n)), texel = 2.0f * fmaxf(map->reach_x, map->reach_y) / (float)maps->size;
    float slope = sqrtf(fmaxf(0.0f, 1.0f - cosine * cosine)) / fmaxf(cosine, 0.1f);
    float bias = 1.5f * texel * slope + 0.1f * texel + maps->offset;
    float depth = 0.5f * ((sl_dot(map->frame.z, q) - bias) / map->reach_z + 1.0f);
    float column = 0.5f * (x + 1.0f) * (float)maps->size - 0.5f, row = 0.5f * (y + 1.0f) * (float)maps->size - 0.5f;
    float left = floorf(column), below = floorf(row), fx = column - left, fy = row - below;
    int i = (int)left, j = (int)below;
    float lower = map_texel(maps, map, i, j, depth) * (1.0f - fx) + map_texel(maps, map, i + 1, j, depth) * fx;
    float upper = map_texel(maps, map, i, j + 1, depth) * (1.0f - fx) + map_texel(maps, map, i + 1, j + 1, depth) * fx;
    return lower * (1.0f - fy) + upper * fy;
}

/* Irradiance on a facing plane, and where it comes from. */
static bool illuminate(const shadow_light *s, sl_vec3 p, sl_vec3 *to_light, sl_rgb *irradiance) {
    float distance;
    if (!s->area) return sl_light_illuminate(&s->light, p, to_light, &distance, irradiance);
    sl_vec3 offset = sl_sub(s->light.position, p);
    float squared = sl_dot(offset, offset), cosine = -sl_dot(s->normal, offset);
    if (!(squared > 0.0f) || !isfinite(squared) || !(cosine > 0.0f)) return false;
    float inverse = 1.0f / sqrtf(squared);
    *to_light = sl_scale(offset, inverse);
    *irradiance = sl_rgb_scale(s->power, cosine * inverse / (squared + s->extent));
    return true;
}

void sl_shadow_maps_each(const sl_shadow_maps *maps, sl_vec3 p, sl_vec3 geometric_normal, sl_vec3 n,
                         sl_shadow_map_visitor *visit, void *context, sl_counters *counters) {
    for (size_t i = 0; i < maps->count; i++) {
        const shadow_light *s = &maps->lights[i];
        sl_vec3 to_light;
        sl_rgb irradiance;
        if (!illuminate(s, p, &to_light, &irradiance)) continue;
        float cosine = sl_dot(n, to_light);
        if (!(cosine > 0.0f) || !(sl_dot(geometric_normal, to_light) > 0.0f)) continue;
        sl_count(counters, SL_COUNT_SHADOW_LOOKUPS, 1);
        float lit = s->cube ? sl_depth_cube_lit(s->cube, p, geometric_normal) : map_lit(maps, &s->map, p, geometric_normal);
        if (lit > 0.0f) visit(context, to_light, sl_rgb_scale(irradiance, lit * cosine));
    }
}

static void add_irradiance(void *context, sl_vec3 to_light, sl_rgb irradiance) {
    (void)to_light;
    sl_rgb *sum = context;
    *sum = sl_rgb_add(*sum, irradiance);
}

sl_rgb sl_shadow_maps_irradiance(const sl_shadow_maps *maps, sl_vec3 p, sl_vec3 geometric_normal, sl_vec3 n,
                                 sl_counters *counters) {
    sl_rgb sum = {0.0f, 0.0f, 0.0f};
    sl_shadow_maps_each(maps, p, geometric_normal, n, add_irradiance, &sum, counters);
    return sum;
}
