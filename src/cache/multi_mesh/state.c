/* The state of a picture: how it is made, measured, and what it takes. */
#include "cache/frame/budget.h"
#include "cache/multi_mesh/multi_mesh_internal.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/error.h"
#include "base/memory.h"

/* ---- life ---- */

void sl_multi_mesh_forget_view(sl_multi_mesh_state *s) {
    sl_visible_pixels_destroy(s->visible);
    sl_materials_destroy(s->materials);
    s->visible = NULL;
    s->materials = NULL;
}

static void multi_mesh_destroy(void *state) {
    sl_multi_mesh_state *s = state;
    if (!s) return;
    sl_multi_mesh_forget_view(s);
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

/* Tells whether any visible face needs a pass. A pass that no visible face needs is skipped. */
static bool shows(const sl_multi_mesh_state *s, bool (*has)(const void *, uint32_t)) {
    for (size_t f = 0; f < s->visible->face_count; f++)
        if (has(s->scene, s->visible->face[f].face)) return true;
    return false;
}

static bool shines(const void *context, uint32_t face) {
    return sl_material_is_emitter(sl_triangle_material(context, face / 2));
}

static void announce_material(sl_multi_mesh_state *s, const char *name, const float *planes) {
    const sl_settings *of = &s->settings;
    if (planes) sl_announce(&s->announcer, name, "image pass 2", of->width, of->height, 3, planes, true);
}

sl_status sl_multi_mesh_see_materials(sl_multi_mesh_state *s, const sl_view *view, sl_error *error) {
    bool sky = s->scene->environment.present && s->visible->count < sl_settings_pixels(&s->settings);
    sl_materials_wanted wanted = {.specular = s->plan.specular_seen && shows(s, wants_specular),
                                  .emission = s->plan.emission && (sky || shows(s, shines))};
    sl_status status = sl_materials_resolve(s->scene, s->raster, view, s->id, wanted, s->settings.threads,
                                            &s->materials, &s->counters, error);
    if (status != SL_OK) return status;
    announce_material(s, "material: k_d", s->materials->diffuse[0]);
    announce_material(s, "material: k_s", s->materials->specular[0]);
    return SL_OK;
}

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

void sl_multi_mesh_remember_done(sl_multi_mesh_state *s) {
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
double sl_multi_mesh_fraction(sl_multi_mesh_state *s) {
    double now = 0.0;
    if (s->phase == SL_PHASE_DONE) return 1.0;
    for (int i = 0; i < SL_COMPONENTS && s->phase == SL_PHASE_REFINE; i++)
        if (sl_multi_mesh_takes_part(s, i)) now = fmax(now, (double)sl_displayed_priority(s->part[i]));
    s->highest = fmax(s->highest, now);
    if (now > 0.0) s->fraction = fmax(s->fraction, 0.99 * (1.0 - sqrt(now / s->highest)));
    return s->fraction;
}

/* Tells of what lobes leave out where enough is seen of it: a twentieth of the picture. */
sl_status sl_multi_mesh_warn_of_lobes(const sl_multi_mesh_state *s, sl_image *image, sl_error *error) {
    double share = sl_materials_glossy_share(s->materials);
    if (!(share > 0.05)) return SL_OK;
    return sl_warn(
        image, error,
        "%.0f %% of the pixels show gloss, which reflects lamps alone: what surfaces and the sky would "
        "add to it is missing",
        100.0 * share);
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

static double mesh_bytes(const sl_multi_mesh_state *s) {
    double bytes = s->irradiance ? (double)sl_irradiance_meshes_bytes(s->irradiance) : 0.0;
    for (int i = 0; i < SL_COMPONENTS; i++)
        if (s->part[i]) bytes += (double)sl_displayed_memory_bytes(s->part[i]);
    return bytes;
}

bool sl_multi_mesh_is_full(sl_multi_mesh_state *s) {
    if (!s->settings.memory_bytes || s->full) return s->full;
    double bytes = mesh_bytes(s);
    if (!s->bytes_of_roots) s->bytes_of_roots = (size_t)bytes;
    /* arrays are there twice while they grow */
    s->full = 2.0 * (bytes - (double)s->bytes_of_roots) > (double)s->settings.memory_bytes;
    size_t leaves = 0;
    for (int i = 0; i < SL_COMPONENTS; i++) leaves += s->part[i] ? s->part[i]->mesh->leaves_alive : 0;
    if (s->full) snprintf(s->filled, sizeof s->filled, "meshes end at %zu leaves", leaves);
    return s->full;
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
    if (s->irradiance) bytes += sl_irradiance_meshes_bytes(s->irradiance);
    bytes += bytes_of_rounds(&s->whole, lights) + bytes_of_rounds(&s->next, lights) +
             sl_coarse_kept_bytes(&s->kept);
    for (int i = 0; i < SL_COMPONENTS; i++)
        if (s->part[i]) bytes += sl_displayed_memory_bytes(s->part[i]);
    return bytes + sl_mesh_frames_bytes(s->frames);
}

const sl_method_class sl_multi_mesh_method = {
    .name = "multi-mesh",
    .complete = sl_multi_mesh_complete,
    .create = multi_mesh_create,
    .destroy = multi_mesh_destroy,
    .update = sl_multi_mesh_update,
    .resolve = sl_multi_mesh_resolve,
    .edit = sl_multi_mesh_edit,
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
