/* Walks from the eye and from the lights, sixteen in step so that their rays go in packets. Both bounce by
 * the same rules; the walk from the eye counts light exactly as trace/path_walk.c does. */
#include "trace/bidirectional/subpath.h"

#include <math.h>

#include "base/random.h"
#include "trace/path_walk.h"

enum { SET_WHERE = SL_SET_THROUGH + 1, SET_WHITHER }; /* where light starts */

/* ---- densities ------------------------------------------------------------------------------- */

double sl_density_at(const sl_path_vertex *from, const sl_path_vertex *to, double pdf) {
    sl_vec3d offset = sl_subd(sl_to_double(to->origin), sl_to_double(from->origin));
    double squared = sl_dotd(offset, offset);
    if (!(squared > 0.0)) return 0.0;
    return pdf * fabs(sl_dotd(sl_to_double(to->geometric_normal), offset)) / (squared * sqrt(squared));
}

double sl_vertex_pdf(const sl_path_vertex *v, sl_vec3 from, sl_vec3 to, unsigned lobes) {
    sl_bsdf seen = v->bsdf;
    sl_bsdf_turn(&seen, from, lobes);
    return (double)sl_bsdf_pdf(&seen, to);
}

sl_rgb sl_light_vertex_value(const sl_path_vertex *v, sl_vec3 to_eye, unsigned lobes) {
    float lit = sl_dot(v->bsdf.normal, v->back), geometric = sl_dot(v->geometric_normal, v->back);
    if (!(lit > 0.0f && geometric > 0.0f && sl_dot(v->geometric_normal, to_eye) > 0.0f)) return sl_grey(0.0f);
    return sl_rgb_scale(sl_bsdf_value(&v->bsdf, to_eye, lobes), lit / geometric);
}

double sl_density_before(const sl_path_maker *m, const sl_path_vertex *v, const sl_path_vertex *before,
                         double pdf) {
    if (before->kind == SL_VERTEX_EYE) return 0.0;
    if (before->kind == SL_VERTEX_LIGHT && sl_emission_is_delta(m, before->light)) return 0.0;
    if (before->kind == SL_VERTEX_LIGHT && sl_emission_is_infinite(m, before->light)) return pdf;
    return sl_density_at(v, before, pdf);
}

static void complete_vertex_before(const sl_path_maker *m, const sl_walker *w, const sl_path_vertex *v,
                                   double pdf) {
    if (w->path->count < 2) return;
    sl_path_vertex *before = &w->path->vertex[w->path->count - 2];
    before->pdf_reverse = sl_density_before(m, v, before, pdf);
}

/* ---- leaving a vertex ------------------------------------------------------------------------ */

static bool follow_mirror(const sl_path_maker *m, sl_walker *w, const sl_path_vertex *v, sl_rgb reflectance) {
    bool after_surface = w->from_light || w->at_surface;
    if (after_surface ? !sl_mirrors_followed(m) : !m->transport.eye_mirrors) return false;
    sl_vec3 direction = sl_normalize_or(sl_reflect(v->back, v->bsdf.normal), v->bsdf.normal);
    float leaving = sl_dot(direction, v->geometric_normal), arriving = sl_dot(v->back, v->geometric_normal);
    if (!(leaving > 0.0f && arriving > 0.0f)) return false;
    w->weight = sl_rgb_mul(w->weight, reflectance);
    /* The shading cosines cancel in the adjoint's correction. */
    if (w->from_light) w->weight = sl_rgb_scale(w->weight, leaving / arriving);
    if (sl_rgb_is_black(w->weight)) return false;
    w->direct_weight = w->weight;
    if (++w->mirrors > SL_ROULETTE_AFTER_MIRRORS && !sl_walker_survives(m->sequence, w)) return false;
    w->mirror_since = true;
    complete_vertex_before(m, w, v, 1.0);
    sl_walker_leave(w, v->origin, direction, 1.0, v->triangle);
    return true;
}

static bool bounce(const sl_path_maker *m, sl_walker *w, const sl_path_vertex *v) {
    float point[3];
    sl_vec3 direction;
    sl_walker_draw(m->sequence, w, SL_SET_DIRECTION, point);
    if (v->bsdf.black || !sl_bsdf_sample(&v->bsdf, point[2], point[0], point[1], &direction)) return false;
    float pdf = sl_bsdf_pdf(&v->bsdf, direction);
    if (!(pdf > 0.0f)) return false;
    sl_rgb weight = sl_rgb_scale(w->weight, 1.0f / pdf);
    if (w->from_light) {
        sl_rgb value = sl_light_vertex_value(v, direction, sl_indirect_lobes(m, 2));
        w->weight = sl_rgb_mul(weight, sl_rgb_scale(value, sl_dot(v->geometric_normal, direction)));
        w->direct_weight = sl_grey(0.0f);
    } else {
        bool further = sl_surfaces_allowed(m, w->surfaces + 1) || sl_mirrors_followed(m);
        w->direct_weight =
            sl_rgb_mul(weight, sl_bsdf_reflect(&v->bsdf, direction, sl_direct_lobes(m, w->surfaces)));
        w->weight = sl_rgb_mul(
            weight, sl_bsdf_reflect(&v->bsdf, direction, further ? sl_indirect_lobes(m, w->surfaces) : 0));
    }
    if (sl_rgb_is_black(w->weight) && sl_rgb_is_black(w->direct_weight)) return false;
    /* The heuristics' densities leave the roulette out: any weights that sum to 1 are right. */
    if (w->surfaces > m->roulette_after && !sl_walker_survives(m->sequence, w)) return false;
    /* Two lobes in one mixture: the other walk would choose between those that reflect light of further
     * surfaces. */
    complete_vertex_before(m, w, v, sl_vertex_pdf(v, direction, v->back, sl_indirect_lobes(m, 2)));
    w->through = !w->from_light && w->surfaces == 1 && !m->transport.bounce_visibility;
    w->mirror_since = false;
    w->mirrors = 0;
    sl_walker_leave(w, v->origin, direction, (double)pdf, v->triangle);
    return true;
}

/* ---- the end of a ray ------------------------------------------------------------------------ */

/* Returns what the light that a ray of the eye meets is multiplied by; path_walk.c's meet_light(). */
static sl_rgb emission_weight(const sl_path_maker *m, const sl_walker *w) {
    if (!w->at_surface) return m->transport.emission ? w->weight : sl_grey(0.0f); /* L S* E */
    return w->mirror_since ? w->weight : w->direct_weight;
}

static void reach_sky(const sl_path_maker *m, sl_walker *w) {
    const sl_environment *sky = &m->scene->environment;
    if (w->from_light || !sky->present || (w->at_surface && !m->transport.sky_light)) return;
    sl_path_vertex *v = &w->path->vertex[w->path->count];
    *v = (sl_path_vertex){.kind = SL_VERTEX_SKY,
                          .back = sl_neg(w->direction),
                          .pdf_forward = w->pdf,
                          .emitted = sl_environment_radiance(sky, w->direction),
                          .emission_weight = emission_weight(m, w),
                          .triangle = SL_NO_INDEX,
                          .surfaces = w->surfaces,
                          .light = (uint32_t)(m->scene->emitter_count + m->scene->light_count)};
    if (!sl_rgb_is_black(v->emitted) && !sl_rgb_is_black(v->emission_weight)) w->path->count++;
}

static void put_vertex(const sl_path_maker *m, const sl_walker *w, uint32_t triangle, const sl_surface *s,
                       sl_path_vertex *v) {
    const sl_scene *scene = m->scene;
    bool mirror = sl_material_is_mirror(s->material);
    unsigned lobes = w->from_light ? sl_indirect_lobes(m, 2) : sl_eye_lobes(m, w->surfaces + 1);
    *v = (sl_path_vertex){.kind = mirror ? SL_VERTEX_MIRROR : SL_VERTEX_SURFACE,
                          .origin = sl_surface_lift(scene, triangle, s),
                          .back = sl_neg(w->direction),
                          .geometric_normal = s->geometric_normal,
                          .weight = w->weight,
                          .triangle = triangle,
                          .surfaces = w->surfaces + (mirror ? 0 : 1),
                          .light = SL_NO_INDEX};
    v->bsdf = sl_bsdf_make(s, v->back, mirror ? 0 : lobes);
    uint32_t emitter = scene->emitter_of_triangle[triangle];
    if (w->from_light || emitter == SL_NO_INDEX || !(s->front || scene->emitters[emitter].two_sided)) return;
    v->light = emitter;
    v->emitted = scene->emitters[emitter].radiance;
    v->emission_weight = emission_weight(m, w);
}

/* Per area. The vertex before lies where the ray started. */
static double arrival_density(const sl_walker *w, const sl_path_vertex *v) {
    double cosine = (double)sl_dot(v->geometric_normal, v->back);
    if (!(cosine > 0.0)) return 0.0;
    if (w->parallel) return w->pdf * cosine;
    sl_vec3d offset = sl_subd(sl_to_double(v->origin), sl_to_double(w->origin));
    double density = w->pdf * cosine / sl_dotd(offset, offset);
    return density <= DBL_MAX ? density : 0.0;
}

/* Puts the vertex that the ray met; false where the walk ends with it. */
static bool arrive(const sl_path_maker *m, sl_walker *w, uint32_t triangle, float w1, float w2) {
    if (triangle == SL_NO_INDEX) {
        reach_sky(m, w);
        return false;
    }
    sl_surface surface;
    sl_scene_surface(m->scene, triangle, w1, w2, sl_neg(w->direction), &surface);
    sl_path_vertex *v = &w->path->vertex[w->path->count];
    put_vertex(m, w, triangle, &surface, v);
    v->pdf_forward = arrival_density(w, v);
    if (!(v->pdf_forward > 0.0)) return false;
    w->path->count++;
    bool full = w->path->count == SL_SUBPATH_VERTICES_MAX;
    if (v->kind == SL_VERTEX_MIRROR) return !full && follow_mirror(m, w, v, surface.material->mirror);
    /* Light alone may end here. */
    if (!sl_surfaces_allowed(m, w->surfaces + 1) || sl_rgb_is_black(w->weight)) {
        v->weight = sl_grey(0.0f);
        return false;
    }
    w->surfaces++;
    w->at_surface = true;
    if (w->from_light && !sl_surfaces_allowed(m, w->surfaces + 1)) return false;
    return !full && bounce(m, w, v);
}

/* ---- packets --------------------------------------------------------------------------------- */

static void walk_on(const sl_path_maker *m, sl_walker *walkers, unsigned count, bool coherent,
                    sl_counters *counters) {
    sl_walker *active[SL_PACKET];
    for (unsigned i = 0; i < count; i++) active[i] = &walkers[i];
    for (unsigned alive = count; alive > 0; coherent = false) {
        sl_hit16 hits;
        sl_walkers_trace(m->tracer, m->sequence, active, alive, coherent, &hits, counters);
        unsigned left = 0;
        for (unsigned i = 0; i < alive; i++) {
            sl_walker *w = active[i];
            if (arrive(m, w, hits.triangle[i], hits.w1[i], hits.w2[i])) active[left++] = w;
        }
        alive = left;
    }
}

/* ---- starts ---------------------------------------------------------------------------------- */

/* Light that may meet no surface but x1 ends there: of use to the camera alone. Of a point that is given, x1
 * is not the walk's to meet. */
static bool light_subpaths_join(const sl_path_maker *m) {
    return m->eye_vertices > 1 || sl_surfaces_allowed(m, 2) ||
           (m->light_image && sl_mirrors_followed(m));
}

void sl_walk_from_lights(const sl_path_maker *m, unsigned count, const uint64_t *key, const uint32_t *index,
                         sl_subpath *const *paths, sl_counters *counters) {
    sl_walker walkers[SL_PACKET];
    unsigned started = 0;
    for (unsigned i = 0; i < count; i++) {
        /* A stream of its own: the walk from the eye draws from `key` itself. */
        sl_walker w = {.path = paths[i], .from_light = true, .far = INFINITY,
                       .key = sl_random_key(key[i], 1), .index = index[i]};
        float where[3], whither[3];
        sl_sequence_point(m->sequence, w.key, SET_WHERE, w.index, where);
        sl_sequence_point(m->sequence, w.key, SET_WHITHER, w.index, whither);
        w.vertex = 2;
        paths[i]->count = 0;
        if (!light_subpaths_join(m)) continue;
        sl_path_vertex *light = &paths[i]->vertex[0];
        if (!sl_emission_sample(m, where, whither, light, &w.direction, &w.pdf, &w.parallel)) continue;
        paths[i]->count = 1;
        w.origin = light->origin;
        w.weight = light->weight;
        w.roulette_scale = 1.0f / sl_rgb_max(light->weight);
        w.skip = light->triangle;
        walkers[started++] = w;
    }
    walk_on(m, walkers, started, false, counters);
}

void sl_walk_from_eye(const sl_path_maker *m, unsigned count, sl_vec3 eye, const sl_vec3 *direction,
                      const double *pdf, const uint64_t *key, const uint32_t *index, sl_subpath *const *paths,
                      sl_counters *counters) {
    sl_walker walkers[SL_PACKET];
    for (unsigned i = 0; i < count; i++) {
        paths[i]->count = 1;
        paths[i]->vertex[0] = (sl_path_vertex){
            .kind = SL_VERTEX_EYE, .origin = eye, .triangle = SL_NO_INDEX, .light = SL_NO_INDEX};
        walkers[i] = (sl_walker){.path = paths[i],
                              .weight = sl_grey(1.0f),
                              .roulette_scale = 1.0f,
                              .origin = eye,
                              .direction = direction[i],
                              .far = INFINITY,
                              .skip = SL_NO_INDEX,
                              .pdf = pdf[i],
                              .key = key[i],
                              .index = index[i]};
    }
    walk_on(m, walkers, count, true, counters);
}

void sl_walk_from_point(const sl_path_maker *m, unsigned count, const sl_path_vertex *point,
                        const uint64_t *key, const uint32_t *index, sl_subpath *const *paths,
                        sl_counters *counters) {
    sl_walker walkers[SL_PACKET];
    unsigned started = 0;
    for (unsigned i = 0; i < count; i++) {
        paths[i]->count = 2;
        paths[i]->vertex[0] =
            (sl_path_vertex){.kind = SL_VERTEX_EYE, .triangle = SL_NO_INDEX, .light = SL_NO_INDEX};
        sl_path_vertex *v = &paths[i]->vertex[1];
        *v = *point;
        v->kind = SL_VERTEX_SURFACE;
        v->weight = sl_grey(1.0f);
        v->surfaces = 1;
        v->light = SL_NO_INDEX;
        sl_bsdf_turn(&v->bsdf, v->back, sl_eye_lobes(m, 1));
        sl_walker w = {.path = paths[i],
                    .weight = v->weight,
                    .roulette_scale = 1.0f,
                    .at_surface = true,
                    .surfaces = 1,
                    .key = key[i],
                    .index = index[i]};
        if (bounce(m, &w, v)) walkers[started++] = w;
    }
    walk_on(m, walkers, started, false, counters);
}
