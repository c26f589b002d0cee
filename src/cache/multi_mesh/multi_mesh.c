/* One picture, batch by batch.
 *
 *   id map ── visible sizes ── materials ── roots' vertices ──┬── the picture so far (three Gouraud planes, merged)
 *                                                             │
 *      the leaves that matter most, of three meshes ── samples of their tests ── splits, undo ── and again
 *                            │
 *      coarse mesh of all surfaces, until it is whole: then indirect light has a mesh, too
 */
#include "cache/multi_mesh/multi_mesh_internal.h"
#include "cache/multi_mesh/story.h"

#include "base/counters.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"

#include <string.h>

enum {
    FIRST_VERTICES = 1024,   /* an update's, before refinement */
    LEAF_VERTICES = 6,
    FRACTION_EVERY = 16 /* updates */
};

/* ---- what there is, and its end ---- */

static void forget_view(sl_multi_mesh_state *s) {
    sl_visible_pixels_destroy(s->visible);
    sl_materials_destroy(s->materials);
    s->visible = NULL;
    s->materials = NULL;
}

static void multi_mesh_destroy(void *state) {
    sl_multi_mesh_state *s = state;
    if (!s) return;
    forget_view(s);
    sl_multi_mesh_forget_world(s);
    sl_free(s->id);
    sl_free(s->plane_memory);
    sl_free(s);
}

static sl_status multi_mesh_create(const sl_scene *scene, const sl_settings *settings, const sl_transport *transport, void **state,
                                   sl_error *error) {
    (void)transport; /* its own: sl_multi_mesh_transport() */
    sl_multi_mesh_state *s = sl_allocate(1, sizeof *s);
    if (!s) return sl_fail_memory(error, "the meshes");
    s->scene = scene;
    s->settings = *settings;
    s->plan = sl_multi_mesh_plan_make(scene, settings);
    s->announcer = (sl_announcer){.observer = settings->observer, .method = "multi-mesh", .counters = &s->counters};
    s->id = sl_allocate(sl_multi_mesh_pixels(s), sizeof *s->id);
    s->plane_memory = sl_allocate(3 * SL_COMPONENTS * sl_multi_mesh_pixels(s), sizeof *s->plane_memory);
    sl_status status = s->id && s->plane_memory ? sl_multi_mesh_make_world(s, error) : sl_fail_memory(error, "the picture");
    if (status != SL_OK) {
        multi_mesh_destroy(s);
        return status;
    }
    for (size_t i = 0; i < SL_COMPONENTS; i++)
        for (size_t k = 0; k < 3; k++) s->planes[i][k] = s->plane_memory + (3 * i + k) * sl_multi_mesh_pixels(s);
    *state = s;
    return SL_OK;
}

/* ---- the view: P1, P1b, P2, P2b ---- */

static bool wants_diffuse(const void *context, uint32_t face) { return sl_material_is_diffuse(sl_face_material(context, face)); }
static bool wants_specular(const void *context, uint32_t face) { return sl_material_is_glossy(sl_face_material(context, face)); }

static bool (*const wants[SL_COMPONENTS])(const void *, uint32_t) = {wants_diffuse, wants_specular, wants_diffuse};

static sl_status see(sl_multi_mesh_state *s, sl_error *error) {
    sl_status status = SL_OK;
    for (int i = 0; i < SL_COMPONENTS && status == SL_OK; i++)
        if (s->part[i]) status = sl_displayed_see(s->part[i], s->visible, wants[i], s->scene, error);
    return status;
}

/* Whether any face in view has what a pass is for: what nothing in view has is not drawn. */
static bool shows(const sl_multi_mesh_state *s, bool (*has)(const void *, uint32_t)) {
    for (size_t f = 0; f < s->visible->face_count; f++)
        if (has(s->scene, s->visible->face[f].face)) return true;
    return false;
}

static bool shines(const void *context, uint32_t face) { return sl_material_is_emitter(sl_face_material(context, face)); }

static sl_materials_wanted materials_in_view(const sl_multi_mesh_state *s) {
    bool sky = s->scene->environment.present && s->visible->count < sl_multi_mesh_pixels(s);
    return (sl_materials_wanted){.specular = s->plan.specular_seen && shows(s, wants_specular), .emission = s->plan.emission && (sky || shows(s, shines))};
}

static bool in_view(const sl_displayed *part) { return part && part->heap_count > 0; }

/* A picture that was done once is done: what other views have found since shows in it, and would be looked into further without end. */
static bool was_done(const sl_multi_mesh_state *s) {
    for (size_t i = 0; i < s->done_count && i < SL_DONE_VIEWS; i++)
        if (memcmp(&s->done[i], &s->scene->camera, sizeof s->done[i]) == 0) return true;
    return false;
}

static void remember_done(sl_multi_mesh_state *s) {
    if (!s->full && !s->seen_before) s->done[s->done_count++ % SL_DONE_VIEWS] = s->scene->camera;
}

/* A row of all planes that will be drawn. */
static void clear_row(void *context, size_t row, unsigned worker) {
    (void)worker;
    const sl_multi_mesh_state *s = context;
    size_t width = (size_t)s->settings.width;
    for (int i = 0; i < SL_COMPONENTS; i++)
        for (int k = 0; k < 3 && in_view(s->part[i]); k++) memset(s->planes[i][k] + row * width, 0, width * sizeof(float));
}

static sl_status draw_view(sl_multi_mesh_state *s, sl_error *error) {
    unsigned threads = s->settings.threads;
    sl_view view = sl_view_scene(s->scene, s->settings.width, s->settings.height);
    sl_target target = {s->settings.width, s->settings.height, s->id, NULL};
    sl_status status = sl_raster_id(s->raster, &view, threads, &target, &s->counters, error);
    sl_visible_pixels *before = s->visible; /* which the meshes still hold */
    s->visible = NULL;
    if (status == SL_OK) status = sl_visible_pixels_sort(s->scene, s->raster, &view, s->id, threads, &s->visible, &s->counters, error);
    sl_multi_mesh_announce_ids(s);
    sl_materials_destroy(s->materials);
    s->materials = NULL;
    sl_materials_wanted wanted = {false, false};
    if (status == SL_OK) wanted = materials_in_view(s);
    if (status == SL_OK)
        status = sl_materials_resolve(s->scene, s->raster, &view, s->id, wanted, threads, &s->materials, &s->counters, error);
    if (status == SL_OK) sl_announce(&s->announcer, "material: k_d", "image pass 2", s->settings.width, s->settings.height, 3, s->materials->diffuse[0], true);
    if (status == SL_OK && wanted.specular)
        sl_announce(&s->announcer, "material: k_s", "image pass 2", s->settings.width, s->settings.height, 3, s->materials->specular[0], true);
    if (status == SL_OK) status = see(s, error);
    if (status == SL_OK) sl_parallel_for(threads, (size_t)s->settings.height, clear_row, s);
    sl_visible_pixels_destroy(before);
    s->priorities_stale = false;
    s->seen_before = was_done(s);
    if (s->irradiance) sl_irradiance_meshes_spare(s->irradiance, s->seen_before);
    if (status == SL_OK) s->phase = SL_PHASE_FIRST;
    return status;
}

/* ---- the first picture, from the roots alone ---- */

/* Some of the vertices that visible leaves lack; *none: there are no more. */
static sl_status fill_missing(sl_multi_mesh_state *s, sl_component part, bool *none, sl_error *error) {
    uint32_t vertex[FIRST_VERTICES], face[FIRST_VERTICES];
    sl_wanted_vertex wanted[FIRST_VERTICES];
    size_t count = sl_displayed_missing(s->part[part], vertex, face, FIRST_VERTICES);
    *none = count < FIRST_VERTICES;
    s->priorities_stale |= count > 0;
    for (size_t i = 0; i < count; i++) wanted[i] = (sl_wanted_vertex){vertex[i], 0, sl_mesh_face_middle(face[i])};
    return sl_multi_mesh_sample(s, part, count, wanted, error);
}

static bool indirect_is_ready(const sl_multi_mesh_state *s) { return s->coarse_whole; }

static bool takes_part(const sl_multi_mesh_state *s, int part) {
    bool done = s->seen_before && part != SL_DIRECT_SPECULAR;
    return s->part[part] && !done && (part != SL_INDIRECT || indirect_is_ready(s));
}

static sl_status first_vertices(sl_multi_mesh_state *s, sl_error *error) {
    bool all = true;
    for (int i = 0; i < SL_COMPONENTS; i++) {
        bool none = true;
        if (!takes_part(s, i)) continue;
        sl_status status = fill_missing(s, (sl_component)i, &none, error);
        if (status != SL_OK) return status;
        all = all && none;
    }
    if (!all) return SL_OK;
    for (int i = 0; i < SL_COMPONENTS; i++) /* in a view seen before they are as sl_displayed_see() has set them */
        if (takes_part(s, i) && s->priorities_stale) sl_displayed_prioritise(s->part[i]);
    sl_announce_pass(&s->announcer, "vertices of the roots", "progressive sampling");
    sl_multi_mesh_announce_priorities(s);
    s->phase = SL_PHASE_REFINE;
    return SL_OK;
}

/* ---- refinement: the leaves that matter most, of all meshes ---- */

typedef struct taken_leaf {
    sl_component part;
    sl_mesh_place place;
} taken_leaf;

static int most_urgent(const sl_multi_mesh_state *s) {
    int best = -1;
    float highest = 0.0f;
    for (int i = 0; i < SL_COMPONENTS; i++) {
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
    sl_probed_leaf *probed;
    size_t leaf_count, probed_count;
    sl_wanted_vertex *wanted[SL_COMPONENTS];
    size_t wanted_count[SL_COMPONENTS];
} refinement;

static sl_status take_leaves(sl_multi_mesh_state *s, refinement *r, sl_error *error) {
    for (int k = 0; k < s->settings.multi_mesh.batch; k++) {
        int part = most_urgent(s);
        if (part < 0) break;
        sl_displayed *mesh = s->part[part];
        sl_mesh_place place = sl_displayed_take(mesh);
        if (place.node == SL_NO_INDEX) break;
        if (sl_displayed_wants_probes(mesh, &place)) {
            r->probed[r->probed_count++] = (sl_probed_leaf){.part = (sl_component)part, .place = place};
            continue;
        }
        r->leaf[r->leaf_count++] = (taken_leaf){(sl_component)part, place};
        uint32_t vertex[LEAF_VERTICES];
        size_t count = 0;
        sl_status status = sl_displayed_request(mesh, &place, vertex, &count, error);
        if (status != SL_OK) return status;
        int depth = sl_displayed_wanted_depth(mesh, &place);
        sl_leaf_middle leaf = sl_mesh_leaf_middle(&place);
        for (size_t i = 0; i < count; i++) r->wanted[part][r->wanted_count[part]++] = (sl_wanted_vertex){vertex[i], depth, leaf};
    }
    return SL_OK;
}

static sl_status serve_leaves(sl_multi_mesh_state *s, refinement *r, sl_error *error) {
    sl_status status = take_leaves(s, r, error);
    for (int i = 0; i < SL_COMPONENTS && status == SL_OK; i++) status = sl_multi_mesh_sample(s, (sl_component)i, r->wanted_count[i], r->wanted[i], error);
    if (status == SL_OK) sl_multi_mesh_probe(s, r->probed_count, r->probed);
    for (size_t i = 0; i < r->leaf_count && status == SL_OK; i++)
        status = sl_displayed_commit(s->part[r->leaf[i].part], &r->leaf[i].place, &s->counters, error);
    for (size_t i = 0; i < r->probed_count && status == SL_OK; i++)
        status = sl_displayed_probed(s->part[r->probed[i].part], &r->probed[i].place, r->probed[i].contradicted, &s->counters, error);
    return status;
}

static sl_status refine(sl_multi_mesh_state *s, size_t *served, sl_error *error) {
    size_t batch = (size_t)s->settings.multi_mesh.batch;
    refinement r = {.leaf = sl_allocate(batch, sizeof *r.leaf), .probed = sl_allocate(batch, sizeof *r.probed)};
    sl_status status = r.leaf && r.probed ? SL_OK : sl_fail_memory(error, "a batch");
    for (int i = 0; i < SL_COMPONENTS; i++) {
        r.wanted[i] = sl_allocate(batch * LEAF_VERTICES, sizeof *r.wanted[i]);
        if (!r.wanted[i]) status = sl_fail_memory(error, "a batch");
    }
    if (status == SL_OK) status = serve_leaves(s, &r, error);
    *served = r.leaf_count + r.probed_count;
    for (int i = 0; i < SL_COMPONENTS; i++) sl_free(r.wanted[i]);
    sl_free(r.probed);
    sl_free(r.leaf);
    return status;
}

static void end_picture(sl_multi_mesh_state *s) {
    sl_multi_mesh_announce_light_sample(s);
    remember_done(s);
    for (int i = 0; i < SL_COMPONENTS; i++)
        if (s->part[i]) sl_displayed_settle(s->part[i]);
    s->phase = SL_PHASE_DONE;
}

/* Leaves were judged by the other components as they were then. Before the end all are judged by what there is now: whether any is wanted after all. A
 * view that is seen again asks for nothing then. */
static bool look_again(sl_multi_mesh_state *s) {
    for (int i = 0; i < SL_COMPONENTS; i++)
        if (takes_part(s, i)) sl_displayed_prioritise(s->part[i]);
    return most_urgent(s) >= 0;
}

static sl_status refine_and_extend(sl_multi_mesh_state *s, sl_error *error) {
    size_t served = 0;
    bool coarse = s->plan.indirect && !indirect_is_ready(s) && in_view(s->part[SL_INDIRECT]);
    bool full = sl_multi_mesh_is_full(s);
    sl_status status = full ? SL_OK : refine(s, &served, error);
    if (status == SL_OK && coarse) return sl_multi_mesh_extend_coarse(s, error);
    if (status == SL_OK && served == 0 && (full || !look_again(s))) end_picture(s);
    return status;
}

/* ---- the method ---- */

/* The share of visible pixels in faces that need nothing more, in all meshes. */
static double share_done(const sl_multi_mesh_state *s) {
    double done = 0.0, all = 0.0;
    for (int i = 0; i < SL_COMPONENTS; i++) {
        const sl_displayed *part = s->part[i];
        if (!part) continue;
        for (size_t f = 0; f < s->visible->face_count; f++) {
            const sl_visible_face *face = &s->visible->face[f];
            uint32_t root = sl_mesh_root_of(part->mesh, face->face);
            all += face->count;
            if (root != SL_NO_INDEX && takes_part(s, i) && s->phase == SL_PHASE_REFINE && !(part->mesh->node[root].priority > 0.0f)) done += face->count;
        }
    }
    return all > 0.0 ? 0.99 * done / all : 0.0;
}

/* Roughly, for the progress bar alone: to look at all faces that are seen takes a batch's samples longer by a twentieth. */
static double fraction_done(sl_multi_mesh_state *s) {
    if (s->phase == SL_PHASE_DONE) return 1.0;
    if (s->phase == SL_PHASE_VIEW || !s->visible) return 0.0;
    if (s->phase != SL_PHASE_REFINE || s->updates++ % FRACTION_EVERY == 0) s->fraction = share_done(s);
    return s->fraction;
}

static sl_status multi_mesh_update(void *state, sl_progress *progress, sl_error *error) {
    sl_multi_mesh_state *s = state;
    if (!s->raster) return sl_fail(error, SL_ERROR_RESOURCES, "an earlier edit of the scene failed; edit it again");
    sl_status status = SL_OK;
    switch (s->phase) {
    case SL_PHASE_VIEW: status = draw_view(s, error); break;
    case SL_PHASE_FIRST: status = first_vertices(s, error); break;
    case SL_PHASE_REFINE: status = refine_and_extend(s, error); break;
    case SL_PHASE_DONE: break;
    }
    progress->fraction = fraction_done(s);
    progress->frame_done = progress->done = s->phase == SL_PHASE_DONE;
    return status;
}

static void draw_parts(sl_multi_mesh_state *s, sl_merge *merge) {
    static const char *const names[SL_COMPONENTS] = {"direct diffuse radiance", "direct specular radiance", "indirect irradiance"};
    for (int i = 0; i < SL_COMPONENTS; i++) {
        if (!in_view(s->part[i])) continue;
        sl_rgb fallback = i == SL_INDIRECT ? s->ambient : sl_grey(0.0f);
        sl_displayed_draw(s->part[i], s->settings.threads, fallback, s->planes[i], &s->counters);
        sl_announce(&s->announcer, names[i], "image pass 3", s->settings.width, s->settings.height, 3, s->planes[i][0], true);
        sl_multi_mesh_announce_edges(s, (sl_component)i);
        const float **target = i == SL_DIRECT_DIFFUSE ? merge->direct_diffuse : i == SL_DIRECT_SPECULAR ? merge->direct_specular : merge->indirect;
        for (int k = 0; k < 3; k++) target[k] = s->planes[i][k];
    }
}

/* Tells of what lobes leave out where enough is seen of it: a twentieth of the picture. */
static sl_status warn_of_lobes(const sl_multi_mesh_state *s, sl_image *image, sl_error *error) {
    double share = sl_materials_glossy_share(s->materials);
    if (!(share > 0.05)) return SL_OK;
    return sl_warn(image, error, "%.0f %% of the pixels show gloss, which reflects lamps alone: what surfaces and the sky would "
                                 "add to it is missing", 100.0 * share);
}

static sl_status multi_mesh_resolve(void *state, sl_image **image, sl_error *error) {
    sl_multi_mesh_state *s = state;
    if (!s->materials) return sl_image_create(s->settings.width, s->settings.height, 3, NULL, image, error); /* nothing is seen yet */
    sl_merge merge = {.materials = s->materials, .threads = s->settings.threads};
    draw_parts(s, &merge);
    sl_status status = sl_merge_picture(&merge, image, error);
    if (status == SL_OK) status = warn_of_lobes(s, *image, error);
    sl_multi_mesh_announce_lights(s);
    const float *planes = status == SL_OK ? (*image)->planes : NULL;
    sl_announce(&s->announcer, "merge", "image pass 4", s->settings.width, s->settings.height, planes ? 3 : 0, planes, false);
    return status;
}

/* The eye: specular radiance starts again, all else stays. Lights and objects: samples of direct light stay where they still hold. */
static sl_status multi_mesh_edit(void *state, unsigned changes, sl_error *error) {
    sl_multi_mesh_state *s = state;
    sl_status status = SL_OK;
    s->phase = SL_PHASE_VIEW;
    if (changes & (SL_CHANGED_OBJECTS | SL_CHANGED_LIGHTS)) {
        forget_view(s);
        s->full = false;
        s->done_count = 0;
        status = sl_multi_mesh_follow_world(s, error);
        if (status != SL_OK) sl_multi_mesh_forget_world(s);
    } else if (s->part[SL_DIRECT_SPECULAR]) {
        sl_displayed_restart(s->part[SL_DIRECT_SPECULAR]);
    }
    return status;
}

static const sl_counters *multi_mesh_counters(const void *state) { return &((const sl_multi_mesh_state *)state)->counters; }

static size_t multi_mesh_bytes(const void *state) {
    const sl_multi_mesh_state *s = state;
    size_t bytes = sizeof *s + sl_multi_mesh_pixels(s) * (sizeof *s->id + 3 * SL_COMPONENTS * sizeof(float));
    if (s->raster) bytes += sl_raster_memory_bytes(s->raster);
    if (s->tracer) bytes += sl_tracer_memory_bytes(s->tracer);
    if (s->topology) bytes += sl_topology_memory_bytes(s->topology);
    if (s->by_exponent) bytes += sl_topology_memory_bytes(s->by_exponent);
    if (s->sampling) bytes += sl_light_sampling_memory_bytes(s->sampling);
    if (s->irradiance) bytes += sl_irradiance_meshes_bytes(s->irradiance);
    if (s->coarse) bytes += sl_coarse_memory_bytes(s->coarse);
    if (s->coarse_light) bytes += sl_coarse_light_memory_bytes(s->coarse_light);
    if (s->gather) bytes += sl_mesh_gather_memory_bytes(s->gather);
    for (int i = 0; i < SL_COMPONENTS; i++)
        if (s->part[i]) bytes += sl_displayed_memory_bytes(s->part[i]);
    return bytes;
}

static sl_mesh_census census_of(const sl_mesh *mesh, size_t bytes) {
    sl_mesh_census c = {.leaves = mesh->leaf_count, .vertices = mesh->vertex_count, .bytes = bytes};
    for (size_t v = 0; v < mesh->vertex_count; v++) c.known += mesh->state[v] == SL_VERTEX_KNOWN;
    return c;
}

void sl_multi_mesh_census(const void *state, sl_mesh_census census[SL_MESH_KINDS]) {
    const sl_multi_mesh_state *s = state;
    for (int k = 0; k < SL_MESH_KINDS; k++) census[k] = (sl_mesh_census){0};
    for (int i = 0; i < SL_COMPONENTS; i++)
        if (s->part[i]) census[i] = census_of(s->part[i]->mesh, sl_displayed_memory_bytes(s->part[i]));
    for (size_t l = 0; s->irradiance && l < s->lights->count; l++) {
        sl_mesh_census c = census_of(sl_irradiance_mesh(s->irradiance, l), 0), *all = &census[SL_MESH_IRRADIANCE];
        all->leaves += c.leaves;
        all->vertices += c.vertices;
        all->known += c.known;
    }
    if (s->irradiance) census[SL_MESH_IRRADIANCE].bytes = sl_irradiance_meshes_bytes(s->irradiance);
    if (s->coarse) {
        size_t vertices = sl_coarse_vertex_count(s->coarse);
        census[SL_MESH_COARSE] = (sl_mesh_census){sl_coarse_triangle_count(s->coarse), vertices, s->coarse_whole ? vertices : s->coarse_done,
                                                  sl_coarse_memory_bytes(s->coarse)};
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
    .need = sl_multi_mesh_need,
    .concessions = sl_multi_mesh_concessions,
    .filled = sl_multi_mesh_filled,
    .transport = sl_multi_mesh_transport,
    .plan = sl_multi_mesh_plan_write,
    .story = sl_multi_mesh_story,
};
