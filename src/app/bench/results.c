#include "app/bench/results.h"

#include <stdlib.h>
#include <string.h>

void sl_bench_results_free(sl_bench_results *results) {
    for (size_t s = 0; s < results->scene_count; s++) {
        sl_bench_scene *scene = &results->scenes[s];
        for (size_t i = 0; i < scene->row_count; i++) free(scene->rows[i].difference);
        for (size_t i = 0; i < scene->reference_count; i++) free(scene->references[i].difference);
        free(scene->rows);
        free(scene->references);
        free(scene->picture);
    }
    free(results->scenes);
    memset(results, 0, sizeof *results);
}

static int by_value(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

sl_bench_spread sl_bench_spread_of(double *values, int count) {
    if (count < 1) return (sl_bench_spread){0};
    qsort(values, (size_t)count, sizeof *values, by_value);
    double median = 0.5 * (values[(count - 1) / 2] + values[count / 2]);
    return (sl_bench_spread){count, median, values[0], values[count - 1]};
}

double sl_bench_unrest_of(double *values, int count) {
    double median = sl_bench_spread_of(values, count).median;
    return count >= 4 && median > 0.0 ? 0.5 * (values[count - 1 - count / 4] - values[count / 4]) / median
                                      : 0.0;
}

double sl_bench_number(const cJSON *object, const char *name) {
    const cJSON *item = cJSON_GetObjectItem(object, name);
    return cJSON_IsNumber(item) ? item->valuedouble : 0.0;
}

double sl_bench_counter(const sl_bench_row *row, sl_counter counter) {
    return sl_bench_number(cJSON_GetObjectItem(row->result, "counters"), sl_counter_name(counter));
}

bool sl_bench_promises(const sl_bench_row *row) { return cJSON_HasObjectItem(row->result, "bound"); }

bool sl_bench_is_tracer(const sl_trial *trial) {
    return strcmp(trial->method, "path") == 0 || strcmp(trial->method, "bidirectional") == 0;
}

const char *sl_bench_end_name(sl_bench_end end) {
    static const char *const names[] = {"ran", "failed", "crashed", "stopped", "left out"};
    return names[end];
}
