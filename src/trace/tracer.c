/* Queries. While a ray is under way its far end is kept a little beyond the best hit, so that near ties are
 * still visited. The answer is then a function of the ray and the set of triangles alone: the least
 * (distance, index) among all hits. */
#include "base/counters.h"
#include "trace/hierarchy.h"

#define FARTHEST 1.8e18f /* that Embree takes */

enum { FEW_RAYS = 2 }; /* not worth a packet */

/* State of a query for its callbacks. */
typedef struct query_state {
    const sl_tracer *tracer;
    sl_ray_state rays;
    float scale[SL_PACKET]; /* of the direction, see direction_scale() */
    uint32_t occluded; /* occlusion queries: bit per ray */
} query_state;

/* ---- callbacks: a triangle is proposed for some of the rays ---------------------------------- */

/* Finds the corners and the number of the triangle that is proposed; of a copy those that the scene has. */
static inline const sl_triangle_corners *find_triangle(const sl_traced_part *part, const void *context,
                                                       unsigned primitive, sl_triangle_corners *own,
                                                       uint32_t *triangle) {
    if (!part->placed) {
        *triangle = part->tracer->copies.copy[sl_embree_instance(context)].first + part->order[primitive];
        sl_scene_corners(part->tracer->scene, *triangle, own);
        return own;
    }
    const sl_placed_triangle *placed = &part->placed[primitive];
    __builtin_prefetch(placed + 1); /* mostly the leaf's next triangle */
    *triangle = placed->index;
    return &placed->corners;
}

/* Tells whether the candidate beats what ray k has: nearer, or as near with a lower index. */
static bool is_better(const sl_ray_state *r, unsigned k, float t, uint32_t triangle) {
    if (!(t > r->near[k]) || r->skip[k] == triangle) return false;
    if (t < r->best_t[k]) return true;
    return t == r->best_t[k] && r->best_triangle[k] != SL_NO_INDEX && triangle < r->best_triangle[k];
}

static bool is_opaque(const sl_tracer *tracer, uint32_t triangle, float w1, float w2) {
    return !tracer->any_alpha || !sl_scene_has_alpha(tracer->scene, triangle) ||
           sl_scene_is_opaque(tracer->scene, triangle, w1, w2);
}

/* The far end that Embree is told for a ray whose best hit (or given end) is at t. */
static float embree_far(const query_state *state, unsigned k, float t) {
    double from_start = (double)t - state->rays.start[k];
    double end = from_start + SL_FAR_SLACK * fabs(from_start) + 0x1p-22 * fabs((double)t);
    return (float)(end * (double)state->tracer->unit);
}

/* Takes a triangle that is proposed to n rays of either kind of query where it is better than what they have:
 * any ends a search for occluders. */
static inline void propose(bool occluders, const void *part, const void *context, unsigned primitive,
                           const int *valid, void *rays, unsigned n) {
    query_state *state = sl_embree_state(context);
    const unsigned *id = sl_embree_id(rays, n);
    float *tfar = sl_embree_tfar(rays, n);
    sl_triangle_corners own;
    uint32_t triangle;
    const sl_triangle_corners *corners = find_triangle(part, context, primitive, &own, &triangle);
    sl_ray_state *r = &state->rays;
    sl_candidates c;
    uint32_t hits = SL_KERNEL_OF(state->tracer->isa, sl_triangle_test)(r, corners, valid, id, n, &c);
    for (; hits; hits &= hits - 1) {
        unsigned i = (unsigned)__builtin_ctz(hits), k = id[i];
        if (!is_better(r, k, c.t[i], triangle) || !is_opaque(state->tracer, triangle, c.w1[i], c.w2[i]))
            continue;
        if (occluders) {
            state->occluded |= 1u << k;
            tfar[i] = -INFINITY;
            continue;
        }
        r->best_t[k] = c.t[i];
        r->best_w1[k] = c.w1[i];
        r->best_w2[k] = c.w2[i];
        r->best_triangle[k] = triangle;
        tfar[i] = embree_far(state, k, c.t[i]);
    }
}

void sl_intersect_callback(const struct RTCIntersectFunctionNArguments *a) {
    propose(false, a->geometryUserPtr, a->context, a->primID, a->valid, a->rayhit, a->N);
}

void sl_occluded_callback(const struct RTCOccludedFunctionNArguments *a) {
    propose(true, a->geometryUserPtr, a->context, a->primID, a->valid, a->ray, a->N);
}

/* ---- queries --------------------------------------------------------------------------------- */

/* A ray that starts far from the scene is started nearer, at about a diagonal from the centre, so that the
 * test's rounding and Embree's stay within the boxes' inflation. Returns the new origin; *start is its
 * distance. */
static sl_vec3 start_near(const sl_tracer *tracer, sl_vec3 origin, sl_vec3d direction, double *start) {
    sl_vec3d to_centre = sl_subd(tracer->centre, sl_to_double(origin));
    double distance_squared = sl_dotd(to_centre, to_centre), diagonal = tracer->diagonal;
    *start = 0.0;
    if (distance_squared <= sl_tracer_far_squared(tracer)) return origin;
    double length_squared = sl_dotd(direction, direction);
    double forward = sl_dotd(to_centre, direction) / length_squared - diagonal / sqrt(length_squared);
    if (!(forward > 0.0) || !isfinite(forward)) return origin;
    *start = forward;
    return sl_to_float(sl_addd(sl_to_double(origin), sl_scaled(direction, forward)));
}

/* The power of two that brings a direction's largest component near 1, where it is far from that: Embree
 * treats tiny directions as zero. Distances are then in units of the scaled direction, exactly. */
static float direction_scale(float largest_component) {
    if (largest_component > SL_SHORTEST && largest_component < SL_LONGEST) return 1.0f;
    int exponent;
    frexpf(largest_component, &exponent);
    exponent = exponent > 120 ? 120 : exponent < -120 ? -120 : exponent;
    return ldexpf(1.0f, -exponent);
}

/* Makes ray i usual: false if it has no direction, is not finite or is empty. */
static bool make_usual(query_state *state, sl_ray16 *rays, unsigned i) {
    sl_vec3 origin = sl_v3(rays->origin_x[i], rays->origin_y[i], rays->origin_z[i]);
    sl_vec3 d = sl_v3(rays->direction_x[i], rays->direction_y[i], rays->direction_z[i]);
    float ax = fabsf(d.x), ay = fabsf(d.y), az = fabsf(d.z), size = ax > ay ? ax : ay;
    size = size > az ? size : az;
    if (!sl_is_finite(origin) || !sl_is_finite(d) || !(size > 0.0f)) return false;
    if (!(rays->far[i] > rays->near[i]) || !(rays->far[i] > 0.0f)) return false;
    float scale = state->scale[i] = direction_scale(size);
    if (scale != 1.0f) d = sl_scale(d, scale);
    sl_vec3 o = start_near(state->tracer, origin, sl_to_double(d), &state->rays.start[i]);
    sl_ray16_set(rays, i, o, d, rays->near[i] / scale, rays->far[i] / scale, rays->skip[i]);
    /* It would end the process. A ray that is no nearer, although it was started near the scene, leaves it
     * behind or passes it by. */
    return sl_greatest_coordinate(sl_scale(o, state->tracer->unit)) < FARTHEST;
}

/* All rays of a query. A lane without a ray holds a harmless one. Returns how many are valid. */
static unsigned prepare(query_state *state, const sl_tracer *tracer, const sl_ray16 *rays, unsigned count,
                        struct RTCRay16 *out, int valid[SL_PACKET]) {
    sl_ray16 own;
    unsigned valids = SL_KERNEL_OF(tracer->isa, sl_rays_usual)(&tracer->setup, rays, count, valid);
    state->tracer = tracer;
    state->occluded = 0;
    for (unsigned i = 0; i < SL_PACKET; i++) {
        state->scale[i] = 1.0f;
        state->rays.start[i] = 0.0;
    }
    if (valids < SL_PACKET) {
        own = *rays;
        rays = &own;
    }
    for (unsigned i = 0; i < SL_PACKET && valids < SL_PACKET; i++) {
        if (valid[i]) continue;
        if (i < count && make_usual(state, &own, i)) {
            valid[i] = -1;
            valids++;
        } else {
            sl_ray16_set(&own, i, sl_v3(0.0f, 0.0f, 0.0f), sl_v3(0.0f, 0.0f, 1.0f), 0.0f, 0.0f, SL_NO_INDEX);
        }
    }
    SL_KERNEL_OF(tracer->isa, sl_rays_ready)(&tracer->setup, rays, &state->rays, out);
    SL_KERNEL_OF(tracer->isa, sl_ray_frames)(&state->rays, rays);
    return valids;
}

static struct RTCRay one_of(const struct RTCRay16 *rays, unsigned i) {
    return (struct RTCRay){.org_x = rays->org_x[i],
                           .org_y = rays->org_y[i],
                           .org_z = rays->org_z[i],
                           .tnear = rays->tnear[i],
                           .dir_x = rays->dir_x[i],
                           .dir_y = rays->dir_y[i],
                           .dir_z = rays->dir_z[i],
                           .time = 0.0f,
                           .tfar = rays->tfar[i],
                           .mask = UINT32_MAX,
                           .id = i,
                           .flags = 0};
}

/* Rays that go different ways are walked one by one, which is faster than as a packet; the hits are the same.
 */
static void intersect_singly(const sl_tracer *tracer, sl_embree_query *query, const int valid[SL_PACKET],
                             const struct RTCRay16 *rays) {
    for (unsigned i = 0; i < SL_PACKET; i++) {
        if (!valid[i]) continue;
        struct RTCRayHit ray = {.ray = one_of(rays, i)};
        ray.hit.geomID = ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        sl_embree_intersect1(tracer->hierarchy, query, &ray);
    }
}

static void occluded_singly(const sl_tracer *tracer, sl_embree_query *query, const int valid[SL_PACKET],
                            const struct RTCRay16 *rays) {
    for (unsigned i = 0; i < SL_PACKET; i++) {
        if (!valid[i]) continue;
        struct RTCRay ray = one_of(rays, i);
        sl_embree_occluded1(tracer->hierarchy, query, &ray);
    }
}

/* Embree 3.13's walk of coherent packets may go round for ever among instances, in occlusion queries. */
static bool goes_as_packet(const sl_tracer *tracer, bool coherent, unsigned valids) {
    return coherent && valids > FEW_RAYS && tracer->copies.copy_count == 0;
}

void sl_trace(const sl_tracer *tracer, const sl_ray16 *rays, unsigned count, bool coherent, sl_hit16 *hits,
              sl_counters *counters) {
    query_state state;
    struct RTCRayHit16 packet;
    _Alignas(64) int valid[SL_PACKET];
    sl_count(counters, SL_COUNT_RAYS, count);
    unsigned valids = prepare(&state, tracer, rays, count, &packet.ray, valid);
    if (valids > 0) {
        for (unsigned i = 0; i < SL_PACKET; i++)
            packet.hit.geomID[i] = packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
        sl_embree_query query;
        sl_embree_begin(&query, &state);
        if (goes_as_packet(tracer, coherent, valids))
            sl_embree_intersect16(tracer->hierarchy, &query, valid, &packet);
        else intersect_singly(tracer, &query, valid, &packet.ray);
    }
    for (unsigned i = 0; i < count; i++) {
        bool hit = valid[i] && state.rays.best_triangle[i] != SL_NO_INDEX;
        hits->triangle[i] = hit ? state.rays.best_triangle[i] : SL_NO_INDEX;
        hits->t[i] = hit ? state.rays.best_t[i] * state.scale[i] : INFINITY;
        hits->w1[i] = hit ? state.rays.best_w1[i] : 0.0f;
        hits->w2[i] = hit ? state.rays.best_w2[i] : 0.0f;
    }
}

uint32_t sl_trace_occluded(const sl_tracer *tracer, const sl_ray16 *rays, unsigned count, bool coherent,
                           sl_counters *counters) {
    query_state state;
    struct RTCRay16 packet;
    _Alignas(64) int valid[SL_PACKET];
    sl_count(counters, SL_COUNT_SHADOW_RAYS, count);
    unsigned valids = prepare(&state, tracer, rays, count, &packet, valid);
    if (valids == 0) return 0;
    sl_embree_query query;
    sl_embree_begin(&query, &state);
    if (goes_as_packet(tracer, coherent, valids))
        sl_embree_occluded16(tracer->hierarchy, &query, valid, &packet);
    else occluded_singly(tracer, &query, valid, &packet);
    return state.occluded;
}
