/* What a ray costs: milliseconds of processor time for 4096 rays of one 64 x 64 hemisphere (packets of 4 x 4 neighbouring
 * directions) and for 4096 shadow rays from its hits to points of one small square light, on one thread, beside Embree's own
 * triangles in the same packets; and the share of rays for which the two name different triangles or shadows.
 *
 *     build/bench/bench_trace SCENE...
 *
 * The points are what the scene's camera sees in 24 random pixels; medians of nine repetitions, ours and Embree's in turn. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "timing.h"

#include "base/math.h"
#include "base/memory.h"
#include "base/random.h"
#include "trace/embree.h"
#include "trace/trace.h"

enum { SIDE = 64, PACKETS = SIDE * SIDE / SL_PACKET, POINTS = 24, REPETITIONS = 9 };

typedef struct packet_set {
    sl_ray16 rays[PACKETS];
} packet_set;

typedef struct bench {
    sl_scene *scene;
    sl_tracer *tracer;
    RTCDevice device;
    RTCScene triangles;
    size_t count; /* of points */
    sl_vec3 position[POINTS], normal[POINTS];
    packet_set *gather, *shadow;
    sl_hit16 *hits;      /* ours, of one repetition: PACKETS a point */
    uint32_t *named;     /* Embree's */
    uint32_t *shadowed[2];
    sl_counters counters;
} bench;

static void stop(const char *what, const sl_error *error) {
    fprintf(stderr, "bench_trace: %s: %s\n", what, error->message);
    exit(1);
}

/* ---- Embree's own triangles ---------------------------------------------------------------------------------------- */

static void build_triangles(bench *b) {
    const sl_scene *s = b->scene;
    b->device = rtcNewDevice("threads=1");
    RTCGeometry geometry = rtcNewGeometry(b->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    float *corners = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                             3 * s->triangle_count);
    unsigned *index = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(unsigned),
                                              s->triangle_count);
    for (size_t t = 0; t < s->triangle_count; t++) {
        for (size_t k = 0; k < 3; k++) {
            sl_vec3 p = sl_scene_position(s, s->vertex[k][t]);
            memcpy(&corners[3 * (3 * t + k)], &p, sizeof p);
            index[3 * t + k] = (unsigned)(3 * t + k);
        }
    }
    rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_HIGH);
    rtcCommitGeometry(geometry);
    b->triangles = rtcNewScene(b->device);
    rtcSetSceneBuildQuality(b->triangles, RTC_BUILD_QUALITY_HIGH);
    rtcAttachGeometry(b->triangles, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(b->triangles);
}

static void fill_packet(struct RTCRay16 *out, const sl_ray16 *rays) {
    memcpy(out->org_x, rays->origin_x, sizeof out->org_x);
    memcpy(out->org_y, rays->origin_y, sizeof out->org_y);
    memcpy(out->org_z, rays->origin_z, sizeof out->org_z);
    memcpy(out->dir_x, rays->direction_x, sizeof out->dir_x);
    memcpy(out->dir_y, rays->direction_y, sizeof out->dir_y);
    memcpy(out->dir_z, rays->direction_z, sizeof out->dir_z);
    memcpy(out->tfar, rays->far, sizeof out->tfar);
    for (unsigned i = 0; i < SL_PACKET; i++) {
        out->tnear[i] = 1e-5f; /* Embree cannot skip a ray's own triangle */
        out->time[i] = 0.0f;
        out->mask[i] = UINT32_MAX;
        out->id[i] = i;
        out->flags[i] = 0;
    }
}

static const int all[SL_PACKET] = {-1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1};

static void embree_closest(bench *b, const sl_ray16 *rays, uint32_t *triangles) {
    struct RTCRayHit16 packet;
    _Alignas(64) int valid[SL_PACKET];
    sl_embree_query query;
    memcpy(valid, all, sizeof valid);
    fill_packet(&packet.ray, rays);
    for (unsigned i = 0; i < SL_PACKET; i++) packet.hit.geomID[i] = packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    sl_embree_begin(&query, NULL);
    sl_embree_intersect16(b->triangles, &query, valid, &packet);
    for (unsigned i = 0; i < SL_PACKET; i++) {
        triangles[i] = packet.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID ? SL_NO_INDEX : packet.hit.primID[i];
    }
}

static uint32_t embree_occluded(bench *b, const sl_ray16 *rays) {
    struct RTCRay16 packet;
    _Alignas(64) int valid[SL_PACKET];
    sl_embree_query query;
    uint32_t bits = 0;
    memcpy(valid, all, sizeof valid);
    fill_packet(&packet, rays);
    sl_embree_begin(&query, NULL);
    sl_embree_occluded16(b->triangles, &query, valid, &packet);
    for (unsigned i = 0; i < SL_PACKET; i++) bits |= packet.tfar[i] < 0.0f ? 1u << i : 0;
    return bits;
}

/* ---- the rays ------------------------------------------------------------------------------------------------------ */

/* Random directions through the film; every hit is a point, with the normal turned to the camera. */
static void choose_points(bench *b) {
    const sl_camera *c = &b->scene->camera;
    float tangent = (float)sl_tan(0.5 * (double)c->vertical_fov);
    float aspect = (float)b->scene->film_width / (float)b->scene->film_height;
    uint64_t key = sl_random_key(1, 2);
    for (uint64_t i = 0; i < 40 * POINTS && b->count < POINTS; i++) {
        float x = (2.0f * sl_random_unit(key, 2 * i) - 1.0f) * tangent * aspect;
        float y = (2.0f * sl_random_unit(key, 2 * i + 1) - 1.0f) * tangent;
        sl_vec3 d = sl_sub(sl_mad(sl_scale(c->right, x), y, c->up), c->back);
        sl_ray16 rays = {.origin_x = {c->eye.x}, .origin_y = {c->eye.y}, .origin_z = {c->eye.z}, .direction_x = {d.x},
                         .direction_y = {d.y}, .direction_z = {d.z}, .far = {INFINITY}, .skip = {SL_NO_INDEX}};
        sl_hit16 hits;
        sl_trace(b->tracer, &rays, 1, false, &hits, &b->counters);
        if (hits.triangle[0] == SL_NO_INDEX) continue;
        sl_surface s;
        sl_scene_surface(b->scene, hits.triangle[0], hits.w1[0], hits.w2[0], sl_neg(d), &s);
        b->normal[b->count] = s.geometric_normal;
        b->position[b->count++] = sl_mad(s.position, 1e-4f, s.geometric_normal);
    }
}

static void put_ray(sl_ray16 *packet, unsigned i, sl_vec3 origin, sl_vec3 direction, float far) {
    packet->origin_x[i] = origin.x;
    packet->origin_y[i] = origin.y;
    packet->origin_z[i] = origin.z;
    packet->direction_x[i] = direction.x;
    packet->direction_y[i] = direction.y;
    packet->direction_z[i] = direction.z;
    packet->near[i] = 0.0f;
    packet->far[i] = far;
    packet->skip[i] = SL_NO_INDEX;
}

/* Cell (x, y) of the hemisphere by the concentric map of the square to the disk (Shirley and Chiu 1997), lifted. */
static sl_vec3 hemisphere_direction(const sl_frame *frame, unsigned x, unsigned y) {
    float a = 2.0f * ((float)x + 0.5f) / SIDE - 1.0f, b = 2.0f * ((float)y + 0.5f) / SIDE - 1.0f, sine, cosine;
    bool wide = fabsf(a) > fabsf(b);
    float r = wide ? a : b, turn = 0.125f * (wide ? b / a : 2.0f - a / b);
    sl_sincos_turnf(turn < 0.0f ? turn + 1.0f : turn, &sine, &cosine);
    return sl_frame_to_world(frame, sl_v3(r * cosine, r * sine, sqrtf(1.0f - r * r)));
}

static void make_gather(packet_set *set, sl_vec3 p, sl_vec3 n) {
    sl_frame frame = sl_frame_from_normal(n);
    for (unsigned k = 0; k < PACKETS; k++) {
        unsigned x0 = k % (SIDE / 4) * 4, y0 = k / (SIDE / 4) * 4;
        for (unsigned i = 0; i < SL_PACKET; i++) {
            put_ray(&set->rays[k], i, p, hemisphere_direction(&frame, x0 + i % 4, y0 + i / 4), INFINITY);
        }
    }
}

/* Every hit of the gather looks at a random point of a square of a twentieth of the scene's size around its middle. */
static void make_shadow(const bench *b, packet_set *set, const packet_set *gather, const sl_hit16 *hits, uint64_t key) {
    sl_vec3 size = sl_sub(b->scene->box_max, b->scene->box_min);
    sl_vec3 middle = sl_mad(b->scene->box_min, 0.5f, size);
    for (unsigned k = 0; k < PACKETS; k++) {
        for (unsigned i = 0; i < SL_PACKET; i++) {
            uint64_t n = 2 * (k * SL_PACKET + i);
            float dx = sl_random_unit(key, n) - 0.5f, dz = sl_random_unit(key, n + 1) - 0.5f;
            const sl_ray16 *r = &gather->rays[k];
            float t = hits[k].triangle[i] == SL_NO_INDEX ? 0.0f : hits[k].t[i] * 0.9999f;
            sl_vec3 light = sl_add(middle, sl_v3(0.05f * size.x * dx, 0.0f, 0.05f * size.z * dz));
            sl_vec3 p = sl_mad(sl_v3(r->origin_x[i], r->origin_y[i], r->origin_z[i]), t,
                               sl_v3(r->direction_x[i], r->direction_y[i], r->direction_z[i]));
            put_ray(&set->rays[k], i, p, sl_sub(light, p), 1.0f);
        }
    }
}

/* ---- measuring ----------------------------------------------------------------------------------------------------- */

static double time_ours(bench *b, bool coherent) {
    double start = now_ms();
    for (size_t k = 0; k < b->count * PACKETS; k++) {
        sl_trace(b->tracer, &b->gather[k / PACKETS].rays[k % PACKETS], SL_PACKET, coherent, &b->hits[k], &b->counters);
    }
    return (now_ms() - start) / (double)b->count;
}

static double time_embree(bench *b) {
    double start = now_ms();
    for (size_t k = 0; k < b->count * PACKETS; k++) {
        embree_closest(b, &b->gather[k / PACKETS].rays[k % PACKETS], &b->named[k * SL_PACKET]);
    }
    return (now_ms() - start) / (double)b->count;
}

static double time_shadows(bench *b, bool ours, bool coherent) {
    double start = now_ms();
    for (size_t k = 0; k < b->count * PACKETS; k++) {
        const sl_ray16 *rays = &b->shadow[k / PACKETS].rays[k % PACKETS];
        b->shadowed[!ours][k] = ours ? sl_trace_occluded(b->tracer, rays, SL_PACKET, coherent, &b->counters)
                                     : embree_occluded(b, rays);
    }
    return (now_ms() - start) / (double)b->count;
}

static void measure(bench *b, const char *name) {
    enum { CLOSEST, SINGLY, THEIRS, SHADOW, SHADOW_SINGLY, THEIR_SHADOW, KINDS };
    double ms[KINDS][REPETITIONS], m[KINDS];
    time_ours(b, true);
    for (size_t p = 0; p < b->count; p++) make_shadow(b, &b->shadow[p], &b->gather[p], &b->hits[p * PACKETS], p);
    for (int i = 0; i < REPETITIONS; i++) {
        ms[THEIRS][i] = time_embree(b);
        ms[SINGLY][i] = time_ours(b, false);
        ms[CLOSEST][i] = time_ours(b, true);
        ms[THEIR_SHADOW][i] = time_shadows(b, false, true);
        ms[SHADOW_SINGLY][i] = time_shadows(b, true, false);
        ms[SHADOW][i] = time_shadows(b, true, true);
    }
    for (int k = 0; k < KINDS; k++) m[k] = median(ms[k], REPETITIONS);
    size_t differ = 0, shadows_differ = 0, rays = b->count * PACKETS * SL_PACKET;
    for (size_t k = 0; k < b->count * PACKETS; k++) {
        for (unsigned i = 0; i < SL_PACKET; i++) differ += b->hits[k].triangle[i] != b->named[k * SL_PACKET + i];
        shadows_differ += (size_t)__builtin_popcount(b->shadowed[0][k] ^ b->shadowed[1][k]);
    }
    printf("%s, %zu triangles, %zu points\n", name, b->scene->triangle_count, b->count);
    printf("  closest  coherent %.4f  one by one %.4f  Embree %.4f ms per 4096 rays   other triangle %.4f %%\n", m[CLOSEST],
           m[SINGLY], m[THEIRS], 100.0 * (double)differ / (double)rays);
    printf("  shadow   coherent %.4f  one by one %.4f  Embree %.4f ms per 4096 rays   other answer   %.4f %%\n", m[SHADOW],
           m[SHADOW_SINGLY], m[THEIR_SHADOW], 100.0 * (double)shadows_differ / (double)rays);
}

static void *checked(void *memory) {
    if (!memory) {
        fprintf(stderr, "bench_trace: out of memory\n");
        exit(1);
    }
    return memory;
}

static void run(const char *path) {
    bench b = {0};
    sl_error error = {0};
    if (sl_scene_load_with(path, &(sl_load_options){.allow_outside = true}, &b.scene, &error) != SL_OK) stop(path, &error);
    if (sl_tracer_create(b.scene, 1, NULL, &b.tracer, &error) != SL_OK) stop(path, &error);
    build_triangles(&b);
    choose_points(&b);
    b.gather = checked(sl_allocate(b.count, sizeof *b.gather));
    b.shadow = checked(sl_allocate(b.count, sizeof *b.shadow));
    b.hits = checked(sl_allocate(b.count * PACKETS, sizeof *b.hits));
    b.named = checked(sl_allocate(b.count * PACKETS * SL_PACKET, sizeof *b.named));
    for (int k = 0; k < 2; k++) b.shadowed[k] = checked(sl_allocate(b.count * PACKETS, sizeof(uint32_t)));
    for (size_t p = 0; p < b.count; p++) make_gather(&b.gather[p], b.position[p], b.normal[p]);
    if (b.count > 0) measure(&b, path);
    else printf("%s: the camera sees nothing\n", path);
    for (int k = 0; k < 2; k++) sl_free(b.shadowed[k]);
    sl_free(b.named);
    sl_free(b.hits);
    sl_free(b.shadow);
    sl_free(b.gather);
    rtcReleaseScene(b.triangles);
    rtcReleaseDevice(b.device);
    sl_tracer_destroy(b.tracer);
    sl_scene_destroy(b.scene);
}

int main(int argc, char **argv) {
    if (argc < 2) {
        fprintf(stderr, "usage: bench_trace SCENE...\n");
        return 2;
    }
    for (int i = 1; i < argc; i++) run(argv[i]);
    return 0;
}
