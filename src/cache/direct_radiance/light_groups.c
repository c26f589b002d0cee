#include "base/error.h"
#include "base/memory.h"
#include "cache/direct_radiance/lights.h"

#include <stdlib.h>
#include <string.h>

/* ---- side by side in one plane ---- */

typedef struct {
    sl_vec3 position;
    uint32_t emitter;
} corner;

static int compare_floats(float a, float b) { return (a > b) - (a < b); }

static int by_position(const void *a, const void *b) {
    const corner *p = a, *q = b;
    int order = compare_floats(p->position.x, q->position.x);
    if (!order) order = compare_floats(p->position.y, q->position.y);
    if (!order) order = compare_floats(p->position.z, q->position.z);
    return order ? order : (p->emitter > q->emitter) - (p->emitter < q->emitter);
}

static bool same_place(const corner *a, const corner *b) {
    return a->position.x == b->position.x && a->position.y == b->position.y && a->position.z == b->position.z;
}

static sl_vec3 first_corner(const sl_scene *s, uint32_t emitter) {
    return sl_scene_position(s, s->vertex[0][s->emitters[emitter].triangle]);
}

/* In b's plane all of a lies, since they share a corner and their normals agree; the distance keeps long
 * chains from drifting. */
static bool one_light(const sl_scene *s, uint32_t a, uint32_t b) {
    uint32_t t = s->emitters[a].triangle, u = s->emitters[b].triangle;
    sl_vec3 n = sl_scene_geometric_normal(s, t), m = sl_scene_geometric_normal(s, u);
    float height = sl_dot(m, sl_sub(first_corner(s, a), first_corner(s, b)));
    return s->object_index[t] == s->object_index[u] && s->material_index[t] == s->material_index[u] &&
           sl_dot(n, m) > 1.0f - 1e-6f && height < 1e-5f * s->scale && height > -1e-5f * s->scale;
}

static uint32_t root_of(uint32_t *parent, uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
}

/* The lower root stays: a group's root is its first emitter. */
static void unite(uint32_t *parent, uint32_t a, uint32_t b) {
    uint32_t low = a < b ? a : b;
    parent[a] = low;
    parent[b] = low;
}

/* Corners [0, count) are one point: each emitter there joins the first earlier group that it fits. */
static void unite_around(const sl_scene *s, const corner *c, size_t count, uint32_t *parent, uint32_t *seen) {
    size_t groups = 0;
    for (size_t i = 0; i < count; i++) {
        uint32_t root = root_of(parent, c[i].emitter);
        size_t k = 0;
        while (k < groups && root != root_of(parent, seen[k]) &&
               !one_light(s, root, root_of(parent, seen[k])))
            k++;
        if (k == groups) seen[groups++] = root;
        else unite(parent, root, root_of(parent, seen[k]));
    }
}

static bool shines(const sl_emitter *e) {
    return e->area > 0.0f && e->opaque > 0.0f && sl_rgb_max(e->radiance) > 0.0f &&
           sl_rgb_is_finite(sl_rgb_scale(e->radiance, e->area));
}

static size_t list_corners(const sl_scene *s, corner *list) {
    size_t count = 0;
    for (uint32_t e = 0; e < s->emitter_count; e++) {
        for (int k = 0; k < 3 && shines(&s->emitters[e]); k++)
            list[count++] = (corner){sl_scene_position(s, s->vertex[k][s->emitters[e].triangle]), e};
    }
    return count;
}

static void find_groups(const sl_scene *s, corner *list, uint32_t *parent, uint32_t *seen) {
    size_t count = list_corners(s, list);
    qsort(list, count, sizeof *list, by_position);
    for (uint32_t e = 0; e < s->emitter_count; e++) parent[e] = e;
    for (size_t i = 0, end; i < count; i = end) {
        for (end = i + 1; end < count && same_place(&list[i], &list[end]);) end++;
        unite_around(s, list + i, end - i, parent, seen);
    }
}

sl_status sl_emitters_group(const sl_scene *scene, uint32_t *group, size_t *groups, sl_error *error) {
    size_t count = scene->emitter_count;
    corner *list = sl_allocate(3 * count, sizeof *list);
    uint32_t *parent = sl_allocate(count, sizeof *parent), *seen = sl_allocate(3 * count, sizeof *seen);
    bool ok = list && parent && seen;
    *groups = 0;
    if (ok) find_groups(scene, list, parent, seen);
    for (uint32_t e = 0; ok && e < count; e++) {
        uint32_t root = root_of(parent, e);
        group[e] = !shines(&scene->emitters[e]) ? SL_NO_INDEX
                   : root == e                  ? (uint32_t)(*groups)++
                                                : group[root];
    }
    sl_free(list);
    sl_free(parent);
    sl_free(seen);
    return ok ? SL_OK : sl_fail_memory(error, "the lights' emitters");
}

/* ---- merging ---- */

enum { FEATURES = 6 };

/* Seeds order[first .. first + count). */
typedef struct {
    size_t first, count;
    double mean[FEATURES], variance[FEATURES], cost;
} cluster_of_seeds;

typedef struct {
    const sl_light_seed *seed;
    double over_size;
    uint32_t *order, *aside;
    size_t count;
    cluster_of_seeds *cluster;
} merging;

/* A turn of the normal by a right angle counts as much as a way of half the scene. */
static double feature(const merging *m, uint32_t i, int k) {
    const sl_light_seed *s = &m->seed[i];
    const float value[FEATURES] = {s->position.x, s->position.y, s->position.z,
                                   s->normal.x,   s->normal.y,   s->normal.z};
    return (double)value[k] * (k < 3 ? m->over_size : 0.35);
}

/* Weighted by power; weak seeds alone still have places, so each weighs a little. */
static void measure(const merging *m, cluster_of_seeds *c) {
    double power = 0.0, least;
    for (size_t i = 0; i < c->count; i++) power += m->seed[m->order[c->first + i]].power;
    least = power > 0.0 ? 1e-9 * power / (double)c->count : 1.0;
    c->cost = 0.0;
    for (int k = 0; k < FEATURES; k++) {
        double sum = 0.0, weights = 0.0, spread = 0.0;
        for (size_t i = 0; i < c->count; i++) {
            double w = m->seed[m->order[c->first + i]].power + least;
            sum += w * feature(m, m->order[c->first + i], k);
            weights += w;
        }
        c->mean[k] = sum / weights;
        for (size_t i = 0; i < c->count; i++) {
            double d = feature(m, m->order[c->first + i], k) - c->mean[k];
            spread += (m->seed[m->order[c->first + i]].power + least) * d * d;
        }
        c->variance[k] = spread / weights;
        c->cost += c->count > 1 ? c->variance[k] * power : 0.0;
    }
}

/* At the mean of the feature that varies most; false where nothing is parted. */
static bool split(merging *m, cluster_of_seeds *c) {
    int axis = 0;
    size_t low = 0, high = 0;
    for (int k = 1; k < FEATURES; k++) axis = c->variance[k] > c->variance[axis] ? k : axis;
    for (size_t i = 0; i < c->count; i++) {
        uint32_t seed = m->order[c->first + i];
        if (feature(m, seed, axis) > c->mean[axis]) m->aside[high++] = seed;
        else m->order[c->first + low++] = seed;
    }
    memcpy(m->order + c->first + low, m->aside, high * sizeof *m->order);
    c->cost = 0.0;
    if (!low || !high) return false;
    cluster_of_seeds *upper = &m->cluster[m->count++];
    *upper = (cluster_of_seeds){.first = c->first + low, .count = high};
    c->count = low;
    measure(m, c);
    measure(m, upper);
    return true;
}

/* A cluster for each kind. */
static void begin(merging *m, size_t seeds) {
    size_t done = 0;
    for (int kind = 0; done < seeds; kind++) {
        size_t first = done;
        for (uint32_t i = 0; i < seeds; i++) {
            if (m->seed[i].kind == kind) m->order[done++] = i;
        }
        if (done == first) continue;
        m->cluster[m->count] = (cluster_of_seeds){.first = first, .count = done - first};
        measure(m, &m->cluster[m->count++]);
    }
}

static void split_costliest(merging *m, size_t most) {
    for (bool more = true; more && m->count < most;) {
        size_t worst = 0;
        for (size_t c = 1; c < m->count; c++) worst = m->cluster[c].cost > m->cluster[worst].cost ? c : worst;
        more = m->cluster[worst].cost > 0.0;
        if (more) split(m, &m->cluster[worst]);
    }
}

/* Numbers the clusters by their first seed. */
static size_t number(const merging *m, size_t seeds, uint32_t *cluster, uint32_t *renumbered) {
    size_t count = 0;
    for (size_t c = 0; c < m->count; c++) {
        renumbered[c] = SL_NO_INDEX;
        for (size_t i = 0; i < m->cluster[c].count; i++)
            cluster[m->order[m->cluster[c].first + i]] = (uint32_t)c;
    }
    for (size_t i = 0; i < seeds; i++) {
        uint32_t c = cluster[i];
        if (renumbered[c] == SL_NO_INDEX) renumbered[c] = (uint32_t)count++;
        cluster[i] = renumbered[c];
    }
    return count;
}

sl_status sl_light_seeds_merge(const sl_light_seed *seed, size_t count, size_t most, float size,
                               uint32_t *cluster, size_t *clusters, sl_error *error) {
    *clusters = count;
    for (size_t i = 0; i < count; i++) cluster[i] = (uint32_t)i;
    if (count <= most) return SL_OK;
    merging m = {.seed = seed,
                 .over_size = 1.0 / (double)size,
                 .order = sl_allocate(count, sizeof *m.order),
                 .aside = sl_allocate(count, sizeof *m.aside),
                 .cluster = sl_allocate(most, sizeof *m.cluster)};
    uint32_t *renumbered = sl_allocate(most, sizeof *renumbered);
    bool ok = m.order && m.aside && m.cluster && renumbered;
    if (ok) {
        begin(&m, count);
        split_costliest(&m, most);
        *clusters = number(&m, count, cluster, renumbered);
    }
    sl_free(m.order);
    sl_free(m.aside);
    sl_free(m.cluster);
    sl_free(renumbered);
    return ok ? SL_OK : sl_fail_memory(error, "the lights' clusters");
}
