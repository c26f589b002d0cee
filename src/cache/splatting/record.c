#include "cache/splatting/record.h"

#include "base/math.h"

/* Squares of gradients leave what floats hold where light is very bright or very faint. */
static float length_of(sl_vec3 v) {
    float length = sl_length(v);
    return length > 1e-15f && length < 1e18f ? length : (float)sl_lengthd(sl_to_double(v));
}

static float translational_length(const sl_record *r) { /* |grad_t Y|, Y the mean of the channels */
    sl_vec3 sum = sl_add(sl_add(r->translational[0], r->translational[1]), r->translational[2]);
    return length_of(sum) * (1.0f / 3.0f);
}

/* ---- metrics ---- */

/* The footprint of a pixel; of records that must not depend on a view, a quarter of their least reach. */
static double unit_of(const sl_radius_rules *rules, double footprint) {
    return rules->minimum_pixels > 0.0 ? footprint : 0.25 * rules->minimum_reach;
}

/* Linear extrapolation errs by lambda r^2 / 2 at most, lambda the larger second derivative: over a disc, pi
 * lambda reach^4 / 4 in all (Jarosz et al. 2012). As many pixels see a piece of surface as footprints u^2 fit
 * on it, so the error that a record adds to the picture is that over Y u^2, and the same for every record
 * where reach = 6 a (2 Y u^2 / lambda)^(1/4). Larger reaches where light is even, smaller ones in corners,
 * but not in proportion: corners are small. Derivatives know only the light that the gather met. A record in
 * the dark may have missed the one door through which some comes; so none reaches further than light can be
 * trusted to stay the same: twice the harmonic mean's reach, and that itself in the dark. */
static double hessian_reach(const sl_irradiance *irradiance, const sl_radius_rules *rules, double unit) {
    double light = (double)sl_rgb_mean(irradiance->value), curvature = fabs((double)irradiance->curvature);
    double harmonic = rules->accuracy * (double)irradiance->harmonic_mean;
    if (!(light > 0.0)) return harmonic;
    double reach = curvature > 0.0 ? 6.0 * rules->accuracy * sqrt(sqrt(2.0 * light * unit * unit / curvature))
                                   : INFINITY;
    return reach < 2.0 * harmonic ? reach : 2.0 * harmonic;
}

static double metric_radius(const sl_irradiance *irradiance, const sl_radius_rules *rules, double footprint) {
    if (rules->metric != SL_METRIC_HESSIAN) return (double)irradiance->harmonic_mean;
    return hessian_reach(irradiance, rules, unit_of(rules, footprint)) / rules->accuracy;
}

/* ---- the rules of the radius (record.h has the list) ---- */

/* Rule 1. Not for Y = 0, where there is no relative change to speak of. */
static double positive_radius(const sl_record *r, double radius) {
    double mean = (double)sl_rgb_mean(r->irradiance),
           slope = (double)translational_length(r) / (double)r->stretch;
    return mean > 0.0 && slope * radius > mean ? mean / slope : radius;
}

/* a R_min of rule 3. Within a footprint or two light can fall off so steeply that no extrapolation follows
 * it. */
static double least_reach(const sl_record *r, const sl_radius_rules *rules, double footprint) {
    double reach = rules->minimum_pixels > 0.0 ? rules->minimum_pixels * footprint : rules->minimum_reach;
    double change = (double)translational_length(r) * reach, mean = (double)sl_rgb_mean(r->irradiance);
    return rules->steep > 0.0 && change > rules->steep * mean ? 0.5 * reach : reach;
}

/* Rule 2: a R does not reach past a wall that the record sees. r / cos theta' is the distance to the hit's
 * plane divided by cos^2, so concave surfaces are not punished. The lowest ray of a plane gather meets a wall
 * at distance d with r / cos theta' = d (1 + t^2) / t^2. */
double sl_record_guard(const sl_irradiance *irradiance, const sl_radius_rules *rules) {
    double t_squared = rules->plane_tangent * rules->plane_tangent;
    double lowest = rules->gather == SL_GATHER_PLANE ? t_squared / (1.0 + t_squared) : 1.0;
    return rules->guard ? lowest * (double)irradiance->nearest / rules->accuracy : INFINITY;
}

sl_record sl_record_make(const sl_gather_point *point, const sl_irradiance *irradiance,
                         const sl_radius_rules *rules, float footprint) {
    sl_record r = {.position = point->position, .normal = point->normal, .irradiance = irradiance->value,
                   .triangle = point->triangle,
                   .key = {(uint32_t)point->key, (uint32_t)(point->key >> 32)},
                   .stretch = rules->metric == SL_METRIC_HESSIAN ? (float)(1.0 / rules->accuracy) : 1.0f};
    for (int c = 0; c < 3; c++) {
        r.rotational[c] = irradiance->rotational[c];
        r.translational[c] = irradiance->translational[c];
        r.rotational_length[c] = length_of(r.rotational[c]);
    }
    double maximum = rules->maximum_radius / rules->accuracy;
    double minimum = least_reach(&r, rules, (double)footprint) / rules->accuracy;
    if (minimum > maximum) minimum = maximum;
    double radius = metric_radius(irradiance, rules, (double)footprint);
    if (!(radius <= maximum)) radius = maximum; /* sees nothing, or an infinite mean */
    radius = positive_radius(&r, radius);
    double limit = sl_record_guard(irradiance, rules);
    if (limit < radius) radius = limit;
    if (!(radius > minimum)) radius = minimum;
    r.minimum_radius = (float)minimum;
    r.own_radius = (float)radius;
    if (radius > minimum) {
        sl_record_set_radius(&r, r.own_radius);
    } else { /* further than its derivatives can be trusted: the light changes by no more than a third */
        float stretch = r.stretch;
        if (stretch > 1.0f) r.stretch = fmaxf(1.0f, 0.33f * stretch);
        sl_record_set_radius(&r, r.own_radius);
        r.stretch = stretch;
    }
    return r;
}

void sl_record_set_radius(sl_record *record, float radius) {
    record->radius = radius;
    float mean = sl_rgb_mean(record->irradiance),
          change = translational_length(record) * radius / record->stretch;
    if (change <= mean || !(change > 0.0f)) return;
    for (int c = 0; c < 3; c++) record->translational[c] = sl_scale(record->translational[c], mean / change);
}

float sl_record_clamped_radius(const sl_reach_tree *reaches, const sl_record *record) {
    float radius = record->stretch *
                   sl_reach_tree_limit(reaches, record->position, record->own_radius / record->stretch);
    /* division and multiplication round */
    radius = radius < record->own_radius ? radius : record->own_radius;
    return radius > record->minimum_radius ? radius : record->minimum_radius;
}

/* ---- along with what moves ---- */

static sl_vec3 moved(const sl_object_motion *motion, sl_vec3 p) {
    return sl_to_float(sl_affine_point(&motion->places, sl_to_double(p)));
}

void sl_gather_point_carry(sl_gather_point *point, const sl_object_motion *motion) {
    point->position = moved(motion, point->position);
    point->geometric_normal = sl_affine_unit(&motion->turns, point->geometric_normal);
    point->normal = sl_affine_unit(&motion->turns, point->normal);
}

/* Its light falls off in the directions that it did. */
void sl_record_carry(sl_record *r, const sl_object_motion *motion) {
    r->position = moved(motion, r->position);
    r->normal = sl_affine_unit(&motion->turns, r->normal);
    for (int w = 0; w < SL_RECORD_WALLS; w++)
        r->walls[w].normal = sl_affine_unit(&motion->turns, r->walls[w].normal);
}
