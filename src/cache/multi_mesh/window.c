/* Frames beside updates. An update leaves copies of the meshes, when it has light everywhere; another thread
 * draws them from where its own copy of the scene stands, geometry and eye included. Of two sets of copies
 * one is drawn from while the other is written to; neither waits: an update whose set is still being drawn
 * leaves none, unless it is the last. */
#include "cache/multi_mesh/multi_mesh_internal.h"

#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "base/math.h"
#include "base/parallel.h"
#include "cache/frame/picture_value.h"
#include "cache/patches/display/copies.h"

struct sl_mesh_frames {
    sl_copies copies;
    struct mesh_copies {
        sl_patches *part[SL_COMPONENTS]; /* NULL: there is none */
        sl_rgb ambient;        /* indirect irradiance where no mesh has any */
        uint32_t made;         /* which of the method's worlds they are of */
    } set[2];
};
typedef struct mesh_copies mesh_copies;

/* What a leaf shows. */
typedef struct shown_leaf {
    sl_patch_place found, at; /* itself, and the nearest of it and its ancestors where anything is known */
    sl_fan_shown fan;         /* in its worker's room */
    bool known;
} shown_leaf;

/* A worker's leaves of a mesh, each in the place of its number modulo LEAVES: kept for as long as the same
 * copies are shown, so that a camera that moves finds what it saw before. */
enum { LEAVES = 1 << 15, SPOKES = 1 << 16, VALUES = 3 * LEAVES + SPOKES };
typedef struct kept_leaves {
    uint32_t patch[LEAVES];   /* SL_NO_INDEX: none */
    shown_leaf leaf[LEAVES];
    float value[VALUES][3];
    sl_fan_spoke spoke[SPOKES];
    size_t values, spokes;    /* in use */
} kept_leaves;

typedef struct window {
    sl_mesh_frames *frames;
    const sl_scene *scene;
    sl_settings settings;
    sl_raster *raster;
    sl_primitives *primitives; /* as the scene copy has them */
    uint32_t made;             /* the world for which they were found */
    unsigned threads;
    uint32_t *id;
    kept_leaves **kept;        /* for each mesh, for each thread; NULL: not needed yet */
    uint64_t kept_of;          /* the copies that they are of */
} window;

/* ---- the update's side ----------------------------------------------------------------------- */

void sl_mesh_frames_destroy(sl_mesh_frames *f) {
    if (!f) return;
    for (int i = 0; i < 2 * SL_COMPONENTS; i++) sl_patches_destroy(f->set[i % 2].part[i / 2]);
    sl_monitor_close(&f->copies.swap);
    sl_free(f);
}

size_t sl_mesh_frames_bytes(const sl_mesh_frames *f) {
    size_t bytes = 0;
    for (int i = 0; f && i < 2 * SL_COMPONENTS; i++) {
        const sl_patches *copy = f->set[i % 2].part[i / 2];
        if (copy) bytes += sl_patches_memory_bytes(copy);
    }
    return bytes;
}

static sl_status frames_create(sl_mesh_frames **frames, sl_error *error) {
    sl_mesh_frames *f = *frames ? *frames : sl_allocate(1, sizeof *f);
    if (!f) return sl_fail_memory(error, "frames beside updates");
    if (!*frames && !sl_monitor_open(&f->copies.swap)) {
        sl_free(f);
        return sl_fail(error, SL_ERROR_RESOURCES, "no lock could be had for frames beside updates");
    }
    *frames = f;
    return SL_OK;
}

static sl_status copy_part(const sl_displayed *part, sl_patches **copy, sl_error *error) {
    if (part && part->mesh->root_count) return sl_patches_copy(part->mesh, copy, error);
    sl_patches_destroy(*copy);
    *copy = NULL;
    return SL_OK;
}

/* The last state waits for a frame that is drawn from what it would write to, since no other follows. */
sl_status sl_multi_mesh_show(sl_multi_mesh_state *s, sl_error *error) {
    sl_mesh_frames *f = s->frames;
    int hidden = f ? sl_copies_hidden(&f->copies, s->phase == SL_PHASE_DONE) : -1;
    sl_status status = SL_OK;
    if (hidden < 0) return SL_OK;
    mesh_copies *set = &f->set[hidden];
    for (int i = 0; i < SL_COMPONENTS && status == SL_OK; i++)
        status = copy_part(s->part[i], &set->part[i], error);
    if (status != SL_OK) return status;
    set->ambient = s->plan.indirect ? s->ambient_in_motion : sl_grey(0.0f);
    set->made = s->made;
    sl_copies_swap(&f->copies);
    return SL_OK;
}

/* ---- the window's side ----------------------------------------------------------------------- */

static size_t kept_count(const window *w) { return SL_COMPONENTS * (size_t)sl_thread_count(w->threads); }

static void window_destroy(void *it) {
    window *w = it;
    if (!w) return;
    for (size_t i = 0; w->kept && i < kept_count(w); i++) sl_free(w->kept[i]);
    sl_primitives_destroy(w->primitives);
    sl_raster_destroy(w->raster);
    SL_FREE_ALL(w->id, w->kept, w);
}

static sl_status window_open(window *w, sl_error *error) {
    size_t pixels = sl_settings_pixels(&w->settings);
    w->id = sl_allocate(pixels, sizeof *w->id);
    w->kept = sl_allocate(kept_count(w), sizeof *w->kept);
    if (!w->id || !w->kept) return sl_fail_memory(error, "frames beside updates");
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
    sl_status status = frames_create(&s->frames, error);
    w->frames = s->frames;
    if (status == SL_OK) status = window_open(w, error);
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

static void forget_leaves(kept_leaves *k) {
    for (size_t i = 0; i < LEAVES; i++) k->patch[i] = SL_NO_INDEX;
    k->values = k->spokes = 0;
}

static sl_fan_shown keep_fan(const sl_mesh_fan *fan, kept_leaves *k) {
    sl_fan_shown kept = sl_mesh_fan_shows(fan);
    kept.value = memcpy(k->value + k->values, fan->value, (3 + fan->count) * sizeof *fan->value);
    kept.spoke = memcpy(k->spoke + k->spokes, fan->spoke, fan->count * sizeof *fan->spoke);
    k->values += 3 + fan->count;
    k->spokes += fan->count;
    return kept;
}

/* Makes a leaf, in place of another that may be there. Where room for values ends all are forgotten. */
static void make_leaf(const sl_patches *mesh, uint32_t found, kept_leaves *k) {
    sl_mesh_fan fan;
    if (k->values + SL_FAN_VERTICES > VALUES || k->spokes + SL_FAN_VERTICES > SPOKES) forget_leaves(k);
    shown_leaf *leaf = &k->leaf[found % LEAVES];
    k->patch[found % LEAVES] = found;
    leaf->found = leaf->at = sl_patch_place_of(mesh, found);
    leaf->known = sl_mesh_fan_shown(mesh, &leaf->at, true, &fan);
    if (leaf->known) leaf->fan = keep_fan(&fan, k);
}

/* root: its patch. */
static const shown_leaf *find_leaf(const sl_patches *mesh, uint32_t root, float w1, float w2,
                                   kept_leaves *k) {
    double a, b;
    sl_mesh_clamp_weights(w1, w2, &a, &b);
    const uint32_t found = sl_patch_leaf_at(mesh, root, 3, a, b);
    if (k->patch[found % LEAVES] != found) make_leaf(mesh, found, k);
    return &k->leaf[found % LEAVES];
}

/* Returns how many of the points have the first one's leaf, whose values these are. */
static size_t values_of(const shown_leaf *leaf, sl_isa isa, size_t count, const float *w1, const float *w2,
                        float value[3][SL_FAN_LANES]) {
    float a[SL_FAN_LANES], b[SL_FAN_LANES];
    const size_t run = SL_KERNEL_OF(isa, sl_mesh_run)(&leaf->found, count, w1, w2, a, b);
    if (!leaf->known) return run;
    if (leaf->at.patch != leaf->found.patch)
        (void)SL_KERNEL_OF(isa, sl_mesh_run)(&leaf->at, run, w1, w2, a, b);
    SL_KERNEL_OF(isa, sl_mesh_fan_values)(&leaf->fan, a, b, value);
    return run;
}

/* ---- a frame's pixels ------------------------------------------------------------------------ */

typedef struct drawing {
    const window *window;
    const mesh_copies *set;
    sl_view view;
    sl_isa isa;
    float *out;
} drawing;

/* Pixels of a triangle side by side in a row, and what lights them. */
enum { PIECE = 64 };
typedef struct piece {
    size_t first, count;
    uint32_t triangle, face;
    const float *w1, *w2, *diffuse[3];
    float light[SL_COMPONENTS][3][PIECE];
} piece;

/* The Gouraud pass interpolates a place (u, v) in the root. */
static void places(const void *context, uint32_t triangle, float *value) {
    sl_root_corner_parameters(((const drawing *)context)->window->primitives, triangle, value);
}

static void set_light(piece *p, size_t part, sl_rgb light) {
    const float colour[3] = {light.r, light.g, light.b};
    for (int c = 0; c < 3; c++)
        for (size_t i = 0; i < p->count; i++) p->light[part][c][i] = colour[c];
}

/* Lights pixels of a face, leaf by leaf. Where a mesh knows nothing ambient light is shown. */
static void light_piece(const drawing *d, size_t part, kept_leaves *kept, piece *p) {
    const sl_patches *mesh = d->set->part[part];
    const uint32_t root = sl_patches_find_root(mesh, p->face);
    set_light(p, part, part == SL_INDIRECT ? d->set->ambient : sl_grey(0.0f));
    if (root == SL_NO_INDEX) return;
    for (size_t i = 0; i < p->count;) {
        const size_t left = p->count - i < SL_FAN_LANES ? p->count - i : SL_FAN_LANES;
        float value[3][SL_FAN_LANES];
        const shown_leaf *leaf = find_leaf(mesh, root, p->w1[i], p->w2[i], kept);
        const size_t run = values_of(leaf, d->isa, left, p->w1 + i, p->w2 + i, value);
        for (int c = 0; c < 3 && leaf->known; c++)
            memcpy(&p->light[part][c][i], value[c], run * sizeof(float));
        i += run;
    }
}

/* Adds kd U_dd, ks U_ds and kd E_i / pi, as sl_multi_mesh_merge() does. */
static void add_light(size_t count, const float *restrict light, const float *restrict kd, float ks,
                      float scale, float *restrict sum) {
#pragma omp simd
    for (size_t i = 0; i < count; i++) sum[i] += sl_picture_value((kd ? kd[i] : ks) * (light[i] * scale));
}

static void put_piece(const drawing *d, const piece *p) {
    const sl_scene *s = d->window->scene;
    const size_t width = (size_t)d->view.width, pixels = width * (size_t)d->view.height,
                 to = pixels - width * (p->first / width + 1) + p->first % width;
    const sl_rgb ks = sl_triangle_material(s, p->triangle)->specular,
                 lamp = sl_view_emission(&d->view, s, p->triangle, 0, 0);
    const float specular[3] = {ks.r, ks.g, ks.b}, emission[3] = {lamp.r, lamp.g, lamp.b};
    for (size_t c = 0; c < 3; c++) {
        float *sum = d->out + c * pixels + to;
        memset(sum, 0, p->count * sizeof *sum);
        for (size_t part = 0; part < SL_COMPONENTS; part++)
            if (d->set->part[part])
                add_light(p->count, p->light[part][c], part == SL_DIRECT_SPECULAR ? NULL : p->diffuse[c],
                          specular[c], part == SL_INDIRECT ? (float)(1.0 / SL_PI) : 1.0f, sum);
        for (size_t i = 0; i < p->count; i++) sum[i] = sl_picture_value(sum[i] + emission[c]);
    }
}

static void put_background(const drawing *d, size_t pixel) {
    const size_t width = (size_t)d->view.width, pixels = width * (size_t)d->view.height,
                 x = pixel % width, y = pixel / width;
    const sl_rgb seen = sl_view_emission(&d->view, d->window->scene, SL_NO_INDEX, x, y);
    float *out = d->out + pixels - width * (y + 1) + x;
    out[0] = sl_picture_value(seen.r);
    out[pixels] = sl_picture_value(seen.g);
    out[2 * pixels] = sl_picture_value(seen.b);
}

static size_t length_of_piece(const drawing *d, const sl_gouraud_pixels *p, size_t i) {
    const size_t width = (size_t)d->view.width, row = width - (p->first + i) % width;
    size_t most = p->count - i < row ? p->count - i : row, count = 1;
    if (most > PIECE) most = PIECE;
    while (count < most && p->id[i + count] == p->id[i]) count++;
    return count;
}

static void draw_strip(void *context, const sl_gouraud_pixels *p) {
    const drawing *d = context;
    kept_leaves *const *kept = d->window->kept + p->worker * SL_COMPONENTS;
    piece now = {.triangle = SL_NO_INDEX};
    for (size_t i = 0; i < p->count; i += now.count) {
        now.count = p->id[i] == SL_NO_INDEX ? 1 : length_of_piece(d, p, i);
        if (p->id[i] == SL_NO_INDEX) {
            put_background(d, p->first + i);
            continue;
        }
        if (p->id[i] != now.triangle)
            now.face = sl_root_seen(d->window->primitives, d->window->scene, p->id[i], d->view.origin);
        now.triangle = p->id[i];
        now.first = p->first + i;
        now.w1 = p->value[0] + i;
        now.w2 = p->value[1] + i;
        for (int c = 0; c < 3; c++) now.diffuse[c] = p->diffuse[c] + i;
        for (size_t part = 0; part < SL_COMPONENTS; part++)
            if (d->set->part[part]) light_piece(d, part, kept[part], &now);
        put_piece(d, &now);
    }
}

/* Makes what keeps leaves of the meshes that there are; other copies' leaves are forgotten. */
static sl_status follow_copies(window *w, const mesh_copies *set, uint64_t versions, sl_error *error) {
    for (size_t i = 0; i < kept_count(w); i++) {
        kept_leaves *k = w->kept[i];
        const bool made = !k && set->part[i % SL_COMPONENTS];
        if (made) k = w->kept[i] = sl_allocate_unset(1, sizeof *k);
        if (made && !k) return sl_fail_memory(error, "frames beside updates");
        if (made || (k && w->kept_of != versions)) forget_leaves(k);
    }
    w->kept_of = versions;
    return SL_OK;
}

static sl_status draw_set(window *w, const mesh_copies *set, uint64_t versions, sl_image *image,
                          sl_counters *counters, sl_error *error) {
    drawing d = {.window = w,
                 .set = set,
                 .view = sl_view_scene(w->scene, w->settings.width, w->settings.height),
                 .isa = sl_isa_best(),
                 .out = image->planes};
    const sl_target target = {w->settings.width, w->settings.height, w->id, NULL};
    const sl_gouraud_pass pass = {
        .channels = 2, .corners = places, .textured = true, .shade = draw_strip, .context = &d};
    sl_status status = follow_structure(w, set->made, error);
    if (status == SL_OK) status = follow_copies(w, set, versions, error);
    if (status == SL_OK) status = sl_raster_id(w->raster, &d.view, w->threads, &target, counters, error);
    if (status != SL_OK) return status;
    for (size_t i = 0; i < SL_COMPONENTS; i++)
        if (set->part[i]) set->part[i]->primitives = w->primitives;
    sl_raster_gouraud(w->raster, &d.view, w->threads, w->id, &pass, counters);
    return SL_OK;
}

static sl_status window_draw(void *it, sl_image *image, uint64_t *versions, sl_counters *counters,
                             sl_error *error) {
    window *w = it;
    const int set = sl_copies_take(&w->frames->copies, versions);
    /* before the first it is black, as it was made */
    sl_status status =
        *versions ? draw_set(w, &w->frames->set[set], *versions, image, counters, error) : SL_OK;
    sl_copies_give_back(&w->frames->copies, set);
    return status;
}

static const uint32_t *window_ids(const void *it) { return ((const window *)it)->id; }

const sl_window_class sl_multi_mesh_window = {.create = window_create,
                                              .destroy = window_destroy,
                                              .move = window_move,
                                              .ids = window_ids,
                                              .draw = window_draw};
