#include "cache/direct_radiance/light_openings.h"

#include <math.h>

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "cache/direct_radiance/light_points.h"
#include "cache/direct_radiance/light_sides.h"

enum { SIZE = 16, TEXELS = SIZE * SIZE, PLACES = 4 /* each way in a cell */, FINEST = 8 /* lights of more points a side have them everywhere */ };

/* A picture's tangent: 127 degrees, and 4/5 of a Lambertian emitter's flux. */
static const double REACH = 2.0;
/* Views that differ less are alike; a cell is shut where less of its light gets out. */
static const double ALIKE = 0.75, SHUT = 0.02;

typedef struct {
    const sl_scene *scene;
    const sl_raster *raster;
    const sl_map_lights *lights;
    unsigned threads;
    sl_counters *counters;
    float *depth; /* of one picture */
} looking;

/* Share of what shines ahead of a place, or back, that gets farther than `near`. Flux by texel is cos^4 of the angle off the axis. */
static sl_status look(const looking *l, const sl_map_light_point *place, bool back, double near, double *open, sl_error *error) {
    const sl_map_light *light = &l->lights->light[place->light];
    const sl_frame frame = sl_light_frame(light);
    const sl_light_picture picture = {place->position, sl_light_side(&frame, back ? SL_LIGHT_BACK : SL_LIGHT_AHEAD), -REACH, REACH,
                                      -REACH, REACH, SIZE, SIZE, back,
                                      sl_map_light_clearance(l->scene, l->lights, place->light, place->position, back)};
    const sl_view view = sl_light_picture_view(l->scene, light, &picture);
    const sl_target target = {SIZE, SIZE, NULL, l->depth};
    double sum = 0.0, all = 0.0;
    sl_status status = sl_raster_id(l->raster, &view, l->threads, &target, l->counters, error);
    for (int i = 0; i < TEXELS; i++) {
        const double x = REACH * ((2.0 * (i % SIZE) + 1.0) / SIZE - 1.0), y = REACH * ((2.0 * (i / SIZE) + 1.0) / SIZE - 1.0);
        const double squared = 1.0 + x * x + y * y, weight = 1.0 / (squared * squared), inverse = (double)l->depth[i];
        all += weight;
        if (squared > near * near * inverse * inverse) sum += weight; /* reciprocal depth: 0 where nothing is */
    }
    *open = sum / all;
    return status;
}

/* Of both sides where both shine. */
static sl_status openness(const looking *l, const sl_map_light_point *place, double near, double *open, sl_error *error) {
    double behind = 0.0;
    sl_status status = look(l, place, false, near, open, error);
    if (status != SL_OK || !l->lights->light[place->light].two_sided) return status;
    status = look(l, place, true, near, &behind, error);
    *open = 0.5 * (*open + behind);
    return status;
}

static double squared_distance(sl_vec3 a, sl_vec3 b) { return (double)sl_dot(sl_sub(a, b), sl_sub(a, b)); }

/* The point of the light, points [first, end), that is nearest. */
static size_t owner_of(const sl_map_lights *lights, size_t first, size_t end, sl_vec3 position) {
    size_t best = first;
    for (size_t i = first + 1; i < end; i++) {
        if (squared_distance(lights->point[i].position, position) < squared_distance(lights->point[best].position, position)) best = i;
    }
    return best;
}

typedef struct {
    sl_map_light_point at;
    size_t owner;
    double open;
} place;

/* The place whose view is most like the cell's, the one nearer to its middle of two; moves the point there. */
static void settle(sl_map_light_point *point, double side, const place *places, size_t count, size_t owner, double own,
                   sl_light_openings *found) {
    double flux = 0.0, open = 0.0, least = INFINITY;
    const place *best = NULL;
    for (size_t i = 0; i < count; i++) {
        if (places[i].owner != owner) continue;
        const double share = (double)sl_rgb_mean(places[i].at.intensity);
        flux += share;
        open += share * places[i].open;
    }
    if (!(flux > 0.0)) return;
    open /= flux;
    found->shut += open < SHUT;
    if (open < SHUT || (own >= ALIKE * open && own * ALIKE <= open)) return;
    for (size_t i = 0; i < count; i++) {
        if (places[i].owner != owner || places[i].open < 0.5 * open) continue;
        const double ratio = places[i].open / open, cost = fabs(ratio > 1.0 ? ratio - 1.0 : 1.0 / ratio - 1.0) +
                                                           0.25 * squared_distance(places[i].at.position, point->position) / (side * side);
        if (cost < least) best = &places[i];
        least = cost < least ? cost : least;
    }
    if (!best) return;
    point->position = best->at.position;
    point->intensity = sl_rgb_scale(point->intensity, (float)fmin(open / best->open, 2.0));
    found->moved++;
}

/* Points [first, end) of a light whose cells are `side` wide. */
static sl_status examine(const looking *l, unsigned subdivision, size_t first, size_t end, double side, const double *own,
                         sl_map_lights *lights, sl_light_openings *found, sl_error *error) {
    const uint32_t index = lights->point[first].light;
    const sl_map_light *light = &lights->light[index];
    const int n = (int)subdivision * PLACES;
    sl_map_light_point *fine = sl_allocate((size_t)(n * n), sizeof *fine);
    place *places = sl_allocate((size_t)(n * n), sizeof *places);
    sl_status status = fine && places ? SL_OK : sl_fail_memory(error, "places of an area light");
    size_t count = status == SL_OK ? sl_map_light_divide(l->scene, light, lights->emitter + light->first, n, fine) : 0;
    for (size_t i = 0; i < count && status == SL_OK; i++) {
        fine[i].light = index;
        places[i] = (place){fine[i], owner_of(lights, first, end, fine[i].position), 0.0};
        status = openness(l, &places[i].at, 0.5 * side, &places[i].open, error);
    }
    sl_map_light_point *moved = sl_allocate(end - first, sizeof *moved); /* owners are told by where points stood */
    if (status == SL_OK && !moved) status = sl_fail_memory(error, "points of an area light");
    for (size_t i = first; i < end && status == SL_OK; i++) {
        moved[i - first] = lights->point[i];
        settle(&moved[i - first], side, places, count, i, own[i - first], found);
    }
    for (size_t i = first; i < end && status == SL_OK; i++) lights->point[i] = moved[i - first];
    sl_free(moved);
    sl_free(places);
    sl_free(fine);
    return status;
}

/* A light that is not divided takes its map's pictures from its own place. */
static void follow(sl_map_lights *lights, size_t first, size_t end) {
    if (end - first != 1) return;
    sl_map_light *light = &lights->light[lights->point[first].light];
    light->position = lights->point[first].position;
    light->intensity = lights->point[first].intensity;
}

static sl_status visit(const looking *l, unsigned subdivision, size_t first, size_t end, sl_map_lights *lights,
                       sl_light_openings *found, sl_error *error) {
    const sl_map_light *light = &lights->light[lights->point[first].light];
    const double side = sqrt((double)light->area / (double)(end - first));
    double own[FINEST * FINEST], wide = 0.0;
    bool near = false;
    sl_status status = SL_OK;
    if (light->kind != SL_MAP_LIGHT_AREA || subdivision > FINEST || !(side > 0.0)) return SL_OK;
    found->points += end - first;
    for (size_t i = first; i < end && status == SL_OK; i++) {
        status = openness(l, &lights->point[i], side, &wide, error);
        if (status == SL_OK && wide < ALIKE) status = openness(l, &lights->point[i], 0.5 * side, &own[i - first], error);
        else own[i - first] = 1.0;
        near = near || wide < 1.0;
    }
    if (status != SL_OK || !near) return status;
    status = examine(l, subdivision, first, end, side, own, lights, found, error);
    if (status == SL_OK) follow(lights, first, end);
    return status;
}

sl_status sl_map_lights_find_openings(const sl_scene *scene, const sl_raster *raster, unsigned subdivision, unsigned threads,
                                      sl_map_lights *lights, sl_light_openings *found, sl_counters *counters, sl_error *error) {
    *found = (sl_light_openings){0};
    looking l = {scene, raster, lights, threads, counters, sl_allocate(TEXELS, sizeof *l.depth)};
    sl_status status = l.depth ? SL_OK : sl_fail_memory(error, "a view from a light");
    for (size_t first = 0, end; first < lights->point_count && status == SL_OK; first = end) {
        for (end = first + 1; end < lights->point_count && lights->point[end].light == lights->point[first].light;) end++;
        status = visit(&l, subdivision, first, end, lights, found, error);
    }
    sl_free(l.depth);
    return status;
}
