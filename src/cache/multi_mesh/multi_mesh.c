/* One picture, batch by batch.
 *
 *   id map ── visible sizes ── materials ── roots' vertices ──┬── the picture so far (three Gouraud planes, merged)
 *                                                             │
 *      the leaves that matter most, of three meshes ── samples of their tests ── splits, undo ── and again
 *                            │
 *      coarse mesh of all surfaces, until it is whole: then indirect light has a mesh, too
 */
#include "cache/multi_mesh/multi_mesh.h"

#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/announce.h"
#include "cache/multi_mesh/direct.h"
#include "cache/multi_mesh/displayed.h"
#include "cache/multi_mesh/gather.h"
#include "cache/multi_mesh/merge.h"
#include "cache/multi_mesh/plan.h"
#include "scene/ambient.h"

#include <string.h>

enum {
    FIRST_VERTICES = 1024,   /* an update's, before refinement */
    COARSE_VERTICES = 1024,  /* an update's, beside refinement */
    FEW_PIXELS = 8,
    GATHERS_A_TASK = 2,
    LEAF_VERTICES = 6,
    PARTS = SL_COMPONENTS
};

typedef enum mesh_phase { PHASE_VIEW, PHASE_FIRST, PHASE_REFINE, PHASE_DONE } mesh_phase;

typedef struct gather_worker {
    sl_mesh_gather_scratch *scratch;
    sl_counters counters;
} gather_worker;

typedef struct multi_mesh_state {
    const sl_scene *scene;
    sl_settings settings;
    sl_multi_mesh_plan plan;
    sl_perception perception;
    sl_rgb ambient;                 /* indirect irradiance before anything of it is known */

    /* what depends on geometry and lights */
    sl_raster *raster;
    sl_tracer *tracer;
    sl_topology *topology, *by_exponent; /* by_exponent: of the specular mesh; NULL: the same */
    sl_sampled_lights *lights;
    sl_light_sampling *sampling;
    sl_irradiance_meshes *irradiance;
    sl_object_places *places;       /* where objects were when all this was made */
    sl_coarse *coarse;
    sl_mesh_gather *gather;
    gather_worker *gatherer;        /* one a thread */
    sl_displayed *part[PARTS];      /* NULL: the scene does not need it */
    size_t coarse_done;             /* vertices of the coarse mesh that are there, */
    sl_rgb *coarse_indirect;        /* two bounces: E_i at the coarse mesh's vertices; NULL: there is but one, or the coarse mesh is whole */
    bool coarse_whole;

    /* what depends on the view */
    uint32_t *id;
    sl_visible_pixels *visible;
    sl_materials_seen *materials;
    float *planes[PARTS][3];
    float *plane_memory;

    mesh_phase phase;
    sl_counters counters;
    sl_announcer announcer;
} multi_mesh_state;

static size_t pixels_of(const multi_mesh_state *s) { return (size_t)s->settings.width * (size_t)s->settings.height; }

static const sl_material *material_of(const sl_scene *scene, uint32_t face) { return &scene->materials[scene->material_index[face / 2]]; }

/* ---- what a face shows: how parts are judged (section 2.7) ---- */

static sl_rgb value_of(const multi_mesh_state *s, sl_component part, uint32_t face, float w1, float w2) {
    float value[3];
    if (s->part[part] && sl_mesh_value(s->part[part]->mesh, face, w1, w2, value)) return (sl_rgb){value[0], value[1], value[2]};
    return part == SL_INDIRECT && s->plan.indirect ? s->ambient : sl_grey(0.0f);
}

static sl_rgb shown_radiance(const void *context, sl_component part, uint32_t face, float w1, float w2, sl_rgb value) {
    const multi_mesh_state *s = context;
    const sl_material *material = material_of(s->scene, face);
    sl_rgb parts[PARTS];
    for (int i = 0; i < PARTS; i++) parts[i] = i == (int)part ? value : value_of(s, (sl_component)i, face, w1, w2);
    sl_rgb received = sl_rgb_add(parts[SL_DIRECT_DIFFUSE], sl_rgb_scale(parts[SL_INDIRECT], (float)(1.0 / SL_PI)));
    sl_rgb reflected = sl_rgb_add(sl_rgb_mul(material->diffuse, received), sl_rgb_mul(material->specular, parts[SL_DIRECT_SPECULAR]));
    bool shines = face % 2 == 0 || material->emission_two_sided;
    return shines ? sl_rgb_add(reflected, material->emission) : reflected;
}

static bool wants_diffuse(const void *context, uint32_t face) { return sl_material_is_diffuse(material_of(context, face)); }
static bool wants_specular(const void *context, uint32_t face) { return sl_material_is_glossy(material_of(context, face)); }

static bool (*const wants[PARTS])(const void *, uint32_t) = {wants_diffuse, wants_specular, wants_diffuse};

/* ---- what there is, and its end ---- */

static void forget_view(multi_mesh_state *s) {
    sl_visible_pixels_destroy(s->visible);
    sl_materials_destroy(s->materials);
    s->visible = NULL;
    s->materials = NULL;
}

/* What gathers see, and what the eye sees: all that does not survive a light or an object that moves. */
static void forget_pictures(multi_mesh_state *s) {
    for (int i = 0; i < PARTS; i++) {
        sl_displayed_destroy(s->part[i]);
        s->part[i] = NULL;
    }
    for (unsigned t = 0; s->gatherer && t < s->settings.threads; t++) sl_mesh_gather_scratch_destroy(s->gatherer[t].scratch);
    sl_free(s->gatherer);
    sl_free(s->coarse_indirect);
    sl_mesh_gather_destroy(s->gather);
    sl_coarse_destroy(s->coarse);
    s->gatherer = NULL;
    s->coarse_indirect = NULL;
    s->gather = NULL;
    s->coarse = NULL;
}

static void forget_world(multi_mesh_state *s) {
    forget_pictures(s);
    sl_irradiance_meshes_destroy(s->irradiance);
    sl_object_places_destroy(s->places);
    sl_light_sampling_destroy(s->sampling);
    sl_sampled_lights_destroy(s->lights);
    sl_topology_destroy(s->by_exponent);
    sl_topology_destroy(s->topology);
    sl_tracer_destroy(s->tracer);
    sl_raster_destroy(s->raster);
    s->irradiance = NULL;
    s->places = NULL;
    s->sampling = NULL;
    s->lights = NULL;
    s->by_exponent = s->topology = NULL;
    s->tracer = NULL;
    s->raster = NULL;
}

static void multi_mesh_destroy(void *state) {
    multi_mesh_state *s = state;
    if (!s) return;
    forget_view(s);
    forget_world(s);
    sl_free(s->id);
    sl_free(s->plane_memory);
    sl_free(s);
}

static sl_status make_sampling(multi_mesh_state *s, sl_error *error) {
    const sl_multi_mesh_settings *m = &s->settings.multi_mesh;
    sl_light_sample_settings sampling = sl_light_sample_defaults();
    sampling.estimator = m->estimator;
    sampling.size = m->light_size;
    sampling.rays = m->light_rays;
    sampling.threads = s->settings.threads;
    sl_status status = sl_sampled_lights_find(s->scene, &s->lights, error);
    if (status == SL_OK) status = sl_light_sampling_create(s->scene, s->raster, s->tracer, s->lights, &sampling, &s->sampling, error);
    return status;
}

static sl_irradiance_settings irradiance_settings(const multi_mesh_state *s) {
    return (sl_irradiance_settings){.scene = s->scene, .topology = s->topology, .tracer = s->tracer, .lights = s->lights,
                                    .sampling = s->sampling, .perception = s->perception, .ambient = s->ambient,
                                    .max_depth = s->settings.multi_mesh.max_depth, .threads = s->settings.threads};
}

static sl_status make_lights(multi_mesh_state *s, sl_error *error) {
    sl_status status = make_sampling(s, error);
    sl_irradiance_settings irradiance = irradiance_settings(s);
    return status == SL_OK ? sl_irradiance_meshes_create(&irradiance, &s->irradiance, error) : status;
}

static sl_status make_part(multi_mesh_state *s, sl_component part, sl_error *error) {
    const sl_multi_mesh_settings *m = &s->settings.multi_mesh;
    const sl_topology *topology = part == SL_DIRECT_SPECULAR && s->by_exponent ? s->by_exponent : s->topology;
    float coarser = part == SL_INDIRECT ? 2.0f : 1.0f; /* no shadow in it is as small as those of a lamp */
    sl_displayed_settings settings = {.component = part, .leaf_area = coarser * coarser * (float)m->leaf_area, .leaf_edge = coarser * (float)m->leaf_edge,
                                      .few_pixels = part == SL_INDIRECT ? 2 * FEW_PIXELS : FEW_PIXELS,
                                      .max_depth = m->max_depth, .selection = m->selection, .seed = s->settings.seed,
                                      .hanging = !m->keep_hanging, .perception = s->perception, .shown = {s, shown_radiance},
                                      .threads = s->settings.threads};
    return sl_displayed_create(topology, &settings, &s->part[part], error);
}

static sl_status make_coarse(multi_mesh_state *s, sl_error *error) {
    sl_coarse_settings coarse = {(float)sl_multi_mesh_coarse_edge(s->scene, &s->settings), s->settings.multi_mesh.coarse_depth};
    s->coarse_done = 0;
    s->coarse_whole = false;
    return sl_coarse_create(s->scene, s->topology, &coarse, &s->coarse, error);
}

static sl_status make_pictures(multi_mesh_state *s, sl_error *error) {
    sl_status status = SL_OK;
    if (s->plan.indirect) status = make_coarse(s, error);
    if (status == SL_OK && s->plan.direct_diffuse) status = make_part(s, SL_DIRECT_DIFFUSE, error);
    if (status == SL_OK && s->plan.direct_specular) status = make_part(s, SL_DIRECT_SPECULAR, error);
    if (status == SL_OK && s->plan.indirect) status = make_part(s, SL_INDIRECT, error);
    return status;
}

/* Displayed levels follow the light that is in the scene, never a picture's content. */
static void set_perception(multi_mesh_state *s) {
    const sl_multi_mesh_settings *m = &s->settings.multi_mesh;
    s->ambient = sl_ambient_irradiance(s->scene);
    s->perception.threshold_scale = (float)m->threshold_scale;
    s->perception.exposure =
        m->exposure > 0.0 ? (float)m->exposure : sl_perception_exposure(s->scene, sl_rgb_mean(s->ambient) * (float)(1.0 / SL_PI));
}

static sl_status make_world(multi_mesh_state *s, sl_error *error) {
    unsigned threads = s->settings.threads;
    set_perception(s);
    sl_status status = sl_raster_create(s->scene, threads, &s->raster, error);
    if (status == SL_OK && s->plan.lights) status = sl_tracer_create(s->scene, threads, NULL, &s->tracer, error);
    if (status == SL_OK) status = sl_topology_create(s->scene, false, &s->topology, error);
    if (status == SL_OK && s->plan.several_exponents) status = sl_topology_create(s->scene, true, &s->by_exponent, error);
    if (status == SL_OK && s->plan.lights) status = make_lights(s, error);
    if (status == SL_OK) status = sl_object_places_take(s->scene, &s->places, error);
    return status == SL_OK ? make_pictures(s, error) : status;
}

/* ---- lights and objects that move ---- */

/* The world as it is now, beside what is left of the old one. */
typedef struct old_world {
    sl_topology *topology, *by_exponent;
    sl_sampled_lights *lights;
    sl_light_sampling *sampling;
    sl_tracer *tracer;
    sl_object_places *places;
} old_world;

static void forget_old_world(old_world *old) {
    sl_light_sampling_destroy(old->sampling);
    sl_sampled_lights_destroy(old->lights);
    sl_topology_destroy(old->by_exponent);
    sl_topology_destroy(old->topology);
    sl_tracer_destroy(old->tracer);
    sl_object_places_destroy(old->places);
}

/* New rays, corners, lights and places beside the old ones; the irradiance meshes still hold those. */
static sl_status renew_world(multi_mesh_state *s, old_world *old, sl_error *error) {
    unsigned threads = s->settings.threads;
    *old = (old_world){s->topology, s->by_exponent, s->lights, s->sampling, s->tracer, s->places};
    s->topology = s->by_exponent = NULL;
    s->lights = NULL;
    s->sampling = NULL;
    s->tracer = NULL;
    s->places = NULL;
    sl_status status = sl_raster_move(s->raster, threads, error);
    if (status == SL_OK) status = sl_tracer_create(s->scene, threads, NULL, &s->tracer, error);
    if (status == SL_OK) status = sl_topology_create(s->scene, false, &s->topology, error);
    if (status == SL_OK && s->plan.several_exponents) status = sl_topology_create(s->scene, true, &s->by_exponent, error);
    if (status == SL_OK) status = make_sampling(s, error);
    if (status == SL_OK) status = sl_object_places_take(s->scene, &s->places, error);
    return status;
}

static sl_status keep_samples(multi_mesh_state *s, const old_world *old, sl_error *error) {
    sl_irradiance_settings irradiance = irradiance_settings(s);
    if (s->lights->count != old->lights->count || !sl_topology_same_structure(s->topology, old->topology)) {
        sl_irradiance_meshes_destroy(s->irradiance);
        s->irradiance = NULL;
        return sl_irradiance_meshes_create(&irradiance, &s->irradiance, error);
    }
    sl_irradiance_changes *changes;
    sl_status status = sl_irradiance_changes_find(s->scene, old->places, s->places, old->lights, s->lights, &changes, error);
    if (status == SL_OK) status = sl_irradiance_meshes_follow(s->irradiance, &irradiance, changes, error);
    sl_irradiance_changes_destroy(changes);
    return status;
}

static sl_status follow_world(multi_mesh_state *s, sl_error *error) {
    old_world old;
    forget_view(s);
    forget_pictures(s);
    if (!s->irradiance) { /* there was no light, or an earlier edit failed */
        forget_world(s);
        return make_world(s, error);
    }
    sl_status status = renew_world(s, &old, error);
    if (status == SL_OK) status = keep_samples(s, &old, error);
    if (status == SL_OK) status = make_pictures(s, error);
    forget_old_world(&old);
    return status;
}

static sl_status multi_mesh_create(const sl_scene *scene, const sl_settings *settings, const sl_transport *transport, void **state,
                                   sl_error *error) {
    (void)transport; /* its own: sl_multi_mesh_transport() */
    multi_mesh_state *s = sl_allocate(1, sizeof *s);
    if (!s) return sl_fail_memory(error, "the meshes");
    s->scene = scene;
    s->settings = *settings;
    s->plan = sl_multi_mesh_plan_make(scene, settings);
    s->announcer = (sl_announcer){.observer = settings->observer, .method = "multi-mesh", .counters = &s->counters};
    s->id = sl_allocate(pixels_of(s), sizeof *s->id);
    s->plane_memory = sl_allocate(3 * PARTS * pixels_of(s), sizeof *s->plane_memory);
    sl_status status = s->id && s->plane_memory ? make_world(s, error) : sl_fail_memory(error, "the picture");
    if (status != SL_OK) {
        multi_mesh_destroy(s);
        return status;
    }
    for (size_t i = 0; i < PARTS; i++)
        for (size_t k = 0; k < 3; k++) s->planes[i][k] = s->plane_memory + (3 * i + k) * pixels_of(s);
    *state = s;
    return SL_OK;
}

/* ---- the view: P1, P1b, P2, P2b ---- */

static sl_status see(multi_mesh_state *s, sl_error *error) {
    sl_status status = SL_OK;
    for (int i = 0; i < PARTS && status == SL_OK; i++)
        if (s->part[i]) status = sl_displayed_see(s->part[i], s->visible, wants[i], s->scene, error);
    return status;
}

static sl_status draw_view(multi_mesh_state *s, sl_error *error) {
    unsigned threads = s->settings.threads;
    sl_view view = sl_view_scene(s->scene, s->settings.width, s->settings.height);
    sl_target target = {s->settings.width, s->settings.height, s->id, NULL};
    sl_status status = sl_raster_id(s->raster, &view, threads, &target, &s->counters, error);
    sl_visible_pixels *before = s->visible; /* which the meshes still hold */
    s->visible = NULL;
    if (status == SL_OK) status = sl_visible_pixels_sort(s->scene, s->raster, &view, s->id, threads, &s->visible, &s->counters, error);
    sl_announce_pass(&s->announcer, "identifiers, visible sizes", "section 3, pass 1");
    memset(s->plane_memory, 0, 3 * PARTS * pixels_of(s) * sizeof *s->plane_memory);
    sl_materials_destroy(s->materials);
    s->materials = NULL;
    sl_materials_wanted wanted = {s->plan.specular_seen, s->plan.emission};
    if (status == SL_OK)
        status = sl_materials_resolve(s->scene, s->raster, &view, s->id, wanted, threads, &s->materials, &s->counters, error);
    if (status == SL_OK) sl_announce(&s->announcer, "material: k_d", "section 3, pass 2", s->settings.width, s->settings.height, 3, s->materials->diffuse[0], true);
    if (status == SL_OK && s->plan.specular_seen)
        sl_announce(&s->announcer, "material: k_s", "section 3, pass 2", s->settings.width, s->settings.height, 3, s->materials->specular[0], true);
    if (status == SL_OK) status = see(s, error);
    sl_visible_pixels_destroy(before);
    if (status == SL_OK) s->phase = PHASE_FIRST;
    return status;
}

/* ---- samples of vertices ---- */

/* A vertex of a displayed mesh that is to be sampled. */
typedef struct wanted_vertex {
    uint32_t vertex;
    int wanted_depth;
} wanted_vertex;

static void put_value(sl_displayed *part, uint32_t vertex, sl_rgb value, bool valid, sl_counters *counters) {
    sl_mesh *mesh = part->mesh;
    bool finite = sl_rgb_is_finite(value);
    if (!finite) sl_count(counters, SL_COUNT_NONFINITE, 1);
    mesh->value[3 * (size_t)vertex] = finite ? value.r : 0.0f;
    mesh->value[3 * (size_t)vertex + 1] = finite ? value.g : 0.0f;
    mesh->value[3 * (size_t)vertex + 2] = finite ? value.b : 0.0f;
    mesh->state[vertex] = valid && finite ? SL_VERTEX_KNOWN : SL_VERTEX_INVALID;
}

/* Radiance of one vertex from its lights' shares. */
static sl_rgb direct_value(const multi_mesh_state *s, sl_component part, uint32_t vertex, const float *share) {
    if (part == SL_DIRECT_DIFFUSE) return sl_direct_diffuse(s->lights, share);
    sl_mesh_point point;
    sl_mesh_point_of(s->part[part]->mesh, vertex, &point);
    return sl_direct_specular(s->lights, share, &point, material_of(s->scene, point.face)->exponent, s->scene->camera.eye,
                              s->settings.multi_mesh.plain_highlights);
}

static sl_status sample_direct(multi_mesh_state *s, sl_component part, size_t count, const wanted_vertex *wanted, sl_error *error) {
    size_t lights = s->lights->count;
    sl_face_point *points = sl_allocate(count, sizeof *points);
    float *share = sl_allocate(count * lights, sizeof *share);
    bool *valid = sl_allocate(count, sizeof *valid);
    sl_status status = points && share && valid ? SL_OK : sl_fail_memory(error, "samples");
    for (size_t i = 0; i < count && status == SL_OK; i++) {
        int depth = s->settings.multi_mesh.joint_mesh ? SL_MESH_DEPTH_MAX : wanted[i].wanted_depth;
        points[i] = sl_vertex_face_point(s->part[part]->mesh, wanted[i].vertex, depth);
    }
    if (status == SL_OK) status = sl_irradiance_at(s->irradiance, count, points, share, valid, &s->counters, error);
    for (size_t i = 0; i < count && status == SL_OK; i++)
        put_value(s->part[part], wanted[i].vertex, direct_value(s, part, wanted[i].vertex, &share[i * lights]), valid[i], &s->counters);
    sl_free(valid);
    sl_free(share);
    sl_free(points);
    return status;
}

typedef struct gathering {
    const multi_mesh_state *s;
    size_t count;
    const sl_mesh_point *point;
    sl_rgb *irradiance;
} gathering;

static void gather_some(void *context, size_t task, unsigned worker) {
    const gathering *g = context;
    gather_worker *w = &g->s->gatherer[worker];
    size_t end = (task + 1) * GATHERS_A_TASK < g->count ? (task + 1) * GATHERS_A_TASK : g->count;
    for (size_t i = task * GATHERS_A_TASK; i < end; i++)
        g->irradiance[i] = sl_mesh_gather_take(g->s->gather, &g->point[i], w->scratch, &w->counters);
}

static void gather_all(multi_mesh_state *s, size_t count, const sl_mesh_point *points, sl_rgb *irradiance) {
    gathering g = {s, count, points, irradiance};
    sl_parallel_for(s->settings.threads, (count + GATHERS_A_TASK - 1) / GATHERS_A_TASK, gather_some, &g);
    for (unsigned t = 0; t < s->settings.threads; t++) {
        sl_counters_add(&s->counters, &s->gatherer[t].counters);
        s->gatherer[t].counters = (sl_counters){{0}};
    }
}

/* Where the vertex gathers: a little inside its face if it lies within a solid, as direct light does (irradiance.c); false: there, too. */
static bool find_gather_point(multi_mesh_state *s, const sl_mesh *mesh, uint32_t vertex, sl_mesh_point *point) {
    static const double nudges[] = {0.01, 0.05, 0.2};
    sl_mesh_point_of(mesh, vertex, point);
    bool inside = s->tracer && sl_topology_inside_solid(s->topology, s->tracer, point->position, point->normal, &s->counters);
    for (size_t i = 0; i < sizeof nudges / sizeof nudges[0] && inside; i++) {
        sl_mesh_point_nudged(mesh, vertex, nudges[i], point);
        inside = sl_topology_inside_solid(s->topology, s->tracer, point->position, point->normal, &s->counters);
    }
    return !inside;
}

/* A vertex where all but nothing arrives may be walled in by what is no solid, as a beam's end in a wall that is but a face: it gathers once more, a fifth
 * of the way into its face. */
static sl_status gather_again_inside(multi_mesh_state *s, size_t count, const wanted_vertex *wanted, sl_mesh_point *points, sl_rgb *irradiance,
                                     sl_error *error) {
    const sl_mesh *mesh = s->part[SL_INDIRECT]->mesh;
    size_t dark = 0;
    float little = 0.02f * sl_rgb_mean(s->ambient);
    uint32_t *which = sl_allocate(count, sizeof *which);
    sl_rgb *again = sl_allocate(count, sizeof *again);
    for (size_t i = 0; i < count && which && again; i++) {
        if (!(sl_rgb_mean(irradiance[i]) < little)) continue;
        sl_mesh_point_nudged(mesh, wanted[i].vertex, 0.2, &points[dark]);
        which[dark++] = (uint32_t)i;
    }
    if (dark) gather_all(s, dark, points, again);
    for (size_t i = 0; i < dark; i++) irradiance[which[i]] = again[i];
    sl_status status = which && again ? SL_OK : sl_fail_memory(error, "gathers");
    sl_free(which);
    sl_free(again);
    return status;
}

static sl_status sample_indirect(multi_mesh_state *s, size_t count, const wanted_vertex *wanted, sl_error *error) {
    sl_displayed *part = s->part[SL_INDIRECT];
    sl_mesh_point *points = sl_allocate(count, sizeof *points);
    sl_rgb *irradiance = sl_allocate(count, sizeof *irradiance);
    bool *valid = sl_allocate(count, sizeof *valid);
    sl_status status = points && irradiance && valid ? SL_OK : sl_fail_memory(error, "gathers");
    for (size_t i = 0; i < count && status == SL_OK; i++) valid[i] = find_gather_point(s, part->mesh, wanted[i].vertex, &points[i]);
    if (status == SL_OK) gather_all(s, count, points, irradiance);
    if (status == SL_OK) status = gather_again_inside(s, count, wanted, points, irradiance, error);
    for (size_t i = 0; i < count && status == SL_OK; i++) put_value(part, wanted[i].vertex, irradiance[i], valid[i], &s->counters);
    sl_free(valid);
    sl_free(irradiance);
    sl_free(points);
    return status;
}

static sl_status sample(multi_mesh_state *s, sl_component part, size_t count, const wanted_vertex *wanted, sl_error *error) {
    if (count == 0) return SL_OK;
    return part == SL_INDIRECT ? sample_indirect(s, count, wanted, error) : sample_direct(s, part, count, wanted, error);
}

/* Some of the vertices that visible leaves lack; *none: there are no more. */
static sl_status fill_missing(multi_mesh_state *s, sl_component part, bool *none, sl_error *error) {
    uint32_t vertex[FIRST_VERTICES];
    wanted_vertex wanted[FIRST_VERTICES];
    size_t count = sl_displayed_missing(s->part[part], vertex, FIRST_VERTICES);
    *none = count < FIRST_VERTICES;
    for (size_t i = 0; i < count; i++) wanted[i] = (wanted_vertex){vertex[i], 0};
    return sample(s, part, count, wanted, error);
}

/* ---- the first picture, from the roots alone ---- */

static bool indirect_is_ready(const multi_mesh_state *s) { return s->coarse_whole; }

static bool takes_part(const multi_mesh_state *s, int part) {
    return s->part[part] && (part != SL_INDIRECT || indirect_is_ready(s));
}

static sl_status first_vertices(multi_mesh_state *s, sl_error *error) {
    bool all = true;
    for (int i = 0; i < PARTS; i++) {
        bool none = true;
        if (!takes_part(s, i)) continue;
        sl_status status = fill_missing(s, (sl_component)i, &none, error);
        if (status != SL_OK) return status;
        all = all && none;
    }
    if (!all) return SL_OK;
    for (int i = 0; i < PARTS; i++)
        if (takes_part(s, i)) sl_displayed_prioritise(s->part[i]);
    sl_announce_pass(&s->announcer, "vertices of the roots", "section 4");
    s->phase = PHASE_REFINE;
    return SL_OK;
}

/* ---- the coarse mesh ---- */

static sl_status ready_gather(multi_mesh_state *s, sl_error *error) {
    const sl_multi_mesh_settings *m = &s->settings.multi_mesh;
    sl_mesh_gather_settings gather = {.size = s->settings.gather_size, .reduced = s->settings.gather_size < 16 ? s->settings.gather_size : 16,
                                      .fov = (float)m->gather_fov, .undivided = m->undivided_gather, .strips = m->side_strips,
                                      .noticed = sl_rgb_mean(s->ambient) * 0.01f};
    sl_status status = sl_mesh_gather_create(s->scene, s->raster, s->coarse, &gather, &s->gather, error);
    if (status == SL_OK && !s->gatherer) {
        s->gatherer = sl_allocate(s->settings.threads, sizeof *s->gatherer);
        if (!s->gatherer) return sl_fail_memory(error, "gathers");
    }
    for (unsigned t = 0; t < s->settings.threads && status == SL_OK; t++)
        if (!s->gatherer[t].scratch) status = sl_mesh_gather_scratch_create(s->gather, &s->gatherer[t].scratch, error);
    return status;
}

static sl_status light_coarse(multi_mesh_state *s, size_t count, sl_error *error) {
    const sl_coarse_vertex *vertex = sl_coarse_vertices(s->coarse) + s->coarse_done;
    size_t lights = s->lights->count;
    sl_face_point points[COARSE_VERTICES];
    bool valid[COARSE_VERTICES];
    float *share = sl_allocate(count * lights, sizeof *share);
    if (!share) return sl_fail_memory(error, "the coarse mesh");
    for (size_t i = 0; i < count; i++) points[i] = (sl_face_point){vertex[i].face, vertex[i].p, vertex[i].q, vertex[i].depth};
    sl_status status = sl_irradiance_at(s->irradiance, count, points, share, valid, &s->counters, error);
    for (size_t i = 0; i < count && status == SL_OK; i++)
        sl_coarse_set(s->coarse, s->coarse_done + i, valid[i] ? sl_direct_diffuse(s->lights, &share[i * lights]) : sl_grey(NAN));
    sl_free(share);
    sl_count(&s->counters, SL_COUNT_COARSE_SAMPLES, status == SL_OK ? count : 0);
    return status;
}

/* The direct light of the coarse mesh is there. A second bounce wants to know what light its vertices gather from it (section 2.5). */
static sl_status finish_direct(multi_mesh_state *s, sl_error *error) {
    sl_coarse_finish(s->coarse, s->settings.threads);
    sl_announce_pass(&s->announcer, "coarse mesh", "section 5");
    sl_status status = ready_gather(s, error);
    if (status != SL_OK || s->settings.bounces < 2) {
        s->coarse_whole = status == SL_OK;
        return status;
    }
    s->coarse_done = 0;
    s->coarse_indirect = sl_allocate(sl_coarse_vertex_count(s->coarse), sizeof *s->coarse_indirect);
    return s->coarse_indirect ? SL_OK : sl_fail_memory(error, "the second bounce");
}

static void gather_for_coarse(multi_mesh_state *s, size_t count) {
    const sl_coarse_vertex *vertex = sl_coarse_vertices(s->coarse) + s->coarse_done;
    sl_mesh_point points[COARSE_VERTICES];
    for (size_t i = 0; i < count; i++) {
        sl_face_point x = {vertex[i].face, vertex[i].p, vertex[i].q, vertex[i].depth};
        points[i] = sl_face_point_in_world(s->topology, &x);
    }
    gather_all(s, count, points, s->coarse_indirect + s->coarse_done);
}

/* U_dd + E_i / pi is what gathers see from now on. */
static void finish_second_bounce(multi_mesh_state *s) {
    for (size_t i = 0; i < sl_coarse_vertex_count(s->coarse); i++) {
        sl_rgb second = sl_rgb_scale(s->coarse_indirect[i], (float)(1.0 / SL_PI));
        sl_coarse_set(s->coarse, i, sl_rgb_add(sl_coarse_get(s->coarse, i), second));
    }
    sl_free(s->coarse_indirect);
    s->coarse_indirect = NULL;
    sl_coarse_finish(s->coarse, s->settings.threads);
    sl_announce_pass(&s->announcer, "coarse mesh, second bounce", "section 5");
    s->coarse_whole = true;
}

static sl_status extend_coarse(multi_mesh_state *s, sl_error *error) {
    size_t all = s->plan.coarse ? sl_coarse_vertex_count(s->coarse) : 0, left = all - s->coarse_done;
    size_t count = left < COARSE_VERTICES ? left : COARSE_VERTICES;
    sl_status status = SL_OK;
    if (s->coarse_indirect) gather_for_coarse(s, count);
    else if (count) status = light_coarse(s, count, error);
    s->coarse_done += count;
    if (status != SL_OK || s->coarse_done < all) return status;
    if (s->coarse_indirect) finish_second_bounce(s);
    else status = finish_direct(s, error);
    if (s->coarse_whole) s->phase = PHASE_FIRST; /* of the indirect mesh */
    return status;
}

/* ---- refinement: the leaves that matter most, of all meshes ---- */

typedef struct taken_leaf {
    sl_component part;
    sl_mesh_place place;
} taken_leaf;

static int most_urgent(const multi_mesh_state *s) {
    int best = -1;
    float highest = 0.0f;
    for (int i = 0; i < PARTS; i++) {
        float priority = takes_part(s, i) ? sl_displayed_priority(s->part[i]) : 0.0f;
        if (priority > highest) {
            highest = priority;
            best = i;
        }
    }
    return best;
}

typedef struct refinement {
    taken_leaf *leaf;
    size_t leaf_count;
    wanted_vertex *wanted[PARTS];
    size_t wanted_count[PARTS];
} refinement;

static sl_status take_leaves(multi_mesh_state *s, refinement *r, sl_error *error) {
    for (int k = 0; k < s->settings.multi_mesh.batch; k++) {
        int part = most_urgent(s);
        if (part < 0) break;
        sl_displayed *mesh = s->part[part];
        sl_mesh_place place = sl_displayed_take(mesh);
        if (place.node == SL_NO_INDEX) break;
        r->leaf[r->leaf_count++] = (taken_leaf){(sl_component)part, place};
        uint32_t vertex[LEAF_VERTICES];
        size_t count = 0;
        sl_status status = sl_displayed_request(mesh, &place, vertex, &count, error);
        if (status != SL_OK) return status;
        int depth = sl_displayed_wanted_depth(mesh, &place);
        for (size_t i = 0; i < count; i++) r->wanted[part][r->wanted_count[part]++] = (wanted_vertex){vertex[i], depth};
    }
    return SL_OK;
}

static sl_status serve_leaves(multi_mesh_state *s, refinement *r, sl_error *error) {
    sl_status status = take_leaves(s, r, error);
    for (int i = 0; i < PARTS && status == SL_OK; i++) status = sample(s, (sl_component)i, r->wanted_count[i], r->wanted[i], error);
    for (size_t i = 0; i < r->leaf_count && status == SL_OK; i++)
        status = sl_displayed_commit(s->part[r->leaf[i].part], &r->leaf[i].place, &s->counters, error);
    return status;
}

static sl_status refine(multi_mesh_state *s, size_t *served, sl_error *error) {
    size_t batch = (size_t)s->settings.multi_mesh.batch;
    refinement r = {.leaf = sl_allocate(batch, sizeof *r.leaf)};
    sl_status status = r.leaf ? SL_OK : sl_fail_memory(error, "a batch");
    for (int i = 0; i < PARTS; i++) {
        r.wanted[i] = sl_allocate(batch * LEAF_VERTICES, sizeof *r.wanted[i]);
        if (!r.wanted[i]) status = sl_fail_memory(error, "a batch");
    }
    if (status == SL_OK) status = serve_leaves(s, &r, error);
    *served = r.leaf_count;
    for (int i = 0; i < PARTS; i++) sl_free(r.wanted[i]);
    sl_free(r.leaf);
    return status;
}

static sl_status refine_and_extend(multi_mesh_state *s, sl_error *error) {
    size_t served = 0;
    bool coarse = s->plan.indirect && !indirect_is_ready(s);
    sl_status status = refine(s, &served, error);
    if (status == SL_OK && coarse) return extend_coarse(s, error);
    if (status == SL_OK && served == 0) s->phase = PHASE_DONE;
    return status;
}

/* ---- the method ---- */

/* The share of visible pixels in faces that need nothing more, in all meshes; roughly, for the progress bar alone. */
static double fraction_done(const multi_mesh_state *s) {
    double done = 0.0, all = 0.0;
    if (s->phase == PHASE_DONE) return 1.0;
    if (s->phase == PHASE_VIEW || !s->visible) return 0.0;
    for (int i = 0; i < PARTS; i++) {
        const sl_displayed *part = s->part[i];
        if (!part) continue;
        for (size_t f = 0; f < s->visible->face_count; f++) {
            const sl_visible_face *face = &s->visible->face[f];
            uint32_t root = part->mesh->root_of_face[face->face];
            all += face->count;
            if (root != SL_NO_INDEX && takes_part(s, i) && s->phase == PHASE_REFINE && !(part->mesh->node[root].priority > 0.0f)) done += face->count;
        }
    }
    return all > 0.0 ? 0.99 * done / all : 0.0;
}

static sl_status multi_mesh_update(void *state, sl_progress *progress, sl_error *error) {
    multi_mesh_state *s = state;
    if (!s->raster) return sl_fail(error, SL_ERROR_RESOURCES, "an earlier edit of the scene failed; edit it again");
    sl_status status = SL_OK;
    switch (s->phase) {
    case PHASE_VIEW: status = draw_view(s, error); break;
    case PHASE_FIRST: status = first_vertices(s, error); break;
    case PHASE_REFINE: status = refine_and_extend(s, error); break;
    case PHASE_DONE: break;
    }
    progress->fraction = fraction_done(s);
    progress->frame_done = progress->done = s->phase == PHASE_DONE;
    return status;
}

static void draw_parts(multi_mesh_state *s, sl_merge *merge) {
    static const char *const names[PARTS] = {"direct diffuse radiance", "direct specular radiance", "indirect irradiance"};
    for (int i = 0; i < PARTS; i++) {
        if (!s->part[i]) continue;
        sl_rgb fallback = i == SL_INDIRECT ? s->ambient : sl_grey(0.0f);
        sl_displayed_draw(s->part[i], s->settings.threads, fallback, s->planes[i], &s->counters);
        sl_announce(&s->announcer, names[i], "section 3, pass 3", s->settings.width, s->settings.height, 3, s->planes[i][0], true);
        const float **target = i == SL_DIRECT_DIFFUSE ? merge->direct_diffuse : i == SL_DIRECT_SPECULAR ? merge->direct_specular : merge->indirect;
        for (int k = 0; k < 3; k++) target[k] = s->planes[i][k];
    }
}

static sl_status multi_mesh_resolve(void *state, sl_image **image, sl_error *error) {
    multi_mesh_state *s = state;
    if (!s->materials) return sl_image_create(s->settings.width, s->settings.height, 3, NULL, image, error); /* nothing is seen yet */
    sl_merge merge = {.materials = s->materials, .threads = s->settings.threads};
    draw_parts(s, &merge);
    sl_status status = sl_merge_picture(&merge, image, error);
    sl_announce_pass(&s->announcer, "merge", "section 3, pass 4");
    return status;
}

/* The eye: specular radiance starts again, all else stays. Lights and objects: samples of direct light stay where they still hold. */
static sl_status multi_mesh_edit(void *state, unsigned changes, sl_error *error) {
    multi_mesh_state *s = state;
    sl_status status = SL_OK;
    s->phase = PHASE_VIEW;
    if (changes & (SL_CHANGED_OBJECTS | SL_CHANGED_LIGHTS)) {
        status = follow_world(s, error);
        if (status != SL_OK) forget_world(s);
    } else if (s->part[SL_DIRECT_SPECULAR]) {
        sl_displayed_restart(s->part[SL_DIRECT_SPECULAR]);
    }
    return status;
}

static const sl_counters *multi_mesh_counters(const void *state) { return &((const multi_mesh_state *)state)->counters; }

static size_t multi_mesh_bytes(const void *state) {
    const multi_mesh_state *s = state;
    size_t bytes = sizeof *s + pixels_of(s) * (sizeof *s->id + 3 * PARTS * sizeof(float));
    if (s->raster) bytes += sl_raster_memory_bytes(s->raster);
    if (s->tracer) bytes += sl_tracer_memory_bytes(s->tracer);
    if (s->topology) bytes += sl_topology_memory_bytes(s->topology);
    if (s->by_exponent) bytes += sl_topology_memory_bytes(s->by_exponent);
    if (s->sampling) bytes += sl_light_sampling_memory_bytes(s->sampling);
    if (s->irradiance) bytes += sl_irradiance_meshes_bytes(s->irradiance);
    if (s->coarse) bytes += sl_coarse_memory_bytes(s->coarse);
    if (s->gather) bytes += sl_mesh_gather_memory_bytes(s->gather);
    for (int i = 0; i < PARTS; i++)
        if (s->part[i]) bytes += sl_displayed_memory_bytes(s->part[i]);
    return bytes;
}

static sl_mesh_census census_of(const sl_mesh *mesh, size_t bytes) {
    sl_mesh_census c = {.leaves = mesh->leaf_count, .vertices = mesh->vertex_count, .bytes = bytes};
    for (size_t v = 0; v < mesh->vertex_count; v++) c.known += mesh->state[v] == SL_VERTEX_KNOWN;
    return c;
}

void sl_multi_mesh_census(const void *state, sl_mesh_census census[SL_MESH_KINDS]) {
    const multi_mesh_state *s = state;
    for (int k = 0; k < SL_MESH_KINDS; k++) census[k] = (sl_mesh_census){0};
    for (int i = 0; i < PARTS; i++)
        if (s->part[i]) census[i] = census_of(s->part[i]->mesh, sl_displayed_memory_bytes(s->part[i]));
    for (size_t l = 0; s->irradiance && l < s->lights->count; l++) {
        const sl_mesh *mesh = sl_irradiance_mesh(s->irradiance, l);
        sl_mesh_census c = census_of(mesh, sl_mesh_memory_bytes(mesh)), *all = &census[SL_MESH_IRRADIANCE];
        all->leaves += c.leaves;
        all->vertices += c.vertices;
        all->known += c.known;
        all->bytes += c.bytes;
    }
}

const sl_method_class sl_multi_mesh_method = {
    .name = "multi-mesh",
    .complete = sl_multi_mesh_complete,
    .create = multi_mesh_create,
    .destroy = multi_mesh_destroy,
    .update = multi_mesh_update,
    .resolve = multi_mesh_resolve,
    .edit = multi_mesh_edit,
    .counters = multi_mesh_counters,
    .memory_bytes = multi_mesh_bytes,
    .transport = sl_multi_mesh_transport,
    .plan = sl_multi_mesh_plan_write,
};
