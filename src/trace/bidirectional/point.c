/* Irradiance and radiance at surface points. The point is v_1 of every eye subpath, so the ways with t >= 2
 * remain. Sample i draws from point i of one sequence wherever the point lies, so its light subpath is the
 * same for all points, and is walked once. */
#include <math.h>

#include "base/counters.h"
#include "base/error.h"
#include "base/grow.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/random.h"
#include "trace/bidirectional/bidirectional.h"
#include "trace/bidirectional/subpath.h"

/* Of the mean of the samples so far: connections that carry less are not all worth a shadow ray. What is
 * decided for later samples depends on earlier ones alone, so nothing is biased. */
static const double worth_a_ray = 0.15;

enum { ROULETTE_AFTER = 3 }; /* surfaces of either walk */

struct sl_bidirectional_points {
    sl_bidirectional_point_settings settings; /* complete */
    sl_light_sampler *lights;
    sl_sequence sequence;
    sl_path_maker diffuse, glossy, mirror; /* what is asked of the point */
    uint64_t key;
    size_t *first;           /* of subpath i's vertices; the last entry is their number */
    sl_path_vertex *vertex;
    size_t capacity;
};

struct sl_bidirectional_scratch {
    sl_subpath path[SL_PACKET];
};

/* ---- light subpaths -------------------------------------------------------------------------- */

static sl_status keep_subpath(sl_bidirectional_points *p, size_t i, const sl_subpath *path, sl_error *error) {
    size_t used = p->first[i];
    p->first[i + 1] = used + path->count;
    for (unsigned k = 0; k < path->count; k++) {
        if (!sl_make_room(&p->vertex, used + k, &p->capacity, sizeof *p->vertex))
            return sl_fail_memory(error, "light subpaths");
        p->vertex[used + k] = path->vertex[k];
    }
    return SL_OK;
}

static unsigned packet_of(const sl_bidirectional_points *p, uint32_t first, uint32_t samples,
                          uint64_t key[SL_PACKET], uint32_t index[SL_PACKET]) {
    unsigned count = samples - first < SL_PACKET ? samples - first : SL_PACKET;
    for (unsigned i = 0; i < count; i++) {
        key[i] = p->key;
        index[i] = p->settings.first + first + i;
    }
    return count;
}

static sl_status walk_light_subpaths(sl_bidirectional_points *p, sl_bidirectional_scratch *scratch,
                                     sl_error *error) {
    sl_path_maker maker = p->diffuse;
    /* The point itself is one surface of the path. */
    if (maker.transport.bounces != SL_BOUNCES_UNLIMITED) maker.transport.bounces--;
    sl_counters uncounted = {{0}};
    sl_status status = SL_OK;
    for (uint32_t first = 0; first < p->settings.samples && status == SL_OK; first += SL_PACKET) {
        uint64_t key[SL_PACKET];
        uint32_t index[SL_PACKET];
        sl_subpath *paths[SL_PACKET];
        unsigned count = packet_of(p, first, p->settings.samples, key, index);
        for (unsigned i = 0; i < count; i++) paths[i] = &scratch->path[i];
        sl_walk_from_lights(&maker, count, key, index, paths, &uncounted);
        for (unsigned i = 0; i < count && status == SL_OK; i++)
            status = keep_subpath(p, first + i, paths[i], error);
    }
    return status;
}

/* ---- making ---------------------------------------------------------------------------------- */

static sl_path_maker maker_for(const sl_bidirectional_points *p, const sl_scene *scene,
                               const sl_tracer *tracer, unsigned lobe) {
    sl_transport transport;
    sl_transport_named("full", &transport);
    transport.bounces = p->settings.bounces;
    if (lobe != SL_LOBE_MIRROR) {
        transport.emission = transport.eye_mirrors = false;
        transport.direct_lobes = 0;
        transport.receiver_lobes = lobe;
    }
    sl_path_maker maker;
    sl_path_maker_init(&maker, scene, tracer, p->lights, &p->sequence, &transport);
    maker.roulette_after = ROULETTE_AFTER;
    maker.eye_vertices = lobe == SL_LOBE_MIRROR ? 1 : 2;
    return maker;
}

static sl_status make_points(sl_bidirectional_points *p, const sl_scene *scene, const sl_tracer *tracer,
                             sl_error *error) {
    sl_status status = sl_light_sampler_create(scene, &p->lights, error);
    if (status != SL_OK) return status;
    p->first = sl_allocate((size_t)p->settings.samples + 1, sizeof *p->first);
    if (!p->first) return sl_fail_memory(error, "light subpaths");
    sl_sequence_make(&p->sequence);
    p->key = sl_random_key(p->settings.seed, 0x706f696e7473u);
    p->diffuse = maker_for(p, scene, tracer, SL_LOBE_DIFFUSE);
    p->glossy = maker_for(p, scene, tracer, SL_LOBE_GLOSSY);
    p->mirror = maker_for(p, scene, tracer, SL_LOBE_MIRROR);
    sl_bidirectional_scratch *scratch;
    status = sl_bidirectional_scratch_create(&scratch, error);
    if (status == SL_OK) status = walk_light_subpaths(p, scratch, error);
    sl_bidirectional_scratch_destroy(scratch);
    return status;
}

sl_status sl_bidirectional_points_create(const sl_scene *scene, const sl_tracer *tracer,
                                         const sl_bidirectional_point_settings *settings,
                                         sl_bidirectional_points **out, sl_error *error) {
    *out = NULL;
    sl_bidirectional_points *p = sl_allocate(1, sizeof *p);
    if (!p) return sl_fail_memory(error, "bidirectional path tracing");
    if (settings) p->settings = *settings;
    if (p->settings.samples == 0) p->settings.samples = 400;
    if (p->settings.bounces == 0) p->settings.bounces = 6;
    sl_status status = make_points(p, scene, tracer, error);
    if (status == SL_OK) *out = p;
    else sl_bidirectional_points_destroy(p);
    return status;
}

void sl_bidirectional_points_destroy(sl_bidirectional_points *p) {
    if (!p) return;
    sl_light_sampler_destroy(p->lights);
    SL_FREE_ALL(p->first, p->vertex, p);
}

sl_status sl_bidirectional_scratch_create(sl_bidirectional_scratch **scratch, sl_error *error) {
    *scratch = sl_allocate(1, sizeof **scratch);
    return *scratch ? SL_OK : sl_fail_memory(error, "subpaths");
}

void sl_bidirectional_scratch_destroy(sl_bidirectional_scratch *scratch) { sl_free(scratch); }

/* ---- values ---------------------------------------------------------------------------------- */

typedef struct packet {
    const sl_bidirectional_point_settings *settings;
    bool without_caustics;
    sl_subpath *eye[SL_PACKET];
    const sl_path_vertex *light_path[SL_PACKET]; /* the light vertices y_0 ... of each lane */
    sl_rgb light[SL_PACKET];
} packet;

static bool is_specular(const sl_path_vertex *v, float polished) {
    if (v->kind == SL_VERTEX_MIRROR) return true;
    return polished > 0.0f && v->bsdf.exponent >= polished && sl_rgb_is_black(v->bsdf.diffuse);
}

/* L S+ D: all surfaces between the light and the point are specular, in whichever way the path was made. A
 * path belongs to one side or the other as a whole, so that its weights still sum to 1. */
static bool is_caustic(const packet *p, unsigned lane, unsigned s, unsigned t) {
    unsigned end = s == 0 ? t - 1 : t; /* s = 0: v_(t-1) is on the light */
    for (unsigned i = 2; i < end; i++) {
        if (!is_specular(&p->eye[lane]->vertex[i], p->settings->polished)) return false;
    }
    for (unsigned i = 1; i < s; i++) {
        if (!is_specular(&p->light_path[lane][i], p->settings->polished)) return false;
    }
    return true;
}

static void receive(void *context, unsigned lane, unsigned s, unsigned t, double x, double y, sl_rgb radiance,
                    double weight) {
    packet *p = context;
    (void)x, (void)y;
    if (p->without_caustics && is_caustic(p, lane, s, t)) return;
    p->light[lane] = sl_rgb_add(p->light[lane], sl_rgb_scale(radiance, (float)weight));
}

typedef struct sums {
    double sum[3], squares[3];
} sums;

static void add_samples(sums *total, const packet *p, unsigned count, sl_counters *counters) {
    for (unsigned i = 0; i < count; i++) {
        if (!sl_rgb_is_finite(p->light[i])) {
            sl_count(counters, SL_COUNT_NONFINITE, 1);
            continue;
        }
        const double value[3] = {(double)p->light[i].r, (double)p->light[i].g, (double)p->light[i].b};
        for (int c = 0; c < 3; c++) {
            total->sum[c] += value[c];
            total->squares[c] += value[c] * value[c];
        }
    }
}

/* Paths by way of v_1, or, where the point is NULL, along a ray. */
static void estimate(const sl_bidirectional_points *points, const sl_path_maker *shared, uint32_t samples,
                     const sl_path_vertex *point, sl_vec3 origin, sl_vec3 direction,
                     sl_bidirectional_scratch *scratch, sl_bidirectional_value *value,
                     sl_counters *counters) {
    sums total = {{0.0}, {0.0}};
    sl_path_maker own = *shared, *maker = &own;
    if (samples == 0 || samples > points->settings.samples) samples = points->settings.samples;
    for (uint32_t first = 0; first < samples; first += SL_PACKET) {
        uint64_t key[SL_PACKET];
        uint32_t index[SL_PACKET];
        packet p = {.settings = &points->settings,
                    .without_caustics = points->settings.without_caustics && shared == &points->diffuse};
        unsigned light_count[SL_PACKET], count = packet_of(points, first, samples, key, index);
        sl_vec3 directions[SL_PACKET];
        double pdf[SL_PACKET];
        for (unsigned i = 0; i < count; i++) {
            p.eye[i] = &scratch->path[i];
            p.light_path[i] = points->vertex + points->first[first + i];
            light_count[i] = (unsigned)(points->first[first + i + 1] - points->first[first + i]);
            directions[i] = direction;
            pdf[i] = 1.0;
        }
        if (point) sl_walk_from_point(maker, count, point, key, index, p.eye, counters);
        else sl_walk_from_eye(maker, count, origin, directions, pdf, key, index, p.eye, counters);
        const sl_path_receiver receiver = {&p, receive};
        sl_connect_all(maker, count, p.eye, p.light_path, light_count, key, index, &receiver, counters);
        add_samples(&total, &p, count, counters);
        own.least = (float)(worth_a_ray * fmax(total.sum[0], fmax(total.sum[1], total.sum[2])) /
                            (double)(first + count));
    }
    sl_count(counters, SL_COUNT_SAMPLES, samples);
    double n = (double)samples;
    for (int c = 0; c < 3; c++) {
        double mean = total.sum[c] / n, variance = total.squares[c] / n - mean * mean;
        value->mean[c] = mean;
        value->variance[c] = samples > 1 && variance > 0.0 ? variance / (n - 1.0) : 0.0;
    }
}

/* As sl_surface_lift(); where the point is on an edge, above whatever meets there. */
static sl_vec3 lifted(const sl_scene *scene, const sl_bidirectional_request *request) {
    if (request->triangle == SL_NO_INDEX)
        return sl_surface_lift_anywhere(scene, request->position, request->geometric_normal);
    sl_surface surface = {.position = request->position,
                          .geometric_normal = request->geometric_normal,
                          .normal = request->normal};
    return sl_surface_lift(scene, request->triangle, &surface);
}

static sl_path_vertex vertex_at(const sl_scene *scene, const sl_bidirectional_request *request,
                                sl_vec3 to_viewer) {
    sl_path_vertex v = {.kind = SL_VERTEX_SURFACE,
                        .origin = lifted(scene, request),
                        .back = to_viewer,
                        .geometric_normal = request->geometric_normal,
                        .triangle = request->triangle,
                        .light = SL_NO_INDEX};
    v.bsdf.normal = request->normal;
    v.bsdf.geometric_normal = request->geometric_normal;
    return v;
}

void sl_bidirectional_irradiance(const sl_bidirectional_points *points,
                                 const sl_bidirectional_request *request, sl_bidirectional_scratch *scratch,
                                 sl_bidirectional_value *irradiance, sl_counters *counters) {
    sl_path_vertex v = vertex_at(points->diffuse.scene, request, request->normal);
    v.bsdf.diffuse = sl_grey((float)SL_PI); /* f = 1: the radiance that leaves it is the irradiance */
    estimate(points, &points->diffuse, request->samples, &v, v.origin, v.back, scratch, irradiance,
             counters);
}

void sl_bidirectional_radiance(const sl_bidirectional_points *points, const sl_bidirectional_request *request,
                               sl_vec3 eye, sl_bidirectional_scratch *scratch,
                               sl_bidirectional_value *radiance, sl_counters *counters) {
    const sl_scene *scene = points->glossy.scene;
    const sl_material *material = request->material;
    *radiance = (sl_bidirectional_value){{0.0}, {0.0}};
    if (!material && request->triangle == SL_NO_INDEX) return;
    if (!material) material = sl_triangle_material(scene, request->triangle);
    sl_vec3 to_eye = sl_normalize_or(sl_sub(eye, request->position), request->normal);
    sl_path_vertex v = vertex_at(scene, request, to_eye);
    if (sl_material_is_mirror(material)) {
        sl_vec3 direction = sl_normalize_or(sl_reflect(to_eye, request->normal), request->normal);
        if (!(sl_dot(direction, request->geometric_normal) > 0.0f)) return;
        estimate(points, &points->mirror, request->samples, NULL, v.origin, direction, scratch, radiance,
                 counters);
        const double tint[3] = {(double)material->mirror.r, (double)material->mirror.g,
                                (double)material->mirror.b};
        for (int c = 0; c < 3; c++) {
            radiance->mean[c] *= tint[c];
            radiance->variance[c] *= tint[c] * tint[c];
        }
    } else if (sl_material_is_glossy(material)) {
        v.bsdf.specular = material->specular;
        v.bsdf.exponent = material->exponent;
        estimate(points, &points->glossy, request->samples, &v, v.origin, v.back, scratch, radiance,
                 counters);
    }
}
