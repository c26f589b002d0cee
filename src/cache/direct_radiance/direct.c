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

static sl_light_source source_of(const sl_map_light *light) {
    static const sl_source_kind kinds[] = {[SL_MAP_LIGHT_POINT] = SL_SOURCE_POINT,
                                           [SL_MAP_LIGHT_SPOT] = SL_SOURCE_SPOT,
                                           [SL_MAP_LIGHT_DIRECTIONAL] = SL_SOURCE_DIRECTIONAL,
                                           [SL_MAP_LIGHT_AREA] = SL_SOURCE_AREA};
    return (sl_light_source){.kind = kinds[light->kind],
                             .position = light->position,
                             .direction = light->direction,
                             .cos_inner = light->cos_inner,
                             .cos_outer = light->cos_outer,
                             .colour = light->intensity};
}

/* cos theta / r^2, and cos theta' of an area light or the edge of a spot. */
static void arrive(const sl_direct_light *d, const sl_light_points *points, const sl_map_light *light,
                   const sl_light_source *source, sl_arrivals *arrivals) {
    d->kernels.light.arrive(points, source, arrivals);
    if (light->kind == SL_MAP_LIGHT_AREA && light->two_sided) {
        sl_light_source back = *source;
        sl_arrivals behind;
        back.direction = sl_neg(back.direction);
        d->kernels.light.arrive(points, &back, &behind);
        for (size_t i = 0; i < points->count; i++) arrivals->weight[i] += behind.weight[i];
    }
}

static sl_lobe_target target_of(const sl_map_light *light) {
    const bool parallel = light->kind == SL_MAP_LIGHT_DIRECTIONAL;
    sl_lobe_target target = {.towards = parallel ? sl_neg(light->direction) : light->position,
                             .direction = parallel};
    if (light->kind != SL_MAP_LIGHT_AREA) return target;
    target.normal = light->direction;
    target.extent = light->area * (float)(0.25 / SL_PI);
    target.two_sided = light->two_sided;
    return target;
}

static void add_light(const sl_direct_light *d, const sl_receiver_tile *tile, bool glossy, size_t index,
                      sl_tile_light *light, sl_counters *counters) {
    const sl_map_light *of = &d->pass->lights->light[index];
    const sl_light_points points = sl_receiver_tile_points(tile);
    const sl_light_source source = source_of(of);
    sl_arrivals arrivals;
    /* it has no distance, and stands on nothing */
    const bool parallel = of->kind == SL_MAP_LIGHT_DIRECTIONAL;
    float lit[SL_TILE_PIXELS];
    arrive(d, &points, of, &source, &arrivals);
    if (!d->kernels.reached(tile->padded, arrivals.weight, parallel ? INFINITY : d->largest_weight, lit))
        return;
    sl_shadow_cubes_lit(d->pass->cubes, index, tile->count, tile->x, tile->y, tile->z, tile->geometric_x,
                        tile->geometric_y, tile->geometric_z, lit, counters);
    float (*e)[SL_TILE_PIXELS] = light->irradiance, (*l)[SL_TILE_PIXELS] = light->lobe;
    d->kernels.where(tile->padded, lit, arrivals.weight);
    d->kernels.light.accumulate(tile->padded, source.colour, arrivals.weight, lit, e[0], e[1], e[2]);
    if (!glossy) return;
    float power[SL_TILE_PIXELS];
    const sl_lobe_target target = target_of(of);
    d->kernels.receiver_lobe(tile, &target, power);
    d->kernels.multiply(tile->padded, power, lit);
    d->kernels.light.accumulate(tile->padded, source.colour, arrivals.weight, lit, l[0], l[1], l[2]);
}

/* ---- a tile ---- */

sl_direct_light sl_direct_light_of(const sl_light_pass *pass) {
    double nearest = 1e-6 * (double)pass->scene->scale;
    return (sl_direct_light){pass, (float)fmin(1.0 / (nearest * nearest), 1e30),
                             sl_receiver_kernels_for(sl_isa_best())};
}

void sl_direct_light_tile(const sl_direct_light *d, const sl_receiver_tile *tile, bool glossy,
                          const sl_tile_target *to, sl_counters *counters) {
    sl_tile_light light;
    memset(&light, 0, glossy ? sizeof light : sizeof light.irradiance);
    for (size_t i = 0; i < d->pass->lights->count; i++) add_light(d, tile, glossy, i, &light, counters);
    d->kernels.reflect_to(tile, &light, glossy, to->width, to->direct);
}

enum { SMALLEST = 16, LARGEST = 8192, ALL_TEXELS = 1 << 25 /* of all cubes together: 128 MiB */ };

struct sl_shadow_cubes {
    size_t count;
    sl_shadow_cube *cube; /* of each light */
    size_t texels;
    sl_shadow_cube_kernel *lit;
};

/* ---- what to draw ---- */

/* A pass, which draws one side's picture or half of it. */
typedef struct {
    sl_view view;
    int side;
} side_pass;

enum { PASSES_MAX = 2 + 2 * 4 };

typedef struct {
    const sl_scene *scene;
    const sl_raster *raster;
    const sl_map_lights *lights;
    unsigned threads;
    sl_counters *counters;
} drawing;

/* A picture of the side, without its lower half (half > 0) or its upper one (half < 0). */
static sl_view view_of_side(const drawing *d, const sl_map_light *light, const sl_shadow_cube *cube,
                            int side, int half, const float clearance[2]) {
    double reach = (double)cube->tangent * (double)cube->size / (double)(cube->size - 2);
    bool back = side == SL_LIGHT_BACK || half < 0;
    sl_light_picture picture = {light->position,
                                sl_light_side(&cube->frame, side),
                                -reach,
                                reach,
                                -reach,
                                reach,
                                cube->size,
                                cube->size,
                                back,
                                clearance[back]};
    sl_view view = sl_light_picture_view(d->scene, light, &picture);
    if (half)
        view.scissor = (sl_scissor){0, half > 0 ? cube->size / 2 : 0, cube->size,
                                    half > 0 ? cube->size : cube->size / 2};
    return view;
}

static void propose(const drawing *d, const sl_view *view, int side, bool shines, side_pass *pass,
                    size_t *count) {
    if (shines && sl_raster_meets(d->raster, view)) pass[(*count)++] = (side_pass){*view, side};
    else sl_count(d->counters, SL_COUNT_RASTER_PASSES_SKIPPED, 1);
}

/* An area light's front and back see what lies on their own sides only. */
static size_t passes_of(const drawing *d, size_t index, const sl_shadow_cube *cube,
                        side_pass pass[PASSES_MAX]) {
    const sl_map_light *light = &d->lights->light[index];
    bool area = light->kind == SL_MAP_LIGHT_AREA;
    float clearance[2] = {0};
    size_t count = 0;
    for (int back = 0; back < 2 && area; back++)
        clearance[back] = sl_map_light_clearance(d->lights, index, back);
    for (int side = 0; side < SL_LIGHT_SIDES; side++) {
        bool halves = area && side != SL_LIGHT_AHEAD && side != SL_LIGHT_BACK,
             shines = sl_light_shines_on(light, side);
        sl_view view = view_of_side(d, light, cube, side, halves ? 1 : 0, clearance);
        propose(d, &view, side, shines, pass, &count);
        if (!halves || !light->two_sided) continue;
        view = view_of_side(d, light, cube, side, -1, clearance);
        propose(d, &view, side, shines, pass, &count);
    }
    return count;
}

/* ---- drawing ---- */

/* Megabytes, of which passes write what they draw: only what they leave out is cleared. */
static bool allocate(sl_shadow_cubes *cubes, sl_shadow_cube *cube, size_t pictures) {
    size_t zeros = sl_shadow_zeros(cube->size), texels = (size_t)cube->size * (size_t)cube->size;
    cube->depth = sl_allocate_unset(zeros + pictures * texels, sizeof *cube->depth);
    cubes->texels += zeros + pictures * texels;
    if (cube->depth) memset(cube->depth, 0, zeros * sizeof *cube->depth);
    return cube->depth != NULL;
}

/* The half of a side that an area light does not see. */
static void clear_other_half(const sl_shadow_cube *cube, const side_pass *pass) {
    const sl_scissor *drawn = &pass->view.scissor;
    const size_t width = (size_t)cube->size, half = width / 2;
    float *picture = cube->depth + cube->start[pass->side];
    if (drawn->y0 > 0) memset(picture, 0, half * width * sizeof *picture);
    else if (drawn->y1 == (int)half)
        memset(picture + half * width, 0, (width - half) * width * sizeof *picture);
}

static void give_picture(sl_shadow_cube *cube, int side, size_t *next) {
    size_t zeros = sl_shadow_zeros(cube->size), texels = (size_t)cube->size * (size_t)cube->size;
    if (cube->mask[side]) return;
    cube->start[side] = (int32_t)(zeros + (*next)++ * texels);
    cube->mask[side] = -1;
}

static sl_status draw_cube(sl_shadow_cubes *cubes, const drawing *d, size_t index, sl_shadow_cube *cube,
                           sl_error *error) {
    side_pass pass[PASSES_MAX];
    sl_view views[PASSES_MAX];
    sl_target targets[PASSES_MAX];
    size_t passes = passes_of(d, index, cube, pass), pictures = 0;
    for (size_t i = 0; i < passes; i++) give_picture(cube, pass[i].side, &pictures);
    if (!allocate(cubes, cube, pictures)) return sl_fail_memory(error, "a depth cube");
    for (size_t i = 0; i < passes; i++) clear_other_half(cube, &pass[i]);
    for (size_t i = 0; i < passes; i++) {
        views[i] = pass[i].view;
        targets[i] = (sl_target){cube->size, cube->size, NULL, cube->depth + cube->start[pass[i].side]};
    }
    return passes ? sl_raster_ids(d->raster, passes, views, d->threads, targets, d->counters, error) : SL_OK;
}

static sl_status draw_parallel(sl_shadow_cubes *cubes, const drawing *d, const sl_map_light *light,
                               sl_shadow_cube *cube, sl_error *error) {
    sl_parallel_picture p = sl_parallel_picture_of(d->scene, light);
    sl_view view = sl_parallel_view(&p, cube->size, cube->size);
    size_t pictures = 0, texels = (size_t)cube->size * (size_t)cube->size;
    cube->directional = true;
    cube->eye = p.centre;
    cube->frame = p.frame;
    cube->reach_x = p.reach_x;
    cube->reach_y = p.reach_y;
    cube->reach_z = p.reach_z;
    give_picture(cube, 0, &pictures);
    if (!allocate(cubes, cube, 1)) return sl_fail_memory(error, "a directional light's depths");
    float *depth = cube->depth + cube->start[0];
    sl_target target = {cube->size, cube->size, NULL, depth};
    sl_status status = sl_raster_id(d->raster, &view, d->threads, &target, d->counters, error);
    for (size_t i = 0; i < texels && status == SL_OK; i++) depth[i] = 1.0f - depth[i];
    return status;
}

/* ---- all ---- */

static bool is_dark(sl_rgb intensity) { return !(sl_rgb_max(intensity) > 0.0f); }

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

/* A cone that the picture ahead holds wastes none of it. */
static float tangent_of(const sl_map_light *light) {
    if (light->kind != SL_MAP_LIGHT_SPOT || sl_light_shines_on(light, 1)) return 1.0f;
    double c = (double)light->cos_outer, tangent = c < 1.0 ? sqrt(1.0 - c * c) / c : 0.0;
    return tangent < 0.001 ? 0.001f : tangent < 1.0 ? (float)tangent : 1.0f;
}

static float rounding_of(const sl_scene *s) { return 4e-7f * sl_scene_coordinate_near(s, s->central_min); }

static sl_status draw_all(sl_shadow_cubes *cubes, const drawing *d, int size, sl_error *error) {
    float rounding = rounding_of(d->scene);
    for (size_t i = 0; i < cubes->count; i++) {
        const sl_map_light *light = &d->lights->light[i];
        sl_shadow_cube *cube = &cubes->cube[i];
        *cube = (sl_shadow_cube){.size = size_of(d->lights, light, size),
                                 .eye = light->position,
                                 .frame = sl_light_frame(light),
                                 .tangent = tangent_of(light),
                                 .rounding = rounding};
        sl_status status = SL_OK;
        if (is_dark(light->intensity) || !sl_is_finite(light->position)) {
            sl_count(d->counters, SL_COUNT_RASTER_PASSES_SKIPPED,
                     light->kind == SL_MAP_LIGHT_DIRECTIONAL ? 1 : SL_LIGHT_SIDES);
            if (!allocate(cubes, cube, 0)) status = sl_fail_memory(error, "a depth cube");
        } else {
            status = light->kind == SL_MAP_LIGHT_DIRECTIONAL ? draw_parallel(cubes, d, light, cube, error)
                                                             : draw_cube(cubes, d, i, cube, error);
        }
        if (status != SL_OK) return status;
    }
    return SL_OK;
}

sl_status sl_shadow_cubes_render(const sl_scene *scene, const sl_raster *raster, const sl_map_lights *lights,
                                 int size, unsigned threads, sl_shadow_cubes **out, sl_counters *counters,
                                 sl_error *error) {
    *out = NULL;
    if (size < SMALLEST || size > LARGEST)
        return sl_fail(error, SL_ERROR_USAGE, "depth cubes have %d to %d texels a side, not %d",
                       (int)SMALLEST, (int)LARGEST, size);
    drawing d = {scene, raster, lights, threads, counters};
    sl_shadow_cubes *cubes = sl_allocate(1, sizeof *cubes);
    if (!cubes) return sl_fail_memory(error, "the depth cubes");
    *cubes = (sl_shadow_cubes){.count = lights->count,
                               .cube = sl_allocate(lights->count, sizeof *cubes->cube),
                               .lit = sl_shadow_cube_kernel_for(sl_isa_best())};
    sl_status status =
        cubes->cube ? draw_all(cubes, &d, size, error) : sl_fail_memory(error, "the depth cubes");
    if (status != SL_OK) sl_shadow_cubes_destroy(cubes);
    else *out = cubes;
    return status;
}

void sl_shadow_cubes_destroy(sl_shadow_cubes *cubes) {
    if (!cubes) return;
    for (size_t i = 0; cubes->cube && i < cubes->count; i++) sl_free(cubes->cube[i].depth);
    sl_free(cubes->cube);
    sl_free(cubes);
}

size_t sl_shadow_cubes_bytes(const sl_shadow_cubes *cubes) {
    return cubes ? sizeof *cubes + cubes->count * sizeof *cubes->cube + cubes->texels * sizeof(float) : 0;
}

/* ---- looking up ---- */

void sl_shadow_cubes_lit(const sl_shadow_cubes *cubes, size_t light, size_t count, const float *px,
                         const float *py, const float *pz, const float *nx, const float *ny, const float *nz,
                         float *lit, sl_counters *counters) {
    if (!cubes) return;
    for (size_t i = 0; i < count; i += SL_SHADOW_BLOCK) {
        size_t block = count - i < SL_SHADOW_BLOCK ? count - i : SL_SHADOW_BLOCK, wanted = 0;
        for (size_t k = 0; k < block; k++) wanted += lit[i + k] != 0.0f;
        if (!wanted) continue;
        cubes->lit(&cubes->cube[light], block, px + i, py + i, pz + i, nx + i, ny + i, nz + i, lit + i);
        sl_count(counters, SL_COUNT_SHADOW_LOOKUPS, wanted);
    }
}
