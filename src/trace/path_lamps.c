#include "trace/path_lamps.h"

#include <math.h>

#include "base/random.h"

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
