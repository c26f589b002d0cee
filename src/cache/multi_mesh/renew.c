/* Values of before an edit. Nothing is thrown away: a value is shown, and tested against others, until it is
 * taken again. Those that an edit cannot have changed are of the new world at once; the others are old, and
 * listed by what they show times how old they are. A value that turns out to be another one touches the
 * leaves around it: edges are tested again, so leaves are cut where light has gone, and put together where
 * it has gone from. */
#include "cache/multi_mesh/displayed.h"

#include "base/code_sort.h"
#include "base/error.h"
#include "base/grow.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"

enum { A_TASK = 1024 }; /* vertices or leaves */

/* ---- another world --------------------------------------------------------------------------- */

typedef struct aging {
    sl_displayed *d;
    uint32_t world;            /* the new one */
    const sl_mesh_check *check;
} aging;

static void age_some(void *context, size_t task, unsigned worker) {
    (void)worker;
    const aging *a = context;
    sl_displayed *d = a->d;
    size_t end = (task + 1) * A_TASK;
    for (size_t v = task * A_TASK; v < end && v < d->mesh->vertex_count; v++) {
        bool of_now = d->mesh->vertex[v].references && d->world_of[v] == d->world;
        if (of_now && a->check->holds(a->check->context, d->mesh, (uint32_t)v)) d->world_of[v] = a->world;
    }
}

void sl_displayed_age(sl_displayed *d, uint32_t worlds, const sl_mesh_check *check) {
    aging a = {d, d->world + worlds, check};
    size_t tasks = (d->mesh->vertex_count + A_TASK - 1) / A_TASK;
    if (check) sl_parallel_for(d->settings.threads, tasks, age_some, &a);
    d->world = d->put_as = a.world;
}

typedef struct doubting {
    sl_displayed *d;
    const sl_leaf_check *check;
} doubting;

static void doubt_some(void *context, size_t task, unsigned worker) {
    (void)worker;
    const doubting *c = context;
    sl_patches *mesh = c->d->mesh;
    size_t end = (task + 1) * A_TASK;
    for (size_t n = task * A_TASK; n < end && n < mesh->patch_count; n++) {
        sl_patch *node = &mesh->patch[n];
        if (!(node->flags & SL_PATCH_ALIVE) || node->child != SL_NO_INDEX || sl_mesh_upper_half(node) == 0.0f)
            continue;
        sl_patch_place leaf = sl_patch_place_of(mesh, (uint32_t)n);
        if (!c->check->stays(c->check->context, mesh, &leaf)) sl_mesh_set_tested_size(node, 0.0f);
    }
}

void sl_displayed_doubt(sl_displayed *d, const sl_leaf_check *check) {
    doubting c = {d, check};
    sl_parallel_for(d->settings.threads, (d->mesh->patch_count + A_TASK - 1) / A_TASK, doubt_some, &c);
}

/* ---- which are old --------------------------------------------------------------------------- */

typedef struct listing {
    sl_displayed *d;
    uint32_t world;
    sl_old_vertex *old;
    size_t count, room;
    bool failed;
} listing;

static void weigh(listing *l, uint32_t vertex, uint32_t leaf, float pixels) {
    sl_displayed *d = l->d;
    if (!sl_mesh_is_sampled(d->mesh, vertex) || d->world_of[vertex] >= l->world) return;
    if (d->weight[vertex] == 0.0f) {
        l->failed = l->failed || !sl_make_room(&l->old, l->count, &l->room, sizeof *l->old);
        if (l->failed) return;
        l->old[l->count++] = (sl_old_vertex){vertex, leaf, 0.0f};
    }
    d->weight[vertex] += pixels;
}

/* Corners, and what lies on the edges. */
static void weigh_leaf(const sl_patch_place *leaf, void *context) {
    listing *l = context;
    const sl_patches *mesh = l->d->mesh;
    float pixels = (float)mesh->patch[leaf->patch].pixels;
    sl_fan_spoke spoke[SL_FAN_VERTICES - 3];
    for (int c = 0; c < 3; c++) weigh(l, sl_patch_corner(mesh, leaf->patch, c), leaf->patch, pixels);
    size_t count = sl_patch_spokes(mesh, leaf, SL_FAN_LEVELS, SL_VERTEX_KNOWN, spoke);
    for (size_t i = 0; i < count; i++) weigh(l, spoke[i].vertex, leaf->patch, pixels);
}

/* By weight, the largest first; floats above 0 are in the order of their bits. */
static sl_status sort(listing *l, sl_old_vertex **sorted, sl_error *error) {
    sl_coded *order = sl_allocate_unset(l->count, sizeof *order);
    *sorted = sl_allocate_unset(l->count, sizeof **sorted);
    bool done = order && *sorted;
    for (size_t i = 0; done && i < l->count; i++)
        order[i] = (sl_coded){(uint32_t)~sl_float_bits(l->old[i].weight), (uint32_t)i};
    if (done) sl_sort_coded(order, l->count);
    for (size_t i = 0; done && i < l->count; i++) (*sorted)[i] = l->old[order[i].item];
    sl_free(order);
    return done ? SL_OK : sl_fail_memory(error, "old vertices");
}

sl_status sl_displayed_list_old(sl_displayed *d, uint32_t world, sl_old_vertex **old, size_t *count,
                                sl_error *error) {
    listing l = {.d = d, .world = world};
    *old = NULL;
    *count = 0;
    for (size_t e = 0; d->pixels && d->world > 1 && e < d->pixels->face_count; e++)
        sl_displayed_visit(d, e, weigh_leaf, &l);
    for (size_t i = 0; i < l.count; i++) {
        uint32_t vertex = l.old[i].vertex;
        l.old[i].weight = d->weight[vertex] * (float)(d->world - d->world_of[vertex]);
        d->weight[vertex] = 0.0f;
    }
    sl_status status = l.failed ? sl_fail_memory(error, "old vertices") : SL_OK;
    if (status == SL_OK && l.count) status = sort(&l, old, error);
    if (status == SL_OK) *count = l.count;
    sl_free(l.old);
    return status;
}

/* ---- leaves around them ---------------------------------------------------------------------- */

/* Without memory for the list it is tested with all others before the picture ends. */
static void touch(sl_patches *mesh, const sl_patch_place *leaf, void *context) {
    sl_displayed *d = context;
    sl_patch *node = &mesh->patch[leaf->patch];
    sl_displayed_mark(d, leaf->patch);
    if (!node->pixels || node->flags & SL_NODE_TOUCHED) return;
    if (!sl_make_room(&d->touched, d->touched_count, &d->touched_room, sizeof *d->touched)) return;
    node->flags |= SL_NODE_TOUCHED;
    d->touched[d->touched_count++] = leaf->patch;
}

void sl_displayed_touch(sl_displayed *d, uint32_t vertex) {
    sl_patches_visit_around(d->mesh, d->mesh->vertex[vertex].place, touch, d);
}

/* A leaf that is closed may have been the last one of its parent's. */
static void settle(sl_displayed *d, uint32_t patch, sl_counters *counters) {
    if (!sl_patch_is_alive(d->mesh, patch) || !sl_patch_is_leaf(d->mesh, patch)) return;
    d->mesh->patch[patch].flags &= ~(uint32_t)SL_NODE_TOUCHED;
    sl_patch_place leaf = sl_patch_place_of(d->mesh, patch);
    sl_displayed_retest(d, &leaf);
    sl_displayed_close(d, &leaf, counters);
}

void sl_displayed_settle(sl_displayed *d, sl_counters *counters) {
    for (size_t i = 0; d->pixels && i < d->touched_count; i++) settle(d, d->touched[i], counters);
    d->touched_count = 0;
}

void sl_displayed_settle_all(sl_displayed *d, sl_counters *counters) {
    sl_displayed_settle(d, counters);
    for (uint32_t n = 0; d->pixels && n < d->mesh->patch_count; n++)
        if (d->mesh->patch[n].pixels) settle(d, n, counters);
}
