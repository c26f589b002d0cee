/* Frames beside updates. An update leaves copies of the meshes, when it has light everywhere; another thread
 * draws them from where its own copy of the scene stands, geometry and eye included. Of two sets of copies
 * one is drawn from while the other is written to; neither waits: an update whose set is still being drawn
 * leaves none. */
#include "cache/multi_mesh/window.h"

#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/thread.h"
#include "cache/multi_mesh/multi_mesh_internal.h"

typedef struct mesh_copies {
    sl_patches *part[SL_COMPONENTS]; /* NULL: there is none */
    sl_rgb ambient;            /* indirect irradiance where no mesh has any */
    uint32_t made;             /* which of the method's worlds they are of */
} mesh_copies;

/* Shared by the method and a window, until both are gone. */
struct sl_mesh_exchange {
    sl_monitor meeting;        /* guards what follows but for the copies themselves */
    int owners;
    int shown, drawn;          /* the newest set, and the one that a frame is drawn from; -1: none */
    uint64_t versions;
    mesh_copies set[2];
};

/* What a leaf shows; a worker keeps the last ones. */
typedef struct shown_leaf {
    sl_patch_place found, at; /* itself, and the nearest of it and its ancestors where anything is known */
    sl_mesh_fan fan;
    bool known;
} shown_leaf;

enum { LEAVES = 64 };

typedef struct window {
    sl_mesh_exchange *exchange;
    const sl_scene *scene;
    sl_settings settings;
    sl_raster *raster;
    sl_primitives *primitives; /* as the scene copy has them */
    uint32_t made;             /* the world for which they were found */
    unsigned threads;
    uint32_t *id;
    float *planes;             /* three for each mesh */
    shown_leaf *leaves;        /* LEAVES for each thread */
} window;

/* ---- what both share ------------------------------------------------------------------------- */

static void forget_copies(mesh_copies *set) {
    for (int i = 0; i < SL_COMPONENTS; i++) sl_patches_destroy(set->part[i]);
}

void sl_mesh_exchange_leave(sl_mesh_exchange *e) {
    if (!e) return;
    sl_monitor_enter(&e->meeting);
    bool last = --e->owners == 0;
    sl_monitor_leave(&e->meeting);
    if (!last) return;
    for (int i = 0; i < 2; i++) forget_copies(&e->set[i]);
    sl_monitor_close(&e->meeting);
    sl_free(e);
}

size_t sl_mesh_exchange_bytes(const sl_mesh_exchange *e) {
    size_t bytes = 0;
    for (int i = 0; e && i < 2 * SL_COMPONENTS; i++) {
        const sl_patches *copy = e->set[i % 2].part[i / 2];
        if (copy) bytes += sl_patches_memory_bytes(copy);
    }
    return bytes;
}

static sl_status exchange_create(sl_mesh_exchange **exchange, sl_error *error) {
    sl_mesh_exchange *e = sl_allocate(1, sizeof *e);
    if (!e) return sl_fail_memory(error, "frames beside updates");
    *e = (sl_mesh_exchange){.owners = 2, .shown = -1, .drawn = -1};
    if (!sl_monitor_open(&e->meeting)) {
        sl_free(e);
        return sl_fail(error, SL_ERROR_RESOURCES, "no lock could be had for frames beside updates");
    }
    *exchange = e;
    return SL_OK;
}

/* ---- the update's side ----------------------------------------------------------------------- */

/* Returns the set that may be written to; -1: none. */
static int hidden_set(sl_mesh_exchange *e) {
    sl_monitor_enter(&e->meeting);
    int hidden = e->shown == 0 ? 1 : 0;
    if (hidden == e->drawn) hidden = -1;
    sl_monitor_leave(&e->meeting);
    return hidden;
}

static sl_status copy_part(const sl_displayed *part, sl_patches **copy, sl_error *error) {
    if (part && part->mesh->root_count) return sl_patches_copy(part->mesh, copy, error);
    sl_patches_destroy(*copy);
    *copy = NULL;
    return SL_OK;
}

sl_status sl_multi_mesh_show(sl_multi_mesh_state *s, sl_error *error) {
    sl_mesh_exchange *e = s->exchange;
    int hidden = e ? hidden_set(e) : -1;
    sl_status status = SL_OK;
    if (hidden < 0) return SL_OK;
    mesh_copies *set = &e->set[hidden];
    for (int i = 0; i < SL_COMPONENTS && status == SL_OK; i++)
        status = copy_part(s->part[i], &set->part[i], error);
    if (status != SL_OK) return status;
    set->ambient = s->plan.indirect ? s->ambient_in_motion : sl_grey(0.0f);
    set->made = s->made;
    sl_monitor_enter(&e->meeting);
    e->shown = hidden;
    e->versions++;
    sl_monitor_leave(&e->meeting);
    return SL_OK;
}

/* ---- the window's side ----------------------------------------------------------------------- */

static void window_destroy(void *it) {
    window *w = it;
    if (!w) return;
    sl_mesh_exchange_leave(w->exchange);
    sl_primitives_destroy(w->primitives);
    sl_raster_destroy(w->raster);
    SL_FREE_ALL(w->id, w->planes, w->leaves, w);
}

static sl_status window_open(window *w, sl_error *error) {
    size_t pixels = (size_t)w->settings.width * (size_t)w->settings.height;
    w->id = sl_allocate(pixels, sizeof *w->id);
    w->planes = sl_allocate(3 * SL_COMPONENTS * pixels, sizeof *w->planes);
    w->leaves = sl_allocate_unset(sl_thread_count(w->threads), LEAVES * sizeof *w->leaves);
    if (!w->id || !w->planes || !w->leaves) return sl_fail_memory(error, "frames beside updates");
    sl_status status = sl_raster_create(w->scene, w->threads, &w->raster, error);
    return status == SL_OK ? sl_primitives_of_triangles(w->scene, &w->primitives, error) : status;
}

static sl_status window_create(void *state, const sl_scene *scene_copy, unsigned threads, void **made,
                               sl_error *error) {
    sl_multi_mesh_state *s = state;
    window *w = sl_allocate(1, sizeof *w);
    *made = NULL;
    if (!w) return sl_fail_memory(error, "frames beside updates");
    w->scene = scene_copy;
    w->threads = threads;
    w->settings = s->settings;
    w->made = s->made;
    sl_status status = exchange_create(&w->exchange, error);
    if (status == SL_OK) {
        sl_mesh_exchange_leave(s->exchange);
        s->exchange = w->exchange;
        status = window_open(w, error);
    }
    if (status == SL_OK) *made = w;
    else window_destroy(w);
    return status;
}

static sl_status window_move(void *it, sl_error *error) {
    window *w = it;
    return sl_raster_move(w->raster, w->threads, error);
}

/* Corners that were one may have come apart when the method's world was made anew. */
static sl_status follow_structure(window *w, uint32_t made, sl_error *error) {
    if (w->made == made) return SL_OK;
    sl_primitives_destroy(w->primitives);
    w->primitives = NULL;
    w->made = made;
    return sl_primitives_of_triangles(w->scene, &w->primitives, error);
}

/* Each row of a face's pixels comes back to the leaves of the one before. */
static const shown_leaf *find_leaf(const sl_patches *mesh, uint32_t root, float w1, float w2,
                                   shown_leaf *leaves) {
    double a, b;
    sl_mesh_clamp_weights(w1, w2, &a, &b);
    const uint32_t found = sl_patch_leaf_at(mesh, root, 3, a, b);
    shown_leaf *leaf = &leaves[found % LEAVES];
    if (found == leaf->found.patch && found != SL_NO_INDEX) return leaf;
    leaf->found.patch = found;
    leaf->known = false;
    if (found == SL_NO_INDEX) return leaf;
    leaf->found = leaf->at = sl_patch_place_of(mesh, found);
    leaf->known = sl_mesh_fan_shown(mesh, &leaf->at, true, &leaf->fan);
    return leaf;
}

/* Returns how many of the points have the first one's leaf, whose values these are. */
static size_t values_of(const shown_leaf *leaf, sl_isa isa, size_t count, const float *w1, const float *w2,
                        float value[3][SL_FAN_LANES]) {
    float a[SL_FAN_LANES], b[SL_FAN_LANES];
    if (leaf->found.patch == SL_NO_INDEX) return 1;
    const size_t run = SL_KERNEL_OF(isa, sl_mesh_run)(&leaf->found, count, w1, w2, a, b);
    if (!leaf->known) return run;
    if (leaf->at.patch != leaf->found.patch)
        (void)SL_KERNEL_OF(isa, sl_mesh_run)(&leaf->at, run, w1, w2, a, b);
    SL_KERNEL_OF(isa, sl_mesh_fan_values)(&leaf->fan, a, b, value);
    return run;
}

/* Faces of one mesh, so many at a time. */
typedef struct drawing {
    const mesh_copies *set;
    const sl_visible_pixels *seen;
    float *planes[SL_COMPONENTS][3];
    size_t pieces; /* of each mesh */
    sl_isa isa;
    shown_leaf *leaves;
} drawing;

enum { FACES = 32 };

/* Pixels of a face lie side by side: most are in the leaf of the one before. Where a mesh knows nothing
 * `otherwise` shows. */
static void draw_face(const drawing *d, size_t part, const sl_visible_face *face, shown_leaf *leaves) {
    const sl_patches *mesh = d->set->part[part];
    const sl_visible_pixels *seen = d->seen;
    const sl_rgb otherwise = part == SL_INDIRECT ? d->set->ambient : sl_grey(0.0f);
    const float colour[3] = {otherwise.r, otherwise.g, otherwise.b};
    const uint32_t end = face->first + face->count, root = sl_patches_find_root(mesh, face->face);
    for (uint32_t i = face->first; i < end;) {
        const size_t left = end - i < SL_FAN_LANES ? end - i : SL_FAN_LANES;
        float value[3][SL_FAN_LANES];
        const shown_leaf *leaf = find_leaf(mesh, root, seen->w1[i], seen->w2[i], leaves);
        const size_t run = values_of(leaf, d->isa, left, seen->w1 + i, seen->w2 + i, value);
        for (size_t l = 0; l < run; l++, i++)
            for (int c = 0; c < 3; c++)
                d->planes[part][c][seen->pixel[i]] = leaf->known ? value[c][l] : colour[c];
    }
}

static void draw_piece(void *context, size_t index, unsigned worker) {
    const drawing *d = context;
    const size_t part = index / d->pieces, first = index % d->pieces * FACES;
    shown_leaf *leaves = d->leaves + worker * LEAVES;
    if (!d->set->part[part]) return;
    for (size_t i = 0; i < LEAVES; i++) leaves[i].found.patch = SL_NO_INDEX;
    for (size_t f = first; f < first + FACES && f < d->seen->face_count; f++)
        draw_face(d, part, &d->seen->face[f], leaves);
}

static void draw_meshes(window *w, const mesh_copies *set, const sl_visible_pixels *seen, sl_merge *merge) {
    const float **const target[] = {merge->direct_diffuse, merge->direct_specular, merge->indirect};
    const size_t pixels = (size_t)w->settings.width * (size_t)w->settings.height;
    drawing d = {.set = set,
                 .seen = seen,
                 .pieces = (seen->face_count + FACES - 1) / FACES,
                 .isa = sl_isa_best(),
                 .leaves = w->leaves};
    for (size_t i = 0; i < SL_COMPONENTS; i++) {
        if (!set->part[i]) continue;
        set->part[i]->primitives = w->primitives;
        for (size_t c = 0; c < 3; c++) target[i][c] = d.planes[i][c] = w->planes + (3 * i + c) * pixels;
        memset(d.planes[i][0], 0, 3 * pixels * sizeof(float));
    }
    sl_parallel_for(w->threads, SL_COMPONENTS * d.pieces, draw_piece, &d);
}

static sl_status draw_set(window *w, const mesh_copies *set, sl_image *image, sl_counters *counters,
                          sl_error *error) {
    sl_view view = sl_view_scene(w->scene, w->settings.width, w->settings.height);
    sl_target target = {w->settings.width, w->settings.height, w->id, NULL};
    sl_visible_pixels *seen = NULL;
    sl_merge merge = {.threads = w->threads};
    sl_materials_seen *materials = NULL;
    const sl_materials_wanted wanted = {set->part[SL_DIRECT_SPECULAR] != NULL, true};
    sl_status status = follow_structure(w, set->made, error);
    if (status == SL_OK) status = sl_raster_id(w->raster, &view, w->threads, &target, counters, error);
    if (status == SL_OK)
        status = sl_visible_pixels_sort(w->primitives, w->raster, &view, w->id, w->threads, &seen, counters,
                                        error);
    if (status == SL_OK)
        status = sl_materials_resolve(w->scene, w->raster, &view, w->id, wanted, w->threads, &materials,
                                      counters, error);
    if (status == SL_OK) {
        draw_meshes(w, set, seen, &merge);
        merge.materials = materials;
        sl_merge_colours(&merge, image);
    }
    sl_materials_destroy(materials);
    sl_visible_pixels_destroy(seen);
    return status;
}

static int take_set(sl_mesh_exchange *e, uint64_t *versions) {
    sl_monitor_enter(&e->meeting);
    int set = e->drawn = e->shown;
    *versions = e->versions;
    sl_monitor_leave(&e->meeting);
    return set;
}

static void give_set_back(sl_mesh_exchange *e) {
    sl_monitor_enter(&e->meeting);
    e->drawn = -1;
    sl_monitor_leave(&e->meeting);
}

static sl_status window_draw(void *it, sl_image *image, uint64_t *versions, sl_counters *counters,
                             sl_error *error) {
    window *w = it;
    int set = take_set(w->exchange, versions);
    if (set < 0) return SL_OK; /* black, as it was made */
    sl_status status = draw_set(w, &w->exchange->set[set], image, counters, error);
    give_set_back(w->exchange);
    return status;
}

static const uint32_t *window_ids(const void *it) { return ((const window *)it)->id; }

const sl_window_class sl_multi_mesh_window = {.create = window_create,
                                              .destroy = window_destroy,
                                              .move = window_move,
                                              .ids = window_ids,
                                              .draw = window_draw};
