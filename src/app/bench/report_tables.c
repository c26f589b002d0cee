/* Tables in Markdown: of trials; and over all scenes together, for the report's beginning and for the page
 * that says it in words (docs/speed-against-error.md), each between two marks, which bench/fill_tables.sh
 * puts into the page. */
#include "app/bench/report.h"

#include <stdlib.h>
#include <string.h>

/* ---- rows of trials ---- */

void sl_report_head(FILE *out, const char *columns) {
    for (int line = 0; line < 2; line++) {
        for (const char *at = columns; at; at = strchr(at, '|') ? strchr(at, '|') + 1 : NULL) {
            bool right = *at == '>';
            if (line) fputs(right ? "| ---: " : "| --- ", out);
            else fprintf(out, "| %.*s ", (int)strcspn(at + right, "|"), at + right);
        }
        fputs("|\n", out);
    }
}

void sl_report_columns(FILE *out, const char *columns) {
    char column[SL_CELL], head[2 * SL_CELL] = "";
    for (size_t used; sl_next_column(&columns, column);) {
        used = strlen(head);
        snprintf(head + used, sizeof head - used, "%s%s%s", used ? "|" : "",
                 sl_cell_is_text(column) ? "" : ">", column);
    }
    sl_report_head(out, head);
}

static void put_row(FILE *out, const sl_bench_scene *s, const sl_bench_row *r, const char *columns) {
    char column[SL_CELL], cell[SL_CELL];
    fputc('|', out);
    while (sl_next_column(&columns, column)) {
        bool code = strcmp(column, "arguments") == 0;
        if (r->end != SL_CHILD_DONE && !sl_cell_is_text(column)) {
            fprintf(out, " %s: %s |", sl_bench_end_name(r->end), r->why);
            break;
        }
        sl_cell(s, r, column, false, cell);
        fprintf(out, code ? " `%s` |" : " %s |", cell);
    }
    fputc('\n', out);
}

void sl_report_rows(FILE *out, const sl_bench_scene *s, int table, const char *columns) {
    for (size_t i = 0; i < s->row_count; i++)
        if (table < 0 || s->rows[i].trial->table == table) put_row(out, s, &s->rows[i], columns);
}

/* Puts a table that a file of trials asks for. */
static void put_trials(FILE *out, const sl_bench_results *r, int index) {
    char columns[SL_CELL];
    snprintf(columns, sizeof columns, "scene, trial, %s", r->trials->table[index].columns);
    sl_report_columns(out, columns);
    for (size_t s = 0; s < r->scene_count; s++) sl_report_rows(out, &r->scenes[s], index, columns);
}

/* ---- how it was measured ---- */

static bool is_measured(const sl_bench_scene *s) { return !s->trouble[0] && s->row_count > 0; }

/* Tells how many errors told without a reference could be checked: what is lost in the reference's noise can
 * check none. */
static void put_promises(FILE *out, const sl_bench_results *r) {
    size_t made = 0, kept = 0;
    for (size_t i = 0; i < r->scene_count; i++) {
        for (size_t k = 0; k < r->scenes[i].row_count; k++) {
            const sl_bench_row *row = &r->scenes[i].rows[k];
            const sl_bench_error *e = &row->error[SL_BENCH_MATCHED];
            if (!sl_bench_promises(row) || !e->known || e->lost) continue;
            made++;
            kept += sl_bench_number(row->result, "bound") >= e->rel_rmse;
        }
    }
    if (made)
        fprintf(out,
                " Of %zu errors told without a reference (`softlux render --error`) %.0f %% are within their "
                "bound, which is to hold in 95 %%.",
                made, 100.0 * (double)kept / (double)made);
}

static void put_machine(FILE *out, const sl_bench_results *r) {
    fprintf(out,
            "softlux %s on %s, %d thread%s, medians of up to %d runs. Runs of the same trial were within "
            "%.1f %% of their middle.",
            r->version, r->machine, r->threads, r->threads == 1 ? "" : "s", r->repeats, 100.0 * r->unrest);
    put_promises(out, r);
    fputs(r->interrupted ? " **Interrupted: what was measured until then.**\n" : "\n", out);
}

/* ---- which method for which scene ---- */

static const double errors[] = {0.2, 0.1, 0.05, 0.02, 0.01};
enum { ERRORS = sizeof errors / sizeof *errors };

/* "splatting, 0.054 s (29.3 x)" */
static void put_lead(FILE *out, const sl_lead *lead) {
    char seconds[32];
    sl_seconds_text(lead->seconds, seconds);
    if (!lead->method) fputs(" none", out);
    else fprintf(out, " %s, %s s", lead->method, seconds);
    if (lead->method && lead->path_seconds > 0.0)
        fprintf(out, " (%s%.1f x)", lead->path_later ? "> " : "", lead->path_seconds / lead->seconds);
    fputs(" |", out);
}

static void put_best(FILE *out, const sl_bench_results *r) {
    fputs("Processor seconds until an error against all light, of the best method beside the path tracer, "
          "and how many times as long that takes; `>`: it was not there after its longest run.\n\n",
          out);
    sl_report_head(out, "scene|surfaces|best at 20 %|at 10 %|at 5 %|at 2 %|at 1 %");
    for (size_t i = 0; i < r->scene_count; i++) {
        const sl_bench_scene *s = &r->scenes[i];
        if (!is_measured(s)) continue;
        fprintf(out, "| %s | %s |", s->name, s->mirrors ? "mirrors" : s->glossy ? "glossy" : "diffuse");
        for (int k = 0; k < ERRORS; k++) {
            const sl_lead lead = sl_lead_at(s, SL_BENCH_FULL, errors[k]);
            put_lead(out, &lead);
        }
        fputc('\n', out);
    }
}

/* ---- what each setting is good for ---- */

static double median_of(double *values, size_t count) {
    return sl_bench_spread_of(values, (int)count).median;
}

static void put_share(FILE *out, double share) {
    fprintf(out, " %.*f %% |", share < 0.0995, 100.0 * share);
}

/* Puts medians over the scenes, and the scene with the largest error. work: room for three numbers a scene.
 */
static void put_method(FILE *out, const sl_bench_results *r, const sl_trial *trial, double *work) {
    double *seconds = work, *own = work + r->scene_count, *all = own + r->scene_count, largest = 0.0;
    size_t count = 0, all_count = 0;
    const char *where = "";
    char text[32];
    for (size_t i = 0; i < r->scene_count; i++) {
        for (size_t k = 0; k < r->scenes[i].row_count; k++) {
            const sl_bench_row *row = &r->scenes[i].rows[k];
            const sl_bench_error *e = row->error;
            if (row->trial != trial || row->end != SL_CHILD_DONE || !e[SL_BENCH_MATCHED].known) continue;
            seconds[count] = row->cpu.median;
            own[count++] = e[SL_BENCH_MATCHED].rel_rmse;
            if (e[SL_BENCH_FULL].known) all[all_count++] = e[SL_BENCH_FULL].rel_rmse;
            if (e[SL_BENCH_MATCHED].rel_rmse < largest) continue;
            largest = e[SL_BENCH_MATCHED].rel_rmse;
            where = r->scenes[i].name;
        }
    }
    if (!count) return;
    sl_seconds_text(median_of(seconds, count), text);
    fprintf(out, "| %s | %s | %zu | %s |", trial->curve, trial->name, count, text);
    put_share(out, median_of(own, count));
    put_share(out, median_of(all, all_count));
    fprintf(out, " %s %.0f %% |\n", where, 100.0 * largest);
}

static void put_methods(FILE *out, const sl_bench_results *r) {
    double *work = calloc(3 * r->scene_count + 1, sizeof *work);
    sl_report_head(out, "method|setting|>scenes|>cpu s|>error of its own paths|>against all light|largest, "
                        "own paths");
    for (size_t i = 0; work && i < r->trials->count; i++) put_method(out, r, &r->trials->trial[i], work);
    free(work);
}

/* ---- all together ---- */

void sl_report_tables(FILE *out, const void *what) {
    const sl_bench_results *r = what;
    static const struct {
        const char *name;
        void (*put)(FILE *out, const sl_bench_results *results);
    } tables[] = {{"machine", put_machine}, {"best", put_best}, {"methods", put_methods}};
    const size_t count = r->trials->table_count ? 1 : sizeof tables / sizeof *tables;
    for (size_t i = 0; i < count; i++) {
        fprintf(out, "<!-- table %s -->\n", tables[i].name);
        tables[i].put(out, r);
        fputs("<!-- end -->\n", out);
    }
    for (size_t i = 0; i < r->trials->table_count; i++) {
        fprintf(out, "<!-- table %s -->\n", r->trials->table[i].name);
        put_trials(out, r, (int)i);
        fputs("<!-- end -->\n", out);
    }
}

void sl_report_overview(FILE *out, const void *results) {
    const sl_bench_results *r = results;
    fputs("# Speed against error\n\n", out);
    put_machine(out, r);
    fputs(
        "\nErrors are relative RMSE: the root of the mean squared difference over the reference's mean, of "
        "all pixels, each the mean over its square, lamps that are seen included; the reference's own noise "
        "is subtracted. What that noise leaves in doubt is below a tenth of the error (95 % confidence), or "
        "stands behind it as ±; `<`: at most, and perhaps nothing; `≥`: lost in the noise, and no less "
        "than the energy that is missing. *matched*: against the light paths that the method itself declares"
        "; *full*: against all light; *estimate*, *bound*: told without a reference. Times are in seconds, "
        "the processor's of all threads together but for *wall*; *peak* is in MB.\n\nScenes:",
        out);
    for (size_t i = 0; i < r->scene_count; i++)
        fprintf(out, "%s [%s](#%s)", i ? "," : "", r->scenes[i].name, r->scenes[i].name);
    fputs("\n\n", out);
    put_best(out, r);
    fputs("\nMedians over the scenes:\n\n", out);
    put_methods(out, r);
}

void sl_report_terminal(const sl_bench_results *r, FILE *out) {
    static const char columns[] = "scene, curve, trial, cpu, matched, full";
    sl_report_columns(out, columns);
    for (size_t i = 0; i < r->scene_count; i++) {
        if (r->scenes[i].trouble[0]) fprintf(out, "| %s | %s |\n", r->scenes[i].name, r->scenes[i].trouble);
        sl_report_rows(out, &r->scenes[i], -1, columns);
    }
    fputc('\n', out);
    put_best(out, r);
    fputc('\n', out);
    put_machine(out, r);
}
