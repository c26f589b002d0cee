#include <string.h>

#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"
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
    sl_status status = list->reaches ? SL_OK : sl_reach_tree_create(&list->reaches, error);
    if (status != SL_OK) return status;
    if (list->count == list->capacity && !make_room(list, coefficients != NULL, coefficient_count))
        return sl_fail_memory(error, "records");
    status =
        sl_reach_tree_insert(list->reaches, record->position, record->own_radius / record->stretch, error);
    if (status != SL_OK) return status;
    if (coefficients)
        memcpy(list->coefficients + list->count * coefficient_count, coefficients,
               coefficient_count * sizeof *coefficients);
    list->records[list->count++] = *record;
    return SL_OK;
}

void sl_record_list_clear(sl_record_list *list) {
    if (list->reaches) sl_reach_tree_clear(list->reaches);
    list->count = 0;
}

void sl_record_list_free(sl_record_list *list) {
    sl_free(list->records);
    sl_free(list->coefficients);
    sl_reach_tree_destroy(list->reaches);
    *list = (sl_record_list){0};
}
