#include "app/bench/results.h"

#include <math.h>
#include <stdio.h>
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

void sl_bench_find_unrest(sl_bench_results *r) {
    enum { MOST = 4096 };
    static double apart[MOST];
    int count = 0;
    for (size_t i = 0; i < r->scene_count; i++) {
        for (size_t k = 0; k < r->scenes[i].row_count && count < MOST; k++) {
            const sl_bench_spread *cpu = &r->scenes[i].rows[k].cpu;
            if (cpu->count > 1 && cpu->median > 0.0)
                apart[count++] = 0.5 * (cpu->most - cpu->least) / cpu->median;
        }
    }
    r->unrest = sl_bench_spread_of(apart, count).median;
}

double sl_bench_number(const cJSON *object, const char *name) {
    const cJSON *item = cJSON_GetObjectItem(object, name);
    return cJSON_IsNumber(item) ? item->valuedouble : 0.0;
}

bool sl_bench_promises(const sl_bench_row *row) { return cJSON_HasObjectItem(row->result, "bound"); }

const char *sl_bench_end_name(sl_child_outcome end) {
    static const char *const names[] = {"ran", "failed", "crashed", "stopped", "left out"};
    return names[end];
}

/* ---- curves ---- */

static int by_time(const void *a, const void *b) {
    const sl_bench_row *x = *(const sl_bench_row *const *)a, *y = *(const sl_bench_row *const *)b;
    if (x->cpu.median != y->cpu.median) return x->cpu.median < y->cpu.median ? -1 : 1;
    return strcmp(x->trial->arguments, y->trial->arguments);
}

static void mark_best(sl_curve *c, sl_bench_truth truth) {
    double least = HUGE_VAL;
    for (size_t i = 0; i < c->count; i++) {
        c->best[i] = c->row[i]->error[truth].rel_rmse < least;
        if (c->best[i]) least = c->row[i]->error[truth].rel_rmse;
    }
}

size_t sl_curves_of(const sl_bench_scene *s, sl_bench_truth truth, sl_curve curves[SL_CURVES]) {
    size_t count = 0;
    for (size_t i = 0; i < s->row_count; i++) {
        const sl_bench_row *row = &s->rows[i];
        if (row->end != SL_CHILD_DONE || !row->error[truth].known || row->cpu.count == 0 ||
            !(row->cpu.median > 0.0))
            continue;
        size_t k = 0;
        while (k < count && strcmp(curves[k].name, row->trial->curve) != 0) k++;
        if (k == SL_CURVES) continue;
        if (k == count) curves[count++] = (sl_curve){.name = row->trial->curve};
        if (curves[k].count < SL_CURVE_POINTS) curves[k].row[curves[k].count++] = row;
    }
    for (size_t k = 0; k < count; k++) {
        qsort(curves[k].row, curves[k].count, sizeof curves[k].row[0], by_time);
        mark_best(&curves[k], truth);
    }
    return count;
}

double sl_curve_time_to(const sl_curve *c, sl_bench_truth truth, double error) {
    const sl_bench_row *before = NULL;
    for (size_t i = 0; i < c->count; i++) {
        if (!c->best[i]) continue;
        const sl_bench_row *row = c->row[i];
        double e = row->error[truth].rel_rmse;
        if (e <= error && !before) return row->cpu.median;
        if (e <= error) {
            double e0 = before->error[truth].rel_rmse, t0 = before->cpu.median;
            double share = e > 0.0 && e0 > e ? log(e0 / error) / log(e0 / e) : 1.0;
            return t0 * exp(share * log(row->cpu.median / t0));
        }
        before = row;
    }
    return 0.0;
}

/* Tells whether the methods are measured beside it: tracers, and the photon map. */
static bool is_peer(const sl_curve *c) {
    return sl_is_tracer(c->row[0]->trial->method) || strncmp(c->name, "photons", 7) == 0;
}

sl_lead sl_lead_at(const sl_bench_scene *scene, sl_bench_truth truth, double error) {
    sl_curve curves[SL_CURVES];
    sl_lead lead = {NULL, 0.0, 0.0, false};
    char path[SL_BENCH_NAME];
    size_t count = sl_curves_of(scene, truth, curves);
    snprintf(path, sizeof path, "path, %s", sl_bench_truth_name(truth));
    for (size_t i = 0; i < count; i++) {
        double seconds = sl_curve_time_to(&curves[i], truth, error);
        if (strcmp(curves[i].name, path) == 0) {
            lead.path_later = !(seconds > 0.0);
            lead.path_seconds = lead.path_later ? curves[i].row[curves[i].count - 1]->cpu.median : seconds;
        }
        if (is_peer(&curves[i]) || !(seconds > 0.0)) continue;
        if (!lead.method || seconds < lead.seconds) lead.method = curves[i].name, lead.seconds = seconds;
    }
    return lead;
}
