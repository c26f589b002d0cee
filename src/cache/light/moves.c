#include "cache/light/moves.h"

#include <math.h>

#include "base/error.h"
#include "base/memory.h"

/* ---- what has moved -------------------------------------------------------------------------- */

static bool same_vector(sl_vec3 a, sl_vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

static bool same_place(const sl_sampled_light *a, const sl_sampled_light *b) {
    if (!same_vector(a->position, b->position) || !same_vector(a->direction, b->direction)) return false;
    if (a->cos_inner != b->cos_inner || a->cos_outer != b->cos_outer) return false;
    for (size_t k = 0; k < 3 * a->triangles; k++)
        if (!same_vector(a->corner[k], b->corner[k])) return false;
    return true;
}

static bool same_colour(sl_rgb a, sl_rgb b) { return a.r == b.r && a.g == b.g && a.b == b.b; }

static bool same_kinds(const sl_sampled_lights *a, const sl_sampled_lights *b) {
    if (a->count != b->count) return false;
    for (size_t l = 0; l < a->count; l++) {
        const sl_sampled_light *x = &a->light[l], *y = &b->light[l];
        if (x->kind != y->kind || x->triangles != y->triangles || x->two_sided != y->two_sided) return false;
    }
    return true;
}

static void note_lights(sl_light_moves *m, const sl_sampled_lights *before) {
    for (size_t l = 0; l < m->lights->count; l++) {
        const sl_sampled_light *was = &before->light[l], *is = &m->lights->light[l];
        m->light_moved[l] = !same_place(was, is);
        m->recoloured = m->recoloured || !same_colour(was->colour, is->colour);
    }
}

sl_status sl_light_places_take(const sl_scene *scene, sl_sampled_lights **lights, sl_error *error) {
    sl_status status = sl_sampled_lights_find(scene, lights, error);
    if (status != SL_OK) return status;
    sl_free((*lights)->light_of_triangle);
    (*lights)->light_of_triangle = NULL;
    return SL_OK;
}

sl_status sl_light_moves_find(const sl_scene *scene, const sl_object_places *places_before,
                              const sl_object_places *places, const sl_sampled_lights *lights_before,
                              const sl_sampled_lights *lights, sl_light_moves **moves, sl_error *error) {
    *moves = NULL;
    if (places_before->count != places->count || !same_kinds(lights_before, lights)) return SL_OK;
    sl_light_moves *m = sl_allocate(1, sizeof *m);
    if (!m) return sl_fail_memory(error, "what has moved");
    *m = (sl_light_moves){.scene = scene,
                          .lights = lights,
                          .light_moved = sl_allocate(lights->count, sizeof *m->light_moved),
                          .object_moved = sl_allocate(places->count, sizeof *m->object_moved),
                          .box = sl_allocate(2 * places->count, sizeof *m->box)};
    if (!m->light_moved || !m->object_moved || !m->box) {
        sl_light_moves_destroy(m);
        return sl_fail_memory(error, "what has moved");
    }
    note_lights(m, lights_before);
    m->box_count = sl_object_moves(places_before, places, m->object_moved, m->box);
    *moves = m;
    return SL_OK;
}

void sl_light_moves_destroy(sl_light_moves *m) {
    if (!m) return;
    sl_free(m->light_moved);
    sl_free(m->object_moved);
    sl_free(m->box);
    sl_free(m);
}

/* ---- cones ----------------------------------------------------------------------------------- */

/* A convex cone with the axis a (unit) and its half angle's cosine and sine. */
typedef struct cone {
    sl_vec3d apex, axis;
    double cosine, sine, length;
} cone;

/* Around the ball that holds the light. A picture of a light in several planes sees the corners of a square
 * around it, too. False: the point is in the ball. */
static bool cone_to(const sl_sampled_light *light, sl_vec3 point, double reach, cone *c) {
    *c = (cone){.apex = sl_to_double(point), .cosine = 1.0, .length = INFINITY};
    if (light->kind == SL_SOURCE_DIRECTIONAL) {
        c->axis = sl_scaled(sl_to_double(light->direction), -1.0);
        return true;
    }
    sl_vec3d way = sl_subd(sl_to_double(light->position), c->apex);
    double length = sl_lengthd(way), wider = light->kind == SL_SOURCE_SOLID ? 1.5 : 1.0 + 1e-5;
    double radius = wider * (double)light->extent + reach;
    if (!(length > radius)) return false;
    c->axis = sl_scaled(way, 1.0 / length);
    c->sine = fmin(radius / length + 1e-7, 1.0);
    c->cosine = sqrt(1.0 - c->sine * c->sine);
    c->length = length + radius;
    return true;
}

/* False only if no point of the box lies in the cone: they are apart where a plane separates them. Tried are
 * the two that bound the cone along its axis, and the one that touches it on the side of the box's middle,
 * with the normal cos(beta) r - sin(beta) a; r points from the axis to that middle. */
static bool meets(const cone *c, sl_vec3d middle, sl_vec3d half) {
    sl_vec3d v = sl_subd(middle, c->apex), a = c->axis;
    double h = sl_dotd(v, a), along = half.x * fabs(a.x) + half.y * fabs(a.y) + half.z * fabs(a.z);
    if (h + along < 0.0 || h - along > c->length) return false;
    sl_vec3d radial = sl_subd(v, sl_scaled(a, h));
    double rho = sl_lengthd(radial);
    if (!(rho > 0.0)) return true;
    sl_vec3d n = sl_subd(sl_scaled(radial, c->cosine / rho), sl_scaled(a, c->sine));
    double across = half.x * fabs(n.x) + half.y * fabs(n.y) + half.z * fabs(n.z);
    return !(rho * c->cosine - h * c->sine > across);
}

bool sl_light_may_differ(const sl_light_moves *m, size_t light, sl_vec3 point, double reach) {
    cone c;
    if (m->light_moved[light]) return true;
    if (!m->box_count) return false;
    if (!cone_to(&m->lights->light[light], point, reach, &c)) return true;
    for (size_t i = 0; i < m->box_count; i++) {
        sl_vec3d low = sl_to_double(m->box[i].low), high = sl_to_double(m->box[i].high);
        sl_vec3d half = sl_scaled(sl_subd(high, low), 0.5), middle = sl_scaled(sl_addd(high, low), 0.5);
        double slack = reach + 1e-5 * (sl_lengthd(high) + sl_lengthd(half)); /* objects have roundings */
        if (!(high.x >= low.x) || meets(&c, middle, sl_addd(half, sl_v3d(slack, slack, slack)))) return true;
    }
    return false;
}
