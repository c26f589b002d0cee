#include "app/bench/kinds.h"

#include "app/auto_method.h"
#include "app/bench/report.h"
#include "app/clock.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- in the child ---- */

static const char *const numbers[] = {"direct", "second",  "further", "mirrored",  "lit",
                                      "glossy", "mirrors", "open",    "triangles", "lights"};
enum { NUMBERS = sizeof numbers / sizeof *numbers };

typedef struct look {
    const sl_bench_scene *scene;
    sl_load_options load;
} look;

static bool look_work(void *context, char **report) {
    const look *l = context;
    const sl_bench_scene *s = l->scene;
    sl_settings settings = sl_settings_default();
    sl_scene *scene = NULL;
    sl_auto_kind k = {0};
    sl_error error;
    settings.width = s->width;
    settings.height = s->height;
    settings.threads = 1;
    sl_status status = sl_scene_load_with(s->path, &l->load, &scene, &error);
    if (status == SL_OK) status = sl_auto_look(scene, &settings, &k, &error);
    sl_scene_destroy(scene);
    if (status != SL_OK) {
        *report = strdup(error.message);
        return false;
    }
    const double values[NUMBERS] = {k.direct, k.second,  k.further, k.mirrored,  k.lit,
                                    k.glossy, k.mirrors, k.open,    k.triangles, k.lights};
    cJSON *root = cJSON_CreateObject();
    for (int i = 0; i < NUMBERS; i++) cJSON_AddNumberToObject(root, numbers[i], values[i]);
    *report = cJSON_PrintUnformatted(root);
    cJSON_Delete(root);
    return *report != NULL;
}

/* ---- in the parent ---- */

static void take(const cJSON *result, sl_bench_scene *s) {
    double v[NUMBERS] = {0};
    for (int i = 0; i < NUMBERS; i++) {
        const cJSON *item = cJSON_GetObjectItem(result, numbers[i]);
        if (!cJSON_IsNumber(item)) return;
        v[i] = item->valuedouble;
    }
    s->kind =
        (sl_auto_kind){v[0], v[1], v[2], v[3], v[4] > 0.0, v[5] > 0.0, v[6] > 0.0, v[7] > 0.0, v[8], v[9]};
    s->kind_known = true;
}

sl_status sl_kinds_look(const sl_bench_options *o, sl_bench_scene *s, sl_journal *journal, sl_error *error) {
    look l = {s, o->load};
    char key[256];
    snprintf(key, sizeof key, "%s %dx%d, %s %s, kind", s->hash, s->width, s->height, SL_VERSION, o->program);
    sl_status status = sl_schedule_child(o, s, key, 0.0, look_work, &l, journal, error);
    const cJSON *entry = sl_journal_find(journal, key);
    if (entry) take(cJSON_GetObjectItem(entry, "result"), s);
    return status;
}

static void put_kinds(FILE *out, const sl_bench_results *r) {
    fputs("scene,hash,pixels,direct,second,further,mirrored,lit,glossy,mirrors,open,triangles,lights\n", out);
    for (size_t i = 0; i < r->scene_count; i++) {
        const sl_bench_scene *s = &r->scenes[i];
        const sl_auto_kind *k = &s->kind;
        if (!s->kind_known) continue;
        fprintf(out, "%s,%s,%d,%.4f,%.4f,%.4f,%.4f,%d,%d,%d,%d,%.0f,%.0f\n", s->name, s->hash,
                s->width * s->height, k->direct, k->second, k->further, k->mirrored, k->lit, k->glossy,
                k->mirrors, k->open, k->triangles, k->lights);
    }
}

sl_status sl_kinds_write(const sl_bench_results *r, const char *folder, sl_error *error) {
    return sl_report_compose(r, folder, "scenes.csv", put_kinds, error);
}
