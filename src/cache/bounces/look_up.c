/* Irradiance at many points at once, and at the few that no hidden record covers.
 *
 * Such a point asks further around: records count as if they reached twice as far, then four times. What their rules then no longer
 * promise is tested: a record must be seen from the point. At last the nearest that is seen stands in; and a
 * point that sees none of them stays dark, as light must not come through walls. */
#include "cache/bounces/hidden.h"

#include <string.h>

#include "base/counters.h"

sl_look_up_kernel *sl_look_up_kernel_for(sl_isa isa) {
#ifndef SL_BASELINE_ONLY
    if (isa == SL_ISA_AVX512) return sl_look_up_avx512;
    if (isa == SL_ISA_AVX2) return sl_look_up_avx2;
#endif
    (void)isa;
    return sl_look_up_baseline;
}

float sl_hidden_weight(const sl_hidden_list *list, size_t record, sl_vec3 position, sl_vec3 normal) {
    const sl_record_terms *k = &list->terms[record];
    float squared = sl_record_squared_distance(k, position.x, position.y, position.z);
    if (!(k->reach_squared - squared >= 0.0f)) return 0.0f;
    float w = sl_record_weight_at(k, squared, position.x, position.y, position.z, normal.x, normal.y, normal.z);
    if (!(w > 0.0f) || !list->records[record].behind_a_wall) return w;
    const sl_hidden_walls *walls = &list->walls[record];
    sl_vec3 d = sl_sub(position, k->position);
    return sl_wall_stands_between(walls, d.x, d.y, d.z) ? 0.0f : w;
}

/* ---- points that no record covers ---- */

typedef struct {
    const sl_hidden_field *field;
    sl_vec3 position, normal;
    uint32_t triangle;
    sl_counters *counters;
} lost_point;

static bool sees(const lost_point *p, const sl_record_terms *k) {
    float offset = p->field->offset;
    sl_vec3 from = sl_mad(p->position, offset, p->normal), to = sl_sub(sl_mad(k->position, offset, k->normal), from);
    sl_ray16 ray;
    if (!(sl_dot(to, to) > 0.0f)) return true;
    memset(&ray, 0, sizeof ray);
    ray.origin_x[0] = from.x, ray.origin_y[0] = from.y, ray.origin_z[0] = from.z;
    ray.direction_x[0] = to.x, ray.direction_y[0] = to.y, ray.direction_z[0] = to.z;
    ray.far[0] = 1.0f;
    ray.skip[0] = p->triangle;
    return !(sl_trace_occluded(p->field->tracer, &ray, 1, false, p->counters) & 1u);
}

/* The terms of a record that reaches `widen` times further; normals may differ by 45 degrees at most. */
static float widened_weight(const lost_point *p, const sl_record_terms *k, float widen) {
    const float turn_max = 0.76536686f; /* 2 sin(22.5 degrees) */
    float reach = sqrtf(k->reach_squared) * widen;
    sl_record_terms wide = *k;
    wide.accuracy = k->accuracy * widen;
    wide.offset = k->offset / widen;
    wide.front = -0.02f * reach - 2.0f * p->field->rules.front_tolerance;
    wide.behind = reach + 2.0f * p->field->rules.front_tolerance;
    float squared = sl_record_squared_distance(k, p->position.x, p->position.y, p->position.z);
    sl_vec3 turn = sl_sub(p->normal, k->normal);
    if (!(squared <= reach * reach) || !(sl_dot(turn, turn) <= turn_max * turn_max)) return 0.0f;
    return sl_record_weight_at(&wide, squared, p->position.x, p->position.y, p->position.z, p->normal.x, p->normal.y,
                               p->normal.z);
}

/* Not extrapolated: out there a gradient says little. */
static bool widened(const lost_point *p, const sl_tree_node *leaf, float widen, sl_rgb *irradiance) {
    const sl_hidden_list *list = p->field->list;
    float sum[3] = {0.0f, 0.0f, 0.0f}, weight = 0.0f;
    for (size_t i = 0; i < (size_t)leaf->blocks * SL_TREE_LANES; i++) {
        const sl_tree_block *block = &p->field->wide->blocks[leaf->first + i / SL_TREE_LANES];
        if (block->reach_squared[i % SL_TREE_LANES] < 0.0f) break;
        const sl_record_terms *k = &list->terms[block->record[i % SL_TREE_LANES] & ~SL_TREE_WALLS];
        float w = widened_weight(p, k, widen);
        if (!(w > 0.0f) || !sees(p, k)) continue;
        for (int c = 0; c < 3; c++) sum[c] += w * k->e[c];
        weight += w;
    }
    if (!(weight > 0.0f)) return false;
    *irradiance = (sl_rgb){sum[0] / weight, sum[1] / weight, sum[2] / weight};
    return true;
}

static bool nearest_seen(const lost_point *p, const sl_tree_node *leaf, sl_rgb *irradiance) {
    enum { TRIES = 8 };
    const sl_hidden_list *list = p->field->list;
    float beyond = -1.0f;
    for (int try = 0; try < TRIES; try++) { /* the nearest that is farther than the last one tried */
        const sl_record_terms *best = NULL;
        float best_squared = 0.0f;
        for (size_t i = 0; i < (size_t)leaf->blocks * SL_TREE_LANES; i++) {
            const sl_tree_block *block = &p->field->wide->blocks[leaf->first + i / SL_TREE_LANES];
            if (block->reach_squared[i % SL_TREE_LANES] < 0.0f) break;
            const sl_record_terms *k = &list->terms[block->record[i % SL_TREE_LANES] & ~SL_TREE_WALLS];
            float squared = sl_record_squared_distance(k, p->position.x, p->position.y, p->position.z);
            if (!(squared > beyond) || !(sl_dot(k->normal, p->normal) > 0.0f) || (best && !(squared < best_squared))) continue;
            best = k;
            best_squared = squared;
        }
        if (!best) return false;
        if (sees(p, best)) {
            *irradiance = (sl_rgb){best->e[0], best->e[1], best->e[2]};
            return true;
        }
        beyond = best_squared;
    }
    return false;
}

static sl_rgb irradiance_of_lost(const sl_hidden_field *field, const sl_hidden_points *points, size_t i, sl_counters *counters) {
    sl_rgb e = sl_grey(0.0f);
    sl_count(counters, SL_COUNT_HIDDEN_MISSES, 1);
    if (!field->wide || !field->wide->node_count) return e;
    const lost_point p = {field, sl_v3(points->position_x[i], points->position_y[i], points->position_z[i]),
                          sl_v3(points->normal_x[i], points->normal_y[i], points->normal_z[i]), points->triangle[i], counters};
    const sl_tree_node *leaf = sl_tree_leaf(field->wide, p.position.x, p.position.y, p.position.z);
    if (!widened(&p, leaf, 2.0f, &e) && !widened(&p, leaf, 4.0f, &e)) nearest_seen(&p, leaf, &e);
    return e;
}

/* ---- all points ---- */

void sl_hidden_look_up(const sl_hidden_field *field, sl_look_up_kernel *kernel, const sl_hidden_points *points, float *r, float *g,
                       float *b, sl_counters *counters) {
    sl_hidden_sums sums;
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
    sl_count(counters, SL_COUNT_HIDDEN_LOOK_UPS, looked_up);
}
