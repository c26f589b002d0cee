/* Irradiance at many points at once, and at the few that no second-level record covers.
 *
 * Such a point takes what the most similar record around says, one that it sees: beyond their reach records
 * promise nothing, and light must not come through walls. A point that sees none of the most similar ones
 * stays dark. */
#include "cache/bounces/second_level.h"

#include <string.h>

#include "base/counters.h"

sl_look_up_kernel *sl_look_up_kernel_for(sl_isa isa) { return SL_KERNEL_OF(isa, sl_look_up); }

float sl_second_weight(const sl_second_list *list, size_t record, sl_vec3 position, sl_vec3 normal) {
    const sl_record_terms *k = &list->terms[record];
    float squared = sl_record_squared_distance(k, position.x, position.y, position.z);
    if (!(k->reach_squared - squared >= 0.0f)) return 0.0f;
    float w =
        sl_record_weight_at(k, squared, position.x, position.y, position.z, normal.x, normal.y, normal.z);
    if (!(w > 0.0f) || !list->records[record].behind_a_wall) return w;
    const sl_second_walls *walls = &list->walls[record];
    sl_vec3 d = sl_sub(position, k->position);
    return sl_wall_stands_between(walls, d.x, d.y, d.z) ? 0.0f : w;
}

/* ---- points that no record covers ---- */

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

/* The most similar records of a leaf, the most similar first: by distance, and by how they face. Not by the D
 * of (2), which in units of their radii holds large records far away for near. */
enum { TRIES = 6 };
typedef struct {
    const sl_record_terms *terms[TRIES];
    float d[TRIES];
    int count;
} similar_records;

static void consider(similar_records *s, const sl_record_terms *k, float d) {
    if (s->count == TRIES && !(d < s->d[TRIES - 1])) return;
    int i = s->count < TRIES ? s->count++ : TRIES - 1;
    for (; i > 0 && d < s->d[i - 1]; i--) {
        s->d[i] = s->d[i - 1];
        s->terms[i] = s->terms[i - 1];
    }
    s->d[i] = d;
    s->terms[i] = k;
}

static similar_records most_similar(const lost_point *p, const sl_record_tree *tree) {
    const sl_second_list *list = p->field->list;
    const sl_tree_node *leaf = sl_tree_leaf(tree, p->position.x, p->position.y, p->position.z);
    similar_records similar = {.count = 0};
    for (uint32_t b = 0; b < leaf->blocks; b++) {
        const sl_tree_block *block = &tree->blocks[leaf->first + b];
        for (int l = 0; l < SL_TREE_LANES && block->reach_squared[l] >= 0.0f; l++) {
            const sl_record_terms *k = &list->terms[block->record[l] & ~SL_TREE_WALLS];
            sl_vec3 turn = sl_sub(p->normal, k->normal);
            float turn_squared = sl_dot(turn, turn);
            if (!(turn_squared < 2.0f)) continue;
            float squared = sl_record_squared_distance(k, p->position.x, p->position.y, p->position.z);
            consider(&similar, k, squared * (1.0f + 2.0f * turn_squared));
        }
    }
    return similar;
}

static sl_rgb irradiance_of_lost(const sl_second_field *field, const sl_second_points *points, size_t i,
                                 sl_counters *counters) {
    const lost_point p = {field, sl_v3(points->position_x[i], points->position_y[i], points->position_z[i]),
                          sl_v3(points->normal_x[i], points->normal_y[i], points->normal_z[i]),
                          points->triangle[i], counters};
    const sl_record_tree *const trees[] = {field->near, field->wide};
    sl_count(counters, SL_COUNT_SECOND_LEVEL_MISSES, 1);
    for (int t = 0; t < 2; t++) {
        if (!trees[t] || !trees[t]->node_count) continue;
        const similar_records similar = most_similar(&p, trees[t]);
        for (int k = 0; k < similar.count; k++) {
            const float *e = similar.terms[k]->e;
            if (sees(&p, similar.terms[k])) return (sl_rgb){e[0], e[1], e[2]};
        }
    }
    return sl_grey(0.0f);
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
