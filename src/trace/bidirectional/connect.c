/* The ways of joining an eye subpath and a light subpath. A connection of v_(t-1) = x and v_t = y carries
 *
 *     weight(x) f(x) (n_s . w_xy) cos_y / d^2 f(y) (n_s . w_l) / (n_g . w_l) weight(y). */
#include "trace/bidirectional/subpath.h"

#include <math.h>

#include "base/random.h"
#include "trace/walker.h"

static bool is_light(sl_rgb c) { return sl_rgb_max(c) > 0.0f && sl_rgb_is_finite(c); }

/* Unit direction from a to b and its length, in double so that scenes of any size have one. */
static bool direction_between(sl_vec3 a, sl_vec3 b, sl_vec3 *direction, double *squared) {
    sl_vec3d offset = sl_subd(sl_to_double(b), sl_to_double(a));
    *squared = sl_dotd(offset, offset);
    if (!(*squared > 0.0 && *squared <= DBL_MAX)) return false;
    *direction = sl_to_float(sl_scaled(offset, 1.0 / sqrt(*squared)));
    return true;
}

/* Russian roulette (Veach 1997, section 10.4): what carries less than `least` survives with the probability
 * value / least, before it costs more. Returns what it is multiplied by, 0 where it does not survive. */
static double survival(const sl_path_maker *m, const sl_connection *c, double value, uint64_t decision) {
    double least = (double)m->least;
    if (!(value < least)) return 1.0;
    return (double)sl_random_unit(c->roulette, 2 * (SL_SUBPATH_VERTICES_MAX * c->t + c->s) + decision) *
                       least <
                   value
               ? least / value
               : 0.0;
}

/* The first decision needs no weight, as no weight is above 1. */
static bool is_worth_it(const sl_path_maker *m, sl_connection *c) {
    c->scale = survival(m, c, (double)sl_rgb_max(c->radiance), 0);
    return c->scale > 0.0;
}

static void see(sl_connection *c, sl_vec3 from, sl_vec3 to, uint32_t skip) {
    c->may_be_hidden = true;
    c->from = from;
    c->towards = sl_sub(to, from);
    c->far = 1.0f - 1e-5f;
    c->skip = skip;
}

/* Of v_(t-2), for a walk from the light that comes to x = v_(t-1) from direction w. */
static double density_before(const sl_path_maker *m, const sl_path_vertex *eye, unsigned t, sl_vec3 w) {
    if (t < 3) return 0.0;
    const sl_path_vertex *x = &eye[t - 1];
    return sl_density_at(x, &eye[t - 2], sl_vertex_pdf(x, w, x->back, sl_indirect_lobes(m, 2)));
}

/* ---- s = 0 ----------------------------------------------------------------------------------- */

bool sl_connect_nothing(const sl_path_maker *m, const sl_path_vertex *eye, unsigned t, sl_connection *c) {
    const sl_path_vertex *v = &eye[t - 1];
    if (v->light == SL_NO_INDEX) return false;
    c->eye = eye;
    c->light = NULL;
    c->t = t;
    c->s = 0;
    c->radiance = sl_rgb_mul(v->emitted, v->emission_weight);
    c->may_be_hidden = false;
    c->scale = 1.0;
    if (!is_light(c->radiance)) return false;
    c->eye_last = sl_emission_origin_pdf(m, v);
    c->eye_before = t >= 3 ? sl_emission_pdf(m, v, &eye[t - 2]) : 0.0;
    c->light_last = c->light_before = 0.0;
    return true;
}

/* ---- s = 1 ----------------------------------------------------------------------------------- */

bool sl_connect_light(const sl_path_maker *m, const sl_path_vertex *eye, unsigned t,
                      const sl_light_sample *sample, sl_connection *c) {
    const sl_path_vertex *x = &eye[t - 1];
    sl_rgb reflected = sl_bsdf_reflect(&x->bsdf, sample->to_light, sl_direct_lobes(m, x->surfaces));
    c->radiance = sl_rgb_mul(x->weight, sl_rgb_mul(reflected, sample->radiance));
    c->t = t;
    c->s = 1;
    if (!is_light(c->radiance) || !is_worth_it(m, c)) return false;
    c->own = sl_emission_sampled(m, x->origin, sample);
    c->eye = eye;
    c->light = &c->own;
    /* The path tracer's shadow ray. */
    c->may_be_hidden = x->surfaces > 1 || m->transport.direct_visibility;
    c->from = x->origin;
    c->towards = sample->to_light;
    c->far = sample->distance * (1.0f - 1e-4f);
    c->skip = sample->triangle != SL_NO_INDEX ? sample->triangle : x->triangle;
    double pdf = sample->pdf > 0.0f ? (double)sl_bsdf_pdf(&x->bsdf, sample->to_light) : 0.0;
    bool infinite = sl_emission_is_infinite(m, sample->entry);
    c->light_last = infinite ? pdf : sl_density_at(x, &c->own, pdf);
    c->light_before = 0.0;
    c->eye_last = sl_emission_pdf(m, &c->own, x);
    c->eye_before = density_before(m, eye, t, sample->to_light);
    return true;
}

/* ---- s >= 2, t >= 2 -------------------------------------------------------------------------- */

/* Of y_(s-2), for a walk from the eye that comes to y = y_(s-1) from direction w. */
static double light_density_before(const sl_path_maker *m, const sl_path_vertex *light, unsigned s, sl_vec3 w,
                                   unsigned lobes) {
    const sl_path_vertex *y = &light[s - 1];
    return sl_density_before(m, y, &light[s - 2], sl_vertex_pdf(y, w, y->back, lobes));
}

bool sl_connect_walks(const sl_path_maker *m, const sl_path_vertex *eye, unsigned t,
                      const sl_path_vertex *light, unsigned s, sl_connection *c) {
    const sl_path_vertex *x = &eye[t - 1], *y = &light[s - 1];
    sl_vec3 w;
    double squared;
    if (!sl_surfaces_allowed(m, x->surfaces + y->surfaces) ||
        !direction_between(x->origin, y->origin, &w, &squared))
        return false;
    float cosine = -sl_dot(y->geometric_normal, w);
    if (!(cosine > 0.0f)) return false;
    sl_rgb at_x = sl_bsdf_reflect(&x->bsdf, w, sl_indirect_lobes(m, x->surfaces));
    sl_rgb at_y = sl_light_vertex_value(y, sl_neg(w), sl_indirect_lobes(m, 2));
    /* weight(y) is in units of the scene's radius squared. */
    float geometry = (float)((double)cosine * m->radius * m->radius / squared);
    c->radiance =
        sl_rgb_scale(sl_rgb_mul(sl_rgb_mul(x->weight, at_x), sl_rgb_mul(y->weight, at_y)), geometry);
    c->t = t;
    c->s = s;
    if (!is_light(c->radiance) || !is_worth_it(m, c)) return false;
    c->eye = eye;
    c->light = light;
    see(c, x->origin, y->origin, y->triangle);
    c->light_last = sl_density_at(x, y, (double)sl_bsdf_pdf(&x->bsdf, w));
    c->eye_last = sl_density_at(y, x, (double)sl_bsdf_pdf(&y->bsdf, sl_neg(w)));
    c->eye_before = density_before(m, eye, t, w);
    c->light_before = light_density_before(m, light, s, sl_neg(w), sl_indirect_lobes(m, 2));
    return true;
}

/* ---- t = 1 ----------------------------------------------------------------------------------- */

/* The film is a rectangle at distance 1, 2 tan_x wide and 2 tan_y high: d omega = cos^3 dA. */
double sl_camera_pdf(const sl_path_maker *m, double cosine) {
    double area = 4.0 * (double)m->tan_x * (double)m->tan_y;
    return 1.0 / (area * cosine * cosine * cosine);
}

static bool film_position(const sl_path_maker *m, sl_vec3 from_eye, double *cosine, double *x, double *y) {
    const sl_camera *camera = &m->scene->camera;
    sl_vec3d w = sl_to_double(from_eye);
    *cosine = -sl_dotd(w, sl_to_double(camera->back));
    if (!(*cosine > 0.0)) return false;
    *x = 0.5 + 0.5 * sl_dotd(w, sl_to_double(camera->right)) / (*cosine * (double)m->tan_x);
    *y = 0.5 - 0.5 * sl_dotd(w, sl_to_double(camera->up)) / (*cosine * (double)m->tan_y);
    return *x >= 0.0 && *x < 1.0 && *y >= 0.0 && *y < 1.0;
}

bool sl_connect_camera(const sl_path_maker *m, const sl_path_vertex *light, unsigned s, sl_connection *c,
                       double *px, double *py) {
    const sl_path_vertex *y = &light[s - 1];
    sl_vec3 eye = m->scene->camera.eye, w;
    double squared, cosine;
    if (!sl_surfaces_allowed(m, y->surfaces) || !direction_between(y->origin, eye, &w, &squared))
        return false;
    if (!film_position(m, sl_neg(w), &cosine, px, py)) return false;
    float leaving = sl_dot(y->geometric_normal, w);
    if (!(leaving > 0.0f)) return false;
    sl_rgb value = sl_light_vertex_value(y, w, s == 2 ? sl_direct_lobes(m, 1) : sl_indirect_lobes(m, 1));
    double pdf = sl_camera_pdf(m, cosine),
           importance = (double)leaving * m->radius * m->radius / squared * pdf;
    c->radiance = sl_rgb_scale(sl_rgb_mul(y->weight, value), (float)importance);
    if (!is_light(c->radiance)) return false;
    c->own =
        (sl_path_vertex){.kind = SL_VERTEX_EYE, .origin = eye, .triangle = SL_NO_INDEX, .light = SL_NO_INDEX};
    c->eye = &c->own;
    c->light = light;
    c->t = 1;
    c->s = s;
    c->scale = 1.0;
    see(c, eye, y->origin, y->triangle);
    c->light_last = sl_density_at(&c->own, y, pdf);
    c->light_before = light_density_before(m, light, s, w, sl_eye_lobes(m, 1));
    c->eye_last = c->eye_before = 0.0;
    return true;
}

/* ---- all of them ----------------------------------------------------------------------------- */

/* Connections that wait for their shadow rays. */
typedef struct queue {
    const sl_path_maker *maker;
    const sl_path_receiver *receiver;
    sl_counters *counters;
    sl_ray16 rays;
    struct {
        unsigned lane, s, t;
        double x, y, weight;
        sl_rgb radiance;
    } waiting[SL_PACKET];
    uint32_t unseen; /* bit i: entry i needs its ray */
    unsigned count;
} queue;

static void empty(queue *q) {
    if (q->count == 0) return;
    uint32_t hidden =
        q->unseen ? sl_trace_occluded(q->maker->tracer, &q->rays, q->count, false, q->counters) & q->unseen
                  : 0;
    for (unsigned i = 0; i < q->count; i++) {
        if (hidden >> i & 1) continue;
        q->receiver->add(q->receiver->context, q->waiting[i].lane, q->waiting[i].s, q->waiting[i].t,
                         q->waiting[i].x, q->waiting[i].y, q->waiting[i].radiance, q->waiting[i].weight);
    }
    q->count = 0;
    q->unseen = 0;
}

static void put(queue *q, unsigned lane, const sl_connection *c, double x, double y) {
    double weight = sl_connection_weight(q->maker, c) * c->scale;
    if (c->may_be_hidden) weight *= survival(q->maker, c, (double)sl_rgb_max(c->radiance) * weight, 1);
    if (!(weight > 0.0)) return;
    if (!c->may_be_hidden) {
        q->receiver->add(q->receiver->context, lane, c->s, c->t, x, y, c->radiance, weight);
        return;
    }
    unsigned i = q->count++;
    sl_ray16_set(&q->rays, i, c->from, c->towards, 0.0f, c->far, c->skip);
    q->unseen |= 1u << i;
    q->waiting[i].lane = lane;
    q->waiting[i].s = c->s;
    q->waiting[i].t = c->t;
    q->waiting[i].x = x;
    q->waiting[i].y = y;
    q->waiting[i].weight = weight;
    q->waiting[i].radiance = c->radiance;
    if (q->count == SL_PACKET) empty(q);
}

static bool is_joinable(const sl_path_vertex *v) {
    return v->kind == SL_VERTEX_SURFACE && sl_rgb_max(v->weight) > 0.0f;
}

static void connect_eye_vertex(queue *q, unsigned lane, const sl_subpath *eye, unsigned t,
                               const sl_path_vertex *light, unsigned light_count, uint64_t key,
                               uint32_t index) {
    const sl_path_maker *m = q->maker;
    const sl_path_vertex *x = &eye->vertex[t - 1];
    sl_connection c = {.scale = 1.0};
    if (sl_connect_nothing(m, eye->vertex, t, &c)) put(q, lane, &c, 0.0, 0.0);
    if (!is_joinable(x)) return;
    float point[3];
    sl_light_sample sample;
    if (m->least > 0.0f) c.roulette = sl_random_key(key, 0x726f756c65747465u + index);
    sl_sequence_point(m->sequence, key, SL_SET_LIGHT + SL_SETS_A_VERTEX * (t - 2), index, point);
    if (sl_direct_lobes(m, x->surfaces) &&
        sl_light_sampler_sample_2d(m->lights, x->origin, point[0], point[1], &sample) &&
        sl_connect_light(m, eye->vertex, t, &sample, &c)) {
        put(q, lane, &c, 0.0, 0.0);
    }
    if (!sl_indirect_lobes(m, x->surfaces)) return;
    for (unsigned s = 2; s <= light_count; s++) {
        if (is_joinable(&light[s - 1]) && sl_connect_walks(m, eye->vertex, t, light, s, &c))
            put(q, lane, &c, 0.0, 0.0);
    }
}

void sl_connect_all(const sl_path_maker *m, unsigned count, sl_subpath *const *eye,
                    const sl_path_vertex *const *light, const unsigned *light_count, const uint64_t *key,
                    const uint32_t *index, const sl_path_receiver *receiver, sl_counters *counters) {
    queue q = {.maker = m, .receiver = receiver, .counters = counters};
    for (unsigned lane = 0; lane < count; lane++) {
        for (unsigned s = 3; m->light_image && s <= light_count[lane]; s++) {
            double x, y;
            sl_connection c;
            if (is_joinable(&light[lane][s - 1]) && sl_connect_camera(m, light[lane], s, &c, &x, &y))
                put(&q, lane, &c, x, y);
        }
        for (unsigned t = 2; t <= eye[lane]->count; t++)
            connect_eye_vertex(&q, lane, eye[lane], t, light[lane], light_count[lane], key[lane],
                               index[lane]);
    }
    empty(&q);
}
