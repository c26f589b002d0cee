/* (1) of Gautron et al. 2005 at points instead of pixels: E(p) = sum of w_k E'_k over sum of w_k, for the
 * records that reach p. Sixteen records are weighed together; what the few that count say is added one after
 * the other, in the order of the octree's levels and of their indices. */
#include "cache/bounces/second_level.h"

#include "base/lanes.h"

typedef struct {
    float x, y, z, nx, ny, nz;
} look_up_point;

static inline uint32_t weigh(const sl_record_block *restrict block, const sl_weight_rules *rules,
                             const look_up_point *p, float *restrict w) {
    const float px = p->x, py = p->y, pz = p->z, nx = p->nx, ny = p->ny, nz = p->nz;
    float distance[SL_OCTREE_LANES], slack[SL_OCTREE_LANES];
#pragma omp simd
    for (int l = 0; l < SL_OCTREE_LANES; l++) {
        float x = px - block->x[l], y = py - block->y[l], z = pz - block->z[l];
        distance[l] = x * x + y * y + z * z;
        slack[l] = block->reach_squared[l] - distance[l];
    }
    if (!(sl_bits16_greater(slack, 0.0f))) return 0;
#pragma omp simd
    for (int l = 0; l < SL_OCTREE_LANES; l++) {
        const sl_record_terms k = {.position = {block->x[l], block->y[l], block->z[l]},
                                   .normal = {block->normal_x[l], block->normal_y[l], block->normal_z[l]},
                                   .inverse_radius = block->inverse_radius[l],
                                   .accuracy = rules->accuracy,
                                   .least = sl_record_least_distance(rules->accuracy),
                                   .offset = rules->offset,
                                   .front = block->front[l],
                                   .behind = block->behind[l]};
        float here = sl_record_weight_at(&k, distance[l], px, py, pz, nx, ny, nz);
        w[l] = slack[l] >= 0.0f ? here : 0.0f;
    }
    return sl_bits16_greater(w, 0.0f);
}

typedef struct look_up_sums {
    float r, g, b, weight;
} sums;

/* Records that reach a point; beyond so many the rest counts little. */
enum { REACHING = 64 };

typedef struct {
    uint32_t record[REACHING];
    float weight[REACHING];
    uint32_t count;
} reaching;

static inline void add_block(const sl_second_cache *cache, const sl_record_block *block,
                             const look_up_point *p, bool without_light, reaching *list, sums *sum) {
    float w[SL_OCTREE_LANES];
    for (uint32_t bits = weigh(block, &cache->rules, p, w), l = 0; bits; bits >>= 1, l++) {
        if (!(bits & 1u)) continue;
        const sl_record_terms *k = &cache->list.terms[block->record[l]];
        const sl_record_offsets o = sl_record_offsets_at(k, p->x, p->y, p->z, p->nx, p->ny, p->nz);
        if (k->has_walls && !sl_record_before_walls(k, o.x, o.y, o.z)) continue;
        if (list) {
            if (list->count == REACHING) continue;
            list->record[list->count] = block->record[l];
            list->weight[list->count++] = w[l];
        }
        sum->weight += w[l];
        if (without_light) continue;
        float turn = sl_record_turn(&o);
        sum->r += w[l] * sl_record_extrapolate(k, 0, &o, turn);
        sum->g += w[l] * sl_record_extrapolate(k, 1, &o, turn);
        sum->b += w[l] * sl_record_extrapolate(k, 2, &o, turn);
    }
}

static inline sums sum_at(const sl_second_cache *cache, const look_up_point *p, bool without_light,
                          reaching *list) {
    const sl_record_octree *octree = &cache->octree;
    const sl_record_node *way[SL_OCTREE_LEVELS + 1];
    const int nodes = sl_octree_way(octree, p->x, p->y, p->z, way);
    sums sum = {0.0f, 0.0f, 0.0f, 0.0f};
    for (int n = 0; n < nodes; n++) {
        for (uint32_t b = way[n]->first; b; b = octree->blocks[b].next)
            add_block(cache, &octree->blocks[b], p, without_light, list, &sum);
    }
    return sum;
}

static inline look_up_point point_of(const sl_second_points *points, size_t i) {
    return (look_up_point){points->position_x[i], points->position_y[i], points->position_z[i],
                           points->normal_x[i],   points->normal_y[i],   points->normal_z[i]};
}

/* Points that no record reaches receive the mean of those around them that one reaches: none at all would
 * darken places full of small things with every bounce. */
enum { CHUNK = 256 };

typedef struct {
    double light[3];
    uint32_t found, missed;
    uint32_t miss[CHUNK];
} chunk_sums;

static void give_mean(const chunk_sums *c, float *const light[3]) {
    for (int k = 0; k < 3 && c->found; k++) {
        const float mean = (float)(c->light[k] / c->found);
        for (uint32_t m = 0; m < c->missed; m++) light[k][c->miss[m]] += mean;
    }
}

uint64_t SL_KERNEL(sl_look_up)(const sl_second_cache *cache, const sl_second_points *points,
                               float *const light[3], float *weight, bool *missed_at) {
    uint64_t missed = 0;
    for (size_t first = 0; first < points->count; first += CHUNK) {
        const size_t end = first + CHUNK < points->count ? first + CHUNK : points->count;
        chunk_sums c = {.found = 0};
        for (size_t i = first; i < end; i++) {
            if (points->triangle[i] == SL_NO_INDEX) continue;
            const look_up_point p = point_of(points, i);
            const sums sum = sum_at(cache, &p, !light, NULL);
            if (weight) weight[i] = sum.weight;
            if (missed_at) missed_at[i] = !(sum.weight > 0.0f);
            if (!(sum.weight > 0.0f)) {
                c.miss[c.missed++] = (uint32_t)i;
            } else if (light) {
                const float scale = 1.0f / sum.weight, e[3] = {sum.r * scale, sum.g * scale, sum.b * scale};
                for (int k = 0; k < 3; k++) {
                    light[k][i] += e[k];
                    c.light[k] += (double)e[k];
                }
                c.found++;
            }
        }
        if (light) give_mean(&c, light);
        missed += c.missed;
    }
    return missed;
}

/* ---- what records send to each other ---- */

static void add_shares(const reaching *list, float weight, const float reflected[3],
                       sl_link_sums *links) {
    for (uint32_t n = 0; n < list->count; n++) {
        float *share = links->share[list->record[n]];
        const float w = list->weight[n] / weight;
        if (share[0] < 0.0f) {
            share[0] = share[1] = share[2] = 0.0f;
            links->touched[links->count++] = list->record[n];
        }
        for (int c = 0; c < 3; c++) share[c] += w * reflected[c];
    }
}

/* A Lambertian surface that receives E sends k_d / pi E, and of N rays with equal cosine weights each counts
 * pi / N. Points that no record reaches send as much as the others do in the mean. */
void SL_KERNEL(sl_second_links)(const sl_second_cache *cache, const sl_gather_hits_seen *seen,
                                   sl_link_sums *links) {
    const sl_second_points *points = &seen->points;
    const float each = 1.0f / (float)(points->count ? points->count : 1);
    double all[3] = {0.0, 0.0, 0.0}, found[3] = {0.0, 0.0, 0.0};
    for (size_t i = 0; i < points->count; i++) {
        const float reflected[3] = {each * seen->diffuse[0][i], each * seen->diffuse[1][i],
                                    each * seen->diffuse[2][i]};
        if (points->triangle[i] == SL_NO_INDEX || !(reflected[0] + reflected[1] + reflected[2] > 0.0f))
            continue;
        const look_up_point p = point_of(points, i);
        reaching list;
        list.count = 0;
        const struct look_up_sums sum = sum_at(cache, &p, true, &list);
        for (int c = 0; c < 3; c++) all[c] += (double)reflected[c];
        if (!(sum.weight > 0.0f)) continue;
        for (int c = 0; c < 3; c++) found[c] += (double)reflected[c];
        add_shares(&list, sum.weight, reflected, links);
    }
    for (uint32_t n = 0; n < links->count; n++) {
        for (int c = 0; c < 3; c++)
            if (found[c] > 0.0) links->share[links->touched[n]][c] *= (float)(all[c] / found[c]);
    }
}
