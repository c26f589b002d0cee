#include "app/live/report.h"

#include "app/page.h"

#include <stdio.h>

static double a_second(uint64_t count, double seconds) {
    return seconds > 0.0 ? (double)count / seconds : 0.0;
}
static double each(double seconds, uint64_t count) { return count ? 1e3 * seconds / (double)count : 0.0; }

static cJSON *json_of(const sl_show_report *r) {
    cJSON *root = cJSON_CreateObject();
    cJSON_AddItemToObject(root, "size", cJSON_CreateIntArray((const int[]){r->width, r->height}, 2));
    cJSON_AddStringToObject(root, "scene", r->scene);
    cJSON_AddStringToObject(root, "method", r->method);
    cJSON_AddNumberToObject(root, "seconds", r->seconds);
    cJSON_AddNumberToObject(root, "frames", (double)r->frames);
    cJSON_AddNumberToObject(root, "missed", (double)r->missed);
    cJSON_AddNumberToObject(root, "frames_a_second", a_second(r->frames, r->seconds));
    cJSON_AddNumberToObject(root, "drawing_ms", each(r->drawing, r->frames));
    cJSON_AddNumberToObject(root, "longest_ms", 1e3 * r->longest);
    cJSON_AddNumberToObject(root, "updates", (double)r->last.updates);
    cJSON_AddNumberToObject(root, "updates_a_second", a_second(r->last.updates, r->seconds));
    cJSON_AddNumberToObject(root, "points_a_second",
                            a_second(r->counters.value[SL_COUNT_POINTS_SHADED], r->seconds));
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
    sl_json_add_counters(root, "counters", &r->counters, false);
    return root;
}

void sl_show_report_json(const sl_show_report *r) { sl_json_print(json_of(r), false); }

void sl_show_report_print(const sl_show_report *r) { sl_json_lines(stderr, json_of(r)); }
