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

sl_bench_kept sl_bench_promises(const sl_bench_results *results, const char *method) {
    enum { MOST = 4096 };
    static double slack[MOST];
    sl_bench_kept k = {0, 0, 0.0};
    for (size_t s = 0; s < results->scene_count; s++) {
        for (size_t i = 0; i < results->scenes[s].row_count && k.made < MOST; i++) {
            const sl_bench_row *row = &results->scenes[s].rows[i];
            const sl_bench_promise *p = &row->promise;
            if (!p->known || !p->measured_known || !(p->measured > 0.0) ||
                (method && strcmp(row->method, method) != 0))
                continue;
            slack[k.made++] = p->bound / p->measured;
            k.kept += p->measured <= p->bound;
        }
    }
    k.slack = sl_bench_spread_of(slack, k.made).median;
    return k;
}

const char *sl_bench_truth_name(sl_bench_truth truth) {
    static const char *const names[] = {"matched", "one-bounce", "full"};
    return names[truth];
}

const char *sl_bench_quality_name(sl_bench_quality quality) {
    static const char *const names[] = {"draft", "normal", "high", "curve"};
    return names[quality];
}

const char *sl_bench_end_name(sl_bench_end end) {
    static const char *const names[] = {"ran", "failed", "crashed", "stopped", "left out"};
    return names[end];
}
