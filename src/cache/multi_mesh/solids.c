/* Solids: closed, consistently wound surfaces without light inside. Nobody sees their inner sides, so no samples are spent there; and a point of
 * another surface that lies inside one (where a table leg stands on the floor) sees a darkness that belongs to nobody. */
#include <math.h>

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "cache/multi_mesh/topology_parts.h"

typedef struct component {
    bool open;                /* not closed, or not a solid for another reason */
    double volume, area;      /* signed: positive where fronts look outwards */
    sl_vec3 low, high;
    uint32_t first, count;    /* its triangles in solids.triangle */
    bool shines, shines_back; /* its own emitters: any, any two-sided */
} component;

typedef struct solids {
    sl_topology *topology;
    uint32_t *parent;         /* union-find by triangle; a set's root is its lowest triangle */
    uint32_t *index;          /* component by triangle */
    uint32_t *triangle;       /* by component */
    component *component;
    size_t count;
    double budget;            /* triangle-light pairs that may still be looked at */
} solids;

/* ---- connected components -------------------------------------------------------------------------------------- */

static uint32_t find_root(uint32_t *parent, uint32_t t) {
    while (parent[t] != t) {
        parent[t] = parent[parent[t]];
        t = parent[t];
    }
    return t;
}

static void unite(uint32_t *parent, uint32_t a, uint32_t b) {
    a = find_root(parent, a);
    b = find_root(parent, b);
    if (a < b) parent[b] = a;
    else parent[a] = b;
}

/* The triangles' edges between positions: edge c of triangle t at 3 t + c; lower position first, *turned where the triangle runs the other way. */
static bool position_edge(const sl_topology *topology, const uint32_t *first_there, size_t half, uint32_t *low, uint32_t *high) {
    size_t f = 2 * (half / 3), c = half % 3;
    uint32_t a = first_there[topology->site[(c + 1) % 3][f]], b = first_there[topology->site[(c + 2) % 3][f]];
    *low = a < b ? a : b;
    *high = a < b ? b : a;
    return a > b;
}

/* Joins the triangles along each edge. An edge is closed where exactly two meet that run along it in opposite directions; others mark their
 * triangles in `loose`. */
static void join_along_edges(solids *s, const uint32_t *first_there, const uint32_t *low, const uint32_t *high, const uint32_t *order, uint8_t *loose) {
    size_t halves = 3 * s->topology->scene->triangle_count;
    for (size_t i = 0, end; i < halves; i = end) {
        for (end = i + 1; end < halves && low[order[end]] == low[order[i]] && high[order[end]] == high[order[i]];) end++;
        uint32_t a, b;
        bool closed = end - i == 2 && low[order[i]] != high[order[i]] &&
                      position_edge(s->topology, first_there, order[i], &a, &b) != position_edge(s->topology, first_there, order[i + 1], &a, &b);
        for (size_t j = i; j < end; j++) {
            unite(s->parent, order[i] / 3, order[j] / 3);
            loose[order[j] / 3] |= !closed;
        }
    }
}

static sl_status join(solids *s, const uint32_t *first_there, uint8_t *loose, sl_error *error) {
    size_t halves = 3 * s->topology->scene->triangle_count;
    uint32_t *low = sl_allocate(halves, sizeof *low), *high = sl_allocate(halves, sizeof *high), *order = sl_allocate(halves, sizeof *order);
    sl_status status = SL_OK;
    if (low == NULL || high == NULL || order == NULL) status = sl_fail_memory(error, "solids");
    for (size_t i = 0; status == SL_OK && i < halves; i++) position_edge(s->topology, first_there, i, &low[i], &high[i]);
    if (status == SL_OK) status = sl_order_pairs(low, high, halves, s->topology->site_count, order, error);
    if (status == SL_OK) join_along_edges(s, first_there, low, high, order, loose);
    sl_free(low);
    sl_free(high);
    sl_free(order);
    return status;
}

/* Components in the order of their lowest triangles, and the triangles of each. */
static sl_status list_components(solids *s, sl_error *error) {
    size_t triangles = s->topology->scene->triangle_count;
    for (uint32_t t = 0; t < triangles; t++) s->index[t] = find_root(s->parent, t) == t ? (uint32_t)s->count++ : s->index[find_root(s->parent, t)];
    s->component = sl_allocate(s->count, sizeof *s->component);
    if (s->component == NULL) return sl_fail_memory(error, "solids");
    for (size_t t = 0; t < triangles; t++) s->component[s->index[t]].count++;
    for (size_t c = 1; c < s->count; c++) s->component[c].first = s->component[c - 1].first + s->component[c - 1].count;
    for (size_t c = 0; c < s->count; c++) s->component[c].count = 0;
    for (uint32_t t = 0; t < triangles; t++) {
        component *c = &s->component[s->index[t]];
        s->triangle[c->first + c->count++] = t;
    }
    return SL_OK;
}

/* ---- what a component is --------------------------------------------------------------------------------------- */

static sl_vec3d corner(const sl_scene *scene, int c, uint32_t t) { return sl_to_double(sl_scene_position(scene, scene->vertex[c][t])); }

/* Volume by the tetrahedra from one of its own points; box; what its materials rule out. */
static void measure(const solids *s, component *c) {
    const sl_scene *scene = s->topology->scene;
    sl_vec3d origin = corner(scene, 0, s->triangle[c->first]);
    c->low = c->high = sl_to_float(origin);
    for (uint32_t i = 0; i < c->count; i++) {
        uint32_t t = s->triangle[c->first + i];
        sl_vec3d v[3];
        for (int k = 0; k < 3; k++) {
            sl_vec3 p = sl_scene_position(scene, scene->vertex[k][t]);
            v[k] = sl_subd(sl_to_double(p), origin);
            c->low = sl_v3(fminf(c->low.x, p.x), fminf(c->low.y, p.y), fminf(c->low.z, p.z));
            c->high = sl_v3(fmaxf(c->high.x, p.x), fmaxf(c->high.y, p.y), fmaxf(c->high.z, p.z));
        }
        sl_vec3d normal = sl_crossd(sl_subd(v[1], v[0]), sl_subd(v[2], v[0]));
        c->volume += sl_dotd(v[0], normal) / 6.0;
        c->area += 0.5 * sl_lengthd(normal);
        c->open |= sl_scene_has_alpha(scene, t); /* one sees through it */
        uint32_t emitter = scene->emitter_of_triangle[t];
        if (emitter == SL_NO_INDEX) continue;
        c->shines = true;
        c->shines_back |= scene->emitters[emitter].two_sided;
    }
    /* Two sheets back to back are closed as well, but have no inside. */
    c->open |= !(fabs(c->volume) > 1e-6 * (double)scene->scale * c->area);
}

static bool in_box(sl_vec3 low, sl_vec3 high, sl_vec3d p) {
    return p.x >= (double)low.x && p.x <= (double)high.x && p.y >= (double)low.y && p.y <= (double)high.y && p.z >= (double)low.z && p.z <= (double)high.z;
}

/* How often a component goes around p, 0 outside and +-1 inside, as the sum of its triangles' signed solid angles (van Oosterom and Strackee 1983)
 * over 4 pi. On the surface itself it lies between. */
static double winding(const solids *s, const component *c, sl_vec3d p) {
    const sl_scene *scene = s->topology->scene;
    double sum = 0.0;
    for (uint32_t i = 0; i < c->count; i++) {
        uint32_t t = s->triangle[c->first + i];
        sl_vec3d a = sl_subd(corner(scene, 0, t), p), b = sl_subd(corner(scene, 1, t), p), d = sl_subd(corner(scene, 2, t), p);
        double la = sl_lengthd(a), lb = sl_lengthd(b), ld = sl_lengthd(d);
        double y = sl_dotd(a, sl_crossd(b, d)), x = la * lb * ld + sl_dotd(a, b) * ld + sl_dotd(b, d) * la + sl_dotd(d, a) * lb;
        bool upon = x < 0.0 && fabs(y) <= 1e-6 * la * lb * ld; /* on the triangle itself: neither side of it */
        if (!upon) sum += 2.0 * sl_atan2(y, x);
    }
    return sum / (4.0 * SL_PI);
}

/* Strictly inside: a lamp that lies on the surface is not. Where looking would take too long a component counts as lit, and is no solid. */
static bool holds_point(solids *s, const component *c, sl_vec3d p) {
    if (!in_box(c->low, c->high, p)) return false;
    s->budget -= (double)c->count;
    return s->budget < 0.0 || fabs(winding(s, c, p)) > 0.75;
}

/* Of another surface's lamp: corners, middles of edges, middle. */
static bool holds_emitter(solids *s, const component *c, uint32_t t) {
    const sl_scene *scene = s->topology->scene;
    static const double weights[7][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0.5, 0.5}, {0.5, 0, 0.5}, {0.5, 0.5, 0}, {1.0 / 3, 1.0 / 3, 1.0 / 3}};
    for (int i = 0; i < 7; i++) {
        sl_vec3d p = sl_scaled(corner(scene, 0, t), weights[i][0]);
        p = sl_addd(p, sl_scaled(corner(scene, 1, t), weights[i][1]));
        if (holds_point(s, c, sl_addd(p, sl_scaled(corner(scene, 2, t), weights[i][2])))) return true;
    }
    return false;
}

static bool holds_light(solids *s, const component *c) {
    const sl_scene *scene = s->topology->scene;
    if (c->volume > 0.0 ? c->shines_back : c->shines) return true; /* its own lamps shine inwards */
    for (size_t i = 0; i < scene->light_count; i++)
        if (scene->lights[i].type != SL_LIGHT_DIRECTIONAL && holds_point(s, c, sl_to_double(scene->lights[i].position))) return true;
    for (size_t i = 0; i < scene->emitter_count; i++) {
        uint32_t t = scene->emitters[i].triangle;
        if (s->index[t] != (uint32_t)(c - s->component) && holds_emitter(s, c, t)) return true;
    }
    return false;
}

/* ---- all of it --------------------------------------------------------------------------------------------------- */

static sl_status keep_solids(solids *s, sl_error *error) {
    sl_topology *topology = s->topology;
    for (size_t i = 0; i < s->count; i++) topology->body_count += !s->component[i].open;
    topology->body_low = sl_allocate(topology->body_count, sizeof(sl_vec3));
    topology->body_high = sl_allocate(topology->body_count, sizeof(sl_vec3));
    if (topology->body_low == NULL || topology->body_high == NULL) return sl_fail_memory(error, "solids");
    uint32_t body = 0;
    for (size_t i = 0; i < s->count; i++) {
        const component *c = &s->component[i];
        for (uint32_t k = 0; k < c->count; k++) {
            uint32_t t = s->triangle[c->first + k];
            topology->body[t] = c->open ? SL_NO_INDEX : body;
            topology->solid[t] = c->open ? 0 : c->volume > 0.0 ? 2 : 1;
        }
        if (c->open) continue;
        topology->body_low[body] = c->low;
        topology->body_high[body] = c->high;
        body++;
    }
    return SL_OK;
}

static sl_status find_solids(solids *s, const uint32_t *first_there, uint8_t *loose, sl_error *error) {
    size_t triangles = s->topology->scene->triangle_count;
    for (uint32_t t = 0; t < triangles; t++) s->parent[t] = t;
    sl_status status = join(s, first_there, loose, error);
    if (status == SL_OK) status = list_components(s, error);
    if (status != SL_OK) return status;
    for (size_t t = 0; t < triangles; t++) s->component[s->index[t]].open |= loose[t];
    for (size_t i = 0; i < s->count; i++) {
        component *c = &s->component[i];
        if (!c->open) measure(s, c);
        if (!c->open) c->open = holds_light(s, c);
    }
    return keep_solids(s, error);
}

sl_status sl_solids_find(sl_topology *topology, const uint32_t *first_there, sl_error *error) {
    size_t triangles = topology->scene->triangle_count;
    solids s = {.topology = topology, .budget = 2e7};
    s.parent = sl_allocate(triangles, sizeof *s.parent);
    s.index = sl_allocate(triangles, sizeof *s.index);
    s.triangle = sl_allocate(triangles, sizeof *s.triangle);
    uint8_t *loose = sl_allocate(triangles, 1);
    sl_status status = SL_OK;
    if (s.parent == NULL || s.index == NULL || s.triangle == NULL || loose == NULL) status = sl_fail_memory(error, "solids");
    if (status == SL_OK) status = find_solids(&s, first_there, loose, error);
    sl_free(s.parent);
    sl_free(s.index);
    sl_free(s.triangle);
    sl_free(s.component);
    sl_free(loose);
    return status;
}
