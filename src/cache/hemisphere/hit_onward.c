/* Light of further bounces where records do not tell it: at hits that are nearer to the point than records
 * lie apart, as in corners and under edges, and at those that none reaches. From one in four of them a ray
 * goes on, in proportion to the cosine, into a slot of its own, and what arrives by it counts for four: as
 * final gathers ask the surfaces near by (Jensen 1996), since what these receive is as fine as the gather's
 * own picture. */
#include "cache/hemisphere/hit_light.h"

#include "base/memory.h"
#include "base/random.h"
#include "trace/bsdf.h"

enum { ONE_IN = 4 };

/* Some more: the golden ratio spreads them not quite evenly. */
size_t sl_onward_most(size_t slots) { return slots / ONE_IN + 16; }

bool sl_onward_allocate(size_t slots, sl_onward *o) {
    const size_t most = sl_onward_most(slots);
    o->missed = sl_allocate(slots + most, sizeof *o->missed);
    o->told = sl_allocate(slots + most, sizeof *o->told);
    o->from = sl_allocate(slots, sizeof *o->from);
    o->carried = sl_allocate(most, sizeof *o->carried);
    return o->missed && o->told && o->from && o->carried;
}

void sl_onward_free(sl_onward *o) { SL_FREE_ALL(o->missed, o->told, o->from, o->carried); }

static bool is_near(const sl_gather_view *view, size_t k) {
    const sl_vec3 way = sl_sub(sl_hit_position(&view->scratch->hits, k), view->eye);
    const float reach = view->gather->settings.onward_reach;
    return sl_dot(way, way) < reach * reach;
}

void sl_gather_mark_onward(const sl_gather_view *view, size_t first, size_t count) {
    sl_onward *o = &view->scratch->onward;
    const sl_gather_hits *h = &view->scratch->hits;
    for (size_t k = first; k < first + count; k++) {
        o->told[k] = 0.0f;
        if (!sl_hit_reflects(view, k) || !(o->missed[k] || is_near(view, k))) continue;
        o->from[o->count++] = (uint32_t)k;
        o->told[k] = h->diffuse_r[k] * h->irradiance_r[k] + h->diffuse_g[k] * h->irradiance_g[k] +
                     h->diffuse_b[k] * h->irradiance_b[k];
        h->irradiance_r[k] = h->irradiance_g[k] = h->irradiance_b[k] = 0.0f;
    }
}

/* Keeps one of them in four, spread by the golden ratio: in step with the rows of a picture they would be the
 * same few columns of it. */
static void thin_out(sl_onward *o, size_t most, uint32_t start) {
    size_t kept = 0;
    for (size_t i = 0; i < o->count && kept < most; i++, start += 2654435769u)
        if (start < UINT32_MAX / ONE_IN) o->from[kept++] = o->from[i];
    o->count = kept;
}

/* Slot i of those that go on: its cell is that of the slot it comes from. */
static void open_slot(const sl_gather_view *view, size_t i) {
    sl_gather_scratch *s = view->scratch;
    const sl_gather_hits *h = &s->hits;
    const size_t from = s->onward.from[i], to = s->onward.first + i;
    const sl_rgb diffuse = sl_hit_diffuse(h, from);
    s->slot_cell[to] = s->slot_cell[from];
    s->slot_share[to] = s->slot_share[from] * (float)ONE_IN;
    s->onward.carried[i] = view->gather->glossy ? sl_rgb_add(diffuse, sl_gather_lobe(view, from)) : diffuse;
}

/* Below the true surface nothing is met: the ray has no length there. */
static void aim(const sl_gather_view *view, size_t i, float u1, float u2, sl_ray16 *rays, unsigned ray) {
    const sl_onward *o = &view->scratch->onward;
    const sl_gather_hits *h = &view->scratch->hits;
    const size_t from = o->from[i], to = o->first + i;
    const sl_vec3 p = sl_hit_position(h, from), true_normal = sl_hit_true_normal(h, from),
                  d = sl_direction_around(sl_hit_normal(h, from), sqrtf(1.0f - u1), u2);
    const float offset = sl_scene_offset_at(view->gather->scene, view->gather->offset, p);
    sl_put(h->direction_x, h->direction_y, h->direction_z, to, d);
    sl_ray16_set(rays, ray, sl_mad(p, offset, true_normal), d, 0.0f,
                 sl_dot(d, true_normal) > 0.0f ? INFINITY : 0.0f, h->triangle[from]);
}

void sl_gather_go_on(const sl_gather_view *view, sl_counters *counters) {
    sl_gather_scratch *s = view->scratch;
    sl_onward *o = &s->onward;
    const uint64_t key = sl_random_key(view->point->key, 3);
    /* Steps of the R2 sequence: 1/g and 1/g^2, g^3 = g + 1, as fractions of 2^32. */
    uint32_t u1 = sl_random_bits(key, 0), u2 = sl_random_bits(key, 1);
    thin_out(o, sl_onward_most(s->slots), sl_random_bits(key, 2));
    o->first = s->slots;
    s->slots += o->count;
    for (size_t first = 0; first < o->count; first += SL_PACKET) {
        const unsigned left = o->count - first < SL_PACKET ? (unsigned)(o->count - first) : SL_PACKET;
        sl_ray16 rays;
        for (unsigned ray = 0; ray < left; ray++, u1 += 3242174889u, u2 += 2447445414u) {
            open_slot(view, first + ray);
            aim(view, first + ray, sl_unit_of_bits(u1), sl_unit_of_bits(u2), &rays, ray);
        }
        sl_gather_trace_packet(view, o->first + first, left, &rays, false, counters);
    }
}

void sl_gather_put_onward(const sl_gather_view *view, size_t first, size_t count) {
    const sl_onward *o = &view->scratch->onward;
    const sl_gather_hits *h = &view->scratch->hits;
    for (size_t k = first; k < first + count; k++) {
        const size_t from = o->from[k - o->first];
        sl_put(h->position_x, h->position_y, h->position_z, k,
               sl_mad(sl_hit_position(h, from), h->depth[k], sl_hit_direction(h, k)));
        sl_rgb_put(h->diffuse_r, h->diffuse_g, h->diffuse_b, k,
                   sl_rgb_mul(sl_hit_diffuse(h, k), o->carried[k - o->first]));
    }
}
