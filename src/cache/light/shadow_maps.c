#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/random.h"
#include "cache/light/shadow_internal.h"

enum { EMITTER_SIDES_MAX = 64, EMITTER_SAMPLES = 32, SUN_LIGHTS = 8, SKY_LIGHTS = 32, SMALLEST_MAP = 8 };

/* ---- one map ------------------------------------------------------------ */

static int smaller(int size, int divisor) {
    return size / divisor > SMALLEST_MAP ? size / divisor : SMALLEST_MAP;
}

/* Six faces and a border of one texel around each. */
static sl_status draw_cube(const sl_shadow_maps *maps, const sl_raster *raster, sl_vec3 eye, int size,
                           float near, sl_mapped_source *s, sl_counters *counters, sl_error *error) {
    size_t texels = (size_t)size * (size_t)size;
    float side = (float)size / (float)(size - 2);
    sl_view views[6];
    sl_target targets[6];
    s->id = sl_allocate(6 * texels, sizeof *s->id);
    if (!s->id) return sl_fail_memory(error, "a shadow map");
    for (int face = 0; face < 6; face++) {
        static const sl_vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
        int axis = face / 2;
        sl_frame frame = {axes[(axis + 1) % 3], axes[(axis + 2) % 3],
                          sl_scale(axes[axis], face % 2 ? -1.0f : 1.0f)};
        views[face] = sl_view_pyramid(&frame, eye, -side, side, -side, side, size, size, near);
        targets[face] = (sl_target){size, size, s->id + (size_t)face * texels, NULL};
    }
    s->map = (sl_shadow_map){.id = s->id, .size = size, .eye = eye};
    return sl_raster_ids(raster, 6, views, maps->settings.threads, targets, counters, error);
}

static float absolute_dot(sl_vec3 a, sl_vec3 b) {
    return fabsf(a.x * b.x) + fabsf(a.y * b.y) + fabsf(a.z * b.z);
}

/* The scene's box as a directional light sees it. */
static sl_status draw_directional(const sl_shadow_maps *maps, const sl_raster *raster, sl_vec3 direction,
                                  int size, sl_mapped_source *s, sl_counters *counters, sl_error *error) {
    const sl_scene *scene = maps->scene;
    sl_vec3 half = sl_scale(sl_sub(scene->box_max, scene->box_min), 0.5f),
            centre = sl_add(scene->box_min, half);
    float margin = 1e-3f * scene->diagonal;
    sl_frame frame = sl_frame_from_normal(direction);
    float reach[3] = {absolute_dot(frame.x, half) + margin, absolute_dot(frame.y, half) + margin,
                      absolute_dot(frame.z, half) + margin};
    sl_vec3 rows[3] = {sl_scale(frame.x, 1.0f / reach[0]), sl_scale(frame.y, 1.0f / reach[1]),
                       sl_scale(frame.z, 1.0f / reach[2])};
    s->id = sl_allocate((size_t)size * (size_t)size, sizeof *s->id);
    if (!s->id) return sl_fail_memory(error, "a shadow map");
    sl_view view = {.origin = centre,
                    .width = size,
                    .height = size,
                    .depth = SL_DEPTH_WINDOW,
                    .skip_triangle = SL_NO_INDEX};
    for (int i = 0; i < 3; i++) {
        view.clip[i][0] = rows[i].x;
        view.clip[i][1] = rows[i].y;
        view.clip[i][2] = rows[i].z;
    }
    view.clip[3][3] = 1.0f;
    s->map = (sl_shadow_map){.id = s->id,
                             .size = size,
                             .eye = centre,
                             .directional = true,
                             .frame = frame,
                             .reach_x = reach[0],
                             .reach_y = reach[1]};
    sl_target target = {size, size, s->id, NULL};
    return sl_raster_id(raster, &view, maps->settings.threads, &target, counters, error);
}

/* ---- lights without extent ------------------------------------------------------------ */

static sl_status add_light(sl_shadow_maps *maps, const sl_raster *raster, const sl_light *light,
                           unsigned part, int size, sl_counters *counters, sl_error *error) {
    sl_mapped_source *s = &maps->sources[maps->source_count++];
    s->part = part;
    s->source = sl_light_source_of(light);
    if (light->type == SL_LIGHT_DIRECTIONAL)
        return draw_directional(maps, raster, light->direction, size, s, counters, error);
    return draw_cube(maps, raster, light->position, size, 2.0f * maps->offset, s, counters, error);
}

/* Directions drawn in proportion to luminance by a Hammersley set, so all of about equal power. */
static sl_status add_environment(sl_shadow_maps *maps, const sl_raster *raster,
                                 const sl_environment *environment, uint32_t count, unsigned part,
                                 sl_counters *counters, sl_error *error) {
    for (uint32_t i = 0; i < count; i++) {
        sl_rgb radiance;
        float pdf, u = ((float)i + 0.5f) / (float)count,
                   v = ((float)(sl_van_der_corput(i) >> 8) + 0.5f) * 0x1p-24f;
        sl_vec3 direction = sl_environment_sample(environment, u, v, &radiance, &pdf);
        if (!(pdf > 0.0f)) continue;
        sl_light light = {.type = SL_LIGHT_DIRECTIONAL, .direction = sl_neg(direction),
                          .intensity = sl_rgb_scale(radiance, 1.0f / (pdf * (float)count))};
        int size = part == SL_MAPPED_SKY ? smaller(maps->settings.size, 2) : maps->settings.size;
        sl_status status = add_light(maps, raster, &light, part, size, counters, error);
        if (status != SL_OK) return status;
    }
    return SL_OK;
}

/* ---- emitters ------------------------------------------------------------ */

/* Point `index` of an additive recurrence (powers of the inverse plastic number), which every prefix spreads
 * well, folded onto the triangle. */
static sl_vec3 point_of(const sl_polygon_light *p, size_t index) {
    double u = 0.5 + 0.7548776662466927 * (double)(index + 1),
           v = 0.5 + 0.5698402909980532 * (double)(index + 1);
    u -= floor(u);
    v -= floor(v);
    if (u + v > 1.0) {
        u = 1.0 - u;
        v = 1.0 - v;
    }
    sl_vec3 along = sl_scale(sl_sub(p->corner[1], p->corner[0]), (float)u);
    return sl_mad(sl_add(p->corner[0], along), (float)v, sl_sub(p->corner[2], p->corner[0]));
}

static sl_status add_side(sl_shadow_maps *maps, const sl_raster *raster, const sl_emitter *e, bool back,
                          size_t samples, sl_counters *counters, sl_error *error) {
    sl_mapped_emitter *m = &maps->emitters[maps->emitter_count++];
    *m = (sl_mapped_emitter){sl_polygon_light_of(maps->scene, e, back), e->radiance, maps->source_count,
                             samples};
    float area = e->area / (float)samples;
    sl_status status = SL_OK;
    for (size_t i = 0; i < samples && status == SL_OK; i++) {
        sl_mapped_source *s = &maps->sources[maps->source_count++];
        s->part = SL_MAPPED_LIGHTS;
        s->source = (sl_light_source){.kind = SL_SOURCE_AREA,
                                      .direction = m->polygon.normal,
                                      .extent = area * (float)(1.0 / SL_PI),
                                      .colour = sl_rgb_scale(e->radiance, area)};
        /* A little before the emitter, which must not hide its own light. */
        s->source.position = sl_mad(point_of(&m->polygon, i), 2.0f * maps->offset, m->polygon.normal);
        status = draw_cube(maps, raster, s->source.position, smaller(maps->settings.size, 4), maps->offset, s,
                           counters, error);
    }
    return status;
}

/* A quarter of it: the sum of three channels may be beyond floats. */
static double power_of(const sl_emitter *e) {
    return (double)sl_rgb_mean(sl_rgb_scale(e->radiance, 0.25f)) * (double)e->area;
}

/* Samples of one side of an emitter: its share of the power, and at least one. */
static size_t samples_of(const sl_scene *scene, const sl_emitter *e) {
    double total = 0.0;
    for (size_t i = 0; i < scene->emitter_count; i++)
        total += power_of(&scene->emitters[i]) * (scene->emitters[i].two_sided ? 2.0 : 1.0);
    double share = total > 0.0 ? power_of(e) / total : 0.0;
    size_t samples = (size_t)floor(EMITTER_SAMPLES * share);
    return samples > 1 ? samples : 1;
}

/* ---- all ------------------------------------------------------------ */

static void make_planes(sl_shadow_maps *maps) {
    const sl_scene *s = maps->scene;
    sl_vec3 centre = sl_mad(s->central_min, 0.5f, sl_sub(s->central_max, s->central_min));
    for (uint32_t t = 0; t < s->triangle_count; t++) {
        sl_vec3 n = sl_scene_geometric_normal(s, t);
        sl_vec3d v = sl_subd(sl_to_double(sl_scene_position(s, s->vertex[0][t])), sl_to_double(centre));
        float *plane = maps->planes + 4 * ((size_t)t + 1);
        plane[0] = n.x;
        plane[1] = n.y;
        plane[2] = n.z;
        plane[3] = (float)sl_dotd(sl_to_double(n), v);
    }
    maps->table = (sl_plane_table){maps->planes, centre, maps->offset};
}

static sl_status add_all(sl_shadow_maps *maps, const sl_raster *raster, sl_counters *counters,
                         sl_error *error) {
    const sl_scene *scene = maps->scene;
    const sl_shadow_map_settings *settings = &maps->settings;
    sl_status status = SL_OK;
    for (size_t i = 0; i < scene->light_count && status == SL_OK; i++)
        status =
            add_light(maps, raster, &scene->lights[i], SL_MAPPED_LIGHTS, settings->size, counters, error);
    if (settings->sun && status == SL_OK)
        status = add_environment(maps, raster, settings->sun, SUN_LIGHTS, SL_MAPPED_LIGHTS, counters, error);
    if (settings->sky && status == SL_OK)
        status = add_environment(maps, raster, settings->sky, SKY_LIGHTS, SL_MAPPED_SKY, counters, error);
    maps->plain_count = maps->source_count;
    for (size_t i = 0; i < scene->emitter_count && status == SL_OK; i++) {
        const sl_emitter *e = &scene->emitters[i];
        size_t samples = samples_of(scene, e);
        status = add_side(maps, raster, e, false, samples, counters, error);
        if (e->two_sided && status == SL_OK)
            status = add_side(maps, raster, e, true, samples, counters, error);
    }
    return status;
}

static sl_status create_all(sl_shadow_maps *maps, const sl_raster *raster, sl_counters *counters,
                            sl_error *error) {
    const sl_scene *scene = maps->scene;
    size_t sides = sl_emitter_sides(scene);
    maps->capacity = scene->light_count + SUN_LIGHTS + SKY_LIGHTS + EMITTER_SAMPLES + sides;
    maps->sources = sl_allocate(maps->capacity, sizeof *maps->sources);
    maps->emitters = sl_allocate(sides, sizeof *maps->emitters);
    maps->planes = sl_allocate(4 * (scene->triangle_count + 1), sizeof *maps->planes);
    if (!maps->sources || !maps->emitters || !maps->planes) return sl_fail_memory(error, "shadow maps");
    make_planes(maps);
    return add_all(maps, raster, counters, error);
}

sl_status sl_shadow_maps_create(const sl_scene *scene, const sl_raster *raster,
                                const sl_shadow_map_settings *settings, sl_shadow_maps **out,
                                sl_counters *counters, sl_error *error) {
    *out = NULL;
    if (settings->size < SMALLEST_MAP || settings->size > 8192)
        return sl_fail(error, SL_ERROR_USAGE, "shadow maps have %d to 8192 texels a side, not %d",
                       (int)SMALLEST_MAP, settings->size);
    if (sl_emitter_sides(scene) > EMITTER_SIDES_MAX)
        return sl_fail(
            error, SL_ERROR_USAGE,
            "shadow maps for %zu sides of emissive triangles are too many (at most %d): use shadow rays",
            sl_emitter_sides(scene), (int)EMITTER_SIDES_MAX);
    sl_shadow_maps *maps = sl_allocate(1, sizeof *maps);
    if (!maps) return sl_fail_memory(error, "shadow maps");
    *maps = (sl_shadow_maps){.scene = scene,
                             .settings = *settings,
                             .kernels = sl_light_kernels_for(sl_isa_best()),
                             .offset = 1e-5f * scene->scale};
    sl_status status = create_all(maps, raster, counters, error);
    if (status != SL_OK) {
        sl_shadow_maps_destroy(maps);
        return status;
    }
    *out = maps;
    return SL_OK;
}

void sl_shadow_maps_destroy(sl_shadow_maps *maps) {
    if (!maps) return;
    for (size_t i = 0; i < maps->source_count; i++) sl_free(maps->sources[i].id);
    sl_free(maps->sources);
    sl_free(maps->emitters);
    sl_free(maps->planes);
    sl_free(maps);
}

size_t sl_shadow_maps_bytes(const sl_shadow_maps *maps) {
    size_t bytes = sizeof *maps + maps->capacity * sizeof *maps->sources +
                   maps->emitter_count * sizeof *maps->emitters +
                   4 * sizeof(float) * (maps->scene->triangle_count + 1);
    for (size_t i = 0; i < maps->source_count; i++) {
        const sl_shadow_map *m = &maps->sources[i].map;
        bytes += (m->directional ? 1 : 6) * sizeof *m->id * (size_t)m->size * (size_t)m->size;
    }
    return bytes;
}
