/* Emitters as a glossy lobe sees them. Each is chosen in proportion to about what the lobe gets from it: its
 * radiance, the lobe's largest value on it and its solid angle, but of that no more than the lobe's own.
 * Directions to it are spread evenly over its solid angle (Arvo 1995), so that nothing but the lobe differs
 * between them, however near the lamp is; far away points spread over its area do as well. */
#include "cache/light/direct_internal.h"

#include "base/math.h"

enum { FEW_LAMPS = 16 }; /* all of which are looked at by angle; of more, those alone that are nearer */
/* times their extent: beyond, a lamp's area tells nearly as much as its solid angle, which takes longer */
#define DISTANT 4.0
/* of a lamp at the lobe's far end; samples of what turns out brighter weigh more by the inverse */
#define LEAST_IMPORTANCE 0.01f

/* ---- how near the lobe's axis a lamp comes ---- */

/* Largest cosine between the axis and the arc from a to b, if that lies inside the arc; else -1, for the
 * corners have it. */
static double cosine_inside_arc(sl_vec3d a, sl_vec3d b, sl_vec3d axis) {
    sl_vec3d pole = sl_crossd(a, b);
    double length = sl_lengthd(pole);
    if (!(length > 1e-9)) return -1.0;
    pole = sl_scaled(pole, 1.0 / length);
    sl_vec3d foot = sl_subd(axis, sl_scaled(pole, sl_dotd(axis, pole)));
    bool inside = sl_dotd(sl_crossd(a, foot), pole) >= 0.0 && sl_dotd(sl_crossd(foot, b), pole) >= 0.0;
    return inside ? sl_lengthd(foot) : -1.0;
}

/* Corners: unit directions. */
static double closest_cosine(const sl_vec3d corner[3], sl_vec3d axis) {
    double cosine = -1.0, turn = sl_dotd(corner[0], sl_crossd(corner[1], corner[2])) < 0.0 ? -1.0 : 1.0;
    bool inside = true;
    for (int k = 0; k < 3; k++) {
        sl_vec3d a = corner[k], b = corner[(k + 1) % 3];
        inside &= turn * sl_dotd(axis, sl_crossd(a, b)) >= 0.0;
        cosine = fmax(cosine, fmax(sl_dotd(a, axis), cosine_inside_arc(a, b, axis)));
    }
    return inside ? 1.0 : cosine;
}

/* ---- one lamp ---- */

/* Where no part of a lamp is much nearer than another, its solid angle is about this. */
static double distant_solid_angle(const sl_polygon_light *light, const sl_vec3d corner[3]) {
    sl_vec3d middle = sl_scaled(sl_addd(sl_addd(corner[0], corner[1]), corner[2]), 1.0 / 3.0);
    double squared = sl_dotd(middle, middle), emitted = -sl_dotd(middle, sl_to_double(light->normal));
    return squared > 0.0 && emitted > 0.0 ? (double)light->area * emitted / (squared * sqrt(squared)) : 0.0;
}

/* Fills in all but the sums; returns the lobe's largest value on the lamp. Far away, too small, or seen from
 * so flat an angle that its corners cannot be told apart, a lamp is sampled by its area. */
static float look_at(const sl_direct *direct, const sl_bsdf *lobe, sl_vec3 p, uint32_t side, sl_lamp *lamp) {
    const sl_polygon_light *light = &direct->sides.polygon[side];
    sl_vec3d corner[3], towards[3];
    double highest = 0.0, nearest = INFINITY;
    lamp->side = side;
    lamp->seen.parts = 0;
    lamp->seen.solid_angle = 0.0;
    if (!(sl_dot(light->normal, sl_sub(p, light->corner[0])) > 0.0f)) return 0.0f;
    for (int c = 0; c < 3; c++) {
        corner[c] = sl_subd(sl_to_double(light->corner[c]), sl_to_double(p));
        double squared = sl_dotd(corner[c], corner[c]);
        towards[c] = squared > 0.0 ? sl_scaled(corner[c], 1.0 / sqrt(squared)) : corner[c];
        highest = fmax(highest, sl_dotd(corner[c], sl_to_double(lobe->normal)));
        nearest = fmin(nearest, squared);
    }
    if (!(highest > 0.0)) return 0.0f;
    if (direct->sides.count <= FEW_LAMPS || nearest < DISTANT * DISTANT * (double)light->extent_squared)
        sl_seen_triangle_make(light->corner, p, lobe->normal, &lamp->seen);
    if (!lamp->seen.parts) lamp->seen.solid_angle = distant_solid_angle(light, corner);
    double cosine = closest_cosine(towards, sl_to_double(lobe->mirror_direction));
    return cosine > 0.0 ? sl_powf(fminf((float)cosine, 1.0f), lobe->exponent) : 0.0f;
}

bool sl_lamps_look(const sl_direct *direct, const sl_bsdf *lobe, sl_vec3 position, sl_lamps *lamps) {
    float lobe_angle = (float)(2.0 * SL_PI) / (lobe->exponent + 2.0f), sum = 0.0f;
    lamps->direct = direct;
    lamps->position = position;
    lamps->count = 0;
    lamps->solid_angle = 0.0;
    lamps->closest = 0.0f;
    for (uint32_t side = 0; side < direct->sides.count; side++) {
        sl_lamp *lamp = &lamps->lamp[lamps->count];
        float value = look_at(direct, lobe, position, side, lamp), importance;
        if (!(lamp->seen.solid_angle > 0.0) || !(direct->sides.luminance[side] > 0.0f)) continue;
        importance = direct->sides.luminance[side] * fminf((float)lamp->seen.solid_angle, lobe_angle) *
                     (value + LEAST_IMPORTANCE);
        sum += importance;
        lamp->chance = importance;
        lamp->sum = sum;
        lamps->solid_angle += lamp->seen.solid_angle;
        lamps->closest = fmaxf(lamps->closest, value);
        lamps->count++;
    }
    for (size_t k = 0; k < lamps->count; k++) lamps->lamp[k].chance /= sum;
    return lamps->count > 0 && sum > 0.0f;
}

/* ---- directions ---- */

/* Where the lamp is met, in units of the direction's length; <= 0: not from its shining side. */
static double distance_to(const sl_polygon_light *light, sl_vec3 p, sl_vec3d direction) {
    sl_vec3d out = sl_to_double(light->normal);
    double height = sl_dotd(out, sl_subd(sl_to_double(p), sl_to_double(light->corner[0]))),
           emitted = -sl_dotd(out, direction);
    return emitted > 0.0 ? height / emitted : 0.0;
}

/* By area: density in solid angle of a point at a distance. */
static double area_density(const sl_polygon_light *light, sl_vec3d direction, double distance) {
    double emitted = -sl_dotd(sl_to_double(light->normal), direction);
    return emitted > 0.0 ? distance * distance / (emitted * (double)light->area) : 0.0;
}

static sl_vec3d draw_by_angle(const sl_lamp *lamp, double u1, double u2) {
    int part = sl_seen_triangle_part(&lamp->seen, &u1);
    return sl_spherical_triangle_point(&lamp->seen.part[part], u1, u2);
}

/* Numbers go where they go on the sphere: u1 along the side from a to c, u2 from b towards there. */
static sl_vec3d draw_by_area(const sl_polygon_light *light, sl_vec3 p, double u1, double u2) {
    double root = sqrt(u2);
    sl_vec3d a = sl_to_double(light->corner[0]), b = sl_to_double(light->corner[1]),
             c = sl_to_double(light->corner[2]);
    sl_vec3d d = sl_subd(
        sl_addd(sl_scaled(b, 1.0 - root), sl_addd(sl_scaled(a, root * (1.0 - u1)), sl_scaled(c, root * u1))),
        sl_to_double(p));
    double length = sl_lengthd(d);
    return length > 0.0 ? sl_scaled(d, 1.0 / length) : d;
}

/* The first whose sum exceeds u of the whole; u is stretched to [0,1) within it. */
static const sl_lamp *choose(const sl_lamps *lamps, float *u) {
    float at = *u * lamps->lamp[lamps->count - 1].sum, before = 0.0f;
    size_t k = 0;
    while (k + 1 < lamps->count && at >= lamps->lamp[k].sum) before = lamps->lamp[k++].sum;
    float width = lamps->lamp[k].sum - before;
    *u = width > 0.0f ? fminf(fmaxf((at - before) / width, 0.0f), 0x1.fffffep-1f) : 0.5f;
    return &lamps->lamp[k];
}

bool sl_lamps_draw(const sl_lamps *lamps, const float u[2], sl_light_sample *sample) {
    float u1 = u[0];
    const sl_lamp *lamp = choose(lamps, &u1);
    const sl_polygon_light *light = &lamps->direct->sides.polygon[lamp->side];
    sl_vec3d d = lamp->seen.parts ? draw_by_angle(lamp, (double)u1, (double)u[1])
                             : draw_by_area(light, lamps->position, (double)u1, (double)u[1]);
    double distance = distance_to(light, lamps->position, d);
    if (!(distance > 0.0)) return false;
    double density = lamp->seen.parts ? 1.0 / lamp->seen.solid_angle : area_density(light, d, distance);
    const sl_emitter *e = &lamps->direct->scene->emitters[lamps->direct->sides.emitter[lamp->side]];
    float pdf = lamp->chance * (float)density;
    if (!(pdf > 0.0f) || !isfinite(pdf)) return false;
    *sample = (sl_light_sample){.to_light = sl_to_float(d),
                                .distance = (float)distance,
                                .radiance = sl_rgb_scale(e->radiance, 1.0f / pdf),
                                .pdf = pdf,
                                .triangle = e->triangle};
    return true;
}

float sl_lamps_pdf(const sl_lamps *lamps, sl_vec3 direction, uint32_t triangle, float distance) {
    const sl_direct *direct = lamps->direct;
    for (size_t k = 0; k < lamps->count; k++) {
        const sl_lamp *lamp = &lamps->lamp[k];
        const sl_polygon_light *light = &direct->sides.polygon[lamp->side];
        if (direct->scene->emitters[direct->sides.emitter[lamp->side]].triangle != triangle ||
            !(sl_dot(light->normal, direction) < 0.0f))
            continue;
        return lamp->chance * (float)(lamp->seen.parts
                                          ? 1.0 / lamp->seen.solid_angle
                                          : area_density(light, sl_to_double(direction), (double)distance));
    }
    return 0.0f;
}
