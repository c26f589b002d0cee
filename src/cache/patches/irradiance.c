/* Irradiance meshes, one a light (irradiance.h says what they are for). In this order:
 *
 *   fetch: F of one light at one point, down the light's quadtree to a corner, to the middle of a leaf's
 *   edge, or to a leaf that may be interpolated. On the way leaves are tested and cut. Missing samples are
 *   wanted, and the fetch waits;
 *   samples: all that are wanted are taken, by all threads, and put into the meshes in the order in which
 *   they were wanted;
 *   rounds (sl_irradiance_at()): fetches for many points and all lights, then samples, until none waits;
 *   what moves: samples that no longer hold are forgotten. */
#include "cache/patches/irradiance.h"

#include "base/batch.h"
#include "base/error.h"
#include "base/grow.h"
#include "base/math.h"
#include "base/memory.h"

/* Of what an eye can tell. Errors of the lights' meshes add up, and to those of the mesh that asks: with 8
 * lights, meshes as coarse as the threshold allows make pictures that one mesh for all makes from fewer
 * samples (the table joint of bench/multi-mesh.trials). */
static const float TOLERANCE = 0.25f;

/* A sample that a round wants: a vertex of a light's mesh. */
typedef struct wanted_sample {
    uint32_t light, vertex;
    float share;              /* once it is taken */
    bool valid;
} wanted_sample;

struct sl_irradiance_meshes {
    sl_irradiance_settings settings;
    sl_patches **mesh;            /* one a light */
    wanted_sample *wanted;
    size_t wanted_count, wanted_capacity;
    sl_light_sample_scratch **scratch; /* one a thread */
    bool sparing;              /* what is known will do */
    double inwards;            /* how far vertices on edges are moved into their faces */
};

typedef enum fetch_state { FETCH_READY, FETCH_PENDING, FETCH_INVALID, FETCH_SPLIT, FETCH_FAILED } fetch_state;

/* ---- fetch ---- */

static bool want(sl_irradiance_meshes *m, uint32_t light, uint32_t vertex) {
    if (sl_mesh_state(m->mesh[light], vertex) != SL_VERTEX_UNKNOWN) return true;
    if (!sl_make_room(&m->wanted, m->wanted_count, &m->wanted_capacity, sizeof *m->wanted)) return false;
    m->wanted[m->wanted_count++] = (wanted_sample){.light = light, .vertex = vertex};
    sl_mesh_set_state(m->mesh[light], vertex, SL_VERTEX_REQUESTED);
    return true;
}

typedef struct light_edge {
    const sl_irradiance_meshes *meshes;
    uint32_t light;
} light_edge;

/* Returns the radiance that an irradiance F of the light makes a face show: diffuse and, as bright as it can
 * be, its highlight; beside the ambient light. */
static sl_rgb shown(const light_edge *e, uint32_t face, float share) {
    const sl_irradiance_settings *settings = &e->meshes->settings;
    const sl_scene *scene = settings->scene;
    const sl_material *material = sl_triangle_material(scene, face / 2);
    sl_rgb lobe = sl_rgb_scale(material->specular, 0.5f * (material->exponent + 2.0f));
    sl_rgb reflected = sl_rgb_mul(sl_rgb_add(material->diffuse, lobe),
                                  sl_rgb_scale(settings->lights->light[e->light].colour, share));
    sl_rgb ambient = sl_rgb_mul(material->diffuse, settings->ambient);
    return sl_rgb_scale(sl_rgb_add(reflected, ambient), (float)(1.0 / SL_PI));
}

static bool differs(const void *context, uint32_t face, float w1, float w2, const float *mean,
                    const float *value) {
    (void)w1;
    (void)w2;
    const light_edge *e = context;
    if (*mean == *value) return false;
    return sl_display_contrast(&e->meshes->settings.perception, shown(e, face, *mean),
                               shown(e, face, *value)) > TOLERANCE;
}

/* Tells whether all three edges are closed, and nothing has been found on them since: an edge is closed with
 * the one that it is half of, or has been tested by its middle, and then someone may have asked for more of
 * it. */
static bool is_confident(const sl_irradiance_meshes *m, uint32_t light, const sl_patch_place *place) {
    const sl_patches *mesh = m->mesh[light];
    const light_edge edge = {m, light};
    if (!sl_all_edges_closed(&mesh->patch[place->patch])) return false;
    for (int i = 0; i < 3; i++)
        if (sl_mesh_edge_differs(mesh, place, i, SL_NO_INDEX, &(sl_edge_test){differs, &edge})) return false;
    return true;
}

/* Tests a leaf's edges as far as their samples are there; wants those that are not. */
static fetch_state test_leaf(sl_irradiance_meshes *m, uint32_t light, const sl_patch_place *place,
                             sl_error *error) {
    sl_patches *mesh = m->mesh[light];
    bool complete = true;
    for (int i = 0; i < 3; i++) {
        uint32_t corner = sl_patch_corner(mesh, place->patch, i);
        if (sl_mesh_is_sampled(mesh, corner)) continue;
        if (!want(m, light, corner)) return FETCH_FAILED;
        complete = false;
    }
    for (int i = 0; i < 3; i++) {
        if (sl_edge_of(&mesh->patch[place->patch], i) != SL_EDGE_UNTESTED) continue;
        sl_status status = SL_OK;
        uint32_t middle = sl_mesh_middle(mesh, place, i, &status, error);
        if (middle == SL_NO_INDEX && status != SL_OK) return FETCH_FAILED;
        /* as short as edges get */
        if (middle == SL_NO_INDEX) sl_set_edge(&mesh->patch[place->patch], i, SL_EDGE_CLOSED);
        if (middle == SL_NO_INDEX || sl_mesh_is_sampled(mesh, middle)) continue;
        if (!want(m, light, middle)) return FETCH_FAILED;
        complete = false;
    }
    if (!complete) return FETCH_PENDING;
    const light_edge edge = {m, light};
    for (int i = 0; i < 3; i++) {
        if (sl_edge_of(&mesh->patch[place->patch], i) == SL_EDGE_UNTESTED)
            sl_set_edge(&mesh->patch[place->patch], i,
                        sl_mesh_test_edge(mesh, place, i, &(sl_edge_test){differs, &edge}));
    }
    return FETCH_READY;
}

static fetch_state fetch_corner(sl_irradiance_meshes *m, uint32_t light, uint32_t vertex, float *share) {
    const sl_patches *mesh = m->mesh[light];
    if (sl_mesh_state(mesh, vertex) == SL_VERTEX_INVALID) return FETCH_INVALID;
    if (sl_mesh_state(mesh, vertex) == SL_VERTEX_KNOWN) {
        *share = *sl_vertex_value(mesh, vertex);
        return FETCH_READY;
    }
    return want(m, light, vertex) ? FETCH_PENDING : FETCH_FAILED;
}

static int corner_at(const sl_patch_place *place, sl_root_place x) {
    for (int i = 0; i < 3; i++)
        if (place->u[i] == x.u && place->v[i] == x.v) return i;
    return -1;
}

/* Returns the edge of a leaf in whose middle a point lies, or -1. */
static int edge_halved_by(const sl_patch_place *place, sl_root_place x) {
    for (int i = 0; i < 3; i++) {
        int a = (i + 1) % 3, b = (i + 2) % 3;
        if (place->u[a] + place->u[b] == 2 * x.u && place->v[a] + place->v[b] == 2 * x.v) return i;
    }
    return -1;
}

static fetch_state interpolate(const sl_patches *mesh, const sl_patch_place *leaf, sl_root_place x,
                               float *share) {
    double w1, w2;
    sl_patch_local(leaf, x.u, x.v, &w1, &w2);
    return sl_mesh_interpolate(mesh, leaf, (float)w1, (float)w2, true, share) ? FETCH_READY : FETCH_INVALID;
}

bool sl_irradiance_known(const sl_patches *mesh, sl_root_place at, float *share) {
    const float unit = 1.0f / (float)SL_PATCH_DYADIC;
    uint32_t sample = sl_vertex_find(mesh, at);
    if (!sl_mesh_is_sampled(mesh, sample))
        return sl_mesh_value(mesh, at.root, (float)at.u * unit, (float)at.v * unit, share);
    *share = *sl_vertex_value(mesh, sample);
    return sl_mesh_state(mesh, sample) == SL_VERTEX_KNOWN;
}

/* At a leaf, as deep as is wanted: a sample, or what its tested edges allow to interpolate. FETCH_SPLIT: it
 * is to be cut. */
static fetch_state fetch_from_leaf(sl_irradiance_meshes *m, uint32_t light, const sl_patch_place *leaf,
                                   const sl_face_point *x, float *share, sl_error *error) {
    sl_patches *mesh = m->mesh[light];
    sl_status status = SL_OK;
    int edge = edge_halved_by(leaf, x->at);
    uint32_t middle = edge >= 0 ? sl_mesh_middle(mesh, leaf, edge, &status, error) : SL_NO_INDEX;
    if (status != SL_OK) return FETCH_FAILED;
    if (middle != SL_NO_INDEX) return fetch_corner(m, light, middle, share);
    fetch_state state = test_leaf(m, light, leaf, error);
    if (state != FETCH_READY) return state;
    return is_confident(m, light, leaf) ? interpolate(mesh, leaf, x->at, share) : FETCH_SPLIT;
}

static fetch_state fetch(sl_irradiance_meshes *m, uint32_t light, const sl_face_point *x, float *share,
                         sl_error *error) {
    sl_patches *mesh = m->mesh[light];
    sl_status status = SL_OK;
    const double one = SL_PATCH_DYADIC;
    if (m->sparing && sl_irradiance_known(mesh, x->at, share)) return FETCH_READY;
    if (sl_patches_root(mesh, x->at.root, &status, error) == SL_NO_INDEX) return FETCH_FAILED;
    sl_patch_place place = sl_patch_root_place(mesh, x->at.root);
    for (;;) {
        int corner = corner_at(&place, x->at);
        if (corner >= 0)
            return fetch_corner(m, light, sl_patch_corner(mesh, place.patch, corner), share);
        if (sl_patch_is_leaf(mesh, place.patch)) {
            fetch_state state = place.depth >= x->wanted_depth
                                    ? fetch_from_leaf(m, light, &place, x, share, error)
                                    : FETCH_SPLIT;
            if (state != FETCH_SPLIT) return state;
            if (sl_mesh_split(mesh, &place, error) != SL_OK) return FETCH_FAILED;
            if (sl_patch_is_leaf(mesh, place.patch)) return interpolate(mesh, &place, x->at, share);
        }
        place = sl_patch_child_place(mesh, &place, sl_patch_child_at(&place, x->at.u / one, x->at.v / one));
    }
}

/* ---- samples ---- */

/* Returns the irradiance that a light could give, mean of the channels. */
static double most_of(const sl_irradiance_meshes *m, size_t light, const sl_lit_point *point) {
    const sl_sampled_light *l = &m->settings.lights->light[light];
    double most = sl_light_unoccluded(l, point) * (double)sl_rgb_mean(l->colour);
    return most > 0.0 && most <= DBL_MAX ? most : 0.0;
}

/* n of the n x n rays that are enough for a light that is one of many; 0: none are. A light of which n x n
 * rays see a part is off by some 0.1 (4 / n)^(3/2) of itself (the cathedral's windows behind their tracery).
 * It may be off by 0.8 % of what else arrives, a seventh of what an eye can tell in the middle greys: the
 * ambient light, and a third of all that lights could give, since not all of it will arrive. */
static int enough_rays(const sl_irradiance_meshes *m, size_t light, const sl_lit_point *point) {
    static const double part[2] = {0.08, 0.226};
    double all = (double)sl_rgb_mean(m->settings.ambient),
           scale = (double)m->settings.perception.threshold_scale;
    for (size_t l = 0; l < m->settings.lights->count; l++) all += most_of(m, l, point) / 3.0;
    double own = most_of(m, light, point);
    return own <= part[0] * scale * all ? 4 : own <= part[1] * scale * all ? 8 : 0;
}

static float take(const sl_irradiance_meshes *m, uint32_t light, const sl_lit_point *point, unsigned worker,
                  sl_counters *counters) {
    int rays = m->settings.few_rays ? enough_rays(m, light, point) : 0;
    if (rays) return sl_light_sample_by_rays(m->settings.sampling, light, point, rays, counters);
    return sl_light_sample_take(m->settings.sampling, light, point, m->scratch[worker], counters);
}

/* A vertex that gets nothing although nothing turns it away from the light may lie inside other geometry:
 * then it is asked for a little beside. */
static void sample_vertex(void *context, size_t index, unsigned worker, void *result,
                          sl_counters *counters) {
    (void)index;
    sl_irradiance_meshes *m = context;
    wanted_sample *wanted = result;
    const sl_patches *mesh = m->mesh[wanted->light];
    sl_mesh_point at = sl_mesh_point_of(mesh, wanted->vertex);
    if (at.lit.triangle == SL_NO_INDEX) sl_step_inside(m->settings.scene, m->inwards, &at);
    wanted->share = take(m, wanted->light, &at.lit, worker, counters);
    wanted->valid = true;
    if (wanted->share > 0.0f) return;
    if (!(sl_light_unoccluded(&m->settings.lights->light[wanted->light], &at.lit) > 0.0)) return;
    bool moved;
    wanted->valid =
        sl_leave_solid(mesh, m->settings.tracer, NULL, wanted->vertex, &at.lit, &moved, counters);
    if (moved) wanted->share = take(m, wanted->light, &at.lit, worker, counters);
}

/* They are put into the meshes in the order in which they were asked for. */
static void take_samples(sl_irradiance_meshes *m, sl_counters *counters) {
    const sl_batch batch = {.count = m->wanted_count, .work = sample_vertex, .context = m,
                            .results = m->wanted, .result_bytes = sizeof *m->wanted, .shared = true};
    sl_batch_run(&batch, m->settings.threads, counters);
    for (size_t i = 0; i < m->wanted_count; i++) {
        sl_patches *mesh = m->mesh[m->wanted[i].light];
        *sl_vertex_value(mesh, m->wanted[i].vertex) = m->wanted[i].share;
        sl_mesh_set_state(mesh, m->wanted[i].vertex,
                          m->wanted[i].valid ? SL_VERTEX_KNOWN : SL_VERTEX_INVALID);
    }
    m->wanted_count = 0;
}

/* Nobody waits for them any more. */
static void forget_wanted(sl_irradiance_meshes *m) {
    for (size_t i = 0; i < m->wanted_count; i++)
        sl_mesh_set_state(m->mesh[m->wanted[i].light], m->wanted[i].vertex, SL_VERTEX_UNKNOWN);
    m->wanted_count = 0;
}

/* ---- rounds ---- */

/* One point's lights; true: all are there. */
static fetch_state fetch_all(sl_irradiance_meshes *m, const sl_face_point *x, float *share, sl_error *error) {
    fetch_state worst = FETCH_READY;
    bool invalid = false;
    for (uint32_t l = 0; l < m->settings.lights->count; l++) {
        share[l] = 0.0f;
        fetch_state state = fetch(m, l, x, &share[l], error);
        if (state == FETCH_FAILED) return state;
        if (state == FETCH_PENDING) worst = FETCH_PENDING;
        invalid = invalid || state == FETCH_INVALID;
    }
    return worst == FETCH_READY && invalid ? FETCH_INVALID : worst;
}

sl_status sl_irradiance_at(sl_irradiance_meshes *m, size_t count, const sl_face_point *points, float *share,
                           bool *valid, sl_counters *counters, sl_error *error) {
    size_t lights = m->settings.lights->count, pending = count;
    uint32_t *waiting = sl_allocate(count, sizeof *waiting);
    if (!waiting) return sl_fail_memory(error, "irradiance meshes");
    for (size_t i = 0; i < count; i++) waiting[i] = (uint32_t)i;
    while (pending) {
        size_t left = 0;
        for (size_t k = 0; k < pending; k++) {
            uint32_t i = waiting[k];
            fetch_state state = fetch_all(m, &points[i], &share[i * lights], error);
            if (state == FETCH_FAILED) {
                forget_wanted(m);
                sl_free(waiting);
                return sl_fail_memory(error, "irradiance meshes");
            }
            valid[i] = state != FETCH_INVALID;
            if (state == FETCH_PENDING) waiting[left++] = i;
        }
        pending = left;
        if (pending) take_samples(m, counters);
    }
    sl_free(waiting);
    return SL_OK;
}

void sl_irradiance_meshes_spare(sl_irradiance_meshes *m, bool sparing) { m->sparing = sparing; }

/* ---- what moves ---- */

bool sl_lights_may_differ(const sl_changed_lights *l, sl_vec3 point, double reach) {
    for (size_t i = l->first; i < l->end; i++)
        if (sl_light_may_differ(l->moves, i, point, reach)) return true;
    return false;
}

bool sl_mesh_value_holds(const void *context, const sl_patches *mesh, uint32_t vertex) {
    const sl_changed_lights *l = context;
    return sl_mesh_state(mesh, vertex) == SL_VERTEX_KNOWN &&
           !sl_has_triangle_moved(l->moves, mesh->vertex[vertex].root / 2) &&
           !sl_lights_may_differ(l, sl_vertex_position(mesh, vertex), l->reach);
}

/* Halves of an edge that differs now are to be tested themselves. */
static void judge_below(sl_irradiance_meshes *m, uint32_t light, const sl_patch_place *place) {
    sl_patches *mesh = m->mesh[light];
    sl_patch *node = &mesh->patch[place->patch];
    const light_edge edge = {m, light};
    for (int i = 0; i < 3; i++) {
        sl_edge_state state = sl_mesh_test_edge(mesh, place, i, &(sl_edge_test){differs, &edge});
        if (state != SL_EDGE_UNTESTED) sl_set_edge(node, i, state);
    }
    if (node->child == SL_NO_INDEX) return;
    sl_mesh_hand_down_edges(mesh, place->patch);
    for (int c = 0; c < 4; c++) {
        sl_patch_place child = sl_patch_child_place(mesh, place, c);
        judge_below(m, light, &child);
    }
}

static void judge_all(sl_irradiance_meshes *m, uint32_t light) {
    for (size_t r = 0; r < m->mesh[light]->root_count; r++) {
        sl_patch_place root = sl_patch_root_place(m->mesh[light], m->mesh[light]->root[r].root);
        judge_below(m, light, &root);
    }
}

/* Samples of few rays go by all the light that there is. */
static void follow_light(sl_irradiance_meshes *m, uint32_t light, const sl_light_moves *moves, bool anew) {
    if (!moves || moves->light_moved[light] || (anew && m->settings.few_rays)) {
        sl_patches_clear(m->mesh[light]);
        return;
    }
    const sl_changed_lights checked = {moves, light, light + 1, 2.0 * m->inwards};
    if (moves->box_count) sl_mesh_forget(m->mesh[light], &(sl_mesh_check){sl_mesh_value_holds, &checked});
    if (anew) judge_all(m, light);
}

/* Tells whether edges are judged by other light than before. */
static bool is_judged_anew(const sl_irradiance_settings *a, const sl_irradiance_settings *b) {
    const float was[4] = {a->perception.exposure, a->ambient.r, a->ambient.g, a->ambient.b};
    const float is[4] = {b->perception.exposure, b->ambient.r, b->ambient.g, b->ambient.b};
    bool anew = false;
    for (int i = 0; i < 4; i++) anew |= was[i] != is[i];
    return anew;
}

static double inwards_of(const sl_irradiance_settings *settings) {
    return 5.0 * sl_light_sampling_step(settings->sampling);
}

static void forget_scratch(sl_irradiance_meshes *m) {
    for (unsigned t = 0; m->scratch && t < m->settings.threads; t++) {
        sl_light_sample_scratch_destroy(m->scratch[t]);
        m->scratch[t] = NULL;
    }
}

static sl_status make_scratch(sl_irradiance_meshes *m, sl_error *error) {
    sl_status status = SL_OK;
    for (unsigned t = 0; t < m->settings.threads && status == SL_OK; t++)
        status = sl_light_sample_scratch_create(m->settings.sampling, &m->scratch[t], error);
    return status;
}

sl_status sl_irradiance_meshes_follow(sl_irradiance_meshes *m, const sl_irradiance_settings *settings,
                                      const sl_light_moves *moves, sl_error *error) {
    const bool anew = is_judged_anew(&m->settings, settings) || (moves && moves->recoloured);
    forget_scratch(m);
    m->settings = *settings;
    m->inwards = inwards_of(settings);
    for (uint32_t l = 0; l < settings->lights->count; l++) follow_light(m, l, moves, anew);
    return make_scratch(m, error);
}

/* ---- life ---- */

sl_status sl_irradiance_meshes_create(const sl_irradiance_settings *settings, sl_irradiance_meshes **meshes,
                                      sl_error *error) {
    *meshes = NULL;
    sl_irradiance_meshes *m = sl_allocate(1, sizeof *m);
    if (!m) return sl_fail_memory(error, "irradiance meshes");
    m->settings = *settings;
    m->inwards = inwards_of(settings);
    const sl_patches_settings mesh = {.channels = 1, .max_depth = settings->max_depth};
    size_t lights = settings->lights->count;
    m->mesh = sl_allocate(lights, sizeof(sl_patches *));
    m->scratch = sl_allocate(settings->threads, sizeof(sl_light_sample_scratch *));
    sl_status status = m->mesh && m->scratch ? SL_OK : sl_fail_memory(error, "irradiance meshes");
    for (size_t l = 0; l < lights && status == SL_OK; l++)
        status = sl_patches_create(settings->primitives, &mesh, &m->mesh[l], error);
    if (status == SL_OK) status = make_scratch(m, error);
    if (status == SL_OK) *meshes = m;
    else sl_irradiance_meshes_destroy(m);
    return status;
}

void sl_irradiance_meshes_destroy(sl_irradiance_meshes *m) {
    if (!m) return;
    for (size_t l = 0; m->mesh && l < m->settings.lights->count; l++) sl_patches_destroy(m->mesh[l]);
    forget_scratch(m);
    SL_FREE_ALL(m->mesh, m->scratch, m->wanted, m);
}

size_t sl_irradiance_meshes_bytes(const sl_irradiance_meshes *m) {
    size_t bytes = sizeof *m + m->wanted_capacity * sizeof *m->wanted;
    for (size_t l = 0; l < m->settings.lights->count; l++) bytes += sl_patches_memory_bytes(m->mesh[l]);
    return bytes;
}

const sl_patches *sl_irradiance_mesh(const sl_irradiance_meshes *m, size_t light) { return m->mesh[light]; }
