/* Step 4 of Algorithm 2: the pixels are visited in a fixed order, and an uncovered one gets a record.
 *
 * The paper's order is linear. The default is coarse to fine: every 16th pixel of every 16th row, then every
 * 8th, and so on; and within such a level not row by row but in steps of the golden ratio, so that pixels
 * visited one after the other are far apart: the fewer of a batch (record_batch.h) are set aside. */
#include "base/counters.h"
#include "base/error.h"
#include "base/golden.h"
#include "base/memory.h"
#include "base/random.h"
#include "cache/splatting/splatting.h"

enum { COARSEST_STRIDE = 16 };

static void start_level(sl_traversal *t, int stride) {
    t->stride = stride;
    if (stride == 0) return;
    t->columns = (uint64_t)((t->width + stride - 1) / stride);
    t->cells = t->columns * (uint64_t)((t->height + stride - 1) / stride);
    t->step = t->order == SL_ORDER_LINEAR ? 1 : sl_golden_step(t->cells);
    t->next = 0;
}

void sl_traversal_start(sl_traversal *traversal, sl_traversal_order order, int width, int height) {
    *traversal = (sl_traversal){.order = order, .width = width, .height = height, .batch = SL_BATCH_MIN,
                                .total = (uint64_t)width * (uint64_t)height};
    start_level(traversal, order == SL_ORDER_LINEAR ? 1 : COARSEST_STRIDE);
}

/* The next pixel of the order that no coarser level has visited; false where all are visited. */
static bool next_pixel(sl_traversal *t, size_t *pixel) {
    while (t->stride) {
        const uint64_t cell = t->next * t->step % t->cells, stride = (uint64_t)t->stride;
        const uint64_t column = cell % t->columns, row = cell / t->columns;
        bool first_level = t->order == SL_ORDER_LINEAR || stride == COARSEST_STRIDE;
        bool is_new = first_level || column % 2 != 0 || row % 2 != 0;
        if (++t->next == t->cells) start_level(t, t->order == SL_ORDER_LINEAR ? 0 : t->stride / 2);
        if (!is_new) continue;
        *pixel = (size_t)(row * stride) * (size_t)t->width + (size_t)(column * stride);
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

/* ---- a batch of them gets records ---- */

static sl_gather_point point_at(const sl_record_pass *pass, size_t pixel) {
    const sl_gbuffer *g = pass->gbuffer;
    return (sl_gather_point){
        .position = sl_gbuffer_position(g, pixel),
        .geometric_normal = sl_gbuffer_geometric(g, pixel),
        .normal = sl_gbuffer_normal(g, pixel),
        .triangle = g->id[pixel],
        .key = sl_random_key(pass->seed, pixel),
    };
}

/* Along the view; by way of mirrors as long as the way. */
static float depth_of(const sl_record_pass *pass, size_t pixel, sl_vec3 p) {
    const sl_vec3 *from = pass->gbuffer->seen_from ? &pass->gbuffer->seen_from[pixel] : NULL;
    sl_vec3 to_mirror = from ? sl_sub(*from, pass->camera->eye) : sl_v3(0.0f, 0.0f, 0.0f);
    if (sl_dot(to_mirror, to_mirror) > 0.0f) return sl_length(to_mirror) + sl_length(sl_sub(p, *from));
    return -sl_dot(sl_sub(p, pass->camera->eye), pass->camera->back);
}

float sl_record_weight(const sl_record_pass *pass, const sl_record *record, size_t pixel) {
    return SL_KERNEL_OF(pass->isa, sl_splat_weight)(record, &pass->weights, &pass->receivers, pixel);
}

/* Has an earlier record of this batch covered the pixel meanwhile? Adds their weights in order, as the
 * coverage buffer will. */
static bool covered_by_batch(const sl_record_pass *pass, const sl_record_list *list, size_t first,
                             size_t pixel) {
    float sum = pass->coverage[pixel];
    for (size_t i = first; i < list->count; i++) sum += sl_record_weight(pass, &list->records[i], pixel);
    return sum >= pass->covered_weight;
}

static sl_status commit(const sl_record_pass *pass, const size_t *pixels, sl_record_batch *batch,
                        sl_record_list *list, sl_counters *counters, sl_error *error) {
    const size_t first = list->count, floats = batch->coefficient_count;
    for (size_t i = 0; i < batch->count; i++) {
        if (covered_by_batch(pass, list, first, pixels[i])) {
            sl_count(counters, SL_COUNT_RECORDS_DISCARDED, 1);
            continue;
        }
        sl_record *record = &batch->record[i];
        sl_record_set_radius(record, sl_record_clamped_radius(&list->reaches, record));
        const float *coefficients = floats ? batch->coefficients + i * floats : NULL;
        sl_status status = sl_record_list_append(list, record, coefficients, floats, error);
        if (status != SL_OK) return status;
        pass->owned[pixels[i]] = 1;
        sl_count(counters, SL_COUNT_RECORDS, 1);
    }
    return sl_cover(pass, list->records + first, list->count - first, error);
}

sl_status sl_traversal_gather(sl_traversal *traversal, const sl_record_pass *pass, const size_t *pixels,
                              size_t count, sl_record_list *list, sl_counters *counters, sl_error *error) {
    const size_t floats = pass->coefficient_count, before = list->count;
    float *coefficients = floats ? sl_allocate(count, floats * sizeof *coefficients) : NULL;
    sl_record_batch *b = sl_allocate(1, sizeof *b);
    sl_status status = b && (coefficients || !floats) ? SL_OK : sl_fail_memory(error, "a batch of records");
    if (status == SL_OK) {
        *b = (sl_record_batch){.scene = pass->scene, .tracer = pass->tracer, .gathers = pass->gathers,
                               .radii = pass->radii, .coefficient_count = floats, .count = count,
                               .coefficients = coefficients};
        for (size_t i = 0; i < count; i++) {
            b->point[i] = point_at(pass, pixels[i]);
            b->footprint[i] = depth_of(pass, pixels[i], b->point[i].position) * pass->footprint_per_depth;
        }
        sl_record_batch_gather(b, counters);
        status = commit(pass, pixels, b, list, counters, error);
        traversal->batch = sl_record_batch_size(traversal->batch, count, list->count - before);
    }
    sl_free(coefficients);
    sl_free(b);
    return status;
}
