/* Pass 6: direct light of receivers, (5) for points and spots and (9) for area lights, each a point with an
 * intensity by direction:
 *
 *     L_o = sum over lights f_r I cos theta / r^2 V,    I = Phi / 4 pi (3); Phi cos theta' / pi of an area
 * light, from (6) and (7)
 *
 * V from the shadow cubes. */
#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "cache/direct_radiance/direct_radiance.h"
#include "cache/direct_radiance/lights.h"

#include <string.h>

/* cos theta / r^2, and cos theta' of an area light or the edge of a spot. */
static void arrive(const sl_direct_light *d, const sl_light_points *points, const sl_light_source *source,
                   sl_arrivals *arrivals) {
    SL_KERNEL_OF(d->isa, sl_light_arrive)(points, source, arrivals);
    if (source->kind == SL_SOURCE_AREA && source->two_sided) {
        sl_light_source back = *source;
        sl_arrivals behind;
        back.direction = sl_neg(back.direction);
        SL_KERNEL_OF(d->isa, sl_light_arrive)(points, &back, &behind);
        for (size_t i = 0; i < points->count; i++) arrivals->weight[i] += behind.weight[i];
    }
}

static sl_lobe_target target_of(const sl_map_light *light) {
    const bool parallel = light->source.kind == SL_SOURCE_DIRECTIONAL;
    sl_lobe_target target = {.towards = parallel ? sl_neg(light->source.direction) : light->source.position,
                             .direction = parallel};
    if (light->source.kind != SL_SOURCE_AREA) return target;
    target.normal = light->source.direction;
    target.extent = light->area * (float)(0.25 / SL_PI);
    target.two_sided = light->source.two_sided;
    return target;
}

/* Multiplies lit by what the light's depth cube says. */
static void look_up(const sl_direct_light *d, const sl_receiver_tile *tile, size_t light, float *lit,
                    sl_counters *counters) {
    sl_light_points points = sl_receiver_tile_points(tile);
    size_t wanted = 0;
    points.count = tile->count;
    for (size_t i = 0; i < tile->count; i++) wanted += lit[i] != 0.0f;
    const sl_depth_cube *cube = &d->pass->lights->cube[light];
    const sl_cube_looks looks = {1, tile->count, &cube};
    SL_KERNEL_OF(d->isa, sl_depth_cube_lit)(&points, &looks, lit);
    sl_count(counters, SL_COUNT_SHADOW_LOOKUPS, wanted);
}

static void add_light(const sl_direct_light *d, const sl_receiver_tile *tile, bool glossy, size_t index,
                      sl_tile_light *light, sl_counters *counters) {
    const sl_map_light *of = &d->pass->lights->light[index];
    const sl_light_points points = sl_receiver_tile_points(tile);
    sl_arrivals arrivals;
    /* it has no distance, and stands on nothing */
    const bool parallel = of->source.kind == SL_SOURCE_DIRECTIONAL;
    float lit[SL_TILE_PIXELS];
    arrive(d, &points, &of->source, &arrivals);
    if (!SL_KERNEL_OF(d->isa, sl_receivers_reached)(tile->padded, arrivals.weight,
                                                    parallel ? INFINITY : d->largest_weight, lit))
        return;
    if (d->pass->lights->cube) look_up(d, tile, index, lit, counters);
    float (*e)[SL_TILE_PIXELS] = light->irradiance, (*l)[SL_TILE_PIXELS] = light->lobe;
    SL_KERNEL_OF(d->isa, sl_light_accumulate)(tile->padded, of->source.colour, arrivals.weight, lit, e[0],
                                              e[1], e[2]);
    if (!glossy) return;
    float power[SL_TILE_PIXELS];
    const sl_lobe_target target = target_of(of);
    SL_KERNEL_OF(d->isa, sl_receiver_lobe_power)(tile, &target, power);
    for (size_t i = 0; i < tile->padded; i++) lit[i] *= power[i];
    SL_KERNEL_OF(d->isa, sl_light_accumulate)(tile->padded, of->source.colour, arrivals.weight, lit, l[0],
                                              l[1], l[2]);
}

/* ---- a tile ---- */

sl_direct_light sl_direct_light_of(const sl_light_pass *pass) {
    double nearest = 1e-6 * (double)pass->scene->scale;
    return (sl_direct_light){pass, (float)fmin(1.0 / (nearest * nearest), 1e30),
                             sl_isa_best()};
}

void sl_direct_light_tile(const sl_direct_light *d, const sl_receiver_tile *tile, bool glossy,
                          const sl_tile_target *to, sl_counters *counters) {
    sl_tile_light light;
    memset(&light, 0, glossy ? sizeof light : sizeof light.irradiance);
    for (size_t i = 0; i < d->pass->lights->count; i++) add_light(d, tile, glossy, i, &light, counters);
    SL_KERNEL_OF(d->isa, sl_receivers_reflect_to)(tile, &light, glossy, to->direct);
}

/* ---- pass 1 ---- */

enum { SMALLEST = 16, ALL_TEXELS = 1 << 25 /* of all cubes together: 128 MiB */ };

/* Points of one lamp share its texels: n x n of them have 1 / n each. And all together have no more than
 * fits. */
static int size_of(const sl_map_lights *lights, const sl_map_light *light, int size) {
    double lamps = 0.0, divisor = 1.0;
    for (size_t i = 0; i < lights->count; i++)
        lamps += 1.0 / (double)(lights->light[i].siblings > 1 ? lights->light[i].siblings : 1);
    while (divisor * divisor * divisor * divisor < (double)light->siblings) divisor += 0.25;
    const double all = 6.0 * (double)size * (double)size * lamps,
                 shrink = all > (double)ALL_TEXELS ? sqrt((double)ALL_TEXELS / all) : 1.0;
    const int result = (int)((double)size * shrink / divisor) & ~1;
    return result > SMALLEST ? result : SMALLEST;
}

sl_status sl_map_lights_draw_cubes(sl_map_lights *lights, const sl_scene *scene, const sl_raster *raster,
                                   int size, unsigned threads, sl_counters *counters, sl_error *error) {
    lights->cube = sl_allocate(lights->count, sizeof *lights->cube);
    sl_status status = lights->cube ? SL_OK : sl_fail_memory(error, "the depth cubes");
    for (size_t i = 0; i < lights->count && status == SL_OK; i++) {
        const sl_map_light *light = &lights->light[i];
        status = sl_depth_cube_draw(scene, raster, &light->source, sl_rgb_is_black(light->source.colour),
                                    size_of(lights, light, size), threads, &lights->cube[i], counters, error);
    }
    return status;
}
