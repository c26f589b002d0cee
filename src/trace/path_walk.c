/* A walk leaves the eye, follows mirrors to x1, and from there bounces from surface to surface. At every
 * surface light is counted twice over, by a sample of the lights and by where the next direction leads, each
 * weighted by the power heuristic (Veach and Guibas 1995) so that together they count once. Sixteen walks go
 * in step, so that their rays go in packets. */
#include "trace/path_walk.h"

#include <math.h>

#include "base/counters.h"
#include "base/random.h"
#include "trace/bsdf.h"

enum { ROULETTE_AFTER = 4 }; /* surfaces, in unlimited transport */

/* Light samples that wait for their shadow rays. */
typedef struct shadow_queue {
    sl_ray16 rays;
    sl_rgb light[SL_PACKET];
    sl_walker *owner[SL_PACKET];
    unsigned count;
} shadow_queue;

/* w = p^2 / (p^2 + q^2), computed by the ratio so that nothing overflows. */
static float power_heuristic(float p, float q) {
    if (!(p > 0.0f)) return 0.0f;
    float ratio = q / p;
    return 1.0f / (1.0f + ratio * ratio);
}

/* ---- light that the ray under way meets ------------------------------------------------------ */

/* triangle: the emitter's, or SL_NO_INDEX for the environment. */
static void meet_light(const sl_path_walk *walk, sl_walker *w, sl_rgb emitted, uint32_t triangle, float t) {
    if (sl_rgb_is_black(emitted)) return;
    sl_rgb weight = w->weight;
    if (!w->at_surface) {
        if (!walk->transport.emission) return; /* L S* E */
    } else if (triangle == SL_NO_INDEX && !walk->transport.sky_light) {
        return;
    } else if (!w->mirror_since) {
        /* Direct light of the last surface, which its light sample counts too. */
        if (sl_rgb_is_black(w->direct_weight)) return;
        float other = sl_light_sampler_pdf(walk->lights, w->origin, w->direction, triangle, t);
        weight = sl_rgb_scale(w->direct_weight, power_heuristic((float)w->pdf, other));
    } /* else: light by mirrors, which no light sample finds */
    w->radiance = sl_rgb_add(w->radiance, sl_rgb_mul(weight, emitted));
}

/* ---- leaving a vertex ------------------------------------------------------------------------ */

static bool follow_mirror(const sl_path_walk *walk, sl_walker *w, const sl_surface *s, sl_vec3 to_viewer,
                          uint32_t triangle) {
    const sl_transport *t = &walk->transport;
    if (w->at_surface ? !(t->bounce_lobes & SL_LOBE_MIRROR) : !t->eye_mirrors) return false;
    w->weight = sl_rgb_mul(w->weight, s->material->mirror);
    if (sl_rgb_is_black(w->weight)) return false;
    if (++w->mirrors > SL_ROULETTE_AFTER_MIRRORS && !sl_walker_survives(walk->sequence, w)) return false;
    sl_vec3 direction = sl_normalize_or(sl_reflect(to_viewer, s->normal), s->normal);
    if (!(sl_dot(direction, s->geometric_normal) > 0.0f)) return false;
    w->mirror_since = true;
    sl_walker_leave(w, sl_surface_lift(walk->scene, triangle, s), direction, 1.0, triangle);
    return true;
}

/* ---- a surface ------------------------------------------------------------------------------- */

/* The transport's demands on the surface that was reached. */
typedef struct surface_task {
    unsigned direct_lobes; /* reflect direct light here */
    unsigned next_lobes;   /* reflect light of further surfaces */
    bool shadows;          /* direct light needs to be visible */
    bool met_by_chance;    /* the direction sampled may count direct light too */
} surface_task;

static surface_task task_at(const sl_path_walk *walk, const sl_walker *w) {
    const sl_transport *t = &walk->transport;
    bool first = w->surfaces == 0, mirrors = t->bounce_lobes & SL_LOBE_MIRROR;
    unsigned reflecting = SL_LOBE_DIFFUSE | SL_LOBE_GLOSSY;
    surface_task task;
    task.direct_lobes = reflecting & (first ? t->direct_lobes : t->bounce_lobes);
    task.next_lobes =
        w->surfaces < t->bounces || mirrors ? reflecting & (first ? t->receiver_lobes : t->bounce_lobes) : 0;
    task.shadows = first ? t->direct_visibility : true;
    bool lights_with_extent =
        walk->scene->emitter_count > 0 || (walk->scene->environment.present && t->sky_light);
    task.met_by_chance =
        lights_with_extent && task.direct_lobes && (!first || (t->direct_visibility && t->bounce_visibility));
    return task;
}

static void queue_shadow_ray(shadow_queue *q, sl_walker *w, sl_vec3 origin, const sl_light_sample *sample,
                             uint32_t triangle, sl_rgb light) {
    unsigned i = q->count++;
    sl_ray16 *r = &q->rays;
    /* the light's own surface does not hide it */
    sl_ray16_set(r, i, origin, sample->to_light, 0.0f, sample->distance * (1.0f - 1e-4f),
                 sample->triangle != SL_NO_INDEX ? sample->triangle : triangle);
    q->light[i] = light;
    q->owner[i] = w;
}

static void sample_light(const sl_path_walk *walk, sl_walker *w, const sl_bsdf *bsdf,
                         const surface_task *task, sl_vec3 origin, uint32_t triangle, shadow_queue *queue) {
    float point[3];
    sl_light_sample sample;
    sl_walker_draw(walk->sequence, w, SL_SET_LIGHT, point);
    if (!sl_light_sampler_sample_2d(walk->lights, origin, point[0], point[1], &sample)) return;
    sl_rgb reflected = sl_bsdf_reflect(bsdf, sample.to_light, task->direct_lobes);
    if (sl_rgb_is_black(reflected)) return;
    float share = 1.0f;
    if (task->met_by_chance && sample.pdf > 0.0f)
        share = power_heuristic(sample.pdf, sl_bsdf_pdf(bsdf, sample.to_light));
    sl_rgb light = sl_rgb_scale(sl_rgb_mul(w->weight, sl_rgb_mul(reflected, sample.radiance)), share);
    if (task->shadows) queue_shadow_ray(queue, w, origin, &sample, triangle, light);
    else w->radiance = sl_rgb_add(w->radiance, light);
}

/* The next direction; false where the walk ends. */
static bool bounce(const sl_path_walk *walk, sl_walker *w, const sl_bsdf *bsdf, const surface_task *task,
                   sl_vec3 origin, uint32_t triangle) {
    float point[3];
    sl_vec3 direction;
    sl_walker_draw(walk->sequence, w, SL_SET_DIRECTION, point);
    if (!sl_bsdf_sample(bsdf, point[2], point[0], point[1], &direction)) return false;
    float pdf = sl_bsdf_pdf(bsdf, direction);
    if (!(pdf > 0.0f)) return false;
    sl_rgb weight = sl_rgb_scale(w->weight, 1.0f / pdf);
    w->direct_weight =
        sl_rgb_mul(weight, sl_bsdf_reflect(bsdf, direction, task->met_by_chance ? task->direct_lobes : 0));
    w->weight = sl_rgb_mul(weight, sl_bsdf_reflect(bsdf, direction, task->next_lobes));
    if (sl_rgb_is_black(w->weight) && sl_rgb_is_black(w->direct_weight)) return false;
    if (walk->transport.bounces == SL_BOUNCES_UNLIMITED && w->surfaces >= ROULETTE_AFTER &&
        !sl_walker_survives(walk->sequence, w))
        return false;
    w->through = w->surfaces == 0 && !walk->transport.bounce_visibility;
    w->at_surface = true;
    w->mirror_since = false;
    w->mirrors = 0;
    sl_walker_leave(w, origin, direction, (double)pdf, triangle);
    return true;
}

static bool reach_surface(const sl_path_walk *walk, sl_walker *w, const sl_surface *s, sl_vec3 to_viewer,
                          uint32_t triangle, shadow_queue *queue) {
    if (w->at_surface) {
        if (w->surfaces == walk->transport.bounces || sl_rgb_is_black(w->weight)) return false;
        w->surfaces++;
    }
    surface_task task = task_at(walk, w);
    unsigned sampled = task.next_lobes | (task.met_by_chance ? task.direct_lobes : 0);
    sl_bsdf bsdf = sl_bsdf_make(s, to_viewer, sampled);
    sl_vec3 origin = sl_surface_lift(walk->scene, triangle, s);
    if (task.direct_lobes) sample_light(walk, w, &bsdf, &task, origin, triangle, queue);
    return !bsdf.black && bounce(walk, w, &bsdf, &task, origin, triangle);
}

/* The end of the ray under way; false where the walk ends with it. */
static bool arrive(const sl_path_walk *walk, sl_walker *w, uint32_t triangle, float t, float w1, float w2,
                   shadow_queue *queue) {
    const sl_scene *scene = walk->scene;
    sl_vec3 direction = sl_normalize_or(w->direction, sl_v3(0.0f, 0.0f, 1.0f));
    if (triangle == SL_NO_INDEX) {
        if (isinf(w->far))
            meet_light(walk, w, sl_environment_radiance(&scene->environment, direction), SL_NO_INDEX,
                       INFINITY);
        return false;
    }
    sl_vec3 to_viewer = sl_neg(direction);
    sl_surface surface;
    sl_scene_surface(scene, triangle, w1, w2, to_viewer, &surface);
    uint32_t emitter = scene->emitter_of_triangle[triangle];
    if (emitter != SL_NO_INDEX && (surface.front || scene->emitters[emitter].two_sided))
        meet_light(walk, w, scene->emitters[emitter].radiance, triangle, t);
    if (sl_material_is_mirror(surface.material)) return follow_mirror(walk, w, &surface, to_viewer, triangle);
    return reach_surface(walk, w, &surface, to_viewer, triangle, queue);
}

/* ---- packets --------------------------------------------------------------------------------- */

static void add_light(const sl_path_walk *walk, shadow_queue *queue, bool coherent, sl_counters *counters) {
    if (queue->count == 0) return;
    uint32_t hidden = sl_trace_occluded(walk->tracer, &queue->rays, queue->count, coherent, counters);
    for (unsigned i = 0; i < queue->count; i++) {
        if (hidden >> i & 1) continue;
        queue->owner[i]->radiance = sl_rgb_add(queue->owner[i]->radiance, queue->light[i]);
    }
    queue->count = 0;
}

void sl_path_walk_radiance(const sl_path_walk *walk, const sl_ray16 *rays, unsigned count, bool coherent,
                           const uint64_t key[SL_PACKET], uint32_t index, sl_rgb radiance[SL_PACKET],
                           sl_counters *counters) {
    sl_walker walkers[SL_PACKET], *active[SL_PACKET];
    shadow_queue queue;
    queue.count = 0;
    for (unsigned i = 0; i < count; i++) {
        walkers[i] = (sl_walker){.weight = {1.0f, 1.0f, 1.0f},
                                 .roulette_scale = 1.0f,
                                 .key = key[i],
                                 .index = index,
                                 .near = rays->near[i],
                                 .far = rays->far[i],
                                 .skip = rays->skip[i]};
        walkers[i].origin = sl_v3(rays->origin_x[i], rays->origin_y[i], rays->origin_z[i]);
        walkers[i].direction = sl_v3(rays->direction_x[i], rays->direction_y[i], rays->direction_z[i]);
        active[i] = &walkers[i];
    }
    for (unsigned alive = count; alive > 0;) {
        sl_hit16 hits;
        sl_walkers_trace(walk->tracer, walk->sequence, active, alive, coherent, &hits, counters);
        unsigned left = 0;
        for (unsigned i = 0; i < alive; i++) {
            sl_walker *w = active[i];
            if (arrive(walk, w, hits.triangle[i], hits.t[i], hits.w1[i], hits.w2[i], &queue))
                active[left++] = w;
        }
        add_light(walk, &queue, coherent, counters);
        alive = left;
        coherent = false;
    }
    for (unsigned i = 0; i < count; i++) radiance[i] = walkers[i].radiance;
}

/* ---- the rays with which walks begin ---- */

void sl_path_lens_ray(const sl_scene *scene, const sl_path_lens *lens, sl_path_place place, sl_ray16 *rays,
                      unsigned i) {
    sl_vec3 direction = sl_path_lens_direction(scene, sl_path_lens_tangents(lens, place));
    sl_ray16_set(rays, i, scene->camera.eye, direction, 0.0f, INFINITY, SL_NO_INDEX);
}

sl_path_place sl_path_place_in(const sl_path_walk *walk, int x, int y, uint64_t key, uint32_t index) {
    float point[3] = {0.5f, 0.5f, 0.0f};
    if (walk->transport.filter != SL_FILTER_CENTRE)
        sl_sequence_point(walk->sequence, key, SL_SET_PIXEL, index, point);
    sl_pixel_shape_place(&walk->shape, point);
    return (sl_path_place){(float)x + point[0], (float)y + point[1]};
}

sl_rgb sl_path_finite_or_black(sl_rgb radiance, sl_counters *counters) {
    if (sl_rgb_is_finite(radiance)) return radiance;
    sl_count(counters, SL_COUNT_NONFINITE, 1);
    return sl_grey(0.0f);
}

/* ---- lamps that the eye sees ---- */

sl_path_lamps sl_path_lamps_of(const sl_path_walk *walk) {
    sl_path_lamps l = {*walk, *walk};
    l.lamps.transport = (sl_transport){.emission = true, .eye_mirrors = walk->transport.eye_mirrors};
    l.rest.transport.emission = false;
    return l;
}

static sl_path_lamp_view view_of(const sl_rgb seen[SL_PACKET], sl_counters *counters) {
    sl_path_lamp_view view = {sl_grey(0.0f), INFINITY, 0.0f};
    for (unsigned i = 0; i < SL_PACKET; i++) {
        const sl_rgb light = sl_path_finite_or_black(seen[i], counters);
        view.low = fminf(view.low, sl_luminance(light));
        view.high = fmaxf(view.high, sl_luminance(light));
        view.mean = sl_rgb_add(view.mean, sl_rgb_scale(light, 1.0f / SL_PACKET));
    }
    return view;
}

sl_path_lamp_view sl_path_see_lamps(const sl_path_walk *walk, const sl_path_lens *lens, int x, int y,
                                    float side, uint64_t key, uint32_t index, sl_counters *counters) {
    const uint64_t places = sl_hash64(key);
    uint64_t keys[SL_PACKET];
    sl_ray16 rays;
    sl_rgb seen[SL_PACKET];
    for (unsigned i = 0; i < SL_PACKET; i++) {
        const sl_path_place in = sl_path_place_in(walk, 0, 0, places, index * SL_PACKET + i);
        const sl_path_place at = {(float)x + side * in.x, (float)y + side * in.y};
        sl_path_lens_ray(walk->scene, lens, at, &rays, i);
        keys[i] = sl_random_key(places, i);
    }
    sl_path_walk_radiance(walk, &rays, SL_PACKET, true, keys, index, seen, counters);
    return view_of(seen, counters);
}
