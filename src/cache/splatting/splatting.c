/* Radiance cache splatting: Algorithm 2 of Gautron, Krivanek, Bouatouch, Pattanaik 2005, corrected where the
 * paper errs. Its steps are this file's headings; Algorithm 1, what one record does to one pixel, is
 * splat_kernels.c.
 *
 *     step 1   G-buffer                                     the first update of a view
 *     step 1b  direct light                                 one update; by rays one for SL_DIRECT_ROWS rows
 *     step 2   splat the records of earlier views           nothing at the start
 *     step 3   read back the sums of weights                kept on this side: the same sums
 *     step 4   new records where a pixel is uncovered       one update a batch (traversal.c)
 *     step 4b  clamp radii to neighbours, visit once more   one update, then step 4 again
 *     step 5   splat the new records, and only those        resolve
 *     step 6   normalise, times albedo / pi, add the rest   resolve
 *
 * Steps 4 and 4b run for diffuse receivers (irradiance records), then for glossy ones (radiance records).
 * With a budget of records a frame ends in the midst of them; the next goes on where it stopped. So it does
 * while things move: records are kept then, and renewed in turns (ages.c). */
#include "cache/splatting/splatting.h"

#include "base/error.h"
#include "cache/splatting/state.h"
#include "image/unset.h"

#include <string.h>

static void announce(sl_splat_state *s, const char *name, const char *source, int channels,
                     const float *planes, bool bottom_first) {
    sl_announce(&s->announcer, name, source, s->settings.width, s->settings.height, channels, planes,
                bottom_first);
}

/* A film's sub-frame may be drawn for records alone, or for its picture alone. */
static bool is_for(const sl_splat_state *s, sl_sub_frame_purpose purpose) {
    return s->scene->sub_frame.purpose == purpose;
}

static bool is_on_film(const sl_splat_state *s) { return s->scene->sub_frame.share > 0; }

/* The first sub-frame is drawn for records and, once others have theirs, for its picture: its direct light is
 * still there. */
static bool is_lit(const sl_splat_state *s) {
    return s->first_is_lit && is_for(s, SL_SUB_FRAME_SHOWS) && s->scene->sub_frame.turn == 0;
}

static bool is_budget_spent(const sl_splat_state *s) {
    return s->settings.records_per_frame && s->frame_records >= s->settings.records_per_frame;
}

/* ---- steps 2 and 3: splat what earlier views have left, and see what that covers ---- */

static sl_status splat_new_records_of(sl_splat_state *s, sl_record_cache *cache, sl_error *error);

static bool walks(const sl_splat_state *s) { return s->settings.records_per_frame && !is_on_film(s); }

/* Sums the weights of earlier records. In a walk they never shrink, so that they are splatted at once. */
static sl_status cover_by(sl_splat_state *s, sl_record_cache *cache, sl_error *error) {
    if (!walks(s) || s->ages.aged)
        return sl_cover(&cache->pass, cache->list.records, cache->list.count, error);
    sl_status status = splat_new_records_of(s, cache, error);
    if (status == SL_OK) memcpy(s->coverage, s->splats.weight, sl_splat_pixels(s) * sizeof *s->coverage);
    return status;
}

static sl_status cover_by_old_records(sl_splat_state *s, sl_error *error) {
    const bool grows = !is_for(s, SL_SUB_FRAME_SHOWS);
    sl_status status = SL_OK;
    if (s->second && grows)
        status = sl_second_cache_follow(s->second, &s->counters, error);
    for (int c = 0; status == SL_OK && c < SL_RECEIVER_CLASSES; c++) {
        sl_record_cache *cache = &s->cache[c];
        if (cache->receivers) status = sl_splat_open_cache(s, cache, error);
        if (status == SL_OK && cache->receivers && cache->list.count && grows)
            status = cover_by(s, cache, error);
    }
    return status;
}

/* The first class from `class` on that any pixel belongs to is next. */
static void start_records(sl_splat_state *s, int class) {
    while (class < SL_RECEIVER_CLASSES && !s->cache[class].receivers) class++;
    s->class = class;
    s->phase =
        class < SL_RECEIVER_CLASSES && !is_for(s, SL_SUB_FRAME_SHOWS) ? SL_PHASE_RECORDS : SL_PHASE_DONE;
    if (s->phase != SL_PHASE_RECORDS) return;
    s->cache[class].known = s->cache[class].list.count;
    sl_traversal_start(&s->cache[class].traversal, s->settings.order, s->settings.width, s->settings.height);
}

/* ---- step 1: G-buffer; what mirrors show takes their place ---- */

static sl_status follow_mirrors(sl_splat_state *s, sl_error *error) {
    sl_reflections_destroy(s->reflections);
    s->reflections = NULL;
    if (!s->plan.mirrors) return SL_OK;
    sl_status status = sl_reflect_pixels(s->scene, s->tracer, s->settings.threads, s->gbuffer,
                                         &s->reflections, &s->counters, error);
    if (status == SL_OK) s->mirrors = sl_mirror_pixels_find(s->gbuffer, s->reflections);
    return status;
}

static sl_status draw_gbuffer(sl_splat_state *s, sl_error *error) {
    sl_view view = sl_view_scene(s->scene, s->settings.width, s->settings.height);
    sl_status status =
        sl_raster_gbuffer(s->raster, &view, s->settings.threads, s->gbuffer, &s->counters, error);
    if (status == SL_OK && s->tracer && !is_for(s, SL_SUB_FRAME_SHOWS))
        status = sl_look_at_edges(s->scene, s->tracer, s->settings.threads, s->gbuffer, &s->counters, error);
    if (status == SL_OK) status = follow_mirrors(s, error);
    if (status == SL_OK) status = sl_splat_classify(s, error);
    if (status != SL_OK) return status;
    sl_announce_gbuffer(&s->announcer, "Algorithm 2, step 1", s->gbuffer);
    s->direct_row = 0;
    if (is_for(s, SL_SUB_FRAME_BOTH)) s->frame_records = 0;
    if (!s->plan.direct) s->phase = SL_PHASE_DONE;
    else if (is_for(s, SL_SUB_FRAME_ASKS) || is_lit(s)) start_records(s, 0);
    else s->phase = SL_PHASE_DIRECT;
    return cover_by_old_records(s, error);
}

/* ---- step 1b: direct light ---- */

static sl_status light_rows(sl_splat_state *s, sl_error *error) {
    const int rows = sl_direct_is_mapped(s->direct) ? s->settings.height : SL_DIRECT_ROWS;
    sl_status status = sl_direct_rows(s->direct, s->gbuffer, rows, &s->direct_row, s->direct_light,
                                      &s->counters, error);
    if (status != SL_OK || s->direct_row < s->settings.height) return status;
    announce(s, "direct light", "direct lighting", 3, s->planes, true);
    s->first_is_lit = is_on_film(s) && is_for(s, SL_SUB_FRAME_BOTH);
    start_records(s, 0);
    return SL_OK;
}

/* Begins direct light anew, in full: while frames follow each other it is interleaved (light/direct.h). */
static void take_time_for_light(sl_splat_state *s) {
    s->interleaves = false;
    sl_direct_interleave(s->direct, false);
    s->direct_row = 0;
    s->phase = SL_PHASE_DIRECT;
}

/* ---- step 4: new records where a pixel's sum of weights is below the threshold (10) ---- */

static sl_status new_records(sl_splat_state *s, sl_error *error) {
    sl_record_cache *cache = &s->cache[s->class];
    size_t before = cache->list.count, budget = s->settings.records_per_frame, pixels[SL_BATCH_MAX];
    /* what is uncovered is filled from its neighbours */
    if (sl_splat_is_full(s) || (is_on_film(s) && is_budget_spent(s))) {
        start_records(s, s->class + 1);
        return SL_OK;
    }
    if (budget && cache->traversal.batch > budget - s->frame_records)
        cache->traversal.batch = budget - s->frame_records;
    const size_t count = sl_traversal_next(&cache->traversal, &cache->pass, pixels);
    sl_status status = count ? sl_splat_open_gathers(s, cache, error) : SL_OK;
    if (status == SL_OK && count)
        status = sl_traversal_gather(&cache->traversal, &cache->pass, pixels, count, &cache->list,
                                     &s->counters, error);
    s->frame_records += cache->list.count - before;
    for (size_t i = before; i < cache->list.count; i++) cache->list.records[i].renewed = s->ages.edits;
    if (status != SL_OK || cache->traversal.stride) return status;
    announce(s, "coverage: sum of w", "Algorithm 2, step 4", 1, s->coverage, true);
    /* A view that needed nothing new leaves the records as they are: seen again from the same place, a
     * picture has the same bits. In a walk records never shrink, or pixels would jump between frames. */
    bool grown = cache->list.count > cache->known;
    if (s->phase == SL_PHASE_RECORDS && grown && !s->settings.records_per_frame) s->phase = SL_PHASE_CLAMP;
    else start_records(s, s->class + 1);
    return SL_OK;
}

/* ---- step 4b: neighbour clamping (Krivanek et al. 2006) ---- */

static void forget_sums(sl_splat_state *s, sl_record_cache *cache) {
    const sl_splat_buffer *b = &s->splats;
    float *const planes[] = {s->coverage, b->r,         b->g,         b->b,        b->weight,
                             b->count,    b->glossy[0], b->glossy[1], b->glossy[2]};
    for (size_t k = 0; k < sizeof planes / sizeof planes[0]; k++) {
        for (size_t i = 0; planes[k] && i < sl_splat_pixels(s); i++) {
            if (cache->receives[i]) planes[k][i] = 0.0f;
        }
    }
    cache->splatted = 0;
}

/* A single pass over the radii is the fixed point of mutual clamping, whatever the order of insertion. Older
 * records may shrink: their coverage is summed anew, and what came to light gets records in a second visit.
 */
static sl_status clamp_to_neighbours(sl_splat_state *s, sl_error *error) {
    sl_record_cache *cache = &s->cache[s->class];
    bool shrunk = false;
    sl_status status = cache->clamped == cache->list.count
                           ? SL_OK
                           : sl_record_list_clamp(&cache->list, s->settings.threads, &shrunk, error);
    if (status != SL_OK) return status;
    cache->clamped = cache->list.count;
    if (!shrunk) {
        start_records(s, s->class + 1);
        return SL_OK;
    }
    forget_sums(s, cache);
    sl_traversal_start(&cache->traversal, s->settings.order, s->settings.width, s->settings.height);
    s->phase = SL_PHASE_SECOND;
    return sl_cover(&cache->pass, cache->list.records, cache->list.count, error);
}

/* ---- step 5: splat the new records ---- */

/* With the earlier ones the sums are those of one pass over all, bit for bit. */
static sl_status splat_new_records_of(sl_splat_state *s, sl_record_cache *cache, sl_error *error) {
    /* before its G-buffer a new view has nothing to splat on */
    bool ready = cache->receivers && s->phase > SL_PHASE_GBUFFER;
    if (!ready || cache->splatted == cache->list.count) return SL_OK;
    sl_status status =
        sl_splat_records(&cache->pass, &cache->list, cache->splatted, &s->splats, &s->counters, error);
    if (status != SL_OK) return status;
    cache->splatted = cache->list.count;
    announce(s, "splat: sum of w E", "Algorithm 1", 3, s->splats.r, true);
    announce(s, "splat: sum of w", "Algorithm 1", 1, s->splats.weight, true);
    if (cache->glossy)
        announce(s, "splat: sum of w times reflected radiance", "Algorithm 1, equation (9)", 3,
                 s->splats.glossy[0], true);
    return SL_OK;
}

/* ---- step 6: L_o = (rho / pi) E (6), E the normalised sum (1); and what else there is ---- */

static sl_status splat_new_records(sl_splat_state *s, sl_error *error) {
    sl_status status = SL_OK;
    for (int c = 0; status == SL_OK && c < SL_RECEIVER_CLASSES; c++)
        status = splat_new_records_of(s, &s->cache[c], error);
    return status;
}

static sl_status splat_resolve_colours(void *state, sl_image *image, sl_error *error) {
    sl_splat_state *s = state;
    sl_status status = splat_new_records(s, error);
    if (status != SL_OK) return status;
    if (s->phase > SL_PHASE_GBUFFER) return sl_splat_compose(s, image, error);
    sl_image_clear(image); /* nothing is drawn yet */
    return SL_OK;
}

static sl_status splat_resolve(void *state, sl_image **image, sl_error *error) {
    sl_splat_state *s = state;
    sl_status status = splat_new_records(s, error);
    if (status != SL_OK) return status;
    sl_splat_announce_gather(s, &s->cache[SL_RECEIVES_IRRADIANCE]);
    sl_splat_announce_records(s);
    int layers = s->plan.radiance ? SL_LAYERS_GLOSSY : SL_LAYERS;
    if (!*image)
        status =
            sl_image_create(s->settings.width, s->settings.height, layers, sl_layer_names, image, error);
    if (status != SL_OK || s->phase <= SL_PHASE_GBUFFER) return status; /* nothing is drawn yet */
    status = sl_splat_compose(s, *image, error);
    if (status != SL_OK) return status;
    announce(s, "indirect light", "Algorithm 2, step 6", 3, sl_image_channel(*image, "indirect.R"), false);
    if (s->plan.radiance)
        announce(s, "indirect glossy light", "Algorithm 2, step 6", 3, sl_image_channel(*image, "glossy.R"),
                 false);
    announce(s, "sum of emission, direct and indirect light", "Algorithm 2, step 6", 3, (*image)->planes,
             false);
    return SL_OK;
}

/* ---- updates: one step, or a part of one, at a time ---- */

static sl_status splat_update(void *state, sl_progress *progress, sl_error *error) {
    sl_splat_state *s = state;
    sl_status status = SL_OK;
    if (!is_on_film(s) && is_budget_spent(s)) s->frame_records = 0;
    switch (s->phase) {
    case SL_PHASE_RENEW: status = sl_splat_renew_records(s, error); break;
    case SL_PHASE_GBUFFER: status = draw_gbuffer(s, error); break;
    case SL_PHASE_DIRECT: status = light_rows(s, error); break;
    case SL_PHASE_RECORDS:
    case SL_PHASE_SECOND: status = new_records(s, error); break;
    case SL_PHASE_CLAMP: status = clamp_to_neighbours(s, error); break;
    case SL_PHASE_DONE:
        if (s->ages.aged) status = sl_splat_rest(s, error);
        else if (s->interleaves) take_time_for_light(s);
        break;
    }
    const bool drawn = s->phase == SL_PHASE_DONE;
    if (drawn && s->ages.anew) sl_splat_settle(s);
    progress->fraction = sl_splat_fraction(s);
    progress->done = drawn && !s->ages.aged && !s->interleaves;
    progress->frame_done = drawn || (is_budget_spent(s) && !s->ages.anew);
    return status;
}

/* ---- edits: records live in the world, so a new camera keeps them; new geometry or light drops them, or
 * ages them where frames follow each other ---- */

void sl_splat_begin_view(sl_splat_state *s) {
    size_t pixels = sl_splat_pixels(s);
    const size_t planes = s->plan.radiance ? SL_SPLAT_PLANES : SL_SPLAT_PLANES - 3;
    s->first_is_lit = s->first_is_lit && (is_for(s, SL_SUB_FRAME_ASKS) || is_lit(s));
    const size_t kept = s->first_is_lit ? 3 : 0; /* direct light */
    sl_sub_frame_clear(&s->scene->sub_frame, s->settings.threads, s->planes + kept * pixels, planes - kept,
                       pixels);
    memset(s->owned, 0, pixels);
    s->phase = sl_splat_is_quick(s) ? SL_PHASE_RENEW : SL_PHASE_GBUFFER;
    s->interleaves = s->maps && walks(s);
    sl_direct_interleave(s->direct, s->interleaves);
    for (int c = 0; c < SL_RECEIVER_CLASSES; c++) {
        s->cache[c].splatted = 0;
        s->cache[c].receivers = 0;
    }
}

static sl_status splat_edit(void *state, unsigned changes, sl_error *error) {
    sl_splat_state *s = state;
    sl_status status = SL_OK;
    sl_splat_stir(s);
    if (changes & (SL_CHANGED_OBJECTS | SL_CHANGED_LIGHTS))
        status = sl_splat_keeps_records(s) ? sl_splat_age_records(s, error)
                                           : sl_splat_renew_transport(s, error);
    sl_splat_begin_view(s);
    return status;
}

/* The records of another run, as if they had been made for an earlier view. */
static sl_status splat_load(void *state, const char *path, sl_error *error) {
    sl_splat_stir(state);
    sl_status status = sl_splat_load(state, path, error);
    if (status == SL_OK) sl_splat_settle(state);
    return status == SL_OK ? splat_edit(state, SL_CHANGED_CAMERA, error) : status;
}

static const uint32_t *splat_ids(const void *state) {
    const sl_splat_state *s = state;
    return s->reflections ? NULL : s->gbuffer->id;
}

const sl_method_class sl_splatting_method = {
    .name = "splatting",
    .complete = sl_splat_complete,
    .create = sl_splat_create,
    .destroy = sl_splat_destroy,
    .update = splat_update,
    .resolve = splat_resolve,
    .resolve_colours = splat_resolve_colours,
    .ids = splat_ids,
    .edit = splat_edit,
    .save = sl_splat_save,
    .load = splat_load,
    .counters_at = offsetof(sl_splat_state, counters),
    .memory_bytes = sl_splat_memory_bytes,
    .need = sl_splat_need,
    .filled = sl_splat_filled,
    .explanation = sl_splat_explanation,
    .transport = sl_splat_transport,
    .plan = sl_splat_plan_write,
    .raster_at = offsetof(sl_splat_state, raster),
    .asks = true,
    .any_transport = false,
};
