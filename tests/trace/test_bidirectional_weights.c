/* The ways of making one path, and how they share it: densities worked out here from the vertices alone.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "unit_test.h"
#include "base/math.h"
#include "base/random.h"
#include "trace/bidirectional/subpath.h"
#include "trace_scenes.h"

/* ---- a scene and what makes its paths -------------------------------------------------------- */

typedef struct world {
    sl_scene *scene;
    sl_tracer *tracer;
    sl_light_sampler *lights;
    sl_sequence sequence;
    sl_path_maker maker;
    sl_subpath eye[SL_PACKET], light[SL_PACKET];
    sl_counters counters;
} world;

static world *open_world(sl_scene *scene, const sl_transport *transport) {
    world *w = calloc(1, sizeof *w);
    w->scene = scene;
    w->tracer = tracer_of(scene);
    assert_int_equal(sl_light_sampler_create(scene, &w->lights, NULL), SL_OK);
    sl_sequence_make(&w->sequence);
    sl_path_maker_init(&w->maker, scene, w->tracer, w->lights, &w->sequence, transport);
    w->maker.tan_x = w->maker.tan_y = (float)sl_tan(0.5 * (double)scene->camera.vertical_fov);
    w->maker.light_image = true;
    return w;
}

static void close_world(world *w) {
    sl_light_sampler_destroy(w->lights);
    sl_tracer_destroy(w->tracer);
    sl_scene_destroy(w->scene);
    free(w);
}

/* Sixteen pairs of subpaths, from anywhere on the film. */
static void walk_both(world *w, uint32_t packet, uint64_t key[SL_PACKET], uint32_t index[SL_PACKET]) {
    sl_vec3 direction[SL_PACKET];
    double pdf[SL_PACKET];
    sl_subpath *eye[SL_PACKET], *light[SL_PACKET];
    const sl_camera *c = &w->scene->camera;
    for (unsigned i = 0; i < SL_PACKET; i++) {
        key[i] = sl_random_key(3, i);
        index[i] = packet;
        float point[3];
        sl_sequence_point(&w->sequence, key[i], 0, packet, point);
        float u = (2.0f * point[0] - 1.0f) * w->maker.tan_x, v = (2.0f * point[1] - 1.0f) * w->maker.tan_y;
        pdf[i] = sl_camera_pdf(&w->maker, 1.0 / sqrt(1.0 + (double)(u * u + v * v)));
        direction[i] =
            sl_normalize_or(sl_sub(sl_mad(sl_scale(c->right, u), v, c->up), c->back), sl_neg(c->back));
        eye[i] = &w->eye[i];
        light[i] = &w->light[i];
    }
    sl_walk_from_lights(&w->maker, SL_PACKET, key, index, light, &w->counters);
    sl_walk_from_eye(&w->maker, SL_PACKET, c->eye, direction, pdf, key, index, eye, &w->counters);
}

/* ---- densities from the vertices alone ------------------------------------------------------- */

typedef struct path {
    unsigned last; /* m */
    const sl_path_vertex *vertex[2 * SL_SUBPATH_VERTICES_MAX];
    bool infinite, delta;
    sl_vec3d towards_light; /* where it is infinite */
} path;

static sl_vec3d direction_of(const path *p, unsigned from, unsigned to, double *squared) {
    *squared = 1.0;
    if (p->infinite && to == p->last) return p->towards_light;
    if (p->infinite && from == p->last) return sl_scaled(p->towards_light, -1.0);
    sl_vec3d d = sl_subd(sl_to_double(p->vertex[to]->origin), sl_to_double(p->vertex[from]->origin));
    *squared = sl_dotd(d, d);
    return sl_scaled(d, 1.0 / sqrt(*squared));
}

/* cos / d^2 at vertex `to`: per area instead of per solid angle. */
static double per_area(const path *p, unsigned from, unsigned to, sl_vec3d normal) {
    double squared;
    sl_vec3d w = direction_of(p, from, to, &squared);
    if (p->infinite && to == p->last) return 1.0;
    return fabs(sl_dotd(w, normal)) / squared;
}

/* Per solid angle: a walk that comes from vertex `from` to `at` goes on to `to`. The rough lobes are always
 * drawn from together. */
static double scatter(const path *p, unsigned from, unsigned at, unsigned to) {
    const sl_path_vertex *v = p->vertex[at];
    if (v->kind == SL_VERTEX_MIRROR) return 1.0;
    double unused;
    sl_vec3d in = direction_of(p, at, from, &unused), out = direction_of(p, at, to, &unused),
             n = sl_to_double(v->bsdf.normal);
    if (sl_dotd(n, out) <= 0.0 || sl_dotd(sl_to_double(v->geometric_normal), out) <= 0.0) return 0.0;
    sl_vec3d mirrored = sl_subd(sl_scaled(n, 2.0 * sl_dotd(n, in)), in);
    double kd = (double)sl_rgb_mean(v->bsdf.diffuse), ks = (double)sl_rgb_mean(v->bsdf.specular),
           e = (double)v->bsdf.exponent;
    double cosine = fmax(sl_dotd(mirrored, out), 0.0);
    return (kd * sl_dotd(n, out) / SL_PI + ks * (e + 1.0) / (2.0 * SL_PI) * pow(cosine, e)) / (kd + ks);
}

static double eye_density(const world *w, const path *p, unsigned i) {
    double squared;
    if (i > 1) {
        if (i == p->last && p->delta) return 0.0;
        return scatter(p, i - 2, i - 1, i) *
               per_area(p, i - 1, i, sl_to_double(p->vertex[i]->geometric_normal));
    }
    double cosine = -sl_dotd(direction_of(p, 0, 1, &squared), sl_to_double(w->scene->camera.back));
    double film = 4.0 * (double)w->maker.tan_x * (double)w->maker.tan_y;
    return per_area(p, 0, 1, sl_to_double(p->vertex[1]->geometric_normal)) /
           (film * cosine * cosine * cosine);
}

static double light_density(const world *w, const path *p, unsigned i) {
    const sl_scene *scene = w->scene;
    uint32_t entry = p->vertex[p->last]->light;
    double chance = sl_light_sampler_chance(w->lights, entry), squared;
    if (i + 2 <= p->last)
        return scatter(p, i + 2, i + 1, i) *
               per_area(p, i + 1, i, sl_to_double(p->vertex[i]->geometric_normal));
    const sl_emitter *emitter = entry < scene->emitter_count ? &scene->emitters[entry] : NULL;
    if (i == p->last) {
        if (emitter) return chance / (double)emitter->area;
        return p->delta
                   ? chance
                   : chance * (double)sl_environment_pdf(&scene->environment, sl_to_float(p->towards_light));
    }
    double arriving = per_area(p, p->last, i, sl_to_double(p->vertex[i]->geometric_normal));
    if (p->infinite) { /* the box's faces as the light sees them */
        sl_vec3d d = p->towards_light,
                 size = sl_subd(sl_to_double(scene->box_max), sl_to_double(scene->box_min));
        return arriving / (fabs(d.x) * size.y * size.z + fabs(d.y) * size.z * size.x +
                           fabs(d.z) * size.x * size.y);
    }
    sl_vec3d out = direction_of(p, p->last, i, &squared);
    if (emitter) {
        double cosine = sl_dotd(out, sl_to_double(sl_scene_geometric_normal(scene, emitter->triangle)));
        return (emitter->two_sided ? 0.5 * fabs(cosine) : fmax(cosine, 0.0)) / SL_PI * arriving;
    }
    const sl_light *light = &scene->lights[entry - scene->emitter_count];
    if (light->type == SL_LIGHT_POINT) return 0.25 / SL_PI * arriving;
    double inner = (double)light->cos_inner, outer = (double)light->cos_outer,
           x = (sl_dotd(out, sl_to_double(light->direction)) - outer) / (inner - outer);
    x = fmin(fmax(x, 0.0), 1.0);
    return arriving * x * x * (3.0 - 2.0 * x) / (2.0 * SL_PI * (1.0 - 0.5 * (inner + outer)));
}

static path path_of(const world *w, const sl_connection *c) {
    path p = {.last = c->s + c->t - 1};
    for (unsigned i = 0; i < c->t; i++) p.vertex[i] = &c->eye[i];
    for (unsigned i = 0; i < c->s; i++) p.vertex[p.last - i] = &c->light[i];
    const sl_path_vertex *end = p.vertex[p.last];
    p.infinite = sl_emission_is_infinite(&w->maker, end->light);
    p.delta = sl_emission_is_delta(&w->maker, end->light);
    p.towards_light = sl_to_double(end->kind == SL_VERTEX_SKY ? sl_neg(end->back) : end->back);
    return p;
}

/* p_t of every way, up to a common factor: all relative to the way of the connection, so that nothing
 * overflows. */
static double share_of(const world *w, const sl_connection *c, double *sum) {
    path p = path_of(w, c);
    double density[2 * SL_SUBPATH_VERTICES_MAX + 2], total = 0.0;
    for (unsigned t = 1; t <= p.last + 1; t++) {
        double log_ratio = 0.0;
        bool possible = t > 1 || p.last > 2;
        for (unsigned i = 1; i <= p.last && possible; i++) {
            double made = i < t ? eye_density(w, &p, i) : light_density(w, &p, i);
            possible = made > 0.0;
            if (possible)
                log_ratio += log(made) - log(i < c->t ? eye_density(w, &p, i) : light_density(w, &p, i));
        }
        if (t <= p.last &&
            (p.vertex[t - 1]->kind == SL_VERTEX_MIRROR || p.vertex[t]->kind == SL_VERTEX_MIRROR))
            possible = false;
        density[t] = possible ? exp(2.0 * log_ratio) : 0.0;
        total += density[t];
    }
    *sum = 0.0;
    for (unsigned t = 1; t <= p.last + 1; t++) *sum += density[t] / total;
    return density[c->t] / total;
}

typedef struct tally {
    unsigned checked, longest, of_mirrors;
} tally;

static void check_weight(const world *w, const sl_connection *c, tally *so_far) {
    double weight = sl_connection_weight(&w->maker, c), sum, expected = share_of(w, c, &sum);
    if (!(fabs(weight - expected) <= 3e-3 * expected + 1e-6)) {
        fail_msg("s = %u, t = %u: weight %g, from the densities %g", c->s, c->t, weight, expected);
    }
    assert_true(fabs(sum - 1.0) < 1e-9);
    so_far->checked++;
    if (c->s + c->t > so_far->longest) so_far->longest = c->s + c->t;
    for (unsigned i = 1; i < c->t; i++) so_far->of_mirrors += c->eye[i].kind == SL_VERTEX_MIRROR;
    for (unsigned i = 1; i < c->s; i++) so_far->of_mirrors += c->light[i].kind == SL_VERTEX_MIRROR;
}

static void check_weights_of_pair(const world *w, const sl_subpath *eye, const sl_subpath *light,
                                  uint32_t packet, tally *so_far) {
    sl_connection c;
    double x, y;
    for (unsigned s = 3; s <= light->count; s++) {
        if (light->vertex[s - 1].kind == SL_VERTEX_SURFACE &&
            sl_connect_camera(&w->maker, light->vertex, s, &c, &x, &y)) {
            check_weight(w, &c, so_far);
        }
    }
    for (unsigned t = 2; t <= eye->count; t++) {
        if (sl_connect_nothing(&w->maker, eye->vertex, t, &c)) check_weight(w, &c, so_far);
        if (eye->vertex[t - 1].kind != SL_VERTEX_SURFACE) continue;
        sl_light_sample sample;
        if (sl_light_sampler_sample_at(w->lights, eye->vertex[t - 1].origin, eye->vertex[t - 1].bsdf.normal,
                                       sl_random_unit(t, packet), sl_random_unit(7, packet),
                                       sl_random_unit(8, packet), &sample) &&
            sl_connect_light(&w->maker, eye->vertex, t, &sample, &c)) {
            check_weight(w, &c, so_far);
        }
        for (unsigned s = 2; s <= light->count; s++) {
            if (light->vertex[s - 1].kind == SL_VERTEX_SURFACE &&
                sl_connect_walks(&w->maker, eye->vertex, t, light->vertex, s, &c)) {
                check_weight(w, &c, so_far);
            }
        }
    }
}

static void the_shares_of_all_ways_are_those_of_their_densities_and_sum_to_one(void **unused) {
    sl_transport full = transport_of("full");
    static const unsigned lights[] = {1, 2, 4, 8, 16, 33, 63};
    for (unsigned i = 0; i < 7; i++) {
        world *w = open_world(trace_scene_lit_by(lights[i], true), &full);
        tally so_far = {0};
        for (uint32_t packet = 0; packet < 150; packet++) {
            uint64_t key[SL_PACKET];
            uint32_t index[SL_PACKET];
            walk_both(w, packet, key, index);
            for (unsigned k = 0; k < SL_PACKET; k++)
                check_weights_of_pair(w, &w->eye[k], &w->light[k], packet, &so_far);
        }
        print_message("lights %2u: %u connections, up to %u vertices, mirrors on them %u\n", lights[i],
                      so_far.checked, so_far.longest, so_far.of_mirrors);
        assert_true(so_far.checked > 500 && so_far.longest >= 6 && so_far.of_mirrors > 50);
        close_world(w);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_shares_of_all_ways_are_those_of_their_densities_and_sum_to_one),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
