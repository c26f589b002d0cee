/* Interleaved: first the cheapest trial of every method, then the next ones, and all that as often as asked
 * for. A machine that is slow for a minute is then slow for all methods alike. */
#include "app/bench/schedule.h"

#include "app/clock.h"
#include "app/page.h"
#include "base/error.h"
#include "base/random.h"
#include "base/ranks.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* settings of a curve are some three times as dear as the one before */
static const double most_of_limit = 0.4;
/* A trial that takes longer is not repeated, since what disturbs it lasts shorter than it does; nor looked
 * at, where it takes yet longer. */
/* Of the processor: how often a trial runs is the same on a busy machine. */
enum { LONG_SECONDS = 1, LONG_LOOK_SECONDS = 3 };

/* A trial's runs are numbered; this one has an observer. */
enum { LOOK = -1 };

/* Tells whether a list, or NULL, names it. */
static bool is_listed(const char *list, const char *between, const char *name) {
    size_t length;
    if (!list) return true;
    for (const char *item; (item = sl_next_item(&list, between, &length));) {
        if (strlen(name) == length && strncmp(item, name, length) == 0) return true;
    }
    return false;
}

static uint64_t hash_of(const char *text, uint64_t hash) { return sl_hash_bytes(hash, text, strlen(text)); }

/* Of several ranks each has all settings of a curve: cheaper ones decide whether dearer ones are tried. */
static bool is_own(const sl_bench_scene *s, const sl_trial *t) {
    const sl_ranks here = sl_ranks_here();
    return hash_of(t->curve, hash_of(s->hash, 0)) % here.count == here.rank;
}

/* Scenes named on the command line stand for those of the trials' file. */
static bool is_wanted(const sl_bench_options *o, const sl_bench_scene *s, const sl_trial *t) {
    return (o->own_scenes || is_listed(t->scenes, " ", s->path)) && is_listed(o->methods, ",", t->method) &&
           is_listed(o->qualities, ",", t->quality);
}

/* ---- the journal's entries ---- */

enum { KEY = 1024 };

static void key_of(const sl_bench_options *o, const sl_bench_scene *s, const sl_trial *t, int run,
                   char key[KEY]) {
    snprintf(key, KEY, "%s %dx%d %u threads, %s %s, %s, %s %d", s->hash, s->width, s->height,
             (unsigned)o->threads, SL_VERSION, o->program, t->arguments, run == LOOK ? "look" : "run",
             run == LOOK ? 0 : run);
}

static cJSON *make_entry(const sl_bench_options *o, const sl_bench_scene *s, const char *key,
                         sl_child_outcome end, const char *why, cJSON *result) {
    cJSON *entry = cJSON_CreateObject();
    cJSON_AddStringToObject(entry, "key", key);
    cJSON_AddStringToObject(entry, "program", o->program);
    cJSON_AddStringToObject(entry, "scene", s->path);
    cJSON_AddStringToObject(entry, "end", sl_bench_end_name(end));
    if (*why) cJSON_AddStringToObject(entry, "why", why);
    if (result) cJSON_AddItemToObject(entry, "result", result);
    return entry;
}

static sl_child_outcome end_of(const cJSON *entry) {
    const char *end = cJSON_GetStringValue(cJSON_GetObjectItem(entry, "end"));
    for (int e = SL_CHILD_DONE; end && e <= SL_CHILD_STOPPED; e++) {
        if (strcmp(end, sl_bench_end_name((sl_child_outcome)e)) == 0) return (sl_child_outcome)e;
    }
    return SL_CHILD_CRASHED;
}

static double memory_bytes(const sl_bench_options *o) { return 0x1p20 * (double)o->memory_megabytes; }

/* Finds the entry of a run; what was stopped, or ran out of memory, is no answer where more is allowed now.
 */
static const cJSON *find_entry(const sl_bench_options *o, const sl_bench_scene *s, const sl_trial *t,
                               int run) {
    char key[KEY];
    key_of(o, s, t, run, key);
    const cJSON *entry = sl_journal_find(o->journal, key);
    if (!entry || end_of(entry) == SL_CHILD_DONE) return entry;
    double limit = sl_bench_number(entry, "limit"), memory = sl_bench_number(entry, "memory");
    bool more_time = limit > 0.0 && (o->limit <= 0.0 || o->limit > limit);
    bool more_memory = memory > 0.0 && (!o->memory_megabytes || memory_bytes(o) > memory);
    return (end_of(entry) == SL_CHILD_STOPPED && more_time) || more_memory ? NULL : entry;
}

static double seconds_of(const cJSON *entry) {
    return sl_bench_number(cJSON_GetObjectItem(entry, "result"), "wall_seconds");
}

/* Returns a cheaper setting of the same curve that the limit stopped, or that left too little of it for this
 * one; NULL: none. */
static const sl_trial *stopped_before(const sl_bench_options *o, const sl_bench_scene *s,
                                      const sl_trial *trial) {
    for (const sl_trial *t = o->trials->trial; trial->ordered && t != trial; t++) {
        bool cheaper = t->ordered && t->table == trial->table && strcmp(t->curve, trial->curve) == 0;
        const cJSON *entry = cheaper ? find_entry(o, s, t, 0) : NULL;
        if (entry && (end_of(entry) == SL_CHILD_STOPPED ||
                      (o->limit > 0.0 && seconds_of(entry) > most_of_limit * o->limit)))
            return t;
    }
    return NULL;
}

/* Tells where the picture of a trial is kept. */
static void picture_path(const sl_bench_options *o, const sl_bench_scene *s, const sl_trial *t,
                         char path[SL_BENCH_PATH]) {
    char name[64];
    /* names are cut off where arguments are long */
    const uint32_t hash = (uint32_t)hash_of(t->arguments, 0);
    snprintf(name, sizeof name, "%.60s", t->arguments);
    for (char *c = name; *c; c++) *c = *c == ' ' || *c == '/' ? '_' : *c;
    snprintf(path, SL_BENCH_PATH, "%s/pictures/%s-%dx%d-%.8s-%s-%08x.exr", o->folder, s->hash, s->width,
             s->height, o->program, name, hash);
}

/* Tells whether a run still makes sense after what the first one, and cheaper settings, were like. */
static bool is_due(const sl_bench_options *o, const sl_bench_scene *s, const sl_trial *t, int run) {
    char picture[SL_BENCH_PATH];
    const cJSON *entry = find_entry(o, s, t, run);
    picture_path(o, s, t, picture);
    if (entry) return run == 0 && end_of(entry) == SL_CHILD_DONE && access(picture, R_OK) != 0;
    if (run == 0) return !stopped_before(o, s, t);
    entry = find_entry(o, s, t, 0);
    if (!entry || end_of(entry) != SL_CHILD_DONE) return false;
    if (run == LOOK && t->table >= 0) return true; /* its table asks for it */
    const double seconds = sl_bench_number(cJSON_GetObjectItem(entry, "result"), "cpu_seconds");
    return seconds < (double)(run == LOOK ? LONG_LOOK_SECONDS : LONG_SECONDS);
}

/* ---- running ---- */

static sl_status measure(const sl_bench_options *o, const sl_bench_scene *s, const sl_trial *t, int run,
                         sl_error *error) {
    char key[KEY], picture[SL_BENCH_PATH];
    const sl_child_limits limits = {o->limit, o->memory_megabytes << 20, sl_interrupted};
    sl_child_end end;
    key_of(o, s, t, run, key);
    picture_path(o, s, t, picture);
    sl_trial_run work = {t->arguments, s->path, s->width, s->height, (unsigned)o->threads, run == LOOK,
                         run == 0 && o->trials->estimates, run == 0 ? picture : NULL, o->load};
    sl_status status = sl_child_run(sl_trial_work, &work, &limits, &end, error);
    if (status == SL_OK && end.outcome != SL_CHILD_LEFT_OUT) {
        cJSON *result = end.outcome == SL_CHILD_DONE ? cJSON_Parse(end.text) : NULL;
        cJSON *entry = make_entry(o, s, key, end.outcome, end.why, result);
        cJSON_AddNumberToObject(entry, "limit", o->limit);
        cJSON_AddNumberToObject(entry, "memory", memory_bytes(o));
        status = sl_journal_add(o->journal, entry, error);
    }
    free(end.text);
    return status;
}
/* Runs every trial of a rank that is wanted; looks come after the first round. */
static sl_status run_rank(const sl_bench_options *o, const sl_bench_scene *s, int round,
                          int rank, double from, sl_error *error) {
    int run = round == 0 ? 0 : round == 1 ? LOOK : round - 1;
    sl_status status = SL_OK;
    for (size_t i = 0; i < o->trials->count && status == SL_OK && !sl_interrupted(); i++) {
        const sl_trial *t = &o->trials->trial[i];
        double spent = sl_seconds_now() - from;
        if (t->rank != rank || (run == LOOK && !t->look) ||
            !is_wanted(o, s, t) || !is_own(s, t) || !is_due(o, s, t, run))
            continue;
        sl_progress_show(o->quiet, (double)round / (double)(o->repeats + 1), "%s, %.0f s: %s, %s", s->name,
                         spent, t->curve, t->name);
        status = measure(o, s, t, run, error);
    }
    return status;
}

sl_status sl_schedule_run(const sl_bench_options *o, const sl_bench_scene *s, sl_error *error) {
    sl_status status = SL_OK;
    double from = sl_seconds_now();
    int ranks = 0;
    for (size_t i = 0; i < o->trials->count && !o->report_only; i++)
        ranks = o->trials->trial[i].rank >= ranks ? o->trials->trial[i].rank + 1 : ranks;
    for (int round = 0; round <= (int)o->repeats && status == SL_OK; round++) {
        for (int rank = 0; rank < ranks && status == SL_OK; rank++)
            status = run_rank(o, s, round, rank, from, error);
    }
    sl_progress_clear(o->quiet);
    return status;
}

/* ---- rows ---- */

static void make_row(const sl_bench_options *o, const sl_bench_scene *s, const sl_trial *t,
                     sl_bench_row *row) {
    enum { MOST = 64 };
    double cpu[MOST], wall[MOST];
    int runs = 0;
    *row = (sl_bench_row){.trial = t, .end = SL_CHILD_LEFT_OUT};
    const sl_trial *cheaper = stopped_before(o, s, t);
    if (cheaper)
        snprintf(row->why, sizeof row->why, "'%s' took most of the limit of seconds, and this takes longer",
                 cheaper->name);
    else snprintf(row->why, sizeof row->why, "it was interrupted");
    picture_path(o, s, t, row->picture);
    row->look = cJSON_GetObjectItem(find_entry(o, s, t, LOOK), "result");
    for (int run = 0; run < (int)o->repeats && run < MOST; run++) {
        const cJSON *entry = find_entry(o, s, t, run),
                    *result = cJSON_GetObjectItem(entry, "result");
        if (entry && run == 0) {
            const char *why = cJSON_GetStringValue(cJSON_GetObjectItem(entry, "why"));
            row->end = end_of(entry);
            snprintf(row->why, sizeof row->why, "%s", why ? why : "");
            row->result = result;
        }
        if (!result) continue;
        cpu[runs] = sl_bench_number(result, "cpu_seconds");
        wall[runs++] = sl_bench_number(result, "wall_seconds");
    }
    row->cpu = sl_bench_spread_of(cpu, runs);
    row->wall = sl_bench_spread_of(wall, runs);
}

sl_status sl_schedule_rows(const sl_bench_options *o, sl_bench_scene *s, sl_error *error) {
    s->rows = calloc(o->trials->count + 1, sizeof *s->rows);
    s->row_count = 0;
    if (!s->rows) return sl_fail_memory(error, "the rows of a report");
    for (size_t i = 0; i < o->trials->count; i++) {
        const sl_trial *t = &o->trials->trial[i];
        sl_bench_row *row = &s->rows[s->row_count];
        if (!is_wanted(o, s, t)) continue;
        make_row(o, s, t, row);
        bool tried = row->end != SL_CHILD_LEFT_OUT || stopped_before(o, s, t);
        if (tried || !o->report_only) s->row_count++;
    }
    return SL_OK;
}
