/* Where gathers will look. A coarse picture through the camera gives points that the eye sees; a few rays
 * from each give points that gathers there see; and so on from the records that those have got. */
#include "cache/bounces/second_level.h"

#include <string.h>

#include "base/batch.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/random.h"
#include "cache/hemisphere/gather_tables.h"

enum { RAYS_A_SIDE = 8, RAYS = SL_PROBE_RAYS };
_Static_assert(RAYS == RAYS_A_SIDE * RAYS_A_SIDE, "cells of a square");

void sl_probed_free(sl_probed *probed) {
    sl_free(probed->points);
    *probed = (sl_probed){0};
}

static sl_status make_room(size_t count, sl_probed *seen, sl_error *error) {
    *seen = (sl_probed){sl_allocate(count, sizeof *seen->points), count};
    return seen->points ? SL_OK : sl_fail_memory(error, "places for second-level records");
}

/* Turns what sixteen rays meet into points to gather at. */
static void look(const sl_scene *scene, const sl_tracer *tracer, const sl_ray16 *rays, unsigned count,
                 bool glossy, uint64_t key, sl_gather_point *seen, sl_counters *counters) {
    sl_hit16 hits;
    sl_trace(tracer, rays, count, true, &hits, counters);
    for (unsigned i = 0; i < count; i++) {
        sl_surface s;
        seen[i] = (sl_gather_point){.triangle = SL_NO_INDEX};
        if (hits.triangle[i] == SL_NO_INDEX) continue;
        sl_vec3 back = sl_v3(-rays->direction_x[i], -rays->direction_y[i], -rays->direction_z[i]);
        sl_scene_surface(scene, hits.triangle[i], hits.w1[i], hits.w2[i], back, &s);
        bool reflects = sl_rgb_max(s.diffuse) > 0.0f || (glossy && sl_material_is_glossy(s.material));
        if (!reflects || !sl_is_finite(s.position) || !sl_is_finite(s.normal)) continue;
        seen[i] = (sl_gather_point){.position = s.position,
                                    .geometric_normal = s.geometric_normal,
                                    .normal = s.normal,
                                    .triangle = hits.triangle[i],
                                    .key = sl_random_key(key, i)};
    }
}

/* ---- from points ---- */

typedef struct {
    const sl_scene *scene;
    const sl_tracer *tracer;
    const sl_gather_point *origins;
    size_t count, used;
    uint64_t key;
} probe_context;

static void probe_one(void *context, size_t index, unsigned worker, void *result, sl_counters *counters) {
    const probe_context *c = context;
    const sl_gather_point *origin = &c->origins[(size_t)((uint64_t)index * c->count / c->used)];
    (void)worker;
    sl_gather_point *seen = result;
    for (unsigned i = 0; i < RAYS; i++) seen[i] = (sl_gather_point){.triangle = SL_NO_INDEX};
    if (origin->triangle == SL_NO_INDEX) return;
    uint64_t key = sl_random_key(c->key, index);
    sl_frame frame = sl_frame_from_normal(origin->normal);
    float offset = sl_scene_offset_at(c->scene, 1e-5f * c->scene->scale, origin->position);
    sl_vec3 eye = sl_mad(origin->position, offset, origin->geometric_normal);
    for (unsigned first = 0; first < RAYS; first += SL_PACKET) {
        sl_ray16 rays;
        memset(&rays, 0, sizeof rays);
        for (unsigned i = 0; i < SL_PACKET; i++) { /* cells of the concentric map, jittered */
            unsigned cell = first + i, row = cell / RAYS_A_SIDE, column = cell % RAYS_A_SIDE;
            double a = ((double)column + (double)sl_random_unit(key, 2 * cell)) * (2.0 / RAYS_A_SIDE) - 1.0,
                   x, y;
            double b = ((double)row + (double)sl_random_unit(key, 2 * cell + 1)) * (2.0 / RAYS_A_SIDE) - 1.0;
            sl_concentric_disc(a, b, &x, &y);
            double z = sqrt(fmax(0.0, 1.0 - x * x - y * y));
            sl_ray16_set(&rays, i, eye, sl_frame_to_world(&frame, sl_v3((float)x, (float)y, (float)z)), 0.0f,
                         INFINITY, origin->triangle);
        }
        look(c->scene, c->tracer, &rays, SL_PACKET, false, sl_random_key(key, 1000 + first), seen + first,
             counters);
    }
}

sl_status sl_probe_from(const sl_scene *scene, const sl_tracer *tracer, const sl_second_settings *settings,
                        const sl_gather_point *origins, size_t count, size_t most, uint64_t generation,
                        sl_probed *seen, sl_counters *counters, sl_error *error) {
    size_t used = count < most ? count : most;
    sl_status status = make_room(used * RAYS, seen, error);
    if (status != SL_OK) return status;
    uint64_t key = sl_random_key(settings->seed, 0x73636f7574u + generation);
    probe_context context = {scene, tracer, origins, count, used, key};
    const sl_batch batch = {.count = used, .work = probe_one, .context = &context, .results = seen->points,
                            .result_bytes = RAYS * sizeof *seen->points, .shared = true};
    sl_batch_run(&batch, settings->threads, counters);
    return SL_OK;
}

/* ---- from the camera ---- */

sl_status sl_probe_camera(const sl_scene *scene, const sl_tracer *tracer, const sl_second_settings *settings,
                          unsigned points, sl_probed *seen, sl_counters *counters, sl_error *error) {
    const sl_camera *camera = &scene->camera;
    double tall = sqrt((double)points / (double)settings->aspect);
    unsigned rows = tall > 1.0 ? (unsigned)tall : 1u, columns = points > rows ? points / rows : 1u;
    float top = (float)sl_tan(0.5 * (double)camera->vertical_fov), right = top * settings->aspect;
    sl_status status = make_room((size_t)rows * columns, seen, error);
    for (size_t first = 0; status == SL_OK && first < seen->count; first += SL_PACKET) {
        unsigned count =
            seen->count - first < SL_PACKET ? (unsigned)(seen->count - first) : (unsigned)SL_PACKET;
        sl_ray16 rays;
        memset(&rays, 0, sizeof rays);
        for (unsigned i = 0; i < count; i++) {
            float x = right * (2.0f * ((float)((first + i) % columns) + 0.5f) / (float)columns - 1.0f);
            float y = top * (2.0f * ((float)((first + i) / columns) + 0.5f) / (float)rows - 1.0f);
            sl_vec3 direction = sl_mad(sl_mad(sl_neg(camera->back), x, camera->right), y, camera->up);
            sl_ray16_set(&rays, i, camera->eye, direction, 1e-5f * scene->scale, INFINITY, SL_NO_INDEX);
        }
        look(scene, tracer, &rays, count, true, sl_random_key(settings->seed, first), seen->points + first,
             counters);
    }
    return status;
}
