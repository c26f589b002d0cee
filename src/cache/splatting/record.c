#include "cache/splatting/record.h"

#include "base/math.h"

static float translational_length(const sl_record *r) { /* |grad_t Y|, Y the mean of the channels */
    sl_vec3 sum = sl_add(sl_add(r->translational[0], r->translational[1]), r->translational[2]);
    return sl_length(sum) * (1.0f / 3.0f);
}

/* Rule 1: E + delta . grad_t E stays positive within R. Not for Y = 0, where there is no relative change to speak of. */
static double positive_radius(const sl_record *r, double radius) {
    double mean = (double)sl_rgb_mean(r->irradiance), slope = (double)translational_length(r);
    return mean > 0.0 && slope * radius > mean ? mean / slope : radius;
}

/* Rule 2: aR does not reach past a wall that the record sees. r / cos theta' is the distance to the hit's plane divided by
 * cos^2, so concave surfaces are not punished. The lowest ray of a plane gather meets a wall at distance d with
 * r / cos theta' = d (1 + t^2) / t^2. */
static double guard_limit(const sl_irradiance *irradiance, const sl_radius_rules *rules) {
    double t_squared = rules->plane_tangent * rules->plane_tangent;
    double lowest = rules->gather == SL_GATHER_PLANE ? t_squared / (1.0 + t_squared) : 1.0;
    return rules->guard ? lowest * (double)irradiance->nearest / rules->accuracy : INFINITY;
}

sl_record sl_record_make(const sl_gather_point *point, const sl_irradiance *irradiance, const sl_radius_rules *rules,
                         float footprint) {
    sl_record r = {.position = point->position, .normal = point->normal, .irradiance = irradiance->value,
                   .triangle = point->triangle};
    for (int c = 0; c < 3; c++) {
        r.rotational[c] = irradiance->rotational[c];
        r.translational[c] = irradiance->translational[c];
        r.rotational_length[c] = sl_length(r.rotational[c]);
    }
    double maximum = rules->maximum_radius / rules->accuracy;
    double reach = rules->minimum_pixels > 0.0 ? rules->minimum_pixels * (double)footprint : rules->minimum_reach;
    double minimum = reach / rules->accuracy;
    if (minimum > maximum) minimum = maximum;
    double radius = (double)irradiance->harmonic_mean;
    if (!(radius <= maximum)) radius = maximum; /* sees nothing, or an infinite mean */
    radius = positive_radius(&r, radius);
    double limit = guard_limit(irradiance, rules);
    if (limit < radius) radius = limit;
    if (!(radius > minimum)) radius = minimum;
    r.behind_a_wall = radius > limit;
    r.minimum_radius = (float)minimum;
    r.own_radius = (float)radius;
    sl_record_set_radius(&r, r.own_radius);
    return r;
}

void sl_record_set_radius(sl_record *record, float radius) {
    record->radius = radius;
    float mean = sl_rgb_mean(record->irradiance), change = translational_length(record) * radius;
    if (change <= mean || !(change > 0.0f)) return;
    for (int c = 0; c < 3; c++) record->translational[c] = sl_scale(record->translational[c], mean / change);
}

void sl_record_limit_radius(sl_record *record, double limit) {
    if (!(limit < (double)record->own_radius)) return;
    record->own_radius = limit > (double)record->minimum_radius ? (float)limit : record->minimum_radius;
    sl_record_set_radius(record, record->own_radius);
}

float sl_record_clamped_radius(const sl_reach_tree *reaches, const sl_record *record) {
    float radius = sl_reach_tree_limit(reaches, record->position, record->own_radius);
    return radius > record->minimum_radius ? radius : record->minimum_radius;
}
