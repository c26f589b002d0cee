/* Pass 6: direct light of receivers, (5) for points and spots and (9) for area lights, each a point with an intensity by direction:
 *
 *     L_o = sum over lights f_r I cos theta / r^2 V,    I = Phi / 4 pi (3); Phi cos theta' / pi of an area light, from (6) and (7)
 *
 * V from the shadow cubes. */
#include "base/math.h"
#include "cache/direct_radiance/light_receivers.h"
#include "cache/direct_radiance/receiver_kernels.h"

typedef struct {
    const sl_light_pass *pass;
    sl_lit_picture *picture;
    int width;
    float largest_weight; /* 1 / r^2 nearer than which a light is taken to stand on the receiver: it then gives nothing */
    sl_receiver_kernels kernels;
} direct_pass;

static sl_light_source source_of(const sl_map_light *light, const sl_map_light_point *point) {
    static const sl_source_kind kinds[] = {[SL_MAP_LIGHT_POINT] = SL_SOURCE_POINT, [SL_MAP_LIGHT_SPOT] = SL_SOURCE_SPOT,
                                           [SL_MAP_LIGHT_DIRECTIONAL] = SL_SOURCE_DIRECTIONAL, [SL_MAP_LIGHT_AREA] = SL_SOURCE_AREA};
    return (sl_light_source){.kind = kinds[light->kind], .position = point->position, .direction = light->direction,
                             .cos_inner = light->cos_inner, .cos_outer = light->cos_outer, .colour = point->intensity};
}

/* cos theta / r^2, and cos theta' of an area light or the edge of a spot. */
static void arrive(const direct_pass *d, const sl_light_points *points, const sl_map_light *light, const sl_light_source *source,
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

static void add_light_point(const direct_pass *d, const sl_receiver_tile *tile, bool glossy, size_t index, sl_tile_light *light,
                            sl_counters *counters) {
    const sl_map_light_point *point = &d->pass->lights->point[index];
    const sl_map_light *of = &d->pass->lights->light[point->light];
    const sl_light_points points = sl_receiver_tile_points(tile);
    const sl_light_source source = source_of(of, point);
    sl_arrivals arrivals;
    const bool parallel = of->kind == SL_MAP_LIGHT_DIRECTIONAL; /* it has no distance, and stands on nothing */
    float lit[SL_TILE_PIXELS], any = 0.0f;
    arrive(d, &points, of, &source, &arrivals);
    for (size_t i = 0; i < tile->padded; i++) {
        float w = arrivals.weight[i];
        lit[i] = w > 0.0f && (parallel || w <= d->largest_weight) ? 1.0f : 0.0f;
        any += lit[i];
    }
    if (!(any > 0.0f)) return;
    sl_shadow_cubes_lit(d->pass->cubes, index, tile->count, tile->x, tile->y, tile->z, tile->geometric_x, tile->geometric_y,
                        tile->geometric_z, lit, counters);
    float (*e)[SL_TILE_PIXELS] = light->irradiance, (*l)[SL_TILE_PIXELS] = light->lobe;
    for (size_t i = 0; i < tile->padded; i++) arrivals.weight[i] = lit[i] > 0.0f ? arrivals.weight[i] : 0.0f;
    d->kernels.light.accumulate(tile->padded, source.colour, arrivals.weight, lit, e[0], e[1], e[2]);
    if (!glossy) return;
    float power[SL_TILE_PIXELS];
    const sl_lobe_target target = {.towards = parallel ? sl_neg(of->direction) : point->position, .direction = parallel};
    d->kernels.receiver_lobe(tile, &target, power);
    d->kernels.multiply(tile->padded, power, lit);
    d->kernels.light.accumulate(tile->padded, source.colour, arrivals.weight, lit, l[0], l[1], l[2]);
}

static void light_tile(void *context, const sl_receiver_tile *tile, bool glossy, sl_counters *counters) {
    const direct_pass *d = context;
    sl_tile_light light = {.irradiance = {{0.0f}}};
    for (size_t p = 0; p < d->pass->lights->point_count; p++) add_light_point(d, tile, glossy, p, &light, counters);
    float radiance[3][SL_TILE_PIXELS];
    d->kernels.reflect(tile, &light, glossy, radiance);
    sl_receiver_tile_add(tile, radiance, d->width, d->picture->direct);
}

sl_status sl_light_directly(const sl_light_pass *pass, const sl_receivers *receivers, sl_lit_picture *picture, sl_counters *counters,
                            sl_error *error) {
    if (pass->lights->point_count == 0) return SL_OK;
    double nearest = 1e-6 * (double)pass->scene->diagonal;
    direct_pass d = {pass, picture, receivers->width, (float)fmin(1.0 / (nearest * nearest), 1e30),
                     sl_receiver_kernels_for(sl_isa_best())};
    sl_receiver_kinds kinds;
    sl_status status = sl_receiver_kinds_find(pass->scene, sl_grey(0.0f), &kinds, error);
    if (status == SL_OK) status = sl_receiver_tiles_run(receivers, &kinds, pass->threads, light_tile, &d, counters, error);
    sl_receiver_kinds_release(&kinds);
    return status;
}
