/* A balanced kd-tree (Bentley 1975): a range's photon in the middle splits it along the longest side of its
 * box; those before it are lower, by (coordinate, id). */
#include <math.h>

#include "cache/shading_cache/caustic_map.h"

static float along(sl_vec3 p, int axis) { return axis == 0 ? p.x : axis == 1 ? p.y : p.z; }

static bool lower(const sl_caustic_photon *a, const sl_caustic_photon *b, int axis) {
    float x = along(a->position, axis), y = along(b->position, axis);
    return x < y || (x == y && a->id < b->id);
}

/* ---- building -------------------------------------------------------------------------------- */

static int longest_axis(const sl_caustic_photon *p, size_t count) {
    sl_vec3 low = p[0].position, high = low;
    for (size_t i = 1; i < count; i++) {
        sl_vec3 q = p[i].position;
        low = sl_v3(fminf(low.x, q.x), fminf(low.y, q.y), fminf(low.z, q.z));
        high = sl_v3(fmaxf(high.x, q.x), fmaxf(high.y, q.y), fmaxf(high.z, q.z));
    }
    sl_vec3 size = sl_sub(high, low);
    return size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
}

static void swap(sl_caustic_photon *a, sl_caustic_photon *b) {
    sl_caustic_photon c = *a;
    *a = *b;
    *b = c;
}

/* Lower ones before place `middle`, others after it (Hoare's selection). */
static void select_middle(sl_caustic_photon *p, size_t count, size_t middle, int axis) {
    size_t first = 0, end = count;
    while (end - first > 1) {
        swap(&p[first + (end - first) / 2], &p[end - 1]);
        sl_caustic_photon *pivot = &p[end - 1];
        size_t place = first;
        for (size_t i = first; i + 1 < end; i++) {
            if (lower(&p[i], pivot, axis)) swap(&p[i], &p[place++]);
        }
        swap(&p[place], pivot);
        if (place == middle) return;
        if (place < middle) first = place + 1;
        else end = place;
    }
}

void sl_caustic_tree_build(sl_caustic_photon *p, size_t count) {
    while (count > 1) {
        int axis = longest_axis(p, count);
        size_t middle = count / 2;
        select_middle(p, count, middle, axis);
        p[middle].axis = (uint8_t)axis;
        sl_caustic_tree_build(p, middle);
        p += middle + 1;
        count -= middle + 1;
    }
}

/* ---- searching ------------------------------------------------------------------------------- */

static const double flatness = 4.0;     /* how many times as far what is off the tangent plane counts */
static const float least_cosine = 0.7f; /* between normals */

typedef struct search {
    const sl_caustic_map *map;
    sl_vec3d centre, n;
    sl_vec3 position, normal;
    double squared;                     /* no farther than that */
    sl_near_photon *near;
    size_t count;
} search;

/* Farther, and on a tie emitted later. */
static bool farther(const search *s, sl_near_photon a, sl_near_photon b) {
    return a.squared > b.squared ||
           (a.squared == b.squared && s->map->photon[a.place].id > s->map->photon[b.place].id);
}

static void sink(search *s, size_t i) {
    for (;;) {
        size_t child = 2 * i + 1;
        if (child >= s->count) return;
        if (child + 1 < s->count && farther(s, s->near[child + 1], s->near[child])) child++;
        if (!farther(s, s->near[child], s->near[i])) return;
        sl_near_photon other = s->near[i];
        s->near[i] = s->near[child];
        s->near[child] = other;
        i = child;
    }
}

static void keep(search *s, sl_near_photon found) {
    if (s->count < SL_CAUSTIC_NEIGHBOURS) {
        s->near[s->count++] = found;
        if (s->count < SL_CAUSTIC_NEIGHBOURS) return;
        for (size_t i = s->count / 2; i-- > 0;) sink(s, i);
    } else {
        if (!farther(s, s->near[0], found)) return;
        s->near[0] = found;
        sink(s, 0);
    }
    s->squared = fmin(s->squared, s->near[0].squared);
}

static void consider(search *s, size_t place) {
    const sl_caustic_photon *p = &s->map->photon[place];
    if (!(sl_dot(p->normal, s->normal) > least_cosine)) return;
    sl_vec3d d = sl_subd(sl_to_double(p->position), s->centre);
    double off = sl_dotd(d, s->n), squared = sl_dotd(d, d) + (flatness * flatness - 1.0) * off * off;
    if (squared <= s->squared) keep(s, (sl_near_photon){squared, (uint32_t)place});
}

static void search_range(search *s, size_t first, size_t count) {
    while (count > 0) {
        size_t middle = count / 2, place = first + middle;
        const sl_caustic_photon *p = &s->map->photon[place];
        consider(s, place);
        if (count == 1) return;
        double beyond = (double)along(s->position, p->axis) - (double)along(p->position, p->axis);
        size_t low_first = first, low_count = middle, high_first = place + 1, high_count = count - middle - 1;
        bool low_near = beyond < 0.0;
        search_range(s, low_near ? low_first : high_first, low_near ? low_count : high_count);
        if (!(beyond * beyond <= s->squared)) return;
        first = low_near ? high_first : low_first;
        count = low_near ? high_count : low_count;
    }
}

size_t sl_caustic_nearest(const sl_caustic_map *map, sl_vec3 position, sl_vec3 normal, double radius,
                          sl_near_photon near[SL_CAUSTIC_NEIGHBOURS]) {
    search s = {.map = map,
                .centre = sl_to_double(position),
                .n = sl_to_double(normal),
                .position = position,
                .normal = normal,
                .squared = radius * radius,
                .near = near};
    search_range(&s, 0, map->count);
    if (s.count < SL_CAUSTIC_NEIGHBOURS) {
        for (size_t i = s.count / 2; i-- > 0;) sink(&s, i);
    }
    return s.count;
}
