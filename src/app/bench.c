/* softlux bench: speed against error of every method, on any scenes, as one report. */
#include "app/bench/references.h"
#include "app/bench/report.h"
#include "app/commands.h"
#include "app/options.h"
#include "app/page.h"
#include "app/same_file.h"
#include "base/error.h"
#include "base/ranks.h"
#include "base/values.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_SCENES = 64 };

static const char details[] =
    "Every method runs over its three qualities and over settings between and beyond them, each run in a "
    "process of its own, in turns; a reference for each\n"
    "set of light paths is made by the path tracer, and kept. DIR then holds report.html (one file with "
    "everything in it), report.md,\n"
    "results.csv, plots as SVG, the pictures, and journal.jsonl: what was measured, a line a run. Ctrl-C "
    "keeps it; the same command goes on from there.\n"
    "Times are the processor's, of all threads together; the clock's stand beside them. A trial that crashes "
    "or does not end is a row that says so.\n\n"
    "exit status 0, 2 usage, 3 input (no scene could be read), 4 output, 5 resources, 128 + N cut short by "
    "signal N (Ctrl-C: 130)\n\n"
    "example: softlux bench scenes/cornell.json -o build/report";

typedef struct request {
    const char *scenes[MOST_SCENES], *trials_path;
    char references[SL_BENCH_PATH], of_trials[MOST_SCENES][SL_BENCH_PATH];
    sl_trials trials;
    int scene_count;
    sl_bench_options options;
} request;

/* ---- the command line ---- */

/* Complains of the first name in a list that is none of the choices. */
static bool check_list(const char *option, const char *list, const char *choices, int *status) {
    size_t length;
    for (const char *item; (item = sl_next_item(&list, ",", &length));) {
        char word[64];
        int index;
        sl_error error;
        snprintf(word, sizeof word, "%.*s", (int)length, item);
        if (sl_value_choice(word, choices, &index, &error) == SL_OK) continue;
        fprintf(stderr, "softlux: --%s: %s\n", option, error.message);
        *status = SL_ERROR_USAGE;
        return false;
    }
    return true;
}

static bool check_lists(const sl_bench_options *o, int *status) {
    char methods[256] = "";
    for (size_t m = 0, at = 0; sl_method_name(m) && at < sizeof methods; m++)
        at += (size_t)snprintf(methods + at, sizeof methods - at, "%s%s", m ? "|" : "", sl_method_name(m));
    return check_list("methods", o->methods, methods, status) &&
           check_list("qualities", o->qualities, "draft|normal|high|curve", status);
}

static bool parse(int argc, char **argv, request *q, int *status) {
    sl_bench_options *o = &q->options;
    *q = (request){.options = {.folder = "softlux-report",
                               .repeats = 3,
                               .threads = 1,
                               .limit = 60.0,
                               .reference_budget = 20.0}};
    const sl_option options[] = {
        SL_TEXT("output", 'o', &o->folder, "DIR",
                "folder of the report, made with those above it [softlux-report]"),
        SL_TEXT(
            "trials", 0, &q->trials_path, "FILE",
            "run these, in the file's scenes where none are named, and write the tables that it asks for"),
        SL_TEXT("methods", 'm', &o->methods, "LIST", "which, with commas between [all]"),
        SL_TEXT("qualities", 'q', &o->qualities, "LIST",
                "of draft, normal, high, and curve: what lies between and beyond [all]"),
        SL_PIXELS("size", 's', o->size, "pixels [the scene's film, at most 192 a side]"),
        SL_NUMBER("repeats", 'r', &o->repeats, "R", 1, 50, "runs of what takes less than a second [3]"),
        SL_NUMBER("threads", 't', &o->threads, "N", 1, 256, "workers of each trial [1]"),
        SL_REAL("limit", &o->limit, NULL, "SECONDS", 0.1, 1e9,
                "for one trial, by the clock; then it is stopped [60]"),
        SL_NUMBER("memory", 0, &o->memory_megabytes, "MB", 16, 1e7, "of addresses for one trial [no limit]"),
        SL_TEXT("references", 0, &o->references, "DIR",
                "where reference pictures are kept [$XDG_CACHE_HOME/softlux/references]"),
        SL_REAL("reference-budget", &o->reference_budget, NULL, "SECONDS", 0.1, 1e9,
                "of processor time for each reference; its noise is to be a tenth of the "
                "smallest error told with it [20]"),
        SL_NUMBER("reference-threads", 0, &o->reference_threads, "N", 1, 256,
                  "workers of the references [all processors]"),
        SL_FLAG("report-only", &o->report_only,
                "run no trial: the report anew, of what the last run measured"),
        SL_FLAG("trials-only", &o->trials_only,
                "measure, and write no report: several of these may fill one folder, with a scene each, on a "
                "processor each"),
        SL_FLAG("allow-outside", &o->load.allow_outside,
                "files that scenes name may lie outside of their folders"),
        SL_FLAG("quiet", &o->quiet, "no progress bar, no table"),
        {.name = NULL}};
    const sl_command_line line = {"softlux bench SCENE...|--trials FILE [-o DIR] [options]",
                                  "Speed against error of every method, as tables and plots.",
                                  details, options, 0, MOST_SCENES, NULL, NULL, NULL};
    if (!sl_options_parse(&line, argc, argv, q->scenes, &q->scene_count, status) || !check_lists(o, status))
        return false;
    if (!q->scene_count && !q->trials_path) {
        fprintf(stderr, "softlux: usage: %s\n", line.usage);
        *status = SL_ERROR_USAGE;
        return false;
    }
    o->own_scenes = q->scene_count > 0;
    sl_reference_default_folder(q->references);
    if (!o->references) o->references = q->references;
    return true;
}

static bool has_scene(const request *q, const char *scene, size_t length) {
    for (int i = 0; i < q->scene_count; i++)
        if (strlen(q->scenes[i]) == length && strncmp(q->scenes[i], scene, length) == 0) return true;
    return false;
}

/* Takes, where no scenes are named, those of the trials, in their order. */
static sl_status take_trials(request *q, sl_error *error) {
    sl_bench_options *o = &q->options;
    sl_status status = sl_trials_read(q->trials_path, &q->trials, error);
    o->trials = &q->trials;
    if (o->size[0] == 0) o->size[0] = q->trials.width, o->size[1] = q->trials.height;
    for (size_t i = 0; i < q->trials.count && status == SL_OK && !o->own_scenes; i++) {
        const char *at = q->trials.trial[i].scenes, *scene;
        size_t length;
        while ((scene = sl_next_item(&at, " ", &length)) && q->scene_count < MOST_SCENES) {
            if (has_scene(q, scene, length)) continue;
            char *copy = q->of_trials[q->scene_count];
            snprintf(copy, SL_BENCH_PATH, "%.*s", (int)length, scene);
            q->scenes[q->scene_count++] = copy;
        }
    }
    return status;
}

/* ---- a scene ---- */

/* Names two scenes of one name, in different folders, apart: the plots' files must not be one. */
static void tell_apart(sl_bench_results *r) {
    sl_bench_scene *last = &r->scenes[r->scene_count - 1];
    size_t same = 0, length = strlen(last->name);
    for (size_t i = 0; i + 1 < r->scene_count; i++)
        same += strncmp(r->scenes[i].name, last->name, length) == 0;
    if (same) snprintf(last->name + length, sizeof last->name - length, "-%zu", same + 1);
}

static sl_status measure(const sl_bench_options *o, const char *path, sl_bench_results *r, sl_error *error) {
    sl_bench_scene *s = &r->scenes[r->scene_count++];
    sl_status status = sl_bench_scene_read(o, path, s, error);
    tell_apart(r);
    if (status != SL_OK || s->trouble[0]) return status;
    status = sl_schedule_run(o, s, error);
    if (status == SL_OK) status = sl_schedule_rows(o, s, error);
    if (status == SL_OK && !o->trials_only && sl_evaluate(o, s, error) != SL_OK) {
        fprintf(stderr, "softlux: %s: no errors: %s\n", s->name, error->message);
        if (error->status == SL_ERROR_OUTPUT) status = SL_ERROR_OUTPUT;
    }
    return status;
}

/* ---- the report ---- */

/* Lets what measured last stand in for this program where nothing is to be measured. */
static void take_program(sl_bench_options *o) {
    const cJSON *entry;
    for (size_t i = 0; o->report_only && (entry = sl_journal_at(o->journal, i)); i++) {
        const cJSON *program = cJSON_GetObjectItem(entry, "program");
        if (cJSON_IsString(program)) snprintf(o->program, sizeof o->program, "%s", program->valuestring);
    }
}

static void name_machine(sl_bench_results *r) {
    char line[256];
    FILE *in = fopen("/proc/cpuinfo", "r");
    snprintf(r->machine, sizeof r->machine, "an unknown processor");
    while (in && fgets(line, sizeof line, in)) {
        char *colon = strchr(line, ':');
        if (strncmp(line, "model name", 10) != 0 || !colon) continue;
        snprintf(r->machine, sizeof r->machine, "%.*s", (int)strcspn(colon + 2, "\n"), colon + 2);
        break;
    }
    if (in) fclose(in);
}

/* Makes the folders, and checks that all can be written, before hours are spent. */
static sl_status check_files(const sl_bench_options *o, sl_error *error) {
    static const char *const names[] = {"report.html", "report.md", "results.csv", "tables.md"};
    char pictures[SL_BENCH_PATH];
    snprintf(pictures, sizeof pictures, "%.1000s/pictures", o->folder);
    sl_status status = sl_make_folder(pictures, "picture.exr", error);
    for (size_t i = 0; i < sizeof names / sizeof *names && status == SL_OK; i++)
        status = sl_make_folder(o->folder, names[i], error);
    if (status != SL_OK || o->trials_only || o->report_only) return status;
    return sl_make_folder(o->references, "reference.exr", error);
}

/* Writes the report after every scene, so that the last one that failed takes nothing away. */
static sl_status measure_all(const request *q, sl_bench_results *r, sl_error *error) {
    sl_status status = SL_OK;
    for (int i = 0; i < q->scene_count && status == SL_OK && !sl_interrupted(); i++) {
        status = measure(&q->options, q->scenes[i], r, error);
        r->interrupted = sl_interrupted();
        sl_bench_find_unrest(r);
        if (status == SL_OK && !q->options.trials_only)
            status = sl_report_write(r, q->options.folder, error);
    }
    return status;
}

static int conclude(const sl_bench_options *o, const sl_bench_results *r, sl_status status,
                    const sl_error *error) {
    if (status != SL_OK) return sl_complain(error);
    size_t measured = 0;
    for (size_t i = 0; i < r->scene_count; i++) {
        measured += !r->scenes[i].trouble[0];
        if (r->scenes[i].trouble[0] && o->quiet)
            fprintf(stderr, "softlux: %s\n", r->scenes[i].trouble);
    }
    if (!o->quiet && !o->trials_only) sl_report_terminal(r, stdout);
    if (r->interrupted) return sl_interrupted_status();
    return measured ? 0 : SL_ERROR_INPUT;
}

static sl_status measure_with_journal(request *q, sl_bench_results *r, sl_error *error) {
    char path[SL_BENCH_PATH];
    snprintf(path, sizeof path, "%s/journal.jsonl", q->options.folder);
    r->scenes = calloc((size_t)q->scene_count + 1, sizeof *r->scenes);
    if (!r->scenes) return sl_fail_memory(error, "scenes of a report");
    sl_status status = sl_journal_open(path, &q->options.journal, error);
    if (status == SL_OK) take_program(&q->options);
    return status == SL_OK ? measure_all(q, r, error) : status;
}

/* Has each of several ranks measure its trials. Then the first one finds them all in the journal. */
static sl_status measure_by_ranks(request *q, sl_error *error) {
    const bool trials_only = q->options.trials_only;
    sl_bench_results own = {0};
    sl_counters none = {{0}};
    q->options.trials_only = true;
    sl_status status = measure_with_journal(q, &own, error);
    sl_bench_results_free(&own);
    sl_journal_close(q->options.journal);
    q->options.journal = NULL;
    if (status == SL_OK) sl_ranks_exchange(NULL, 0, 0, &none); /* all have come here */
    q->options.trials_only = trials_only || sl_ranks_here().rank > 0;
    return status;
}

int sl_command_bench(int argc, char **argv) {
    static request q;
    sl_bench_results results = {0};
    sl_error error;
    int exit_status;
    if (!parse(argc, argv, &q, &exit_status)) return exit_status;
    sl_program_fingerprint(q.options.program);
    sl_watch_for_interrupt();
    snprintf(results.version, sizeof results.version, "%s", SL_VERSION);
    results.threads = (int)q.options.threads;
    results.repeats = (int)q.options.repeats;
    name_machine(&results);
    sl_status status = take_trials(&q, &error);
    results.trials = &q.trials;
    if (status == SL_OK) status = check_files(&q.options, &error);
    if (status == SL_OK && sl_ranks_here().count > 1) status = measure_by_ranks(&q, &error);
    if (status == SL_OK) status = measure_with_journal(&q, &results, &error);
    exit_status = conclude(&q.options, &results, status, &error);
    sl_journal_close(q.options.journal);
    sl_bench_results_free(&results);
    sl_trials_free(&q.trials);
    return exit_status;
}
