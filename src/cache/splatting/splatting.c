/* Algorithm 2 of Gautron et al. 2005, corrected where the paper errs:
 *
 *   1  G-buffer                               update 0
 *   1b emission and direct light              one update for every DIRECT_ROWS rows
 *   2  splat existing records                 none are there at the start; after a camera edit all of them
 *   3  coverage                               kept as records are committed; the same sums, so nothing to read back
 *   4  new records where uncovered            one update a batch (traversal.c)
 *   4b clamp radii to neighbours, visit once more  one update, then step 4 again
 *   5  splat the new records only             resolve
 *   6  normalise, times albedo / pi, add direct and emission   resolve
 */
#include "cache/splatting/splatting.h"

#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/splatting/plan.h"

#include <string.h>

enum { DIRECT_ROWS = 64, SHADOW_MAP_SIZE = 1024 };

typedef enum { PHASE_GBUFFER, PHASE_DIRECT, PHASE_RECORDS, PHASE_CLAMP, PHASE_SECOND, PHASE_DONE } phase;

typedef struct {
    const sl_scene *scene;
    sl_settings settings;
    sl_splat_plan plan;

    sl_raster *raster;
    sl_tracer *tracer;
    sl_gather *gather;
    sl_gather_scratch **scratch;
    sl_shadow_maps *maps;
    sl_direct *direct;
    sl_environment sky, sun;        /* of the scene's environment; what is black is not present */
    sl_gbuffer *gbuffer;
    uint32_t *receives;
    float *planes;                  /* direct rgb, splat rgb, weight, count, coverage: 9 planes, bottom row first */
    float *direct_light[3], *coverage;
    sl_splat_buffer splats;
    uint8_t *owned;
    size_t splatted;                /* records in the splat buffer */
    sl_record_list list;
    sl_record_pass pass;
    sl_traversal traversal;
    phase phase;
    int direct_row;
    sl_counters counters, announced; /* all so far, and what observers have been told of */
} splat_state;

enum { PLANES = 9 };

static size_t pixel_count(const splat_state *s) { return (size_t)s->settings.width * (size_t)s->settings.height; }

/* ---- creation ---- */

static void destroy_transport(splat_state *s) {
    for (unsigned i = 0; s->scratch && i < s->settings.threads; i++) sl_gather_scratch_destroy(s->scratch[i]);
    sl_free(s->scratch);
    s->scratch = NULL;
    sl_gather_destroy(s->gather);
    sl_direct_destroy(s->direct);
    sl_shadow_maps_destroy(s->maps);
    sl_tracer_destroy(s->tracer);
    sl_raster_destroy(s->raster);
    sl_environment_release(&s->sky);
    sl_environment_release(&s->sun);
    s->gather = NULL;
    s->direct = NULL;
    s->maps = NULL;
    s->tracer = NULL;
    s->raster = NULL;
}

static void splat_destroy(void *state) {
    splat_state *s = state;
    if (!s) return;
    destroy_transport(s);
    sl_gbuffer_destroy(s->gbuffer);
    sl_free(s->receives);
    sl_free(s->planes);
    sl_free(s->owned);
    sl_record_list_free(&s->list);
    sl_free(s);
}

static const sl_environment *present_or_null(const sl_environment *e) { return e->present ? e : NULL; }

/* Everything that depends on geometry and lights, and not on the camera. Only what the plan asks for is made. */
static sl_status create_transport(splat_state *s, sl_error *error) {
    unsigned threads = s->settings.threads;
    sl_status status = sl_raster_create(s->scene, threads, &s->raster, error);
    if (status == SL_OK) status = sl_environment_split(&s->scene->environment, SL_SKY_CONTRAST, &s->sky, &s->sun, error);
    if (status == SL_OK && s->plan.direct) status = sl_tracer_create(s->scene, threads, NULL, &s->tracer, error);
    if (status == SL_OK && s->plan.direct && s->settings.direct == SL_DIRECT_SHADOW_MAPS)
        status = sl_shadow_maps_create(s->scene, s->raster, SHADOW_MAP_SIZE, threads, &s->maps, &s->counters, error);
    if (status == SL_OK && s->plan.direct) {
        sl_direct_settings direct = {s->plan.quality.light_samples, s->settings.seed, threads, s->maps,
                                     present_or_null(&s->sun), present_or_null(&s->sky)};
        status = sl_direct_create(s->scene, s->tracer, &direct, &s->direct, error);
    }
    if (status != SL_OK || !s->plan.indirect) return status;
    s->plan.gather.background = s->maps ? NULL : present_or_null(&s->sky); /* the maps hold all of the environment */
    status = sl_gather_create(s->scene, s->raster, s->tracer, &s->plan.gather, threads, &s->gather, &s->counters, error);
    if (status == SL_OK) {
        s->scratch = sl_allocate(threads, sizeof *s->scratch);
        if (!s->scratch) status = sl_fail_memory(error, "gathers");
    }
    for (unsigned i = 0; status == SL_OK && i < threads; i++) status = sl_gather_scratch_create(s->gather, &s->scratch[i], error);
    return status;
}

static sl_status create_buffers(splat_state *s, sl_error *error) {
    size_t pixels = pixel_count(s);
    s->receives = sl_allocate(pixels, sizeof *s->receives);
    s->owned = sl_allocate(pixels, sizeof *s->owned);
    s->planes = sl_allocate(PLANES * pixels, sizeof *s->planes);
    if (!s->receives || !s->owned || !s->planes) return sl_fail_memory(error, "the splat buffers");
    for (int c = 0; c < 3; c++) s->direct_light[c] = s->planes + (size_t)c * pixels;
    float *p = s->planes + 3 * pixels;
    s->splats = (sl_splat_buffer){p, p + pixels, p + 2 * pixels, p + 3 * pixels, p + 4 * pixels};
    s->coverage = p + 5 * pixels;
    return sl_gbuffer_create(s->settings.width, s->settings.height, &s->gbuffer, error);
}

static void prepare_pass(splat_state *s) {
    const sl_gbuffer *g = s->gbuffer;
    float a = (float)s->plan.quality.accuracy, diagonal = s->scene->diagonal;
    double tangent = sl_tan(0.5 * (double)s->plan.gather.plane_fov);
    s->pass = (sl_record_pass){
        .gather = s->gather,
        .tracer = s->tracer,
        .scratch = s->scratch,
        .gbuffer = g,
        .receivers = {g->width, g->height, g->position_x, g->position_y, g->position_z, g->normal_x, g->normal_y,
                      g->normal_z, s->receives},
        /* Smooth weights: a pixel counts as covered by one record at D <= 0.9 a, so that none hangs on a vanishing weight. */
        .weights = {a, 1.0f / a, 1e-5f * diagonal},
        .covered_weight = 1.0f / (9.0f * a),
        .radii = {s->plan.quality.accuracy, s->plan.quality.minimum_pixels, 0.1 * (double)diagonal, true, s->gather ? sl_gather_kind_used(s->gather) : SL_GATHER_RAYS,
                  tangent},
        .kernels = sl_splat_kernels_for(sl_isa_best()),
        .camera = &s->scene->camera,
        .near_distance = 1e-5f * diagonal,
        .footprint_per_depth = (float)(2.0 * sl_tan(0.5 * (double)s->scene->camera.vertical_fov)) / (float)s->settings.height,
        .neighbour_clamp = true,
        .coverage = s->coverage,
        .owned = s->owned,
        .seed = s->settings.seed,
        .threads = s->settings.threads,
        .diagonal = diagonal,
    };
}

static sl_status splat_create(const sl_scene *scene, const sl_settings *settings, const sl_transport *transport,
                              void **state, sl_error *error) {
    (void)transport; /* its own: sl_splat_transport() */
    splat_state *s = sl_allocate(1, sizeof *s);
    if (!s) return sl_fail_memory(error, "radiance cache splatting");
    s->scene = scene;
    s->settings = *settings;
    s->plan = sl_splat_plan_make(scene, settings);
    sl_status status = create_transport(s, error);
    if (status == SL_OK) status = create_buffers(s, error);
    if (status != SL_OK) {
        splat_destroy(s);
        return status;
    }
    prepare_pass(s);
    *state = s;
    return SL_OK;
}

/* ---- what observers are told ---- */

/* A pass with the picture that it made; its cost is what the counters have grown by since the last one. */
static void announce(splat_state *s, const char *name, const char *source, int channels, const float *planes) {
    sl_counters cost;
    for (int i = 0; i < SL_COUNTERS; i++) cost.value[i] = s->counters.value[i] - s->announced.value[i];
    s->announced = s->counters;
    sl_observe(s->settings.observer, "splatting", name, source, s->settings.width, s->settings.height, channels, planes, true,
               &cost);
}

/* ---- steps 1 and 1b ---- */

static sl_view camera_view(const splat_state *s) {
    const sl_camera *camera = &s->scene->camera;
    sl_frame frame = {camera->right, camera->up, sl_neg(camera->back)};
    float top = (float)sl_tan(0.5 * (double)camera->vertical_fov);
    float right = top * (float)s->settings.width / (float)s->settings.height;
    return sl_view_pyramid(&frame, camera->eye, -right, right, -top, top, s->settings.width, s->settings.height,
                           s->pass.near_distance);
}

/* Which pixels can reflect light diffusely: the others never ask for records. A normal that is not finite would ask for ever. */
static void classify_receivers(splat_state *s) {
    const sl_gbuffer *g = s->gbuffer;
    for (size_t i = 0; i < pixel_count(s); i++) {
        s->receives[i] = 0;
        if (g->material[i] == SL_NO_INDEX) continue;
        if (!sl_is_finite(sl_v3(g->normal_x[i], g->normal_y[i], g->normal_z[i])) ||
            !sl_is_finite(sl_v3(g->position_x[i], g->position_y[i], g->position_z[i]))) {
            sl_count(&s->counters, SL_COUNT_NONFINITE, 1);
            continue;
        }
        s->receives[i] = g->diffuse_r[i] > 0.0f || g->diffuse_g[i] > 0.0f || g->diffuse_b[i] > 0.0f;
    }
}

/* Three planes of the G-buffer as one picture; the pass is paid for by the first picture of it. */
static void announce_triple(splat_state *s, const char *name, const float *x, const float *y, const float *z) {
    size_t pixels = pixel_count(s);
    float *planes = sl_allocate(3 * pixels, sizeof *planes);
    if (!planes) return;
    memcpy(planes, x, pixels * sizeof *planes);
    memcpy(planes + pixels, y, pixels * sizeof *planes);
    memcpy(planes + 2 * pixels, z, pixels * sizeof *planes);
    announce(s, name, "Algorithm 2, step 1", 3, planes);
    sl_free(planes);
}

static void announce_gbuffer(splat_state *s) {
    const sl_gbuffer *g = s->gbuffer;
    if (!s->settings.observer) return;
    announce(s, "G-buffer: depth", "Algorithm 2, step 1", 1, g->depth);
    announce_triple(s, "G-buffer: positions", g->position_x, g->position_y, g->position_z);
    announce_triple(s, "G-buffer: normals", g->normal_x, g->normal_y, g->normal_z);
    announce_triple(s, "G-buffer: albedo", g->diffuse_r, g->diffuse_g, g->diffuse_b);
}

static sl_status draw_gbuffer(splat_state *s, sl_error *error) {
    sl_view view = camera_view(s);
    sl_status status = sl_raster_gbuffer(s->raster, &view, s->settings.threads, s->gbuffer, &s->counters, error);
    if (status != SL_OK) return status;
    announce_gbuffer(s);
    classify_receivers(s);
    s->direct_row = 0;
    s->phase = s->plan.direct ? PHASE_DIRECT : PHASE_DONE;
    if (s->list.count == 0) return SL_OK;
    return sl_cover(&s->pass, s->list.records, s->list.count, error); /* step 2: records of earlier views */
}

static sl_status light_rows(splat_state *s, sl_error *error) {
    int end = s->direct_row + DIRECT_ROWS < s->settings.height ? s->direct_row + DIRECT_ROWS : s->settings.height;
    sl_status status = sl_direct_rows(s->direct, s->gbuffer, s->direct_row, end, s->direct_light[0], s->direct_light[1],
                                      s->direct_light[2], &s->counters, error);
    if (status != SL_OK) return status;
    s->direct_row = end;
    if (end < s->settings.height) return SL_OK;
    announce(s, "direct light", "section 4, direct lighting", 3, s->planes);
    sl_traversal_start(&s->traversal, s->settings.order, s->settings.width, s->settings.height);
    s->phase = s->plan.indirect ? PHASE_RECORDS : PHASE_DONE;
    return SL_OK;
}

/* ---- step 4 ---- */

static sl_status new_records(splat_state *s, phase next, sl_error *error) {
    sl_status status = sl_traversal_advance(&s->traversal, &s->pass, &s->list, &s->counters, error);
    if (status != SL_OK || s->traversal.stride) return status;
    announce(s, "coverage: sum of w", "Algorithm 2, step 4", 1, s->coverage);
    s->phase = next;
    return SL_OK;
}

typedef struct {
    const sl_record_list *list;
    float *radii;
} clamp_context;

static void clamp_one(void *context, size_t index, unsigned worker) {
    (void)worker;
    const clamp_context *c = context;
    c->radii[index] = sl_record_clamped_radius(c->list->reaches, c->list->count, &c->list->records[index]);
}

/* Step 4b. A single pass over the radii is the fixed point of mutual clamping, whatever the order of insertion. Older records may
 * shrink: coverage is summed anew, and what came to light gets records in a second visit. */
static sl_status clamp_to_neighbours(splat_state *s, sl_error *error) {
    bool shrunk = false;
    float *radii = sl_allocate(s->list.count, sizeof *radii);
    if (!radii) return sl_fail_memory(error, "record radii");
    clamp_context context = {&s->list, radii};
    sl_parallel_for(s->settings.threads, s->list.count, clamp_one, &context);
    for (size_t i = 0; i < s->list.count; i++) {
        if (!(radii[i] < s->list.records[i].radius)) continue;
        sl_record_set_radius(&s->list.records[i], radii[i]);
        shrunk = true;
    }
    sl_free(radii);
    s->phase = PHASE_DONE;
    if (!shrunk) return SL_OK;
    size_t pixels = pixel_count(s);
    memset(s->coverage, 0, pixels * sizeof *s->coverage);
    memset(s->splats.r, 0, 5 * pixels * sizeof *s->splats.r); /* r, g, b, weight, count lie in one block */
    s->splatted = 0;
    sl_traversal_start(&s->traversal, s->settings.order, s->settings.width, s->settings.height);
    s->phase = PHASE_SECOND;
    return sl_cover(&s->pass, s->list.records, s->list.count, error);
}

/* Shares of the whole that each phase takes, roughly, for the progress bar alone. */
static double fraction_done(const splat_state *s) {
    double visited = s->traversal.total ? (double)s->traversal.visited / (double)s->traversal.total : 0.0;
    switch (s->phase) {
    case PHASE_GBUFFER: return 0.0;
    case PHASE_DIRECT: return 0.02 + 0.18 * (double)s->direct_row / (double)s->settings.height;
    case PHASE_RECORDS: return 0.2 + 0.7 * visited;
    case PHASE_CLAMP: return 0.9;
    case PHASE_SECOND: return 0.9 + 0.1 * visited;
    case PHASE_DONE: return 1.0;
    }
    return 1.0;
}

static sl_status splat_update(void *state, sl_progress *progress, sl_error *error) {
    splat_state *s = state;
    if (!s->raster) return sl_fail(error, SL_ERROR_RESOURCES, "an earlier edit of the scene failed; edit it again");
    sl_status status = SL_OK;
    switch (s->phase) {
    case PHASE_GBUFFER: status = draw_gbuffer(s, error); break;
    case PHASE_DIRECT: status = light_rows(s, error); break;
    case PHASE_RECORDS: status = new_records(s, PHASE_CLAMP, error); break;
    case PHASE_CLAMP: status = clamp_to_neighbours(s, error); break;
    case PHASE_SECOND: status = new_records(s, PHASE_DONE, error); break;
    case PHASE_DONE: break;
    }
    progress->fraction = fraction_done(s);
    progress->done = s->phase == PHASE_DONE;
    return status;
}

/* ---- steps 5 and 6 ---- */

/* Step 5: only what has not been splatted yet; with the earlier ones the sums are those of one pass over all, bit for bit. */
static sl_status splat_new_records(splat_state *s, sl_error *error) {
    size_t count = s->list.count - s->splatted;
    if (count == 0 || s->phase == PHASE_GBUFFER) return SL_OK; /* before its G-buffer a new view has nothing to splat on */
    sl_status status = sl_splat_records(&s->pass, s->list.records + s->splatted, count, &s->splats, &s->counters, error);
    if (status != SL_OK) return status;
    s->splatted = s->list.count;
    announce(s, "splat: sum of w E", "Algorithm 1", 3, s->splats.r);
    announce(s, "splat: sum of w", "Algorithm 1", 1, s->splats.weight);
    return SL_OK;
}

static sl_status splat_resolve(void *state, sl_image **image, sl_error *error) {
    splat_state *s = state;
    sl_status status = splat_new_records(s, error);
    if (status != SL_OK) return status;
    int width = s->settings.width, height = s->settings.height;
    size_t pixels = pixel_count(s);
    float *layers = sl_allocate(SL_LAYERS * pixels, sizeof *layers);
    sl_composition parts = {s->scene, s->gbuffer, s->receives, s->splats, {s->direct_light[0], s->direct_light[1], s->direct_light[2]},
                            s->phase != PHASE_GBUFFER};
    status = layers ? sl_compose(&parts, layers, error) : sl_fail_memory(error, "the picture");
    if (status == SL_OK) status = sl_image_create(width, height, SL_LAYERS, sl_layer_names, image, error);
    for (size_t c = 0; status == SL_OK && c < SL_LAYERS; c++)
        sl_raster_flip(layers + c * pixels, width, height, (*image)->planes + c * pixels);
    if (status == SL_OK) {
        announce(s, "indirect light", "Algorithm 2, step 6", 3, layers + 9 * pixels);
        announce(s, "sum of emission, direct and indirect light", "Algorithm 2, step 6", 3, layers);
    }
    sl_free(layers);
    return status;
}

/* ---- edits: records live in the world, so a new camera keeps them; new geometry or light drops them ---- */

static sl_status splat_edit(void *state, unsigned changes, sl_error *error) {
    splat_state *s = state;
    size_t pixels = pixel_count(s);
    memset(s->planes, 0, PLANES * pixels * sizeof *s->planes);
    memset(s->receives, 0, pixels * sizeof *s->receives);
    memset(s->owned, 0, pixels);
    s->splatted = 0;
    s->phase = PHASE_GBUFFER;
    sl_status status = SL_OK;
    if (changes & (SL_CHANGED_OBJECTS | SL_CHANGED_LIGHTS)) {
        s->list.count = 0;
        destroy_transport(s);
        status = create_transport(s, error);
        if (status != SL_OK) destroy_transport(s);
    }
    prepare_pass(s);
    return status;
}

static const sl_counters *splat_counters(const void *state) { return &((const splat_state *)state)->counters; }

static size_t splat_memory_bytes(const void *state) {
    const splat_state *s = state;
    size_t pixels = pixel_count(s);
    size_t gbuffer = pixels * (14 * sizeof(float) + 2 * sizeof(uint32_t));
    size_t bytes = sizeof *s + pixels * (PLANES * sizeof(float) + sizeof(uint32_t) + 1) + gbuffer;
    bytes += s->list.capacity * (sizeof(sl_record) + sizeof(sl_record_reach));
    if (s->raster) bytes += sl_raster_memory_bytes(s->raster);
    if (s->tracer) bytes += sl_tracer_memory_bytes(s->tracer);
    if (s->gather) bytes += sl_gather_memory_bytes(s->gather);
    if (s->maps) bytes += sl_shadow_maps_bytes(s->maps);
    return bytes;
}

const sl_method_class sl_splatting_method = {
    .name = "splatting",
    .complete = sl_splat_complete,
    .create = splat_create,
    .destroy = splat_destroy,
    .update = splat_update,
    .resolve = splat_resolve,
    .edit = splat_edit,
    .counters = splat_counters,
    .memory_bytes = splat_memory_bytes,
    .transport = sl_splat_transport,
    .plan = sl_splat_plan_write,
    .any_transport = false,
};
