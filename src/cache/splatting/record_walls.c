/* Rule 2 of the radius (record.h) without its price. The guard keeps a record from reaching past the nearest
 * thing that its gather saw, in all directions and however high above the surface that thing hangs. But only
 * a wall that stands on the surface has another room behind it. A few rays along the tangent plane find what
 * stands there; the record keeps the planes of two walls and does not count behind them, and reaches as far
 * as its metric says elsewhere. */
#include <string.h>

#include "cache/splatting/record.h"

enum { DIRECTIONS = SL_PACKET };

/* Unit vectors in the tangent frame of the geometric normal, 22.5 degrees apart. */
static const float around[DIRECTIONS][2] = {
    {1.0f, 0.0f},  {0.92387953f, 0.38268343f},   {0.70710678f, 0.70710678f},   {0.38268343f, 0.92387953f},
    {0.0f, 1.0f},  {-0.38268343f, 0.92387953f},  {-0.70710678f, 0.70710678f},  {-0.92387953f, 0.38268343f},
    {-1.0f, 0.0f}, {-0.92387953f, -0.38268343f}, {-0.70710678f, -0.70710678f}, {-0.38268343f, -0.92387953f},
    {0.0f, -1.0f}, {0.38268343f, -0.92387953f},  {0.70710678f, -0.70710678f},  {0.92387953f, -0.38268343f},
};

/* A ray's hit along the tangent plane, relative to the point, its normal on the point's side. */
typedef struct {
    sl_vec3 direction, point, normal;
    float distance; /* infinite: nothing, or nothing any more */
} wall_hit;

/* Rays a little above the surface, a little longer than the reach: a wall that the disc just touches between
 * two rays is met too. */
static void look_around(const sl_scene *scene, const sl_tracer *tracer, const sl_gather_point *point,
                           float reach, wall_hit hits[DIRECTIONS], sl_counters *counters) {
    const float offset = sl_scene_offset_at(scene, 1e-5f * scene->scale, point->position);
    sl_frame frame = sl_frame_from_normal(sl_normalize_or(point->geometric_normal, point->normal));
    float height = 0.01f * reach > 2.0f * offset ? 0.01f * reach : 2.0f * offset;
    sl_vec3 eye = sl_mad(point->position, height, frame.z);
    sl_ray16 rays;
    sl_hit16 found;
    memset(&rays, 0, sizeof rays);
    for (int i = 0; i < DIRECTIONS; i++) {
        const sl_vec3 direction = sl_frame_to_world(&frame, sl_v3(around[i][0], around[i][1], 0.0f));
        hits[i] = (wall_hit){.direction = direction, .distance = INFINITY};
        sl_ray16_set(&rays, (unsigned)i, eye, hits[i].direction, 0.0f, 1.1f * reach, point->triangle);
    }
    sl_trace(tracer, &rays, DIRECTIONS, false, &found, counters);
    for (int i = 0; i < DIRECTIONS; i++) {
        if (found.triangle[i] == SL_NO_INDEX) continue;
        sl_vec3 d = hits[i].direction, n = sl_scene_geometric_normal(scene, found.triangle[i]);
        hits[i].normal = sl_dot(n, d) > 0.0f ? sl_neg(n) : n;
        hits[i].point = sl_mad(sl_scale(d, found.t[i]), height, frame.z);
        hits[i].distance = found.t[i];
    }
}

static int nearest_of(const wall_hit hits[DIRECTIONS]) {
    int nearest = 0;
    for (int i = 1; i < DIRECTIONS; i++) {
        if (hits[i].distance < hits[nearest].distance) nearest = i;
    }
    return nearest;
}

void sl_record_find_walls(const sl_scene *scene, const sl_tracer *tracer, const sl_gather_point *point,
                          double accuracy, double guard, sl_record *record, sl_counters *counters) {
    const float offset = sl_scene_offset_at(scene, 1e-5f * scene->scale, point->position),
                reach = (float)accuracy * record->radius;
    const bool beyond = (double)record->radius > guard;
    wall_hit hits[DIRECTIONS];
    look_around(scene, tracer, point, reach, hits, counters);
    for (int i = 0; i < DIRECTIONS && !beyond; i++) {
        if (!(-sl_dot(hits[i].normal, hits[i].direction) > 0.5f)) hits[i].distance = INFINITY;
    }
    for (int w = 0; w < SL_RECORD_WALLS; w++) {
        const wall_hit wall = hits[nearest_of(hits)];
        if (!(wall.distance < INFINITY)) return;
        record->walls[w] =
            (sl_record_wall){wall.normal, fminf(sl_dot(wall.point, wall.normal), 0.0f) - offset};
        for (int i = 0; i < DIRECTIONS; i++) { /* what lies in the wall or behind it is dealt with */
            if (sl_dot(hits[i].point, wall.normal) <= record->walls[w].offset + 2.0f * offset)
                hits[i].distance = INFINITY;
        }
    }
    const wall_hit left = hits[nearest_of(hits)];
    if (!(left.distance < INFINITY)) return;
    /* More walls than the record can hold: no farther than the next one, which two rays may meet at its
     * sides. */
    double limit = 0.98 * (double)left.distance / accuracy;
    if (limit < guard) limit = guard;
    if (limit < (double)record->minimum_radius) limit = (double)record->minimum_radius;
    if (!(limit < (double)record->radius)) return;
    record->own_radius = (float)limit;
    sl_record_set_radius(record, record->own_radius);
}
