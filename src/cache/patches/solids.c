#include "cache/patches/solids.h"

#include <math.h>

#include "base/error.h"
#include "base/memory.h"
#include "scene/edges.h"
#include "trace/bsdf.h"

typedef enum solid_kind { NO_SOLID, OPEN_SOLID, CLOSED_SOLID, LIT_SOLID } solid_kind;

/* Triangles that are connected by common edges. */
typedef struct body {
    solid_kind kind;
    /* of one object, without holes: each edge is that of two triangles, one each way */
    bool sealed;
    uint32_t object;           /* of its first triangle */
    bool shines;               /* it has emitters itself */
    sl_box box;
    double area, volume;       /* signed volume over its box's centre: positive where fronts look outwards */
    sl_vec3d areas;            /* sum of the triangles' area vectors: 0 of what is closed */
} body;

struct sl_solids {
    const sl_scene *scene;
    uint32_t *body_of;         /* by triangle */
    body *bodies;
    size_t count;
    uint32_t *solid;           /* those that are one, in order */
    size_t solid_count;
};

/* ---- what hangs together --------------------------------------------------------------------- */

static uint32_t root_of(uint32_t *parent, uint32_t t) {
    while (parent[t] != t) {
        parent[t] = parent[parent[t]];
        t = parent[t];
    }
    return t;
}

/* Triangles that share an edge get the lowest of their numbers as parent. */
static void join_edges(const sl_half_edges *edges, uint32_t *parent) {
    for (uint32_t t = 0; t < edges->count / 3; t++) parent[t] = t;
    for (size_t i = 0, end; i < edges->count; i = end) {
        end = sl_half_edges_of_one(edges, i);
        for (size_t k = i + 1; k < end; k++) {
            const uint32_t a = root_of(parent, edges->index[k - 1] / 3),
                           b = root_of(parent, edges->index[k] / 3);
            parent[a < b ? b : a] = a < b ? a : b;
        }
    }
}

/* An edge that has one triangle, or three, or two that run the same way, may be the border of a hole. */
static void find_sealed(sl_solids *solids, const sl_half_edges *edges) {
    const sl_scene *s = solids->scene;
    for (size_t i = 0, end; i < edges->count; i = end) {
        end = sl_half_edges_of_one(edges, i);
        const bool whole =
            end == i + 2 && sl_half_edge_at(edges, i).upwards != sl_half_edge_at(edges, i + 1).upwards;
        for (size_t k = i; k < end; k++) {
            const uint32_t t = edges->index[k] / 3;
            body *b = &solids->bodies[solids->body_of[t]];
            if (!whole || sl_scene_has_alpha(s, t) || s->object_index[t] != b->object) b->sealed = false;
        }
    }
}

static bool find_bodies(sl_solids *solids) {
    const sl_scene *s = solids->scene;
    uint32_t *parent = sl_allocate(s->triangle_count, sizeof *parent);
    sl_half_edges edges;
    bool done = sl_half_edges_list(s, &edges) && parent;
    if (done) {
        join_edges(&edges, parent);
        for (uint32_t t = 0; t < s->triangle_count; t++) {
            uint32_t root = root_of(parent, t); /* root <= t */
            solids->body_of[t] = root == t ? (uint32_t)solids->count++ : solids->body_of[root];
        }
        solids->bodies = sl_allocate(solids->count, sizeof *solids->bodies);
        done = solids->bodies;
    }
    if (done) {
        for (uint32_t t = (uint32_t)s->triangle_count; t-- > 0;)
            solids->bodies[solids->body_of[t]] = (body){.sealed = true, .object = s->object_index[t]};
        find_sealed(solids, &edges);
    }
    sl_half_edges_release(&edges);
    sl_free(parent);
    return done;
}

/* ---- which of it is solid -------------------------------------------------------------------- */

static void measure_boxes(sl_solids *solids) {
    const sl_scene *s = solids->scene;
    for (size_t b = 0; b < solids->count; b++) {
        body *old = &solids->bodies[b];
        *old = (body){.sealed = old->sealed, .object = old->object, .box = sl_box_empty()};
    }
    for (size_t t = 0; t < s->triangle_count; t++) {
        body *b = &solids->bodies[solids->body_of[t]];
        for (int c = 0; c < 3; c++) sl_box_add(&b->box, sl_scene_position(s, s->vertex[c][t]));
        if (s->emitter_of_triangle[t] != SL_NO_INDEX) b->shines = true;
    }
}

static void measure_volumes(sl_solids *solids) {
    const sl_scene *s = solids->scene;
    for (size_t t = 0; t < s->triangle_count; t++) {
        body *b = &solids->bodies[solids->body_of[t]];
        sl_vec3d low = sl_to_double(b->box.low), high = sl_to_double(b->box.high), corner[3];
        sl_vec3d centre = sl_scaled(sl_addd(low, high), 0.5);
        for (int c = 0; c < 3; c++)
            corner[c] = sl_subd(sl_to_double(sl_scene_position(s, s->vertex[c][t])), centre);
        sl_vec3d area =
            sl_scaled(sl_crossd(sl_subd(corner[1], corner[0]), sl_subd(corner[2], corner[0])), 0.5);
        b->areas = sl_addd(b->areas, area);
        b->area += sl_lengthd(area);
        b->volume += sl_dotd(area, corner[0]) / 3.0;
    }
}

static bool box_holds(const body *b, sl_vec3 p) {
    const sl_vec3 low = b->box.low, high = b->box.high;
    return p.x >= low.x && p.x <= high.x && p.y >= low.y && p.y <= high.y && p.z >= low.z && p.z <= high.z;
}

static bool light_inside(const sl_solids *solids, const body *b) {
    const sl_scene *s = solids->scene;
    for (size_t l = 0; l < s->light_count; l++) {
        if (s->lights[l].type != SL_LIGHT_DIRECTIONAL && box_holds(b, s->lights[l].position)) return true;
    }
    for (size_t e = 0; e < s->emitter_count; e++) {
        for (int c = 0; c < 3; c++) {
            if (box_holds(b, sl_scene_position(s, s->vertex[c][s->emitters[e].triangle]))) return true;
        }
    }
    return false;
}

void sl_solids_edit(sl_solids *solids) {
    measure_boxes(solids);
    measure_volumes(solids);
    solids->solid_count = 0;
    for (size_t i = 0; i < solids->count; i++) {
        body *b = &solids->bodies[i];
        sl_vec3 size = sl_sub(b->box.high, b->box.low);
        double box = (double)size.x * (double)size.y * (double)size.z;
        if (b->shines || !(b->volume > 0.01 * box)) continue;
        if (light_inside(solids, b)) b->kind = b->sealed ? LIT_SOLID : NO_SOLID;
        else b->kind = sl_lengthd(b->areas) <= 1e-4 * b->area ? CLOSED_SOLID : OPEN_SOLID;
        if (b->kind == NO_SOLID) continue;
        solids->solid[solids->solid_count++] = (uint32_t)i;
    }
}

sl_status sl_solids_find(const sl_scene *scene, sl_solids **out, sl_error *error) {
    *out = NULL;
    sl_solids *solids = sl_allocate(1, sizeof *solids);
    if (!solids) return sl_fail_memory(error, "the scene's solids");
    solids->scene = scene;
    solids->body_of = sl_allocate(scene->triangle_count, sizeof *solids->body_of);
    bool found = solids->body_of && find_bodies(solids);
    if (found)
        solids->solid = sl_allocate(solids->count, sizeof *solids->solid);
    if (!found || !solids->solid) {
        sl_solids_destroy(solids);
        return sl_fail_memory(error, "the scene's solids");
    }
    sl_solids_edit(solids);
    *out = solids;
    return SL_OK;
}

void sl_solids_destroy(sl_solids *solids) {
    if (!solids) return;
    SL_FREE_ALL(solids->body_of, solids->bodies, solids->solid, solids);
}

/* ---- probe rays ------------------------------------------------------------------------------ */

enum { PROBES = 8 };

/* Around the normal: none along what people build, none so flat that it meets what the point itself lies on.
 */
static void probe_rays(sl_vec3 p, sl_vec3 normal, sl_ray16 *rays) {
    static const float height[PROBES] = {0.93f, 0.33f, 0.71f, 0.47f, 0.84f, 0.39f, 0.62f, 0.54f};
    static const float turn[PROBES] = {0.03f, 0.17f, 0.30f, 0.42f, 0.53f, 0.67f, 0.79f, 0.92f};
    for (int i = 0; i < PROBES; i++) {
        sl_vec3 d = sl_direction_around(normal, height[i], turn[i]);
        sl_ray16_set(rays, (unsigned)i, p, d, 0.0f, INFINITY, SL_NO_INDEX);
    }
}

/* To an eye within it a lit one is a room. Light that is kept for all eyes comes into what is open. */
static bool is_solid_to(const body *b, const sl_vec3 *eye) {
    if (!eye) return b->kind == CLOSED_SOLID;
    return b->kind != LIT_SOLID || !box_holds(b, *eye);
}

bool sl_solids_eye_matters(const sl_solids *solids, sl_vec3 before, sl_vec3 now) {
    bool other = false;
    for (size_t i = 0; i < solids->solid_count && !other; i++) {
        const body *b = &solids->bodies[solids->solid[i]];
        other = is_solid_to(b, &before) != is_solid_to(b, &now);
    }
    return other;
}

bool sl_solids_hide_back(const sl_solids *solids, uint32_t triangle) {
    const body *b = &solids->bodies[solids->body_of[triangle]];
    return b->kind == CLOSED_SOLID && b->sealed;
}

bool sl_solids_hold(const sl_solids *solids, const sl_tracer *tracer, const sl_lit_point *at,
                    const sl_vec3 *eye, sl_counters *counters) {
    const sl_scene *s = solids->scene;
    sl_vec3 p = sl_mad(at->position, 1e-5f * s->scale, at->geometric_normal);
    uint32_t own = at->triangle != SL_NO_INDEX ? solids->body_of[at->triangle] : SL_NO_INDEX;
    bool near = false;
    for (size_t i = 0; i < solids->solid_count && !near; i++) {
        const body *b = &solids->bodies[solids->solid[i]];
        near = solids->solid[i] != own && box_holds(b, p) && is_solid_to(b, eye);
    }
    if (!near) return false;
    sl_ray16 rays;
    sl_hit16 hits;
    probe_rays(p, at->geometric_normal, &rays);
    sl_trace(tracer, &rays, PROBES, false, &hits, counters);
    int closed = 0, open = 0;
    for (int i = 0; i < PROBES; i++) {
        if (hits.triangle[i] == SL_NO_INDEX) continue;
        uint32_t t = hits.triangle[i];
        sl_vec3 d = sl_v3(rays.direction_x[i], rays.direction_y[i], rays.direction_z[i]);
        const body *b = &solids->bodies[solids->body_of[t]];
        if (!(sl_dot(d, sl_scene_geometric_normal(s, t)) > 0.0f) || !box_holds(b, p) || !is_solid_to(b, eye))
            continue;
        closed += b->kind == CLOSED_SOLID || b->kind == LIT_SOLID;
        open += b->kind == OPEN_SOLID;
    }
    return 2 * closed > PROBES || closed + open == PROBES;
}
