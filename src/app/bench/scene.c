#define _DEFAULT_SOURCE /* MAP_ANONYMOUS */
/* Facts about a scene that are found before anything is measured of it. */
#include "app/bench/schedule.h"

#include "app/same_file.h"
#include "base/error.h"
#include "scene/features.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

/* ---- in the child ---- */

/* Shared with the child, which fills in the scene. */
typedef struct look {
    const sl_bench_options *options;
    sl_bench_scene scene;
    bool refused; /* the report would take the place of a file: the error says of which */
    sl_error error;
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

static void describe(const sl_scene *scene, sl_bench_scene *s) {
    sl_features f = sl_scene_features(scene);
    snprintf(s->hash, sizeof s->hash, "%016" PRIx64, sl_scene_hash(scene));
    s->triangles = sl_scene_triangle_count(scene);
    s->glossy = f.glossy_triangles > 0;
    s->mirrors = f.mirror_triangles > 0;
    s->sky = f.environment;
}

static bool look_work(void *context, char **report) {
    look *l = context;
    sl_scene *scene = NULL;
    sl_status status = sl_scene_load_with(l->scene.path, &l->options->load, &scene, &l->error);
    if (status == SL_OK) {
        status = spare_scene(scene, l->options->folder, &l->error);
        l->refused = status != SL_OK;
    }
    if (status == SL_OK) {
        choose_size(l->options, scene, &l->scene);
        describe(scene, &l->scene);
    }
    *report = strdup(l->error.message);
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

sl_status sl_bench_scene_read(const sl_bench_options *o, const char *path, sl_bench_scene *s,
                              sl_error *error) {
    const sl_child_limits limits = {0.0, 0, sl_interrupted};
    sl_child_end end = {0};
    look *l = mmap(NULL, sizeof *l, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (l == MAP_FAILED) return sl_fail_memory(error, "a look at a scene");
    name_scene(path, s);
    s->base = o->trials->base;
    *l = (look){.options = o, .scene = *s};
    sl_status status = sl_child_run(look_work, l, &limits, &end, error);
    if (status == SL_OK && l->refused) status = sl_fail(error, SL_ERROR_USAGE, "%s", l->error.message);
    else if (end.outcome == SL_CHILD_DONE) *s = l->scene;
    else snprintf(s->trouble, sizeof s->trouble, "%s", end.why);
    munmap(l, sizeof *l);
    free(end.text);
    return status;
}
