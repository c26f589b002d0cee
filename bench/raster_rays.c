/* Against rays: one plane over a point, rendered, and the same directions (those of the pixels' centres)
 * traced, sixteen at a time in blocks of 4 x 4 pixels: by our tracer, and by Embree with its own triangles,
 * both told that the rays are coherent. */
#include <stdio.h>
#include <string.h>

#include "base/math.h"
#include "base/memory.h"
#include "raster_workloads.h"
#include "timing.h"
#include "trace/embree.h"
#include "trace/trace.h"

enum { ROUNDS = 9, LARGEST = 256 };
static const double sample_ms = 0.5;

typedef struct rivals {
    const bench_scene *scene;
    sl_tracer *tracer;
    RTCDevice device;
    RTCScene triangles;
    int size;
    size_t packets;
    sl_view view;
    sl_raster_scratch *scratch;
    uint32_t *id, *traced, *embree; /* pixels in the plane's order; packet after packet */
    float *depth;
    sl_ray16 *rays;
    sl_counters counters;
} rivals;

/* ---- Embree's own triangles ------------------------------------------------------------------ */

static void build_embree(rivals *r) {
    const peer_mesh *m = &r->scene->mesh;
    r->device = rtcNewDevice("threads=1");
    RTCGeometry geometry = rtcNewGeometry(r->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    float *position = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                              3 * sizeof(float), m->vertex_count);
    uint32_t *index = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                              3 * sizeof(uint32_t), m->triangle_count);
    if (!position || !index) bench_stop("Embree", "not enough memory");
    memcpy(position, m->position, 3 * sizeof(float) * m->vertex_count);
    memcpy(index, m->index, 3 * sizeof(uint32_t) * m->triangle_count);
    rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_HIGH);
    rtcCommitGeometry(geometry);
    r->triangles = rtcNewScene(r->device);
    rtcSetSceneBuildQuality(r->triangles, RTC_BUILD_QUALITY_HIGH);
    rtcAttachGeometry(r->triangles, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(r->triangles);
}

static void fill_packet(struct RTCRayHit16 *out, const sl_ray16 *rays) {
    struct RTCRay16 *ray = &out->ray;
    memcpy(ray->org_x, rays->origin_x, sizeof ray->org_x);
    memcpy(ray->org_y, rays->origin_y, sizeof ray->org_y);
    memcpy(ray->org_z, rays->origin_z, sizeof ray->org_z);
    memcpy(ray->dir_x, rays->direction_x, sizeof ray->dir_x);
    memcpy(ray->dir_y, rays->direction_y, sizeof ray->dir_y);
    memcpy(ray->dir_z, rays->direction_z, sizeof ray->dir_z);
    memcpy(ray->tnear, rays->near, sizeof ray->tnear);
    memcpy(ray->tfar, rays->far, sizeof ray->tfar);
    for (unsigned i = 0; i < SL_PACKET; i++) {
        ray->time[i] = 0.0f;
        ray->mask[i] = UINT32_MAX;
        ray->id[i] = i;
        ray->flags[i] = 0;
        out->hit.geomID[i] = out->hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
}

static void trace_embree(rivals *r) {
    _Alignas(64) static const int all[SL_PACKET] = {-1, -1, -1, -1, -1, -1, -1, -1,
                                                    -1, -1, -1, -1, -1, -1, -1, -1};
    struct RTCRayHit16 packet;
    sl_embree_query query;
    sl_embree_begin(&query, NULL);
    for (size_t k = 0; k < r->packets; k++) {
        fill_packet(&packet, &r->rays[k]);
        sl_embree_intersect16(r->triangles, &query, all, &packet);
        for (unsigned i = 0; i < SL_PACKET; i++) {
            r->embree[k * SL_PACKET + i] =
                packet.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID ? SL_NO_INDEX : packet.hit.primID[i];
        }
    }
}

/* ---- ours ------------------------------------------------------------------------------------ */

static void trace_ours(rivals *r) {
    sl_hit16 hits;
    for (size_t k = 0; k < r->packets; k++) {
        sl_trace(r->tracer, &r->rays[k], SL_PACKET, true, &hits, &r->counters);
        memcpy(&r->traced[k * SL_PACKET], hits.triangle, sizeof hits.triangle);
    }
}

static void rasterize(rivals *r) {
    sl_target target = {r->size, r->size, r->id, r->depth};
    sl_raster_id_small(r->scene->raster, &r->view, &target, r->scratch, &r->counters);
}

/* ---- the same directions --------------------------------------------------------------------- */

static size_t pixel_of(const rivals *r, size_t packet, unsigned i) {
    size_t blocks = (size_t)r->size / 4, x = packet % blocks * 4 + i % 4, y = packet / blocks * 4 + i / 4;
    return y * (size_t)r->size + x;
}

/* Directions are 1 long along the plane's axis, so that distances are depths and begin at the same near
 * plane. */
static void aim(rivals *r, size_t point, double degrees) {
    sl_frame frame = sl_frame_from_normal(r->scene->normal[point]);
    float tangent = (float)sl_tan(degrees * SL_PI / 360.0);
    r->view = bench_plane_view(r->scene, point, r->size, degrees);
    for (size_t k = 0; k < r->packets; k++) {
        sl_ray16 *ray = &r->rays[k];
        for (unsigned i = 0; i < SL_PACKET; i++) {
            size_t pixel = pixel_of(r, k, i), size = (size_t)r->size;
            float x = (2.0f * ((float)(pixel % size) + 0.5f) / (float)size - 1.0f) * tangent;
            float y = (2.0f * ((float)(pixel / size) + 0.5f) / (float)size - 1.0f) * tangent;
            sl_vec3 d = sl_frame_to_world(&frame, sl_v3(x, y, 1.0f));
            ray->origin_x[i] = r->view.origin.x;
            ray->origin_y[i] = r->view.origin.y;
            ray->origin_z[i] = r->view.origin.z;
            ray->direction_x[i] = d.x;
            ray->direction_y[i] = d.y;
            ray->direction_z[i] = d.z;
            ray->near[i] = -r->view.clip[2][3];
            ray->far[i] = INFINITY;
            ray->skip[i] = SL_NO_INDEX;
        }
    }
}

/* ---- measuring ------------------------------------------------------------------------------- */

enum { RASTER, TRACE, EMBREE, RIVALS };

static double time_of(rivals *r, int rival, int runs) {
    static void (*const run[RIVALS])(rivals *) = {rasterize, trace_ours, trace_embree};
    double start = now_ms();
    for (int i = 0; i < runs; i++) run[rival](r);
    return (now_ms() - start) / runs;
}

/* Adds the medians at one point, the three taking turns. */
static void measure_point(rivals *r, double sums[RIVALS]) {
    double ms[RIVALS][ROUNDS];
    int runs[RIVALS];
    for (int k = 0; k < RIVALS; k++) {
        time_of(r, k, 1);
        runs[k] = (int)(sample_ms / time_of(r, k, 1)) + 1;
    }
    for (int i = 0; i < ROUNDS; i++) {
        for (int k = 0; k < RIVALS; k++) ms[k][i] = time_of(r, k, runs[k]);
    }
    for (int k = 0; k < RIVALS; k++) sums[k] += median(ms[k], ROUNDS);
}

static double differing(const rivals *r) {
    double differ = 0;
    for (size_t k = 0; k < r->packets; k++) {
        for (unsigned i = 0; i < SL_PACKET; i++)
            differ += r->traced[k * SL_PACKET + i] != r->id[pixel_of(r, k, i)];
    }
    return differ / (double)(r->packets * SL_PACKET);
}

/* Raster over rays, at the most; at a million triangles rays may win. */
static double wanted_ratio(const bench_scene *scene, int size) {
    if (scene->scene->triangle_count > 100000) return 0.0;
    return size <= 64 ? 1.0 : size >= 256 ? 0.5 : 0.0;
}

static void measure_size(const measurer *m, rivals *r, int size, double degrees) {
    double ms[RIVALS] = {0}, wanted = wanted_ratio(r->scene, size), differ = 0,
           points = (double)r->scene->points;
    r->size = size;
    r->packets = (size_t)size * (size_t)size / SL_PACKET;
    for (size_t i = 0; i < r->scene->points; i++) {
        aim(r, i, degrees);
        measure_point(r, ms);
        differ += differing(r) / points;
    }
    for (int k = 0; k < RIVALS; k++) ms[k] /= points;
    double ratio = ms[RASTER] / ms[TRACE];
    if (m->csv) {
        printf("\"rays, %.0f degrees %dx%d, %s\",%.5g,%.5g,%.5g,%.4g,%.3g,%.3g\n", degrees, size, size,
               r->scene->name, ms[RASTER], ms[TRACE], ms[EMBREE], ratio, wanted, differ);
    } else {
        printf("%-16s %3.0f  %3dx%-3d %9.4f %9.4f %9.4f %8.2f %8.2f", r->scene->name, degrees, size, size,
               ms[RASTER], ms[TRACE], ms[EMBREE], ratio, ms[RASTER] / ms[EMBREE]);
        if (wanted > 0.0) printf(" %7.1f  %-6s", wanted, ratio > wanted ? "missed" : "");
        else printf(" %7s  %-6s", "", "");
        printf(" %9.1e\n", differ);
    }
    fflush(stdout);
}

static void print_head(const measurer *m) {
    static bool printed;
    if (printed) return;
    printed = true;
    if (m->csv) {
        printf("workload,raster ms,our rays ms,Embree ms,ratio,wanted,differing\n");
        return;
    }
    printf("\nagainst rays: ms of processor time for one plane over a point, one thread, and the same "
           "directions traced\n%-16s %3s  %7s %9s %9s %9s %8s"
           " %8s %7s  %-6s %9s\n",
           "", "fov", "pixels", "raster", "our rays", "Embree", "of ours", "of E.", "wanted", "",
           "differing");
}

void bench_rays(measurer *m, bench_scene *scene) {
    size_t pixels = (size_t)LARGEST * LARGEST;
    sl_error error;
    char name[64];
    snprintf(name, sizeof name, "rays, %s", scene->name);
    if (m->threads > 1 || !measure_wants(m, name)) return;
    bench_scene_open(scene);
    rivals r = {.scene = scene,
                .id = bench_allocate(pixels, 4),
                .traced = bench_allocate(pixels, 4),
                .embree = bench_allocate(pixels, 4),
                .depth = bench_allocate(pixels, 4),
                .rays = bench_allocate(pixels / SL_PACKET, sizeof(sl_ray16))};
    if (sl_tracer_create(scene->scene, 1, NULL, &r.tracer, &error) != SL_OK)
        bench_stop(scene->name, error.message);
    if (sl_raster_scratch_create(scene->raster, LARGEST, LARGEST, &r.scratch, &error) != SL_OK)
        bench_stop(scene->name, error.message);
    build_embree(&r);
    print_head(m);
    for (int wide = 0; wide < 2; wide++) {
        for (int size = 64; size <= LARGEST; size *= 2) measure_size(m, &r, size, wide ? 160.0 : 140.0);
    }
    rtcReleaseScene(r.triangles);
    rtcReleaseDevice(r.device);
    sl_tracer_destroy(r.tracer);
    sl_raster_scratch_destroy(r.scratch);
    sl_free(r.id);
    sl_free(r.traced);
    sl_free(r.embree);
    sl_free(r.depth);
    sl_free(r.rays);
}
