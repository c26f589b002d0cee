#include "app/live/report.h"

#include "app/utf8.h"

#include <cjson/cJSON.h>
#include <stdio.h>

static double a_second(uint64_t count, double seconds) {
    return seconds > 0.0 ? (double)count / seconds : 0.0;
}
static double each(double seconds, uint64_t count) { return count ? 1e3 * seconds / (double)count : 0.0; }

static void print_stages(const sl_show_report *r) {
    double all = sl_pass_times_sum(r->stages);
    for (int i = 0; i < r->stages->count && all > 0.0; i++) {
        const sl_pass_time *s = &r->stages->pass[i];
        fprintf(stderr, "  %-20s %9.3f ms  %5.1f %%\n", s->name, each(s->seconds, s->times),
                100.0 * s->seconds / all);
    }
}

void sl_show_report_print(const sl_show_report *r) {
    uint64_t points = r->counters.value[SL_COUNT_POINTS_SHADED];
    fprintf(stderr, "frames    %llu in %.2f s: %.1f a second", (unsigned long long)r->frames, r->seconds,
            a_second(r->frames, r->seconds));
    if (r->frames_per_second > 0.0)
        fprintf(stderr, " of %g, %llu missed", r->frames_per_second, (unsigned long long)r->missed);
    fprintf(stderr, "; %.2f ms of a processor to draw one, the longest took %.1f\n",
            each(r->drawing, r->frames), 1e3 * r->longest);
    fprintf(stderr, "updates   %llu: %.2f a second", (unsigned long long)r->last.updates,
            a_second(r->last.updates, r->seconds));
    if (points)
        fprintf(stderr, "; %llu points, %.1f a second", (unsigned long long)points,
                a_second(points, r->seconds));
    if (r->last.error_levels >= 0.0)
        fprintf(stderr, "; what is seen last seems off by %.2f levels", r->last.error_levels);
    fprintf(stderr, "\n");
    if (r->last.changes_shown) {
        fprintf(stderr,
                "changes   %llu of light were shown, %.2f s after the moves on the average, %.2f at most",
                (unsigned long long)r->last.changes_shown, r->lag / (double)r->last.changes_shown,
                r->longest_lag);
        uint64_t found = r->counters.value[SL_COUNT_CHANGES_SHOWN];
        if (found)
            fprintf(stderr, "; found in %.1f updates",
                    (double)r->counters.value[SL_COUNT_UPDATES_TO_SHOW] / (double)found);
        fprintf(stderr, "\n");
    }
    print_stages(r);
}

void sl_show_report_json(const sl_show_report *r) {
    cJSON *root = cJSON_CreateObject();
    cJSON *size = cJSON_AddArrayToObject(root, "size");
    cJSON_AddItemToArray(size, cJSON_CreateNumber(r->width));
    cJSON_AddItemToArray(size, cJSON_CreateNumber(r->height));
    cJSON_AddStringToObject(root, "scene", r->scene);
    cJSON_AddStringToObject(root, "method", r->method);
    cJSON_AddNumberToObject(root, "seconds", r->seconds);
    cJSON_AddNumberToObject(root, "frames", (double)r->frames);
    cJSON_AddNumberToObject(root, "missed", (double)r->missed);
    cJSON_AddNumberToObject(root, "frames_a_second", a_second(r->frames, r->seconds));
    cJSON_AddNumberToObject(root, "drawing_ms", each(r->drawing, r->frames));
    cJSON_AddNumberToObject(root, "longest_ms", 1e3 * r->longest);
    cJSON_AddNumberToObject(root, "updates", (double)r->last.updates);
    cJSON_AddNumberToObject(root, "versions", (double)r->last.versions);
    cJSON_AddNumberToObject(root, "error_levels", r->last.error_levels);
    cJSON_AddNumberToObject(root, "changes_shown", (double)r->last.changes_shown);
    cJSON_AddNumberToObject(root, "lag_ms", each(r->lag, r->last.changes_shown));
    cJSON_AddNumberToObject(root, "longest_lag_ms", 1e3 * r->longest_lag);
    cJSON *stages = cJSON_AddObjectToObject(root, "stages_ms");
    for (int i = 0; i < r->stages->count; i++) {
        const sl_pass_time *s = &r->stages->pass[i];
        cJSON_AddNumberToObject(stages, s->name, each(s->seconds, s->times));
    }
    cJSON *counters = cJSON_AddObjectToObject(root, "counters");
    for (int i = 0; i < SL_COUNTERS; i++)
        cJSON_AddNumberToObject(counters, sl_counter_name((sl_counter)i), (double)r->counters.value[i]);
    char *text = cJSON_Print(root);
    if (text) puts(sl_utf8_mend(text));
    cJSON_free(text);
    cJSON_Delete(root);
}
