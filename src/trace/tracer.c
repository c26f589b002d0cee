/* The hierarchy and its queries. One Embree user primitive a triangle; its box is inflated, since Embree's
 * walk rounds; and while a ray is under way its far end is kept a little beyond the best hit, so that near
 * ties are still visited. The answer is then a function of the ray and the set of triangles alone: the least
 * (distance, index) among all hits. */
#include "trace/trace.h"

#include <stdatomic.h>
#include <stdio.h>

#include "base/counters.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "trace/ray_setup.h"
#include "trace/triangle_order.h"

/* Boxes grow by four times what rounding decides a hit within (ray_setup.h). */
#define INFLATION 2e-6
#define FARTHEST 1.8e18f /* that Embree takes */

enum { FEW_RAYS = 2 }; /* not worth a packet */

/* A cache line, so that meeting a triangle costs one miss at most. */
typedef struct placed_triangle {
    _Alignas(64) sl_triangle_corners corners;
    uint32_t index; /* in the scene */
} placed_triangle;

struct sl_tracer {
    const sl_scene *scene;
    RTCDevice device;
    RTCScene hierarchy;
    placed_triangle *triangles; /* a user primitive each */
    bool any_alpha;
    float unit;      /* Embree's unit of length over ours, a power of two; 1 but for astronomical scenes */
    float inflation;
    sl_vec3d centre;
    double diagonal;
    sl_triangle_test *test;
    sl_ray_frames *frames;
    sl_ray_setup setup;
    sl_rays_usual *find_usual;
    sl_rays_ready *make_ready;
    atomic_llong embree_bytes;
};

/* State of a query for its callbacks. */
typedef struct query_state {
    const sl_tracer *tracer;
    sl_ray_state rays;
    float scale[SL_PACKET]; /* of the direction, see direction_scale() */
    uint32_t occluded; /* occlusion queries: bit per ray */
} query_state;

/* ---- building -------------------------------------------------------------------------------- */

static float least(const float v[3]) { return fminf(v[0], fminf(v[1], v[2])); }
static float greatest(const float v[3]) { return fmaxf(v[0], fmaxf(v[1], v[2])); }

static void triangle_bounds(const struct RTCBoundsFunctionArguments *arguments) {
    const sl_tracer *tracer = arguments->geometryUserPtr;
    const sl_triangle_corners *c = &tracer->triangles[arguments->primID].corners;
    float grow = tracer->inflation, unit = tracer->unit;
    struct RTCBounds *box = arguments->bounds_o;
    box->lower_x = (least(c->p[0]) - grow) * unit;
    box->lower_y = (least(c->p[1]) - grow) * unit;
    box->lower_z = (least(c->p[2]) - grow) * unit;
    box->upper_x = (greatest(c->p[0]) + grow) * unit;
    box->upper_y = (greatest(c->p[1]) + grow) * unit;
    box->upper_z = (greatest(c->p[2]) + grow) * unit;
}

static void intersect_callback(const struct RTCIntersectFunctionNArguments *arguments);
static void occluded_callback(const struct RTCOccludedFunctionNArguments *arguments);

/* Origins beyond this are far from the scene. */
static double far_squared(const sl_tracer *tracer) { return 4.0 * tracer->diagonal * tracer->diagonal; }

static bool count_memory(void *tracer, ssize_t bytes, bool post) {
    (void)post;
    atomic_fetch_add(&((sl_tracer *)tracer)->embree_bytes, (long long)bytes);
    return true;
}

static sl_status fail_embree(const sl_tracer *tracer, const char *what, sl_error *error) {
    enum RTCError code = rtcGetDeviceError(tracer->device);
    return sl_fail(error, SL_ERROR_RESOURCES, "Embree could not %s (error %d)", what, (int)code);
}

static void copy_triangles(sl_tracer *tracer, const uint32_t *order) {
    const sl_scene *s = tracer->scene;
    float greatest_coordinate = 0.0f;
    for (size_t i = 0; i < s->triangle_count; i++) {
        uint32_t t = order[i];
        sl_triangle_corners *c = &tracer->triangles[i].corners;
        tracer->triangles[i].index = t;
        for (int k = 0; k < 3; k++) {
            sl_vec3 p = sl_scene_position(s, s->vertex[k][t]);
            c->p[0][k] = p.x;
            c->p[1][k] = p.y;
            c->p[2][k] = p.z;
            greatest_coordinate =
                fmaxf(greatest_coordinate, fmaxf(fabsf(p.x), fmaxf(fabsf(p.y), fabsf(p.z))));
        }
        tracer->any_alpha |= sl_scene_has_alpha(s, t);
    }
    /* Embree drops boxes that reach beyond 1.8e18. */
    int exponent;
    frexpf(greatest_coordinate, &exponent);
    tracer->unit = exponent > 40 ? ldexpf(1.0f, -exponent) : 1.0f;
    sl_vec3d low = sl_to_double(s->box_min), high = sl_to_double(s->box_max);
    tracer->centre = sl_scaled(sl_addd(low, high), 0.5);
    tracer->diagonal = sl_lengthd(sl_subd(high, low));
    /* The second term: far from the origin a box must grow by some units in the last place to grow at all. */
    tracer->inflation = (float)(INFLATION * tracer->diagonal + 0x1p-22 * (double)greatest_coordinate);
}

static sl_status place_triangles(sl_tracer *tracer, sl_error *error) {
    size_t count = tracer->scene->triangle_count;
    uint32_t *order = sl_allocate(count, sizeof *order);
    tracer->triangles = sl_allocate(count, sizeof *tracer->triangles);
    sl_status status = order && tracer->triangles ? sl_triangle_order(tracer->scene, order, error)
                                                  : sl_fail_memory(error, "the tracer's triangles");
    if (status == SL_OK) copy_triangles(tracer, order);
    sl_free(order);
    return status;
}

static sl_status build_hierarchy(sl_tracer *tracer, sl_error *error) {
    RTCGeometry geometry = rtcNewGeometry(tracer->device, RTC_GEOMETRY_TYPE_USER);
    if (!geometry) return fail_embree(tracer, "make a geometry", error);
    rtcSetGeometryUserPrimitiveCount(geometry, (unsigned)tracer->scene->triangle_count);
    rtcSetGeometryUserData(geometry, tracer);
    rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_HIGH);
    rtcSetGeometryBoundsFunction(geometry, triangle_bounds, NULL);
    rtcSetGeometryIntersectFunction(geometry, intersect_callback);
    rtcSetGeometryOccludedFunction(geometry, occluded_callback);
    rtcCommitGeometry(geometry);
    tracer->hierarchy = rtcNewScene(tracer->device);
    if (!tracer->hierarchy) {
        rtcReleaseGeometry(geometry);
        return fail_embree(tracer, "make a scene", error);
    }
    rtcSetSceneFlags(tracer->hierarchy, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(tracer->hierarchy, RTC_BUILD_QUALITY_HIGH);
    rtcAttachGeometry(tracer->hierarchy, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(tracer->hierarchy);
    if (rtcGetDeviceError(tracer->device) != RTC_ERROR_NONE) {
        return sl_fail(error, SL_ERROR_RESOURCES, "Embree could not build the hierarchy of %zu triangles",
                       tracer->scene->triangle_count);
    }
    return SL_OK;
}

sl_status sl_tracer_create(const sl_scene *scene, unsigned threads, const char *embree_config,
                           sl_tracer **out, sl_error *error) {
    *out = NULL;
    if (scene->triangle_count >= SL_NO_INDEX) {
        return sl_fail(error, SL_ERROR_RESOURCES, "a scene may have at most %u triangles, this has %zu",
                       SL_NO_INDEX - 1, scene->triangle_count);
    }
    sl_tracer *tracer = sl_allocate(1, sizeof *tracer);
    if (!tracer) return sl_fail_memory(error, "the tracer");
    tracer->scene = scene;
    tracer->test = SL_KERNEL_OF(sl_isa_best(), sl_triangle_test);
    tracer->frames = SL_KERNEL_OF(sl_isa_best(), sl_ray_frames);
    tracer->find_usual = SL_KERNEL_OF(sl_isa_best(), sl_rays_usual);
    tracer->make_ready = SL_KERNEL_OF(sl_isa_best(), sl_rays_ready);
    sl_status status = place_triangles(tracer, error);
    if (status != SL_OK) {
        sl_tracer_destroy(tracer);
        return status;
    }
    tracer->setup = (sl_ray_setup){tracer->centre, far_squared(tracer), (double)tracer->unit};

    /* Embree ends the process where it cannot start one. */
    unsigned builders = sl_threads_to_be_had(sl_thread_count(threads));
    if (builders == 0) {
        sl_tracer_destroy(tracer);
        return sl_fail(error, SL_ERROR_RESOURCES, "no thread could be had for the rays' hierarchy");
    }
    char config[256];
    /* Embree's default, a leaf for each triangle, makes it test boxes longer than we would test triangles. */
    snprintf(config, sizeof config, "threads=%u,object_accel_max_leaf_size=4%s%s", builders,
             embree_config ? "," : "", embree_config ? embree_config : "");
    tracer->device = rtcNewDevice(config);
    if (!tracer->device) {
        status = sl_fail(error, SL_ERROR_RESOURCES, "Embree could not make a device with \"%s\" (error %d)",
                         config, (int)rtcGetDeviceError(NULL));
    } else {
        rtcSetDeviceMemoryMonitorFunction(tracer->device, count_memory, tracer);
        status = build_hierarchy(tracer, error);
    }
    if (status != SL_OK) {
        sl_tracer_destroy(tracer);
        return status;
    }
    *out = tracer;
    return SL_OK;
}

void sl_tracer_destroy(sl_tracer *tracer) {
    if (!tracer) return;
    if (tracer->hierarchy) rtcReleaseScene(tracer->hierarchy);
    if (tracer->device) rtcReleaseDevice(tracer->device);
    sl_free(tracer->triangles);
    sl_free(tracer);
}

size_t sl_tracer_memory_bytes(const sl_tracer *tracer) {
    long long embree = atomic_load(&((sl_tracer *)tracer)->embree_bytes);
    return sizeof *tracer + tracer->scene->triangle_count * sizeof *tracer->triangles +
           (size_t)(embree > 0 ? embree : 0);
}

/* Measured: 145 to 164 bytes a triangle at 10^5 to 10^6 of them while Embree builds (of which 64 are ours),
 * and a few megabytes of pools. */
double sl_tracer_memory_need(size_t triangles) { return 6e6 + 168.0 * (double)triangles; }

/* ---- callbacks: a triangle is proposed for some of the rays ---------------------------------- */

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

static void intersect_callback(const struct RTCIntersectFunctionNArguments *arguments) {
    query_state *state = sl_embree_state(arguments->context);
    unsigned n = arguments->N;
    const unsigned *id = sl_embree_id(arguments->rayhit, n);
    float *tfar = sl_embree_tfar(arguments->rayhit, n);
    const placed_triangle *placed = &state->tracer->triangles[arguments->primID];
    __builtin_prefetch(placed + 1); /* mostly the leaf's next triangle */
    uint32_t triangle = placed->index;
    sl_candidates c;
    uint32_t hits = state->tracer->test(&state->rays, &placed->corners, arguments->valid, id, n, &c);
    for (; hits; hits &= hits - 1) {
        unsigned i = (unsigned)__builtin_ctz(hits), k = id[i];
        sl_ray_state *r = &state->rays;
        if (!is_better(r, k, c.t[i], triangle) || !is_opaque(state->tracer, triangle, c.w1[i], c.w2[i]))
            continue;
        r->best_t[k] = c.t[i];
        r->best_w1[k] = c.w1[i];
        r->best_w2[k] = c.w2[i];
        r->best_triangle[k] = triangle;
        tfar[i] = embree_far(state, k, c.t[i]);
    }
}

static void occluded_callback(const struct RTCOccludedFunctionNArguments *arguments) {
    query_state *state = sl_embree_state(arguments->context);
    unsigned n = arguments->N;
    const unsigned *id = sl_embree_id(arguments->ray, n);
    float *tfar = sl_embree_tfar(arguments->ray, n);
    const placed_triangle *placed = &state->tracer->triangles[arguments->primID];
    __builtin_prefetch(placed + 1); /* mostly the leaf's next triangle */
    uint32_t triangle = placed->index;
    sl_candidates c;
    uint32_t hits = state->tracer->test(&state->rays, &placed->corners, arguments->valid, id, n, &c);
    for (; hits; hits &= hits - 1) {
        unsigned i = (unsigned)__builtin_ctz(hits), k = id[i];
        if (!is_better(&state->rays, k, c.t[i], triangle)) continue;
        if (!is_opaque(state->tracer, triangle, c.w1[i], c.w2[i])) continue;
        state->occluded |= 1u << k;
        tfar[i] = -INFINITY;
    }
}

/* ---- queries --------------------------------------------------------------------------------- */

/* A ray that starts far from the scene is started nearer, at about a diagonal from the centre, so that the
 * test's rounding and Embree's stay within the boxes' inflation. Returns the new origin; *start is its
 * distance. */
static sl_vec3 start_near(const sl_tracer *tracer, sl_vec3 origin, sl_vec3d direction, double *start) {
    sl_vec3d to_centre = sl_subd(tracer->centre, sl_to_double(origin));
    double distance_squared = sl_dotd(to_centre, to_centre), diagonal = tracer->diagonal;
    *start = 0.0;
    if (distance_squared <= far_squared(tracer)) return origin;
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
    unsigned valids = tracer->find_usual(&tracer->setup, rays, count, valid);
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
    tracer->make_ready(&tracer->setup, rays, &state->rays, out);
    tracer->frames(&state->rays, rays);
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
        if (coherent && valids > FEW_RAYS) sl_embree_intersect16(tracer->hierarchy, &query, valid, &packet);
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
    if (coherent && valids > FEW_RAYS) sl_embree_occluded16(tracer->hierarchy, &query, valid, &packet);
    else occluded_singly(tracer, &query, valid, &packet);
    return state.occluded;
}
