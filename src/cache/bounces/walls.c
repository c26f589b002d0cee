/* How far the tangent plane of a record is free, by direction. Behind a thin wall the floor goes on, and a
 * record must not light it there. The guard on its radius (record.h, rule 2) is as good as the few rays of
 * its gather: near a wall, a tenth too generous; and the least radius overrules it. */
#include "cache/bounces/second_level.h"

/* A straight wall at distance d, square to the middle of a sector, is met by the sector's borders at d /
 * cos(11.25 degrees). */
static const float to_the_middle = 0.98078528f;

/* Within the guard only what stands across the ray is a wall: a concave surface, met at a grazing angle, is
 * the record's own. */
static bool is_wall(const sl_wall_hit *hit, bool within_guard) {
    return hit->distance < INFINITY && (!within_guard || -sl_dot(hit->normal, hit->direction) > 0.5f);
}

void sl_second_walls_find(const sl_scene *scene, const sl_tracer *tracer, const sl_gather_point *point,
                          float accuracy, sl_record *record, sl_second_walls *walls, sl_counters *counters) {
    const float reach = accuracy * record->radius;
    const bool within_guard = !record->behind_a_wall;
    sl_frame frame = sl_frame_from_normal(sl_normalize_or(point->geometric_normal, record->normal));
    sl_wall_hit hits[SL_WALL_SECTORS];
    sl_record_look_around(scene, tracer, point, reach, hits, counters);
    walls->x = frame.x;
    walls->y = frame.y;
    float clear[SL_WALL_SECTORS];
    for (int i = 0; i < SL_WALL_SECTORS; i++)
        clear[i] = is_wall(&hits[i], within_guard) ? hits[i].distance : 1.1f * reach;
    record->behind_a_wall = 0;
    for (int i = 0; i < SL_WALL_SECTORS; i++) {
        int next = (i + 1) % SL_WALL_SECTORS;
        float free = to_the_middle * (clear[i] < clear[next] ? clear[i] : clear[next]);
        if (free < reach) record->behind_a_wall = 1;
        unsigned sector = sl_wall_sector(sl_around[i][0] + sl_around[next][0],
                                         sl_around[i][1] + sl_around[next][1]);
        walls->free_squared[sector] = free * free;
    }
}
