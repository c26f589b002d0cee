/* Irradiance at many points at once. The few that no second-level record covers receive none by way of them:
 * beyond their reach records promise nothing. */
#include "cache/bounces/second_level.h"

#include "base/counters.h"

sl_look_up_kernel *sl_look_up_kernel_for(sl_isa isa) { return SL_KERNEL_OF(isa, sl_look_up); }

float sl_second_weight(const sl_second_field *field, sl_look_up_kernel *kernel, const sl_gather_point *p) {
    const sl_second_points one = {1, &p->triangle, &p->position.x, &p->position.y, &p->position.z,
                                  &p->normal.x, &p->normal.y, &p->normal.z};
    sl_second_sums sums;
    kernel(field, &one, 0, 1, true, &sums);
    return sums.weight[0];
}

float sl_share_out_of_reach(const sl_second_field *field, sl_look_up_kernel *kernel,
                            const sl_probed *points) {
    size_t asked = 0, missed = 0;
    for (size_t i = 0; i < points->count; i++) {
        if (points->points[i].triangle == SL_NO_INDEX) continue;
        asked++;
        if (!(sl_second_weight(field, kernel, &points->points[i]) > 0.0f)) missed++;
    }
    return asked ? (float)missed / (float)asked : 0.0f;
}

void sl_second_look_up(const sl_second_field *field, sl_look_up_kernel *kernel,
                       const sl_second_points *points, float *r, float *g, float *b, sl_counters *counters) {
    sl_second_sums sums;
    uint64_t looked_up = 0, missed = 0;
    for (size_t first = 0; first < points->count; first += SL_LOOK_UP_MAX) {
        size_t left = points->count - first, count = left < SL_LOOK_UP_MAX ? left : (size_t)SL_LOOK_UP_MAX;
        kernel(field, points, first, count, false, &sums);
        for (size_t i = 0; i < count; i++) {
            if (points->triangle[first + i] == SL_NO_INDEX) continue;
            looked_up++;
            if (!(sums.weight[i] > 0.0f)) {
                missed++;
                continue;
            }
            const float scale = 1.0f / sums.weight[i];
            r[first + i] += sums.r[i] * scale;
            g[first + i] += sums.g[i] * scale;
            b[first + i] += sums.b[i] * scale;
        }
    }
    sl_count(counters, SL_COUNT_SECOND_LEVEL_LOOK_UPS, looked_up);
    sl_count(counters, SL_COUNT_SECOND_LEVEL_MISSES, missed);
}
