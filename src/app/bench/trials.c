/* A file of trials, line by line; the ladder of all methods is such a file too.
 *
 *   # a comment
 *   size 256x256
 *   scenes scenes/cornell.json scenes/vase.json    of the trials below
 *   truth matched:light-octree                     the paths that are theirs, with options that change them
 *   with -m light-octree --set light-octree.depth=6
 *   curve light octree                             one curve of a plot, from cheap to dear
 *   table remedies: cpu, matched, octree.leaves    of the trials below
 *   trial the default =
 *   trial depth 5 = --set light-octree.depth=5
 */
#include "app/bench/trials.h"

#include "base/error.h"
#include "base/values.h"
#include "cache/frame/settings.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Cheap settings first. What a curve adds lies between the qualities, below draft and above high, along the
 * settings that trade time for error best; light samples grow as records do, photons as voxels do, or one of
 * the two would bear all of the error. The tracers sample pixels at their centres as the methods do. */
static const char ladder[] =
    "truth matched:splatting\nwith -m splatting\ncurve splatting\n"
    "trial a 0.7, 2 light samples, 16x16 = -q draft --accuracy 0.7 --spp 2 --set gather-size=16\n"
    "trial draft = -q draft\n"
    "trial a 0.5, 8 light samples, 16x16 = --accuracy 0.5 --spp 8 --set gather-size=16\n"
    "trial normal = -q normal\n"
    "trial a 0.25, 32 light samples, 28x28 = -q high --accuracy 0.25 --spp 32 --set gather-size=28\n"
    "trial high = -q high\n"
    "trial a 0.1, 128 light samples, 48x48 = -q high --accuracy 0.1 --spp 128 --set gather-size=48\n"
    /* so many diffuse bounces that all of global illumination is its truth, but for glossy surfaces */
    "truth full\nwith -m splatting --bounces 6\ncurve splatting, 6 bounces\n"
    "trial draft = -q draft\ntrial normal = -q normal\ntrial high = -q high\n"
    "truth matched:direct-radiance\nwith -m direct-radiance\ncurve direct-radiance\n"
    "trial 2x2 photons = -q draft --photons 2\n"
    "trial draft = -q draft\n"
    "trial 4x4 photons, a point a lamp = --photons 4 --emitter-samples 1\n"
    "trial normal = -q normal\n"
    "trial high = -q high\n"
    /* with visibility of its photons it has the very paths of one bounce */
    "truth one-bounce\n"
    "trial high, visibility by rays = -q high --visibility rays\n"
    "truth matched:direct-radiance\n"
    "trial 12x12 photons, 4x4 emitters = -q high --photons 12 --emitter-samples 4\n"
    "truth one-bounce\n"
    "trial 8x8 photons, 4x4 emitters, rays = -q high --photons 8 --emitter-samples 4 --visibility rays\n"
    "truth matched:light-octree\nwith -m light-octree\ncurve light-octree\n"
    "trial 40k photons, depth 4 = "
    "-q draft --stored-photons 40000 --set light-octree.neighbours=60 --depth 4\n"
    "trial draft = -q draft\n"
    "trial 300k photons, depth 5 = --stored-photons 300000 --set light-octree.neighbours=200 --depth 5\n"
    "trial normal = -q normal\n"
    "trial 1.2M photons, depth 5 = --stored-photons 1200000 --set light-octree.neighbours=500 --depth 5\n"
    "trial high = -q high\n"
    /* the peer: the octree's photon map itself, gathered at every pixel */
    "with -m light-octree --set light-octree.photons-at-pixels=1\ncurve photons at pixels\n"
    "trial 40k photons, k 60 = -q draft --stored-photons 40000 --set light-octree.neighbours=60\n"
    "trial draft = -q draft\ntrial normal = -q normal\n"
    "truth matched:multi-mesh\nwith -m multi-mesh\ncurve multi-mesh\n"
    "trial threshold 4 = -q draft --threshold 4\n"
    "trial draft = -q draft\ntrial normal = -q normal\ntrial high = -q high\n"
    "trial threshold 0.25, leaves of 8 = "
    "-q high --threshold 0.25 --set multi-mesh.leaf-area=8 --set multi-mesh.leaf-edge=6\n"
    "trial threshold 0.1, leaves of 2 = "
    "-q high --threshold 0.1 --set multi-mesh.leaf-area=2 --set multi-mesh.leaf-edge=2\n"
    "truth matched:shading-cache\nwith -m shading-cache\ncurve shading-cache\n"
    "trial draft = -q draft\ntrial normal = -q normal\n"
    "trial normal, 100 updates = -q normal --updates 100\n"
    "trial high = -q high\n"
    "truth one-bounce\nwith -m path --transport one-bounce --set filter=centre\ncurve path, one-bounce\n"
    "trial 1 sample = --spp 1\ntrial 4 samples = --spp 4\n"
    "trial draft = -q draft\ntrial normal = -q normal\ntrial high = -q high\n"
    "trial 1024 samples = --spp 1024\n"
    "truth full\nwith -m path --transport full --set filter=centre\ncurve path, full\n"
    "trial 1 sample = --spp 1\ntrial 4 samples = --spp 4\n"
    "trial draft = -q draft\ntrial normal = -q normal\ntrial high = -q high\n"
    "trial 512 samples = --spp 512\n"
    "with -m bidirectional --transport full --set filter=centre\ncurve bidirectional, full\n"
    "trial 4 samples = --spp 4\n"
    "trial draft = -q draft\ntrial normal = -q normal\ntrial high = -q high\n";

/* ---- a line ---- */

/* What the lines so far say of the trials to come. */
typedef struct reader {
    sl_trials *trials;
    const char *scenes, *truth, *with, *curve;
    int table;
    size_t room;
} reader;

static bool copy(char *to, size_t room, const char *from) {
    return (size_t)snprintf(to, room, "%s", from) < room;
}

static sl_bench_quality quality_of(const char *name) {
    for (int q = SL_BENCH_DRAFT; q < SL_BENCH_CURVE; q++) {
        if (strcmp(name, sl_bench_quality_name((sl_bench_quality)q)) == 0) return (sl_bench_quality)q;
    }
    return SL_BENCH_CURVE;
}

/* Decides for the ladder's trials: of the tracers one look is enough, since they have one pass, and a first
 * picture does not depend on how many samples follow. */
static bool is_looked_at(const sl_trials *all, const sl_trial *t) {
    const char *columns = t->table < 0 ? NULL : all->table[t->table].columns;
    bool tracer = strcmp(t->method, "path") == 0 || strcmp(t->method, "bidirectional") == 0;
    if (columns) return strstr(columns, "part.") || strstr(columns, "first");
    return t->quality != SL_BENCH_CURVE && (!tracer || t->quality == SL_BENCH_DRAFT);
}

static sl_trial *add_trial(reader *r) {
    sl_trials *all = r->trials;
    if (all->count == r->room) {
        r->room = 2 * r->room + 64;
        sl_trial *more = realloc(all->trial, r->room * sizeof *more);
        if (!more) return NULL;
        all->trial = more;
    }
    return memset(&all->trial[all->count++], 0, sizeof *all->trial);
}

/* NAME = OPTIONS */
static const char *read_trial(reader *r, char *rest) {
    char *equals = strstr(rest, " =");
    sl_settings settings;
    if (!equals || !r->with || !r->truth) return "expected trial NAME = OPTIONS, after with and truth";
    *equals = '\0';
    sl_trial *t = add_trial(r);
    if (!t) return "not enough memory";
    bool fits = (size_t)snprintf(t->arguments, sizeof t->arguments, "%s%s", r->with, equals + 2) <
                    sizeof t->arguments &&
                copy(t->name, sizeof t->name, rest) && copy(t->transport, sizeof t->transport, r->truth);
    if (!fits) return "a trial that is too long";
    if (!sl_trial_settings(t->arguments, &settings) || !settings.method) return "options that mean nothing";
    copy(t->method, sizeof t->method, settings.method);
    copy(t->curve, sizeof t->curve, r->curve ? r->curve : settings.method);
    t->quality = quality_of(t->name);
    t->scenes = r->scenes;
    t->table = r->table;
    t->ordered = r->curve != NULL;
    t->look = is_looked_at(r->trials, t);
    return NULL;
}

/* NAME: COLUMN, COLUMN */
static const char *read_table(reader *r, char *rest) {
    sl_trials *all = r->trials;
    char *colon = strchr(rest, ':');
    if (!colon || all->table_count == SL_TRIAL_TABLES) return "expected table NAME: COLUMN, ...";
    *colon = '\0';
    if (!copy(all->table[all->table_count].name, SL_BENCH_NAME, rest)) return "a name that is too long";
    all->table[all->table_count].columns = colon + 1;
    r->table = (int)all->table_count++;
    r->curve = NULL;
    for (int t = 0; t < SL_BENCH_TRUTHS; t++)
        all->truth[t] = all->truth[t] || strstr(colon + 1, sl_bench_truth_name((sl_bench_truth)t));
    all->audits = all->audits || strstr(colon + 1, "estimate");
    all->truth[SL_BENCH_MATCHED] = all->truth[SL_BENCH_MATCHED] || all->audits;
    return NULL;
}

static const char *read_line(reader *r, char *line) {
    char *rest = line + strcspn(line, " ");
    sl_error error;
    int size[2];
    if (*rest) *rest++ = '\0';
    if (!*line || *line == '#') return NULL;
    if (strcmp(line, "trial") == 0) return read_trial(r, rest);
    if (strcmp(line, "table") == 0) return read_table(r, rest);
    if (strcmp(line, "scenes") == 0) return r->scenes = rest, NULL;
    if (strcmp(line, "truth") == 0) return r->truth = rest, NULL;
    if (strcmp(line, "with") == 0) return r->with = rest, NULL;
    if (strcmp(line, "curve") == 0) return r->curve = *rest ? rest : NULL, NULL;
    if (strcmp(line, "size") != 0) return "expected size, scenes, truth, with, curve, table or trial";
    if (sl_value_size(rest, 32768, size, &error) != SL_OK) return "expected size WxH";
    r->trials->width = size[0], r->trials->height = size[1];
    return NULL;
}

/* ---- a file ---- */

static char *text_of(const char *path) {
    char *text = NULL;
    size_t room = 0;
    FILE *in = fopen(path, "r");
    if (in && getdelim(&text, &room, '\0', in) < 0) free(text), text = NULL;
    if (in) fclose(in);
    return text;
}

sl_status sl_trials_read(const char *path, sl_trials *trials, sl_error *error) {
    int number = 1;
    reader r = {.trials = trials, .table = -1};
    *trials = (sl_trials){.text = path ? text_of(path) : strdup(ladder)};
    if (!trials->text)
        return sl_fail(error, SL_ERROR_INPUT, "%s: cannot be read", path ? path : "the ladder");
    for (char *line = trials->text, *next; line; line = next, number++) {
        next = strchr(line, '\n');
        if (next) *next++ = '\0';
        const char *trouble = read_line(&r, line);
        if (trouble)
            return sl_fail(error, SL_ERROR_INPUT, "%s:%d: %s", path ? path : "ladder", number, trouble);
    }
    for (int t = 0; t < SL_BENCH_TRUTHS && !path; t++) trials->truth[t] = true;
    trials->audits = trials->audits || !path;
    return SL_OK;
}

void sl_trials_free(sl_trials *trials) {
    free(trials->trial);
    free(trials->text);
    *trials = (sl_trials){0};
}

const char *sl_trials_next_scene(const char **at, size_t *length) {
    const char *scene = *at ? *at + strspn(*at, " ") : "";
    *length = strcspn(scene, " ");
    *at = scene + *length;
    return *length ? scene : NULL;
}
