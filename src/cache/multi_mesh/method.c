/* The method: its state is made, measured and ended; an update takes a step of the picture; an edit makes
 * what that is made from follow the scene, or makes it anew. */
#include "cache/frame/budget.h"
#include "cache/multi_mesh/multi_mesh_internal.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/error.h"
#include "base/memory.h"

/* ---- life ---- */

static void forget_view(sl_multi_mesh_state *s) {
    sl_visible_pixels_destroy(s->visible);
    sl_multi_mesh_forget_materials(s);
    s->visible = NULL;
}

static void multi_mesh_destroy(void *state) {
    sl_multi_mesh_state *s = state;
    if (!s) return;
    forget_view(s);
    sl_multi_mesh_forget_world(s);
    sl_mesh_frames_destroy(s->frames);
    SL_FREE_ALL(s->id, s->plane_memory, s);
}

static sl_status multi_mesh_create(const sl_scene *scene, const sl_settings *settings,
                                   const sl_transport *transport, void **state, sl_error *error) {
    (void)transport; /* its own: sl_multi_mesh_transport() */
    sl_multi_mesh_state *s = sl_allocate(1, sizeof *s);
    if (!s) return sl_fail_memory(error, "the meshes");
    s->scene = scene;
    s->settings = *settings;
    s->world = 1;
    s->plan = sl_multi_mesh_plan_make(scene);
    s->announcer =
        (sl_announcer){.observer = settings->observer, .method = "multi-mesh", .counters = &s->counters};
    const size_t pixels = sl_settings_pixels(settings);
    s->id = sl_allocate(pixels, sizeof *s->id);
    s->plane_memory = sl_allocate(3 * SL_COMPONENTS * pixels, sizeof *s->plane_memory);
    sl_status status =
        s->id && s->plane_memory ? sl_multi_mesh_make_world(s, error) : sl_fail_memory(error, "the picture");
    if (status != SL_OK) {
        multi_mesh_destroy(s);
        return status;
    }
    for (size_t i = 0; i < SL_COMPONENTS; i++)
        for (size_t k = 0; k < 3; k++) s->planes[i][k] = s->plane_memory + (3 * i + k) * pixels;
    *state = s;
    return SL_OK;
}

/* ---- views ---- */

static bool wants_diffuse(const void *context, uint32_t face) {
    return sl_material_is_diffuse(sl_triangle_material(context, face / 2));
}
static bool wants_specular(const void *context, uint32_t face) {
    return sl_material_is_glossy(sl_triangle_material(context, face / 2));
}

static bool (*const wants[SL_COMPONENTS])(const void *, uint32_t) = {wants_diffuse, wants_specular,
                                                                     wants_diffuse};

sl_status sl_multi_mesh_see(sl_multi_mesh_state *s, sl_error *error) {
    sl_status status = SL_OK;
    for (int i = 0; i < SL_COMPONENTS && status == SL_OK; i++)
        if (s->part[i]) status = sl_displayed_see(s->part[i], s->visible, wants[i], s->scene, error);
    memset(s->plane_memory, 0, sl_settings_pixels(&s->settings) * sizeof(float[SL_COMPONENTS][3]));
    return status;
}

/* A picture that was done once is done: what other views have found since shows in it, and would be looked
 * into further without end. */
bool sl_multi_mesh_was_done(const sl_multi_mesh_state *s) {
    for (size_t i = 0; i < s->done_count && i < SL_DONE_VIEWS; i++)
        if (memcmp(&s->done[i], &s->scene->camera, sizeof s->done[i]) == 0) return true;
    return false;
}

static void remember_done(sl_multi_mesh_state *s) {
    if (!s->full && !s->seen_before) s->done[s->done_count++ % SL_DONE_VIEWS] = s->scene->camera;
}

bool sl_multi_mesh_takes_part(const sl_multi_mesh_state *s, int part) {
    bool done = s->seen_before && part != SL_DIRECT_SPECULAR;
    return s->part[part] && !done && (part != SL_INDIRECT || (s->whole.coarse && !s->gathers_wait));
}

int sl_multi_mesh_light_depth(const sl_multi_mesh_state *s, int wanted) {
    if (s->settings.multi_mesh.joint_mesh) return SL_MESH_DEPTH_MAX;
    return s->now.lights->count > 1 ? wanted - 1 : wanted;
}

/* Returns the share that is done, roughly, for the progress bar alone: how far the highest priority has come
 * down from what it was at most. */
static double fraction_of(sl_multi_mesh_state *s) {
    double now = 0.0;
    if (s->phase == SL_PHASE_DONE) return 1.0;
    for (int i = 0; i < SL_COMPONENTS && s->phase == SL_PHASE_REFINE; i++)
        if (sl_multi_mesh_takes_part(s, i)) now = fmax(now, (double)sl_displayed_priority(s->part[i]));
    s->highest = fmax(s->highest, now);
    if (now > 0.0) s->fraction = fmax(s->fraction, 0.99 * (1.0 - sqrt(now / s->highest)));
    return s->fraction;
}

static size_t mesh_bytes(const sl_multi_mesh_state *s) {
    size_t bytes = s->irradiance ? sl_irradiance_meshes_bytes(s->irradiance) : 0;
    for (int i = 0; i < SL_COMPONENTS; i++)
        if (s->part[i]) bytes += sl_displayed_memory_bytes(s->part[i]);
    return bytes;
}

/* Tells whether the meshes have taken what memory they may: asked from the first refinement on. */
static bool is_full(sl_multi_mesh_state *s) {
    if (!s->settings.memory_bytes || s->full) return s->full;
    const size_t bytes = mesh_bytes(s);
    if (!s->bytes_of_roots) s->bytes_of_roots = bytes;
    /* arrays are there twice while they grow */
    s->full = 2.0 * ((double)bytes - (double)s->bytes_of_roots) > (double)s->settings.memory_bytes;
    size_t leaves = 0;
    for (int i = 0; i < SL_COMPONENTS; i++) leaves += s->part[i] ? s->part[i]->mesh->leaves_alive : 0;
    if (s->full) snprintf(s->filled, sizeof s->filled, "meshes end at %zu leaves", leaves);
    return s->full;
}

/* ---- the end of a picture ---- */

static void end_picture(sl_multi_mesh_state *s) {
    sl_multi_mesh_announce_light_sample(s);
    remember_done(s);
    s->phase = SL_PHASE_DONE;
    s->settled = true;
}

/* Leaves were judged by the other components as they were then. Before the end all are judged by what there
 * is now. */
static bool look_again(sl_multi_mesh_state *s) {
    for (int i = 0; i < SL_COMPONENTS; i++) {
        if (!sl_multi_mesh_takes_part(s, i)) continue;
        if (s->world > 1 && !s->judged) sl_displayed_settle_all(s->part[i], &s->counters);
        sl_displayed_prioritise(s->part[i]);
    }
    s->judged = true;
    return sl_multi_mesh_most_urgent(s) >= 0;
}

static bool is_coarse_left(const sl_multi_mesh_state *s) {
    return s->plan.indirect && !sl_coarse_is_of_now(s) && sl_is_in_view(s->part[SL_INDIRECT]);
}

/* While light moves an update takes long where the coarse mesh is large, and shadows are to be found soon:
 * batches go on while a leaf counts as much as a 512th of the picture by a threshold. */
static sl_status refine_more(sl_multi_mesh_state *s, sl_error *error) {
    enum { BATCHES = 16, PART = 512 };
    const float large = (float)s->settings.width * (float)s->settings.height / PART;
    sl_status status = SL_OK;
    size_t served = 1;
    for (int k = 1; k < BATCHES && status == SL_OK && served > 0; k++) {
        const int part = sl_multi_mesh_most_urgent(s);
        if (part < 0 || sl_displayed_priority(s->part[part]) < large) break;
        status = sl_multi_mesh_refine(s, &served, error);
    }
    return status;
}

static sl_status refine_or_end(sl_multi_mesh_state *s, sl_error *error) {
    size_t served = 0;
    bool full = is_full(s);
    sl_status status = full ? SL_OK : sl_multi_mesh_refine(s, &served, error);
    if (status == SL_OK && s->moves && served > 0) status = refine_more(s, error);
    bool idle = served == 0 && !s->old_left && !is_coarse_left(s);
    if (status == SL_OK && idle && (full || !look_again(s))) end_picture(s);
    return status;
}

/* ---- an update ---- */

/* From then on frames may show it: the most visible edges of light are split, or while something moves at
 * least some roots lit. */
static void note_light(sl_multi_mesh_state *s) {
    bool refines = s->phase == SL_PHASE_REFINE && s->fraction >= 0.25;
    bool begins = s->is_edited && s->phase >= SL_PHASE_FIRST;
    s->has_light = s->has_light || refines || begins || s->phase == SL_PHASE_DONE;
}

/* The first picture: one phase after the other. */
static sl_status update_phase(sl_multi_mesh_state *s, sl_error *error) {
    switch (s->phase) {
    case SL_PHASE_VIEW: return sl_multi_mesh_draw_view(s, error);
    case SL_PHASE_FIRST: return sl_multi_mesh_first_vertices(s, error);
    case SL_PHASE_REFINE: break;
    case SL_PHASE_DONE: return SL_OK;
    }
    sl_status status = refine_or_end(s, error);
    return status == SL_OK && is_coarse_left(s) ? sl_multi_mesh_extend_coarse(s, error) : status;
}

/* Once there has been an edit an update has a share for each: the view if it has changed, the coarse mesh,
 * vertices that faces lack which have come into view, what edits have made old, refinement. So leaves are cut
 * and put together whatever moves, and however often. */
static sl_status update_shares(sl_multi_mesh_state *s, sl_error *error) {
    if (s->phase == SL_PHASE_DONE) return SL_OK;
    sl_status status = s->phase == SL_PHASE_VIEW ? sl_multi_mesh_draw_view(s, error) : SL_OK;
    if (status == SL_OK && is_coarse_left(s)) status = sl_multi_mesh_extend_coarse(s, error);
    if (status == SL_OK && s->phase == SL_PHASE_FIRST) status = sl_multi_mesh_first_vertices(s, error);
    if (status == SL_OK) status = sl_multi_mesh_renew(s, error);
    return status == SL_OK ? refine_or_end(s, error) : status;
}

static sl_status multi_mesh_update(void *state, sl_progress *progress, sl_error *error) {
    sl_multi_mesh_state *s = state;
    sl_status status = SL_OK;
    s->updates++;
    if (s->is_edited) status = update_shares(s, error);
    else status = update_phase(s, error);
    progress->fraction = fraction_of(s);
    progress->frame_done = progress->done = s->phase == SL_PHASE_DONE;
    note_light(s);
    return status == SL_OK && s->has_light ? sl_multi_mesh_show(s, error) : status;
}

/* ---- an edit ---- */

static sl_status make_anew(sl_multi_mesh_state *s, sl_error *error) {
    forget_view(s);
    sl_multi_mesh_forget_world(s);
    s->full = s->has_light = false;
    s->made++;
    s->plan = sl_multi_mesh_plan_make(s->scene); /* light may fall where none fell */
    sl_status status = sl_multi_mesh_make_world(s, error);
    if (status != SL_OK) sl_multi_mesh_forget_world(s);
    return status;
}

/* Lights and objects: what cannot have changed stays as it is, all else is seen until it is renewed. */
static sl_status edit_world(sl_multi_mesh_state *s, unsigned changes, sl_error *error) {
    bool followed = false;
    s->done_count = 0;
    s->moves = !s->settled;
    s->settled = false;
    sl_multi_mesh_hasten_coarse(s);
    s->gathers_wait = sl_coarse_is_of_now(s) || (s->gathers_wait && !s->next.coarse && !s->whole.rolls);
    s->world++;
    if (changes & (SL_CHANGED_OBJECTS | SL_CHANGED_LIGHTS)) s->lit = s->world;
    s->judged = false;
    s->updates = 0;
    if (s->whole.coarse && changes & SL_CHANGED_MATERIALS) s->whole.coarse->reflectance_known = false;
    if (!s->change_waits) s->change_world = s->world;
    s->change_waits = true;
    sl_status status = s->raster && !s->full ? sl_multi_mesh_follow(s, changes, &followed, error) : SL_OK;
    if (status == SL_OK && !followed) return make_anew(s, error);
    if (status == SL_OK) return SL_OK;
    forget_view(s);
    sl_multi_mesh_forget_world(s);
    s->settled = true; /* the next one begins anew */
    return status;
}

/* The eye: specular radiance starts again, all else stays. */
static sl_status multi_mesh_edit(void *state, unsigned changes, sl_error *error) {
    sl_multi_mesh_state *s = state;
    s->phase = SL_PHASE_VIEW;
    s->is_edited = true;
    if (changes & SL_CHANGED_CAMERA && s->part[SL_DIRECT_SPECULAR])
        sl_displayed_restart(s->part[SL_DIRECT_SPECULAR]);
    bool world = changes & ~(unsigned)SL_CHANGED_CAMERA;
    return world ? edit_world(s, changes, error) : SL_OK;
}

/* ---- memory ---- */

/* IDs 4, three Gouraud planes 36, materials 28, the pixels by face 16, the picture 84. For each triangle
 * three meshes have a root (its node, its corners and edges, what they are on the screen), there are the
 * primitives, and a coarse mesh. Refinement has no use for less than a thousand leaves. */
enum {
    A_PIXEL = 176,
    OF_GLOSS = 24,
    A_TRIANGLE = 760,
    A_COARSE = 320,
    AN_IRRADIANCE = 120,
    LEAVES_LEAST = 1000,
    A_LEAF = 200,
    A_CELL = 160
};

/* Returns bytes of the coarse mesh, whose edges are its own: pieces of the surface, as large as the scene's
 * box six times over. */
static double coarse_bytes(const sl_scene *scene, const sl_settings *settings) {
    const double edge = sl_multi_mesh_coarse_edge(scene, settings), d = (double)scene->diagonal;
    double pieces = 4.0 * 6.0 * d * d / (edge * edge), finest = (double)scene->triangle_count;
    for (int i = 0; i < settings->multi_mesh.coarse_depth; i++) finest *= 4.0;
    return 2.0 * (pieces < finest ? pieces : finest) * A_COARSE; /* as many again where light differs */
}

static sl_memory_need multi_mesh_need(const sl_scene *scene, const sl_settings *settings) {
    const sl_multi_mesh_plan plan = sl_multi_mesh_plan_make(scene);
    const double triangles = (double)scene->triangle_count, n = settings->gather_size,
                 l = settings->multi_mesh.light_size;
    const double lights = sl_need_lights(scene);
    double caches = triangles * A_TRIANGLE + (plan.indirect ? coarse_bytes(scene, settings) : 0.0) +
                    LEAVES_LEAST * A_LEAF;
    caches += sl_need_of_threads(settings, A_CELL * (n * n + l * l)) + lights * 2000.0 + 3e6;
    return (sl_memory_need){.hierarchies = plan.lights ? sl_tracer_memory_need(scene) +
                                                             sl_raster_memory_kept(scene->triangle_count)
                                                       : sl_raster_memory_need(scene->triangle_count),
                            .caches = caches,
                            .picture =
                                sl_need_of_pixels(settings, A_PIXEL + (plan.specular_seen ? OF_GLOSS : 0))};
}

static const char *multi_mesh_filled(const void *state) {
    const sl_multi_mesh_state *s = state;
    return s->full ? s->filled : NULL;
}

/* ---- the method ---- */

static size_t bytes_of_rounds(const sl_coarse_rounds *r, size_t lights) {
    if (!r->coarse) return 0;
    size_t of_vertex = (r->direct ? sizeof *r->direct : 0) + (r->indirect ? sizeof *r->indirect : 0) +
                       (r->shares ? lights * sizeof *r->shares : 0) +
                       (r->rolls ? sizeof *r->area + sizeof *r->lit_in : 0);
    size_t bytes = sl_coarse_memory_bytes(r->coarse) + r->coarse->vertex_count * of_vertex;
    for (int i = 0; i < SL_GATHER_DETAILS; i++)
        if (r->eye[i].gather) bytes += sl_gather_memory_bytes(r->eye[i].gather);
    return bytes;
}

static size_t multi_mesh_bytes(const void *state) {
    const sl_multi_mesh_state *s = state;
    const size_t lights = s->now.lights ? s->now.lights->count : 0;
    size_t bytes = sizeof *s + sl_settings_pixels(&s->settings) * sizeof(float[1 + 3 * SL_COMPONENTS]);
    if (s->raster) bytes += sl_raster_memory_bytes(s->raster);
    if (s->now.tracer) bytes += sl_tracer_memory_bytes(s->now.tracer);
    if (s->primitives) bytes += sl_primitives_memory_bytes(s->primitives);
    if (s->now.sampling) bytes += sl_light_sampling_memory_bytes(s->now.sampling);
    bytes += bytes_of_rounds(&s->whole, lights) + bytes_of_rounds(&s->next, lights) +
             sl_coarse_kept_bytes(&s->kept);
    return bytes + mesh_bytes(s) + sl_mesh_frames_bytes(s->frames);
}

const sl_method_class sl_multi_mesh_method = {
    .name = "multi-mesh",
    .complete = sl_multi_mesh_complete,
    .create = multi_mesh_create,
    .destroy = multi_mesh_destroy,
    .update = multi_mesh_update,
    .resolve = sl_multi_mesh_resolve,
    .edit = multi_mesh_edit,
    .tells_apart = SL_CHANGED_POWER | SL_CHANGED_MATERIALS,
    .counters_at = offsetof(sl_multi_mesh_state, counters),
    .memory_bytes = multi_mesh_bytes,
    .need = multi_mesh_need,
    .filled = multi_mesh_filled,
    .transport = sl_multi_mesh_transport,
    .plan = sl_multi_mesh_plan_write,
    .raster_at = offsetof(sl_multi_mesh_state, raster),
    .window = &sl_multi_mesh_window,
    .explanation = sl_multi_mesh_explanation,
};
