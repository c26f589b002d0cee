/* Step 4 of Algorithm 2: the pixels are visited in a fixed order, and an uncovered one gets a record.
 *
 * The paper's order is linear. The default is coarse to fine: every 16th pixel of every 16th row, then every
 * 8th, and so on; and within such a level not row by row but in steps of the golden ratio, so that pixels
 * visited one after the other are far apart. A record's content does not depend on the cache, and coverage
 * only grows; so a batch of candidates can be gathered in parallel and committed in order, setting aside
 * those that an earlier one of the batch has covered: the records are those of the sequential algorithm,
 * whatever the batch and the number of threads. The further apart, the fewer are set aside. */
#include "base/batch.h"
#include "base/error.h"
#include "base/golden.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/random.h"
#include "cache/splatting/splatting.h"

#include <string.h>

enum { COARSEST_STRIDE = 16, SMALLEST_BATCH = 4 };

static void start_level(sl_traversal *t, int stride) {
    t->stride = stride;
    if (stride == 0) return;
    t->columns = (uint64_t)(t->width + stride - 1) / (uint64_t)stride;
    t->rows = (uint64_t)(t->height + stride - 1) / (uint64_t)stride;
    t->cells = t->columns * t->rows;
    t->next = t->column = t->row = 0;
    uint64_t step = t->order == SL_ORDER_LINEAR ? 1 : sl_golden_step(t->cells);
    t->step_columns = step % t->columns;
    t->step_rows = step / t->columns;
}

/* As many cells on as the step, counted row by row and around: without a division for every pixel. */
static void step_on(sl_traversal *t) {
    t->column += t->step_columns;
    t->row += t->step_rows;
    if (t->column >= t->columns) {
        t->column -= t->columns;
        t->row++;
    }
    if (t->row >= t->rows) t->row -= t->rows;
}

void sl_traversal_start(sl_traversal *traversal, sl_traversal_order order, int width, int height) {
    *traversal = (sl_traversal){.order = order, .width = width, .height = height, .batch = SMALLEST_BATCH,
                                .total = (uint64_t)width * (uint64_t)height};
    start_level(traversal, order == SL_ORDER_LINEAR ? 1 : COARSEST_STRIDE);
}

/* The next pixel of the order that no coarser level has visited; false where all are visited. */
static bool next_pixel(sl_traversal *t, size_t *pixel) {
    while (t->stride) {
        uint64_t x = t->column * (uint64_t)t->stride, y = t->row * (uint64_t)t->stride;
        bool first_level = t->order == SL_ORDER_LINEAR || t->stride == COARSEST_STRIDE;
        bool is_new = first_level || t->column % 2 != 0 || t->row % 2 != 0;
        step_on(t);
        if (++t->next == t->cells) start_level(t, t->order == SL_ORDER_LINEAR ? 0 : t->stride / 2);
        if (!is_new) continue;
        *pixel = (size_t)y * (size_t)t->width + (size_t)x;
        t->visited++;
        return true;
    }
    return false;
}

/* Coverage first: most pixels have it when they are visited, and each plane that is looked into is a miss in
 * the cache. */
static bool wants_record(const sl_record_pass *pass, size_t pixel) {
    return !(pass->coverage[pixel] >= pass->covered_weight) && pass->receivers.receives[pixel] &&
           !pass->owned[pixel];
}

size_t sl_traversal_next(sl_traversal *t, const sl_record_pass *pass, size_t pixels[SL_BATCH_MAX]) {
    size_t count = 0, pixel;
    while (count < t->batch && next_pixel(t, &pixel)) {
        if (wants_record(pass, pixel)) pixels[count++] = pixel;
    }
    return count;
}

/* ---- gathering a batch ---- */

typedef struct {
    const sl_record_pass *pass;
    const size_t *pixels;
} gather_batch;

/* A result of the batch, with the pass's number of coefficients. */
typedef struct {
    sl_record record;
    float coefficients[];
} candidate;

static size_t candidate_bytes(const sl_record_pass *pass) {
    return sizeof(candidate) + pass->coefficient_count * sizeof(float);
}

static sl_gather_point point_at(const sl_record_pass *pass, size_t pixel) {
    const sl_gbuffer *g = pass->gbuffer;
    return (sl_gather_point){
        .position = sl_v3(g->position_x[pixel], g->position_y[pixel], g->position_z[pixel]),
        .geometric_normal = sl_v3(g->geometric_x[pixel], g->geometric_y[pixel], g->geometric_z[pixel]),
        .normal = sl_v3(g->normal_x[pixel], g->normal_y[pixel], g->normal_z[pixel]),
        .triangle = g->id[pixel],
        .key = sl_random_key(pass->seed, pixel),
    };
}

static void gather_at(const sl_record_pass *pass, unsigned worker, const sl_gather_point *point,
                      sl_irradiance *irradiance, candidate *out, sl_counters *counters) {
    sl_gather_scratch *scratch = pass->scratch[worker];
    if (!pass->coefficient_count) sl_gather_irradiance(pass->gather, point, scratch, irradiance, counters);
    else sl_gather_radiance(pass->gather, point, scratch, irradiance, out->coefficients, counters);
}

/* Records that may reach past the guard look for the walls around them. */
static sl_record make_record(const sl_record_pass *pass, const sl_gather_point *point,
                             const sl_irradiance *irradiance, float footprint, bool inside,
                             sl_counters *counters) {
    sl_radius_rules rules = pass->radii;
    bool looks_for_walls =
        rules.guard && rules.metric == SL_METRIC_HESSIAN && !inside && pass->tracer && pass->scene;
    if (looks_for_walls) rules.guard = false;
    sl_record record = sl_record_make(point, irradiance, &rules, footprint);
    if (looks_for_walls)
        sl_record_find_walls(pass->scene, pass->tracer, point, rules.accuracy,
                             sl_record_guard(irradiance, &pass->radii), false, &record, counters);
    return record;
}

/* Along the view; by way of mirrors as long as the way. */
static float depth_of(const sl_record_pass *pass, size_t pixel, sl_vec3 p) {
    const sl_vec3 *from = pass->gbuffer->seen_from ? &pass->gbuffer->seen_from[pixel] : NULL;
    sl_vec3 to_mirror = from ? sl_sub(*from, pass->camera->eye) : sl_v3(0.0f, 0.0f, 0.0f);
    if (sl_dot(to_mirror, to_mirror) > 0.0f) return sl_length(to_mirror) + sl_length(sl_sub(p, *from));
    return -sl_dot(sl_sub(p, pass->camera->eye), pass->camera->back);
}

/* A point that sees mostly the insides of things lies within an intersection of surfaces: it tries again a
 * little further out, and if that does not help it reaches no further than R_min, and only what it sees. */
static void gather_one(void *context, size_t index, unsigned worker, void *result, sl_counters *counters) {
    const gather_batch *b = context;
    candidate *out = result;
    const sl_record_pass *pass = b->pass;
    sl_gather_point point = point_at(pass, b->pixels[index]);
    sl_irradiance irradiance;
    gather_at(pass, worker, &point, &irradiance, out, counters);
    float close = 1e-3f * pass->scale;
    bool inside = irradiance.back_share > 0.5f && irradiance.harmonic_mean < close;
    if (inside) {
        sl_gather_point outer = point;
        outer.position = sl_mad(point.position, 1e-4f * pass->scale, point.geometric_normal);
        gather_at(pass, worker, &outer, &irradiance, out, counters);
        inside = irradiance.back_share > 0.5f && irradiance.harmonic_mean < close;
    }
    if (inside) irradiance.harmonic_mean = irradiance.nearest = 0.0f, irradiance.curvature[0] = INFINITY;
    float footprint = depth_of(pass, b->pixels[index], point.position) * pass->footprint_per_depth;
    out->record = make_record(pass, &point, &irradiance, footprint, inside, counters);
    if (pass->coefficient_count)
        sl_record_limit_radius(&out->record, sl_glossy_length(pass->glossy.glossy, out->coefficients));
}

/* ---- records behind walls ---- */

/* A record whose R_min reaches past the guard is tested by a ray to each of its few pixels: walls thinner
 * than a pixel's footprint do not leak. Its rays are not counted, as pixels of many tiles ask at once. The
 * pixel's own triangle is not in the way to what lies in front of it; it may be in the way to what lies
 * behind. */
static bool sees(const sl_record_pass *pass, const sl_record *record, size_t pixel) {
    sl_gather_point at = point_at(pass, pixel);
    if (at.position.x == record->position.x && at.position.y == record->position.y &&
        at.position.z == record->position.z)
        return true; /* its own pixel */
    sl_ray16 ray;
    memset(&ray, 0, sizeof ray);
    float offset = sl_scene_offset_at(pass->scene, 1e-5f * pass->scale, at.position);
    sl_vec3 from = sl_mad(at.position, offset, at.geometric_normal);
    sl_vec3 to_record = sl_mad(record->position, offset, record->normal), to = sl_sub(to_record, from);
    if (!(sl_dot(to, to) > 0.0f)) return true;
    ray.origin_x[0] = from.x, ray.origin_y[0] = from.y, ray.origin_z[0] = from.z;
    ray.direction_x[0] = to.x, ray.direction_y[0] = to.y, ray.direction_z[0] = to.z;
    ray.far[0] = 1.0f;
    bool in_front = sl_dot(sl_sub(to_record, at.position), at.geometric_normal) > 0.0f;
    ray.skip[0] = in_front ? at.triangle : SL_NO_INDEX;
    sl_counters unused = {{0}};
    return !(sl_trace_occluded(pass->tracer, &ray, 1, false, &unused) & 1u);
}

float sl_record_weight(const sl_record_pass *pass, const sl_record *record, size_t pixel) {
    float w = pass->kernels->weight(record, &pass->weights, &pass->receivers, pixel);
    return w > 0.0f && record->behind_a_wall && pass->tracer && !sees(pass, record, pixel) ? 0.0f : w;
}

/* ---- committing it ---- */

/* Has an earlier record of this batch covered the pixel meanwhile? Adds their weights in order, as the
 * coverage buffer will. */
static bool covered_by_batch(const sl_record_pass *pass, const sl_record_list *list, size_t first,
                             size_t pixel) {
    float sum = pass->coverage[pixel];
    for (size_t i = first; i < list->count; i++) sum += sl_record_weight(pass, &list->records[i], pixel);
    return sum >= pass->covered_weight;
}

static sl_status commit(const gather_batch *batch, size_t count, void *candidates, sl_record_list *list,
                        sl_counters *counters, sl_error *error) {
    const sl_record_pass *pass = batch->pass;
    const size_t *pixels = batch->pixels;
    size_t first = list->count, floats = pass->coefficient_count;
    for (size_t i = 0; i < count; i++) {
        candidate *c = (candidate *)((char *)candidates + i * candidate_bytes(pass));
        if (covered_by_batch(pass, list, first, pixels[i])) {
            sl_count(counters, SL_COUNT_RECORDS_DISCARDED, 1);
            continue;
        }
        sl_record_set_radius(&c->record, sl_record_clamped_radius(&list->reaches, &c->record));
        const float *coefficients = floats ? c->coefficients : NULL;
        sl_status status = sl_record_list_append(list, &c->record, coefficients, floats, error);
        if (status != SL_OK) return status;
        pass->owned[pixels[i]] = 1;
        sl_count(counters, SL_COUNT_RECORDS, 1);
    }
    return sl_cover(pass, list->records + first, list->count - first, error);
}

sl_status sl_traversal_gather(sl_traversal *traversal, const sl_record_pass *pass, const size_t *pixels,
                              size_t count, sl_record_list *list, sl_counters *counters, sl_error *error) {
    void *candidates = sl_allocate(count, candidate_bytes(pass));
    if (!candidates) return sl_fail_memory(error, "a batch of records");
    gather_batch gathers = {pass, pixels};
    const sl_batch batch = {count, gather_one, &gathers, candidates, candidate_bytes(pass)};
    sl_batch_run(&batch, pass->threads, counters);
    size_t before = list->count;
    sl_status status = commit(&gathers, count, candidates, list, counters, error);
    /* The batch follows the waste; it never changes which records there are. */
    size_t wasted = count - (list->count - before);
    if (wasted * 32 <= count && traversal->batch < SL_BATCH_MAX) traversal->batch *= 2;
    else if (wasted * 8 > count && traversal->batch > SMALLEST_BATCH) traversal->batch /= 2;
    sl_free(candidates);
    return status;
}
