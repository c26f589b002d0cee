/* Light that has met more than one surface before it arrives at what the gather sees. */
#include "cache/hemisphere/gather_internal.h"

void sl_gather_add_hidden_light(const sl_gather_view *view, sl_counters *counters) {
    const sl_hidden_light *hidden = view->gather->settings.hidden;
    const sl_gather_hits *h = &view->scratch->hits;
    const sl_hidden_points points = {.count = view->scratch->slots, .triangle = h->triangle,
                                     .position_x = h->position_x, .position_y = h->position_y, .position_z = h->position_z,
                                     .normal_x = h->normal_x, .normal_y = h->normal_y, .normal_z = h->normal_z};
    hidden->irradiance(hidden->context, &points, h->irradiance_r, h->irradiance_g, h->irradiance_b, counters);
}
