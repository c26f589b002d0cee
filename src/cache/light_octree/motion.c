/* Frames while something moves: the update behind an edit draws a whole one, so that no frame is without
 * light. Direct light is by shadow maps, and pixels share points of the octree four by four; rays, and a
 * point for each pixel, are for what stands still. A strip of rows goes through all steps while a processor's
 * cache holds it. Where light has changed, photons are traced again in slices, one an edit. A slice's paths
 * are the same each time, and all slices count alike: where nothing has moved photons keep their places and
 * their shares, and light does not flash. */
#include "base/batch.h"
#include "base/counters.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/light_octree/light_octree.h"

/* Where there are no maps, or memory is short. */
enum { RAYS = 4 };
/* All slices together have a quarter of the photons of a picture at rest. */
enum { PATHS_DIVISOR = 4 * SL_OCTREE_SLICES };

/* ---- Direct light ---- */

static void forget_direct(sl_octree_motion *m) {
    sl_direct_destroy(m->direct);
    m->direct = NULL;
}

static sl_status make_direct(sl_octree_state *s, sl_error *error) {
    const sl_direct_settings direct = {.light_samples = RAYS,
                                       .seed = s->settings.seed,
                                       .threads = s->settings.threads,
                                       .sun = sl_octree_sampled_sky(s)};
    if (s->motion.direct || !s->plan.direct) return SL_OK;
    return sl_direct_create_quick(s->scene, s->raster, s->tracer, &direct, !s->settings.memory_bytes,
                                  &s->motion.direct, &s->counters, error);
}

static sl_status light_directly(sl_octree_state *s, sl_error *error) {
    sl_status status = SL_OK;
    for (int row = 0; status == SL_OK && s->motion.direct && row < s->settings.height;)
        status = sl_direct_rows(s->motion.direct, s->gbuffer, SL_DIRECT_ROWS, &row, s->direct_light,
                                &s->counters, error);
    if (status == SL_OK && s->motion.direct) sl_octree_announce_direct(s);
    return status;
}

/* ---- Photons, in slices ---- */

void sl_octree_age_light(sl_octree_motion *m) {
    for (int k = 0; k < SL_OCTREE_SLICES; k++) m->age[k]++;
    forget_direct(m);
}

void sl_octree_forget_slices(sl_octree_motion *m) {
    for (int k = 0; k < SL_OCTREE_SLICES; k++) {
        sl_photon_list_destroy(m->slice[k]);
        m->slice[k] = NULL;
    }
    sl_photon_tree_destroy(m->tree);
    m->tree = NULL;
    m->shown = false;
}

void sl_octree_forget_motion(sl_octree_motion *m) {
    forget_direct(m);
    sl_octree_forget_slices(m);
}

/* The paths of a slice are some of those that a picture at rest begins with. */
static uint64_t chunks_of_slice(const sl_octree_state *s) {
    const uint64_t paths = s->settings.light_octree.photons / PATHS_DIVISOR;
    return (paths + SL_PHOTON_CHUNK - 1) / SL_PHOTON_CHUNK;
}

static sl_status trace_slice(sl_octree_state *s, int k, sl_error *error) {
    const uint64_t chunks = chunks_of_slice(s);
    sl_photon_options options = sl_octree_photon_options(s);
    sl_photon_list *slice = NULL;
    bool done;
    options.stored = UINT64_MAX; /* never done: fluxes stay undivided */
    options.first = (uint64_t)k * chunks * SL_PHOTON_CHUNK;
    sl_status status = sl_photons_trace(s->scene, s->tracer, &options, (size_t)chunks, &slice, &done,
                                        &s->counters, error);
    if (status == SL_OK) {
        sl_photon_list_destroy(s->motion.slice[k]);
        s->motion.slice[k] = slice;
        s->motion.age[k] = 0;
    } else {
        sl_photon_list_destroy(slice);
    }
    return status;
}

static int oldest_slice(const sl_octree_motion *m) {
    int oldest = 0;
    for (int k = 1; k < SL_OCTREE_SLICES; k++) {
        if (m->age[k] > m->age[oldest]) oldest = k;
    }
    return oldest;
}

/* Traces the oldest slice again; all, where none is there. */
static sl_status renew_slices(sl_octree_state *s, sl_error *error) {
    if (s->motion.slice[0]) return trace_slice(s, oldest_slice(&s->motion), error);
    sl_status status = SL_OK;
    for (int k = SL_OCTREE_SLICES - 1; k >= 0 && status == SL_OK; k--) status = trace_slice(s, k, error);
    return status;
}

static void add_slice(sl_photon_list *all, const sl_photon_list *slice, double share) {
    const double weight = slice->emitted > 0 ? share / (double)slice->emitted : 0.0;
    for (size_t i = 0; i < slice->count; i++) {
        sl_photon *p = &all->photon[all->count++];
        *p = slice->photon[i];
        for (int c = 0; c < 3; c++) p->flux[c] = (float)((double)p->flux[c] * weight);
    }
    all->emitted += slice->emitted;
    all->emitted_flux = slice->emitted_flux;
    all->cut_flux += slice->cut_flux * weight;
}

/* Makes one map of all slices, each of which tells of all light. */
static sl_status join_slices(const sl_octree_motion *m, sl_photon_list **result, sl_error *error) {
    sl_photon_list *all = *result = sl_allocate(1, sizeof *all);
    size_t count = 0;
    for (int k = 0; k < SL_OCTREE_SLICES; k++) count += m->slice[k]->count;
    if (all) all->photon = sl_allocate_unset(count, sizeof *all->photon);
    if (!all || !all->photon) {
        sl_photon_list_destroy(all);
        return sl_fail_memory(error, "photons");
    }
    for (int k = 0; k < SL_OCTREE_SLICES; k++) add_slice(all, m->slice[k], 1.0 / SL_OCTREE_SLICES);
    return SL_OK;
}

/* ---- The octree ---- */

/* An octree of all slices takes the place of the one that is shown. */
static sl_status light_anew(sl_octree_state *s, sl_error *error) {
    sl_octree_motion *m = &s->motion;
    sl_photon_list *photons = NULL;
    sl_photon_tree *tree = NULL;
    sl_status status = renew_slices(s, error);
    if (status == SL_OK) status = join_slices(m, &photons, error);
    if (status != SL_OK) return status;
    if (!photons->count) {
        sl_photon_list_destroy(photons);
        sl_octree_forget_level(&s->shown); /* dark */
        m->shown = false;
        return SL_OK;
    }
    status = sl_photon_tree_create(photons, s->settings.threads, &tree, error);
    if (status == SL_OK) status = sl_octree_show_level_of(s, tree, s->plan.first_depth, error);
    if (status != SL_OK) {
        sl_photon_tree_destroy(tree);
        return status;
    }
    sl_photon_tree_destroy(m->tree);
    m->tree = tree;
    m->shown = true;
    return SL_OK;
}

static bool is_light_old(const sl_octree_motion *m) { return m->age[oldest_slice(m)] > 0; }

/* ---- Frames ---- */

/* Rows that pass through all steps while they are in a processor's cache. */
enum { ROWS = 32 };

typedef struct drawing {
    const sl_octree_state *state;
    const sl_resolver *resolver;
    sl_octree_pixels pixels; /* of the whole picture */
} drawing;

typedef struct strip_end {
    sl_status status;
    sl_error error;
} strip_end;

/* Returns rows of a G-buffer, from pixel `first` on. */
static sl_gbuffer part_of(const sl_gbuffer *g, size_t first, int rows) {
    return (sl_gbuffer){.width = g->width, .height = rows, .id = g->id + first,
                        .position_x = g->position_x + first, .position_y = g->position_y + first,
                        .position_z = g->position_z + first, .normal_x = g->normal_x + first,
                        .normal_y = g->normal_y + first, .normal_z = g->normal_z + first,
                        .geometric_x = g->geometric_x + first, .geometric_y = g->geometric_y + first,
                        .geometric_z = g->geometric_z + first, .diffuse_r = g->diffuse_r + first,
                        .diffuse_g = g->diffuse_g + first, .diffuse_b = g->diffuse_b + first,
                        .material = g->material + first};
}

static void draw_strip(void *context, size_t index, unsigned worker, void *result, sl_counters *counters) {
    const drawing *d = context;
    const sl_octree_state *s = d->state;
    strip_end *end = result;
    const int first_row = (int)index * ROWS, left = s->gbuffer->height - first_row,
              rows = left < ROWS ? left : ROWS;
    const size_t width = (size_t)s->gbuffer->width, first = (size_t)first_row * width;
    float *const indirect[3] = {s->indirect_light[0] + first, s->indirect_light[1] + first,
                                s->indirect_light[2] + first};
    sl_gbuffer part = part_of(s->gbuffer, first, rows);
    sl_octree_pixels pixels = d->pixels;
    int row = first_row;
    pixels.gbuffer = &part;
    pixels.threads = 1;
    sl_count(counters, SL_COUNT_FRAGMENTS_SHADED,
             sl_resolver_run(d->resolver, worker, first, (size_t)rows * width, &part));
    end->status =
        sl_direct_rows(s->motion.direct, s->gbuffer, rows, &row, s->direct_light, counters, &end->error);
    if (end->status == SL_OK)
        end->status = sl_octree_light_pixels(&pixels, indirect, counters, &end->error);
}

static sl_status draw_all(const drawing *d, sl_counters *counters, sl_error *error) {
    const size_t strips = ((size_t)d->state->gbuffer->height + ROWS - 1) / ROWS;
    strip_end *end = sl_allocate(strips, sizeof *end);
    if (!end) return sl_fail_memory(error, "a frame's strips");
    const sl_batch batch = {.count = strips, .work = draw_strip, .context = (void *)d, .results = end,
                            .result_bytes = sizeof *end};
    sl_batch_run(&batch, d->pixels.threads, counters);
    sl_status status = SL_OK;
    for (size_t i = 0; i < strips && status == SL_OK; i++) {
        status = end[i].status;
        if (status != SL_OK) *error = end[i].error;
    }
    sl_free(end);
    return status;
}

static sl_status draw_strips(sl_octree_state *s, sl_error *error) {
    const sl_octree_shading shading = sl_octree_state_shading(s);
    const sl_view view = sl_view_scene(s->scene, s->settings.width, s->settings.height);
    const sl_target target = {view.width, view.height, s->gbuffer->id, s->gbuffer->depth};
    const unsigned threads = sl_thread_count(s->settings.threads);
    sl_resolver *resolver = NULL;
    sl_status status = sl_raster_id(s->raster, &view, threads, &target, &s->counters, error);
    if (status == SL_OK)
        status = sl_resolver_create(s->raster, &view, s->gbuffer->id, threads, &resolver, error);
    const drawing d = {s, resolver, sl_octree_pixels_of(s, &shading, true)};
    if (status == SL_OK) status = draw_all(&d, &s->counters, error);
    sl_resolver_destroy(resolver);
    if (status != SL_OK) return status;
    sl_octree_begin_light(s);
    sl_octree_announce_direct(s);
    sl_octree_show_light(s, false);
    return SL_OK;
}

/* Draws what needs the whole G-buffer first: mirrors, light by rays, an atlas, photons at pixels. */
static sl_status draw_in_steps(sl_octree_state *s, sl_error *error) {
    sl_status status = sl_octree_draw_gbuffer(s, error);
    if (status == SL_OK) status = light_directly(s, error);
    if (status == SL_OK && s->shown.octree) status = sl_octree_light_picture(s, true, error);
    return status;
}

static bool can_be_strips(const sl_octree_state *s) {
    return s->motion.direct && sl_direct_is_mapped(s->motion.direct) && s->shown.octree && !s->plan.mirrors &&
           !s->canvas && !s->settings.light_octree.photons_at_pixels;
}

sl_status sl_octree_draw_frame(sl_octree_state *s, sl_error *error) {
    const bool old = !s->shown.octree || (s->motion.shown && is_light_old(&s->motion));
    sl_status status = make_direct(s, error);
    if (status == SL_OK && s->plan.photons && old) status = light_anew(s, error);
    const sl_octree_phase next = s->plan.direct ? SL_OCTREE_PHASE_DIRECT : SL_OCTREE_PHASE_PHOTONS;
    if (status == SL_OK) status = can_be_strips(s) ? draw_strips(s, error) : draw_in_steps(s, error);
    s->phase = next; /* rays and photons as of what stands still come now */
    s->fresh = status == SL_OK;
    return status;
}

size_t sl_octree_motion_bytes(const sl_octree_motion *m) {
    size_t bytes = sl_direct_map_bytes(m->direct);
    for (int k = 0; k < SL_OCTREE_SLICES; k++)
        if (m->slice[k]) bytes += m->slice[k]->capacity * sizeof(sl_photon);
    return bytes + (m->tree ? sl_photon_tree_bytes(m->tree) : 0);
}
