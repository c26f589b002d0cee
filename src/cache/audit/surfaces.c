/* A lamp that is seen is hundreds of times as bright as what it lights, and any method shows it as it is: in
 * the mean that errors are relative to it would hide the surfaces. */
#include "base/parallel.h"
#include "cache/audit/trace_probes.h"

typedef struct looking {
    const sl_path_walk *walk;
    const sl_path_lens *lens;
    sl_image *surfaces;
} looking;

static bool shines(const sl_scene *scene, const sl_ray16 *rays, const sl_hit16 *hits, unsigned i) {
    sl_vec3 direction = sl_v3(rays->direction_x[i], rays->direction_y[i], rays->direction_z[i]);
    uint32_t triangle = hits->triangle[i];
    if (triangle == SL_NO_INDEX)
        return sl_rgb_max(sl_environment_radiance(&scene->environment, direction)) > 0.0f;
    if (scene->emitter_of_triangle[triangle] == SL_NO_INDEX) return false;
    sl_vec3 normal = sl_scene_geometric_normal(scene, triangle);
    if (sl_dot(normal, direction) > 0.0f) normal = sl_neg(normal);
    return sl_rgb_max(sl_scene_emission(scene, triangle, normal)) > 0.0f;
}

/* Looks at a filter's square in sixteen places, its corners among them; a centre is one without extent. */
static bool square_shows_light(const looking *l, int x, int y, sl_counters *counters) {
    const float r = l->walk->shape.radius;
    sl_ray16 rays;
    sl_hit16 hits;
    for (unsigned i = 0; i < SL_PACKET; i++)
        sl_path_lens_ray(l->walk->scene, l->lens,
                         (sl_path_place){(float)x + (0.5f - r) + (float)(i % 4) / 3.0f * (2.0f * r),
                                         (float)y + (0.5f - r) + (float)(i / 4) / 3.0f * (2.0f * r)},
                         &rays, i);
    sl_trace(l->walk->tracer, &rays, SL_PACKET, true, &hits, counters);
    for (unsigned i = 0; i < SL_PACKET; i++) {
        if (shines(l->walk->scene, &rays, &hits, i)) return true;
    }
    return false;
}

static void look_at_row(void *context, size_t row, unsigned worker) {
    const looking *l = context;
    sl_counters counters = {{0}};
    float *out = l->surfaces->planes + row * (size_t)l->lens->width;
    (void)worker;
    for (int x = 0; x < l->lens->width; x++)
        out[x] = square_shows_light(l, x, (int)row, &counters) ? 0.0f : 1.0f;
}

sl_status sl_audit_surfaces(const sl_path_walk *walk, const sl_path_lens *lens, unsigned threads,
                            sl_image **surfaces, sl_error *error) {
    size_t pixels = (size_t)lens->width * (size_t)lens->height, seen = 0;
    sl_status status = sl_image_create(lens->width, lens->height, 1, NULL, surfaces, error);
    if (status != SL_OK) return status;
    looking l = {walk, lens, *surfaces};
    bool light = walk->transport.emission && (walk->scene->emitter_count || walk->scene->environment.present);
    if (light) sl_parallel_for(threads, (size_t)lens->height, look_at_row, &l);
    for (size_t i = 0; i < pixels; i++) seen += (*surfaces)->planes[i] > 0.5f;
    for (size_t i = 0; i < pixels && 100 * seen < pixels; i++) (*surfaces)->planes[i] = 1.0f;
    return SL_OK;
}
