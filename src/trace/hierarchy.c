/* The hierarchy: one Embree user primitive a triangle, in boxes that are inflated, since Embree's walk
 * rounds. No hit depends on what is where in it. */
#include "trace/hierarchy.h"

#include <stdio.h>

#include "base/code_sort.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/morton.h"
#include "base/parallel.h"

/* Boxes grow by four times what rounding decides a hit within (ray_setup.h). */
#define INFLATION 2e-6

/* ---- triangles ------------------------------------------------------------------------------- */

static float least(const float v[3]) { return fminf(v[0], fminf(v[1], v[2])); }
static float greatest(const float v[3]) { return fmaxf(v[0], fmaxf(v[1], v[2])); }

static void triangle_bounds(const struct RTCBoundsFunctionArguments *arguments) {
    const sl_traced_part *part = arguments->geometryUserPtr;
    const float grow = part->inflation, unit = part->tracer->unit;
    sl_triangle_corners own;
    const sl_triangle_corners *c = &own;
    if (part->placed) c = &part->placed[arguments->primID].corners;
    else sl_scene_corners(part->tracer->scene, part->first + part->order[arguments->primID], &own);
    struct RTCBounds *box = arguments->bounds_o;
    box->lower_x = (least(c->p[0]) - grow) * unit;
    box->lower_y = (least(c->p[1]) - grow) * unit;
    box->lower_z = (least(c->p[2]) - grow) * unit;
    box->upper_x = (greatest(c->p[0]) + grow) * unit;
    box->upper_y = (greatest(c->p[1]) + grow) * unit;
    box->upper_z = (greatest(c->p[2]) + grow) * unit;
}

static void measure_scene(sl_tracer *tracer) {
    const sl_scene *s = tracer->scene;
    float greatest_coordinate = 0.0f;
    for (size_t t = 0; t < s->triangle_count; t++) {
        for (int k = 0; k < 3; k++) {
            const float c = sl_greatest_coordinate(sl_scene_position(s, s->vertex[k][t]));
            greatest_coordinate = fmaxf(greatest_coordinate, c);
        }
        tracer->any_alpha |= sl_scene_has_alpha(s, (uint32_t)t);
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

/* ---- their order: the Morton curve's, so that neighbours in space are near one another in memory ---- */

enum { AXIS_BITS = 20 };

/* Along one axis, from the scene's low end in units of its largest extent. */
static uint64_t cell(float a, float b, float c, float low, double extent) {
    double middle = ((double)a + (double)b + (double)c) / 3.0 - (double)low;
    double last = (double)((1 << AXIS_BITS) - 1), x = extent > 0.0 ? middle / extent * last : 0.0;
    return x > 0.0 ? (uint64_t)(x < last ? x : last) : 0; /* also where it is not a number */
}

static uint64_t morton_code(const sl_scene *s, size_t triangle, double extent) {
    sl_vec3 a = sl_scene_position(s, s->vertex[0][triangle]),
            b = sl_scene_position(s, s->vertex[1][triangle]);
    sl_vec3 c = sl_scene_position(s, s->vertex[2][triangle]);
    return sl_morton_code(cell(a.x, b.x, c.x, s->box_min.x, extent),
                          cell(a.y, b.y, c.y, s->box_min.y, extent),
                          cell(a.z, b.z, c.z, s->box_min.z, extent));
}

static sl_status put_in_order(const sl_scene *scene, uint32_t *order, size_t count, sl_error *error) {
    sl_coded *places = sl_allocate_unset(count, sizeof *places);
    if (!places) return sl_fail_memory(error, "the order of the tracer's triangles");
    sl_vec3d size = sl_subd(sl_to_double(scene->box_max), sl_to_double(scene->box_min));
    double extent = fmax(size.x, fmax(size.y, size.z));
    for (size_t i = 0; i < count; i++)
        places[i] = (sl_coded){morton_code(scene, order[i], extent), order[i]};
    sl_sort_coded(places, count);
    for (size_t i = 0; i < count; i++) order[i] = places[i].item;
    sl_free(places);
    return SL_OK;
}

/* All that are no copies. */
static size_t list_plain(const sl_tracer *tracer, uint32_t *list) {
    const sl_copies *c = &tracer->copies;
    size_t count = 0, next = 0;
    for (uint32_t t = 0; t < tracer->scene->triangle_count; t++) {
        if (next < c->copy_count && t == c->copy[next].first) t += c->mesh[c->copy[next++].mesh].count - 1;
        else list[count++] = t;
    }
    return count;
}

static sl_status place_plain(sl_tracer *tracer, sl_error *error) {
    sl_traced_part *part = &tracer->plain;
    const size_t room = tracer->scene->triangle_count - tracer->copies.triangles;
    uint32_t *list = sl_allocate(room, sizeof *list);
    sl_status status = list ? SL_OK : sl_fail_memory(error, "the tracer's triangles");
    *part = (sl_traced_part){.tracer = tracer, .inflation = tracer->inflation};
    if (status == SL_OK) {
        part->count = list_plain(tracer, list);
        status = put_in_order(tracer->scene, list, part->count, error);
    }
    if (status == SL_OK && !(part->placed = sl_allocate_unset(part->count, sizeof *part->placed)))
        status = sl_fail_memory(error, "the tracer's triangles");
    for (size_t i = 0; status == SL_OK && i < part->count; i++) {
        part->placed[i].index = list[i];
        sl_scene_corners(tracer->scene, list[i], &part->placed[i].corners);
    }
    sl_free(list);
    return status;
}

static sl_status place_mesh(sl_tracer *tracer, const sl_copied_mesh *mesh, sl_traced_part *part,
                            sl_error *error) {
    *part = (sl_traced_part){.tracer = tracer,
                             .count = mesh->count,
                             .first = mesh->first,
                             .inflation = (float)(mesh->slack + mesh->stretch * (double)tracer->inflation),
                             .order = sl_allocate(mesh->count, sizeof *part->order)};
    if (!part->order) return sl_fail_memory(error, "the tracer's triangles");
    for (uint32_t i = 0; i < mesh->count; i++) part->order[i] = mesh->first + i;
    sl_status status = put_in_order(tracer->scene, part->order, mesh->count, error);
    for (uint32_t i = 0; i < mesh->count; i++) part->order[i] -= mesh->first;
    return status;
}

/* ---- Embree ---------------------------------------------------------------------------------- */

static bool count_memory(void *tracer, ssize_t bytes, bool post) {
    (void)post;
    atomic_fetch_add(&((sl_tracer *)tracer)->embree_bytes, (long long)bytes);
    return true;
}

static sl_status fail_embree(const sl_tracer *tracer, const char *what, sl_error *error) {
    enum RTCError code = rtcGetDeviceError(tracer->device);
    return sl_fail(error, SL_ERROR_RESOURCES, "Embree could not %s (error %d)", what, (int)code);
}

static sl_status make_scene(const sl_tracer *tracer, RTCScene *scene, sl_error *error) {
    if (!(*scene = rtcNewScene(tracer->device))) return fail_embree(tracer, "make a scene", error);
    rtcSetSceneFlags(*scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(*scene, RTC_BUILD_QUALITY_HIGH);
    return SL_OK;
}

static sl_status attach(const sl_tracer *tracer, RTCScene scene, RTCGeometry geometry, unsigned id,
                        sl_error *error) {
    if (!geometry) return fail_embree(tracer, "make a geometry", error);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene, geometry, id);
    rtcReleaseGeometry(geometry);
    return SL_OK;
}

static sl_status attach_part(const sl_tracer *tracer, RTCScene scene, sl_traced_part *part, unsigned id,
                             sl_error *error) {
    RTCGeometry geometry = rtcNewGeometry(tracer->device, RTC_GEOMETRY_TYPE_USER);
    if (geometry) {
        rtcSetGeometryUserPrimitiveCount(geometry, (unsigned)part->count);
        rtcSetGeometryUserData(geometry, part);
        rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_HIGH);
        rtcSetGeometryBoundsFunction(geometry, triangle_bounds, NULL);
        rtcSetGeometryIntersectFunction(geometry, sl_intersect_callback);
        rtcSetGeometryOccludedFunction(geometry, sl_occluded_callback);
    }
    return attach(tracer, scene, geometry, id, error);
}

static sl_status attach_copy(const sl_tracer *tracer, const sl_copy *copy, unsigned id, sl_error *error) {
    RTCGeometry geometry = rtcNewGeometry(tracer->device, RTC_GEOMETRY_TYPE_INSTANCE);
    if (geometry) {
        rtcSetGeometryInstancedScene(geometry, tracer->meshes[copy->mesh].scene);
        rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, copy->from_mesh);
    }
    return attach(tracer, tracer->hierarchy, geometry, id, error);
}

static sl_status build_mesh(sl_tracer *tracer, size_t mesh, sl_error *error) {
    sl_traced_part *part = &tracer->meshes[mesh];
    sl_status status = place_mesh(tracer, &tracer->copies.mesh[mesh], part, error);
    if (status == SL_OK) status = make_scene(tracer, &part->scene, error);
    if (status == SL_OK) status = attach_part(tracer, part->scene, part, 0, error);
    if (status == SL_OK) rtcCommitScene(part->scene);
    return status;
}

/* Copies have the numbers that they have among the scene's copies: sl_embree_instance(). */
static sl_status build_hierarchy(sl_tracer *tracer, sl_error *error) {
    const sl_copies *c = &tracer->copies;
    sl_status status = make_scene(tracer, &tracer->hierarchy, error);
    for (size_t i = 0; i < c->mesh_count && status == SL_OK; i++)
        if (c->mesh[i].copies > 1) status = build_mesh(tracer, i, error);
    for (size_t i = 0; i < c->copy_count && status == SL_OK; i++)
        status = attach_copy(tracer, &c->copy[i], (unsigned)i, error);
    if (status == SL_OK)
        status = attach_part(tracer, tracer->hierarchy, &tracer->plain, (unsigned)c->copy_count, error);
    if (status != SL_OK) return status;
    rtcCommitScene(tracer->hierarchy);
    if (rtcGetDeviceError(tracer->device) != RTC_ERROR_NONE)
        return sl_fail(error, SL_ERROR_RESOURCES, "Embree could not build the hierarchy of %zu triangles",
                       tracer->scene->triangle_count);
    return SL_OK;
}

/* ---- life ------------------------------------------------------------------------------------ */

static sl_status make_device(sl_tracer *tracer, unsigned threads, const char *embree_config,
                             sl_error *error) {
    /* Embree ends the process where it cannot start one. */
    unsigned builders = sl_threads_to_be_had(sl_thread_count(threads));
    char config[256];
    if (builders == 0)
        return sl_fail(error, SL_ERROR_RESOURCES, "no thread could be had for the rays' hierarchy");
    /* Embree's default, a leaf for each triangle, makes it test boxes longer than we would test triangles. */
    snprintf(config, sizeof config, "threads=%u,object_accel_max_leaf_size=4%s%s", builders,
             embree_config ? "," : "", embree_config ? embree_config : "");
    tracer->device = rtcNewDevice(config);
    if (!tracer->device)
        return sl_fail(error, SL_ERROR_RESOURCES, "Embree could not make a device with \"%s\" (error %d)",
                       config, (int)rtcGetDeviceError(NULL));
    rtcSetDeviceMemoryMonitorFunction(tracer->device, count_memory, tracer);
    return SL_OK;
}

static sl_status make(sl_tracer *tracer, unsigned threads, const char *embree_config, size_t worth,
                      sl_error *error) {
    measure_scene(tracer);
    tracer->setup =
        (sl_ray_setup){tracer->centre, sl_tracer_far_squared(tracer), (double)tracer->unit};
    sl_status status = SL_OK;
    if (tracer->unit == 1.0f) status = sl_copies_find(tracer->scene, worth, &tracer->copies, error);
    tracer->meshes = sl_allocate(tracer->copies.mesh_count, sizeof *tracer->meshes);
    if (status == SL_OK && !tracer->meshes) status = sl_fail_memory(error, "the tracer's meshes");
    if (status == SL_OK) status = place_plain(tracer, error);
    if (status == SL_OK) status = make_device(tracer, threads, embree_config, error);
    return status == SL_OK ? build_hierarchy(tracer, error) : status;
}

sl_status sl_tracer_create_sharing(const sl_scene *scene, unsigned threads, const char *embree_config,
                                   size_t worth, sl_tracer **out, sl_error *error) {
    *out = NULL;
    if (scene->triangle_count >= SL_NO_INDEX)
        return sl_fail(error, SL_ERROR_RESOURCES, "a scene may have at most %u triangles, this has %zu",
                       SL_NO_INDEX - 1, scene->triangle_count);
    sl_tracer *tracer = sl_allocate(1, sizeof *tracer);
    if (!tracer) return sl_fail_memory(error, "the tracer");
    tracer->scene = scene;
    tracer->isa = sl_isa_best();
    sl_status status = make(tracer, threads, embree_config, worth, error);
    if (status == SL_OK) *out = tracer;
    else sl_tracer_destroy(tracer);
    return status;
}

sl_status sl_tracer_create(const sl_scene *scene, unsigned threads, const char *embree_config,
                           sl_tracer **out, sl_error *error) {
    return sl_tracer_create_sharing(scene, threads, embree_config, SL_COPIES_WORTH, out, error);
}

void sl_tracer_destroy(sl_tracer *tracer) {
    if (!tracer) return;
    if (tracer->hierarchy) rtcReleaseScene(tracer->hierarchy);
    for (size_t i = 0; tracer->meshes && i < tracer->copies.mesh_count; i++) {
        if (tracer->meshes[i].scene) rtcReleaseScene(tracer->meshes[i].scene);
        sl_free(tracer->meshes[i].order);
    }
    if (tracer->device) rtcReleaseDevice(tracer->device);
    SL_FREE_ALL(tracer->plain.placed, tracer->meshes);
    sl_copies_release(&tracer->copies);
    sl_free(tracer);
}

size_t sl_tracer_memory_bytes(const sl_tracer *tracer) {
    const sl_copies *c = &tracer->copies;
    const long long embree = atomic_load(&((sl_tracer *)tracer)->embree_bytes);
    size_t bytes = sizeof *tracer + tracer->plain.count * sizeof *tracer->plain.placed +
                   c->mesh_count * (sizeof *tracer->meshes + sizeof *c->mesh) +
                   c->copy_count * sizeof *c->copy;
    for (size_t i = 0; i < c->mesh_count; i++)
        bytes += tracer->meshes[i].count * sizeof *tracer->meshes[i].order;
    return bytes + (size_t)(embree > 0 ? embree : 0);
}

/* Measured: 121 to 140 bytes a triangle at 10^5 to 10^6 of them while Embree builds (of which 40 are ours),
 * and a few megabytes of pools. */
double sl_tracer_memory_need(const sl_scene *scene) {
    return 6e6 + 144.0 * (double)(scene->triangle_count - sl_copies_expected(scene));
}
