/* Samples of vertices: direct radiance from the irradiance meshes, indirect irradiance from gathers. A batch's samples are taken by all threads and
 * committed in order. */
#include "cache/multi_mesh/multi_mesh_internal.h"

#include "base/counters.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/multi_mesh/direct.h"
#include "cache/multi_mesh/lit_points.h"

static void put_value(sl_displayed *part, uint32_t vertex, sl_rgb value, bool valid, sl_counters *counters) {
    sl_mesh *mesh = part->mesh;
    bool finite = sl_rgb_is_finite(value);
    if (!finite) sl_count(counters, SL_COUNT_NONFINITE, 1);
    mesh->value[3 * (size_t)vertex] = finite ? value.r : 0.0f;
    mesh->value[3 * (size_t)vertex + 1] = finite ? value.g : 0.0f;
    mesh->value[3 * (size_t)vertex + 2] = finite ? value.b : 0.0f;
    mesh->state[vertex] = valid && finite ? SL_VERTEX_KNOWN : SL_VERTEX_INVALID;
}

/* Radiance of one vertex from its lights' shares. */
static sl_rgb direct_value(const sl_multi_mesh_state *s, sl_component part, uint32_t vertex, const float *share) {
    if (part == SL_DIRECT_DIFFUSE) return sl_direct_diffuse(s->lights, share);
    sl_mesh_point point;
    sl_mesh_point_of(s->part[part]->mesh, vertex, &point);
    return sl_direct_specular(s->lights, share, &point, sl_face_material(s->scene, point.face)->exponent, s->scene->camera.eye);
}

/* How deep a light's mesh must be, whatever its edges say. A leaf's edges have their middles sampled, so its samples are as close to each other as corners
 * of leaves a level deeper: several lights' meshes are left that much coarser, which for the same error takes a quarter to a third of the samples of eight
 * lights away (bench_mesh_joint). With one light samples where nothing changes are few (in the room 8 %, at 5 % more error). */
static int irradiance_depth(const sl_multi_mesh_state *s, int wanted) {
    if (s->settings.multi_mesh.joint_mesh) return SL_MESH_DEPTH_MAX;
    return s->lights->count > 1 ? wanted - 1 : wanted;
}

static sl_status sample_direct(sl_multi_mesh_state *s, sl_component part, size_t count, const sl_wanted_vertex *wanted, sl_error *error) {
    size_t lights = s->lights->count;
    sl_face_point *points = sl_allocate(count, sizeof *points);
    float *share = sl_allocate(count * lights, sizeof *share);
    bool *valid = sl_allocate(count, sizeof *valid);
    sl_status status = points && share && valid ? SL_OK : sl_fail_memory(error, "samples");
    for (size_t i = 0; i < count && status == SL_OK; i++) {
        points[i] = sl_vertex_face_point(s->part[part]->mesh, wanted[i].vertex, irradiance_depth(s, wanted[i].wanted_depth), wanted[i].leaf);
    }
    if (status == SL_OK) status = sl_irradiance_at(s->irradiance, count, points, share, valid, &s->counters, error);
    for (size_t i = 0; i < count && status == SL_OK; i++)
        put_value(s->part[part], wanted[i].vertex, direct_value(s, part, wanted[i].vertex, &share[i * lights]), valid[i], &s->counters);
    sl_free(valid);
    sl_free(share);
    sl_free(points);
    return status;
}

typedef struct gathering {
    const sl_multi_mesh_state *s;
    const sl_mesh_point *point;
    sl_rgb *irradiance;
} gathering;

static void gather_one(void *context, size_t task, unsigned worker) {
    const gathering *g = context;
    sl_gather_worker *w = &g->s->gatherer[worker];
    g->irradiance[task] = sl_mesh_gather_take(g->s->gather, &g->point[task], w->scratch, &w->counters);
}

void sl_multi_mesh_gather(sl_multi_mesh_state *s, size_t count, const sl_mesh_point *points, sl_rgb *irradiance) {
    gathering g = {s, points, irradiance};
    sl_parallel_for(s->settings.threads, count, gather_one, &g);
    for (unsigned t = 0; t < s->settings.threads; t++) {
        sl_counters_add(&s->counters, &s->gatherer[t].counters);
        s->gatherer[t].counters = (sl_counters){{0}};
    }
}

/* Where the vertex gathers: a little inside its leaf if it lies within a solid, as direct light does (irradiance.c); false: there, too. */
static bool find_gather_point(sl_multi_mesh_state *s, const sl_mesh *mesh, const sl_wanted_vertex *wanted, sl_mesh_point *point) {
    sl_mesh_point_of(mesh, wanted->vertex, point);
    bool inside = s->tracer && sl_mesh_point_in_solid(s->topology, s->tracer, point, &s->counters);
    for (size_t i = 0; i < SL_NUDGES && inside; i++) {
        sl_mesh_point_nudged(mesh, wanted->vertex, wanted->leaf, sl_nudge[i], point);
        inside = sl_mesh_point_in_solid(s->topology, s->tracer, point, &s->counters);
    }
    return !inside;
}

static double reach_of(const sl_mesh *mesh, uint32_t vertex) { return sl_dyadic_reach(mesh->key[vertex].p, mesh->key[vertex].q); }

/* What to do about a vertex where all but nothing arrives: it may be walled in by what is no solid (lit_points.h). */
typedef enum dark_vertex { DARK_AS_IT_IS, DARK_AND_INVALID, DARK_BUT_INSIDE } dark_vertex;

/* A face's corner gathers once more, a fifth of the way into the face: a beam that few pixels show has no other vertices. Unless a wall stands in between,
 * far off: what is beyond that is another room. Any other vertex behind a wall has no light of its own. */
static dark_vertex look_inside(sl_multi_mesh_state *s, const sl_mesh *mesh, const sl_wanted_vertex *wanted, sl_mesh_point *inside) {
    const float scale = s->scene->scale, far = 0.01f * scale;
    double reach = reach_of(mesh, wanted->vertex);
    sl_mesh_point at;
    if (!s->tracer) return DARK_AS_IT_IS;
    sl_mesh_point_of(mesh, wanted->vertex, &at);
    sl_mesh_point_nudged(mesh, wanted->vertex, wanted->leaf, sl_nudge[SL_NUDGES - 1], inside);
    float share = sl_share_before_wall(s->tracer, &at, inside, 1e-5f * scale, &s->counters);
    if (reach < 1.0) return share < SL_STUB ? DARK_AND_INVALID : DARK_AS_IT_IS;
    bool another_room = share >= SL_STUB && share < 1.0f && sl_length(sl_sub(inside->position, at.position)) > far;
    return another_room ? DARK_AS_IT_IS : DARK_BUT_INSIDE;
}

static sl_status gather_before_walls(sl_multi_mesh_state *s, size_t count, const sl_wanted_vertex *wanted, sl_mesh_point *points, sl_rgb *irradiance,
                                     bool *valid, sl_error *error) {
    const sl_mesh *mesh = s->part[SL_INDIRECT]->mesh;
    size_t dark = 0;
    float little = 0.02f * sl_rgb_mean(s->ambient);
    uint32_t *which = sl_allocate(count, sizeof *which);
    sl_rgb *again = sl_allocate(count, sizeof *again);
    for (size_t i = 0; i < count && which && again; i++) {
        if (!(sl_rgb_mean(irradiance[i]) < little)) continue;
        dark_vertex found = look_inside(s, mesh, &wanted[i], &points[dark]);
        if (found == DARK_AND_INVALID) valid[i] = false;
        if (found == DARK_BUT_INSIDE) which[dark++] = (uint32_t)i;
    }
    if (dark) sl_multi_mesh_gather(s, dark, points, again);
    for (size_t i = 0; i < dark; i++) irradiance[which[i]] = again[i];
    sl_status status = which && again ? SL_OK : sl_fail_memory(error, "gathers");
    sl_free(which);
    sl_free(again);
    return status;
}

static sl_status sample_indirect(sl_multi_mesh_state *s, size_t count, const sl_wanted_vertex *wanted, sl_error *error) {
    sl_displayed *part = s->part[SL_INDIRECT];
    sl_mesh_point *points = sl_allocate(count, sizeof *points);
    sl_rgb *irradiance = sl_allocate(count, sizeof *irradiance);
    bool *valid = sl_allocate(count, sizeof *valid);
    sl_status status = points && irradiance && valid ? SL_OK : sl_fail_memory(error, "gathers");
    for (size_t i = 0; i < count && status == SL_OK; i++) valid[i] = find_gather_point(s, part->mesh, &wanted[i], &points[i]);
    if (status == SL_OK) sl_multi_mesh_gather(s, count, points, irradiance);
    if (status == SL_OK) status = gather_before_walls(s, count, wanted, points, irradiance, valid, error);
    for (size_t i = 0; i < count && status == SL_OK; i++) put_value(part, wanted[i].vertex, irradiance[i], valid[i], &s->counters);
    sl_free(valid);
    sl_free(irradiance);
    sl_free(points);
    return status;
}

sl_status sl_multi_mesh_sample(sl_multi_mesh_state *s, sl_component part, size_t count, const sl_wanted_vertex *wanted, sl_error *error) {
    if (count == 0) return SL_OK;
    return part == SL_INDIRECT ? sample_indirect(s, count, wanted, error) : sample_direct(s, part, count, wanted, error);
}
