/* How far the tangent plane of a record is free, by direction. Behind a thin wall the floor goes on, and a
 * record must not light it there. The guard on its radius (record.h, rule 2) is as good as the few rays of
 * its gather: near a wall, a tenth too generous; and the least radius overrules it. */
#include "cache/bounces/second_level.h"

#include <string.h>

/* Unit vectors at multiples of 22.5 degrees, the borders of the sectors. */
static const float border[SL_WALL_SECTORS][2] = {
    {1.0f, 0.0f},  {0.92387953f, 0.38268343f},   {0.70710678f, 0.70710678f},   {0.38268343f, 0.92387953f},
    {0.0f, 1.0f},  {-0.38268343f, 0.92387953f},  {-0.70710678f, 0.70710678f},  {-0.92387953f, 0.38268343f},
    {-1.0f, 0.0f}, {-0.92387953f, -0.38268343f}, {-0.70710678f, -0.70710678f}, {-0.38268343f, -0.92387953f},
    {0.0f, -1.0f}, {0.38268343f, -0.92387953f},  {0.70710678f, -0.70710678f},  {0.92387953f, -0.38268343f},
};

/* A straight wall at distance d, square to the middle of a sector, is met by the sector's borders at d /
 * cos(11.25 degrees). */
static const float to_the_middle = 0.98078528f;

/* Within the guard only what stands across the ray is a wall: a concave surface, met at a grazing angle, is
 * the record's own. */
static bool is_wall(const sl_scene *scene, const sl_ray16 *rays, const sl_hit16 *hits, int i,
                    bool within_guard) {
    if (hits->triangle[i] == SL_NO_INDEX) return false;
    sl_vec3 n = sl_scene_geometric_normal(scene, hits->triangle[i]);
    sl_vec3 d = sl_v3(rays->direction_x[i], rays->direction_y[i], rays->direction_z[i]);
    return !within_guard || fabsf(sl_dot(n, d)) > 0.5f;
}

void sl_second_walls_find(const sl_scene *scene, const sl_tracer *tracer, const sl_gather_point *point,
                          float accuracy, sl_record *record, sl_second_walls *walls, sl_counters *counters) {
    const float offset = sl_scene_offset_at(scene, 1e-5f * scene->scale, record->position),
                reach = accuracy * record->radius;
    const bool within_guard = !record->behind_a_wall;
    sl_frame frame = sl_frame_from_normal(sl_normalize_or(point->geometric_normal, record->normal));
    float height = 0.01f * reach > 2.0f * offset ? 0.01f * reach : 2.0f * offset;
    sl_vec3 eye = sl_mad(record->position, height, frame.z);
    sl_ray16 rays;
    sl_hit16 hits;
    memset(&rays, 0, sizeof rays);
    for (int i = 0; i < SL_WALL_SECTORS; i++) {
        sl_vec3 d = sl_frame_to_world(&frame, sl_v3(border[i][0], border[i][1], 0.0f));
        sl_ray16_set(&rays, (unsigned)i, eye, d, 0.0f, 1.1f * reach, point->triangle);
    }
    sl_trace(tracer, &rays, SL_PACKET, false, &hits, counters);
    walls->x = frame.x;
    walls->y = frame.y;
    float clear[SL_WALL_SECTORS];
    for (int i = 0; i < SL_WALL_SECTORS; i++)
        clear[i] = is_wall(scene, &rays, &hits, i, within_guard) ? hits.t[i] : 1.1f * reach;
    record->behind_a_wall = 0;
    for (int i = 0; i < SL_WALL_SECTORS; i++) {
        int next = (i + 1) % SL_WALL_SECTORS;
        float free = to_the_middle * (clear[i] < clear[next] ? clear[i] : clear[next]);
        if (free < reach) record->behind_a_wall = 1;
        unsigned sector = sl_wall_sector(border[i][0] + border[next][0], border[i][1] + border[next][1]);
        walls->free_squared[sector] = free * free;
    }
}
