/* Irradiance at many points at once, and at the few that no second-level record covers.
 *
 * Such a point takes what the most similar record around says, one that it sees: beyond their reach records
 * promise nothing, and light must not come through walls. A point that sees none of the most similar ones
 * stays dark. */
#include "cache/bounces/second_level.h"

#include <string.h>

#include "base/counters.h"

sl_look_up_kernel *sl_look_up_kernel_for(sl_isa isa) { return SL_KERNEL_OF(isa, sl_look_up); }

float sl_second_weight(const sl_second_field *field, sl_look_up_kernel *kernel, const sl_gather_point *p) {
    const sl_second_points one = {1, &p->triangle, &p->position.x, &p->position.y, &p->position.z,
                                  &p->normal.x, &p->normal.y, &p->normal.z};
    sl_second_sums sums;
    kernel(field, &one, 0, 1, true, &sums);
    return sums.weight[0];
}

float sl_share_out_of_reach(const sl_second_field *field, sl_look_up_kernel *kernel,
                            const sl_probed *points) {
    size_t asked = 0, missed = 0;
    for (size_t i = 0; i < points->count; i++) {
        if (points->points[i].triangle == SL_NO_INDEX) continue;
        asked++;
        if (!(sl_second_weight(field, kernel, &points->points[i]) > 0.0f)) missed++;
    }
    return asked ? (float)missed / (float)asked : 0.0f;
}

/* ---- points that no record covers ---- */

enum { WIDE_LEVEL = 3 }; /* eighths of the scene */

typedef struct {
    const sl_second_field *field;
    sl_vec3 position, normal;
    uint32_t triangle;
    sl_counters *counters;
} lost_point;

static void set_segment(sl_ray16 *rays, unsigned i, sl_vec3 from, sl_vec3 to, uint32_t skip) {
    sl_ray16_set(rays, i, from, sl_sub(to, from), 0.0f, 1.0f, skip);
}

/* Both ends are lifted, so that a convex surface does not stand between its own points; nothing may be in the
 * way up either. */
static bool sees(const lost_point *p, const sl_record_terms *k) {
    float offset = p->field->offset,
          lift = 0.15f * sl_length(sl_sub(p->position, k->position)) + 2.0f * offset;
    sl_vec3 above = sl_mad(p->position, lift, p->normal), above_record = sl_mad(k->position, lift, k->normal);
    sl_ray16 rays;
    sl_vec3 across = sl_sub(above_record, above);
    if (!(sl_dot(across, across) > 0.0f)) return true;
    memset(&rays, 0, sizeof rays);
    /* the point's own triangle may stand before what lies behind it */
    set_segment(&rays, 0, above, above_record, SL_NO_INDEX);
    set_segment(&rays, 1, sl_mad(p->position, offset, p->normal), above, p->triangle);
    set_segment(&rays, 2, sl_mad(k->position, offset, k->normal), above_record, SL_NO_INDEX);
    return sl_trace_occluded(p->field->tracer, &rays, 3, false, p->counters) == 0;
}

/* The most similar records of a cell, the most similar first: by distance, and by how they face. Not by the D
 * of (2), which in units of their radii holds large records far away for near. */
enum { TRIES = 6 };
typedef struct {
    const sl_record_terms *terms[TRIES];
    float d[TRIES];
    int count;
} similar_records;

static void consider(similar_records *s, const sl_record_terms *k, float d) {
    for (int i = 0; i < s->count; i++)
        if (s->terms[i] == k) return; /* of another cell */
    if (s->count == TRIES && !(d < s->d[TRIES - 1])) return;
    int i = s->count < TRIES ? s->count++ : TRIES - 1;
    for (; i > 0 && d < s->d[i - 1]; i--) {
        s->d[i] = s->d[i - 1];
        s->terms[i] = s->terms[i - 1];
    }
    s->d[i] = d;
    s->terms[i] = k;
}

static void consider_node(const lost_point *p, const sl_record_node *node, similar_records *similar) {
    const sl_record_octree *octree = p->field->octree;
    for (uint32_t b = node->first; b; b = octree->blocks[b].next) {
        for (uint32_t l = 0; l < octree->blocks[b].count; l++) {
            const sl_record_terms *k = &p->field->list->terms[octree->blocks[b].record[l]];
            sl_vec3 turn = sl_sub(p->normal, k->normal);
            float turn_squared = sl_dot(turn, turn);
            if (!(turn_squared < 2.0f)) continue;
            float squared = sl_record_squared_distance(k, p->position.x, p->position.y, p->position.z);
            consider(similar, k, squared * (1.0f + 2.0f * turn_squared));
        }
    }
}

static void consider_below(const lost_point *p, const sl_record_node *node, similar_records *similar) {
    consider_node(p, node, similar);
    for (int c = 0; c < 8; c++) {
        if (node->child[c]) consider_below(p, &p->field->octree->nodes[node->child[c]], similar);
    }
}

static bool ask_similar(const lost_point *p, const similar_records *similar, sl_rgb *e) {
    for (int k = 0; k < similar->count; k++) {
        const float *of = similar->terms[k]->e;
        *e = (sl_rgb){of[0], of[1], of[2]};
        if (sees(p, similar->terms[k])) return true;
    }
    return false;
}

/* Asks the records that are listed in the cells around the point, then all of the widest of those cells. */
static sl_rgb irradiance_of_lost(const sl_second_field *field, const sl_second_points *points, size_t i,
                                 sl_counters *counters) {
    const lost_point p = {field, sl_v3(points->position_x[i], points->position_y[i], points->position_z[i]),
                          sl_v3(points->normal_x[i], points->normal_y[i], points->normal_z[i]),
                          points->triangle[i], counters};
    const sl_record_node *way[SL_OCTREE_LEVELS + 1];
    const int nodes = sl_octree_way(field->octree, p.position.x, p.position.y, p.position.z, way);
    similar_records near = {.count = 0}, wide = {.count = 0};
    sl_rgb e;
    sl_count(counters, SL_COUNT_SECOND_LEVEL_MISSES, 1);
    for (int n = 0; n < nodes; n++) consider_node(&p, way[n], &near);
    if (ask_similar(&p, &near, &e)) return e;
    if (nodes > WIDE_LEVEL) consider_below(&p, way[WIDE_LEVEL], &wide);
    return ask_similar(&p, &wide, &e) ? e : sl_grey(0.0f);
}

/* ---- all points ---- */

void sl_second_look_up(const sl_second_field *field, sl_look_up_kernel *kernel,
                       const sl_second_points *points, float *r, float *g, float *b, sl_counters *counters) {
    sl_second_sums sums;
    uint64_t looked_up = 0;
    for (size_t first = 0; first < points->count; first += SL_LOOK_UP_MAX) {
        size_t left = points->count - first, count = left < SL_LOOK_UP_MAX ? left : (size_t)SL_LOOK_UP_MAX;
        kernel(field, points, first, count, false, &sums);
        for (size_t i = 0; i < count; i++) {
            if (points->triangle[first + i] == SL_NO_INDEX) continue;
            looked_up++;
            sl_rgb e;
            if (sums.weight[i] > 0.0f) {
                float scale = 1.0f / sums.weight[i];
                e = (sl_rgb){sums.r[i] * scale, sums.g[i] * scale, sums.b[i] * scale};
            } else {
                e = irradiance_of_lost(field, points, first + i, counters);
            }
            r[first + i] += e.r;
            g[first + i] += e.g;
            b[first + i] += e.b;
        }
    }
    sl_count(counters, SL_COUNT_SECOND_LEVEL_LOOK_UPS, looked_up);
}
