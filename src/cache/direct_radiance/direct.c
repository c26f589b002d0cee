/* Pass 6: direct light of receivers, (5) for points and spots and (9) for area lights, each a point with an intensity by direction:
 *
 *     L_o = sum over lights f_r I cos theta / r^2 V,    I = Phi / 4 pi (3); Phi cos theta' / pi of an area light, from (6) and (7)
 *
 * V from the shadow cubes. */
#include <string.h>

#include "base/math.h"
#include "cache/direct_radiance/light_tiles.h"

static sl_light_source source_of(const sl_map_light *light, const sl_map_light_point *point) {
    static const sl_source_kind kinds[] = {[SL_MAP_LIGHT_POINT] = SL_SOURCE_POINT, [SL_MAP_LIGHT_SPOT] = SL_SOURCE_SPOT,
                                           [SL_MAP_LIGHT_DIRECTIONAL] = SL_SOURCE_DIRECTIONAL, [SL_MAP_LIGHT_AREA] = SL_SOURCE_AREA};
    return (sl_light_source){.kind = kinds[light->kind], .position = point->position, .direction = light->direction,
                             .cos_inner = light->cos_inner, .cos_outer = light->cos_outer, .colour = point->intensity};
}

/* cos theta / r^2, and cos theta' of an area light or the edge of a spot. */
static void arrive(const sl_direct_light *d, const sl_light_points *points, const sl_map_light *light, const sl_light_source *source,
                   sl_arrivals *arrivals) {
    d->kernels.light.arrive(points, source, arrivals);
    if (light->kind == SL_MAP_LIGHT_AREA && light->two_sided) {
        sl_light_source back = *source;
        sl_arrivals behind;
        back.direction = sl_neg(back.direction);
        d->kernels.light.arrive(points, &back, &behind);
        for (size_t i = 0; i < points->count; i++) arrivals->weight[i] += behind.weight[i];
    }
}

/* An area light's point stands for a part of its area, as large as the point's share of the intensity. */
static sl_lobe_target target_of(const sl_map_light *light, const sl_map_light_point *point) {
    const bool parallel = light->kind == SL_MAP_LIGHT_DIRECTIONAL;
    sl_lobe_target target = {.towards = parallel ? sl_neg(light->direction) : point->position, .direction = parallel};
    const float whole = sl_rgb_max(light->intensity), share = whole > 0.0f ? sl_rgb_max(point->intensity) / whole : 0.0f;
    if (light->kind != SL_MAP_LIGHT_AREA || !(share <= 1.0f)) return target;
    target.normal = light->direction;
    target.extent = light->area * share * (float)(0.25 / SL_PI);
    target.two_sided = light->two_sided;
    return target;
}

static void add_light_point(const sl_direct_light *d, const sl_receiver_tile *tile, bool glossy, size_t index, sl_tile_light *light,
                            sl_counters *counters) {
    const sl_map_light_point *point = &d->pass->lights->point[index];
    const sl_map_light *of = &d->pass->lights->light[point->light];
    const sl_light_points points = sl_receiver_tile_points(tile);
    const sl_light_source source = source_of(of, point);
    sl_arrivals arrivals;
    const bool parallel = of->kind == SL_MAP_LIGHT_DIRECTIONAL; /* it has no distance, and stands on nothing */
    float lit[SL_TILE_PIXELS];
    arrive(d, &points, of, &source, &arrivals);
    if (!d->kernels.reached(tile->padded, arrivals.weight, parallel ? INFINITY : d->largest_weight, lit)) return;
    sl_shadow_cubes_lit(d->pass->cubes, index, tile->count, tile->x, tile->y, tile->z, tile->geometric_x, tile->geometric_y,
                        tile->geometric_z, lit, counters);
    float (*e)[SL_TILE_PIXELS] = light->irradiance, (*l)[SL_TILE_PIXELS] = light->lobe;
    d->kernels.where(tile->padded, lit, arrivals.weight);
    d->kernels.light.accumulate(tile->padded, source.colour, arrivals.weight, lit, e[0], e[1], e[2]);
    if (!glossy) return;
    float power[SL_TILE_PIXELS];
    const sl_lobe_target target = target_of(of, point);
    d->kernels.receiver_lobe(tile, &target, power);
    d->kernels.multiply(tile->padded, power, lit);
    d->kernels.light.accumulate(tile->padded, source.colour, arrivals.weight, lit, l[0], l[1], l[2]);
}

/* ---- a tile, a picture ---- */

sl_direct_light sl_direct_light_of(const sl_light_pass *pass) {
    double nearest = 1e-6 * (double)pass->scene->scale;
    return (sl_direct_light){pass, (float)fmin(1.0 / (nearest * nearest), 1e30), sl_receiver_kernels_for(sl_isa_best())};
}

void sl_direct_light_tile(const sl_direct_light *d, const sl_receiver_tile *tile, bool glossy, const sl_tile_target *to,
                          sl_counters *counters) {
    sl_tile_light light;
    memset(&light, 0, glossy ? sizeof light : sizeof light.irradiance);
    for (size_t p = 0; p < d->pass->lights->point_count; p++) add_light_point(d, tile, glossy, p, &light, counters);
    d->kernels.reflect_to(tile, &light, glossy, to->width, to->direct);
}

typedef struct {
    sl_direct_light light;
    sl_tile_target to;
} picture_pass;

static void light_tile(void *context, const sl_receiver_tile *tile, bool glossy, sl_counters *counters) {
    const picture_pass *p = context;
    sl_direct_light_tile(&p->light, tile, glossy, &p->to, counters);
}

sl_status sl_light_directly(const sl_light_pass *pass, const sl_receivers *receivers, sl_lit_picture *picture, sl_counters *counters,
                            sl_error *error) {
    if (pass->lights->point_count == 0) return SL_OK;
    float *const *direct = picture->direct;
    picture_pass p = {sl_direct_light_of(pass), {.width = receivers->width, .direct = {direct[0], direct[1], direct[2]}}};
    sl_receiver_kinds kinds;
    sl_status status = sl_receiver_kinds_find(pass->scene, sl_grey(0.0f), &kinds, error);
    if (status == SL_OK) status = sl_receiver_tiles_run(receivers, &kinds, pass->threads, light_tile, &p, counters, error);
    sl_receiver_kinds_release(&kinds);
    return status;
}
