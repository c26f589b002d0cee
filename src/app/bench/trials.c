/* A file of trials, line by line; the ladder of all methods is such a file too.
 *
 *   # a comment
 *   base --filter centre --bounces 1               of all trials and of their references
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
#include "base/grow.h"
#include "base/memory.h"
#include "base/values.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ladder.trials, as the linker has put it in. */
extern const char _binary_src_app_bench_ladder_trials_start[], _binary_src_app_bench_ladder_trials_end[];

const char *sl_bench_truth_name(sl_bench_truth truth) {
    static const char *const names[] = {"matched", "one-bounce", "full"};
    return names[truth];
}

/* ---- a line ---- */

/* The lines so far, as far as they count for the trials to come. */
typedef struct reader {
    sl_trials *trials;
    const char *scenes, *truth, *with, *curve;
    int table;
    size_t room;
} reader;

static bool copy(char *to, size_t room, const char *from) {
    return (size_t)snprintf(to, room, "%s", from) < room;
}

static const char *quality_of(const char *name) {
    static const char *const qualities[] = {"draft", "normal", "high", "curve"};
    int q = 0;
    while (q < 3 && strcmp(name, qualities[q]) != 0) q++;
    return qualities[q];
}

/* Decides for the ladder's trials: of the tracers one look is enough, since they have one pass, and a first
 * picture does not depend on how many samples follow. */
static bool is_looked_at(const sl_trials *all, const sl_trial *t) {
    const char *columns = t->table < 0 ? NULL : all->table[t->table].columns;
    if (columns) return strstr(columns, "part.") || strstr(columns, "first");
    return sl_is_tracer(t->method) ? strcmp(t->quality, "draft") == 0 : strcmp(t->quality, "curve") != 0;
}

/* NAME = OPTIONS */
static const char *read_trial(reader *r, char *rest) {
    char *equals = strstr(rest, " =");
    sl_settings settings;
    if (!equals || !r->with || !r->truth) return "expected trial NAME = OPTIONS, after with and truth";
    *equals = '\0';
    sl_trials *all = r->trials;
    if (!sl_make_room(&all->trial, all->count, &r->room, sizeof *all->trial)) return "not enough memory";
    sl_trial *t = &all->trial[all->count++];
    bool fits = (size_t)snprintf(t->arguments, sizeof t->arguments, "%s%s%s%s", all->base,
                                 *all->base ? " " : "", r->with, equals + 2) < sizeof t->arguments &&
                copy(t->name, sizeof t->name, rest) && copy(t->transport, sizeof t->transport, r->truth);
    if (!fits) return "a trial that is too long";
    if (!sl_trial_settings(t->arguments, &settings) || !settings.method) return "options that mean nothing";
    copy(t->method, sizeof t->method, settings.method);
    copy(t->curve, sizeof t->curve, r->curve ? r->curve : settings.method);
    t->quality = quality_of(t->name);
    t->scenes = r->scenes;
    t->table = r->table;
    t->ordered = r->curve != NULL;
    bool goes_on = t > all->trial && strcmp(t[-1].curve, t->curve) == 0;
    t->rank = goes_on ? t[-1].rank + 1 : 0;
    t->look = is_looked_at(all, t);
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
    all->estimates = all->estimates || strstr(colon + 1, "estimate");
    all->truth[SL_BENCH_MATCHED] = all->truth[SL_BENCH_MATCHED] || all->estimates;
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
    if (strcmp(line, "base") == 0) return r->trials->base = rest, NULL;
    if (strcmp(line, "truth") == 0) return r->truth = rest, NULL;
    if (strcmp(line, "with") == 0) return r->with = rest, NULL;
    if (strcmp(line, "curve") == 0) return r->curve = *rest ? rest : NULL, NULL;
    if (strcmp(line, "size") != 0) return "expected base, size, scenes, truth, with, curve, table or trial";
    if (sl_value_size(rest, 32768, size, &error) != SL_OK) return "expected size WxH";
    r->trials->width = size[0], r->trials->height = size[1];
    return NULL;
}

/* ---- a file ---- */

static char *text_of(const char *path) {
    const char *ladder = _binary_src_app_bench_ladder_trials_start;
    if (!path) return strndup(ladder, (size_t)(_binary_src_app_bench_ladder_trials_end - ladder));
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
    *trials = (sl_trials){.text = text_of(path), .base = ""};
    if (!trials->text)
        return sl_fail(error, SL_ERROR_INPUT, "%s: cannot be read", path ? path : "the ladder");
    for (char *line = trials->text, *next; line; line = next, number++) {
        next = strchr(line, '\n');
        if (next) *next++ = '\0';
        const char *trouble = read_line(&r, line);
        if (trouble)
            return sl_fail(error, SL_ERROR_INPUT, "%s:%d: %s", path ? path : "ladder", number, trouble);
    }
    trials->truth[SL_BENCH_MATCHED] = trials->truth[SL_BENCH_MATCHED] || !path;
    trials->truth[SL_BENCH_FULL] = trials->truth[SL_BENCH_FULL] || !path;
    trials->estimates = trials->estimates || !path;
    return SL_OK;
}

void sl_trials_free(sl_trials *trials) {
    sl_free(trials->trial);
    free(trials->text);
    *trials = (sl_trials){0};
}
