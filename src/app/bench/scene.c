#include "app/bench/scene.h"

#include "app/same_file.h"
#include "base/error.h"
#include "scene/features.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- in the child ---- */

typedef struct look {
    const sl_bench_options *options;
    sl_bench_scene scene;
} look;

/* Refuses to write over the scene; what is written besides has names that no reader of scenes takes, or that
 * are made of the scene's hash. */
static sl_status spare_scene(const sl_scene *scene, const char *folder, sl_error *error) {
    static const char *const names[] = {"journal.jsonl", "report.html", "report.md",
                                        "results.csv",   "tables.md"};
    sl_status status = SL_OK;
    for (size_t i = 0; i < sizeof names / sizeof names[0] && status == SL_OK; i++)
        status = sl_spare_scene_in(scene, "output", folder, names[i], error);
    return status;
}

/* Makes the film small: the error of a method hardly depends on the size, its time does. */
static void choose_size(const sl_bench_options *o, const sl_scene *scene, sl_bench_scene *s) {
    const double most = 192.0;
    sl_scene_film(scene, &s->width, &s->height);
    double larger = s->width > s->height ? s->width : s->height, scale = larger > most ? most / larger : 1.0;
    s->width = (int)fmax(1.0, round(scale * s->width));
    s->height = (int)fmax(1.0, round(scale * s->height));
    if (o->size[0] > 0) s->width = o->size[0], s->height = o->size[1];
}

static void describe(const sl_scene *scene, sl_bench_scene *s, cJSON *root) {
    sl_features f = sl_scene_features(scene);
    snprintf(s->hash, sizeof s->hash, "%016" PRIx64, sl_scene_hash(scene));
    cJSON_AddStringToObject(root, "hash", s->hash);
    cJSON_AddNumberToObject(root, "width", s->width);
    cJSON_AddNumberToObject(root, "height", s->height);
    cJSON_AddNumberToObject(root, "triangles", (double)sl_scene_triangle_count(scene));
    cJSON_AddNumberToObject(root, "glossy", f.glossy_triangles > 0);
    cJSON_AddNumberToObject(root, "mirrors", f.mirror_triangles > 0);
    cJSON_AddNumberToObject(root, "sky", f.environment);
}

static bool look_work(void *context, char **report) {
    look *l = context;
    const sl_bench_options *o = l->options;
    sl_bench_scene *s = &l->scene;
    sl_scene *scene = NULL;
    sl_error error;
    cJSON *root = cJSON_CreateObject();
    sl_status status = sl_scene_load_with(s->path, &o->load, &scene, &error);
    if (status == SL_OK && spare_scene(scene, o->folder, &error) != SL_OK) {
        cJSON_AddStringToObject(root, "refused", error.message);
    } else if (status == SL_OK) {
        choose_size(o, scene, s);
        describe(scene, s, root);
    }
    *report = status == SL_OK ? cJSON_PrintUnformatted(root) : strdup(error.message);
    cJSON_Delete(root);
    sl_scene_destroy(scene);
    return status == SL_OK;
}

/* ---- in the parent ---- */

static void name_scene(const char *path, sl_bench_scene *s) {
    const char *slash = strrchr(path, '/');
    snprintf(s->path, sizeof s->path, "%s", path);
    snprintf(s->name, sizeof s->name, "%s", slash ? slash + 1 : path);
    char *dot = strrchr(s->name, '.');
    if (dot && dot != s->name) *dot = '\0';
}

static sl_status take(const cJSON *told, sl_bench_scene *s, sl_error *error) {
    const char *refused = cJSON_GetStringValue(cJSON_GetObjectItem(told, "refused")),
               *hash = cJSON_GetStringValue(cJSON_GetObjectItem(told, "hash"));
    if (refused) return sl_fail(error, SL_ERROR_USAGE, "%s", refused);
    if (!hash) return sl_fail(error, SL_ERROR_RESOURCES, "%s: it told nothing of itself", s->path);
    snprintf(s->hash, sizeof s->hash, "%s", hash);
    s->width = (int)sl_bench_number(told, "width");
    s->height = (int)sl_bench_number(told, "height");
    s->triangles = (uint64_t)sl_bench_number(told, "triangles");
    s->glossy = sl_bench_number(told, "glossy") > 0.0;
    s->mirrors = sl_bench_number(told, "mirrors") > 0.0;
    s->sky = sl_bench_number(told, "sky") > 0.0;
    return SL_OK;
}

sl_status sl_bench_scene_read(const sl_bench_options *o, const char *path, sl_bench_scene *s,
                              sl_error *error) {
    const sl_child_limits limits = {0.0, 0, sl_interrupted};
    look l = {.options = o};
    sl_child_end end;
    name_scene(path, s);
    s->base = o->trials->base;
    l.scene = *s;
    sl_status status = sl_child_run(look_work, &l, &limits, &end, error);
    if (status != SL_OK) return status;
    cJSON *told = cJSON_Parse(end.text);
    if (end.outcome == SL_CHILD_DONE) status = take(told, s, error);
    else snprintf(s->trouble, sizeof s->trouble, "%s", end.why);
    cJSON_Delete(told);
    free(end.text);
    return status;
}
