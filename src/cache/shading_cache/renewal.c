/* Renewal: what is seen and is from before an edit is sampled again, what most of the picture hangs on first.
 * Each update has a share of its samples for that, for either layer; choices of pixels (hit-and-test, flood
 * fill) are for what is new, whatever moves. */
#include <math.h>

#include "base/code_sort.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "cache/shading_cache/state.h"

/* ---- how many ---- */

/* Rays that a sample of a layer takes, about, with what each vertex costs besides; while things move, with
 * few points on lights, and few paths. */
static double rays_of(const sl_shading_state *s, unsigned layer) {
    const double vertex = 8.0, cheap = s->moves ? 1.0 / SL_QUICK_PART : 1.0,
                 dear = s->few_paths ? 1.0 / SL_FEW_PATHS : 1.0,
                 part = layer == SL_LAYER_CHEAP ? cheap : dear;
    double rays = vertex;
    for (int r = 0; r < s->renderer_count; r++)
        if (s->renderer[r].layer == layer && s->renderer[r].rays)
            rays += part * s->renderer[r].rays(s->renderer[r].state);
    return rays;
}

double sl_shading_cheap_samples(const sl_shading_state *s) {
    double cheap = rays_of(s, SL_LAYER_CHEAP);
    return s->layers.kept ? 0.5 * (cheap + rays_of(s, SL_LAYER_DEAR)) / cheap : 1.0;
}

void sl_shading_count_samples(sl_shading_state *s, size_t requests) {
    double cheap = rays_of(s, SL_LAYER_CHEAP), dear = rays_of(s, SL_LAYER_DEAR), rays = 0.0;
    for (size_t i = 0; i < requests; i++) {
        unsigned layers = s->request[i].layers;
        rays += (layers & SL_LAYER_CHEAP ? cheap : 0.0) + (layers & SL_LAYER_DEAR ? dear : 0.0);
    }
    s->samples += rays / (cheap + dear);
}

/* An update at rest shades about four vertices for each of its points. As much is there for renewal: half of
 * it for either layer, and what the cheap one leaves for the dear one. */
static double samples_of(const sl_shading_state *s) { return 4.0 * (double)s->settings.shading_cache.points; }

static size_t cheap_renewals(const sl_shading_state *s) {
    return (size_t)(samples_of(s) * sl_shading_cheap_samples(s));
}

static size_t dear_renewals(const sl_shading_state *s, size_t cheap_taken) {
    double cheap = rays_of(s, SL_LAYER_CHEAP), dear = rays_of(s, SL_LAYER_DEAR), all = samples_of(s);
    double count = (all * (cheap + dear) - (double)cheap_taken * cheap) / dear;
    double left = s->last_sample - s->samples;
    return (size_t)fmin(fmin(fmax(count, 0.5 * all), all), fmax(left, 1.0));
}

/* ---- which ---- */

/* Weighs a vertex: pixels of the largest patch in view that it is a corner of (where it hangs on an
 * edge, of the leaf); and of its dear layer those times what it adds to what lies between coarser ones,
 * which falls as second differences do. */
typedef struct vertex_weight {
    float cheap, dear;
} vertex_weight;

typedef struct weighing {
    const sl_patches *patches;
    uint32_t now;
    vertex_weight *weight;     /* by vertex */
    float root_pixels;
} weighing;

static void weigh(const weighing *w, uint32_t vertex, float pixels) {
    vertex_weight *weight = &w->weight[vertex];
    weight->cheap = fmaxf(weight->cheap, pixels);
    weight->dear = fmaxf(weight->dear, pixels * (pixels / w->root_pixels));
}

static void weigh_hanging(const weighing *w, uint32_t leaf, float pixels) {
    sl_fan_spoke spoke[4 * SL_HANGING_MOST];
    sl_patch_place place = sl_patch_place_of(w->patches, leaf);
    size_t count = sl_patch_spokes(w->patches, &place, SL_PATCH_DEPTH_MAX, 0, spoke);
    for (size_t k = 0; k < count; k++) weigh(w, spoke[k].vertex, pixels);
}

static void weigh_below(const weighing *w, uint32_t patch) {
    const sl_patch *at = &w->patches->patch[patch];
    if (at->seen != w->now || at->pixels == 0) return;
    for (int c = 0; c < sl_patch_corners(w->patches, patch); c++)
        weigh(w, sl_patch_corner(w->patches, patch, c), (float)at->pixels);
    if (at->child == SL_NO_INDEX) weigh_hanging(w, patch, (float)at->pixels);
    for (uint32_t k = 0; k < 4 && at->child != SL_NO_INDEX; k++) weigh_below(w, at->child + k);
}

static void weigh_vertices(const sl_shading_state *s, vertex_weight *weight) {
    weighing w = {.patches = s->patches, .now = s->now, .weight = weight};
    for (size_t i = 0; i < s->patches->root_count; i++) {
        w.root_pixels = (float)s->patches->patch[s->patches->root[i].patch].pixels;
        weigh_below(&w, s->patches->root[i].patch);
    }
}

/* Errors grow with age. Where vertices are renewed at rates r_i, sum w_i / r_i^2 is least for r_i that go
 * with the third roots of w_i: what is asked for first has the greatest w age^3. */
static float urgency_of(float weight, uint32_t age) { return weight * (float)age * (float)age * (float)age; }

/* Codes a vertex so that the most urgent one comes first; floats of 0 and above are in the order of their
 * bits. */
static sl_coded renewal_of(uint32_t vertex, float weight, uint32_t age) {
    return (sl_coded){~(uint64_t)sl_float_bits(urgency_of(weight, age)), vertex};
}

typedef struct renewals {
    vertex_weight *weight;     /* by vertex */
    uint8_t *layers;           /* by vertex: SL_LAYER_ bits that it is asked for */
    sl_coded *list[2];         /* stale cheap layers, dear ones */
    size_t count[2];
} renewals;

static void release(renewals *r) {
    SL_FREE_ALL(r->weight, r->layers, r->list[0], r->list[1]);
}

static sl_status allocate(const sl_patches *p, renewals *r, sl_error *error) {
    *r = (renewals){.weight = sl_allocate(p->vertex_count, sizeof *r->weight),
                    .layers = sl_allocate(p->vertex_count, sizeof *r->layers)};
    for (int k = 0; k < 2; k++) r->list[k] = sl_allocate_unset(p->vertex_count, sizeof *r->list[k]);
    if (r->weight && r->layers && r->list[0] && r->list[1]) return SL_OK;
    release(r);
    return sl_fail_memory(error, "renewal");
}

static void list_stale(const sl_shading_state *s, renewals *r) {
    const sl_patches *p = s->patches;
    for (uint32_t v = 0; v < p->vertex_count; v++) {
        if (!(r->weight[v].cheap > 0.0f) || p->vertex[v].evaluated == SL_VERTEX_NEVER) continue;
        if (sl_vertex_is_stale(p, &s->work, v))
            r->list[0][r->count[0]++] =
                renewal_of(v, r->weight[v].cheap, s->now - p->vertex[v].evaluated);
        if (sl_dear_layer_is_stale(&s->layers, p, v))
            r->list[1][r->count[1]++] =
                renewal_of(v, r->weight[v].dear, s->layers.now - s->layers.version[v]);
    }
    for (int k = 0; k < 2; k++) sl_sort_coded(r->list[k], r->count[k]);
}

/* Takes the most urgent ones of a list. */
static void take(sl_shading_state *s, renewals *r, int k, size_t taken, size_t *count) {
    for (size_t i = 0; i < taken; i++) {
        uint32_t vertex = r->list[k][i].item;
        bool whole = !s->layers.kept || s->layers.version[vertex] == SL_VERSION_UNKNOWN;
        if (!r->layers[vertex]) s->vertex[(*count)++] = vertex;
        r->layers[vertex] |= whole ? SL_LAYERS_ALL : k == 0 ? SL_LAYER_CHEAP : SL_LAYER_DEAR;
    }
}

/* While dear layers are renewed new vertices get theirs from around them, until it is their turn. */
static unsigned layers_of_new(const sl_shading_state *s, uint32_t vertex, bool catches_up) {
    if (!s->layers.kept) return SL_LAYERS_ALL;
    if (s->patches->vertex[vertex].evaluated != SL_VERTEX_NEVER) /* for more points on lights */
        return s->layers.version[vertex] == SL_VERSION_UNKNOWN ? SL_LAYERS_ALL : SL_LAYER_CHEAP;
    bool waits = catches_up && sl_dear_layer_is_near(&s->layers, s->patches, vertex);
    return waits ? SL_LAYER_CHEAP : SL_LAYERS_ALL;
}

static sl_status renew(sl_shading_state *s, renewals *r, size_t *count, sl_error *error) {
    size_t left = 0, new_ones = *count;
    weigh_vertices(s, r->weight);
    list_stale(s, r);
    for (size_t i = 0; i < new_ones; i++) {
        r->layers[s->vertex[i]] = (uint8_t)layers_of_new(s, s->vertex[i], r->count[1] > 0);
        left += r->layers[s->vertex[i]] != SL_LAYERS_ALL;
    }
    size_t cheap = sl_fewer(r->count[0], cheap_renewals(s)),
           dear = sl_fewer(r->count[1], dear_renewals(s, cheap));
    sl_status status = sl_shading_reserve(s, *count + cheap + dear, error);
    if (status != SL_OK) return status;
    take(s, r, 0, cheap, count);
    take(s, r, 1, dear, count);
    s->stale_left = r->count[0] - cheap + r->count[1] - dear + left;
    s->dear_left = r->count[1] - dear;
    s->may_be_stale = r->count[0] + r->count[1] + left > 0;
    for (size_t i = 0; i < *count; i++) s->request[i].layers = r->layers[s->vertex[i]];
    return s->layers.kept && dear > 0 ? sl_layers_begin(&s->layers, s->patches, error) : SL_OK;
}

sl_status sl_shading_renew(sl_shading_state *s, size_t *count, sl_error *error) {
    sl_status status = sl_layers_reserve(&s->layers, s->patches, error);
    s->stale_left = s->dear_left = 0;
    for (size_t i = 0; i < *count && status == SL_OK; i++)
        s->request[i].layers = layers_of_new(s, s->vertex[i], false);
    if (status != SL_OK || !s->may_be_stale) return status;
    renewals r;
    status = allocate(s->patches, &r, error);
    if (status != SL_OK) return status;
    status = renew(s, &r, count, error);
    release(&r);
    return status;
}
