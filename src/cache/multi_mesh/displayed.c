/* A mesh as the eye uses it: which of the id map's pixels show which leaf (image pass 1). Roots are made for
 * faces in view, and pixels handed down their quadtrees: a leaf's count of pixels is exact, also where other
 * things hide part of it. */
#include "cache/multi_mesh/displayed.h"

#include <string.h>

#include "base/counters.h"
#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"
#include "base/parallel.h"

sl_status sl_displayed_create(const sl_primitives *primitives, const sl_displayed_settings *settings,
                              sl_displayed **displayed, sl_error *error) {
    sl_displayed *d = sl_allocate(1, sizeof *d);
    if (!d) return sl_fail_memory(error, "displayed mesh");
    d->settings = *settings;
    d->chain_entry = SL_NO_INDEX;
    d->world = d->put_as = 1;
    const sl_patches_settings mesh = {.channels = 3, .max_depth = settings->max_depth};
    sl_status status = sl_patches_create(primitives, &mesh, &d->mesh, error);
    if (status == SL_OK) status = sl_displayed_grow(d, error);
    if (status == SL_OK) *displayed = d;
    else sl_displayed_destroy(d);
    return status;
}

void sl_displayed_destroy(sl_displayed *d) {
    if (!d) return;
    sl_patches_destroy(d->mesh);
    SL_FREE_ALL(d->first, d->order, d->root, d->highest, d->world_of, d->weight, d->touched, d);
}

size_t sl_displayed_memory_bytes(const sl_displayed *d) {
    return sizeof *d + sl_patches_memory_bytes(d->mesh) +
           (d->patch_capacity + d->order_capacity + d->leaves_room) * sizeof(uint32_t) +
           2 * d->leaves_room * sizeof *d->highest +
           d->vertex_room * (sizeof *d->world_of + sizeof *d->weight) + d->touched_room * sizeof *d->touched;
}

static bool grow_vertices(sl_displayed *d) {
    size_t room = d->mesh->vertex_capacity, used = d->vertex_room;
    if (room <= used) return true;
    if (!sl_regrow(&d->world_of, used, room, sizeof *d->world_of) ||
        !sl_regrow(&d->weight, used, room, sizeof *d->weight))
        return false;
    d->vertex_room = room;
    return true;
}

sl_status sl_displayed_grow(sl_displayed *d, sl_error *error) {
    size_t capacity = d->mesh->patch_capacity, used = d->patch_capacity;
    if (!grow_vertices(d)) return sl_fail_memory(error, "displayed mesh");
    if (capacity <= used) return SL_OK;
    if (!sl_regrow(&d->first, used, capacity, sizeof *d->first))
        return sl_fail_memory(error, "displayed mesh");
    d->patch_capacity = capacity;
    return SL_OK;
}

/* ---- pixels down the quadtrees ---- */

static void visit_below(const sl_displayed *d, const sl_patch_place *place, sl_seen_leaf_visitor *visit,
                        void *context) {
    const sl_patch *node = &d->mesh->patch[place->patch];
    if (node->pixels && node->child == SL_NO_INDEX) visit(place, context);
    for (int c = 0; c < 4 && node->pixels && node->child != SL_NO_INDEX; c++) {
        sl_patch_place child = sl_patch_child_place(d->mesh, place, c);
        visit_below(d, &child, visit, context);
    }
}

void sl_displayed_visit(const sl_displayed *d, size_t entry, sl_seen_leaf_visitor *visit, void *context) {
    if (!sl_displayed_wants(d, entry)) return;
    sl_patch_place root = sl_patch_root_place(d->mesh, d->pixels->face[entry].face);
    visit_below(d, &root, visit, context);
}

enum { CHILD_SHIFT = 30, PIXEL = (1 << CHILD_SHIFT) - 1 };

/* Each child's pixels lie together, and so do those of the whole node. Which child's they are stands in
 * their highest bits meanwhile. */
void sl_displayed_hand_down(sl_displayed *d, const sl_patch_place *place) {
    const sl_visible_pixels *pixels = d->pixels;
    sl_patch *node = &d->mesh->patch[place->patch], *child = &d->mesh->patch[node->child];
    uint32_t first = d->first[place->patch], at = first, end = first + node->pixels;
    for (uint32_t i = first; i < end; i++) {
        const double w1 = (double)pixels->w1[d->order[i]], w2 = (double)pixels->w2[d->order[i]];
        d->order[i] |= (uint32_t)sl_patch_child_at(place, w1, w2) << CHILD_SHIFT;
    }
    for (uint32_t c = 0; c < 4; c++) {
        d->first[node->child + c] = at;
        for (uint32_t i = at; i < end; i++) {
            const uint32_t pixel = d->order[i];
            if (pixel >> CHILD_SHIFT != c) continue;
            d->order[i] = d->order[at];
            d->order[at++] = pixel & PIXEL;
        }
        child[c].pixels = at - d->first[node->child + c];
    }
}

/* Pixels, sizes and priorities of a tree. */
static void see_below(sl_displayed *d, const sl_patch_place *place) {
    sl_patch *node = &d->mesh->patch[place->patch];
    bool is_leaf = node->child == SL_NO_INDEX,
         judged = is_leaf || sl_all_edges_closed(node) || d->settings.probed_area > 0.0f;
    if (node->pixels > 1 && judged) sl_displayed_judge_size(d, place);
    node->priority = 0.0f;
    if (is_leaf) {
        node->priority = sl_displayed_leaf_priority(d, place);
        return;
    }
    sl_displayed_hand_down(d, place);
    for (int c = 0; c < 4; c++) {
        const sl_patch *child = &d->mesh->patch[node->child + (uint32_t)c];
        if (!child->pixels) continue; /* all is 0 below */
        sl_patch_place below = sl_patch_child_place(d->mesh, place, c);
        see_below(d, &below);
        node->priority = child->priority > node->priority ? child->priority : node->priority;
    }
}

static void see_root(void *context, size_t entry, unsigned worker) {
    (void)worker;
    sl_displayed *d = context;
    if (!sl_displayed_wants(d, entry)) return;
    const sl_visible_face *face = &d->pixels->face[entry];
    sl_patch_place root = sl_patch_root_place(d->mesh, face->face);
    d->first[root.patch] = face->first;
    for (uint32_t i = 0; i < face->count; i++) d->order[face->first + i] = face->first + i;
    d->mesh->patch[root.patch].pixels = face->count;
    see_below(d, &root);
}

/* ---- a new view ---- */

static sl_status reserve(sl_displayed *d, sl_error *error) {
    size_t entries = d->pixels->face_count, pixels = d->pixels->count;
    if (pixels > d->order_capacity || !d->order) {
        sl_free(d->order);
        d->order = sl_allocate_unset(pixels, sizeof *d->order);
        d->order_capacity = d->order ? pixels : 0;
        if (!d->order) return sl_fail_memory(error, "displayed mesh");
    }
    for (d->leaves = 1; d->leaves < entries;) d->leaves *= 2;
    if (d->leaves > d->leaves_room) {
        sl_free(d->root);
        sl_free(d->highest);
        d->root = sl_allocate_unset(d->leaves, sizeof *d->root);
        d->highest = sl_allocate_unset(2 * d->leaves, sizeof *d->highest);
        d->leaves_room = d->root && d->highest ? d->leaves : 0;
        if (!d->leaves_room) return sl_fail_memory(error, "displayed mesh");
    }
    return SL_OK;
}

static void forget_view(sl_displayed *d) {
    for (size_t n = 0; n < d->mesh->patch_count; n++) {
        sl_patch *node = &d->mesh->patch[n];
        node->pixels = 0;
        node->priority = 0.0f;
        node->flags &= ~(uint32_t)(SL_NODE_TAKEN | SL_NODE_DIRTY | SL_NODE_SMALL);
    }
    d->root_count = 0;
    d->chain_entry = SL_NO_INDEX;
    d->dirty_all = true;
    d->corners_asked = false;
}

sl_status sl_displayed_see(sl_displayed *d, const sl_visible_pixels *pixels,
                           bool (*want)(const void *context, uint32_t face), const void *context,
                           sl_error *error) {
    d->pixels = NULL; /* none, should memory end here */
    forget_view(d);
    d->pixels = pixels;
    sl_status status = reserve(d, error);
    for (size_t e = 0; status == SL_OK && e < pixels->face_count; e++) {
        bool wanted = want(context, pixels->face[e].face);
        d->root[e] = wanted ? sl_patches_root(d->mesh, pixels->face[e].face, &status, error) : SL_NO_INDEX;
        d->root_count += wanted;
    }
    if (status == SL_OK) status = sl_displayed_grow(d, error);
    if (status != SL_OK) {
        d->pixels = NULL;
        return status;
    }
    sl_parallel_for(d->settings.threads, pixels->face_count, see_root, d);
    sl_displayed_rank(d);
    return SL_OK;
}

size_t sl_displayed_missing(sl_displayed *d, uint32_t *vertex, size_t room) {
    /* Corners of roots alone: no leaf is cut before the middles of its edges are known. */
    size_t count = 0;
    for (size_t e = 0; d->pixels && e < d->pixels->face_count && count < room; e++) {
        if (!sl_displayed_wants(d, e)) continue;
        for (int c = 0; c < 3 && count < room; c++) {
            uint32_t v = sl_patch_corner(d->mesh, d->root[e], c);
            if (sl_mesh_state(d->mesh, v) != SL_VERTEX_UNKNOWN) continue;
            sl_mesh_set_state(d->mesh, v, SL_VERTEX_REQUESTED);
            vertex[count++] = v;
        }
    }
    d->corners_asked |= count > 0;
    return count;
}

void sl_displayed_put(sl_displayed *d, uint32_t vertex, sl_rgb value, bool valid, sl_counters *counters) {
    float *of = sl_vertex_value(d->mesh, vertex);
    bool finite = sl_rgb_is_finite(value), was_known = d->world > 1 && d->world_of[vertex];
    const float before[3] = {of[0], of[1], of[2]};
    if (!finite) sl_count(counters, SL_COUNT_NONFINITE, 1);
    of[0] = finite ? value.r : 0.0f;
    of[1] = finite ? value.g : 0.0f;
    of[2] = finite ? value.b : 0.0f;
    valid = valid && finite;
    sl_mesh_set_state(d->mesh, vertex, valid ? SL_VERTEX_KNOWN : SL_VERTEX_INVALID);
    d->world_of[vertex] = d->put_as;
    if (was_known && (!valid || memcmp(before, of, sizeof before) != 0)) sl_displayed_touch(d, vertex);
}

void sl_displayed_restart(sl_displayed *d) {
    sl_patches_clear(d->mesh);
    d->pixels = NULL;
    d->root_count = 0;
    d->dirty_all = d->corners_asked = false;
    d->chain_entry = SL_NO_INDEX;
    d->touched_count = 0;
}

/* Gouraud (image pass 3): a leaf's pixels from its vertices and those that its neighbours put on its edges.
 * Only what has changed is drawn: leaves that were cut or put together, and those on whose edges a vertex
 * became known. Pixels belong to one leaf each, so the picture does not depend on the order, and an
 * incremental one is that of drawing it all. */

typedef struct draw_job {
    const sl_displayed *d;
    sl_isa isa;
    sl_rgb fallback;
    float *const *planes;
    uint64_t *redrawn;         /* pixels, by worker */
} draw_job;

static void draw_lanes(const draw_job *job, uint32_t patch, uint32_t first, uint32_t count,
                       const sl_patch_place *shown, const sl_fan_shown *fan) {
    const sl_visible_pixels *pixels = job->d->pixels;
    float w1[SL_FAN_LANES], w2[SL_FAN_LANES], value[3][SL_FAN_LANES];
    uint32_t pixel[SL_FAN_LANES];
    for (uint32_t l = 0; l < count; l++) {
        const uint32_t i = sl_displayed_pixel(job->d, patch, first + l);
        pixel[l] = pixels->pixel[i];
        w1[l] = pixels->w1[i];
        w2[l] = pixels->w2[i];
        value[0][l] = job->fallback.r, value[1][l] = job->fallback.g, value[2][l] = job->fallback.b;
    }
    if (fan) {
        (void)SL_KERNEL_OF(job->isa, sl_mesh_run)(shown, count, w1, w2, w1, w2);
        SL_KERNEL_OF(job->isa, sl_mesh_fan_values)(fan, w1, w2, value);
    }
    for (uint32_t l = 0; l < count; l++)
        for (int c = 0; c < 3; c++) job->planes[c][pixel[l]] = value[c][l];
}

static void draw_leaf(const draw_job *job, const sl_patch_place *leaf) {
    uint32_t count = job->d->mesh->patch[leaf->patch].pixels;
    sl_patch_place shown = *leaf;
    sl_mesh_fan fan;
    bool known = sl_mesh_fan_shown(job->d->mesh, &shown, job->d->settings.hanging, &fan);
    const sl_fan_shown values = known ? sl_mesh_fan_shows(&fan) : (sl_fan_shown){0};
    for (uint32_t first = 0; first < count; first += SL_FAN_LANES) {
        const uint32_t some = count - first < SL_FAN_LANES ? count - first : SL_FAN_LANES;
        draw_lanes(job, leaf->patch, first, some, &shown, known ? &values : NULL);
    }
}

typedef struct root_drawing {
    const draw_job *job;
    uint64_t redrawn;
} root_drawing;

static void draw_changed(const sl_patch_place *leaf, void *context) {
    root_drawing *r = context;
    const sl_displayed *d = r->job->d;
    sl_patch *node = &d->mesh->patch[leaf->patch];
    if (!d->dirty_all && !(node->flags & SL_NODE_DIRTY)) return;
    node->flags &= ~(uint32_t)SL_NODE_DIRTY;
    draw_leaf(r->job, leaf);
    r->redrawn += node->pixels;
}

static void draw_root(void *context, size_t entry, unsigned worker) {
    const draw_job *job = context;
    root_drawing r = {job, 0};
    sl_displayed_visit(job->d, entry, draw_changed, &r);
    job->redrawn[worker] += r.redrawn;
}

void sl_displayed_draw(sl_displayed *d, unsigned threads, sl_rgb fallback, float *const planes[3],
                       sl_counters *counters) {
    enum { THREADS_MOST = 256 };
    if (!d->pixels) return;
    uint64_t redrawn[THREADS_MOST] = {0};
    draw_job job = {.d = d, .isa = sl_isa_best(), .fallback = fallback, .planes = planes, .redrawn = redrawn};
    sl_parallel_for(threads, d->pixels->face_count, draw_root, &job);
    for (int t = 0; t < THREADS_MOST; t++) sl_count(counters, SL_COUNT_PIXELS_REDRAWN, redrawn[t]);
    d->dirty_all = false;
}
