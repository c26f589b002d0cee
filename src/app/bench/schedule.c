/* Interleaved: first the cheapest trial of every method, then the next ones, and all that as often as asked
 * for. A machine that is slow for a minute is then slow for all methods alike. */
#include "app/bench/schedule.h"

#include "app/bench/calibration.h"
#include "app/clock.h"
#include "base/error.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* settings of a curve are some three times as dear as the one before */
static const double most_of_limit = 0.4;
/* A trial that takes longer is not repeated, since what disturbs it lasts shorter than it does; nor looked
 * at, where it takes yet longer. */
enum { LONG_SECONDS = 1, LONG_LOOK_SECONDS = 3 };

typedef struct job {
    const sl_trial *trial;
    size_t rank; /* in its curve */
    int repeat;  /* -1: a look */
} job;

typedef struct job_list {
    size_t count, room;
    job *jobs;
} job_list;

bool sl_list_names(const char *list, const char *name) {
    size_t length = strlen(name);
    if (!list) return true;
    for (const char *at = list; *at; at += strcspn(at, ","), at += *at == ',') {
        if (strcspn(at, ",") == length && strncmp(at, name, length) == 0) return true;
    }
    return false;
}

/* ---- the jobs ---- */

static bool add_job(job_list *l, const sl_trial *trial, size_t rank, int repeat) {
    if (l->count == l->room) {
        size_t room = 2 * l->room + 128;
        job *more = realloc(l->jobs, room * sizeof *more);
        if (!more) return false;
        l->jobs = more;
        l->room = room;
    }
    l->jobs[l->count++] = (job){trial, rank, repeat};
    return true;
}

static int by_turn(const void *a, const void *b) {
    const job *x = a, *y = b;
    /* looks after the first round */
    int round_x = x->repeat < 0 ? 1 : 2 * x->repeat, round_y = y->repeat < 0 ? 1 : 2 * y->repeat;
    if (round_x != round_y) return round_x < round_y ? -1 : 1;
    if (x->rank != y->rank) return x->rank < y->rank ? -1 : 1;
    return x->trial < y->trial ? -1 : x->trial > y->trial;
}

/* Scenes named on the command line stand for those of the trials' file. */
static bool is_wanted(const sl_bench_options *o, const sl_bench_scene *s, const sl_trial *t) {
    const char *at = t->scenes, *scene;
    size_t length;
    bool here = !at || o->own_scenes;
    while (!here && (scene = sl_trials_next_scene(&at, &length)))
        here = strlen(s->path) == length && strncmp(s->path, scene, length) == 0;
    return here && sl_list_names(o->methods, t->method) &&
           sl_list_names(o->qualities, sl_bench_quality_name(t->quality));
}

static bool list_jobs(const sl_bench_options *o, const sl_bench_scene *s, job_list *l) {
    const sl_trial *before = NULL;
    size_t rank = 0;
    *l = (job_list){0};
    for (size_t i = 0; i < o->trials->count; i++) {
        const sl_trial *t = &o->trials->trial[i];
        rank = before && strcmp(before->curve, t->curve) == 0 ? rank + 1 : 0;
        before = t;
        if (!is_wanted(o, s, t)) continue;
        for (int r = t->look ? -1 : 0; r < o->repeats; r++) {
            if (!add_job(l, t, rank, r)) return false;
        }
    }
    if (l->count) qsort(l->jobs, l->count, sizeof *l->jobs, by_turn);
    return true;
}

/* ---- the journal's entries ---- */

static void key_of(const sl_bench_options *o, const sl_bench_scene *s, const job *j, char *key, size_t size) {
    snprintf(key, size, "%s %dx%d %u threads, %s %s, %s, %s %d", s->hash, s->width, s->height, o->threads,
             SL_VERSION, o->program, j->trial->arguments, j->repeat < 0 ? "look" : "run",
             j->repeat < 0 ? 0 : j->repeat);
}

static double number(const cJSON *object, const char *name) {
    const cJSON *item = cJSON_GetObjectItem(object, name);
    return cJSON_IsNumber(item) ? item->valuedouble : 0.0;
}

static const char *text_of(const cJSON *object, const char *name) {
    const cJSON *item = cJSON_GetObjectItem(object, name);
    return cJSON_IsString(item) ? item->valuestring : "";
}

static sl_bench_end end_of(const cJSON *entry) {
    for (int e = SL_BENCH_RAN; e <= SL_BENCH_STOPPED; e++) {
        if (strcmp(text_of(entry, "end"), sl_bench_end_name((sl_bench_end)e)) == 0) return (sl_bench_end)e;
    }
    return SL_BENCH_CRASHED;
}

/* Finds the entry of a job; what was stopped, or ran out of memory, is no answer where more is allowed now.
 */
static const cJSON *find_entry(const sl_bench_options *o, const sl_bench_scene *s, const sl_journal *journal,
                               const job *j) {
    char key[1024];
    key_of(o, s, j, key, sizeof key);
    const cJSON *entry = sl_journal_find(journal, key);
    if (!entry || end_of(entry) == SL_BENCH_RAN) return entry;
    bool more_time = number(entry, "limit") > 0.0 && (o->limit <= 0.0 || o->limit > number(entry, "limit"));
    bool more_memory = number(entry, "memory") > 0.0 &&
                       (!o->memory_bytes || (double)o->memory_bytes > number(entry, "memory"));
    return (end_of(entry) == SL_BENCH_STOPPED && more_time) || more_memory ? NULL : entry;
}

static double seconds_of(const cJSON *entry) {
    return number(cJSON_GetObjectItem(entry, "result"), "wall_seconds");
}

/* Returns a cheaper setting of the same curve that the limit stopped, or that left too little of it for this
 * one; NULL: none. */
static const sl_trial *stopped_before(const sl_bench_options *o, const sl_bench_scene *s,
                                      const sl_journal *journal, const sl_trial *trial) {
    for (const sl_trial *t = o->trials->trial; trial->ordered && t != trial; t++) {
        const job first = {t, 0, 0};
        bool cheaper = t->ordered && t->table == trial->table && strcmp(t->curve, trial->curve) == 0;
        const cJSON *entry = cheaper ? find_entry(o, s, journal, &first) : NULL;
        if (entry && (end_of(entry) == SL_BENCH_STOPPED ||
                      (o->limit > 0.0 && seconds_of(entry) > most_of_limit * o->limit)))
            return t;
    }
    return NULL;
}

/* Tells whether a job still makes sense after what its first run, and cheaper settings, were like. */
static bool is_due(const sl_bench_options *o, const sl_bench_scene *s, const sl_journal *journal,
                   const job *j) {
    job first = *j;
    char picture[SL_BENCH_PATH];
    first.repeat = 0;
    const cJSON *entry = find_entry(o, s, journal, j);
    sl_trial_picture(o, s, j->trial, picture);
    if (entry) return j->repeat == 0 && end_of(entry) == SL_BENCH_RAN && access(picture, R_OK) != 0;
    if (j->repeat == 0) return !stopped_before(o, s, journal, j->trial);
    entry = find_entry(o, s, journal, &first);
    if (!entry || end_of(entry) != SL_BENCH_RAN) return false;
    if (j->repeat < 0 && j->trial->table >= 0) return true; /* its table asks for it */
    return seconds_of(entry) < (double)(j->repeat < 0 ? LONG_LOOK_SECONDS : LONG_SECONDS);
}

/* ---- running ---- */

void sl_trial_picture(const sl_bench_options *o, const sl_bench_scene *s, const sl_trial *t,
                      char path[SL_BENCH_PATH]) {
    char name[128];
    size_t n = 0;
    uint32_t hash = 2166136261u; /* Fowler, Noll and Vo: names are cut off where arguments are long */
    for (const char *c = t->arguments; *c; c++) hash = (hash ^ (unsigned char)*c) * 16777619u;
    for (const char *c = t->arguments; *c && n < sizeof name - 1; c++) {
        if (*c == ' ' && n && name[n - 1] != '_') name[n++] = '_';
        else if (*c != ' ' && *c != '-') name[n++] = *c;
        else if (*c == '-' && n && name[n - 1] != '_') name[n++] = '-';
    }
    name[n] = '\0';
    snprintf(path, SL_BENCH_PATH, "%s/pictures/%s-%dx%d-%.8s-%s-%08x.exr", o->folder, s->hash, s->width,
             s->height, o->program, name, hash);
}

static cJSON *make_entry(const sl_bench_options *o, const sl_bench_scene *s, const char *key,
                         sl_child_end *end) {
    cJSON *entry = cJSON_CreateObject(),
          *result = end->outcome == SL_CHILD_DONE ? cJSON_Parse(end->text) : NULL;
    cJSON_AddStringToObject(entry, "key", key);
    cJSON_AddStringToObject(entry, "program", o->program);
    cJSON_AddStringToObject(entry, "scene", s->path);
    cJSON_AddStringToObject(entry, "end", sl_bench_end_name((sl_bench_end)end->outcome));
    if (end->why[0]) cJSON_AddStringToObject(entry, "why", end->why);
    if (result) cJSON_AddItemToObject(entry, "result", result);
    free(end->text);
    end->text = NULL;
    return entry;
}

sl_status sl_schedule_child(const sl_bench_options *o, const sl_bench_scene *s, const char *key,
                            double seconds, sl_child_work *work, void *context, sl_journal *journal,
                            sl_error *error) {
    const sl_child_limits limits = {seconds, 0, sl_interrupted};
    sl_child_end end;
    if (sl_journal_find(journal, key)) return SL_OK;
    sl_status status = sl_child_run(work, context, &limits, &end, error);
    if (status == SL_OK && end.outcome != SL_CHILD_INTERRUPTED)
        return sl_journal_add(journal, make_entry(o, s, key, &end), error);
    free(end.text);
    return status;
}

static sl_status run_job(const sl_bench_options *o, const sl_bench_scene *s, sl_journal *journal,
                         const job *j, sl_error *error) {
    char key[1024], picture[SL_BENCH_PATH];
    const sl_child_limits limits = {o->limit, o->memory_bytes, sl_interrupted};
    sl_child_end end;
    key_of(o, s, j, key, sizeof key);
    sl_trial_picture(o, s, j->trial, picture);
    sl_trial_run run = {
        j->trial, s->path, s->width, s->height, o->threads, j->repeat < 0, j->repeat == 0 ? picture : NULL,
        o->load};
    sl_calibration calibration = sl_calibrate();
    sl_status status = sl_child_run(sl_trial_work, &run, &limits, &end, error);
    if (status != SL_OK || end.outcome == SL_CHILD_INTERRUPTED) {
        free(end.text);
        return status;
    }
    cJSON *entry = make_entry(o, s, key, &end);
    cJSON_AddStringToObject(entry, "arguments", j->trial->arguments);
    cJSON_AddNumberToObject(entry, "limit", o->limit);
    cJSON_AddNumberToObject(entry, "memory", (double)o->memory_bytes);
    cJSON_AddNumberToObject(entry, "calibration_wall", calibration.wall);
    cJSON_AddNumberToObject(entry, "calibration_cpu", calibration.cpu);
    return sl_journal_add(journal, entry, error);
}
_Static_assert((int)SL_BENCH_STOPPED == (int)SL_CHILD_STOPPED &&
                   (int)SL_BENCH_CRASHED == (int)SL_CHILD_CRASHED,
               "one order in both");

static void show_progress(const sl_bench_options *o, const sl_bench_scene *s, const job_list *l, size_t at,
                          double seconds) {
    enum { CELLS = 30 };
    char bar[CELLS + 1];
    size_t filled = l->count ? at * CELLS / l->count : CELLS;
    if (o->quiet || !isatty(STDERR_FILENO)) return;
    for (size_t i = 0; i < CELLS; i++) bar[i] = i < filled ? '#' : '.';
    bar[CELLS] = '\0';
    fprintf(stderr, "\r\033[K[%s] %s, trial %zu of %zu, %.0f s", bar, s->name, at, l->count, seconds);
    if (at < l->count) fprintf(stderr, ": %s, %s", l->jobs[at].trial->curve, l->jobs[at].trial->name);
    else fputc('\n', stderr);
    fflush(stderr);
}

sl_status sl_schedule_run(const sl_bench_options *o, const sl_bench_scene *s, sl_journal *journal,
                          sl_error *error) {
    job_list l;
    sl_status status = SL_OK;
    double from = sl_seconds_now();
    if (o->report_only) return SL_OK;
    if (!list_jobs(o, s, &l)) {
        free(l.jobs);
        return sl_fail(error, SL_ERROR_RESOURCES, "not enough memory for a list of trials");
    }
    for (size_t i = 0; i < l.count && status == SL_OK && !sl_interrupted(); i++) {
        double spent = sl_seconds_now() - from;
        if (o->budget > 0.0 && spent > o->budget) break;
        if (!is_due(o, s, journal, &l.jobs[i])) continue;
        show_progress(o, s, &l, i, spent);
        status = run_job(o, s, journal, &l.jobs[i], error);
    }
    if (status == SL_OK && !sl_interrupted()) show_progress(o, s, &l, l.count, sl_seconds_now() - from);
    free(l.jobs);
    return status;
}

/* ---- rows ---- */

static int by_share(const void *a, const void *b) {
    const sl_bench_part *x = a, *y = b;
    if (x->share != y->share) return x->share > y->share ? -1 : 1;
    return strcmp(x->name, y->name);
}

/* Takes the largest parts, and the small ones together. */
static void take_parts(const cJSON *parts, sl_bench_row *row) {
    enum { MOST = 256 };
    sl_bench_part all[MOST];
    size_t count = 0;
    const cJSON *part;
    cJSON_ArrayForEach(part, parts) {
        if (count == MOST || !part->string) break;
        snprintf(all[count].name, sizeof all[count].name, "%.63s", part->string);
        all[count++].share = part->valuedouble;
    }
    qsort(all, count, sizeof *all, by_share);
    row->part_count = count < SL_BENCH_PARTS ? count : SL_BENCH_PARTS;
    memcpy(row->parts, all, row->part_count * sizeof *all);
    if (count <= SL_BENCH_PARTS) return;
    sl_bench_part *last = &row->parts[SL_BENCH_PARTS - 1];
    snprintf(last->name, sizeof last->name, "%zu others", count - SL_BENCH_PARTS + 1);
    for (size_t i = SL_BENCH_PARTS; i < count; i++) last->share += all[i].share;
}

static void take_result(const cJSON *result, sl_bench_row *row) {
    const cJSON *c = cJSON_GetObjectItem(result, "counters");
    row->peak_bytes = (uint64_t)number(result, "peak_bytes");
    row->method_bytes = (uint64_t)number(result, "method_bytes");
    row->rays = (uint64_t)number(c, sl_counter_name(SL_COUNT_RAYS));
    row->shadow_rays = (uint64_t)number(c, sl_counter_name(SL_COUNT_SHADOW_RAYS));
    row->records = (uint64_t)number(c, sl_counter_name(SL_COUNT_RECORDS));
    row->samples = (uint64_t)number(c, sl_counter_name(SL_COUNT_SAMPLES));
    row->fragments = (uint64_t)number(c, sl_counter_name(SL_COUNT_FRAGMENTS_SHADED));
}

static void make_row(const sl_bench_options *o, const sl_bench_scene *s, const sl_journal *journal,
                     const sl_trial *t, sl_bench_row *row) {
    enum { MOST = 64 };
    double cpu[MOST], wall[MOST];
    int runs = 0;
    snprintf(row->method, sizeof row->method, "%s", t->method);
    snprintf(row->curve, sizeof row->curve, "%s", t->curve);
    snprintf(row->name, sizeof row->name, "%s", t->name);
    snprintf(row->arguments, sizeof row->arguments, "%s", t->arguments);
    snprintf(row->transport, sizeof row->transport, "%s", t->transport);
    row->quality = t->quality;
    row->table = t->table;
    row->end = SL_BENCH_LEFT_OUT;
    const sl_trial *cheaper = stopped_before(o, s, journal, t);
    if (cheaper)
        snprintf(row->why, sizeof row->why, "'%s' took most of the limit of seconds, and this takes longer",
                 cheaper->name);
    else snprintf(row->why, sizeof row->why, "there was no time left for it");
    sl_trial_picture(o, s, t, row->picture);
    for (int r = -1; r < o->repeats && runs < MOST; r++) {
        const job j = {t, 0, r};
        const cJSON *entry = find_entry(o, s, journal, &j), *result = cJSON_GetObjectItem(entry, "result");
        if (!entry) continue;
        if (r < 0) {
            row->first_picture = number(result, "first_picture");
            take_parts(cJSON_GetObjectItem(result, "parts"), row);
            continue;
        }
        if (r == 0) {
            row->end = end_of(entry);
            snprintf(row->why, sizeof row->why, "%s", text_of(entry, "why"));
            take_result(result, row);
        }
        if (!result) continue;
        cpu[runs] = number(result, "cpu_seconds");
        wall[runs++] = number(result, "wall_seconds");
    }
    row->cpu = sl_bench_spread_of(cpu, runs);
    row->wall = sl_bench_spread_of(wall, runs);
}

sl_status sl_schedule_rows(const sl_bench_options *o, sl_bench_scene *s, const sl_journal *journal,
                           sl_error *error) {
    size_t count = o->trials->count;
    s->rows = calloc(count + 1, sizeof *s->rows);
    s->row_count = 0;
    if (!s->rows) {
        return sl_fail(error, SL_ERROR_RESOURCES, "not enough memory for the rows of a report");
    }
    for (size_t i = 0; i < count; i++) {
        const sl_trial *t = &o->trials->trial[i];
        if (!is_wanted(o, s, t)) continue;
        make_row(o, s, journal, t, &s->rows[s->row_count]);
        /* nobody tried it */
        bool untold = o->report_only && s->rows[s->row_count].end == SL_BENCH_LEFT_OUT &&
                      !stopped_before(o, s, journal, t);
        if (untold) memset(&s->rows[s->row_count], 0, sizeof *s->rows);
        else s->row_count++;
    }
    return SL_OK;
}
