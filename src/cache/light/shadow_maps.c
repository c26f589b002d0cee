#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/random.h"
#include "cache/light/shadow_maps_internal.h"

#include <math.h>

enum { EMITTER_SAMPLES = 32, SUN_LIGHTS = 8, SKY_LIGHTS = 32, SMALLEST_MAP = 8 };

/* ---- one map ------------------------------------------------------------ */

static int smaller(int size, int divisor) {
    return size / divisor > SMALLEST_MAP ? size / divisor : SMALLEST_MAP;
}

static sl_status draw(sl_shadow_maps *maps, const sl_raster *raster, sl_mapped_source *s, int size,
                      sl_counters *counters, sl_error *error) {
    return sl_depth_cube_draw(maps->scene, raster, &s->source, false, size, maps->settings.threads, &s->cube,
                              counters, error);
}

/* ---- lights without extent ------------------------------------------------------------ */

static sl_status add_light(sl_shadow_maps *maps, const sl_raster *raster, const sl_light *light,
                           unsigned part, int size, sl_counters *counters, sl_error *error) {
    sl_mapped_source *s = &maps->sources[maps->source_count++];
    s->part = part;
    s->source = sl_light_source_of(light);
    return draw(maps, raster, s, size, counters, error);
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
    const int asked = maps->settings.emitter_size, size = asked ? asked : smaller(maps->settings.size, 4);
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
        status = draw(maps, raster, s, size, counters, error);
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
    if (!maps->sources || !maps->emitters) return sl_fail_memory(error, "shadow maps");
    return add_all(maps, raster, counters, error);
}

sl_status sl_shadow_maps_create(const sl_scene *scene, const sl_raster *raster,
                                const sl_shadow_map_settings *settings, sl_shadow_maps **out,
                                sl_counters *counters, sl_error *error) {
    *out = NULL;
    if (sl_emitter_sides(scene) > SL_SHADOW_MAP_SIDES_MAX)
        return sl_fail(
            error, SL_ERROR_USAGE,
            "shadow maps for %zu sides of emissive triangles are too many (at most %d): use shadow rays",
            sl_emitter_sides(scene), (int)SL_SHADOW_MAP_SIDES_MAX);
    sl_shadow_maps *maps = sl_allocate(1, sizeof *maps);
    if (!maps) return sl_fail_memory(error, "shadow maps");
    *maps = (sl_shadow_maps){.scene = scene,
                             .settings = *settings,
                             .isa = sl_isa_best(),
                             .offset = 1e-5f * scene->scale};
    sl_order_squares(maps->square_order);
    sl_status status = create_all(maps, raster, counters, error);
    if (status == SL_OK) *out = maps;
    else sl_shadow_maps_destroy(maps);
    return status;
}

void sl_shadow_maps_destroy(sl_shadow_maps *maps) {
    if (!maps) return;
    for (size_t i = 0; i < maps->source_count; i++) sl_depth_cube_release(&maps->sources[i].cube);
    sl_free(maps->sources);
    sl_free(maps->emitters);
    sl_free(maps);
}

size_t sl_shadow_maps_bytes(const sl_shadow_maps *maps) {
    size_t bytes = sizeof *maps + maps->capacity * sizeof *maps->sources +
                   maps->emitter_count * sizeof *maps->emitters;
    for (size_t i = 0; i < maps->source_count; i++)
        bytes += maps->sources[i].cube.texels * sizeof *maps->sources[i].cube.depth;
    return bytes;
}
