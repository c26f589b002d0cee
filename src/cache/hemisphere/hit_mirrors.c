/* Follows the rays of a gather that meet mirrors. Their slots then hold what is seen in the mirror; lamps and
 * sky are seen there, too, since nothing else accounts for light that mirrors throw on surfaces. How far
 * away the slot's surface is stays the mirror's own distance: that is what moves with the point. */
#include "cache/hemisphere/hit_light.h"

#include "trace/bsdf.h"

static bool is_mirror(const sl_gather_view *view, size_t k) {
    return view->scratch->hits.triangle[k] != SL_NO_INDEX && sl_material_is_mirror(sl_hit_material(view, k));
}

/* Sends on the ray that met a mirror at slot k. */
static void reflect(const sl_gather_view *view, size_t k, sl_ray16 *rays, unsigned ray) {
    const sl_scene *scene = view->gather->scene;
    const sl_gather_hits *h = &view->scratch->hits;
    sl_mirrored_hit *m = &view->scratch->mirrored[k];
    const sl_vec3 d = sl_hit_direction(h, k);
    sl_surface surface;
    sl_scene_surface(scene, h->triangle[k], h->w1[k], h->w2[k], sl_neg(d), &surface);
    const sl_vec3 out = sl_normalize_or(sl_reflect_off(d, surface.normal, surface.geometric_normal),
                                        surface.geometric_normal);
    if (!m->any)
        *m = (sl_mirrored_hit){true, -sl_dot(d, surface.geometric_normal), surface.front ? 0.0f : 1.0f,
                               sl_grey(1.0f), surface.position};
    m->share = sl_rgb_mul(m->share, surface.material->mirror);
    m->position = sl_surface_lift(scene, h->triangle[k], &surface);
    sl_put(h->direction_x, h->direction_y, h->direction_z, k, out);
    sl_ray16_set(rays, ray, m->position, out, 0.0f, INFINITY, h->triangle[k]);
}

static void note_hit(const sl_gather_view *view, size_t k, const sl_hit16 *hits, unsigned ray) {
    const sl_gather_hits *h = &view->scratch->hits;
    sl_mirrored_hit *m = &view->scratch->mirrored[k];
    h->triangle[k] = hits->triangle[ray];
    h->w1[k] = hits->w1[ray];
    h->w2[k] = hits->w2[ray];
    if (hits->triangle[ray] != SL_NO_INDEX)
        m->position = sl_mad(m->position, hits->t[ray], sl_hit_direction(h, k));
}

/* Follows up to sixteen rays until none shows a mirror; between two that face each other some end black. */
static void follow(const sl_gather_view *view, size_t slot[SL_PACKET], unsigned count,
                   sl_counters *counters) {
    for (int reflections = 0; count > 0; reflections++) {
        unsigned left = 0;
        sl_ray16 rays;
        sl_hit16 hits;
        for (unsigned i = 0; i < count; i++) reflect(view, slot[i], &rays, i);
        sl_trace(view->gather->tracer, &rays, count, false, &hits, counters);
        for (unsigned i = 0; i < count; i++) {
            note_hit(view, slot[i], &hits, i);
            if (!is_mirror(view, slot[i])) continue;
            if (reflections + 1 < SL_REFLECTIONS_MAX) slot[left++] = slot[i];
            else view->scratch->mirrored[slot[i]].share = sl_grey(0.0f);
        }
        count = left;
    }
}

void sl_gather_follow_mirrors(const sl_gather_view *view, size_t first, size_t count, sl_counters *counters) {
    size_t slot[SL_PACKET];
    unsigned waiting = 0;
    for (size_t k = first; k < first + count; k++) {
        view->scratch->mirrored[k].any = false;
        if (is_mirror(view, k)) slot[waiting++] = k;
        if (waiting < SL_PACKET) continue;
        follow(view, slot, waiting, counters);
        waiting = 0;
    }
    follow(view, slot, waiting, counters);
}
