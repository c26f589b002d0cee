#include <string.h>

#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/splatting/splatting.h"

static bool make_room(sl_record_list *list, bool with_coefficients, size_t coefficient_count) {
    size_t capacity = list->capacity ? 2 * list->capacity : 1024;
    bool grown = sl_regrow(&list->records, list->count, capacity, sizeof *list->records);
    if (with_coefficients)
        grown =
            grown && sl_regrow(&list->coefficients, list->count, capacity, coefficient_count * sizeof(float));
    if (grown) list->capacity = capacity;
    return grown;
}

sl_status sl_record_list_append(sl_record_list *list, const sl_record *record, const float *coefficients,
                                size_t coefficient_count, sl_error *error) {
    if (list->count == list->capacity && !make_room(list, coefficients != NULL, coefficient_count))
        return sl_fail_memory(error, "records");
    sl_status status =
        sl_reach_tree_insert(&list->reaches, record->position, record->own_radius / record->stretch, error);
    if (status != SL_OK) return status;
    if (coefficients)
        memcpy(list->coefficients + list->count * coefficient_count, coefficients,
               coefficient_count * sizeof *coefficients);
    list->records[list->count++] = *record;
    return SL_OK;
}

/* ---- rule 5 ---- */

typedef struct {
    const sl_record_list *list;
    float *radii;
} clamp_context;

static void clamp_one(void *context, size_t index, unsigned worker) {
    (void)worker;
    const clamp_context *c = context;
    c->radii[index] = sl_record_clamped_radius(&c->list->reaches, &c->list->records[index]);
}

sl_status sl_record_list_clamp(sl_record_list *list, unsigned threads, bool *shrunk, sl_error *error) {
    float *radii = sl_allocate(list->count, sizeof *radii);
    if (!radii) return sl_fail_memory(error, "record radii");
    clamp_context context = {list, radii};
    sl_parallel_for(threads, list->count, clamp_one, &context);
    for (size_t i = 0; i < list->count; i++) {
        if (!(radii[i] < list->records[i].radius)) continue;
        sl_record_set_radius(&list->records[i], radii[i]);
        *shrunk = true;
    }
    sl_free(radii);
    return SL_OK;
}

void sl_record_list_clear(sl_record_list *list) {
    list->reaches.count = list->count = 0;
}

void sl_record_list_free(sl_record_list *list) {
    sl_free(list->records);
    sl_free(list->coefficients);
    sl_free(list->reaches.nodes);
    *list = (sl_record_list){0};
}
