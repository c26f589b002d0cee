#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/random.h"
#include "cache/light/depth_cube.h"
#include "cache/light/shadow_maps.h"

#include <string.h>

enum { EMITTER_SAMPLES = 32, SUN_LIGHTS = 8, SKY_LIGHTS = 32, SMALLEST_MAP = 8 };

/* A light without extent, or a sample of one with extent, and its map. */
typedef struct sl_mapped_source {
    sl_light_source source;
    sl_depth_cube cube;
    unsigned part;
} sl_mapped_source;

/* A side of an emissive triangle, and its samples among the sources. */
typedef struct sl_mapped_emitter {
    sl_polygon_light polygon;
    sl_rgb radiance;
    size_t first, count;
} sl_mapped_emitter;

struct sl_shadow_maps {
    const sl_scene *scene;
    sl_shadow_map_settings settings;
    sl_isa isa;
    float offset;
    /* the first plain_count sources are no samples of emitters */
    size_t source_count, emitter_count, plain_count, capacity;
    sl_mapped_source *sources;
    sl_mapped_emitter *emitters;
};

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
        status = draw(maps, raster, s, smaller(maps->settings.size, 4), counters, error);
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

/* ---- lighting points, a block at a time ---- */

static bool any(const float *values, size_t count) {
    bool found = false;
    for (size_t i = 0; i < count; i++) found |= values[i] > 0.0f;
    return found;
}

/* False: nothing arrives anywhere in the block, shadows aside. */
static bool look_up(const sl_shadow_maps *maps, const sl_mapped_source *s, const sl_light_points *points,
                    sl_arrivals *arrivals, float *lit, sl_counters *counters) {
    SL_KERNEL_OF(maps->isa, sl_light_arrive)(points, &s->source, arrivals);
    if (!any(arrivals->weight, points->count)) return false;
    for (size_t i = 0; i < points->count; i++) lit[i] = 1.0f;
    SL_KERNEL_OF(maps->isa, sl_depth_cube_lit)(points, &s->cube, lit);
    sl_count(counters, SL_COUNT_SHADOW_LOOKUPS, points->count);
    return true;
}

void sl_shadow_maps_each(const sl_shadow_maps *maps, const sl_light_points *points, unsigned parts,
                         sl_shadow_map_visitor *visit, void *context, sl_counters *counters) {
    sl_arrivals arrivals;
    float lit[SL_LIGHT_BLOCK];
    for (size_t i = 0; i < maps->source_count; i++) {
        const sl_mapped_source *s = &maps->sources[i];
        if ((s->part & parts) && look_up(maps, s, points, &arrivals, lit, counters))
            visit(context, &arrivals, lit, s->source.colour);
    }
}

/* ---- emitters: the exact irradiance of the whole times the share of the samples that is visible ---- */

typedef struct {
    float seen[SL_LIGHT_BLOCK], all[SL_LIGHT_BLOCK]; /* sums of weights */
} shares;

/* Points [begin, end) of a block. */
typedef struct {
    size_t begin, end;
} span;

/* Nowhere a part of the samples alone. */
static bool all_agree(const shares *s, span at) {
    bool agree = true;
    for (size_t i = at.begin; i < at.end; i++) agree &= s->seen[i] == 0.0f || s->seen[i] == s->all[i];
    return agree;
}

/* Adds what samples [first, last) of an emitter give. */
static void add_samples(const sl_shadow_maps *maps, const sl_mapped_emitter *e, size_t first, size_t last,
                        const sl_light_points *points, span at, shares *s, sl_counters *counters) {
    const size_t k = at.begin;
    const sl_light_points some = {at.end - k,
                                  points->x + k,
                                  points->y + k,
                                  points->z + k,
                                  points->geometric_x + k,
                                  points->geometric_y + k,
                                  points->geometric_z + k,
                                  points->normal_x + k,
                                  points->normal_y + k,
                                  points->normal_z + k};
    sl_arrivals arrivals;
    float lit[SL_LIGHT_BLOCK];
    for (size_t sample = first; sample < last; sample++) {
        if (!look_up(maps, &maps->sources[e->first + sample], &some, &arrivals, lit, counters)) continue;
        for (size_t i = 0; i < some.count; i++) {
            s->all[k + i] += arrivals.weight[i];
            s->seen[k + i] += arrivals.weight[i] * lit[i];
        }
    }
}

/* Some of a block's points. */
typedef struct {
    float x[SL_LIGHT_BLOCK], y[SL_LIGHT_BLOCK], z[SL_LIGHT_BLOCK];
    float geometric[3][SL_LIGHT_BLOCK], normal[3][SL_LIGHT_BLOCK];
    sl_light_points points;
} thinned;

/* Takes a quarter of each part of a tile: of each row every fourth point, and of each column, too. */
static void thin(const sl_light_points *all, thinned *few) {
    const float *from[9] = {all->x, all->y, all->z, all->geometric_x, all->geometric_y, all->geometric_z,
                            all->normal_x, all->normal_y, all->normal_z};
    float *to[9] = {few->x, few->y, few->z, few->geometric[0], few->geometric[1], few->geometric[2],
                    few->normal[0], few->normal[1], few->normal[2]};
    static const uint8_t begin[4] = {0, 2, 1, 3};
    size_t count = 0;
    for (size_t i = 0; i < all->count; i++) {
        if (i % 4 != begin[i / SL_MAPPED_COLUMNS % 4]) continue;
        for (int k = 0; k < 9; k++) to[k][count] = from[k][i];
        count++;
    }
    few->points = (sl_light_points){count, few->x, few->y, few->z, few->geometric[0], few->geometric[1],
                                    few->geometric[2], few->normal[0], few->normal[1], few->normal[2]};
}

/* Returns the share that all points agree on, 0 or 1; negative: they do not, or none is before the light. */
static float common_share(const shares *s, size_t count) {
    bool dark = true, lit = true;
    for (size_t i = 0; i < count; i++) {
        dark &= s->seen[i] == 0.0f;
        lit &= s->seen[i] == s->all[i];
    }
    return lit == dark ? -1.0f : lit ? 1.0f : 0.0f;
}

/* Where the first quarter of the samples says the same in a part of a block, the others would too: of a
 * picture the penumbrae alone need all. And where a quarter of a tile's points is lit alike, so are those
 * between. */
static void share_of_samples(const sl_shadow_maps *maps, const sl_mapped_emitter *e,
                             const sl_light_points *points, const thinned *few, unsigned parts, shares *s,
                             sl_counters *counters) {
    const size_t least = e->count / 4 > 4 ? e->count / 4 : 4, pilot = least < e->count ? least : e->count,
                 count = points->count, step = few ? SL_MAPPED_PART : count;
    float share = -1.0f;
    memset(s, 0, sizeof *s);
    if (few) {
        add_samples(maps, e, 0, pilot, &few->points, (span){0, few->points.count}, s, counters);
        share = common_share(s, few->points.count);
        for (size_t i = 0; i < count; i++) s->seen[i] = fmaxf(share, 0.0f), s->all[i] = share >= 0.0f;
    }
    for (size_t first = 0; first < count && share < 0.0f; first += step) {
        const span part = {first, first + step < count ? first + step : count};
        add_samples(maps, e, 0, pilot, points, part, s, counters);
        if (!(parts & SL_MAPPED_FEW) && !all_agree(s, part))
            add_samples(maps, e, pilot, e->count, points, part, s, counters);
    }
}

static void add_emitter(const sl_shadow_maps *maps, const sl_mapped_emitter *e, const sl_light_points *points,
                        const thinned *few, unsigned parts, float *r, float *g, float *b,
                        sl_counters *counters) {
    float exact[SL_LIGHT_BLOCK];
    shares s;
    SL_KERNEL_OF(maps->isa, sl_polygon_light)(points, &e->polygon, exact);
    if (!any(exact, points->count)) return;
    share_of_samples(maps, e, points, few, parts, &s, counters);
    for (size_t i = 0; i < points->count; i++) s.seen[i] = s.all[i] > 0.0f ? s.seen[i] / s.all[i] : 0.0f;
    SL_KERNEL_OF(maps->isa, sl_light_accumulate)(points->count, e->radiance, exact, s.seen, r, g, b);
}

void sl_shadow_maps_irradiance(const sl_shadow_maps *maps, const sl_light_points *points, unsigned parts,
                               float *r, float *g, float *b, sl_counters *counters) {
    sl_arrivals arrivals;
    float lit[SL_LIGHT_BLOCK];
    for (size_t i = 0; i < maps->plain_count; i++) {
        const sl_mapped_source *s = &maps->sources[i];
        if (!(s->part & parts) || !look_up(maps, s, points, &arrivals, lit, counters)) continue;
        SL_KERNEL_OF(maps->isa, sl_light_accumulate)(points->count, s->source.colour, arrivals.weight, lit,
                                                     r, g, b);
    }
    if (!(parts & SL_MAPPED_LIGHTS) || !maps->emitter_count) return;
    thinned few;
    const bool thins = parts & SL_MAPPED_TILE;
    if (thins) thin(points, &few);
    for (size_t i = 0; i < maps->emitter_count; i++)
        add_emitter(maps, &maps->emitters[i], points, thins ? &few : NULL, parts, r, g, b, counters);
}
