/* Requests of vertices, their samples, and the commit of one of them: it may show a change, and changing
 * objects are shown with coarser patches (sections on the sample renderer and on moving objects). */
#include "base/batch.h"
#include "base/counters.h"
#include "base/error.h"
#include "base/grow.h"
#include "base/math.h"
#include "cache/shading_cache/state.h"

#include <string.h>

/* ---- requests and samples ---- */

sl_status sl_shading_reserve(sl_shading_state *s, size_t room, sl_error *error) {
    size_t had = s->vertex_room;
    if (room <= had) return SL_OK;
    if (!sl_regrow(&s->vertex, had, room, sizeof *s->vertex) ||
        !sl_regrow(&s->request, had, room, sizeof *s->request) ||
        !sl_regrow(&s->sample, had, room, sizeof *s->sample) ||
        !sl_regrow(&s->part, had, room, sizeof *s->part) ||
        (s->layers.kept && !sl_regrow(&s->layer, had, room, sizeof *s->layer)))
        return sl_fail_memory(error, "samples");
    s->vertex_room = room;
    return SL_OK;
}

static void make_request(const sl_shading_state *s, uint32_t vertex, sl_sample_request *request) {
    const sl_patch_vertex *v = &s->patches->vertex[vertex];
    const sl_material *material = sl_root_material(s->primitives, v->root);
    const sl_vertex_sets *sets = s->patches->sets ? &s->patches->sets[vertex] : NULL;
    bool more = sets && v->evaluated != SL_VERTEX_NEVER && !sl_vertex_is_stale(s->patches, &s->work, vertex);
    *request = (sl_sample_request){.material = material,
                                   .eye = s->scene->camera.eye,
                                   .dense = v->dense,
                                   .quick = s->moves,
                                   .few_paths = s->few_paths,
                                   .radiance = sl_material_has_lobe(material),
                                   .set = more ? sets->count : 0,
                                   .layers = request->layers};
    sl_vertex_sample_point(s->patches, vertex, &request->point);
}

/* A corner inside other geometry is asked for further inside its patch. */
static void request_one(void *context, size_t i, unsigned worker, void *result, sl_counters *counters) {
    (void)worker;
    (void)result;
    sl_shading_state *s = context;
    bool moved;
    make_request(s, s->vertex[i], &s->request[i]);
    s->sample[i] =
        (sl_sample){.valid = sl_leave_solid(s->patches, s->tracer, &s->scene->camera.eye, s->vertex[i],
                                            &s->request[i].point, &moved, counters)};
}

static void add_sample(sl_sample *sum, const sl_sample *part) {
    sum->irradiance = sl_rgb_add(sum->irradiance, part->irradiance);
    sum->radiance = sl_rgb_add(sum->radiance, part->radiance);
    sum->variance += part->variance;
    sum->broken = sum->broken || part->broken;
}

static bool is_asked(const sl_shading_state *s, size_t i, unsigned layer) {
    return s->sample[i].valid && !s->sample[i].broken && (s->request[i].layers & layer);
}

/* Tells whether any of the requests is worth asking for. */
static bool pass_over_others(sl_shading_state *s, unsigned layer, size_t count) {
    bool any = false;
    for (size_t i = 0; i < count; i++) {
        const bool asked = is_asked(s, i, layer);
        s->request[i].passed_over = !asked;
        any |= asked;
    }
    return any;
}

static void add_part(sl_shading_state *s, size_t i, unsigned layer, const sl_sample *part) {
    add_sample(&s->sample[i], part);
    if (s->layers.kept) add_sample(&s->layer[i][layer == SL_LAYER_DEAR], part);
}

void sl_shading_sample(sl_shading_state *s, size_t count) {
    const sl_batch requests = {.count = count, .work = request_one, .context = s};
    if (count) sl_batch_run(&requests, s->settings.threads, &s->counters);
    if (count && s->layers.kept) memset(s->layer, 0, count * sizeof *s->layer);
    for (int r = 0; r < s->renderer_count; r++) {
        const sl_sample_renderer *renderer = &s->renderer[r];
        if (!pass_over_others(s, renderer->layer, count)) continue;
        sl_render(renderer, count, s->request, s->settings.threads, s->part, &s->counters);
        for (size_t i = 0; i < count; i++)
            if (!s->request[i].passed_over) add_part(s, i, renderer->layer, &s->part[i]);
    }
    sl_shading_count_samples(s, count);
    sl_count(&s->counters, SL_COUNT_POINTS_SHADED, count);
    sl_announce_pass(&s->announcer, "samples", "lazy evaluation");
}

/* ---- commit, change ---- */

/* A value may tell of change if it replaces one that was made with the same samples. Radiance towards an eye
 * that has moved tells nothing. */
typedef struct compared {
    bool comparable, radiance;
    sl_rgb before;
} compared;

static sl_rgb exitant_of(const sl_shading_state *s, uint32_t vertex, bool with_radiance) {
    const sl_patch_vertex *v = &s->patches->vertex[vertex];
    const float *value = sl_vertex_value(s->patches, vertex);
    sl_rgb over_pi = sl_rgb_scale((sl_rgb){value[0], value[1], value[2]}, (float)(1.0 / SL_PI));
    sl_rgb exitant = sl_rgb_mul(over_pi, sl_root_mean_diffuse(s->primitives, v->root));
    const float *lobe = with_radiance ? sl_vertex_lobe(s->patches, vertex) : NULL;
    if (lobe) exitant = sl_rgb_add(exitant, (sl_rgb){lobe[0], lobe[1], lobe[2]});
    return exitant;
}

static compared compare_before(const sl_shading_state *s, uint32_t vertex, const sl_sample_request *request) {
    const sl_patch_vertex *v = &s->patches->vertex[vertex];
    bool one_set = request->set == 0 && (!s->patches->sets || s->patches->sets[vertex].count == 1);
    bool same_paths = !(request->layers & SL_LAYER_DEAR) || !s->layers.kept ||
                      s->layers.version[vertex] >= s->same_paths;
    compared c = {.comparable = v->evaluated != SL_VERTEX_NEVER && !v->extrapolated && one_set &&
                  same_paths && v->dense == v->is_dense && v->is_quick == s->moves,
                  .radiance = v->evaluated >= s->changes.eye_moved};
    if (c.comparable) c.before = exitant_of(s, vertex, c.radiance);
    return c;
}

static void channels_of(const sl_sample *sample, float channel[6]) {
    const sl_rgb e = sample->irradiance, l = sample->radiance;
    memcpy(channel, (const float[6]){e.r, e.g, e.b, l.r, l.g, l.b}, 6 * sizeof *channel);
}

/* Returns what was sampled, with what is kept of a layer that was not. */
static void take_layers(sl_shading_state *s, size_t i, float value[6]) {
    float parts[2][6];
    channels_of(&s->sample[i], value);
    if (!s->layers.kept) return;
    for (int k = 0; k < 2; k++) channels_of(&s->layer[i][k], parts[k]);
    sl_layers_commit(&s->layers, s->patches, s->vertex[i], s->request[i].layers, parts, value);
}

/* All of it: no trace is left of what was there, be it a million times as bright. */
static void blend(sl_patches *p, uint32_t vertex, const float parts[6], float share) {
    float *value = sl_vertex_value(p, vertex);
    for (int k = 0; k < p->settings.channels; k++)
        value[k] = share < 1.0f ? value[k] + share * (parts[k] - value[k]) : parts[k];
}

/* The share of a new value: all of it, but where it joins earlier sets of samples. */
static float share_of(const sl_sample_request *request) {
    return request->set > 0 ? 1.0f / ((float)request->set + 1.0f) : 1.0f;
}

/* Returns true for first values that are blended in. Means of several sets of samples are not: they have
 * no value yet. */
static bool is_to_fade(const sl_shading_state *s, uint32_t vertex, uint32_t object) {
    return s->settings.shading_cache.blending < 1.0 && !s->patches->sets &&
           s->patches->vertex[vertex].evaluated == SL_VERTEX_NEVER && !s->changes.object[object].changing;
}

/* A broken sample: the old value stays, and counts as new, or it would be asked for for ever. Where there is
 * none, and inside other geometry, the vertex is extrapolated from the corners around it. */
static void commit_nothing(sl_shading_state *s, uint32_t vertex, bool inside) {
    sl_patch_vertex *v = &s->patches->vertex[vertex];
    if (inside || v->evaluated == SL_VERTEX_NEVER) sl_patches_set_extrapolated(s->patches, vertex);
    if (s->layers.kept) s->layers.version[vertex] = v->extrapolated ? SL_VERSION_UNKNOWN : s->layers.now;
    sl_vertex_mark(v, s->now);
}

/* A vertex is inside other geometry and was not, or the other way round: a change without values to compare.
 * */
static bool comes_or_goes(const sl_patch_vertex *v, const sl_sample *sample) {
    return v->evaluated != SL_VERTEX_NEVER && v->extrapolated == sample->valid;
}

void sl_shading_commit_sample(sl_shading_state *s, size_t i) {
    uint32_t vertex = s->vertex[i];
    const sl_sample_request *request = &s->request[i];
    sl_sample *sample = &s->sample[i];
    sl_patch_vertex *v = &s->patches->vertex[vertex];
    uint32_t object = sl_root_object(s->primitives, v->root);
    bool finite = sl_rgb_is_finite(sample->irradiance) && sl_rgb_is_finite(sample->radiance);
    sl_count(&s->counters, SL_COUNT_NONFINITE, !finite);
    if (sample->broken || !finite) {
        commit_nothing(s, vertex, false);
        return;
    }
    if (comes_or_goes(v, sample)) {
        sl_changes_begin(&s->changes, object, s->now);
        sl_count(&s->counters, SL_COUNT_CHANGES_DETECTED, 1);
    }
    if (!sample->valid) {
        commit_nothing(s, vertex, true);
        return;
    }
    compared c = compare_before(s, vertex, request);
    float value[6];
    take_layers(s, i, value);
    v->extrapolated = 0;
    v->is_dense = v->dense;
    if (request->layers & SL_LAYER_CHEAP) v->is_quick = s->moves;
    float share = share_of(request), from[6];
    bool fades = is_to_fade(s, vertex, object) && sl_vertex_surroundings(s->patches, vertex, from);
    blend(s->patches, vertex, value, share);
    if (s->patches->sets) {
        sl_vertex_sets *sets = &s->patches->sets[vertex];
        sets->variance = fmaxf(
            0.0f, sets->variance + share * (share * sample->variance - sets->variance * (2.0f - share)));
        sets->count = request->set < UINT32_MAX ? request->set + 1 : UINT32_MAX;
    }
    if (request->layers & SL_LAYER_CHEAP) sl_vertex_mark(v, s->now);
    if (fades)
        sl_fade_begin(&s->fades, s->patches, vertex, from, (float)s->settings.shading_cache.blending);
    float apart = c.comparable ? sl_levels_apart(&s->curve, c.before, exitant_of(s, vertex,
        c.radiance)) : 0.0f;
    if (c.comparable && sl_changes_compare(&s->changes, object, apart, s->now))
        sl_count(&s->counters, SL_COUNT_CHANGES_DETECTED, 1);
}

/* Returns how coarse patches of what changes are, so that there is time to renew their cheap layer: T_c after
 * a change, a part of it while one follows another. */
float sl_shading_coarsest(const sl_shading_state *s) {
    enum { MOTION_PART = 8 };
    const sl_shading_cache_settings *c = &s->settings.shading_cache;
    const double seconds = s->moves ? c->clean_up_seconds / MOTION_PART : c->clean_up_seconds;
    double visible = 0.0;
    if (c->no_resolution_drop) return 0.0f;
    for (size_t i = 0; i < s->leaf_count; i++) {
        uint32_t object = sl_root_object(s->primitives, sl_patch_root(s->patches, s->leaf[i].patch));
        if (s->changes.object[object].changing) visible += s->patches->patch[s->leaf[i].patch].pixels;
    }
    if (!(visible > 0.0)) return 0.0f;
    return sl_changes_coarsest(visible, c->nominal_rate * sl_shading_cheap_samples(s), seconds);
}

/* Corners that were never evaluated are none of that: while an object is refined there always are some. */
static bool shows_what_was_before(const sl_patches *p, uint32_t leaf, uint32_t change) {
    uint32_t oldest = sl_leaf_oldest(p, leaf);
    if (oldest != SL_VERTEX_NEVER) return oldest < change;
    for (int c = 0; c < sl_patch_corners(p, leaf); c++) {
        uint32_t evaluated = p->vertex[sl_patch_corner(p, leaf, c)].evaluated;
        if (evaluated != SL_VERTEX_NEVER && evaluated < change) return true;
    }
    return false;
}

/* Objects of which visible leaves still show what was before. */
void sl_shading_find_stale(sl_shading_state *s) {
    memset(s->stale, 0, s->scene->object_count * sizeof *s->stale);
    for (size_t i = 0; i < s->leaf_count; i++) {
        uint32_t patch = s->leaf[i].patch;
        if (!sl_patch_is_alive(s->patches, patch) || !sl_patch_is_leaf(s->patches, patch)) continue;
        uint32_t object = sl_root_object(s->primitives, sl_patch_root(s->patches, patch));
        const sl_object_change *change = &s->changes.object[object];
        if (change->changing && !s->stale[object])
            s->stale[object] = shows_what_was_before(s->patches, patch, change->stale_before);
    }
}

void sl_shading_drop_resolution(sl_shading_state *s) {
    float coarsest = sl_shading_coarsest(s);
    if (coarsest > 0.0f) sl_changes_drop(&s->changes, s->patches, &s->view, coarsest);
}

/* Latency: the number of updates until an edit's change of the picture is found. */
void sl_shading_note_latency(sl_shading_state *s) {
    if (!s->edited) return;
    sl_count(&s->counters, SL_COUNT_CHANGES_SHOWN, 1);
    sl_count(&s->counters, SL_COUNT_UPDATES_TO_SHOW, s->now - s->edited + 1);
    s->edited = 0;
}
